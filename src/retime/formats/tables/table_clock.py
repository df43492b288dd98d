"""The clock of a table: which column holds times, which one frame numbers, the rate, and frames between uneven rows."""

from __future__ import annotations

import math
import warnings
from fractions import Fraction

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatWarning
from retime.formats.made_frames import too_many_made
from retime.formats.tables.table_rows import TableRows
from retime.formats.tables.table_text import TableText
from retime.formats.tables.time_column import RATE_OF_ONE_ROW, TimeColumn, TimesError, numeric_times, text_times
from retime.formats.tables.time_names import form_of_name, is_frame_name, is_time_name
from retime.formats.tables.time_text import form_of_text
from retime.motion.blending import Places
from retime.motion.channels import matching
from retime.motion.clock import ClockForm

TIME_NAMES = ("time", "t", "seconds", "timestamp")
"""What a column of times is called, of those that programs write by themselves."""
_RATE_HINT = "; a rate that is given (--fps) takes the rows as even"


def find_clocks(text: TableText) -> dict[int, ClockForm | str]:
    """Find columns that may hold times, by what was said, their names, and their first cell."""
    first = text.first_row()
    if text.layout.clock is not None:
        columns = [text.layout.clock]
    else:
        said = [
            place
            for pattern, kind in text.options.channels.items()
            if kind.kind == "time" and kind.unit != "frames"
            for place in matching(pattern, text.names)
        ]
        named = [place for place, name in enumerate(text.names) if is_time_name(name)]
        columns = list(dict.fromkeys([*said, *named]))
        if 0 in text.layout.left_out and first and form_of_text(first[0]):
            columns.append(0)
    found: dict[int, ClockForm | str] = {}
    for column in columns:
        cell = first[column] if column < len(first) else ""
        found[column] = "" if text.numeric(cell) else form_of_text(cell) or ""
    return found


