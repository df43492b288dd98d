"""What people type: times, lengths, ranges, speeds, keytimes and locks, in one grammar.

A bare number is seconds, for a time and for a length. The editor's page reads the same texts (`web/src/grammar.ts`);
`tests/grammar/table.json` says what each means or why it is refused, and the tests of both run it.

Some texts say more once the clip's rate is known: ``120f``, or a timecode. What `read_time`, `read_span`, `read_key`
and `read_lock` return is as written, to be refused early where its form is wrong; its method ``at`` takes the rate.
"""

from __future__ import annotations

import math
import numbers
import re
from dataclasses import dataclass
from fractions import Fraction

from retime.brief import text_of
from retime.errors import OptionError
from retime.motion.timecode import Timecode

# No time or length has more digits than these; Python would refuse, or overflow on, thousands of them.
_NUMBER = r"(?:\d{1,15}(?:\.\d{0,30})?|\.\d{1,30})"
_FLAGS = re.ASCII | re.IGNORECASE
_SECONDS = re.compile(rf"([+-]?{_NUMBER})\s*(s?)", _FLAGS)
_FRAMES = re.compile(rf"([+-]?{_NUMBER})\s*f", _FLAGS)
_CLOCK = re.compile(r"(?:(\d{1,9}):)?(\d{1,9}):(\d{1,2}(?:\.\d{0,30})?)", _FLAGS)
# In a drop-frame timecode some programs write a semicolon between all numbers.
_TIMECODE = re.compile(r"(\d{1,9})([:;])(\d{1,2})\2(\d{1,2})([:;])(\d{1,3})", _FLAGS)
_PERCENT = re.compile(rf"([+-]?{_NUMBER})\s*%", _FLAGS)
_SPEED = re.compile(rf"({_NUMBER})(?:\s*/\s*({_NUMBER}))?\s*[x×]?", _FLAGS)
_FRAME_RANGE = re.compile(r"(-?\d{1,15})?:(-?\d{1,15})?", _FLAGS)
# A range that is not written with two dots; the first letter may be the sign of a number.
_FROM_TO = re.compile(r"(.+?)(?:-|–|to)(.+)", _FLAGS)
_PLAIN = re.compile(_NUMBER, _FLAGS)
# No time, speed or count is larger; what is would overflow as a float.
_LARGEST = 10**100
# The longest clip at the highest rate that anybody has: a length that is too short for it is so for all.
_MANY_FRAMES, _HIGH_RATE = 10_000_000, Fraction(240)
# A bare length below this many seconds may have been meant as a factor.
_MOST_FACTOR = 5


@dataclass(frozen=True)
class WrittenTime:
    """A time as written: one of seconds, frames and a timecode.

    Attributes
    ----------
    text : str
        As it was written.
    seconds, frames : Fraction, optional
        Where it counts in those.
    timecode : Timecode, optional
        Where it is one.
    """

    text: str
    seconds: Fraction | None = None
    frames: Fraction | None = None
    timecode: Timecode | None = None

    @property
    def negative(self) -> bool:
        """Whether it lies before time 0."""
        return (self.seconds or self.frames or 0) < 0

    def at(self, rate: Fraction) -> Fraction:
        """Return the seconds that it says at a rate, exactly.

        Raises
        ------
        OptionError
            A timecode that this rate does not have.
        """
        if self.seconds is not None:
            return self.seconds
        if self.timecode is not None:
            return self.timecode.frame(rate) / rate
        assert self.frames is not None
        return self.frames / rate


def read_time(text: str | float) -> WrittenTime:
    """Read a time, of a clip whose rate is not known yet.

    Parameters
    ----------
    text : str or float
        Seconds (``2.5``, ``2.5s``, the number 2.5), frames (``120f``), a clock (``mm:ss.mmm``, ``hh:mm:ss.mmm``) or a
        timecode (``hh:mm:ss:ff``, drop-frame ``hh:mm:ss;ff``).

    Raises
    ------
    OptionError
        Not a time.

    Examples
    --------
    >>> read_time("00:00:03:15").at(Fraction(60))
    Fraction(13, 4)
    """
    return _read_time(text, "a time such as 2.5 (seconds), 120f, 1:02.500 or 00:01:02:12")


