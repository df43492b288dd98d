"""Parquet: a signal as a table of columns, as data sets of robots (LeRobot) and of tables in general keep them.

Written are ``timestamp`` (seconds from the first frame, 32 bits), ``frame_index`` (from 0) and a column for each
channel; text stays text. What such a table can't say exactly stands in its metadata: the rate, the number of the first
frame, and what each channel holds.

Read is a column of numbers as a channel, one of lists of numbers (``observation.state``) as as many, text and booleans
as labels. A file holds one motion: of several episodes, one must be chosen before.

Needs the extra ``parquet`` (pyarrow).
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import warnings
from collections.abc import Sequence
from dataclasses import asdict, replace
from fractions import Fraction
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.child_process import child_environment
from retime.errors import FormatError, FormatWarning, MissingExtraError, OptionError
from retime.files import write_bytes
from retime.formats.channel_meaning import make_signal
from retime.formats.file_signatures import foreign_kind
from retime.formats.read_options import Limits, ReadOptions
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import ChannelKind, NumberForm, text_label
from retime.motion.clock import Clock
from retime.motion.rate import parse_rate, rate_from_step
from retime.motion.signal import Signal

_MAGIC = b"PAR1"
_TIME, _FRAME = "timestamp", "frame_index"
_TIMES = (_TIME, "time", "t", "seconds")
# Columns that number rows, where they do; and one that numbers motions.
_COUNTERS = (_FRAME, "frame", "index", "__index_level_0__")
_EPISODE = "episode_index"
_RATE, _FIRST_FRAME, _START, _KIND = b"retime.rate", b"retime.first_frame", b"retime.start", b"retime.kind"
_TICKS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
_FRACTION = re.compile(rb"-?[0-9]{1,40}(?:/[1-9][0-9]{0,39})?")
_CHILD = "import sys; from retime.formats.parquet import _child; _child(sys.argv[1])"
# How long reading may take, and what the process that tries it says of the memory.
_LEAST_SECONDS, _BYTES_A_SECOND, _NO_MEMORY = 60, 1e6, 3
_FPS_HINT = "; give the rate (--fps, rate=)"
# A small file may be all alike, and so compress well past the ratio.
_SMALL_BYTES = 1 << 20


def _pyarrow() -> Any:
    try:
        import pyarrow
        import pyarrow.compute
        import pyarrow.parquet
    except ImportError as error:
        raise MissingExtraError("a Parquet file", package="pyarrow", extra="parquet") from error
    return pyarrow


def read(path: Path, data: bytes, options: ReadOptions) -> Signal:
    """Read a Parquet table.

    Parameters
    ----------
    path : Path
        The file, for messages.
    data : bytes
        What it holds.
    options : ReadOptions
        What the reader was told.

    Returns
    -------
    Signal
        A channel for each column of numbers, but for those that count rows or time.

    Raises
    ------
    FormatError
        No Parquet table, a damaged one, one past the limits, several episodes, or no rate.
    MissingExtraError
        There is no pyarrow.

    Warns
    -----
    FormatWarning
        Columns were left out that hold no numbers (pictures, say).
    """
    if not (data.startswith(_MAGIC) and data.endswith(_MAGIC) and len(data) > 2 * len(_MAGIC)):
        kind = "a part of one: the file ends too soon" if data.startswith(_MAGIC) else foreign_kind(data)
        empty = "an empty file" if not data else "something else"
        raise FormatError(f"expected a Parquet table, found {kind or empty}", path=path)
    _pyarrow()
    _try_in_child(path, data, options.limits)
    return _decode(path, data, options.limits).signal(options)


def _decode(path: Path, data: bytes, limits: Limits) -> _Columns:
    """Read the columns of a table within the limits; raise FormatError."""
    arrow = _pyarrow()
    try:
        file = arrow.parquet.ParquetFile(BytesIO(data))
        _check_limits(path, file.metadata, limits, len(data))
        return _Columns(path, arrow, file)
    except (arrow.ArrowException, OSError, UnicodeDecodeError) as error:
        problem = str(error).strip().partition("\n")[0][:200]
        raise FormatError(f"a Parquet table that can't be read: {problem}", path=path) from None


def _try_in_child(path: Path, data: bytes, limits: Limits) -> None:
    """Raise FormatError where reading ends the process that does it, or fills the memory, or takes for ever.

    Damaged files make pyarrow end its process, so another one reads first. What that one says doesn't matter: the same
    bytes give the same again.
    """
    command = [sys.executable, "-c", _CHILD, json.dumps(asdict(limits))]
    environment = child_environment()
    seconds = _LEAST_SECONDS + len(data) / _BYTES_A_SECOND
    try:
        ended = subprocess.run(
            command, input=data, env=environment, capture_output=True, check=False, timeout=seconds
        ).returncode
    except subprocess.TimeoutExpired:
        raise FormatError(f"a Parquet table that is not read after {seconds:.0f} s", path=path) from None
    if ended == _NO_MEMORY:
        raise FormatError("a Parquet table that needs too much memory", path=path)
    if ended:
        raise FormatError(f"a damaged Parquet table: reading it ends the program that does ({ended})", path=path)


def _child(limits_text: str) -> None:
    """Read a table from the standard input, in a process that may die of it."""
    limits = Limits(**json.loads(limits_text))
    if sys.platform != "win32":
        import resource

        most = 3 * limits.inflated_bytes + (2 << 30)
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
    warnings.simplefilter("ignore")
    try:
        _decode(Path("-"), sys.stdin.buffer.read(), limits)
    except FormatError:
        # It is found again, with the path, where it is reported.
        sys.exit(0)
    except MemoryError:
        sys.exit(_NO_MEMORY)


def _check_limits(path: Path, metadata: Any, limits: Limits, n_bytes: int) -> None:
    """Refuse what a file claims past the limits, before anything is made of it."""
    if metadata.num_rows > limits.frames:
        raise FormatError(f"{metadata.num_rows} rows, the limit is {limits.frames} (Limits.frames)", path=path)
    if metadata.num_columns > limits.channels:
        raise FormatError(
            f"{metadata.num_columns} columns, the limit is {limits.channels} (Limits.channels)", path=path
        )
    inflated = n_values = 0
    for group in map(metadata.row_group, range(metadata.num_row_groups)):
        for column in map(group.column, range(metadata.num_columns)):
            inflated += column.total_uncompressed_size
            n_values += column.num_values
    if inflated > max(_SMALL_BYTES, limits.zip_ratio * n_bytes):
        raise FormatError(
            f"claims {inflated} bytes in {n_bytes}, more than {limits.zip_ratio}:1 (Limits.zip_ratio)", path=path
        )
    if max(inflated, 8 * n_values) > limits.inflated_bytes:
        raise FormatError(
            f"claims {max(inflated, 8 * n_values)} bytes, the limit is {limits.inflated_bytes} (Limits.inflated_bytes)",
            path=path,
        )


class _Columns:
    """The columns of one file as numbers."""

    def __init__(self, path: Path, arrow: Any, file: Any) -> None:
        self.path = path
        self.types = arrow.types
        self.arrow = arrow
        schema = file.schema_arrow
        self.metadata: dict[bytes, bytes] = dict(schema.metadata or {})
        for name in schema.names:
            if schema.names.count(name) > 1:
                raise FormatError(f"two columns are called {name!r}", path=path)
        usable = [field for field in schema if self.usable(field.type)]
        left_out = [field.name for field in schema if not self.usable(field.type)]
        if left_out:
            some = ", ".join(left_out[:8]) + (" ..." if len(left_out) > 8 else "")
            warnings.warn(f"{path}: columns that hold no numbers were left out: {some}", FormatWarning, stacklevel=4)
        self.names: list[str] = []
        self.numbers: list[FloatArray] = []
        self.kinds: dict[int, ChannelKind] = {}
        self.forms: dict[int, NumberForm] = {}
        # Seconds that one in the last place stands for, of moments.
        self.units: dict[int, float] = {}
        if usable:
            table = file.read(columns=[field.name for field in usable], use_threads=False)
            for field in usable:
                self.add(field, table.column(field.name).combine_chunks())
        if not self.names or not len(self.numbers[0]):
            raise FormatError("the table has no row of numbers", path=path)

    def is_number(self, kind: Any) -> bool:
        return bool(self.types.is_integer(kind) or self.types.is_floating(kind))

    def is_text(self, kind: Any) -> bool:
        if self.types.is_dictionary(kind):
            kind = kind.value_type
        return bool(self.types.is_string(kind) or self.types.is_large_string(kind))

    def is_list(self, kind: Any) -> bool:
        any_list = self.types.is_list(kind) or self.types.is_large_list(kind) or self.types.is_fixed_size_list(kind)
        return bool(any_list and self.is_number(kind.value_type))

    def usable(self, kind: Any) -> bool:
        moment = self.types.is_timestamp(kind) or self.types.is_duration(kind)
        return bool(
            self.is_number(kind) or self.is_text(kind) or self.is_list(kind) or self.types.is_boolean(kind) or moment
        )

    def add(self, field: Any, column: Any) -> None:
        """Take a column for one channel or, of lists, for several."""
        place = len(self.names)
        if self.is_list(field.type):
            self.add_list(field.name, column)
        elif self.is_text(field.type):
            texts = [text or "" for text in column.to_pylist()]
            # A gap has no word.
            codes, kind = text_label([text for text in texts if text])
            numbers = np.full(len(texts), np.nan)
            numbers[[bool(text) for text in texts]] = codes
            self.names.append(field.name)
            self.numbers.append(numbers)
            self.kinds[place] = kind
        else:
            self.names.append(field.name)
            self.numbers.append(self.floats(column))
            if self.types.is_timestamp(field.type) or self.types.is_duration(field.type):
                self.kinds[place] = ChannelKind("time")
                self.units[place] = 1 / _TICKS[field.type.unit]
            elif self.types.is_boolean(field.type) or field.name.endswith("_index"):
                self.kinds[place] = ChannelKind("label")
        said = (field.metadata or {}).get(_KIND)
        if said is not None and place < len(self.names) and not self.is_text(field.type):
            try:
                self.kinds[place] = ChannelKind.parse(said.decode("utf-8", "replace"))
            except OptionError as error:
                raise FormatError(f"column {field.name!r}: {error}", path=self.path) from None

        if self.types.is_boolean(field.type):
            self.forms[place] = "boolean"
        elif self.types.is_integer(field.type):
            self.forms[place] = "whole"

    def add_list(self, name: str, column: Any) -> None:
        lengths = self.arrow.compute.list_value_length(column).unique().to_pylist()
        length = int(lengths[0] or 0) if len(lengths) == 1 else 0
        if not length:
            found = ", ".join("nothing" if one is None else str(one) for one in lengths[:5])
            raise FormatError(
                f"column {name!r} holds lists of {found} numbers; expected as many in each row", path=self.path
            )
        numbers = self.floats(column.flatten()).reshape(len(column), length)
        self.names += [f"{name}.{i}" for i in range(length)]
        self.numbers += list(numbers.T)

    def floats(self, column: Any) -> FloatArray:
        """Make doubles; what is missing is not a number. Moments and spans of time come out in seconds."""
        kind = column.type
        ticks = 1.0
        if self.types.is_timestamp(kind) or self.types.is_duration(kind):
            ticks = _TICKS[kind.unit]
            # From the first one on, which keeps them exact.
            column = column.cast(self.arrow.int64())
            column = self.arrow.compute.subtract(column, column[0])
        if self.types.is_boolean(kind):
            column = column.cast(self.arrow.uint8())
        numbers: FloatArray = column.cast(self.arrow.float64()).to_numpy(zero_copy_only=False)
        return numbers / ticks

    def signal(self, options: ReadOptions) -> Signal:
        """Make a signal of what was read."""
        lower = [name.lower() for name in self.names]
        if _EPISODE in lower:
            episodes = np.unique(self.numbers[lower.index(_EPISODE)])
            if len(episodes) > 1:
                raise FormatError(
                    f"holds {len(episodes)} episodes, and a motion is one: write one of them ({_EPISODE} == "
                    f"{episodes[0]:g}) to a file of its own",
                    path=self.path,
                )
        time = next((lower.index(name) for name in _TIMES if name in lower), None)
        counters = [
            place
            for place, name in enumerate(lower)
            if name in _COUNTERS and place != time and bool(np.all(np.diff(self.numbers[place]) == 1))
        ]
        kept = [place for place in range(len(self.names)) if place != time and place not in counters]
        if not kept:
            raise FormatError("the table has no column beside those that count rows and time", path=self.path)
        rate = options.rate or self.rate(None if time is None else self.numbers[time], time)
        first = next((self.numbers[place][0] for place in counters if lower[place] in _COUNTERS[:2]), 0.0)
        made = make_signal(
            self.path,
            [self.names[place] for place in kept],
            np.stack([self.numbers[place] for place in kept], axis=1),
            rate,
            options,
            {new: self.kinds[place] for new, place in enumerate(kept) if place in self.kinds},
            first_frame=int(self.number(_FIRST_FRAME) or 0) + int(first),
            clock=Clock("s", self.number(_START)).later(int(first) / rate),
            time_column="" if time is None else self.names[time],
        )
        forms = [self.forms.get(place, "") for place in kept]
        kinds = [replace(kind, form=form) for kind, form in zip(made.kinds, forms, strict=True)]
        return replace(made, kinds=tuple(kinds))

    def number(self, key: bytes) -> Fraction | None:
        """Return a number of the metadata, as `write` says it, if it is there: of or at the frame that counts as 0."""
        said = self.metadata.get(key)
        if said is None:
            return None
        if not _FRACTION.fullmatch(said):
            raise FormatError(f"{key.decode()} in the metadata is no number: {said[:40]!r}", path=self.path)
        return Fraction(said.decode("ascii"))

    def rate(self, times: FloatArray | None, column: int | None) -> Fraction:
        """Find the rate: what `write` says of it, where times agree, else that of even times."""
        said = None
        if _RATE in self.metadata:
            try:
                said = parse_rate(self.metadata[_RATE].decode("utf-8", "replace"))
            except OptionError as error:
                raise FormatError(f"the metadata's rate: {error}", path=self.path) from None
        if times is None or column is None or len(times) < 2:
            if said is None:
                raise FormatError(
                    f"the table has no rows of times ({', '.join(_TIMES)}) to tell its rate{_FPS_HINT}", path=self.path
                )
            return said
        name = self.names[column]
        steps = np.diff(times)
        if not np.all(steps > 0):
            row = int(np.flatnonzero(~(steps > 0))[0]) + 1
            goes = f"row {row}: {name!r} goes from {times[row - 1]:.10g} to {times[row]:.10g}"
            raise FormatError(f"{goes}; times must increase{_FPS_HINT}", path=self.path)
        step = float(times[-1] - times[0]) / len(steps)
        # Times of 32 bits, as they are usual, are this coarse.
        coarse = self.units.get(column) or float(np.spacing(np.float32(np.abs(times).max())))
        off = np.abs(steps - step)
        if off.max() > max(0.01 * step, min(2 * coarse, 0.75 * step)):
            row = int(off.argmax()) + 1
            goes = f"row {row}: {name!r} goes from {times[row - 1]:.10g} to {times[row]:.10g}"
            raise FormatError(
                f"{goes}, a step of {steps[row - 1]:.6g} where the mean is {step:.6g}; times must be even{_FPS_HINT}",
                path=self.path,
            )
        if said is not None and abs(step * float(said) - 1) < 1e-3:
            return said
        if step >= 2:
            raise FormatError(f"{name!r} goes on by {step:g} a row, which can't be seconds{_FPS_HINT}", path=self.path)
        try:
            return rate_from_step(Fraction(step), Fraction(coarse) / len(steps))
        except ValueError as error:
            raise FormatError(f"{name!r}: {error}{_FPS_HINT}", path=self.path) from None


def write(signal: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Write a Parquet table: ``timestamp``, ``frame_index``, and the channels.

    Parameters
    ----------
    signal : Signal
        What to write.
    path : Path
        Where.
    overwrite : bool
        Replace a file that is there.

    Raises
    ------
    FormatError
        Names are empty, repeat, or are those of the first two columns.
    MissingExtraError
        There is no pyarrow.
    OutputExistsError
        The file is there, and `overwrite` is not set.
    """
    if not isinstance(signal, Signal):
        raise FormatError("a Parquet table holds a signal, not a motion", path=path)
    _check_names(signal.names, path)
    arrow = _pyarrow()
    index = np.arange(signal.n_frames)
    seconds = index * float(signal.rate.denominator) / float(signal.rate.numerator)
    arrays = [arrow.array(seconds.astype(np.float32)), arrow.array(index.astype(np.int64))]
    fields = [arrow.field(_TIME, arrow.float32()), arrow.field(_FRAME, arrow.int64())]
    for name, kind, numbers in zip(signal.names, signal.kinds, signal.values.T, strict=True):
        if kind.words:
            arrays.append(arrow.array([word or None for word in signal.texts(name)], arrow.string()))
        else:
            arrays.append(_stored(arrow, numbers, kind))
        fields.append(arrow.field(name, arrays[-1].type, metadata={_KIND: str(kind).encode()}))
    facts = {_RATE: str(signal.rate).encode(), _FIRST_FRAME: str(signal.first_frame).encode()}
    if signal.clock.start is not None:
        facts[_START] = str(signal.clock.start).encode()
    table = arrow.Table.from_arrays(arrays, schema=arrow.schema(fields, metadata=facts))
    file = BytesIO()
    arrow.parquet.write_table(table, file)
    write_bytes(path, file.getvalue(), overwrite=overwrite)


def _stored(arrow: Any, numbers: FloatArray, kind: ChannelKind) -> Any:
    """Store a channel as its file did where nothing was interpolated: truths, whole numbers; else as doubles."""
    column = arrow.array(np.ascontiguousarray(numbers), from_pandas=True)
    known = numbers[~np.isnan(numbers)]
    if kind.kind in ("label", "event"):
        # Somebody may have put other numbers there since.
        if kind.form == "boolean" and np.all((known == 0) | (known == 1)):
            return column.cast(arrow.bool_())
        if kind.form == "whole" and np.all((known == np.round(known)) & (np.abs(known) < 2.0**53)):
            return column.cast(arrow.int64())
    return column


def _check_names(names: Sequence[str], path: Path) -> None:
    taken = {_TIME, _FRAME}
    for name in names:
        if not name.strip():
            raise FormatError("a channel has no name, which a Parquet table can't hold", path=path)
        if name in taken:
            twice = "is the name of a column that counts" if name in (_TIME, _FRAME) else "is the name of two channels"
            raise FormatError(f"{name!r} {twice}, which a Parquet table can't hold", path=path)
        taken.add(name)
