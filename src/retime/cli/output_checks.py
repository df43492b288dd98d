"""Checks of the files that a command is to write: what can be refused is refused before the long work."""

from __future__ import annotations

import errno
import importlib.util
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from retime.errors import FormatError, MissingExtraError, OptionError, OutputExistsError
from retime.evaluate.plot.style import PLOT_SUFFIXES
from retime.file_names import name_key


def check_outputs(outputs: Mapping[str, Path | None], *, inputs: Iterable[Path], force: bool) -> None:
    """Refuse outputs that could not be written, or would destroy something.

    Parameters
    ----------
    outputs : mapping of str to Path
        What each one is called in messages (its option), and its place; None is left out.
    inputs : iterable of Path
        Files that are read.
    force : bool
        Files that are there may be replaced. An input never is.

    Raises
    ------
    OptionError
        An output is an input, or two are one file.
    OutputExistsError
        One is there already, and `force` is not set.
    OSError
        Its folder is missing or can't be written, or it is a folder itself.
    """
    sources = list(inputs)
    taken: dict[str, str] = {}
    for option, place in outputs.items():
        if place is None:
            continue
        folder = place.parent
        if not folder.exists():
            raise FileNotFoundError(errno.ENOENT, f"{option}: there is no folder {folder}; make it first", str(place))
        if not folder.is_dir():
            raise NotADirectoryError(errno.ENOTDIR, f"{option}: {folder} is not a folder", str(place))
        if place.is_dir():
            raise IsADirectoryError(errno.EISDIR, f"{option}: this is a folder; name a file in it", str(place))
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PermissionError(errno.EACCES, f"{option}: the folder {folder} can't be written", str(place))
        for source in sources:
            if _same_file(place, source):
                raise OptionError(f"{option} {place} is the input; choose another place, an input is never overwritten")
        real = name_key(os.path.realpath(place))
        if real in taken:
            raise OptionError(f"{option} and {taken[real]} name the same file, {place}")
        taken[real] = option
        if not force and place.exists():
            raise OutputExistsError(place)


def check_format(place: Path, *, like: Path, arrays: Sequence[str] = ()) -> None:
    """Refuse a place whose format can't hold what another file, or these arrays of it, hold; raise FormatError."""
    from retime.formats.compressed import refuse_compressed
    from retime.formats.registry import stays_in_place
    from retime.media.kinds import is_media

    if is_media(like):
        if not is_media(place):
            raise FormatError(f"{like} is video, pictures or sound, and {place.suffix or place} is not", path=place)
        return
    if stays_in_place(like, place, arrays=arrays) is not None:
        refuse_compressed(place)
        return
    check_holds_like(place, like, arrays)


def check_holds_like(place: Path, like: Path, arrays: Sequence[str] = ()) -> None:
    """Refuse a place whose format can't hold anew what another file holds; raise FormatError."""
    from retime.formats.registry import check_holds, format_in

    check_holds(place, format_in(like, arrays=arrays).holds, like=str(like))


def check_plot(place: Path) -> None:
    """Refuse a picture that could not be drawn; raise OptionError or MissingExtraError."""
    if place.suffix.lower() not in PLOT_SUFFIXES:
        raise OptionError(f"a picture is {' or '.join(PLOT_SUFFIXES)}; found {place}")
    if importlib.util.find_spec("matplotlib") is None:
        raise MissingExtraError("a picture", package="matplotlib", extra="plot")


def _same_file(a: Path, b: Path) -> bool:
    try:
        return a.samefile(b)
    except OSError:
        return os.path.realpath(a) == os.path.realpath(b)
