"""The journal: the whole history in it, and what is left of one that was cut."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.project import journal as journals
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
