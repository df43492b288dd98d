"""What a run of the editor leaves to the next: its port, and the key that its pages hold."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import pytest

from retime.project.runs import Run, leave_to_next, run_before

KEY = "k" * 43


def test_the_next_run_knows_port_and_key(tmp_path: Path) -> None:
    place = tmp_path / "runs" / "a.json"
    first = run_before(place)
    assert first.port == 0
    leave_to_next(place, Run(4711, first.key))
    assert run_before(place) == Run(4711, first.key)
    if sys.platform != "win32":
        assert place.stat().st_mode & 0o777 == 0o600
    # After a week nobody comes back.
    long_ago = time.time() - 8 * 86400
    os.utime(place, (long_ago, long_ago))
    assert run_before(place).port == 0
    assert run_before(place).key != first.key


@pytest.mark.parametrize(
    "text", ["", "[]", "{", '{"port": 0}', '{"port": 80, "key": "short"}', '{"port": "a", "key": 1}']
)
def test_what_is_no_file_of_ours_is_left_alone(tmp_path: Path, text: str) -> None:
    place = tmp_path / "a.json"
    place.write_text(text)
    place.chmod(0o600)
    found = run_before(place)
    assert (found.port, len(found.key) >= 32) == (0, True)


@pytest.mark.skipif(sys.platform == "win32", reason="files there have no mode")
def test_a_key_that_others_could_read_is_none(tmp_path: Path) -> None:
    place = tmp_path / "a.json"
    leave_to_next(place, Run(4711, KEY))
    place.chmod(0o644)
    assert run_before(place).key != KEY