def _read_time(text: str | float, expected: str) -> WrittenTime:
    number = _plain_number(text)
    if number is not None:
        return WrittenTime(text_of(text), seconds=number)
    written = text_of(text).strip()
    if match := _SECONDS.fullmatch(written):
        return WrittenTime(written, seconds=Fraction(match[1]))
    if match := _FRAMES.fullmatch(written):
        return WrittenTime(written, frames=Fraction(match[1]))
    if match := _CLOCK.fullmatch(written):
        hours, minutes, seconds = int(match[1] or 0), int(match[2]), Fraction(match[3])
        _check_clock(minutes if match[1] else 0, seconds, written)
        return WrittenTime(written, seconds=3600 * hours + 60 * minutes + seconds)
    if (match := _TIMECODE.fullmatch(written)) and (match[2], match[5]) != (";", ":"):
        hours, minutes, whole, frames = (int(match[group]) for group in (1, 3, 4, 6))
        _check_clock(minutes, whole, written)
        return WrittenTime(written, timecode=Timecode(hours, minutes, whole, frames, match[5] == ";", written))
    raise OptionError(f"expected {expected}, found {_shown(text)}")


def _check_clock(minutes: int, seconds: int | Fraction, written: str) -> None:
    if minutes >= 60 or seconds >= 60:
        raise OptionError(f"minutes and seconds after a colon stay below 60, found {_shown(written)}")


def _plain_number(value: object) -> Fraction | None:
    """Return a number of 1e100 at most exactly (NumPy's too), or None for anything else."""
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        return None
    if isinstance(value, numbers.Rational):
        exact = Fraction(int(value.numerator), int(value.denominator))
    elif math.isfinite(value):
        exact = Fraction(float(value))
    else:
        return None
    return exact if abs(exact) <= _LARGEST else None


def _shown(value: object) -> str:
    return repr(text_of(value)[:60])


def parse_time(text: str | float, rate: Fraction) -> float:
    """Read a time of a clip: `read_time` at its rate.

    Parameters
    ----------
    text : str or float
        A number means seconds.
    rate : Fraction
        Frames a second, for frames (120f is frame 120 counted from 0) and timecodes.

    Returns
    -------
    float
        Seconds.

    Raises
    ------
    OptionError
        Not a time, or a timecode that this rate does not have.

    Examples
    --------
    >>> parse_time("60f", Fraction(120)), parse_time("1:02.5", Fraction(120)), parse_time(8, Fraction(120))
    (0.5, 62.5, 8.0)
    """
    return float(read_time(text).at(rate))


def parse_length(text: str | float, n_frames: int, rate: Fraction) -> int:
    """Read a length: seconds (``9.3``, ``9.3s``), a share of the input (``65%``), frames, a clock or a timecode.

    A clip of n frames lasts n / rate seconds: its last frame is shown for a frame period too.

    Parameters
    ----------
    text : str or float
        The length. A float means seconds, as bare text does. An int is refused: it meant frames once, and must not
        change its meaning without a word.
    n_frames : int
        Frames of the input, for ``65%``.
    rate : Fraction
        Frames a second.

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
    >>> parse_length("65%", 1980, Fraction(120)), parse_length(9.3, 1980, Fraction(120))
    (1287, 1116)
    """
    if isinstance(text, numbers.Integral) and not isinstance(text, bool):
        shown = text_of(text)[:60]
        raise OptionError(
            f'a length of {shown} could mean frames or seconds: write "{shown}f" for frames, or "{shown}s" for seconds'
        )
    if match := _PERCENT.fullmatch(text_of(text).strip()):
        length = round(Fraction(match[1]) / 100 * n_frames)
    else:
        time = _read_time(text, "a length such as 65%, 9.3 (seconds), 280f or 0:09.300")
        if time.frames is not None and time.frames.denominator != 1:
            raise OptionError(f"a length is a whole number of frames, found {_shown(text)}")
        length = round(time.at(rate) * rate)
    if length < 2:
        raise OptionError(
            f"a length of {text_of(text).strip()} is {length} frame{'s' * (length != 1)}; the output needs at least 2"
            f"{factor_hint(text)}"
        )
    return length


def check_length(text: str) -> str:
    """Refuse what is no length for any clip: neither ``free`` nor, at any rate, two frames or more.

    Raises
    ------
    OptionError
        Not a length.
    """
    # Only the clip's rate tells whether it has such a timecode.
    if text != "free" and not _TIMECODE.fullmatch(text.strip()):
        parse_length(text, _MANY_FRAMES, _HIGH_RATE)
    return text


