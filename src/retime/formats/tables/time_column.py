"""The column of times of a table: in what it counts, how far apart its rows are, and when the first one is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.formats.tables.time_text import parse_texts
from retime.motion.clock import TICKS, Clock, ClockForm
from retime.motion.rate import rate_from_step, usual_rate

# Whole numbers up to here are doubles; nanoseconds since 1970 go further, and are off by less than a microsecond.
_EXACT, _LONGEST = 2.0**53, 2.0**63
RATE_OF_ONE_ROW = Fraction(30)
"""Frames a second that are taken where there is one row, which says nothing of them."""
# By these sizes times since 1970 are told: 1e11 s are three thousand years.
_SINCE_1970: tuple[tuple[float, ClockForm], ...] = ((1e17, "ns"), (1e14, "us"), (1e11, "ms"))


class TimesError(ValueError):
    """Times from which no rate can be found.

    Attributes
    ----------
    row : int or None
        The row at fault, from 0.
    problem : str
        What is wrong.
    """

    def __init__(self, problem: str, row: int | None = None) -> None:
        self.problem = problem
        self.row = row
        super().__init__(problem)


@dataclass(frozen=True, eq=False)
class TimeColumn:
    """Times of rows.

    Attributes
    ----------
    name : str
        Of the column.
    times : float array, shape (n_rows,)
        In ticks.
    unit : float
        Ticks that one in the last place stands for.
    ticks : int
        How many make a second.
    clock : Clock
        How they are written, and the first of them.
    show : callable
        Makes text of a row's time, for messages.
    exact : Fraction, optional
        Frames a second, where nothing was rounded.
    guessed : bool
        Whether it is a guess how many frames its timecode counts to a second.
    """

    name: str
    times: FloatArray
    unit: float
    ticks: int
    clock: Clock
    show: Callable[[int], str]
    exact: Fraction | None = None
    guessed: bool = False

    __repr__ = brief_repr

    @property
    def rises(self) -> bool:
        """Whether each time is later than the one before."""
        return bool(np.all(np.abs(self.times) < _LONGEST) and np.all(np.diff(self.times) > 0))

    def agrees_with(self, other: TimeColumn) -> bool:
        """Whether this column says the same as another one, but for where it begins and how it is rounded."""
        if not (self.rises and other.rises):
            return False
        own, others = [(one.times - one.times[0]) / one.ticks for one in (self, other)]
        slack = max(self.unit / self.ticks, other.unit / other.ticks, 0.01 * float(others[-1]) / max(len(others), 1))
        return bool(np.all(np.abs(own - others) <= 2 * slack))

    def check(self, hint: str) -> None:
        """Raise TimesError where times don't rise, or are too large for one."""
        largest = _LONGEST if self.clock.form != "s" else _EXACT
        far = np.flatnonzero(~(np.abs(self.times) < largest))
        if len(far):
            row = int(far[0])
            raise TimesError(f"row {row + 1}: {self.name!r} is {self.times[row]:.6g}, too large for a time{hint}", row)
        back = np.flatnonzero(~(np.diff(self.times) > 0))
        if len(back):
            row = int(back[0]) + 1
            raise TimesError(
                f"row {row + 1}: {self.name!r} goes from {self.show(row - 1)} to {self.show(row)}; times must "
                f"increase{hint}",
                row,
            )

    @property
    def even(self) -> bool:
        """Whether steps are as long as one another: to a hundredth, or as far as decimals tell."""
        step = float((self.times[-1] - self.times[0]) / (len(self.times) - 1))
        off = np.abs(np.diff(self.times) - step)
        return not off.max() > max(0.01 * step, min(2 * self.unit, 0.75 * step))

    def told_rate(self) -> Fraction | None:
        """Find the exact rate of times, if they rise, are even, and have one."""
        if len(self.times) == 1 or not (self.rises and self.even):
            return None
        return self.exact or rate_of(self.times, self.unit, self.ticks)

    def rate(self) -> Fraction:
        """Find the exact rate of even times; raise TimesError where there is none."""
        found = self.told_rate()
        if found is None:
            step = float(self.times[-1] - self.times[0]) / (len(self.times) - 1) / self.ticks
            raise TimesError(f"the mean step of {self.name!r}, {step:.6g} s, gives no rate of 0.000001 to 1,000,000")
        return found

    def usual_rate(self) -> Fraction:
        """Choose a rate for times that are not even: the usual one nearest to that of their middle step."""
        return usual_rate(self.ticks / float(np.median(np.diff(self.times))))


