"""Undo and redo, against a model that keeps every value in a list."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from retime.project.document import ClipFile, Document, Key
from retime.project.history import History
from tests.project.documents import numbered


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


def test_a_step_is_made_of_the_parts_of_the_one_before_where_they_are_equal() -> None:
    """A day of edits, each of which a page sends whole, stays in memory."""

    def document(moved: float, *, n_keys: int = 5) -> Document:
        keys = tuple(Key(f"k{i}", 0.1 * i, moved if i == 2 else 0.1 * i) for i in range(n_keys))
        return Document((ClipFile("/a.bvh"),), keys=keys, options={"length": "65%"})

    first = History(document(0.2))
    second = first.edit(document(0.3), label="move key")
    assert second.present == document(0.3)
    assert second.present.clips is first.present.clips
    assert second.present.options is first.present.options
    for place in (0, 1, 3, 4):
        assert second.present.keys[place] is first.present.keys[place]
    # A key that goes, and one that comes: the others are found again by their ids.
    fewer = second.edit(replace(document(0.3), keys=document(0.3).keys[1:]), label="remove key")
    assert all(one is other for one, other in zip(fewer.present.keys, second.present.keys[1:], strict=True))
    more = fewer.edit(document(0.3, n_keys=6), label="add keys")
    assert more.present == document(0.3, n_keys=6)
    assert more.present.keys[1] is second.present.keys[1]


def test_the_earliest_steps_are_let_go(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("retime.project.history.MOST_STEPS", 3)
    history = History(numbered(0))
    for number in range(1, 6):
        history = history.edit(numbered(number), label=f"to {number}")
    undone = []
    while history.undo_label is not None:
        undone.append(history.undo_label)
        history = history.undo()
    assert undone == ["to 5", "to 4", "to 3"]
    assert history.present == numbered(2)
    while history.redo_label is not None:
        history = history.redo()
    assert history.present == numbered(5)
    # A gesture that goes on pushes nothing out.
    for number in (6, 7, 8):
        history = history.edit(numbered(number), label="drag", gesture="g", done=False)
    assert [step.label for step in history.done] == ["to 4", "to 5", "drag"]