def factor_hint(length: object) -> str:
    """Ask whether a share was meant, where a bare length is so short that it may be a factor.

    Returns
    -------
    str
        To go at the end of a message that refuses it; empty where there is nothing to ask.

    Examples
    --------
    >>> factor_hint("0.65"), factor_hint("0.65s")
    (' (did you mean 65%?)', '')
    """
    number = _plain_number(length)
    if number is None and isinstance(length, str) and _PLAIN.fullmatch(length.strip()):
        number = Fraction(length.strip())
    if number is None or not 0 < number < _MOST_FACTOR:
        return ""
    return f" (did you mean {float(number * 100):g}%?)"


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
    match = _FRAME_RANGE.fullmatch(text.strip())
    if match is None:
        raise OptionError(f"expected a range of frames such as 1:1980, found {_shown(text)}")
    last_frame = first_frame + n_frames - 1
    first = first_frame if match[1] is None else int(match[1])
    last = last_frame if match[2] is None else int(match[2])
    if not first_frame <= first <= last <= last_frame:
        raise OptionError(f"frames {text} are not inside the clip, whose frames are {first_frame}:{last_frame}")
    return first - first_frame, last - first_frame + 1


def parse_speed(text: str | float) -> float:
    """Read a playback speed: ``2``, ``0.5``, ``1/4``, ``1.5x``, ``150%``.

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
    >>> parse_speed("1/4"), parse_speed("150%")
    (0.25, 1.5)
    """
    speed = _plain_number(text)
    written = text_of(text).strip()
    if (match := _SPEED.fullmatch(written)) and (match[2] is None or Fraction(match[2]) > 0):
        speed = Fraction(match[1]) / Fraction(match[2] or 1)
    elif match := _PERCENT.fullmatch(written):
        speed = Fraction(match[1]) / 100
    if speed is None or float(speed) <= 0:
        raise OptionError(f"expected a playback speed such as 2, 0.5, 1/4 or 150%, found {_shown(text)}")
    return float(speed)


def parse_speeds(text: str | float) -> tuple[float, float]:
    """Read a range of playback speeds: ``1/4..8``, ``0.5-2``, ``..2``, one speed, or ``uncut``.

    Returns
    -------
    slowest, fastest : float
        0 and inf where left out. ``uncut`` is 0 to 1: slowed down at most.

    Raises
    ------
    OptionError
        Not a range of speeds above 0, the slowest first.

    Examples
    --------
    >>> parse_speeds("1/4..8"), parse_speeds("1"), parse_speeds("uncut")
    ((0.25, 8.0), (1.0, 1.0), (0.0, 1.0))
    """
    written = text_of(text).strip()
    if written.lower() == "uncut":
        return 0.0, 1.0
    ends = _ends(written)
    if ends is None:
        speed = parse_speed(text)
        return speed, speed
    low, high = ends
    slowest = parse_speed(low) if low not in ("", "0") else 0.0
    fastest = parse_speed(high) if high else math.inf
    if slowest > fastest:
        raise OptionError(f"a range of speeds has the slowest first, found {_shown(text)}")
    return slowest, fastest


def _ends(text: str) -> tuple[str, str] | None:
    """Split a range at its sign; either end may be left out where that is two dots."""
    low, dots, high = text.partition("..")
    if not dots:
        match = _FROM_TO.fullmatch(text)
        if match is None:
            return None
        low, high = match[1], match[2]
    return low.strip(), high.strip()


@dataclass(frozen=True)
class WrittenSpan:
    """A span of input time as written.

    Attributes
    ----------
    text : str
        As it was written.
    start, end : WrittenTime
        Input times.
    """

    text: str
    start: WrittenTime
    end: WrittenTime

    def at(self, rate: Fraction) -> tuple[float, float]:
        """Return start and end in seconds.

        Raises
        ------
        OptionError
            At this rate it does not begin before it ends.
        """
        start, end = self.start.at(rate), self.end.at(rate)
        if not start < end:
            raise OptionError(f"a span begins before it ends, found {_shown(self.text)}")
        return float(start), float(end)


def read_span(text: str) -> WrittenSpan:
    """Read a span of input time: ``2.1..3.4``, ``60f-90f``, ``0:02 to 0:03.5``.

    Raises
    ------
    OptionError
        Not two times.
    """
    ends = _ends(text.strip())
    if ends is None:
        raise OptionError(f"expected a span of input time such as 2.1..3.4 or 60f..90f, found {_shown(text)}")
    return WrittenSpan(text, read_time(ends[0]), read_time(ends[1]))