def rate_of(times: FloatArray, unit: float, ticks: int) -> Fraction | None:
    """Find the exact rate behind times that are even but for their last decimal's `unit`; None where there is none."""
    n_steps = len(times) - 1
    step = (Fraction(float(times[-1])) - Fraction(float(times[0]))) / n_steps / ticks
    try:
        # Each end was rounded or cut, by one unit at most.
        found = rate_from_step(step, Fraction(unit) / n_steps / ticks)
    except ValueError:
        return None
    if ticks > 1 and n_steps > 1 and len(set(np.diff(times).tolist())) == 1:
        # Whole milliseconds that are all as far apart were counted so, where no usual rate explains them.
        exact = 1 / step
        if exact.denominator == 1 or found.denominator not in (1, 1001):
            return exact
    return found


def unit_of(times: FloatArray, at_least: int) -> float:
    """Find the size of one in the last decimal that times are written with: `at_least`, or more if they need more."""
    largest = float(np.max(np.abs(times)))
    spacing = 2 * float(np.spacing(largest))
    for decimals in range(at_least, 17):
        if 10.0**-decimals <= spacing:
            break
        if np.array_equal(np.round(times, decimals), times):
            return 10.0**-decimals
    return spacing


def form_of_values(times: FloatArray) -> ClockForm:
    """Tell in what times count by their size: steps of 2 and more are no seconds, for no motion is caught so seldom.

    Examples
    --------
    >>> form_of_values(np.array([0.0, 33, 67])), form_of_values(np.array([0.0, 0.033, 0.067]))
    ('ms', 's')
    """
    first = abs(float(times[0]))
    for least, form in _SINCE_1970:
        if first >= least:
            return form
    steps = np.diff(times)
    step = float(np.median(steps)) if len(steps) else 0.0
    if not step >= 2:
        return "s"
    return "ms" if step <= 1e3 else "us" if step <= 1e6 else "ns"


def numeric_times(name: str, times: FloatArray, sample: str, form: ClockForm | None) -> TimeColumn:
    """Take a column of numbers for times.

    Parameters
    ----------
    name : str
        Of the column.
    times : float array, shape (n_rows,)
        Its numbers.
    sample : str
        The first of them as written, with a point. Where it is another number, or none (the row was damaged, and left
        out), the first time is written anew.
    form : str, optional
        In what they count, where that is known.
    """
    try:
        # As an exact fraction a power of ten has as many digits as it says: one of a damaged file may say billions.
        written = len(sample.lower().partition("e")[2]) < 5 and float(Fraction(sample)) == times[0]
    except (ValueError, ArithmeticError):
        written = False
    sample = sample if written else repr(float(times[0]))
    known = form or form_of_values(times)
    decimals = len(sample.lower().partition("e")[0].partition(".")[2])
    ticks = TICKS[known]
    clock = Clock(known, Fraction(sample) / ticks, sample)
    return TimeColumn(name, times, unit_of(times, decimals), ticks, clock, lambda row: f"{times[row]:.10g}")


def text_times(name: str, texts: Sequence[str], form: ClockForm, rate: Fraction | None) -> TimeColumn:
    """Take a column of timecodes, dates or times of day, of rows that `form_of_text` knows, for times.

    Parameters
    ----------
    name : str
        Of the column.
    texts : sequence of str
        Its cells.
    form : {"timecode", "date"}
        What they are.
    rate : Fraction, optional
        Frames a second, where that is known.
    """
    found = parse_texts(texts, form, rate=rate)
    clock = Clock(form, found.seconds[0], texts[0], found.base)
    # A timecode counts whole frames, and those of its own rate.
    steps = {after - before for before, after in pairwise(found.seconds)} if found.base else set()
    exact = 1 / steps.pop() if len(steps) == 1 and min(steps) > 0 else None
    times = np.array([float(second - found.seconds[0]) for second in found.seconds])
    return TimeColumn(name, times, float(found.unit), 1, clock, lambda row: repr(texts[row]), exact, found.guessed)
