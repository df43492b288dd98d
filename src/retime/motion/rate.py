"""Exact frame rates.

Files and people write rates as rounded decimals: 23.976 means 24000/1001, a frame time of .0083333 means 1/120.
A decimal stands for the interval of numbers that round (or were cut) to it; the plainest rate in that interval is the
one that was meant.
"""

from __future__ import annotations

import re
from fractions import Fraction

from retime.errors import OptionError

_DECIMAL = re.compile(r"\+?(\d+(?:\.(\d*))?|\.(\d+))(?:[eE]([+-]?\d{1,3}))?", re.ASCII)
_FRACTION = re.compile(r"(\d{1,12})/(\d{1,12})", re.ASCII)
_NTSC = tuple(Fraction(n * 1000, 1001) for n in (24, 30, 48, 60, 120, 240))


def _interval(text: str) -> tuple[Fraction, Fraction]:
    """Return a written decimal and the size of one unit in its last place."""
    match = _DECIMAL.fullmatch(text.strip())
    if match is None:
        raise ValueError(f"expected a positive decimal number, found {text!r}")
    decimals = len(match[2] or match[3] or "")
    exponent = int(match[4] or 0)
    return Fraction(text.strip()), Fraction(10) ** (exponent - decimals)


def _plainest(low: Fraction, high: Fraction, written: Fraction) -> Fraction:
    """Return the whole rate, else the NTSC rate, in an interval; else a plain fraction; else the rate as written."""
    whole = Fraction(round(written))
    if whole > 0 and low <= whole <= high:
        return whole
    for rate in _NTSC:
        if low <= rate <= high:
            return rate
    simplest = _simplest(low, high)
    # Fractions up to a denominator q lie about 1/q**2 apart. One in an interval a thousand times narrower is no
    # accident: somebody wrote the digits of that fraction.
    if simplest.denominator**2 * (high - low) * 1000 < 1:
        return simplest
    return written


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

    The plainest rate that the digits allow: a whole one, an NTSC one, or a fraction too simple to be there by accident;
    else exactly one over the time as written.

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
        Not a positive decimal number.

    Examples
    --------
    >>> rate_from_frame_time(".0083333"), rate_from_frame_time("0.04170833")
    (Fraction(120, 1), Fraction(24000, 1001))
    """
    written, unit = _interval(text)
    if written <= 0:
        raise ValueError(f"expected a frame time above 0, found {text!r}")
    # Some programs cut the decimals instead of rounding them: a whole unit to either side.
    low, high = written - unit, written + unit
    # Few digits (0.03) must not make a rate out of thin air: no more than 1 % away.
    low, high = max(low, written * Fraction(99, 100)), min(high, written * Fraction(101, 100))
    return _plainest(1 / high, 1 / low, 1 / written)


def parse_rate(value: str | float | Fraction) -> Fraction:
    """Find the exact rate that a person means.

    Parameters
    ----------
    value : str, float or Fraction
        Frames a second: ``"30000/1001"``, ``"29.97"``, ``120``, ``23.976``.

    Returns
    -------
    Fraction
        The exact rate, above 0.

    Raises
    ------
    OptionError
        Not a positive finite number.

    Examples
    --------
    >>> parse_rate("23.976")
    Fraction(24000, 1001)
    """
    if isinstance(value, Fraction):
        rate = value
    else:
        text = str(value).strip()
        try:
            pair = _FRACTION.fullmatch(text)
            if pair is not None:
                rate = Fraction(int(pair[1]), int(pair[2]))
            else:
                written, unit = _interval(text)
                rate = written
                if rate.denominator != 1:
                    rate = _plainest(written - unit, written + unit, written) if unit < Fraction(1, 5) else written
        except (ValueError, ZeroDivisionError):
            raise OptionError(f"expected a frame rate such as 30, 29.97 or 30000/1001, found {value!r}") from None
    if rate <= 0:
        raise OptionError(f"expected a frame rate above 0, found {value!r}")
    return rate
