"""A short run of the mutants of USD scenes."""

from __future__ import annotations

import pytest

pytest.importorskip("pxr", reason="usd-core is not installed (make extras)")

from tests.fuzz.usd_scenes import run


@pytest.mark.extras
def test_mutants_are_read_or_refused() -> None:
    tally = run(250, seed=1)
    assert tally.faults == {}
    assert tally.ends["refused"] > 50
    assert tally.ends["retimed"] > 50