@dataclass(frozen=True)
class WrittenLock:
    """A span of input time and its speeds, as written.

    Attributes
    ----------
    span : WrittenSpan
        Where it holds.
    slowest, fastest : float
        Playback speeds; equal ones fix the speed.
    """

    span: WrittenSpan
    slowest: float = 1.0
    fastest: float = 1.0

    def at(self, rate: Fraction) -> tuple[float, float, float, float]:
        """Return start and end in seconds, and the speeds."""
        return (*self.span.at(rate), self.slowest, self.fastest)


def read_lock(text: str) -> WrittenLock:
    """Read a lock: a span of input time, and the speed or the range of speeds at which it plays (1 where left out).

    Raises
    ------
    OptionError
        No lock, or one without a fastest speed.

    Examples
    --------
    >>> read_lock("60f..90f=1/2..1").at(Fraction(30))
    (2.0, 3.0, 0.5, 1.0)
    """
    span, sign, speeds = text.partition("=")
    written = read_span(span)
    slowest, fastest = parse_speeds(speeds) if sign else (1.0, 1.0)
    if fastest == math.inf:
        raise OptionError(f"a lock needs a fastest speed, as in 1/2..2, found {_shown(text)}")
    return WrittenLock(written, slowest, fastest)


@dataclass(frozen=True)
class WrittenKey:
    """A keytime as written.

    Attributes
    ----------
    input_time, output_time : WrittenTime
        Not below 0.
    speed : float, optional
        A tangent.
    """

    input_time: WrittenTime
    output_time: WrittenTime
    speed: float | None = None

    def at(self, rate: Fraction) -> tuple[float, float] | tuple[float, float, float]:
        """Return input time and output time in seconds, and the speed where there is one."""
        pair = float(self.input_time.at(rate)), float(self.output_time.at(rate))
        return pair if self.speed is None else (*pair, self.speed)


def read_key(text: str) -> WrittenKey:
    """Read a keytime ``IN=OUT`` or ``IN=OUT@SPEED``.

    Raises
    ------
    OptionError
        No keytime, or one before time 0.

    Examples
    --------
    >>> read_key("00:00:05:00=3.25@1/2").at(Fraction(60))
    (5.0, 3.25, 0.5)
    """
    input_text, sign, rest = text.partition("=")
    output_text, at, speed = rest.partition("@")
    if not sign:
        raise OptionError(f"expected input time = output time, such as 2.5=1.8 or 300f=0:01.800, found {_shown(text)}")
    input_time, output_time = read_time(input_text), read_time(output_text)
    if input_time.negative or output_time.negative:
        raise OptionError(f"input and output begin at time 0, found {_shown(text)}")
    return WrittenKey(input_time, output_time, parse_speed(speed) if at else None)


def parse_share(text: str | float) -> float:
    """Read a share of 1: ``0.5`` or ``50%``.

    Raises
    ------
    OptionError
        Not a number from 0 to 1.

    Examples
    --------
    >>> parse_share("50%")
    0.5
    """
    share = _plain_number(text)
    written = text_of(text).strip()
    if _PLAIN.fullmatch(written):
        share = Fraction(written)
    elif match := _PERCENT.fullmatch(written):
        share = Fraction(match[1]) / 100
    if share is None or not 0 <= share <= 1:
        raise OptionError(f"expected a share from 0 to 1, or 0% to 100%, found {_shown(text)}")
    return float(share)


def parse_number(
    text: str | float, *, least: float = 0.0, above: bool = False, whole: bool = False, unit: str = ""
) -> float:
    """Read a plain number with a lower bound.

    Parameters
    ----------
    text : str or float
        Digits, with a decimal point; no exponent.
    least : float
        The lower bound.
    above : bool
        Whether the bound itself is refused.
    whole : bool
        Whether only whole numbers are taken.
    unit : str
        May stand after the number.

    Raises
    ------
    OptionError
        Not such a number.

    Examples
    --------
    >>> parse_number("4 Hz", unit="Hz"), parse_number("2x", unit="x", above=True)
    (4.0, 2.0)
    """
    number = _plain_number(text)
    # How people write "times".
    written = text_of(text).strip().replace("×", "x")
    if unit and written.lower().endswith(unit.lower()):
        written = written[: -len(unit)].rstrip()
    if _PLAIN.fullmatch(written):
        number = Fraction(written)
    if number is None or number < least or (above and number == least) or (whole and number.denominator != 1):
        kind = "a whole number" if whole else "a plain number"
        bound = f"above {least:g}" if above else f"of at least {least:g}"
        raise OptionError(f"expected {kind} {bound}, found {_shown(text)}")
    return float(number)
