"""Undo and redo: values, and the steps between them."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

from retime.project.document import Document

MOST_STEPS = 1000
"""That undo can take back: an editor that is open for days keeps no more of them."""


@dataclass(frozen=True)
class Step:
    """Something that was done.

    Attributes
    ----------
    label : str
        What it was, for the undo menu.
    gesture : str
        The gesture that may go on with it; "" where it is over.
    document : Document
        What it made.
    """

    label: str
    gesture: str
    document: Document


@dataclass(frozen=True)
class History:
    """A document, the steps that led to it, and those that were taken back.

    Attributes
    ----------
    start : Document
        Before the first step that is kept.
    done : tuple of Step
        The latest last.
    undone : tuple of Step
        The next to do again last.

    Examples
    --------
    >>> from retime.project.document import ClipFile
    >>> history = History(Document((ClipFile("walk.bvh"),)))
    >>> shorter = replace(history.present, options={"length": "65%"})
    >>> history = history.edit(shorter, label="set length")
    >>> history.undo().present.options, history.undo().redo().present.options
    ({}, {'length': '65%'})
    """

    start: Document
    done: tuple[Step, ...] = ()
    undone: tuple[Step, ...] = ()

    @property
    def present(self) -> Document:
        """The document as it is now."""
        return self.done[-1].document if self.done else self.start

    @property
    def undo_label(self) -> str | None:
        """What `undo` would take back."""
        return self.done[-1].label if self.done else None

    @property
    def redo_label(self) -> str | None:
        """What `redo` would do again."""
        return self.undone[-1].label if self.undone else None

    def edit(self, document: Document, *, label: str, gesture: str = "", done: bool = True) -> History:
        """Take a new value.

        A gesture is one step, however many edits it has. One that ends where it began leaves no step. Of more than
        `MOST_STEPS` the earliest is no longer kept.

        Parameters
        ----------
        document : Document
            The new value.
        label : str
            What was done.
        gesture : str
            Which gesture it is part of; "" where it is one by itself.
        done : bool
            Whether that is over.
        """
        going_on = gesture != "" and bool(self.done) and self.done[-1].gesture == gesture and not self.undone
        before = replace(self, done=self.done[:-1]) if going_on else self.sealed()
        if document == before.present:
            return before
        step = Step(label, "" if done else gesture, _made_of(before.present, document))
        steps = (*before.done, step)
        start = steps[-MOST_STEPS - 1].document if len(steps) > MOST_STEPS else before.start
        return replace(before, start=start, done=steps[-MOST_STEPS:], undone=())

    def sealed(self) -> History:
        """Let no gesture go on with the last step."""
        if not self.done or not self.done[-1].gesture:
            return self
        return replace(self, done=(*self.done[:-1], replace(self.done[-1], gesture="")))

    def undo(self) -> History:
        """Take back the last step; nothing, where there is none."""
        if not self.done:
            return self
        last = replace(self.done[-1], gesture="")
        return replace(self, done=self.done[:-1], undone=(*self.undone, last)).sealed()

    def redo(self) -> History:
        """Do again the step taken back last; nothing, where there is none."""
        if not self.undone:
            return self
        return replace(self, done=(*self.done, self.undone[-1]), undone=self.undone[:-1])


def _made_of(known: Document, document: Document) -> Document:
    """Return an equal document that has the very parts of another, wherever both are equal.

    A page sends all of a document for each key that is moved, and a day of steps stays in memory.
    """
    old, new = _values(known), _values(document)
    return replace(document, **{name: _kept(old[name], value) for name, value in new.items() if value is not old[name]})


def _values(document: Document) -> dict[str, Any]:
    return {field.name: getattr(document, field.name) for field in fields(document)}


def _kept(old: Any, new: Any) -> Any:
    if new == old:
        return old
    if not isinstance(new, tuple) or not isinstance(old, tuple):
        return new
    # Keys and their like are found again by their ids, the others by their places.
    by_id = {getattr(one, "id", place): one for place, one in enumerate(old)}
    return tuple(
        known if (known := by_id.get(getattr(one, "id", place))) == one else one for place, one in enumerate(new)
    )
