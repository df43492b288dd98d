"""Times, lengths and frame ranges as people write them."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from numbers import Integral, Real

from retime.errors import OptionError

# No time or length has more digits than these; Python would refuse, or overflow on, thousands of them.
_NUMBER = r"[+-]?(?:\d{1,15}(?:\.\d{0,30})?|\.\d{1,30})"
_SECONDS = re.compile(rf"({_NUMBER})\s*s?", re.ASCII)
_FRAMES = re.compile(r"([+-]?\d{1,15})\s*f", re.ASCII)
_CLOCK = re.compile(r"(?:(\d{1,9}):)?(\d{1,9}):(\d{1,2}(?:\.\d{0,30})?)", re.ASCII)
_PERCENT = re.compile(rf"({_NUMBER})\s*%", re.ASCII)
_RANGE = re.compile(r"(-?\d{1,15})?:(-?\d{1,15})?", re.ASCII)


def parse_time(text: str | float, rate: Fraction) -> float:
    """Read a time: seconds (``2.5`` or ``2.5s``), frames (``120f``), or a clock (``mm:ss.mmm``, ``h:mm:ss``).

    Parameters
    ----------
    text : str or float
        A number means seconds.
    rate : Fraction
        Frames a second, for ``120f``: frame 120 counted from 0.

    Returns
    -------
    float
        Seconds.

    Raises
    ------
    OptionError
        Not a time.

    Examples
    --------
    >>> parse_time("60f", Fraction(120)), parse_time("1:02.5", Fraction(120))
    (0.5, 62.5)
    """
    if isinstance(text, Real) and not isinstance(text, bool) and math.isfinite(text):
        return float(text)
    written = str(text).strip()
    if match := _SECONDS.fullmatch(written):
        return float(match[1])
    if match := _FRAMES.fullmatch(written):
        return float(int(match[1]) / rate)
    if (match := _CLOCK.fullmatch(written)) and float(match[3]) < 60 and (match[1] is None or int(match[2]) < 60):
        return int(match[1] or 0) * 3600 + int(match[2]) * 60 + float(match[3])
    raise OptionError(f"expected a time such as 2.5s, 120f or 1:02.500, found {text!r}")


def parse_length(text: str | int, n_frames: int, rate: Fraction) -> int:
    """Read a length: frames (``280f`` or the int 280), seconds (``9.3s``) or a share of the input (``65%``).

    A clip of n frames lasts n / rate seconds: its last frame is shown for a frame period too.

    Parameters
    ----------
    text : str or int
        The length.
    n_frames : int
        Frames of the input, for ``65%``.
    rate : Fraction
        Frames a second, for ``9.3s``.

    Returns
    -------
    int
        Frames, at least 2.

    Raises
    ------
    OptionError
        Not a length, or one below two frames.

    Examples
    --------
    >>> parse_length("65%", 1980, Fraction(120)), parse_length("9.3s", 1980, Fraction(120))
    (1287, 1116)
    """
    written = str(text).strip()
    if isinstance(text, Integral) and not isinstance(text, bool):
        length = int(text)
    elif match := _PERCENT.fullmatch(written):
        length = round(Fraction(match[1]) / 100 * n_frames)
    elif match := _FRAMES.fullmatch(written):
        length = int(match[1])
    elif (match := _SECONDS.fullmatch(written)) and written.endswith("s"):
        length = round(Fraction(match[1]) * rate)
    else:
        raise OptionError(f"expected a length such as 65%, 9.3s or 280f, found {text!r}")
    if length < 2:
        raise OptionError(f"a length of {text} is {length} frame{'s' * (length != 1)}; the output needs at least 2")
    return length


def parse_frame_range(text: str, n_frames: int, first_frame: int = 0) -> tuple[int, int]:
    """Read a range of frames ``A:B``, both included, by the numbers that the file gives them.

    Parameters
    ----------
    text : str
        ``1:1980``, ``:500``, ``100:``.
    n_frames : int
        Frames there are.
    first_frame : int
        Number of the first one (AMC counts from 1, BVH from 0).

    Returns
    -------
    start, stop : int
        Half-open, counted from 0.

    Raises
    ------
    OptionError
        Not a range, or one that leaves the clip.
    """
    match = _RANGE.fullmatch(text.strip())
    if match is None:
        raise OptionError(f"expected a range of frames such as 1:1980, found {text!r}")
    last_frame = first_frame + n_frames - 1
    first = first_frame if match[1] is None else int(match[1])
    last = last_frame if match[2] is None else int(match[2])
    if not first_frame <= first <= last <= last_frame:
        raise OptionError(f"frames {text} are not inside the clip, whose frames are {first_frame}:{last_frame}")
    return first - first_frame, last - first_frame + 1


_SPEED = re.compile(rf"({_NUMBER})(?:/(\d+(?:\.\d*)?))?x?", re.ASCII)


def parse_speed(text: str | float) -> float:
    """Read a playback speed: ``2``, ``0.5``, ``1/4``, ``1.5x``.

    Returns
    -------
    float
        Above 0.

    Raises
    ------
    OptionError
        Not a speed above 0.

    Examples
    --------
    >>> parse_speed("1/4")
    0.25
    """
    match = _SPEED.fullmatch(str(text).strip())
    if match is None or float(match[1]) <= 0 or (match[2] is not None and float(match[2]) == 0):
        raise OptionError(f"expected a playback speed such as 2, 0.5 or 1/4, found {text!r}")
    return float(match[1]) / float(match[2] or 1)


def parse_speeds(text: str | float) -> tuple[float, float]:
    """Read a range of playback speeds, ``1/4..8``, or one speed; either end may be left out (``..2``).

    Returns
    -------
    slowest, fastest : float
        0 and inf where left out.

    Examples
    --------
    >>> parse_speeds("1/4..8"), parse_speeds("1")
    ((0.25, 8.0), (1.0, 1.0))
    """
    low, dots, high = str(text).strip().partition("..")
    if not dots:
        speed = parse_speed(text)
        return speed, speed
    slowest = parse_speed(low) if low else 0.0
    fastest = parse_speed(high) if high else math.inf
    if slowest > fastest:
        raise OptionError(f"a range of speeds has the slowest first; found {text!r}")
    return slowest, fastest
