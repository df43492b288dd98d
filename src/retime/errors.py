"""Every error and warning that retime raises on purpose.

Each carries its place, its values and a remedy, in the message and as attributes::

    RetimeError
    ├── FormatError            a file that can't be read or written as what it claims to be
    ├── InvalidMotionError     numbers that no motion may hold (non-finite, wrong shape)
    ├── InfeasibleWarpError    no warp meets the keytimes and limits
    ├── OptionError            options that contradict each other or the data
    ├── OutputExistsError      an output would overwrite a file, and nobody said it may
    └── MissingExtraError      an optional dependency is needed; names the extra to install

    RetimeWarning              (a UserWarning) something was assumed or repaired
    └── FormatWarning          ... while reading a file
"""

from __future__ import annotations

from os import PathLike, fspath

__all__ = [
    "FormatError",
    "FormatWarning",
    "InfeasibleWarpError",
    "InvalidMotionError",
    "MissingExtraError",
    "OptionError",
    "OutputExistsError",
    "RetimeError",
    "RetimeWarning",
]


# Letters of a message; a file from a stranger may have names of any length, which messages quote.
_MOST_LETTERS, _LAST_LETTERS = 2000, 500


class RetimeError(Exception):
    """Base of every error that retime raises on purpose.

    Parameters
    ----------
    message : str
        For people. Of one that is very long the middle is left out.
    """

    def __init__(self, message: str) -> None:
        if len(message) > _MOST_LETTERS:
            message = f"{message[: _MOST_LETTERS - _LAST_LETTERS - 3]}...{message[-_LAST_LETTERS:]}"
        super().__init__(message)


class FormatError(RetimeError, ValueError):
    """A file is not what it claims to be, or can't hold what should be written.

    Parameters
    ----------
    problem : str
        What was expected and what was found.
    path : path-like, optional
        The file.
    line : int, optional
        Line in the file, counted from 1.
    column : int, optional
        Column in the line, counted from 1.
    byte : int, optional
        Offset from the start of a binary file, counted from 0.
    """

    def __init__(
        self,
        problem: str,
        *,
        path: str | PathLike[str] | None = None,
        line: int | None = None,
        column: int | None = None,
        byte: int | None = None,
    ) -> None:
        self.problem = problem
        self.path = None if path is None else fspath(path)
        self.line = line
        self.column = column
        self.byte = byte
        place = [] if self.path is None else [self.path]
        if line is not None:
            place.append(str(line))
            if column is not None:
                place.append(str(column))
        elif byte is not None:
            place.append(f"byte {byte}")
        super().__init__(f"{':'.join(place)}: {problem}" if place else problem)


class InvalidMotionError(RetimeError, ValueError):
    """A motion holds numbers that no motion may hold."""


class InfeasibleWarpError(RetimeError, ValueError):
    """No warp meets the keytimes and the limits.

    Parameters
    ----------
    message : str
        What can't be met, and what would make it feasible.
    span : int, optional
        Which span between neighbouring keytimes, counted from 0.
    n_input, n_output, max_skip : int, optional
        Frames and limit of the span that fails, at the analysis rate.
    min_output, max_output : int, optional
        The output frames that this span allows, at the analysis rate.
    option : str, optional
        The argument of `retime.guided_warp` that is at fault, where it is one.
    output_times : tuple of float
        Output times of the keytimes at fault.
    """

    def __init__(
        self,
        message: str,
        *,
        span: int | None = None,
        n_input: int | None = None,
        n_output: int | None = None,
        max_skip: int | None = None,
        min_output: int | None = None,
        max_output: int | None = None,
        option: str | None = None,
        output_times: tuple[float, ...] = (),
    ) -> None:
        self.option = option
        self.output_times = output_times
        self.span = span
        self.n_input = n_input
        self.n_output = n_output
        self.max_skip = max_skip
        self.min_output = min_output
        self.max_output = max_output
        super().__init__(message)


class OptionError(RetimeError, ValueError):
    """Options contradict each other or the data.

    Parameters
    ----------
    message : str
        What contradicts what, and what would help.
    option : str, optional
        The argument of `retime.guided_warp` that is at fault, where it is one.
    item : int, optional
        Which of its items, counted from 0, where it is a list (``locks``, ``reference``).
    output_times : tuple of float
        Output times of the keytimes at fault.
    """

    def __init__(
        self,
        message: str,
        *,
        option: str | None = None,
        item: int | None = None,
        output_times: tuple[float, ...] = (),
    ) -> None:
        self.option = option
        self.item = item
        self.output_times = output_times
        super().__init__(message)


class OutputExistsError(RetimeError, FileExistsError):
    """An output would overwrite a file, and nobody said that it may."""

    def __init__(self, path: str | PathLike[str]) -> None:
        self.path = fspath(path)
        super().__init__(f"{self.path}: exists already; choose another place or allow overwriting (--force)")


class MissingExtraError(RetimeError, ImportError):
    """An optional dependency is needed.

    Parameters
    ----------
    what : str
        What was asked for.
    package : str
        The package that could not be imported.
    extra : str
        The extra of retime that installs it.
    """

    def __init__(self, what: str, *, package: str, extra: str) -> None:
        self.package = package
        self.extra = extra
        super().__init__(f"{what} needs {package}, which is not installed: pip install 'retime[{extra}]'")


class MissingPageError(RetimeError, FileNotFoundError):
    """The editor's page was not built into this installation; the message says why, and how to get it."""


class RetimeWarning(UserWarning):
    """Something was assumed or repaired; the result may not be what was meant."""


class FormatWarning(RetimeWarning):
    """A file was read, but not quite as it says."""


def words_of(error: BaseException) -> str:
    """Say what went wrong, as people read it: of the system, what it refused and for which file.

    Examples
    --------
    >>> words_of(FileNotFoundError(2, "No such file or directory", "walk.bvh"))
    'walk.bvh: No such file or directory'
    """
    if isinstance(error, OSError) and error.strerror:
        return f"{fspath(error.filename)!s}: {error.strerror}" if error.filename else error.strerror
    return str(error) or type(error).__name__
