"""Tables of text: a signal as a row for each frame and a column for each channel.

The first row names the columns; where it is all numbers there is no such row, and they are called c0, c1 ... Programs
write more above their rows, and `retime.formats.tables` reads that. A column of times gives the rate and is no channel,
and neither is one called frame that counts up by one. Fields are separated by commas, semicolons or tabs, whichever the
first line uses.

A spreadsheet takes a field that begins with ``=``, ``+``, ``-`` or ``@`` for a formula. Names that do are written with
an apostrophe before them, which reading takes off again.
"""

from __future__ import annotations

import csv
import math
import re
import warnings
from array import array
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from io import BytesIO, StringIO
from itertools import islice
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, FormatWarning
from retime.files import write_bytes
from retime.formats.channel_meaning import GAPS_HINT, make_signal
from retime.formats.file_signatures import foreign_kind
from retime.formats.number_rows import parse_rows
from retime.formats.number_text import NumberTextError, parse_number, part_glued
from retime.formats.read_options import ReadOptions
from retime.formats.tables import Head, Layout, find_layout
from retime.formats.tables.layout import Row
from retime.formats.tables.time_column import RATE_OF_ONE_ROW, TimeColumn, TimesError, numeric_times, text_times
from retime.formats.tables.time_names import form_of_name, is_frame_name, is_time_name
from retime.formats.tables.time_text import form_of_text
from retime.formats.tables.time_writer import time_texts
from retime.formats.text_lines import without_byte_order_mark, without_end_padding
from retime.limits import MOST_NUMBERS
from retime.motion.any_motion import AnyMotion
from retime.motion.blending import Places, blended
from retime.motion.channels import ChannelKind, matching, text_label
from retime.motion.clock import Clock, ClockForm
from retime.motion.signal import Signal

TIME_NAMES = ("time", "t", "seconds", "timestamp")
_FORMULA = re.compile(r"[\s']*[=+\-@]")
_ESCAPED = re.compile(r"'[\s']*[=+\-@]")
# Rows are parsed in pieces of this size: parsing takes several times the memory of its text.
_PIECE_BYTES = 1 << 22
# How a value that is missing is written.
_GAPS = {"", "nan", "-nan", "na", "n/a", "#n/a", "null", "none"}
# A word of a text begins otherwise: what begins like this is a number, or one that is written wrongly.
_LIKE_A_NUMBER = re.compile(r"[+-]?[.,]?\d|[+-]?(nan|inf|infinity)$", re.IGNORECASE)
# By so many rows it is told which columns are text.
_ROWS_TO_TELL = 1000
# So many frames, of so many numbers, may be made of rows that are uneven in time, or so many of each that is there; and
# no more than an output may have.
_MOST_FRAMES_MADE = 1 << 18
_MOST_MADE = 1 << 22
_MADE_OF_ONE = 100
# So many rows, and bytes, may stand above the numbers.
_HEAD_ROWS = 40
_HEAD_BYTES = 1 << 22
_SEPARATOR = re.compile(rb"\s*\"?sep=([^\n])\"?[ \t]*\n", re.IGNORECASE)
_RATE_HINT = "; a rate that is given (--fps) takes the rows as even"


def read(path: Path, data: bytes, options: ReadOptions) -> Signal:
    r"""Read a CSV table.

    Parameters
    ----------
    path : Path
        The file, for messages.
    data : bytes
        What it holds.
    options : ReadOptions
        What the reader was told. A ``rate`` takes the place of the time column's, whose times then need not be even.

    Returns
    -------
    Signal
        The first frame's number is the first time times the rate, where that is whole; else what a frame column says.

    Raises
    ------
    FormatError
        Rows of different lengths, names that repeat, a field that is no finite number, times that are not even, or
        no rate.

    Warns
    -----
    FormatWarning
        Rows were cut off where the file is damaged (``options.repair``).

    Examples
    --------
    >>> curve = read(Path("curve.csv"), b"time,x\n0,1\n0.04,3\n0.08,4\n", ReadOptions())
    >>> curve.names, curve.rate, curve.values[:, 0].tolist()
    (('x',), Fraction(25, 1), [1.0, 3.0, 4.0])
    """
    kind = foreign_kind(data)
    data = without_end_padding(without_byte_order_mark(path, data))
    try:
        zero = data.find(b"\0")
        if zero >= 0:
            raise FormatError("binary data, not text; expected a table of numbers", path=path, byte=zero)
        if not data.strip():
            raise FormatError("the file is empty; expected a table of numbers", path=path)
        table = _Table(path, data, options)
        for note in table.read_rows():
            warnings.warn(f"{path}: {note}", FormatWarning, stacklevel=3)
        return table.signal()
    except FormatError as error:
        if kind is None:
            raise
        raise FormatError(
            f"this is {kind}; expected a table of numbers", path=path, line=error.line, byte=error.byte
        ) from None


