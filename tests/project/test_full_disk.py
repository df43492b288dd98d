"""A full disk leaves what was there before, and the next edit makes it good."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys

import pytest

from retime.project.journal import read_journal
from retime.project.work import open_project
from tests.project.documents import dead, edited, numbered

FULL_DISK = """\
import resource, signal, sys
from pathlib import Path
from dataclasses import replace
from retime.project.document import ClipFile, Key
from retime.project.journal import Edit
from retime.project.work import open_project

place = Path(sys.argv[1])
work = open_project(place)
# From here on no file can grow beyond this: writing fails in the middle, as on a full disk.
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), int(sys.argv[2])))
document = replace(work.history.present, keys=tuple(Key(f"k{i}", i / 100, i / 50) for i in range(200)))
history = work.history.edit(document, label="many keys")
for act in (
    lambda: work.journal.edit(Edit(document, "many keys", "", True), history, {}),
    lambda: work.save(place, history, {}, overwrite=False),
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
    work = open_project(place, numbered(0))
    work.save(place, work.history, work.warps, overwrite=False)
    edited(work, 1)
    dead(work)
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
    work = open_project(tmp_path / "p.retime", numbered(0))
    edited(work, 1)
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (work.journal.path.stat().st_size + 20, limits[1]))
    try:
        with pytest.raises(OSError, match="File too large"):
            edited(work, 2)
        with pytest.raises(OSError, match="File too large"):
            edited(work, 3)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, before)
    assert read_journal(work.journal.path).history.present.keys[0].input_time == 0.01
    work.history = work.history.undo()
    work.journal.undo(work.history, {})
    assert read_journal(work.journal.path).history == work.history
    assert work.history.present.keys[0].input_time == 0.02
    work.close()
