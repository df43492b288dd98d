"""How a command may end: exit codes, and what an error is said to be."""

from __future__ import annotations

import os

from retime.errors import InfeasibleWarpError, OptionError

EXIT_OK = 0
EXIT_FILE = 1
EXIT_USAGE = 2
EXIT_INFEASIBLE = 3
EXIT_INTERRUPTED = 130


def exit_code(error: BaseException) -> int:
    """Return the code that an error ends a command with."""
    if isinstance(error, InfeasibleWarpError):
        return EXIT_INFEASIBLE
    return EXIT_USAGE if isinstance(error, OptionError) else EXIT_FILE


def problem(error: BaseException) -> str:
    """Say what went wrong: of the system, what it refused, and for which file."""
    if not isinstance(error, OSError):
        return str(error)
    words = error.strerror or str(error)
    return f"{os.fspath(error.filename)!s}: {words}" if error.filename else words
