"""A full disk leaves what was there before, and the next edit makes it good."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys

import pytest

from retime.project.journal import read_journal
from retime.project.workspace import open_project
from tests.project.documents import dead, edited, numbered

FULL_DISK = """\
import resource, signal, sys
from pathlib import Path
from dataclasses import replace
from retime.project.document import ClipFile, Key
from retime.project.journal import Edit
from retime.project.workspace import open_project

place = Path(sys.argv[1])
workspace = open_project(place)
# From here on no file can grow beyond this: writing fails in the middle, as on a full disk.
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), int(sys.argv[2])))
document = replace(workspace.history.present, keys=tuple(Key(f"k{i}", i / 100, i / 50) for i in range(200)))
history = workspace.history.edit(document, label="many keys")
for act in (
    lambda: workspace.journal.edit(Edit(document, "many keys", "", True), history, {}),
    lambda: workspace.save(place, history, {}, overwrite=False),
):
    try:
        act()
    except OSError as error:
        print(error.errno)
    else:
        print("written")
"""


def test_a_full_disk_leaves_the_old_file_and_the_old_journal(tmp_path) -> None:
    place = tmp_path / "p.retime"
    workspace = open_project(place, numbered(0))
    workspace.save(place, workspace.history, workspace.warps, overwrite=False)
    edited(workspace, 1)
    dead(workspace)
    before = place.read_bytes()
    room = max(path.stat().st_size for path in tmp_path.iterdir()) + 500
    done = subprocess.run(
        [sys.executable, "-c", FULL_DISK, place, str(room)], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["27", "27"], "expected EFBIG twice"
    assert place.read_bytes() == before
    again = open_project(place)
    assert again.history.present.keys[0].input_time == 0.01
    again.close()
    assert {path.name for path in tmp_path.iterdir()} == {"p.retime", ".p.retime-journal"}


def test_an_autosave_that_failed_is_made_good_by_the_next(tmp_path) -> None:
    workspace = open_project(tmp_path / "p.retime", numbered(0))
    edited(workspace, 1)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (workspace.journal.path.stat().st_size + 20, limits[1]))
    try:
        with pytest.raises(OSError, match="File too large"):
            edited(workspace, 2)
        with pytest.raises(OSError, match="File too large"):
            edited(workspace, 3)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, before)
    assert read_journal(workspace.journal.path).history.present.keys[0].input_time == 0.01
    workspace.history = workspace.history.undo()
    workspace.journal.undo(workspace.history, {})
    assert read_journal(workspace.journal.path).history == workspace.history
    assert workspace.history.present.keys[0].input_time == 0.02
    workspace.close()