class TableClock:
    """When the rows of a table are.

    Parameters
    ----------
    text : TableText
        Its text.
    rows : TableRows
        Its rows, read.
    """

    def __init__(self, text: TableText, rows: TableRows) -> None:
        self.text, self.path = text, text.path
        self.rows = rows

    def time_columns(self) -> dict[int, TimeColumn]:
        """Take the columns that may hold times for times."""
        rate = self.text.options.rate or self.text.layout.rate
        found = {}
        # Numbers first: their rate tells how many frames a timecode beside them counts to its second.
        for column in sorted(self.rows.clocks, key=lambda column: column in self.rows.time_texts):
            times = found[column] = self._time_column(column, rate)
            rate = rate or times.told_rate()
        return {column: found[column] for column in self.rows.clocks}

    def _time_column(self, column: int, rate: Fraction | None) -> TimeColumn:
        """Take a column for times, of rows that are known, or not, to have this rate."""
        name = self.text.layout.clock_name or self.text.names[column] or "time"
        if column in self.rows.time_texts:
            texts = self.rows.time_texts[column][: len(self.rows.values)]
            form: ClockForm = "timecode" if self.rows.clocks[column] == "timecode" else "date"
            return text_times(name, texts, form, rate)
        times = np.array(self.rows.values[:, column])
        return numeric_times(name, times, self.rows.first_cell(column).replace(",", "."), self._known_form(column))

    def _known_form(self, column: int) -> ClockForm | None:
        """Say in what a column of times counts, where somebody said it: a person, the head, or its name."""
        name = self.text.names[column]
        for pattern, kind in self.text.options.channels.items():
            if kind.kind == "time" and matching(pattern, [name]):
                return "ms" if kind.unit == "ms" else "us" if kind.unit == "us" else "s"
        return self.text.layout.clock_form or form_of_name(name)

    def choose_clock(self, columns: dict[int, TimeColumn]) -> int | None:
        """Choose the first column of times that rise; or one that should and doesn't, for its error."""
        for place, column in columns.items():
            if column.rises:
                return place
        usual = (place for place in columns if self.text.names[place].lower() in TIME_NAMES)
        return next(usual, None if self.text.options.rate is not None else next(iter(columns), None))

    def frame_column(self, time: int | None) -> int | None:
        """Find the column that numbers frames, if one counts up; raise FormatError where one without a name doesn't."""
        if 0 in self.text.layout.left_out and not self.text.names[0] and time != 0:
            if len(self.rows.values) < 2 or counted_from(self.rows.values[:, 0]) is None:
                raise self.text.unnamed(self.text.layout, 1)
            return 0
        if len(self.text.names) - (time is not None) < 2:
            return None
        frames = [i for i, name in enumerate(self.text.names) if is_frame_name(name) and i != time]
        counts = next((i for i in frames if counted_from(self.rows.values[:, i]) is not None), None)
        if counts is None:
            for place in frames:
                self._warn_of_no_count(place, time)
        return counts

    def _warn_of_no_count(self, column: int, time: int | None) -> None:
        """Warn that a column called after frames is a channel, where all but a few of its numbers count them."""
        name, values = self.text.names[column], self.rows.values[:, column]
        if any(matching(pattern, [name]) for pattern in self.text.options.channels):
            return
        known = np.flatnonzero(~np.isnan(values))
        odd = np.flatnonzero(np.diff(values[known]) != np.diff(known))
        if not 0 < len(odd) < (len(known) - 1) / 2:
            return
        before, after = known[odd[0]], known[odd[0] + 1]
        even = "" if time is not None else ", and its rows as even"
        warnings.warn(
            f"{self.path}: {name!r} doesn't count up by one: it goes from {values[before]:.10g} to "
            f"{values[after]:.10g} at line {self.text.line_of_row(int(after))}. It is taken for a channel that the "
            f"search looks at{even} (--channel '{name}=time:frames' takes it for a clock)",
            FormatWarning,
            stacklevel=5,
        )

    def timing(self, clock: TimeColumn | None) -> tuple[Fraction, Places | None]:
        """Find the rate, and where between the rows frames are, if the rows are not even."""
        given = self.text.options.rate
        if clock is None:
            given = given or self.text.layout.rate
            if given is None:
                raise self.text.error(
                    None,
                    f"the table has no column of times ({', '.join(TIME_NAMES)}), so its rate must be given (--fps)",
                )
            return given, None
        try:
            clock.check(_RATE_HINT)
            if len(clock.times) == 1:
                return given or self.text.layout.rate or self._rate_of_one_row(clock), None
            even = clock.even
            rate = given or (self._declared_rate(clock.rate()) if even else self.text.layout.rate or clock.usual_rate())
        except TimesError as error:
            if given is not None:
                return given, None
            raise self.text.error(
                None if error.row is None else self.text.line_of_row(error.row), error.problem
            ) from None
        self._say_form(clock)
        return rate, None if even else self._even_places(clock, rate)

    def _declared_rate(self, measured: Fraction) -> Fraction:
        """Prefer the rate that the head says, where the times don't contradict it."""
        declared = self.text.layout.rate
        return measured if declared is None or abs(declared / measured - 1) > Fraction(1, 200) else declared

    def _rate_of_one_row(self, clock: TimeColumn) -> Fraction:
        """Take the usual rate where a single row says none; say so."""
        warnings.warn(
            f"{self.path}: a single row's {clock.name!r} gives no rate: {RATE_OF_ONE_ROW} frames a second are taken "
            "(--fps says another)",
            FormatWarning,
            stacklevel=5,
        )
        return RATE_OF_ONE_ROW

    def _say_form(self, clock: TimeColumn) -> None:
        """Say it, where only the size of times told in what they count, or nothing did."""
        form = clock.clock.form
        if clock.guessed:
            warnings.warn(
                f"{self.path}: no second ends among these timecodes, so {clock.clock.base} frames to a second are a "
                "guess; where it is wrong, give the rate (--fps)",
                FormatWarning,
                stacklevel=4,
            )
        if form not in ("ms", "us", "ns"):
            return
        column = next(
            place for place in self.rows.clocks if self.text.names[place] == clock.name or self.text.layout.clock_name
        )
        if self._known_form(column) is None:
            what = str(clock.clock).partition(",")[0]
            warnings.warn(
                f"{self.path}: {clock.name!r} is taken for {what}, by the size of its numbers (--channel "
                f"'{clock.name}=time:s' takes it for seconds)",
                FormatWarning,
                stacklevel=4,
            )

    def _even_places(self, clock: TimeColumn, rate: Fraction) -> Places:
        """Say where between the rows frames lie that are made at an even rate, and warn that they are made."""
        at = (clock.times - clock.times[0]) / clock.ticks
        n_frames = math.floor(at[-1] * float(rate) * (1 + 1e-12)) + 1
        if n_frames > self.text.options.limits.frames:
            raise self.text.error(
                None,
                f"{clock.name!r} goes over {at[-1]:.6g} s, {n_frames} frames at {float(rate):.6g} Hz, the limit is "
                f"{self.text.options.limits.frames} (Limits.frames)",
            )
        steps = np.diff(at)
        longest = int(steps.argmax())
        n_rows, n_channels = self.rows.values.shape
        if too_many_made(n_frames, n_channels, n_rows=n_rows, n_numbers=self.rows.values.size):
            gigabytes = 8 * n_frames * n_channels / 1e9
            raise self.text.error(
                self.text.line_of_row(longest + 1),
                f"{clock.name!r} goes on by {steps[longest]:.6g} s here, and {n_frames} frames of {n_channels} columns "
                f"({gigabytes:.2g} GB) would be made of {n_rows} rows; is this time right? A lower rate makes "
                "fewer (--fps)",
            )
        warnings.warn(
            f"{self.path}: the times in {clock.name!r} are uneven, {steps.min():.4g} to {steps.max():.4g} s apart (the "
            f"longest step ends at line {self.text.line_of_row(longest + 1)}); {n_frames} frames were made of "
            f"{len(at)} rows, where they stand in time, at {float(rate):.6g} Hz (--fps R makes another rate)",
            FormatWarning,
            stacklevel=4,
        )
        times = np.arange(n_frames) * rate.denominator / rate.numerator
        before = np.clip(np.searchsorted(at, times, side="right") - 1, 0, len(at) - 2)
        share = np.clip((times - at[before]) / steps[before], 0.0, 1.0)
        whole = share == 1.0
        return np.where(whole, before + 1, before), before + 1, np.where(whole, 0.0, share)


def first_frame(clock: TimeColumn, rate: Fraction, numbered: int) -> int:
    """Give the first frame the number that its time is, where that is whole and a clip's; else that of its file."""
    start = clock.clock.start
    if start is None or clock.clock.origin != "clip":
        return numbered
    # As far as the last decimal tells.
    off = min(0.2, max(0.01, clock.unit / clock.ticks * float(rate)))
    whole = _whole(float(start * rate), off)
    return numbered if whole is None else whole


def counted_from(values: FloatArray) -> int | None:
    """Return the number of the first row, where numbers are whole and go up by one a row; cells may be empty.

    What is read so is written without its gaps, and must be the same when it is read again.
    """
    known = np.flatnonzero(~np.isnan(values))
    if len(known) < min(len(values), 2):
        return None
    first = _whole(float(values[known[0]]) - known[0], 0.0)
    return first if first is not None and np.array_equal(values[known] - first, known) else None


def _whole(number: float, off: float = 0.01) -> int | None:
    """Round a number that is whole, but for the rounding of what it was made of; None where it isn't."""
    if not abs(number) < 2**53 or abs(number - round(number)) > off:
        return None
    return round(number)