class _Table:
    """The rows of one file."""

    def __init__(self, path: Path, data: bytes, options: ReadOptions) -> None:
        self.path = path
        self.options = options
        if b"\r" in data:
            data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        self.data = data
        try:
            data.decode("utf-8")
            self.encoding = "utf-8"
        except UnicodeDecodeError:
            self.encoding = "cp1252"
        # A spreadsheet's own first line, which says what parts the cells.
        said = _SEPARATOR.match(data)
        self.body = 0 if said is None else said.end()
        self.body_line = 1 + data.count(b"\n", 0, self.body)
        self.delimiter = self.find_delimiter() if said is None else said[1].decode("latin-1")
        if not self.delimiter.isascii() or self.delimiter.isalnum() or self.delimiter in "\"'+-.":
            raise self.error(1, f"sep= names what parts the cells: one of , ; | or a tab, found {self.delimiter!r}")
        self.layout = self.header()
        self.names = self.layout.names
        # Columns that may hold times, the likeliest first, each with the form of its text ("" of numbers).
        self.clocks = self.find_clocks()
        self.time_texts: dict[int, list[str]] = {column: [] for column, form in self.clocks.items() if form}
        self.values = np.empty((0, len(self.names)))
        # Lines of rows whose numbers ran together and were parted.
        self.glued: list[int] = []
        # Columns of text, found where a row is first met that is not all numbers; and the texts of each.
        self.texts: dict[int, list[str]] | None = None

    def error(self, line: int | None, problem: str) -> FormatError:
        return FormatError(problem, path=self.path, line=line)

    def find_delimiter(self) -> str:
        """Take a tab or semicolon where the first line that isn't blank has one, outside of quotes; else the comma."""
        # A quoted name may hold line ends and delimiters, so quoted text is emptied first.
        plain = re.sub(rb'"[^"]*"', b'""', self.data[:_PIECE_BYTES])
        first = next((line for line in BytesIO(plain) if line.strip()), b"")
        for delimiter in "\t;":
            # A single column may have white space around it; that is no delimiter.
            if delimiter.encode() in first.strip():
                return delimiter
        return "," if not self.options.decimal_comma else ";"

    def rows(self, data: bytes, first_line: int) -> Iterator[tuple[int, int, list[str]]]:
        """Yield each row's line, the offset after it, and its fields; blank rows are left out."""
        offset = 0
        limit = self.options.limits.line_bytes

        def lines() -> Iterator[str]:
            nonlocal offset
            for number, line in enumerate(BytesIO(data), first_line):
                if len(line) > limit:
                    raise self.error(
                        number, f"the line has {len(line)} bytes, the limit is {limit} (Limits.line_bytes)"
                    )
                offset += len(line)
                yield line.decode(self.encoding, "replace")

        if self.delimiter == " ":
            for number, text in enumerate(lines(), first_line):
                if fields := text.split():
                    yield number, offset, fields
            return
        reader = csv.reader(lines(), delimiter=self.delimiter, strict=True)
        before = 0
        while True:
            try:
                row = next(reader)
            except StopIteration:
                return
            except csv.Error as error:
                raise self.error(first_line + before, f"not a row of a table: {error}") from None
            fields = [field.strip() for field in row]
            if fields and fields != [""]:
                yield first_line + before, offset, fields
            before = reader.line_num

    def header(self) -> Layout:
        """Read what stands above the rows of numbers; leave the body behind it."""
        begin, begin_line = self.body, self.body_line
        rows = []
        try:
            head = self.rows(self.data[begin : begin + _HEAD_BYTES], begin_line)
            for line, offset, fields in islice(head, _HEAD_ROWS):
                rows.append(Row(line, begin + offset, tuple(fields)))
        except FormatError:
            # What is wrong below the first row is said when it is reached, and what is above may be kept (--repair).
            if not rows:
                raise
        if not rows:
            raise self.error(None, "the file is blank; expected a table of numbers")
        layout = find_layout(Head(tuple(rows), self.delimiter, self.numeric, self.error))
        self.delimiter = layout.delimiter
        n_columns, limits = len(layout.names), self.options.limits
        if n_columns > limits.channels:
            raise self.error(
                layout.names_line, f"{n_columns} columns, the limit is {limits.channels} (Limits.channels)"
            )
        if layout.start:
            self.body = layout.start
            self.body_line = 1 + self.data.count(b"\n", 0, self.body)
        columns: dict[str, int] = {}
        for i, name in enumerate(layout.names, 1):
            if not name and i - 1 not in layout.left_out:
                raise self.unnamed(layout, i)
            if len(name.encode()) > limits.name_bytes:
                raise self.error(
                    layout.names_line,
                    f"the name of column {i} is longer than {limits.name_bytes} bytes (Limits.name_bytes)",
                )
            if name in columns:
                raise self.error(
                    layout.names_line,
                    f"columns {columns[name]} and {i} are both called {name!r}; each needs its own name",
                )
            columns[name] = i
        return layout

    def unnamed(self, layout: Layout, column: int) -> FormatError:
        return self.error(layout.names_line, f"column {column} of {len(layout.names)} has no name")

    def first_row(self) -> list[str]:
        """Return the cells of the first row of numbers, if there is one."""
        for _, _, fields in self.rows(self.data[self.body : self.body + _HEAD_BYTES], self.body_line):
            return fields
        return []

    def find_clocks(self) -> dict[int, ClockForm | str]:
        """Find columns that may hold times, by what was said, their names, and their first cell."""
        first = self.first_row()
        if self.layout.clock is not None:
            columns = [self.layout.clock]
        else:
            said = [
                place
                for pattern, kind in self.options.channels.items()
                if kind.kind == "time" and kind.unit != "frames"
                for place in matching(pattern, self.names)
            ]
            named = [place for place, name in enumerate(self.names) if is_time_name(name)]
            columns = list(dict.fromkeys([*said, *named]))
            if 0 in self.layout.left_out and first and form_of_text(first[0]):
                columns.append(0)
        found: dict[int, ClockForm | str] = {}
        for column in columns:
            cell = first[column] if column < len(first) else ""
            found[column] = "" if self.numeric(cell) else form_of_text(cell) or ""
        return found

    def numeric(self, field: str) -> bool:
        """Whether a field of the first row is meant as a number, be it one that is refused later."""
        try:
            parse_number(field.encode(), decimal_comma=self.options.decimal_comma)
        except NumberTextError:
            return re.fullmatch(r"[+-]?(nan|inf|infinity)", field, re.IGNORECASE) is not None
        return True

    def read_rows(self) -> list[str]:
        """Read all rows; the notes say what was cut off of a damaged file."""
        pieces: list[FloatArray] = []
        notes = []
        n_rows = 0
        start, line = self.body, self.body_line
        limit = self.options.limits.frames
        while start < len(self.data):
            stop = self.data.find(b"\n", start + _PIECE_BYTES) + 1 or len(self.data)
            piece = self.data[start:stop]
            # A delimiter at the end of a row begins no cell where the layout says so.
            ends = rb"%b+(?= *(?:\n|$))" % re.escape(self.delimiter.encode())
            rows = parse_rows(
                re.sub(ends, b"", piece) if self.layout.extra else piece,
                len(self.names),
                delimiter=self.delimiter.strip(" "),
                decimal_comma=self.options.decimal_comma,
                # The limit counts the line's end too.
                line_bytes=self.options.limits.line_bytes - 1,
            )
            failure = None
            if rows is None:
                rows, failure = self.careful_rows(piece, line)
            n_rows += len(rows)
            pieces.append(rows)
            if n_rows > limit:
                raise self.error(None, f"more than {limit} rows (Limits.frames)")
            if failure is not None:
                if not self.options.repair or not n_rows:
                    raise failure
                notes.append(f"{n_rows} whole rows were kept; then {failure}")
                break
            start, line = stop, line + piece.count(b"\n")
        if not n_rows:
            raise self.error(line, "the table ends after its names; expected rows of numbers")
        self.values = np.concatenate(pieces)
        claimed = self.layout.n_frames
        if claimed is not None and claimed != n_rows and not notes:
            shown = claimed if claimed < 10**12 else f"{claimed:.3g}"
            notes.append(f"{shown} rows claimed, {n_rows} there; kept all {n_rows}")
        if self.glued:
            where = f"{len(self.glued)} row{'s' * (len(self.glued) != 1)}"
            notes.append(f"numbers that ran together were parted in {where}; the first is line {self.glued[0]}")
        return notes

    def careful_rows(self, piece: bytes, first_line: int) -> tuple[FloatArray, FormatError | None]:
        """Parse rows one at a time, up to the first that can't be."""
        values = array("d")
        failure = None
        n_columns = len(self.names)
        if self.texts is None:
            self.texts = {column: [] for column in self.text_columns(piece, first_line)}
        try:
            for line, _, fields in self.rows(piece, first_line):
                while self.layout.extra and len(fields) > n_columns and not fields[-1]:
                    fields.pop()
                if len(fields) < n_columns and self.options.repair:
                    fields = self.parted(line, fields)
                if len(fields) != n_columns:
                    raise self.error(
                        line,
                        f"the row has {len(fields)} field{'s' * (len(fields) != 1)}, the first row has {n_columns}"
                        + (f" (separated by {self.delimiter!r})" if 1 in (len(fields), n_columns) else ""),
                    )
                values.extend([self.number(line, i, field) for i, field in enumerate(fields)])
        except FormatError as error:
            failure = error
        return np.array(values).reshape(-1, n_columns), failure

    def parted(self, line: int, fields: list[str]) -> list[str]:
        """Part numbers that run together, where the row then has as many as it must have; in tables of numbers."""
        # Dates and words may hold a minus.
        if self.texts or self.time_texts:
            return fields
        comma = self.options.decimal_comma
        parted = [
            one for field in fields for one in part_glued(field.encode(), decimal_comma=comma).decode().split(" ")
        ]
        if len(parted) != len(self.names):
            return fields
        self.glued.append(line)
        return parted

    def number(self, line: int, column: int, field: str) -> float:
        if column in self.time_texts:
            if form_of_text(field) != self.clocks[column]:
                raise self.error(
                    line,
                    f"column {self.names[column]!r}: expected a {self.clocks[column]}, as in the first row; found "
                    f"{field[:40]!r}",
                )
            self.time_texts[column].append(field)
            return 0.0
        if self.texts and column in self.texts:
            self.texts[column].append(field[1:] if _ESCAPED.match(field) else field)
            return 0.0
        try:
            return parse_number(field.encode(), decimal_comma=self.options.decimal_comma)
        except NumberTextError as error:
            if field.lower() in _GAPS:
                if self.options.gaps is not None and column not in self.clocks:
                    return math.nan
                problem = error.problem if field else "expected a number, found nothing"
                raise self.error(line, f"column {self.names[column]!r}: {problem}; {GAPS_HINT}") from None
            raise self.error(line, f"column {self.names[column]!r}: {error.problem}") from None

    def text_columns(self, piece: bytes, first_line: int) -> list[int]:
        """Find columns that hold text: words in two rows at least, and no number, as far as the first rows tell."""
        rows = [fields for _, _, fields in islice(self.rows(piece, first_line), _ROWS_TO_TELL)]
        found = []
        for column in range(len(self.names)):
            cells = [fields[column] for fields in rows if len(fields) >= len(self.names)]
            words = [cell for cell in cells if cell.lower() not in _GAPS]
            if len(words) > 1 and column not in self.clocks and not any(_LIKE_A_NUMBER.match(cell) for cell in words):
                found.append(column)
        # A table of text alone is none of what is read here.
        return found if len(found) < len(self.names) else []

    def line_of_row(self, wanted: int) -> int:
        """Find the line of a row of numbers."""
        for row, (line, _, _) in enumerate(self.rows(self.data[self.body :], self.body_line)):
            if row == wanted:
                return line
        raise AssertionError("the row was read from this file")

    def signal(self) -> Signal:
        """Make a signal of what was read."""
        columns = self.time_columns()
        time = self.choose_clock(columns)
        frame = self.frame_column(time)
        clock = None if time is None else columns[time]
        rate, places = self.timing(clock)
        # Another column that says the same time is left out: retimed, the two would disagree.
        same = {place for place, other in columns.items() if clock is not None and other.agrees_with(clock)}
        dropped = {time, frame, *same, *self.time_texts, *self.layout.left_out}
        kept = [i for i in range(len(self.names)) if i not in dropped]
        if not kept:
            raise self.error(None, f"the table has no column beside {self.names[time or 0]!r}")
        known = {kept.index(column): kind for column, kind in self.layout.kinds.items() if column in kept}
        for column, texts in (self.texts or {}).items():
            if column in kept:
                self.values[:, column], known[kept.index(column)] = text_label(texts[: len(self.values)])
        number = 0 if frame is None else _count(self.values[:, frame]) or 0
        named, written = ("", Clock()) if clock is None else (clock.name, clock.clock)
        if clock is None and frame is not None and self.names[frame]:
            named, written = self.names[frame], Clock("frames", Fraction(number) / rate, str(number))
        signal = make_signal(
            self.path,
            [self.names[i] for i in kept],
            np.ascontiguousarray(self.values[:, kept]),
            rate,
            self.options,
            known,
            time_column=named,
            first_frame=number if clock is None else _first_frame(clock, rate, number),
            clock=written,
            dialect=self.layout.dialect,
        )
        if places is None:
            return signal
        return replace(signal, values=blended(signal.values, signal.names, signal.kinds, places))

    def time_columns(self) -> dict[int, TimeColumn]:
        """Take the columns that may hold times for times."""
        rate = self.options.rate or self.layout.rate
        found = {}
        # Numbers first: their rate tells how many frames a timecode beside them counts to its second.
        for column in sorted(self.clocks, key=lambda column: column in self.time_texts):
            times = found[column] = self.time_column(column, rate)
            rate = rate or times.told_rate()
        return {column: found[column] for column in self.clocks}

    def time_column(self, column: int, rate: Fraction | None) -> TimeColumn:
        """Take a column for times, of rows that are known, or not, to have this rate."""
        name = self.layout.clock_name or self.names[column] or "time"
        if column in self.time_texts:
            texts = self.time_texts[column][: len(self.values)]
            form: ClockForm = "timecode" if self.clocks[column] == "timecode" else "date"
            return text_times(name, texts, form, rate)
        times = np.array(self.values[:, column])
        return numeric_times(name, times, self.first_row()[column].replace(",", "."), self.known_form(column))

    def known_form(self, column: int) -> ClockForm | None:
        """Say in what a column of times counts, where somebody said it: a person, the head, or its name."""
        name = self.names[column]
        for pattern, kind in self.options.channels.items():
            if kind.kind == "time" and matching(pattern, [name]):
                return "ms" if kind.unit == "ms" else "us" if kind.unit == "us" else "s"
        return self.layout.clock_form or form_of_name(name)

    def choose_clock(self, columns: dict[int, TimeColumn]) -> int | None:
        """Choose the first column of times that rise; or one that should and doesn't, for its error."""
        for place, column in columns.items():
            if column.rises:
                return place
        usual = (place for place in columns if self.names[place].lower() in TIME_NAMES)
        return next(usual, None if self.options.rate is not None else next(iter(columns), None))

    def frame_column(self, time: int | None) -> int | None:
        """Find the column that numbers frames, if one counts up; raise FormatError where one without a name doesn't."""
        if 0 in self.layout.left_out and not self.names[0] and time != 0:
            if len(self.values) < 2 or _count(self.values[:, 0]) is None:
                raise self.unnamed(self.layout, 1)
            return 0
        if len(self.names) - (time is not None) < 2:
            return None
        frames = [i for i, name in enumerate(self.names) if is_frame_name(name) and i != time]
        return next((i for i in frames if _count(self.values[:, i]) is not None), None)

    def timing(self, clock: TimeColumn | None) -> tuple[Fraction, Places | None]:
        """Find the rate, and where between the rows frames are, if the rows are not even."""
        given = self.options.rate
        if clock is None:
            given = given or self.layout.rate
            if given is None:
                raise self.error(
                    None,
                    f"the table has no column of times ({', '.join(TIME_NAMES)}), so its rate must be given (--fps)",
                )
            return given, None
        try:
            clock.check(_RATE_HINT)
            if len(clock.times) == 1:
                return given or self.layout.rate or self.rate_of_one_row(clock), None
            even = clock.even
            rate = given or (self.declared_rate(clock.rate()) if even else self.layout.rate or clock.usual_rate())
        except TimesError as error:
            if given is not None:
                return given, None
            raise self.error(None if error.row is None else self.line_of_row(error.row), error.problem) from None
        self.say_form(clock)
        return rate, None if even else self.even_places(clock, rate)

    def declared_rate(self, measured: Fraction) -> Fraction:
        """Prefer the rate that the head says, where the times don't contradict it."""
        declared = self.layout.rate
        return measured if declared is None or abs(declared / measured - 1) > Fraction(1, 200) else declared

    def rate_of_one_row(self, clock: TimeColumn) -> Fraction:
        """Take the usual rate where a single row says none; say so."""
        warnings.warn(
            f"{self.path}: a single row's {clock.name!r} gives no rate: {RATE_OF_ONE_ROW} frames a second are taken "
            "(--fps says another)",
            FormatWarning,
            stacklevel=5,
        )
        return RATE_OF_ONE_ROW

    def say_form(self, clock: TimeColumn) -> None:
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
        column = next(place for place in self.clocks if self.names[place] == clock.name or self.layout.clock_name)
        if self.known_form(column) is None:
            what = str(clock.clock).partition(",")[0]
            warnings.warn(
                f"{self.path}: {clock.name!r} is taken for {what}, by the size of its numbers (--channel "
                f"'{clock.name}=time:s' takes it for seconds)",
                FormatWarning,
                stacklevel=4,
            )

    def even_places(self, clock: TimeColumn, rate: Fraction) -> Places:
        """Say where between the rows frames lie that are made at an even rate, and warn that they are made."""
        at = (clock.times - clock.times[0]) / clock.ticks
        n_frames = math.floor(at[-1] * float(rate) * (1 + 1e-12)) + 1
        if n_frames > self.options.limits.frames:
            raise self.error(
                None,
                f"{clock.name!r} goes over {at[-1]:.6g} s, {n_frames} frames at {float(rate):.6g} Hz, the limit is "
                f"{self.options.limits.frames} (Limits.frames)",
            )
        steps = np.diff(at)
        longest = int(steps.argmax())
        # What a few rows claim by their times is not taken on their word: one time that is wrong makes days of frames.
        n_rows, n_channels = self.values.shape
        numbers = n_frames * n_channels
        if (
            n_frames > max(_MOST_FRAMES_MADE, _MADE_OF_ONE * n_rows)
            or numbers > max(_MOST_MADE, _MADE_OF_ONE * self.values.size)
            or numbers > max(MOST_NUMBERS, self.values.size)
        ):
            raise self.error(
                self.line_of_row(longest + 1),
                f"{clock.name!r} goes on by {steps[longest]:.6g} s here, and {n_frames} frames of {n_channels} columns "
                f"({8 * numbers / 1e9:.2g} GB) would be made of {n_rows} rows; is this time right? A lower rate makes "
                "fewer (--fps)",
            )
        warnings.warn(
            f"{self.path}: the times in {clock.name!r} are uneven, {steps.min():.4g} to {steps.max():.4g} s apart (the "
            f"longest step ends at line {self.line_of_row(longest + 1)}); {n_frames} frames were made of "
            f"{len(at)} rows, where they stand in time, at {float(rate):.6g} Hz (--fps R makes another rate)",
            FormatWarning,
            stacklevel=4,
        )
        times = np.arange(n_frames) * rate.denominator / rate.numerator
        before = np.clip(np.searchsorted(at, times, side="right") - 1, 0, len(at) - 2)
        share = np.clip((times - at[before]) / steps[before], 0.0, 1.0)
        whole = share == 1.0
        return np.where(whole, before + 1, before), before + 1, np.where(whole, 0.0, share)


