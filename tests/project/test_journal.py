"""The journal: the whole history in it, and what is left of one that was cut."""

from __future__ import annotations

import json
import shutil
import tempfile
import tracemalloc
import zlib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import FormatError, OptionError
from retime.project import journal as journals
from retime.project.dataclass_json import to_value
from retime.project.history import History
from retime.project.journal import Edit, Journal, read_journal
from tests.project.documents import numbered

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


def test_a_long_history_is_written_anew_without_all_of_it_in_memory(tmp_path) -> None:
    history = History(numbered(0))
    for number in range(1, 1001):
        history = history.edit(numbered(number), label=str(number))
    # More is undone than not, so that both are written.
    for _ in range(600):
        history = history.undo()
    journal = Journal(tmp_path / "j")
    # What is imported and made once is not counted.
    journal.begin(history, {}, "")
    tracemalloc.start()
    try:
        journal.begin(history, {}, "")
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    journal.close()
    size = journal.path.stat().st_size
    assert size > 300_000
    assert most < 3 * journals._PIECE + 50_000 < size
    assert read_journal(journal.path).history == history


def test_a_journal_of_an_older_program_is_recovered_undo_included(tmp_path) -> None:
    def document(**changes):
        options = {"method": "guided", "rate": None, "slowest": None, "fastest": None, "smoothness": 0.0}
        options |= {"score": "joint", "loop": False, "average": True}
        fields = {"length": None, "min_length": None, "max_length": None, "free_weight": "neutral", "influence": 1.0}
        return {
            "clips": [{"path": "/a.bvh"}],
            **fields,
            "options": {**options, **changes.pop("options", {})},
            **changes,
        }

    limits = {"slowest": 0.5, "fastest": 2.0}
    steps = [("set length", {"length": "65%"}), ("set limits", {"length": "65%", "options": limits})]
    lines = [{"format": "retime-journal", "version": 1, "base": "", "start": document()}]
    for label, changes in steps:
        lines.append({"did": "edit", "document": document(**changes), "label": label, "gesture": "", "done": True})
    lines.append({"did": "undo"})
    texts = [json.dumps(line).encode() for line in lines]
    (tmp_path / "j").write_bytes(b"".join(b"%08x %s\n" % (zlib.crc32(text), text) for text in texts))
    history = read_journal(tmp_path / "j").history
    assert history.start.options == {}
    assert (history.undo_label, history.present.options) == ("set length", {"length": "65%"})
    assert history.redo().present.options == {"length": "65%", "speed": "0.5..2"}


@pytest.mark.parametrize("name", [["w"], {"w": 1}, 3, None])
def test_a_journal_that_keeps_a_warp_by_no_name_is_none(tmp_path, name) -> None:
    start = {"format": "retime-journal", "version": 2, "base": "", "start": to_value(numbered(0))}
    lines = [start, {"did": "keep", "id": name, "warp": {}}]
    texts = [json.dumps(line).encode() for line in lines]
    (tmp_path / "j").write_bytes(b"".join(b"%08x %s\n" % (zlib.crc32(text), text) for text in texts))
    with pytest.raises(FormatError, match="a warp is kept by no name"):
        read_journal(tmp_path / "j")


def edited(journal: Journal, history: History, number: int) -> History:
    edit = Edit(numbered(number), f"to {number}", "", True)
    history = history.edit(edit.document, label=edit.label)
    journal.edit(edit, history, {})
    return history


@pytest.mark.parametrize("how", ["removed", "replaced"])
def test_a_journal_that_was_taken_away_is_written_anew(tmp_path, how) -> None:
    journal = Journal(tmp_path / "j")
    journal.begin(History(numbered(0)), {}, "base")
    history = edited(journal, History(numbered(0)), 1)
    journal.path.unlink()
    if how == "replaced":
        journal.path.write_text("nobody's\n")
    history = edited(journal, history, 2)
    assert read_journal(journal.path).history == history
    journal.save("digest", history, {})
    assert read_journal(journal.path).saves == (("digest", history.present),)
    journal.path.unlink()
    journal.save("later", history, {})
    assert read_journal(journal.path).saves == (("later", history.present),)
    journal.close()


def test_a_journal_whose_lock_was_removed_takes_it_again(tmp_path) -> None:
    journal = Journal(tmp_path / "j")
    journal.begin(History(numbered(0)), {}, "")
    for place in tmp_path.iterdir():
        place.unlink()
    history = edited(journal, History(numbered(0)), 1)
    with pytest.raises(OptionError, match="another editor"):
        Journal(tmp_path / "j")
    assert read_journal(journal.path).history == history
    journal.close(remove=True)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("how", ["removed", "renamed"])
def test_a_journal_whose_folder_is_gone_says_so_and_goes_on_when_it_is_there_again(tmp_path, how) -> None:
    folder = tmp_path / "work"
    journal = Journal(folder / "j")
    journal.begin(History(numbered(0)), {}, "")
    history = edited(journal, History(numbered(0)), 1)
    shutil.rmtree(folder) if how == "removed" else folder.rename(tmp_path / "elsewhere")
    for number in (2, 3):
        edit = Edit(numbered(number), f"to {number}", "", True)
        history = history.edit(edit.document, label=edit.label)
        with pytest.raises(FileNotFoundError, match="the folder is gone"):
            journal.edit(edit, history, {})
    folder.mkdir()
    history = edited(journal, history, 4)
    assert read_journal(journal.path).history == history
    journal.close()


def test_a_journal_whose_place_another_editor_has_taken_leaves_it_alone(tmp_path) -> None:
    folder = tmp_path / "work"
    journal = Journal(folder / "j")
    journal.begin(History(numbered(0)), {}, "")
    folder.rename(tmp_path / "elsewhere")
    other = Journal(folder / "j")
    other.begin(History(numbered(7)), {}, "")
    with pytest.raises(OptionError, match="another editor"):
        edited(journal, History(numbered(0)), 1)
    journal.close(remove=True)
    assert read_journal(other.path).history == History(numbered(7))
    with pytest.raises(OptionError, match="another editor"):
        Journal(folder / "j")
    other.close()
