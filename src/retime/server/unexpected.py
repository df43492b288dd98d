"""Errors that nobody expected: each gets a number, the page is told that, and the log has all of it."""

from __future__ import annotations

import itertools
import logging

from retime.errors import RetimeError, words_of
from retime.server.page_words import page_words

_log = logging.getLogger("retime.server")
_numbers = itertools.count(1)
# Letters of an error's own words that a page is shown.
_MAX_WORDS = 300


def words_for_page(error: BaseException) -> str:
    """Say what went wrong.

    Parameters
    ----------
    error : BaseException
        What retime raises on purpose, what the system refuses, and a want of memory are said in their own words,
        and in the page's where they name what to set.
        Anything else is a fault of retime's: it gets a number, and is logged with where it happened.

    Returns
    -------
    str
        For whoever asked for what failed.
    """
    if isinstance(error, RetimeError | OSError | MemoryError):
        return page_words(words_of(error))
    number = next(_numbers)
    _log.error("fault %d in retime", number, exc_info=error)
    words = words_of(error)
    words = words if len(words) <= _MAX_WORDS else words[:_MAX_WORDS] + "…"
    return (
        f"fault {number} in retime ({type(error).__name__}: {words}). What was asked for is not done; all else goes "
        f"on. The editor's log, in its terminal, says under this number where it happened: please report it"
    )