def _first_frame(clock: TimeColumn, rate: Fraction, numbered: int) -> int:
    """Give the first frame the number that its time is, where that is whole and a clip's; else that of its file."""
    start = clock.clock.start
    if start is None or clock.clock.origin != "clip":
        return numbered
    # As far as the last decimal tells.
    off = min(0.2, max(0.01, clock.unit / clock.ticks * float(rate)))
    whole = _whole(float(start * rate), off)
    return numbered if whole is None else whole


def _count(values: FloatArray) -> int | None:
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


def write(signal: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Write a CSV table: a column of times, then the channels, with as many digits as bring the numbers back.

    Parameters
    ----------
    signal : Signal
        What to write. Its column of times keeps its name, its form and where it began (`Signal.clock`). Where it had
        none it is called time, and the first frame's time is its number divided by the rate.
    path : Path
        Where.
    overwrite : bool
        Replace a file that is there.

    Raises
    ------
    FormatError
        Names are empty or repeat.
    OutputExistsError
        The file is there, and `overwrite` is not set.

    Warns
    -----
    FormatWarning
        The times can't say the rate exactly (a single row, say).
    """
    if not isinstance(signal, Signal):
        raise FormatError("a CSV table holds a signal, not a motion", path=path)
    seen: set[str] = set()
    for name in signal.names:
        if not name.strip():
            raise FormatError("a channel has no name, which a CSV table can't hold", path=path)
        if name in seen:
            raise FormatError(f"two channels are called {name!r}, which a CSV table can't hold", path=path)
        seen.add(name)
    time = next(
        (
            name
            for name in (signal.time_column, *TIME_NAMES)
            if (is_time_name(name) or (is_frame_name(name) and signal.clock.form == "frames")) and name not in seen
        ),
        None,
    )
    if time is None:
        raise FormatError(
            f"channels have all names that a column of times can have: {', '.join(TIME_NAMES)}", path=path
        )
    for name, column in zip(signal.names, signal.values.T, strict=True):
        if is_frame_name(name) and _count(column) is not None:
            warnings.warn(
                f"{path}: channel {name!r} goes up by one a row, so a reader takes it for the frames' numbers and not "
                "for a channel; another name keeps it one",
                FormatWarning,
                stacklevel=3,
            )
    time, times, exact = time_texts(signal, time)
    if time in seen:
        raise FormatError(f"a channel is called {time!r}, as the column of times must be", path=path)
    if not exact:
        warnings.warn(
            f"{path}: the column of times can't say that the rate is {signal.rate}; give it when the file is read "
            "(--fps)",
            FormatWarning,
            stacklevel=3,
        )
    delimiter = "\t" if path.suffix.lower() == ".tsv" else ","
    write_bytes(path, _parts(signal, time, times, delimiter), overwrite=overwrite)


def _parts(signal: Signal, time: str, times: list[str], delimiter: str) -> Iterator[bytes]:
    """Yield the file's bytes, some rows at a time."""
    text = StringIO()
    names = [f"'{name}" if _FORMULA.match(name) else name for name in signal.names]
    # A reader takes a tab or semicolon in the first line for the delimiter, so names that hold one are quoted.
    confusing = any(re.search("[\t;]", name) for name in names)
    writer = csv.writer(
        text, delimiter=delimiter, lineterminator="\n", quoting=csv.QUOTE_ALL if confusing else csv.QUOTE_MINIMAL
    )
    writer.writerow([time, *names])
    yield text.getvalue().encode("utf-8", "replace")
    numbers = all(kind.kind in ("linear", "angle", "quaternion") for kind in signal.kinds) and not signal.holes.any()
    for start in range(0, signal.n_frames, 1024):
        values = signal.values[start : start + 1024].tolist()
        rows = zip(times[start : start + 1024], values, strict=True)
        if numbers:
            yield "".join([f"{at}{delimiter}{delimiter.join(map(repr, row))}\n" for at, row in rows]).encode()
            continue
        text.seek(0)
        text.truncate()
        for at, row in rows:
            cells = [_cell(value, kind) for value, kind in zip(row, signal.kinds, strict=True)]
            writer.writerow([at, *cells])
        yield text.getvalue().encode("utf-8", "replace")


def _cell(value: float, kind: ChannelKind) -> str:
    """Write a value as its kind is written: a word, a whole number, nothing in a hole."""
    if math.isnan(value):
        return ""
    if kind.words:
        word = kind.words[int(value)]
        return f"'{word}" if _FORMULA.match(word) else word
    if kind.kind in ("label", "event") and value.is_integer():
        return str(int(value))
    return repr(value)
