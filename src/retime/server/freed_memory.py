"""What the editor's process does with memory that it has freed."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable
from functools import cache


def give_back_freed_memory() -> None:
    """Give back to the system what the process has freed, where glibc would keep it.

    Between pieces that are still in use it keeps all others, in a share of memory for each thread: an editor that is
    open all day would hold what the largest of its searches needed, in each of them. It takes milliseconds, and what is
    allocated next is cleared by the system once more, so it is for a moment in which nobody waits. Does nothing where
    the system's allocator is another one.
    """
    trim = _trim()
    if trim is not None:
        trim(0)


@cache
def _trim() -> Callable[[int], int] | None:
    """Return glibc's function, which lets other threads work meanwhile; None where there is none."""
    if not sys.platform.startswith("linux"):
        return None
    try:
        trim = ctypes.CDLL(None).malloc_trim
    except (OSError, AttributeError):
        # Another C library, such as musl, or a program that is linked with none of its own.
        return None
    trim.argtypes, trim.restype = [ctypes.c_size_t], ctypes.c_int
    found: Callable[[int], int] = trim
    return found
