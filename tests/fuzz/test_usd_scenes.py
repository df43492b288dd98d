"""A short run of the mutants of USD scenes."""

from __future__ import annotations

import pytest

pytest.importorskip("pxr", reason="usd-core is not installed (make extras)")

from tests.fuzz import trials
from tests.fuzz.usd_scenes import Mutants


@pytest.mark.extras
def test_mutants_are_read_or_refused() -> None:
    mutants = Mutants()
    try:
        tally = trials.run(mutants, range(1, 501), most_seconds=90)
    finally:
        mutants.close()
    assert tally.faults == {}
    assert tally.ends["refused"] > 100
    assert tally.ends["read"] > 100
    assert tally.ends["retimed"] > 5
