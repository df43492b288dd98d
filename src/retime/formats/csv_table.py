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
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from io import StringIO
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, FormatWarning
from retime.files import write_bytes
from retime.formats.channel_meaning import make_signal
from retime.formats.file_signatures import foreign_kind
from retime.formats.read_options import ReadOptions
from retime.formats.tables.numerals import with_numerals
from retime.formats.tables.table_clock import TIME_NAMES, TableClock, counted_from, find_clocks, first_frame
from retime.formats.tables.table_rows import TableRows
from retime.formats.tables.table_text import TableText
from retime.formats.tables.time_names import is_frame_name, is_time_name
from retime.formats.tables.time_writer import time_texts
from retime.formats.text_lines import without_byte_order_mark, without_end_padding
from retime.motion.any_motion import AnyMotion
from retime.motion.blending import blended
from retime.motion.channels import ChannelKind, text_label
from retime.motion.clock import Clock
from retime.motion.signal import Signal

_FORMULA = re.compile(r"[\s']*[=+\-@]")
_NUMBER = re.compile(r"[+-][0-9]+")


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
        text = TableText(path, data, options)
        rows = TableRows(text, find_clocks(text))
        for note in rows.read():
            warnings.warn(f"{path}: {note}", FormatWarning, stacklevel=3)
        return _signal(text, rows)
    except FormatError as error:
        if kind is None:
            raise
        raise FormatError(
            f"this is {kind}; expected a table of numbers", path=path, line=error.line, byte=error.byte
        ) from None


def _signal(text: TableText, rows: TableRows) -> Signal:
    """Make a signal of what was read."""
    times = TableClock(text, rows)
    columns = times.time_columns()
    time = times.choose_clock(columns)
    frame = times.frame_column(time)
    clock = None if time is None else columns[time]
    rate, places = times.timing(clock)
    # Another column that says the same time is left out: retimed, the two would disagree.
    same = {place for place, other in columns.items() if clock is not None and other.agrees_with(clock)}
    dropped = {time, frame, *same, *rows.time_texts, *text.layout.left_out}
    kept = [i for i in range(len(text.names)) if i not in dropped]
    if not kept:
        raise text.error(None, f"the table has no column beside {text.names[time or 0]!r}")
    known = {kept.index(column): kind for column, kind in text.layout.kinds.items() if column in kept}
    for column, texts in (rows.texts or {}).items():
        if column in kept:
            rows.values[:, column], known[kept.index(column)] = text_label(texts[: len(rows.values)])
    values = np.ascontiguousarray(rows.values[:, kept])
    known = with_numerals(rows, kept, values, known, text.options)
    number = 0 if frame is None else counted_from(rows.values[:, frame]) or 0
    named, written = ("", Clock()) if clock is None else (clock.name, clock.clock)
    if clock is None and frame is not None and text.names[frame]:
        named, written = text.names[frame], Clock("frames", Fraction(number) / rate, str(number))
    signal = make_signal(
        text.path,
        [text.names[i] for i in kept],
        values,
        rate,
        text.options,
        known,
        time_column=named,
        first_frame=number if clock is None else first_frame(clock, rate, number),
        clock=written,
        dialect=text.layout.dialect,
    )
    if places is None:
        return signal
    return replace(signal, values=blended(signal.values, signal.names, signal.kinds, places))


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
        # Alone, it is all that the table holds, and so a channel.
        if len(signal.names) > 1 and is_frame_name(name) and counted_from(column) is not None:
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
    cells = [_cell_writer(column, kind) for column, kind in zip(signal.values.T, signal.kinds, strict=True)]
    # Words alone may need quotes.
    worded = any(kind.words for kind in signal.kinds)
    for start in range(0, signal.n_frames, 1024):
        stop = start + 1024
        columns = [map(cell, signal.values[start:stop, place].tolist()) for place, cell in enumerate(cells)]
        rows = zip(times[start:stop], *columns, strict=True)
        if not worded:
            yield "".join([f"{delimiter.join(row)}\n" for row in rows]).encode()
            continue
        text.seek(0)
        text.truncate()
        writer.writerows(rows)
        yield text.getvalue().encode("utf-8", "replace")


def _cell_writer(values: FloatArray, kind: ChannelKind) -> Callable[[float], str]:
    """Say how the values of a channel are written: as words, as their file writes its numbers, as nothing in a hole."""
    holes = np.isnan(values)
    write: Callable[[float], str] = repr
    if kind.words:
        # A number is no formula.
        words = [f"'{word}" if _FORMULA.match(word) and not _NUMBER.fullmatch(word) else word for word in kind.words]
        write = _word_writer(words)
    elif kind.numerals:
        write = _numeral_writer(kind.numerals)
    elif kind.kind in ("label", "event"):
        write = _whole_or_decimal
    elif kind.form == "whole" and np.all(holes | (values == np.round(values))):
        # As soon as something lies between, all of the column has decimals.
        write = _whole
    return _hole_or(write) if holes.any() else write


def _word_writer(words: Sequence[str]) -> Callable[[float], str]:
    return lambda value: words[int(value)]


def _numeral_writer(numerals: Sequence[str]) -> Callable[[float], str]:
    # By its text a zero has its sign.
    texts = {repr(float(text)): text for text in reversed(numerals)}
    return lambda value: texts.get(repr(value)) or _whole_or_decimal(value)


def _whole_or_decimal(value: float) -> str:
    return str(int(value)) if value.is_integer() else repr(value)


def _whole(value: float) -> str:
    return f"{value:.0f}"


def _hole_or(write: Callable[[float], str]) -> Callable[[float], str]:
    return lambda value: "" if math.isnan(value) else write(value)
