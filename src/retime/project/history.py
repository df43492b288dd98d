"""Undo and redo: values, and the steps between them."""

from __future__ import annotations

from dataclasses import dataclass, replace

from retime.project.document import Document


@dataclass(frozen=True)
class Step:
    """Something that was done.

    Attributes
    ----------
    label : str
        What it was, for the undo menu.
    gesture : str
        Edits of one gesture are one step.
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
        Before the first step.
    done : tuple of Step
        The latest last.
    undone : tuple of Step
        The next to do again last.

    Examples
    --------
    >>> from retime.project.document import ClipFile
    >>> history = History(Document((ClipFile("walk.bvh"),)))
    >>> shorter = replace(history.present, length="65%")
    >>> history = history.edit(shorter, label="set length", gesture="g1")
    >>> history.undo().present.length, history.undo().redo().present.length
    (None, '65%')
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

    def edit(self, document: Document, *, label: str, gesture: str) -> History:
        """Take a new value; one of the gesture that the last step is from becomes part of that step.

        A gesture that ends where it began leaves no step, and what was undone stays undone only where nothing was done
        since.
        """
        going_on = bool(self.done) and self.done[-1].gesture == gesture and not self.undone
        before = replace(self, done=self.done[:-1]) if going_on else self
        if document == before.present:
            return before if going_on else self
        return replace(before, done=(*before.done, Step(label, gesture, document)), undone=())

    def undo(self) -> History:
        """Take back the last step; nothing, where there is none."""
        if not self.done:
            return self
        return replace(self, done=self.done[:-1], undone=(*self.undone, self.done[-1]))

    def redo(self) -> History:
        """Do again the step taken back last; nothing, where there is none."""
        if not self.undone:
            return self
        return replace(self, done=(*self.done, self.undone[-1]), undone=self.undone[:-1])
