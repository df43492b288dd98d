"""A short run of the mutants of scenes."""

from __future__ import annotations

from tests.fuzz.scenes import run


def test_mutants_are_read_or_refused() -> None:
    outcomes = run(600, seed=1)
    assert outcomes["refused"] > 100
    assert outcomes["retimed"] > 50
