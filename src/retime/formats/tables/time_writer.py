"""The column of times of a table that is written: in the form that its file had, from where that began."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from retime.formats.tables.time_column import RATE_OF_ONE_ROW, form_of_values, rate_of, text_times, unit_of
from retime.formats.tables.time_names import form_of_name
from retime.formats.tables.time_text import text_writer
from retime.motion.clock import TICKS, Clock
from retime.motion.signal import Signal


def time_texts(signal: Signal, name: str) -> tuple[str, list[str], bool]:
    """Write the times of a signal's frames.

    Parameters
    ----------
    signal : Signal
        Its clock says how.
    name : str
        What the column is to be called.

    Returns
    -------
    str
        The name; with a unit, where nobody could tell it otherwise.
    list of str
        A time for each frame.
    bool
        Whether a reader finds the exact rate in them.
    """
    clock, rate, n_frames = signal.clock, signal.rate, signal.n_frames
    start = signal.first_frame / rate if clock.start is None else clock.start
    if clock.form == "frames":
        first = round(start * rate)
        # Numbers of frames say nothing of their rate, and didn't in the file that this comes from.
        return name, [str(first + i) for i in range(n_frames)], True
    if clock.form in ("timecode", "date"):
        parts, write = text_writer(clock.sample, clock.base, rate)
        texts = [write(part) for part in _counts(start, rate, n_frames, parts, nearest=False)]
        return name, texts, text_times(name, texts, clock.form, None).told_rate() == rate
    ticks = TICKS[clock.form]
    fewest = _fewest_decimals(clock, rate)
    for decimals in range(fewest, fewest + 12):
        counts = _counts(start, rate, n_frames, Fraction(ticks * 10**decimals), nearest=True)
        times = np.array(counts, dtype=np.float64) / 10.0**decimals
        exact = bool(np.all(np.diff(times) > 0))
        # Of a single row the usual rate is taken.
        told = rate_of(times, unit_of(times, decimals), ticks) if n_frames > 1 else RATE_OF_ONE_ROW
        exact = exact and told == rate
        if exact:
            break
    else:
        decimals = fewest + 6
        counts = _counts(start, rate, n_frames, Fraction(ticks * 10**decimals), nearest=True)
        times = np.array(counts, dtype=np.float64) / 10.0**decimals
    if form_of_name(name) not in (None, clock.form) or (
        form_of_name(name) is None and form_of_values(times) != clock.form
    ):
        name = f"{name}_{clock.form}"
    return name, [_decimal(count, decimals) for count in counts], exact


def _fewest_decimals(clock: Clock, rate: Fraction) -> int:
    """Say how many decimals times need: six of seconds, else as many as the file had; neighbours must differ in two."""
    if clock.form == "s":
        return max(6, 2 + math.ceil(math.log10(float(rate))))
    had = len(clock.sample.lower().partition("e")[0].partition(".")[2])
    return max(had, math.ceil(math.log10(4 * float(rate) / TICKS[clock.form])))


def _counts(start: Fraction, rate: Fraction, n_frames: int, parts: Fraction, *, nearest: bool) -> list[int]:
    """Count the parts of a second up to each frame, in whole numbers all the way: sums of periods would drift."""
    first, step = start * parts, parts / rate
    whole = math.lcm(first.denominator, step.denominator)
    a, b = int(first * whole), int(step * whole)
    half = whole // 2 if nearest else 0
    return [(a + b * i + half) // whole for i in range(n_frames)]


def _decimal(count: int, decimals: int) -> str:
    if not decimals:
        return str(count)
    digits = f"{abs(count):0{decimals + 1}d}"
    return f"{'-' if count < 0 else ''}{digits[:-decimals]}.{digits[-decimals:]}"
