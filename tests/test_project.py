"""The editor's document: its undo, its journal, its file, and what is left after a death or on a full disk."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from retime.errors import FormatError, OptionError, OutputExistsError
from retime.project import journal as journals
from retime.project.document import (
    ClipFile,
    CounterpartFile,
    Document,
    JointPair,
    KeptWarp,
    Key,
    LockedTime,
    Options,
    ReferenceFile,
)
from retime.project.file import project_bytes, read_project, save_project, warp_id
from retime.project.history import History
from retime.project.journal import Edit, Journal, read_journal
from retime.project.places import Places
from retime.project.values import from_value, to_value
from retime.project.work import new_document, open_document, open_project
from retime.warp.curve import Warp

WARP = Warp(np.array([0.0, 0.1, 1 / 3]), np.array([0.0, 0.3, 2 / 3]), name="été")


def document_of(folder: Path) -> Document:
    """Make a document that uses every field."""
    return Document(
        clips=(
            ClipFile(str(folder / "a.bvh"), first_frame=2, last_frame=90, fps="30000/1001", up="z"),
            ClipFile(str(folder / "camera.csv")),
        ),
        references=(
            ReferenceFile(
                str(folder / "refs" / "b.bvh"),
                weight=2.0,
                mirror=True,
                joint_map=str(folder / "names.json"),
                joints=(JointPair("Hips", "pelvis"),),
                counterparts=(CounterpartFile(1, str(folder / "refs" / "c.csv"), fps="25"),),
            ),
            ReferenceFile(first_frame=4),
        ),
        keys=(Key("k1", 1 / 3, 0.1), Key("k2", 2.0, 1.5, 0.5)),
        locks=(LockedTime("l1", 0.5, 0.75, 0.0, 1.0),),
        length="65%",
        influence=0.5,
        options=Options(score="conditional", slowest=0.25, fastest=4.0),
        kept=(KeptWarp(warp_id(WARP), "first try"),),
    )


def numbered(number: int) -> Document:
    return Document((ClipFile("/a.bvh"),), keys=(Key("k", 0.01 * number, 1.0),))


# Values.


def test_a_document_is_json_and_back(tmp_path) -> None:
    document = document_of(tmp_path)
    assert from_value(Document, json.loads(json.dumps(to_value(document))), "document") == document


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"clips": []}, "needs a clip"),
        ({"clips": [{"path": "a", "role": "follow"}]}, "the first clip"),
        ({"keys": [{"id": "k", "input_time": 0, "output_time": 0}] * 2}, "two keys have the same id"),
        ({"keys": [{"id": "", "input_time": 0, "output_time": 0}]}, "empty"),
        ({"keys": {}}, r"document.keys: expected a list, found an object"),
        ({"keys": [{"id": "k", "input_time": "0", "output_time": 0}]}, r"keys\[0\].input_time: expected a number"),
        ({"influence": True}, "expected a number, found true"),
        ({"length": 65}, "expected text, found 65"),
        ({"free_weight": "heavy"}, "expected one of neutral, sum"),
        ({"options": {"loop": 1}}, "options.loop: expected true or false"),
        ({"options": {"max_skip": 2.0}}, "expected a whole number"),
        ({"length": "\ud800"}, "half a letter"),
        ({"tempo": 1}, 'unknown field "tempo"'),
        ({"references": [{"counterparts": [{"clip": 1, "path": "b"}]}]}, "counterpart for clip 1, of 1 clips"),
        ({"references": [{"joints": [{"input": "a", "reference": "b"}] * 2}]}, "two joints for one of the clip's"),
    ],
)
def test_what_is_no_document_is_refused_with_its_place(change, says) -> None:
    value = {"clips": [{"path": "a.bvh"}], **change}
    with pytest.raises(FormatError, match=says):
        from_value(Document, value, "document")


# Undo and redo, against a model that keeps every value in a list; and the journal, against the history.


class UndoMachine(RuleBasedStateMachine):
    def __init__(self) -> None:
        super().__init__()
        self.history = History(numbered(0))
        # The model: all values, where we are, and the gesture that goes on.
        self.values = [0]
        self.place = 0
        self.gesture = ""

    @rule(number=st.integers(0, 3), gesture=st.sampled_from(["", "g1", "g2"]), done=st.booleans())
    def edit(self, number: int, gesture: str, done: bool) -> None:
        self.history = self.history.edit(numbered(number), label=f"to {number}", gesture=gesture, done=done)
        goes_on = gesture != "" and gesture == self.gesture and self.place == len(self.values) - 1
        before = self.place - goes_on
        if number == self.values[before]:
            # Back where it began, or nothing at all; whatever gesture there was is over.
            if goes_on:
                self.values = self.values[: before + 1]
            self.place, self.gesture = before, ""
            return
        self.values = [*self.values[: before + 1], number]
        self.place, self.gesture = before + 1, "" if done else gesture

    @rule()
    def undo(self) -> None:
        self.history = self.history.undo()
        if self.place:
            self.place, self.gesture = self.place - 1, ""

    @rule()
    def redo(self) -> None:
        self.history = self.history.redo()
        if self.place < len(self.values) - 1:
            self.place, self.gesture = self.place + 1, ""

    @precondition(lambda self: self.history.undo_label is not None)
    @rule()
    def undo_and_redo_is_nothing(self) -> None:
        assert self.history.undo().redo().present == self.history.present

    @invariant()
    def the_document_is_the_models(self) -> None:
        assert self.history.present == numbered(self.values[self.place])
        assert (self.history.undo_label is None) == (self.place == 0)
        assert (self.history.redo_label is None) == (self.place == len(self.values) - 1)


TestUndo = UndoMachine.TestCase
TestUndo.settings = settings(max_examples=60, stateful_step_count=30)


ACTIONS = st.lists(
    st.one_of(
        st.tuples(st.integers(0, 3), st.sampled_from(["", "g1", "g2"]), st.booleans()),
        st.sampled_from(["undo", "redo", "rewrite"]),
    ),
    max_size=25,
)


@settings(max_examples=25)
@given(ACTIONS)
def test_a_journal_holds_the_whole_history(actions) -> None:
    with tempfile.TemporaryDirectory() as folder:
        history = History(numbered(0))
        journal = Journal(Path(folder) / "j")
        journal.begin(history, {}, "")
        for action in actions:
            if action == "undo":
                history = history.undo()
                journal.undo(history, {})
            elif action == "redo":
                history = history.redo()
                journal.redo(history, {})
            elif action == "rewrite":
                journal.begin(history, {}, "")
            else:
                number, gesture, done = action
                edit = Edit(numbered(number), f"to {number}", gesture, done)
                history = history.edit(edit.document, label=edit.label, gesture=gesture, done=done)
                journal.edit(edit, history, {})
        assert read_journal(journal.path).history == history
        journal.close(remove=True)


# The project file.


def test_a_project_comes_back_as_it_was(tmp_path) -> None:
    document = document_of(tmp_path)
    place = tmp_path / "p.retime"
    save_project(place, project_bytes(document, {warp_id(WARP): WARP}, tmp_path), overwrite=False)
    project = read_project(place)
    assert project.document == document
    np.testing.assert_array_equal(project.warps[warp_id(WARP)].input_times, WARP.input_times)


def test_a_project_of_version_1_is_read(tmp_path) -> None:
    place = tmp_path / "old.retime"
    reference = {"path": "b.bvh", "first_frame": 3, "weight": 2.0, "mirror": False, "joint_map": "names.csv"}
    document = {"clips": [{"path": "a.bvh", "role": "search"}], "references": [reference]}
    place.write_text(json.dumps({"format": "retime-project", "version": 1, "document": document, "warps": {}}))
    (found,) = read_project(place).document.references
    assert found == ReferenceFile(
        str(tmp_path / "b.bvh"), first_frame=3, weight=2.0, joint_map=str(tmp_path / "names.csv")
    )


def test_files_in_the_projects_folder_move_with_it(tmp_path) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    document = Document((ClipFile(str(here / "clips" / "a.bvh")),), references=(ReferenceFile("/elsewhere/b.bvh"),))
    (here / "p.retime").write_bytes(project_bytes(document, {}, here))
    here.rename(there)
    moved = read_project(there / "p.retime").document
    assert (moved.clips[0].path, moved.references[0].path) == (str(there / "clips" / "a.bvh"), "/elsewhere/b.bvh")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "not JSON"),
        ("{}", "expected a project"),
        ('{"format": "retime-project", "version": 3}', r"version 3 is not one .*\(it reads 1, 2\)"),
        ('{"format": "retime-project", "version": true}', "version True is not one"),
        ('{"format": "retime-project", "version": 1}', "document: expected an object"),
        (
            '{"format": "retime-project", "version": 1, "document": {"clips": [{"path": "a"}]}, "x": 1}',
            "unknown field 'x'",
        ),
        (
            '{"format": "retime-project", "version": 1, "document": {"clips": [{"path": "a"}], "kept": '
            '[{"id": "w", "name": "n"}]}}',
            "keeps a warp 'w'",
        ),
        (
            '{"format": "retime-project", "version": 1, "document": {"clips": [{"path": "a"}]}, "warps": {"w": {}}}',
            "warps.w: expected a warp",
        ),
    ],
)
def test_what_is_no_project_is_refused_with_its_name(tmp_path, text, says) -> None:
    place = tmp_path / "p.retime"
    place.write_text(text)
    with pytest.raises(FormatError, match=says) as found:
        read_project(place)
    assert found.value.path == str(place)


def test_a_project_is_not_saved_under_another_files_name(tmp_path) -> None:
    place = tmp_path / "profile"
    with pytest.raises(FormatError, match=r"ends in \.retime"):
        save_project(place, b"{}", overwrite=True)
    assert not place.exists()


# The journal, after the program died.

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


@pytest.mark.parametrize("cut", [1, 2, 20, 200])
def test_a_line_that_was_cut_counts_as_not_written(tmp_path, cut) -> None:
    journal = Journal(tmp_path / "j")
    history = History(numbered(0))
    journal.begin(history, {}, "")
    for number in (1, 2):
        history = history.edit(numbered(number), label=str(number))
        journal.edit(Edit(numbered(number), str(number), "", True), history, {})
    journal.close()
    data = journal.path.read_bytes()
    journal.path.write_bytes(data[:-cut])
    assert read_journal(journal.path).history.present == numbered(1)
    # A block of the disk that was never written reads as zeros.
    journal.path.write_bytes(data[:-cut] + bytes(cut))
    assert read_journal(journal.path).history.present == numbered(1)


def test_two_editors_never_write_one_journal(tmp_path) -> None:
    work = open_document(numbered(0), folder=tmp_path)
    with pytest.raises(OptionError, match="another editor has this open"):
        open_document(numbered(0), folder=tmp_path)
    work.close()
    open_document(numbered(0), folder=tmp_path).close()
    # Nothing was done, and nothing is left behind.
    assert [path.name for path in tmp_path.rglob("*")] == ["journals"]


def test_a_journal_does_not_grow_for_ever(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(journals, "_LARGE", 20_000)
    journal = Journal(tmp_path / "j")
    history = History(numbered(0))
    journal.begin(history, {}, "")
    sizes = []
    for number in range(1, 200):
        edit = Edit(numbered(number), "drag", "g", False)
        history = history.edit(edit.document, label="drag", gesture="g", done=False)
        journal.edit(edit, history, {})
        sizes.append(journal.path.stat().st_size)
    assert max(sizes) < 22_000
    assert read_journal(journal.path).history == history
    journal.close()


def edited(work, number: int) -> None:
    document = replace(work.history.present, keys=(Key("k", 0.01 * number, 1.0),))
    work.history = work.history.edit(document, label=f"to {number}")
    work.journal.edit(Edit(document, f"to {number}", "", True), work.history, work.warps)


def dead(work) -> None:
    """Let go of a work as a program does that dies: nothing is removed."""
    work.journal._file.close()
    work.journal._lock.close()


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


# A full disk.

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


# Places.


def test_places_are_compared_part_by_part_with_links_followed(tmp_path) -> None:
    inside, beside = tmp_path / "clips", tmp_path / "clips2"
    for folder in (inside, beside):
        folder.mkdir()
        (folder / "a.bvh").touch()
    (inside / "way_out").symlink_to(beside)
    (inside / "a_link.bvh").symlink_to(beside / "a.bvh")
    places = Places([inside], [beside / "named.bvh"])
    assert places.find("a.bvh") == inside / "a.bvh"
    assert places.find(inside / "new.bvh") == inside / "new.bvh"
    assert places.find(beside / "named.bvh", reading=True) == beside / "named.bvh"
    for path in (
        beside / "a.bvh",
        beside / "named.bvh",
        "../clips2/a.bvh",
        "way_out/a.bvh",
        "a_link.bvh",
        "/etc/passwd",
        "~root/a.bvh",
        "a\0.bvh",
        "~nobody knows/a.bvh",
    ):
        with pytest.raises(OptionError, match=r"outside the folders|no path"):
            places.find(path)


def test_a_refusal_says_what_to_type(tmp_path) -> None:
    here, one, two = (tmp_path / name for name in ("here", "my clips", "more"))
    places = Places([here], command=["retime", "edit", "--project", "p.retime"])
    with pytest.raises(OptionError) as found:
        places.find(one / "a.bvh", beside=[one / "b.bvh", here / "c.bvh", two / "d.bvh"])
    assert str(found.value).endswith(f"type: retime edit --project p.retime --folder '{one}' --folder {two}")
    # Of a folder it is the folder itself, not the one that it is in; what is no path does not stand in the way.
    with pytest.raises(OptionError, match=f"--folder {two}$"):
        places.find(two, beside=["a\0.bvh", "~nobody knows/a.bvh"])
    with pytest.raises(OptionError, match=r"os\.chdir"):
        Places([here]).find(one / "a.bvh")


def test_a_name_that_is_no_text_is_refused() -> None:
    with pytest.raises(OptionError, match="name that is text"):
        new_document([os.fsdecode(b"/clips/\xff.bvh")])
