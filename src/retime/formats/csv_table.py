"""CSV: a signal as a table, a row for each frame and a column for each channel.

The first row names the columns; where it is all numbers there is no such row, and they are called c0, c1 ... A column
called time, t, seconds or timestamp gives the rate and is no channel, and neither is one called frame that counts up by
one. Fields are separated by commas, semicolons or tabs, whichever the first line uses.

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
from retime.formats.number_text import NumberTextError, parse_number
from retime.formats.read_options import ReadOptions
from retime.formats.text_lines import without_byte_order_mark, without_end_padding
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import ChannelKind, text_label
from retime.motion.rate import rate_from_step
from retime.motion.signal import Signal, numbered_names

TIME_NAMES = ("time", "t", "seconds", "timestamp")
_FRAME_NAME = "frame"
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
        self.delimiter = self.find_delimiter()
        self.body, self.body_line = 0, 1
        self.names = self.header()
        self.values = np.empty((0, len(self.names)))
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

    def header(self) -> list[str]:
        line, offset, fields = next(self.rows(self.data, 1), (1, 0, []))
        if not fields:
            raise self.error(None, "the file is blank; expected a table of numbers")
        if len(fields) > self.options.limits.channels:
            raise self.error(
                line, f"{len(fields)} columns, the limit is {self.options.limits.channels} (Limits.channels)"
            )
        if all(self.numeric(field) for field in fields):
            return list(numbered_names(len(fields)))
        self.body = offset
        self.body_line = 1 + self.data.count(b"\n", 0, offset)
        names = []
        columns: dict[str, int] = {}
        for i, field in enumerate(fields, 1):
            name = field[1:] if _ESCAPED.match(field) else field
            if not name:
                raise self.error(line, f"column {i} of {len(fields)} has no name")
            if len(name.encode()) > self.options.limits.name_bytes:
                raise self.error(
                    line,
                    f"the name of column {i} is longer than {self.options.limits.name_bytes} bytes (Limits.name_bytes)",
                )
            if name in columns:
                raise self.error(
                    line, f"columns {columns[name]} and {i} are both called {name!r}; each needs its own name"
                )
            columns[name] = i
            names.append(name)
        return names

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
            rows = parse_rows(
                piece,
                len(self.names),
                delimiter=self.delimiter,
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

    def number(self, line: int, column: int, field: str) -> float:
        if self.texts and column in self.texts:
            self.texts[column].append(field[1:] if _ESCAPED.match(field) else field)
            return 0.0
        try:
            return parse_number(field.encode(), decimal_comma=self.options.decimal_comma)
        except NumberTextError as error:
            if field.lower() in _GAPS:
                if self.options.gaps is not None and self.names[column].lower() not in TIME_NAMES:
                    return math.nan
                problem = error.problem if field else "expected a number, found nothing"
                raise self.error(line, f"column {self.names[column]!r}: {problem}; {GAPS_HINT}") from None
            raise self.error(line, f"column {self.names[column]!r}: {error.problem}") from None

    def text_columns(self, piece: bytes, first_line: int) -> list[int]:
        """Find columns that hold text: words in two rows at least, and no number, as far as the first rows tell."""
        rows = [fields for _, _, fields in islice(self.rows(piece, first_line), _ROWS_TO_TELL)]
        found = []
        for column, name in enumerate(self.names):
            cells = [fields[column] for fields in rows if len(fields) == len(self.names)]
            words = [cell for cell in cells if cell.lower() not in _GAPS]
            if (
                len(words) > 1
                and name.lower() not in TIME_NAMES
                and not any(_LIKE_A_NUMBER.match(cell) for cell in words)
            ):
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
        lower = [name.lower() for name in self.names]
        time = next((i for i, name in enumerate(lower) if name in TIME_NAMES), None)
        frame = lower.index(_FRAME_NAME) if _FRAME_NAME in lower else None
        if frame is not None and (len(lower) - (time is not None) < 2 or not _counts_up(self.values[:, frame])):
            frame = None
        rate = self.options.rate
        if rate is None:
            if time is None:
                raise self.error(
                    None,
                    f"the table has no column of times ({', '.join(TIME_NAMES)}), so its rate must be given (--fps)",
                )
            rate = self.rate_of(time)
        kept = [i for i in range(len(lower)) if i not in (time, frame)]
        if not kept:
            raise self.error(None, f"the table has no column beside {self.names[time or 0]!r}")
        first_frame = None if time is None else _whole(float(self.values[0, time]) * float(rate))
        if first_frame is None:
            first_frame = 0 if frame is None else int(self.values[0, frame])
        known = {}
        for column, texts in (self.texts or {}).items():
            self.values[:, column], known[kept.index(column)] = text_label(texts[: len(self.values)])
        return make_signal(
            self.path,
            [self.names[i] for i in kept],
            np.ascontiguousarray(self.values[:, kept]),
            rate,
            self.options,
            known,
            time_column="" if time is None else self.names[time],
            first_frame=first_frame,
        )

    def rate_of(self, column: int) -> Fraction:
        """Find the rate of a column of times, which must be even."""
        times, name = self.values[:, column], self.names[column]
        hint = "; a rate that is given (--fps) takes the rows as even"
        if len(times) == 1:
            raise self.error(None, f"a single row's {name!r} gives no rate, so it must be given (--fps)")
        far = np.flatnonzero(~(np.abs(times) < 2.0**53))
        if len(far):
            row = int(far[0])
            raise self.error(
                self.line_of_row(row), f"row {row + 1}: {name!r} is {times[row]:.6g}, too large for a time{hint}"
            )
        steps = np.diff(times)
        back = np.flatnonzero(~(steps > 0))
        if len(back):
            row = int(back[0]) + 1
            raise self.error(
                self.line_of_row(row),
                f"row {row + 1}: {name!r} goes from {times[row - 1]:.10g} to {times[row]:.10g}; times must "
                f"increase{hint}",
            )
        step = float((times[-1] - times[0]) / (len(times) - 1))
        off = np.abs(steps - step)
        unit = _unit(times, self.decimals(column))
        if off.max() > max(0.01 * step, min(2 * unit, 0.75 * step)):
            row = int(off.argmax()) + 1
            raise self.error(
                self.line_of_row(row),
                f"row {row + 1}: {name!r} goes from {times[row - 1]:.10g} to {times[row]:.10g}, a step of "
                f"{steps[row - 1]:.6g} where the mean is {step:.6g}; times must be even{hint}",
            )
        rate = _rate(times, unit)
        if rate is None:
            raise self.error(None, f"the mean step of {name!r}, {step:.6g} s, gives no rate of 0.000001 to 1,000,000")
        return rate

    def decimals(self, column: int) -> int:
        """Count the decimals of a column in the first row, for times such as 0.50 and 1.00 that don't show them all."""
        _, _, fields = next(self.rows(self.data[self.body :], self.body_line))
        return len(re.sub("[eE].*", "", fields[column].replace(",", ".")).partition(".")[2])


