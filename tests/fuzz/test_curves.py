"""A short run of the mutants of retime curves."""

from __future__ import annotations

from tests.fuzz.curves import run


def test_mutants_are_read_or_refused() -> None:
    outcomes = run(1500, seed=1)
    assert outcomes["refused"] > 400
    assert outcomes["read"] > 200
