"""Workers, scheduler and clips that die: what is left is what a single process makes."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.batch.storm import storm

pytest.importorskip("distributed", reason="distributed (the extra retime[batch]) is not installed")


@pytest.mark.extras
def test_a_library_survives_a_storm(tmp_path: Path) -> None:
    outcome = storm(tmp_path, clips=160, kills=3, seed=4)
    assert outcome.faults == []
    assert outcome.killed == 3
    assert outcome.kept > 0
