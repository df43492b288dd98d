"""A retime curve of another program is read as a warp."""

from __future__ import annotations

import warnings
from os import PathLike
from pathlib import Path

from retime.checks import path_of, real, whole
from retime.errors import FormatError, FormatWarning, OptionError
from retime.files import read_bytes
from retime.hosts.exporting import TOLERANCE
from retime.hosts.registry import HOSTS, IMPORTED, Host, host_by_ending, host_named
from retime.hosts.shot import Shot
from retime.motion.rate import RateLike, parse_rate
from retime.warp.curve import Warp

_MOST_BYTES = 1 << 26
# A clip of which neither input nor output has anything to show for so long is hardly meant.
_LATE_SECONDS = 1.0


def import_curve(
    path: str | PathLike[str],
    host: str | None = None,
    *,
    rate: RateLike | None = None,
    start: int | None = None,
    tolerance: float | None = None,
    item: str = "",
) -> Warp:
    r"""Read the retime curve of another program.

    Parameters
    ----------
    path : path-like
        The file.
    host : str, optional
        Which program's it is; left out, the ending tells.
    rate : float, Fraction or str, optional
        Frames a second that it counts, where the file itself does not say.
    start : int, optional
        The number of the frame at time 0, of input and output alike. Left out, the host's own custom.
    tolerance : float, optional
        Seconds that a line may be off where a rounded curve is drawn by lines; 0.001 where left out.
    item : str
        Which curve, where the file has several: the name of its node, layer or clip.

    Returns
    -------
    Warp
        To apply, to blend with others, or to be an example for `retime.imitate`.

    Raises
    ------
    FormatError
        It is no curve, or one that is no warp: times that don't increase, a jump, a spline that only its program knows;
        says where, and what would help.
    OptionError
        No such host, something is missing or would have no effect.
    OSError
        The file can't be opened.

    Warns
    -----
    FormatWarning
        The curve begins a second or more after the frame that counts as the first where `start` is left out.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     place = pathlib.Path(folder, "walk.framecurve.txt")
    ...     _ = place.write_text("1\t1.0\n25\t49.0\n")
    ...     import_curve(place, rate=24)
    Warp('walk.framecurve', output 0 to 1 s, input 0 to 2 s, 2 knots)
    """
    place = path_of(path, "import_curve(path)")
    found = _host(place, host)
    if rate is not None and found.says_rate:
        raise OptionError(f"--rate would have no effect: a file of {found.name} says itself how it counts")
    if start is not None and found.first_frame is None and not found.may_count_frames:
        raise OptionError(f"--start would have no effect: {found.name} counts from the beginning of its clip")
    if item and not found.takes_item:
        raise OptionError(f"--item would have no effect: a file of {found.name} holds one curve")
    if tolerance is not None and not found.bends:
        raise OptionError(f"--tolerance would have no effect: a curve of {found.name} has straight lines alone")
    allowed = TOLERANCE if tolerance is None else real(tolerance, "the tolerance")
    if not 0 <= allowed < float("inf"):
        raise OptionError(f"the tolerance must be 0 or more seconds, found {allowed}")
    number = found.first_frame or 0 if start is None else whole(start, "the first frame's number")
    said = tuple(option for option, value in (("--rate", rate), ("--start", start)) if value is not None)
    shot = Shot(None if rate is None else parse_rate(rate), number, item, allowed, said)
    data = read_bytes(place, _MOST_BYTES)
    try:
        warp = found.module.read(data, shot)
    except FormatError as error:
        raise FormatError(error.problem, path=place, line=error.line, column=error.column, byte=error.byte) from None
    if start is None and (found.first_frame is not None or (found.may_count_frames and rate is not None)):
        _warn_of_late_keys(warp, shot, place)
    return Warp(warp.output_times, warp.input_times, name=place.stem)


def _warn_of_late_keys(warp: Warp, shot: Shot, place: Path) -> None:
    """Warn where a curve is far from the first frame that nobody named: many shots begin at 1001."""
    late = min(warp.output_start, float(warp.input_times.min()))
    if late < _LATE_SECONDS:
        return
    number = "N" if shot.rate is None else str(round(shot.start + warp.output_start * float(shot.rate)))
    begins = "" if shot.rate is None else f" at frame {number}"
    warnings.warn(
        f"{place}: the curve begins{begins}, {warp.output_start:.4g} s after frame {shot.start}, which counts as the "
        f"shot's first: nobody says another. Where the shot begins with the curve, say so (--start {number})",
        FormatWarning,
        stacklevel=3,
    )


def _host(place: Path, name: str | None) -> Host:
    """Find whose curve it is."""
    if name is None:
        found = host_by_ending(place)
        if found is None:
            endings = ", ".join(f"{end} ({host.name})" for host in HOSTS if host.imports for end in host.suffixes)
            raise FormatError(
                f"what curve is this? Its ending is none of {endings}: name the host (--host)", path=place
            )
        return found
    host = host_named(name)
    if not host.imports:
        raise OptionError(f"a curve for {name} can be written, not read; read are {', '.join(IMPORTED)}")
    return host
