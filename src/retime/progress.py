"""Long work that tells how far it is, and ends where nobody wants its answer any more."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Iterator
from contextvars import ContextVar

Tell = Callable[[float], None]
"""Takes the share of a stage that is done, from 0 to 1, or nan where nobody knows it; raises to end the work."""

_TELL: ContextVar[Tell | None] = ContextVar("tell", default=None)


@contextlib.contextmanager
def watching(tell: Tell) -> Iterator[None]:
    """Have `tell` called at least ten times a second while a search is at work in this thread.

    Whatever it raises ends the search, and is raised to the caller. (Ctrl-C ends it without this.)

    Parameters
    ----------
    tell : function of a share
        Called in this thread, with the share of a stage that is done, or nan.

    Examples
    --------
    >>> import time
    >>> from retime import guided_warp
    >>> begun = time.monotonic()
    >>> def hurry(share):
    ...     if time.monotonic() - begun > 60:
    ...         raise TimeoutError("it took a minute")
    >>> with watching(hurry):
    ...     guided_warp([float(i * i % 7) for i in range(60)], rate=30, length="75%").n_output
    45
    """
    token = _TELL.set(tell)
    try:
        yield
    finally:
        _TELL.reset(token)


def look(share: float = math.nan) -> None:
    """Tell who watches how much of a stage is done; called by whatever takes long."""
    tell = _TELL.get()
    if tell is not None:
        tell(share)