def _counts_up(values: FloatArray) -> bool:
    """Whether numbers are whole and go up by one."""
    with np.errstate(over="ignore"):
        return _whole(float(values[0])) == values[0] and bool(np.all(np.diff(values) == 1))


def _whole(number: float) -> int | None:
    """Round a number that is whole, but for the rounding of what it was made of; None where it isn't."""
    if not abs(number) < 2**53 or abs(number - round(number)) > 0.01:
        return None
    return round(number)


def _unit(times: FloatArray, at_least: int) -> float:
    """Find the size of one in the last decimal that times are written with: `at_least`, or more if they need more."""
    largest = float(np.max(np.abs(times)))
    spacing = 2 * float(np.spacing(largest))
    for decimals in range(at_least, 17):
        if 10.0**-decimals <= spacing:
            break
        if np.array_equal(np.round(times, decimals), times):
            return 10.0**-decimals
    return spacing


def _rate(times: FloatArray, unit: float) -> Fraction | None:
    """Find the exact rate behind times that are even but for their last decimal's `unit`; None where there is none."""
    n_steps = len(times) - 1
    step = (Fraction(float(times[-1])) - Fraction(float(times[0]))) / n_steps
    try:
        # Each end was rounded or cut, by one unit at most.
        return rate_from_step(step, Fraction(unit) / n_steps)
    except ValueError:
        return None


def write(signal: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Write a CSV table: a column of times, then the channels, with as many digits as bring the numbers back.

    Parameters
    ----------
    signal : Signal
        What to write. Its column of times keeps its name; where it had none it is called time. The first frame's time
        is its number divided by the rate.
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
        (name for name in (signal.time_column, *TIME_NAMES) if name.lower() in TIME_NAMES and name not in seen), None
    )
    if time is None:
        raise FormatError(
            f"channels have all names that a column of times can have: {', '.join(TIME_NAMES)}", path=path
        )
    times, decimals = _exact_times(signal, path)
    write_bytes(path, _parts(signal, time, times, decimals), overwrite=overwrite)


def _exact_times(signal: Signal, path: Path) -> tuple[FloatArray, int]:
    """Find times with just enough decimals for a reader to find the exact rate, six at least."""
    frames = signal.first_frame + np.arange(signal.n_frames, dtype=np.float64)
    times = frames * signal.rate.denominator / signal.rate.numerator
    # Neighbouring times must differ in two digits at least.
    least = max(6, 2 + math.ceil(math.log10(float(signal.rate))))
    if signal.n_frames > 1:
        for decimals in range(least, least + 12):
            written = np.round(times, decimals)
            if np.all(np.diff(written) > 0) and _rate(written, _unit(written, decimals)) == signal.rate:
                return written, decimals
    warnings.warn(
        f"{path}: the column of times can't say that the rate is {signal.rate}; give it when the file is read (--fps)",
        FormatWarning,
        stacklevel=4,
    )
    return times, least + 6


def _parts(signal: Signal, time: str, times: FloatArray, decimals: int) -> Iterator[bytes]:
    """Yield the file's bytes, some rows at a time."""
    text = StringIO()
    names = [f"'{name}" if _FORMULA.match(name) else name for name in signal.names]
    # A reader takes a tab or semicolon in the first line for the delimiter, so names that hold one are quoted.
    confusing = any(re.search("[\t;]", name) for name in names)
    writer = csv.writer(text, lineterminator="\n", quoting=csv.QUOTE_ALL if confusing else csv.QUOTE_MINIMAL)
    writer.writerow([time, *names])
    yield text.getvalue().encode("utf-8", "replace")
    numbers = all(kind.kind in ("linear", "angle", "quaternion") for kind in signal.kinds) and not signal.holes.any()
    for start in range(0, signal.n_frames, 1024):
        values = signal.values[start : start + 1024].tolist()
        rows = zip(times[start : start + 1024].tolist(), values, strict=True)
        if numbers:
            yield "".join([f"{at:.{decimals}f},{','.join(map(repr, row))}\n" for at, row in rows]).encode()
            continue
        text.seek(0)
        text.truncate()
        for at, row in rows:
            cells = [_cell(value, kind) for value, kind in zip(row, signal.kinds, strict=True)]
            writer.writerow([f"{at:.{decimals}f}", *cells])
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
