"""Exact frame rates.

Files and people write rates as rounded decimals: 23.976 means 24000/1001, a frame time of .0083333 means 1/120.
A decimal stands for the interval of numbers that round, or were cut, to it; the plainest rate in that interval is the
one that was meant.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable
from fractions import Fraction
from typing import Any

from retime.brief import text_of
from retime.errors import OptionError

_DECIMAL = re.compile(r"\+?(\d+(?:\.(\d*))?|\.(\d+))(?:[eE]([+-]?\d{1,3}))?", re.ASCII)
_FRACTION = re.compile(r"(\d{1,30})/(\d{1,30})", re.ASCII)
_RATE_UNIT = re.compile(r"\s*(?:hz|fps)$", re.ASCII | re.IGNORECASE)
# Rates that cameras and programs offer, for decimals so short that they fit several whole rates.
_USUAL = (12, 15, 24, 25, 30, 48, 50, 60, 72, 75, 90, 100, 120, 144, 150, 180, 200, 240, 250, 300, 360, 480, 500, 1000)
# Television plays each of them at 1000/1001 of its rate. Of these the common ones are meant by any digits that fit
# them (29.9).
_BROADCAST = tuple(Fraction(n * 1000, 1001) for n in (24, 30, 48, 60, 120, 240))
# The rest, but for that of 1000: it is 999.001, and who writes that means 999.
_OTHER_BROADCAST = tuple(rate for n in _USUAL[:-1] if (rate := Fraction(n * 1000, 1001)) not in _BROADCAST)
# These are rare: the digits must be nearer to n * 1000/1001 than to n, so at most half the way between them off.
_BROADCAST_TOLERANCE = Fraction(1, 2002)
# An unusual whole rate is meant where the interval is so short that it would hold one by chance this seldom.
_CHANCE = Fraction(1, 4)
# Of a frame time that is none, the rates that may have been meant.
_LEAST_MEANT, _MOST_MEANT = 12, 240
# Beyond these a number is no frame rate but a mistake, and arithmetic with it could overflow.
_SLOWEST, _FASTEST = Fraction(1, 10**6), Fraction(10**6)

RateLike = str | float | Fraction
"""Frames a second as people have them; see `parse_rate`."""


def _interval(text: str) -> tuple[Fraction, Fraction, Fraction]:
    """Return a written decimal, and the interval of what rounds, or is cut, to it; its upper end is excluded."""
    match = _DECIMAL.fullmatch(text.strip())
    # Python reads no integers with more digits.
    if match is None or len(text) > 4000:
        raise ValueError(f"expected a positive decimal number, found {text[:60]!r}")
    written = Fraction(text.strip())
    unit = Fraction(10) ** (int(match[4] or 0) - len(match[2] or match[3] or ""))
    # A float printed with all its digits is not as exact as it looks.
    noise = written / 2**50
    return written, written - max(unit / 2, noise), written + max(unit, noise)


def _plainest(low: Fraction, high: Fraction, written: Fraction, fits: Callable[[Fraction], bool]) -> Fraction:
    """Return the plainest rate that fits: whole, one of television's, a simple fraction; else the rate as written."""
    if written.denominator == 1:
        return written
    first, last = -(-low // 1), high // 1
    # A whole number is meant where it is the only one in the interval, and not there just because the interval is long:
    # a frame time of 0.032 (31.25 Hz) does not mean 31.
    wholes = (first,) if first == last and (high - low < _CHANCE or first in _USUAL) else _USUAL
    for rate in (*map(Fraction, wholes), *_BROADCAST):
        if fits(rate):
            return rate
    for rate in _OTHER_BROADCAST:
        if fits(rate) and _alike(rate, written):
            return rate
    # Where a program keeps a rate of television as a decimal, that is what it writes (29.970000), or a frame time of
    # one over it (1 / 23.976). One digit more than the decimal has is enough to be no accident.
    for decimal, (rate, place) in _broadcast_decimals().items():
        if fits(decimal) and high - low <= place / 5:
            return rate
    simplest = _simplest(low, high)
    # Fractions up to a denominator q lie about 1/q**2 apart. One in an interval a thousand times narrower is no
    # accident: somebody wrote the digits of that fraction.
    if fits(simplest) and simplest.denominator**2 * (high - low) * 1000 < 1:
        return simplest
    return written


def _alike(rate: Fraction, written: Fraction) -> bool:
    return abs(rate - written) <= _BROADCAST_TOLERANCE * written


@functools.cache
def _broadcast_decimals() -> dict[Fraction, tuple[Fraction, Fraction]]:
    """Map how television's rates are written (two to four places, rounded or cut) to the rate and the last place."""
    decimals: dict[Fraction, tuple[Fraction, Fraction]] = {}
    for rate in (*_BROADCAST, *_OTHER_BROADCAST):
        for place in (Fraction(1, 10**digits) for digits in (2, 3, 4)):
            for decimal in (round(rate / place) * place, rate // place * place):
                if decimal.denominator > 1 and _alike(rate, decimal):
                    decimals.setdefault(decimal, (rate, place))
    return decimals


def _simplest(low: Fraction, high: Fraction) -> Fraction:
    """Return the fraction with the smallest denominator in an interval above 0, by continued fractions."""
    whole_parts = []
    while low.denominator != 1 and low // 1 == high // 1:
        whole_parts.append(low // 1)
        low, high = 1 / (high - high // 1), 1 / (low - low // 1)
    result = Fraction(-(-low // 1))
    for whole in reversed(whole_parts):
        result = whole + 1 / result
    return result


def rate_from_frame_time(text: str) -> Fraction:
    """Find the exact rate behind a frame time as a file writes it.

    The plainest rate that the digits allow: a whole one; one of television (n * 1000/1001), or one over a decimal by
    which that is known (1 / 23.976); or a fraction too simple to be there by accident. Else exactly one over the time
    as written.

    Parameters
    ----------
    text : str
        Seconds a frame, a positive decimal (".0083333").

    Returns
    -------
    Fraction
        Frames a second.

    Raises
    ------
    ValueError
        Not a decimal number from 0.000001 to 1,000,000.

    Examples
    --------
    >>> rate_from_frame_time(".0083333"), rate_from_frame_time("0.04170833")
    (Fraction(120, 1), Fraction(24000, 1001))
    """
    written, low, high = _interval(text)
    if not 1 / _FASTEST <= written <= 1 / _SLOWEST:
        raise ValueError(
            f"expected a frame time from {float(1 / _FASTEST)} to {float(1 / _SLOWEST)} seconds, found {text[:60]!r}"
        )
    # Few digits (0.03) must not make a rate out of thin air: no more than 2 % away.
    low, high = max(low, written * Fraction(98, 100)), min(high, written * Fraction(102, 100))
    return _plainest(1 / high, 1 / low, 1 / written, lambda rate: low <= 1 / rate < high)


def rate_meant_by(frame_time: str) -> tuple[str, Fraction] | None:
    """Guess what a frame time of more than a second was meant as.

    Parameters
    ----------
    frame_time : str
        As a file has it.

    Returns
    -------
    (str, Fraction) or None
        "milliseconds" or "a rate", and the frames a second; None where it is like neither.

    Examples
    --------
    >>> rate_meant_by("33.333"), rate_meant_by("30"), rate_meant_by("2")
    (('milliseconds', Fraction(30, 1)), ('a rate', Fraction(30, 1)), None)
    """
    written, _, _ = _interval(frame_time)
    if "e" in frame_time.lower():
        return None
    usual = {*map(Fraction, _USUAL), *_BROADCAST}
    # No usual rate is the milliseconds of another. Few digits (7) fit a rate that nobody meant.
    for what, rate, exact in (
        ("a rate", parse_rate(frame_time), written),
        ("milliseconds", rate_from_frame_time(f"{frame_time}e-3"), 1000 / written),
    ):
        if rate in usual and _LEAST_MEANT <= rate <= _MOST_MEANT and abs(rate - exact) <= rate / 200:
            return what, rate
    return None


def rate_from_step(step: Fraction, error: Fraction) -> Fraction:
    """Find the exact rate behind the step between times, as a table of times gives it.

    Parameters
    ----------
    step : Fraction
        Seconds a frame, measured.
    error : Fraction
        How far off the step may be, above 0.

    Returns
    -------
    Fraction
        Frames a second: the rate that is plainest, as `rate_from_frame_time` understands it, or else the fraction with
        the smallest denominator, no more than 2 % away.

    Raises
    ------
    ValueError
        Not a step from 0.000001 to 1,000,000 seconds.

    Examples
    --------
    >>> rate_from_step(Fraction("0.03337"), Fraction("0.00001")), rate_from_step(Fraction("0.03"), Fraction("1e-6"))
    (Fraction(30000, 1001), Fraction(100, 3))
    """
    if not 1 / _FASTEST <= step <= 1 / _SLOWEST:
        raise ValueError(f"expected a step from 0.000001 to 1,000,000 seconds, found {float(step):.6g}")
    error = min(error, step / 50)
    low, high = 1 / (step + error), 1 / (step - error)
    rate = _plainest(low, high, 1 / step, lambda rate: low <= rate <= high)
    return _simplest(low, high) if rate == 1 / step else rate


def usual_rate(measured: float) -> Fraction:
    """Return the usual rate nearest to one that was measured, or where none is within 5 %, the number to two digits.

    Examples
    --------
    >>> usual_rate(30.7), usual_rate(41.6), usual_rate(0.123)
    (Fraction(30, 1), Fraction(42, 1), Fraction(3, 25))
    """
    nearest = min(_USUAL, key=lambda rate: abs(rate - measured))
    if abs(nearest - measured) <= 0.05 * measured:
        return Fraction(nearest)
    return Fraction(f"{measured:.1e}")


def parse_rate(value: RateLike) -> Fraction:
    """Find the exact rate that a person means.

    Parameters
    ----------
    value : str, float or Fraction
        Frames a second: ``"30000/1001"``, ``"29.97"``, ``"60 Hz"``, ``"24fps"``, ``120``, ``23.976``.

    Returns
    -------
    Fraction
        The exact rate, from 0.000001 to 1,000,000.

    Raises
    ------
    OptionError
        Not a number in that range.

    Examples
    --------
    >>> parse_rate("23.976")
    Fraction(24000, 1001)
    """
    if isinstance(value, Fraction):
        rate = value
    else:
        text = _RATE_UNIT.sub("", text_of(value).strip())
        try:
            pair = _FRACTION.fullmatch(text)
            if pair is not None:
                rate = Fraction(int(pair[1]), int(pair[2]))
            else:
                written, low, high = _interval(text)
                if written > 0:
                    rate = _plainest(low, high, written, lambda rate: low <= rate < high)
                else:
                    rate = written
        except (ValueError, ZeroDivisionError):
            raise OptionError(
                f"expected a frame rate such as 30, 29.97 or 30000/1001, found {text_of(value)[:60]!r}"
            ) from None
    if not _SLOWEST <= rate <= _FASTEST:
        raise OptionError(f"expected a frame rate from {float(_SLOWEST)} to {_FASTEST}, found {text_of(value)[:60]!r}")
    return rate


class RateField:
    """The field ``rate`` of a dataclass: whatever `parse_rate` reads is taken, and the exact fraction is kept.

    Examples
    --------
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Video:
    ...     rate: RateField = RateField("30")
    >>> Video().rate, Video(23.976).rate
    (Fraction(30, 1), Fraction(24000, 1001))
    """

    def __init__(self, default: RateLike) -> None:
        self._default = parse_rate(default)

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, instance: Any, owner: type | None = None) -> Fraction:
        # A dataclass asks the class itself for the default.
        rate: Fraction = self._default if instance is None else instance.__dict__[self._name]
        return rate

    def __set__(self, instance: Any, value: RateLike) -> None:
        instance.__dict__[self._name] = parse_rate(value)
