"""What is open: recovered after the program died, saved, and never mixed with another's work."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from retime.errors import OptionError, OutputExistsError
from retime.project.document import (
    KeptWarp,
)
from retime.project.file import project_bytes, warp_id
from retime.project.journal import Edit, read_journal
from retime.project.work import new_document, open_document, open_project
from tests.project.documents import WARP, dead, edited, numbered

EDITOR = """\
import sys
from pathlib import Path
from retime.project.document import Key
from retime.project.journal import Edit
from retime.project.work import new_document, open_document
from dataclasses import replace

work = open_document(new_document(["/clips/a.bvh"]), folder=Path(sys.argv[1]))
for number in range(1000):
    document = replace(work.history.present, keys=(Key("k", 0.001 * number, 1.0),))
    edit = Edit(document, f"move to {number}", "", True)
    work.history = work.history.edit(document, label=edit.label)
    work.journal.edit(edit, work.history, {})
    # Acknowledged, from here on.
    print(number, flush=True)
"""


@pytest.mark.parametrize("after", [0, 3, 17])
def test_kill_9_leaves_the_last_acknowledged_edit(tmp_path, after) -> None:
    child = subprocess.Popen([sys.executable, "-c", EDITOR, tmp_path], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    acknowledged = -1
    for line in child.stdout:
        acknowledged = int(line)
        if acknowledged == after:
            child.send_signal(signal.SIGKILL)
            break
    # It may have got further before it died.
    acknowledged = max([acknowledged, *map(int, child.stdout.read().split())])
    child.stdout.close()
    assert child.wait() == -signal.SIGKILL

    work = open_document(new_document(["/clips/a.bvh"]), folder=tmp_path)
    number = round(1000 * work.history.present.keys[0].input_time)
    # One more may have been written, and not yet told.
    assert number in (acknowledged, acknowledged + 1)
    assert work.recovered
    assert work.history.undo_label == f"move to {number}"
    assert len(work.history.done) >= acknowledged
    work.close()


def test_two_editors_never_write_one_journal(tmp_path) -> None:
    work = open_document(numbered(0), folder=tmp_path)
    with pytest.raises(OptionError, match="another editor has this open"):
        open_document(numbered(0), folder=tmp_path)
    work.close()
    open_document(numbered(0), folder=tmp_path).close()
    # Nothing was done, and nothing is left behind.
    assert [path.name for path in tmp_path.rglob("*")] == ["journals"]


def test_a_project_that_was_saved_has_nothing_to_recover(tmp_path) -> None:
    place = tmp_path / "p.retime"
    work = open_project(place, numbered(0))
    edited(work, 5)
    assert not work.is_saved
    work.save(place, work.history, work.warps, overwrite=False)
    assert work.is_saved
    dead(work)
    again = open_project(place)
    assert not again.recovered
    assert again.history.present == work.history.present
    # Undo goes back to before the save, even so.
    assert again.history.undo_label == "to 5"
    again.close()
    assert [path.name for path in tmp_path.iterdir()] == ["p.retime"]


def test_what_came_after_a_save_is_recovered(tmp_path) -> None:
    place = tmp_path / "p.retime"
    work = open_project(place, numbered(0))
    work.save(place, work.history, work.warps, overwrite=False)
    edited(work, 7)
    dead(work)
    again = open_project(place)
    assert again.recovered
    assert again.history.present.keys[0].input_time == 0.07
    again.save(place, again.history, again.warps, overwrite=False)
    assert not again.recovered
    again.close()


@pytest.mark.parametrize("moment", ["before the file", "after the file"])
def test_death_while_saving_loses_nothing(tmp_path, monkeypatch, moment) -> None:
    place = tmp_path / "p.retime"
    work = open_project(place, numbered(0))
    work.save(place, work.history, work.warps, overwrite=False)
    edited(work, 3)

    class Death(BaseException):
        pass

    def die(*args: object, **options: object) -> None:
        raise Death

    if moment == "before the file":
        monkeypatch.setattr("retime.project.work.save_project", die)
    else:
        monkeypatch.setattr(work.journal, "begin", die)
    with pytest.raises(Death):
        work.save(place, work.history, work.warps, overwrite=False)
    dead(work)
    again = open_project(place)
    assert again.history.present.keys[0].input_time == 0.03
    assert again.recovered == (moment == "before the file")
    assert again.notes == []
    again.close()


def test_a_project_that_another_program_changed_is_not_mixed_with_the_journal(tmp_path) -> None:
    place = tmp_path / "p.retime"
    work = open_project(place, numbered(0))
    work.save(place, work.history, work.warps, overwrite=False)
    edited(work, 3)
    theirs = project_bytes(numbered(9), {}, tmp_path)
    place.write_bytes(theirs)
    with pytest.raises(OptionError, match="another program changed this project"):
        work.save(place, work.history, work.warps, overwrite=False)
    assert place.read_bytes() == theirs
    dead(work)
    again = open_project(place)
    assert again.history.present == numbered(9)
    assert not again.recovered
    (note,) = again.notes
    assert "changed since" in note
    (kept,) = tmp_path.glob("*.old-1")
    assert read_journal(kept).history.present.keys[0].input_time == 0.03
    again.close()


def test_saving_under_another_name_goes_on_there(tmp_path) -> None:
    work = open_document(numbered(0), folder=tmp_path / "state")
    edited(work, 3)
    place = tmp_path / "p.retime"
    place.write_text("something else")
    with pytest.raises(OutputExistsError):
        work.save(place, work.history, work.warps, overwrite=False)
    assert place.read_text() == "something else"
    assert work.path is None
    work.save(place, work.history, work.warps, overwrite=True)
    edited(work, 4)
    dead(work)
    again = open_project(place)
    assert again.recovered
    assert again.history.present.keys[0].input_time == 0.04
    again.close()
    assert list((tmp_path / "state" / "journals").iterdir()) == []


def test_kept_warps_are_recovered(tmp_path) -> None:
    work = open_document(numbered(0), folder=tmp_path)
    document = replace(work.history.present, kept=(KeptWarp(warp_id(WARP), "first"),))
    history = work.history.edit(document, label="keep")
    work.journal.keep(warp_id(WARP), WARP, history, {})
    work.journal.edit(Edit(document, "keep", "", True), history, {warp_id(WARP): WARP})
    dead(work)
    again = open_document(numbered(0), folder=tmp_path)
    np.testing.assert_array_equal(again.warps[warp_id(WARP)].output_times, WARP.output_times)
    assert again.history.present == document
    again.close()


@pytest.mark.parametrize("damage", [b"", b"\x00" * 100, b"00000000 {}\n"])
def test_a_journal_that_can_not_be_read_is_kept_and_told(tmp_path, damage) -> None:
    work = open_document(numbered(0), folder=tmp_path)
    place = work.journal.path
    dead(work)
    place.write_bytes(damage)
    again = open_document(numbered(0), folder=tmp_path)
    (note,) = again.notes
    assert "could not be read" in note
    assert place.with_name(place.name + ".old-1").read_bytes() == damage
    again.close()


def test_a_name_that_is_no_text_is_refused() -> None:
    with pytest.raises(OptionError, match="name that is text"):
        new_document([os.fsdecode(b"/clips/\xff.bvh")])
