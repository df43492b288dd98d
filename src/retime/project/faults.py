"""What of a document is at fault where it can't be solved: the page says so beside the very keytime, clip or field."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass

from retime.errors import InfeasibleWarpError, OptionError, RetimeError, words_of
from retime.project.document import Document
from retime.search.options import BY_NAME


@dataclass(frozen=True)
class Fault:
    """What of a document is at fault.

    Attributes
    ----------
    key, lock : str, optional
        The id of a keytime, of a lock.
    clip, reference : int, optional
        The place of a clip, of a reference, counted from 0.
    field : str, optional
        The name of a value: ``options.rate``.
    """

    key: str | None = None
    lock: str | None = None
    clip: int | None = None
    reference: int | None = None
    field: str | None = None


class FaultyError(RetimeError):
    """Something in a document can't be used.

    Parameters
    ----------
    error : Exception
        Why; its words are this one's.
    fault : Fault
        What.
    """

    def __init__(self, error: Exception, fault: Fault) -> None:
        self.fault = fault
        super().__init__(words_of(error))


@contextlib.contextmanager
def blaming(fault: Fault) -> Iterator[None]:
    """Say of whatever fails inside that this was at fault."""
    try:
        yield
    except FaultyError:
        raise
    except (RetimeError, OSError) as error:
        raise FaultyError(error, fault) from error


def option_fault(name: str) -> Fault:
    """Say that an option is at fault; of what is no option (keys, locks, clips) nothing can be said by its name."""
    return Fault(field=f"options.{name}") if name in BY_NAME else Fault()


def fault_of(error: Exception, document: Document, last: Document | None) -> Fault:
    """Say what of a document is at fault.

    Parameters
    ----------
    error : Exception
        From `DocumentSolver.solve`.
    document : Document
        What was to be solved.
    last : Document, optional
        The last one that could be solved: of the two ends of a span the one that was changed since is at fault.
    """
    if isinstance(error, FaultyError):
        return error.fault
    if not isinstance(error, InfeasibleWarpError | OptionError):
        return Fault()
    if isinstance(error, OptionError) and error.item is not None:
        if error.option == "locks":
            return Fault(lock=document.locks[error.item].id)
        if error.option == "reference" and error.item < len(document.references):
            return Fault(reference=error.item)
    if error.option == "reference" and len(document.references) == 1:
        return Fault(reference=0)
    if error.option == "motion":
        # The clips of a group don't fit together: the one that was added last is named.
        return Fault(clip=max(i for i, file in enumerate(document.clips) if file.role == "search"))
    suspects = [key for key in document.keys if key.output_time in error.output_times]
    before = () if last is None else last.keys
    changed = [key for key in suspects if key not in before]
    if not changed and last is not None and error.output_times:
        # No keytime has moved, so it is another change that leaves no way through.
        if locks := [lock for lock in document.locks if lock not in last.locks]:
            return Fault(lock=locks[-1].id)
        for name in BY_NAME:
            if document.options.get(name) != last.options.get(name):
                return option_fault(name)
    if suspects:
        return Fault(key=(changed or suspects)[-1].id)
    if error.option is None:
        # A span is at fault, and no keytime of the document ends it: its end is the clip's, where the length puts it.
        return option_fault("length") if error.output_times and "length" in document.options else Fault()
    return option_fault(error.option)
