"""Undo and redo, against a model that keeps every value in a list."""

from __future__ import annotations

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

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
