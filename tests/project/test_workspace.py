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
    ClipFile,
    Document,
    KeptWarp,
)
from retime.project.file import project_bytes, warp_id
from retime.project.journal import Edit, read_journal
from retime.project.workspace import new_document, open_document, open_project
from tests.project.documents import WARP, dead, edited, numbered

EDITOR = """\
import sys
from pathlib import Path
from retime.project.document import Key
from retime.project.journal import Edit
from retime.project.workspace import new_document, open_document
from dataclasses import replace

workspace = open_document(new_document(["/clips/a.bvh"]), folder=Path(sys.argv[1]))
for number in range(1000):
    document = replace(workspace.history.present, keys=(Key("k", 0.001 * number, 1.0),))
    edit = Edit(document, f"move to {number}", "", True)
    workspace.history = workspace.history.edit(document, label=edit.label)
    workspace.journal.edit(edit, workspace.history, {})
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

    workspace = open_document(new_document(["/clips/a.bvh"]), folder=tmp_path)
    number = round(1000 * workspace.history.present.keys[0].input_time)
    # One more may have been written, and not yet told.
    assert number in (acknowledged, acknowledged + 1)
    assert workspace.recovered
    assert workspace.history.undo_label == f"move to {number}"
    assert len(workspace.history.done) >= acknowledged
    workspace.close()


def test_two_editors_never_write_one_journal(tmp_path) -> None:
    workspace = open_document(numbered(0), folder=tmp_path)
    with pytest.raises(OptionError, match="another editor has this open"):
        open_document(numbered(0), folder=tmp_path)
    workspace.close()
    open_document(numbered(0), folder=tmp_path).close()
    # Nothing was done, and nothing is left behind.
    assert [path.name for path in tmp_path.rglob("*")] == ["journals"]


def test_a_project_that_was_saved_has_nothing_to_recover(tmp_path) -> None:
    place = tmp_path / "p.retime"
    workspace = open_project(place, numbered(0))
    edited(workspace, 5)
    assert not workspace.is_saved
    workspace.save(place, workspace.history, workspace.warps, overwrite=False)
    assert workspace.is_saved
    dead(workspace)
    again = open_project(place)
    assert not again.recovered
    assert again.history.present == workspace.history.present
    # Undo goes back to before the save, even so.
    assert again.history.undo_label == "to 5"
    again.close()
    assert [path.name for path in tmp_path.iterdir()] == ["p.retime"]


def test_what_came_after_a_save_is_recovered(tmp_path) -> None:
    place = tmp_path / "p.retime"
    workspace = open_project(place, numbered(0))
    workspace.save(place, workspace.history, workspace.warps, overwrite=False)
    edited(workspace, 7)
    dead(workspace)
    again = open_project(place)
    assert again.recovered
    assert again.history.present.keys[0].input_time == 0.07
    again.save(place, again.history, again.warps, overwrite=False)
    assert not again.recovered
    again.close()


@pytest.mark.parametrize("moment", ["before the file", "after the file"])
def test_death_while_saving_loses_nothing(tmp_path, monkeypatch, moment) -> None:
    place = tmp_path / "p.retime"
    workspace = open_project(place, numbered(0))
    workspace.save(place, workspace.history, workspace.warps, overwrite=False)
    edited(workspace, 3)

    class Death(BaseException):
        pass

    def die(*args: object, **options: object) -> None:
        raise Death

    if moment == "before the file":
        monkeypatch.setattr("retime.project.workspace.save_project", die)
    else:
        monkeypatch.setattr(workspace.journal, "begin", die)
    with pytest.raises(Death):
        workspace.save(place, workspace.history, workspace.warps, overwrite=False)
    dead(workspace)
    again = open_project(place)
    assert again.history.present.keys[0].input_time == 0.03
    assert again.recovered == (moment == "before the file")
    assert again.notes == []
    again.close()


def test_a_project_that_another_program_changed_is_not_mixed_with_the_journal(tmp_path) -> None:
    place = tmp_path / "p.retime"
    workspace = open_project(place, numbered(0))
    workspace.save(place, workspace.history, workspace.warps, overwrite=False)
    edited(workspace, 3)
    theirs = project_bytes(numbered(9), {}, tmp_path)
    place.write_bytes(theirs)
    with pytest.raises(OptionError, match="another program changed this project"):
        workspace.save(place, workspace.history, workspace.warps, overwrite=False)
    assert place.read_bytes() == theirs
    dead(workspace)
    again = open_project(place)
    assert again.history.present == numbered(9)
    assert not again.recovered
    (note,) = again.notes
    assert "changed since" in note
    (kept,) = tmp_path.glob("*.old-1")
    assert read_journal(kept).history.present.keys[0].input_time == 0.03
    again.close()


def test_saving_under_another_name_goes_on_there(tmp_path) -> None:
    workspace = open_document(numbered(0), folder=tmp_path / "state")
    edited(workspace, 3)
    place = tmp_path / "p.retime"
    place.write_text("something else")
    with pytest.raises(OutputExistsError):
        workspace.save(place, workspace.history, workspace.warps, overwrite=False)
    assert place.read_text() == "something else"
    assert workspace.path is None
    workspace.save(place, workspace.history, workspace.warps, overwrite=True)
    edited(workspace, 4)
    dead(workspace)
    again = open_project(place)
    assert again.recovered
    assert again.history.present.keys[0].input_time == 0.04
    again.close()
    # Of the clips' own journal nothing is left; what is left says where they were saved.
    assert [file.suffix for file in (tmp_path / "state" / "journals").iterdir()] == [".saved"]


def test_kept_warps_are_recovered(tmp_path) -> None:
    workspace = open_document(numbered(0), folder=tmp_path)
    document = replace(workspace.history.present, kept=(KeptWarp(warp_id(WARP), "first"),))
    history = workspace.history.edit(document, label="keep")
    workspace.journal.keep(warp_id(WARP), WARP, history, {})
    workspace.journal.edit(Edit(document, "keep", "", True), history, {warp_id(WARP): WARP})
    dead(workspace)
    again = open_document(numbered(0), folder=tmp_path)
    np.testing.assert_array_equal(again.warps[warp_id(WARP)].output_times, WARP.output_times)
    assert again.history.present == document
    again.close()


@pytest.mark.parametrize("damage", [b"", b"\x00" * 100, b"00000000 {}\n"])
def test_a_journal_that_can_not_be_read_is_kept_and_told(tmp_path, damage) -> None:
    workspace = open_document(numbered(0), folder=tmp_path)
    place = workspace.journal.path
    dead(workspace)
    place.write_bytes(damage)
    again = open_document(numbered(0), folder=tmp_path)
    (note,) = again.notes
    assert "could not be read" in note
    assert place.with_name(place.name + ".old-1").read_bytes() == damage
    again.close()


def test_a_name_that_is_no_text_is_refused() -> None:
    with pytest.raises(OptionError, match="name that is text"):
        new_document([os.fsdecode(b"/clips/\xff.bvh")])


def test_clips_that_were_saved_are_found_in_their_project(tmp_path) -> None:
    state, place = tmp_path / "state", tmp_path / "p.retime"
    workspace = open_document(numbered(0), folder=state)
    edited(workspace, 3)
    workspace.save(place, workspace.history, workspace.warps, overwrite=False)
    edited(workspace, 4)
    dead(workspace)
    # The same clips: saved, and what came after the save is there too.
    again = open_document(numbered(0), folder=state)
    assert (again.path, again.resumed, again.recovered) == (place, True, True)
    assert again.history.present.keys[0].input_time == 0.04
    # Saved elsewhere, they are found there.
    other = tmp_path / "q.retime"
    again.save(other, again.history, again.warps, overwrite=False)
    again.close()
    third = open_document(numbered(0), folder=state)
    assert (third.path, third.resumed, third.recovered) == (other, True, False)
    third.close()
    # Other clips are other work.
    different = open_document(Document((ClipFile("/else.bvh"),)), folder=state)
    assert (different.path, different.resumed) == (None, False)
    different.close()


def test_one_begins_anew_and_loses_nothing(tmp_path) -> None:
    state, place = tmp_path / "state", tmp_path / "p.retime"
    workspace = open_document(numbered(0), folder=state)
    edited(workspace, 3)
    workspace.save(place, workspace.history, workspace.warps, overwrite=False)
    workspace.close()
    saved = place.read_bytes()
    anew = open_document(numbered(0), folder=state).begin_anew(state)
    assert (anew.path, anew.resumed, anew.history.present) == (None, False, numbered(0))
    assert place.read_bytes() == saved
    # It stays anew; what was done since then is recovered, and set aside by who begins anew again.
    edited(anew, 5)
    dead(anew)
    back = open_document(numbered(0), folder=state)
    assert (back.path, back.recovered) == (None, True)
    once_more = back.begin_anew(state)
    assert once_more.history.present == numbered(0)
    (kept,) = (state / "journals").glob("*.old-1")
    assert str(kept) in once_more.notes[0]
    assert read_journal(kept).history.present.keys[0].input_time == 0.05
    once_more.close()


def test_a_project_that_is_gone_is_told_and_the_clips_are_there(tmp_path) -> None:
    state, place = tmp_path / "state", tmp_path / "p.retime"
    workspace = open_document(numbered(0), folder=state)
    edited(workspace, 3)
    workspace.save(place, workspace.history, workspace.warps, overwrite=False)
    workspace.close()
    for broken in (lambda: place.write_text("no project"), place.unlink):
        broken()
        again = open_document(numbered(0), folder=state)
        assert (again.path, again.history.present) == (None, numbered(0))
        assert "can't be opened" in again.notes[0]
        again.close()
