"""A warp is written for a host, read back from what was written, and compared."""

from __future__ import annotations

from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.checks import path_of, real, whole
from retime.errors import FormatError, OptionError
from retime.files import write_bytes
from retime.hosts.checks import check_warp
from retime.hosts.registry import Host, host_named
from retime.hosts.shot import MOST_KEYS, Shot
from retime.motion.rate import RateLike, parse_rate
from retime.warp.curve import Warp, WarpLike, as_warp

TOLERANCE = 0.001
"""Seconds that fewer keys may be off."""

# Seconds: no program shows what changes so soon.
_CLOSE = 1e-4


@dataclass(frozen=True)
class ExportedCurve:
    """What was written, and how far it is from the warp.

    Attributes
    ----------
    host : str
        For which.
    keys : int
        Of the curve.
    error : float
        Seconds: the furthest that the curve, read back from the file, shows another input time than the warp; at the
        output's frames where the host counts frames, and at every key of both where it draws lines between them. Where
        the file says which whole frame is shown (ffmpeg, MLT, the list), it is of that frame.
    error_frames : float, optional
        The same in frames; None where no rate was named.
    """

    host: str
    keys: int
    error: float
    error_frames: float | None

    @property
    def error_text(self) -> str:
        """How far it is off, in words."""
        said = f"{_shown(self.error * 1000)} ms"
        if self.error_frames is not None:
            said = f"{_shown(self.error_frames)} frames, {said}"
        return f"{said} at most, read back from the file"


def _shown(error: float) -> str:
    return f"{error:.3g}" if error == 0 or error >= 1e-6 else "under 0.000001"


def export_curve(
    warp: WarpLike,
    path: str | PathLike[str],
    host: str,
    *,
    rate: RateLike | None = None,
    start: int | None = None,
    tolerance: float | None = None,
    item: str = "",
    overwrite: bool = False,
) -> ExportedCurve:
    """Write the retime curve that another program plays a warp by.

    Parameters
    ----------
    warp : Warp or GuidedWarp
        The warp.
    path : path-like
        The file; its ending is one of the host's.
    host : str
        The program: "nuke", "maya", ...; `retime.hosts.registry.HOSTS` lists them.
    rate : float, Fraction or str, optional
        Frames a second of the shot; needed but for hosts that count seconds.
    start : int, optional
        The number of the shot's first frame, of input and output alike. Left out, the host's own custom.
    tolerance : float, optional
        Seconds that the curve may be off to do with fewer keys; 0.001 where left out.
    item : str
        The node, layer, clip or prim that it is for.
    overwrite : bool
        Replace a file that is there.

    Returns
    -------
    ExportedCurve
        The error of what was written, read back.

    Raises
    ------
    OptionError
        No such host, something that it needs is missing or that it can't use was given, or the warp holds, runs
        backward or begins where the host can't; says what would do.
    FormatError
        The file's name ends as no file of the host does.
    OutputExistsError, OSError
        It can't be written.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> warp = Warp([0.0, 1.0, 2.0], [0.0, 2.0, 3.0])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     done = export_curve(warp, pathlib.Path(folder, "walk.nk"), "nuke", rate=24)
    >>> done.keys, done.error_frames < 1e-6
    (49, True)
    """
    warp = as_warp(warp, "export_curve(warp, path, host)")
    place = path_of(path, "export_curve(warp, path, host)")
    found = host_named(host)
    text, done = curve_text(warp, place, found, rate=rate, start=start, tolerance=tolerance, item=item)
    write_bytes(place, text.encode(), overwrite=overwrite)
    return done


