"""Times written as text: timecodes, dates, times of day; to seconds, and back in the form that they had."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import date
from fractions import Fraction
from itertools import pairwise

import numpy as np

from retime.motion.clock import ClockForm

_TIMECODE = re.compile(r"(\d{1,2}):([0-5]\d):([0-5]\d)([:;])(\d{2,3})(?:\.(\d{1,9}))?", re.ASCII)
_DATE = re.compile(
    r"(?:(\d{4})-(\d\d)-(\d\d)([T ]))?(\d{1,2}):([0-5]\d):([0-5]\d)(?:([.,])(\d{1,9}))?( ?(?:Z|UTC|[+-]\d\d:?\d\d))?",
    re.ASCII,
)
_BASES = (24, 25, 30, 48, 50, 60, 72, 90, 100, 120, 240)
_DAY = 86400
_EPOCH = date(1970, 1, 1).toordinal()


@dataclass(frozen=True)
class TextTimes:
    """A column of times that are text.

    Attributes
    ----------
    seconds : list of Fraction
        Of each row, rising over midnight.
    unit : Fraction
        Seconds that one in the last place stands for.
    base : int
        Frames that a timecode counts to its second; else 0.
    pace : Fraction
        Seconds that pass while it counts one: of drop-frame timecode 1001/1000, else 1.
    guessed : bool
        Whether `base` is only what is usual: no second ends among the rows, and nobody said the rate.
    """

    seconds: list[Fraction]
    unit: Fraction
    base: int = 0
    pace: Fraction = Fraction(1)
    guessed: bool = False


def form_of_text(cell: str) -> ClockForm | None:
    """Tell timecodes from dates and times of day; None where a cell is neither.

    Examples
    --------
    >>> [form_of_text(cell) for cell in ("10:00:04:04.652", "2024-05-01T10:00:04.5Z", "10:00:04", "4.5")]
    ['timecode', 'date', 'date', None]
    """
    if _TIMECODE.fullmatch(cell):
        return "timecode"
    match = _DATE.fullmatch(cell)
    return "date" if match and (match[1] is None or _day(match) is not None) else None


def parse_texts(texts: Sequence[str], form: ClockForm, *, rate: Fraction | None) -> TextTimes:
    """Find the seconds of times that `form_of_text` knows.

    Parameters
    ----------
    texts : sequence of str
        The times.
    form : {"timecode", "date"}
        What they are.
    rate : Fraction, optional
        Frames a second, where that is known: it helps to tell how many frames a timecode counts to its second.
    """
    if form == "timecode":
        return _timecodes(texts, rate)
    seconds = []
    digits = 0
    for text in texts:
        match = _matched(_DATE, text)
        days = _day(match) or 0
        digits = max(digits, len(match[9] or ""))
        clock = 3600 * int(match[5]) + 60 * int(match[6]) + int(match[7])
        seconds.append(_DAY * days + clock + Fraction(int(match[9] or 0), 10 ** len(match[9] or "")))
    return TextTimes(_over_midnight(seconds), Fraction(1, 10**digits))


def _matched(pattern: re.Pattern[str], text: str) -> re.Match[str]:
    match = pattern.fullmatch(text)
    assert match is not None, "the reader checked it"
    return match


def _day(match: re.Match[str]) -> int | None:
    """Count the days since 1970; None where there is no date, or no such day."""
    if match[1] is None:
        return None
    try:
        return date(int(match[1]), int(match[2]), int(match[3])).toordinal() - _EPOCH
    except ValueError:
        return None


def _over_midnight(seconds: list[Fraction]) -> list[Fraction]:
    """Add a day where the clock went from its end to its start."""
    days = 0
    unwrapped = seconds[:1]
    for before, after in pairwise(seconds):
        days += after - before < -_DAY // 2
        unwrapped.append(after + _DAY * days)
    return unwrapped


def _timecodes(texts: Sequence[str], rate: Fraction | None) -> TextTimes:
    matches = [_matched(_TIMECODE, text) for text in texts]
    whole = [3600 * int(match[1]) + 60 * int(match[2]) + int(match[3]) for match in matches]
    frames = [Fraction(int(match[5])) + Fraction(int(match[6] or 0), 10 ** len(match[6] or "")) for match in matches]
    drop = any(match[4] == ";" for match in matches)
    base = _base(whole, frames, rate, drop=drop)
    pace = Fraction(1001, 1000) if drop and base % 30 == 0 else Fraction(1)
    seconds = []
    for second, frame in zip(_over_midnight([Fraction(second) for second in whole]), frames, strict=True):
        count = second * base + frame
        if pace != 1:
            minutes = int(second) // 60
            count -= base // 15 * (minutes - minutes // 10)
        seconds.append(count * pace / base)
    digits = max(len(match[6] or "") for match in matches)
    guessed = len(set(whole)) == 1 and (rate is None or round(rate) % base != 0) and not drop
    return TextTimes(seconds, pace / base / 10**digits, base, pace, guessed)


def _base(whole: Sequence[int], frames: Sequence[Fraction], rate: Fraction | None, *, drop: bool) -> int:
    """Tell how many frames a timecode counts to its second: as many as make its steps most even.

    Where no second ends among the rows, every count does so; then it is the rate, or else the smallest that is usual.
    """
    largest = int(max(frames))
    counts = [base for base in _BASES if base > largest and (not drop or base in (30, 60))] or [largest + 1]
    seconds, parts = np.array(whole, dtype=np.float64), np.array([float(frame) for frame in frames])
    told = None if rate is None else round(rate)

    def unevenness(base: int) -> tuple[float, bool, int]:
        steps = np.diff((seconds - seconds[0]) % _DAY * base + parts)
        uneven = float(np.abs(steps - np.median(steps)).sum()) if len(steps) else 0.0
        return (round(uneven, 6), base != told, base)

    return min(counts, key=unevenness)


def text_writer(sample: str, base: int, rate: Fraction) -> tuple[Fraction, Callable[[int], str]]:
    """Return how many parts of a second are counted, and what writes a time, in those parts, as `sample` is written.

    Parameters
    ----------
    sample : str
        A time that `form_of_text` knows.
    base : int
        Frames that a timecode counts to its second.
    rate : Fraction
        Frames a second that the times shall show.
    """
    timecode = _TIMECODE.fullmatch(sample)
    if timecode is not None:
        return _timecode_writer(timecode, base, rate)
    match = _matched(_DATE, sample)
    digits = len(match[9] or "")
    # Rows that follow one another must differ, and clearly.
    while digits < 9 and Fraction(10) ** digits < 4 * rate:
        digits += 1
    point, zone, between = match[8] or ".", match[10] or "", match[4]

    def write(parts: int) -> str:
        second, part = divmod(parts, 10**digits)
        day, clock = divmod(second, _DAY)
        dated = f"{date.fromordinal(_EPOCH + day)}{between}" if between else ""
        decimals = f"{point}{part:0{digits}d}" if digits else ""
        return f"{dated}{clock // 3600:02d}:{clock // 60 % 60:02d}:{clock % 60:02d}{decimals}{zone}"

    return Fraction(10**digits), write


def _timecode_writer(sample: re.Match[str], base: int, rate: Fraction) -> tuple[Fraction, Callable[[int], str]]:
    drop = sample[4] == ";" and base % 30 == 0
    digits = len(sample[6] or "")
    counted = Fraction(base * 1000, 1001) if drop else Fraction(base)
    # Where frames don't stand on those of the timecode, only parts of them can tell when they are.
    if not digits and (counted / rate).denominator != 1:
        digits = 3

    def write(parts: int) -> str:
        frame, part = divmod(parts, 10**digits)
        if drop:
            ten_minutes, skipped = base * 600 - 9 * (base // 15), base // 15
            tens, rest = divmod(frame, ten_minutes)
            minutes = 0 if rest < base * 60 else 1 + (rest - base * 60) // (base * 60 - skipped)
            frame += skipped * (9 * tens + minutes)
        second, frame = divmod(frame, base)
        decimals = f".{part:0{digits}d}" if digits else ""
        width = max(2, len(sample[5]))
        hour = second // 3600 % 24
        return f"{hour:02d}:{second // 60 % 60:02d}:{second % 60:02d}{sample[4]}{frame:0{width}d}{decimals}"

    return counted * 10**digits, write
