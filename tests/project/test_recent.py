"""What was opened last: noted, bounded, and never in the way."""

from __future__ import annotations

import json
import os
import sys

import pytest

from retime.project.recent import MOST, note_recent, recent


def test_the_last_is_first_once_and_only_what_is_there(tmp_path) -> None:
    state = tmp_path / "state"
    assert recent(state) == []
    files = [tmp_path / f"été {i}.bvh" for i in range(MOST + 3)]
    for file in files:
        file.touch()
        note_recent(file, state)
    assert recent(state) == files[: -MOST - 1 : -1]
    note_recent(files[-4], state)
    assert recent(state)[:3] == [files[-4], files[-1], files[-2]]
    assert len(recent(state)) == MOST
    files[-1].unlink()
    assert files[-1] not in recent(state)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"[]",
        b'{"paths": 3}',
        b'{"paths": [3, "not absolute", "/a\\u0000b", null]}',
        b"\xff\xfe",
        b"[" * 9000,
    ],
)
def test_what_another_program_wrote_there_counts_for_nothing(tmp_path, content) -> None:
    (tmp_path / "recent.json").write_bytes(content)
    assert recent(tmp_path) == []
    file = tmp_path / "a.bvh"
    file.touch()
    note_recent(file, tmp_path)
    assert recent(tmp_path) == [file]
    assert json.loads((tmp_path / "recent.json").read_text()) == {"paths": [str(file)]}


@pytest.mark.skipif(sys.platform == "win32" or os.geteuid() == 0, reason="needs a folder that can't be written")
def test_a_list_that_can_not_be_written_stops_nothing(tmp_path) -> None:
    file = tmp_path / "a.bvh"
    file.touch()
    state = tmp_path / "state"
    state.mkdir(mode=0o500)
    note_recent(file, state)
    assert recent(state) == []


def test_a_state_folder_that_is_a_file_stops_nothing(tmp_path) -> None:
    file = tmp_path / "a.bvh"
    file.touch()
    note_recent(file, file)
    assert recent(file) == []
