"""The exit code with which an error ends a command."""

from __future__ import annotations

from retime.errors import InfeasibleWarpError, OptionError

EXIT_OK = 0
EXIT_FILE = 1
EXIT_USAGE = 2
EXIT_INFEASIBLE = 3
# Of many clips.
EXIT_SOME_FAILED = 4
EXIT_NONE_DONE = 5
EXIT_INTERRUPTED = 130


def exit_code(error: BaseException) -> int:
    """Return the code that an error ends a command with."""
    if isinstance(error, InfeasibleWarpError):
        return EXIT_INFEASIBLE
    return EXIT_USAGE if isinstance(error, OptionError) else EXIT_FILE