def curve_text(
    warp: Warp,
    place: Path,
    host: Host,
    *,
    rate: RateLike | None,
    start: int | None,
    tolerance: float | None,
    item: str,
) -> tuple[str, ExportedCurve]:
    """Return what `export_curve` writes, and what it says of it."""
    shot = _shot(host, rate, start, tolerance, item)
    _check_ending(host, place, item)
    check_warp(host, warp)
    if (host.every_frame or host.whole_frames) and shot.count_frames(warp) < 2:
        raise OptionError(
            f"the output is a single frame at {float(shot.exact_rate):g} frames a second, in which nothing is retimed; "
            "name a higher rate (--rate)"
        )
    if host.every_frame:
        keyed = shot.on_frames(warp)
    else:
        keyed = (shot.on_frames(warp) if host.whole_frames else warp).simplify(shot.tolerance)
    if len(keyed.output_times) > MOST_KEYS:
        raise OptionError(
            f"the curve has {len(keyed.output_times)} keys, the most is {MOST_KEYS}; allow a larger error (--tolerance)"
        )
    text = host.module.write(keyed, shot)
    # The file has one curve; what it is for is no name to look for.
    try:
        back = host.module.read(text.encode(), replace(shot, item=""))
    except FormatError as error:
        gap = float(np.diff(keyed.output_times).min())
        if gap < _CLOSE:
            raise OptionError(
                f"{host.name} can't hold this warp: two of its knots are {gap:.2g} s apart, which the digits of its "
                "file don't tell; allow a larger error (--tolerance), or take a format with more digits (--host csv)"
            ) from None
        raise OptionError(f"{host.name} can't hold this warp: read back, {error.problem}") from None
    off = _worst(warp, back, host, shot)
    return text, ExportedCurve(
        host.name, len(keyed.output_times), off, None if shot.rate is None else off * float(shot.rate)
    )


def _shot(host: Host, rate: RateLike | None, start: int | None, tolerance: float | None, item: str) -> Shot:
    """Check what a host is told."""
    if rate is None and host.needs_rate:
        raise OptionError(f"{host.name} counts frames, a warp seconds: name the shot's frames a second (--rate)")
    if start is not None and host.first_frame is None:
        raise OptionError(f"--start would have no effect: {host.name} counts from the beginning of its clip")
    if tolerance is not None and host.every_frame:
        raise OptionError(f"--tolerance would have no effect: {host.name} gets the exact time of every frame")
    if item and not host.takes_item:
        raise OptionError(f"--item would have no effect: for {host.name} there is nothing to name")
    if not item and host.needs_item:
        raise OptionError(f"{host.name} needs --item: {host.takes_item}")
    if item and not item.strip():
        raise OptionError("--item is blank: leave it out, or name what the curve is for")
    if not item.isprintable():
        raise OptionError("--item holds a letter that can't be printed: no program has such a name")
    allowed = TOLERANCE if tolerance is None else real(tolerance, "the tolerance")
    number = host.first_frame or 0 if start is None else whole(start, "the first frame's number")
    if abs(number) > MOST_KEYS * 1000:
        raise OptionError(f"no shot begins at frame {number}")
    return Shot(None if rate is None else parse_rate(rate), number, item, allowed)


def _check_ending(host: Host, place: Path, item: str) -> None:
    """Refuse a name that the program would not open."""
    endings = host.suffixes
    if host.name == "maya":
        # A scene can't reach curves of another; a script in it can.
        endings = (".py",) if item else (".ma",)
    if place.suffix.lower() not in endings:
        what = " (with --item, a script)" if host.name == "maya" and item else ""
        raise FormatError(f"a file for {host.name} ends in {' or '.join(endings)}{what}", path=place)


def _worst(warp: Warp, back: Warp, host: Host, shot: Shot) -> float:
    """Return the largest difference of input times, seconds."""
    if host.picks:
        at, rate = shot.on_frames(warp).output_times, float(shot.exact_rate)
        shown = np.floor(back(at) * rate + (0.5 if host.picks == "nearest" else 0.0)) / rate
        return float(np.abs(warp(at) - shown).max())
    times: list[FloatArray] = []
    if shot.rate is not None:
        times.append(shot.on_frames(warp).output_times)
    if not host.every_frame and not host.whole_frames:
        times += [warp.output_times, back.output_times]
    at = np.concatenate(times)
    return float(np.abs(warp(at) - back(at)).max())
