"""What is known of a clip in files beside it (labels, contacts, events), taken through the clip's warp.

Two kinds of table and one of document are understood:

* a CSV with a row a frame (contacts, labels): its rows are shown as the clip's frames are, text by the nearest;
* a CSV with a row an event: columns called ``start_frame`` and ``end_frame``, ``start_t`` and ``end_t`` (and their like
  below) are ranges, ``frame`` or ``time`` are moments;
* JSON in which objects hold such pairs anywhere, as BABEL's do, and lists of one value a frame.

A range that the output shows twice (the warp runs backward there) becomes two; one that it leaves out is dropped; a
range or moment that it leaps over lies on the frame nearest to it.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from retime.arrays import IntArray
from retime.errors import FormatError
from retime.evaluate.metrics.spans import output_intervals
from retime.files import read_bytes
from retime.formats.number_text import NumberTextError, parse_number
from retime.formats.registry import read, write
from retime.formats.text_lines import utf8_text
from retime.motion.signal import Signal
from retime.strict_json import parse_json
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp

# First and last frame of a range (both included), and begin and end in seconds.
_FRAME_PAIRS = (("start_frame", "end_frame"), ("first_frame", "last_frame"), ("frame_start", "frame_end"))
_TIME_PAIRS = (
    ("start_t", "end_t"),
    ("start_time", "end_time"),
    ("start_s", "end_s"),
    ("start_seconds", "end_seconds"),
    ("start", "end"),
    ("onset", "offset"),
)
_FRAME_NAMES = ("frame", "frame_index")
_TIME_NAMES = ("time", "t", "time_s", "seconds")
# Of a document as a whole: how long, or how many frames, the clip is.
_LENGTHS = ("dur", "duration", "duration_s")
_COUNTS = ("n_frames", "num_frames", "frames", "frame_count")
# Seconds, and frames: a time so far outside of what is used is still its first or last moment.
_NEAR = 1e-6


@dataclass(frozen=True, eq=False)
class ShownFrames:
    """Which frames of a file an output shows.

    Attributes
    ----------
    warp : Warp
        Its input time 0 is the first frame used.
    rate : Fraction
        Frames a second, of input and output.
    n_file, first, n_used : int
        Frames of the file; the first one used, counted from the file's first; how many are used.
    """

    warp: Warp
    rate: Fraction
    n_file: int
    first: int
    n_used: int

    @property
    def duration(self) -> float:
        """Seconds of the output, each frame shown for a period."""
        return float(self.warp.count_frames(self.rate) / self.rate)

    @cached_property
    def frames(self) -> IntArray:
        """Return the file's frame that each output frame shows, to the nearest, shape (n_output,)."""
        return self.first + self.warp.to_frame_indices(float(self.rate), self.n_used)

    def ranges(self, first: int, last: int) -> list[tuple[int, int]]:
        """Return the output frames, both ends included, that show the file's frames from `first` to `last`."""
        shown = self.frames
        inside = (shown >= first) & (shown <= last)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(np.int8), [0]]))).reshape(-1, 2)
        if len(edges) == 0 and first <= self.first + self.n_used - 1 and last >= self.first:
            # Leapt over: the nearest frame stands for it.
            nearest = int(np.argmin(np.abs(shown - 0.5 * (first + last))))
            return [(nearest, nearest)]
        return [(int(start), int(stop) - 1) for start, stop in edges]

    def spans(self, start: float, end: float) -> list[tuple[float, float]]:
        """Return the output times, in seconds, that show the file's times from `start` to `end`."""
        offset = self.first / float(self.rate)
        used = (self.n_used - 1) / float(self.rate)
        low, high = max(start - offset, 0.0), min(end - offset, used)
        if low > high + _NEAR:
            # Within the last frame's own period nothing moves on.
            return [] if low > used + 1 / float(self.rate) or high < 0 else [(self.duration, self.duration)]
        found = output_intervals(self.warp, low, max(low, high))
        if not found:
            moment = self.moment(start)
            return [] if moment is None else [(moment, moment)]
        spans = [(begin, stop) for begin, stop in found]
        if end - offset > used + _NEAR:
            # The last frame is shown for a period; a range that reaches beyond it ends with the output.
            spans[-1] = (spans[-1][0], self.duration)
        return spans

    def moment(self, time: float) -> float | None:
        """Return the first output time that shows a time of the file, the nearest where none does; None outside."""
        wanted = time - self.first / float(self.rate)
        end = float(self.n_used / self.rate)
        if not -_NEAR <= wanted <= end + _NEAR:
            return None
        inputs, outputs = self.warp.input_times, self.warp.output_times
        low, high = np.minimum(inputs[:-1], inputs[1:]), np.maximum(inputs[:-1], inputs[1:])
        meets = np.flatnonzero((low <= wanted) & (wanted <= high))
        if len(meets) == 0:
            return float(outputs[int(np.argmin(np.abs(inputs - wanted)))])
        i = int(meets[0])
        change = inputs[i + 1] - inputs[i]
        share = 0.0 if change == 0 else (wanted - inputs[i]) / change
        return float(outputs[i] + share * (outputs[i + 1] - outputs[i]))


def retimed_beside(source: Path, shown: ShownFrames) -> bytes:
    """Return what a file beside a clip says of the clip's output.

    Parameters
    ----------
    source : Path
        The file (.csv, .tsv or .json).
    shown : ShownFrames
        What the output shows.

    Returns
    -------
    bytes
        Of a file of the same kind.

    Raises
    ------
    FormatError
        Neither ranges, moments, nor a value a frame are found in it, or it is no such file.
    """
    suffix = source.suffix.lower()
    if suffix == ".json":
        document = parse_json(read_bytes(source), what="a file of labels")
        lines = json.dumps(_Document(shown, source).retimed(document), indent=1, ensure_ascii=False)
        return lines.encode() + b"\n"
    if suffix in (".csv", ".tsv"):
        text = utf8_text(source, read_bytes(source))
        delimiter = "\t" if suffix == ".tsv" else max(",;\t", key=text.partition("\n")[0].count)
        rows = list(_rows(text, delimiter, source))
        mapped = _retimed_rows(rows, shown, source)
        if mapped is None:
            return _retimed_frames(source, shown)
        out = StringIO()
        csv.writer(out, delimiter=delimiter, lineterminator="\n").writerows(mapped)
        return out.getvalue().encode()
    raise FormatError("labels beside a clip are .csv, .tsv or .json", path=source)


def _rows(text: str, delimiter: str, source: Path) -> Iterator[list[str]]:
    """Part a table into its rows; blank lines are none."""
    reader = csv.reader(StringIO(text, newline=""), delimiter=delimiter)
    try:
        yield from filter(None, reader)
    except csv.Error as error:
        problem = f"expected fields parted by {delimiter!r}: {error}"
        raise FormatError(problem, path=source, line=reader.line_num) from None


def _retimed_frames(source: Path, shown: ShownFrames) -> bytes:
    """Show a table with a row a frame as the clip is shown."""
    table = read(source, rate=shown.rate, gaps="keep")
    assert isinstance(table, Signal)
    if table.n_frames != shown.n_file:
        raise FormatError(
            "expected columns of ranges (start_frame, end_frame; start_t, end_t), of moments (frame; time), or a row "
            f"for each of the clip's {shown.n_file} frames; found {table.n_frames} rows",
            path=source,
        )
    used = table.frames(shown.first, shown.first + shown.n_used)
    with TemporaryDirectory() as folder:
        place = Path(folder, source.name)
        write(apply_warp(used, shown.warp, average=False), place)
        return place.read_bytes()


def _pair(names: list[str], pairs: tuple[tuple[str, str], ...]) -> tuple[int, int] | None:
    for start, end in pairs:
        if start in names and end in names:
            return names.index(start), names.index(end)
    return None


def _retimed_rows(rows: list[list[str]], shown: ShownFrames, source: Path) -> list[list[str]] | None:
    """Map the rows of a table of events, or of one text or several a frame; None where it is neither."""
    if not rows:
        raise FormatError("the file is empty", path=source)
    names = [name.strip().lower() for name in rows[0]]
    frames, times = _pair(names, _FRAME_PAIRS), _pair(names, _TIME_PAIRS)
    body = rows[1:]
    mapped = [rows[0]]
    if frames is not None or times is not None:
        for line, row in enumerate(body, start=2):
            versions: list[dict[int, str]] | None = None
            if frames is not None:
                first, last = (_cell(row, column, _frame, source, line) for column in frames)
                versions = [dict(zip(frames, map(str, one), strict=True)) for one in shown.ranges(first, last)]
            if times is not None:
                start, end = (_cell(row, column, _time, source, line) for column in times)
                spans = [dict(zip(times, map(_seconds, one), strict=True)) for one in shown.spans(start, end)]
                # Both ways of saying it are kept side by side, as far as both have a version.
                versions = spans if versions is None else [a | b for a, b in zip(versions, spans, strict=False)]
            for new in versions or ():
                mapped.append([new.get(i, cell) for i, cell in enumerate(row)])
        return mapped
    single = next((name for name in (*_FRAME_NAMES, *_TIME_NAMES) if name in names), None)
    texts = next((part for part in (body, rows) if len(part) == shown.n_file), None)
    if texts is not None and not any(_is_number(cell) for row in texts for cell in row):
        # Nothing to be interpolated: each output frame has the row of the frame that it shows.
        return [*rows[: len(rows) - len(texts)], *(texts[frame] for frame in shown.frames.tolist())]
    if single is None or texts is body:
        return None
    column = names.index(single)
    for line, row in enumerate(body, start=2):
        if single in _FRAME_NAMES:
            ranges_found = shown.ranges(*[_cell(row, column, _frame, source, line)] * 2)
            value = str(ranges_found[0][0]) if ranges_found else None
        else:
            moment = shown.moment(_cell(row, column, _time, source, line))
            value = None if moment is None else _seconds(moment)
        if value is not None:
            mapped.append([value if i == column else cell for i, cell in enumerate(row)])
    return mapped


def _is_number(cell: str) -> bool:
    try:
        parse_number(cell.strip().encode())
    except NumberTextError:
        return False
    return True


def _frame(text: str) -> int:
    number = _time(text)
    if number != int(number):
        raise NumberTextError("expected a whole number")
    return int(number)


def _time(text: str) -> float:
    return parse_number(text.encode())


def _seconds(value: float) -> str:
    return f"{value:.6f}".rstrip("0").rstrip(".")


def _cell(row: list[str], column: int, number: Callable[[str], Any], source: Path, line: int) -> Any:
    if column >= len(row):
        raise FormatError("the row is too short", path=source, line=line)
    try:
        return number(row[column].strip())
    except NumberTextError:
        kind = "a frame's number" if number is _frame else "a time in seconds"
        raise FormatError(f"expected {kind}, found {row[column]!r}", path=source, line=line) from None


class _Document:
    """Maps a JSON document."""

    def __init__(self, shown: ShownFrames, source: Path) -> None:
        self.shown = shown
        self.source = source
        self.found = False

    def retimed(self, document: Any) -> Any:
        """Return the document for the output; raise FormatError where nothing in it speaks of times."""
        new = self._mapped(document)
        if not self.found:
            raise FormatError(
                "found no ranges (start_t, end_t; start_frame, end_frame), no moments, no list of one value a frame",
                path=self.source,
            )
        return new

    def _mapped(self, value: Any) -> Any:
        if isinstance(value, list):
            if len(value) == self.shown.n_file > 1 and not any(isinstance(one, dict) for one in value):
                self.found = True
                return [value[frame] for frame in self.shown.frames.tolist()]
            return [
                new for one in value for new in (self._events(one) if isinstance(one, dict) else [self._mapped(one)])
            ]
        if isinstance(value, dict):
            events = self._events(value)
            # Outside of a list there is room for one only: from the first beginning to the last end.
            return events[0] if events else None
        return value

    def _events(self, item: dict[str, Any]) -> list[dict[str, Any]]:
        """Return what becomes of an object: itself, or one for each range that shows its own."""
        names = list(item)
        lowered = [name.lower() for name in names]
        plain = {name: self._mapped(value) if isinstance(value, list | dict) else value for name, value in item.items()}
        for name in names:
            if name.lower() in _LENGTHS and self._is_number(item[name]):
                plain[name] = round(self.shown.duration, 6)
            elif name.lower() in _COUNTS and item[name] == self.shown.n_file:
                plain[name] = self.shown.warp.count_frames(self.shown.rate)
        changed: list[dict[str, Any]] | None = None
        for pairs, ranges, digits in ((_FRAME_PAIRS, self.shown.ranges, 0), (_TIME_PAIRS, self.shown.spans, 6)):
            pair = _pair(lowered, pairs)
            if pair is None:
                continue
            start, end = (item[names[i]] for i in pair)
            if not (self._is_number(start) and self._is_number(end)):
                continue
            self.found = True
            new = [
                {names[pair[0]]: round(low, digits), names[pair[1]]: round(high, digits)}
                for low, high in ranges(start, end)
            ]
            if changed is None:
                changed = new
            else:
                changed = [one | other for one, other in zip(changed, new, strict=False)]
        if changed is None:
            changed = self._moments(item, names, lowered)
        return [plain | one for one in changed]

    def _moments(self, item: dict[str, Any], names: list[str], lowered: list[str]) -> list[dict[str, Any]]:
        changed: dict[str, Any] = {}
        for name, low in zip(names, lowered, strict=True):
            if not self._is_number(item[name]):
                continue
            if low in _FRAME_NAMES and float(item[name]).is_integer():
                self.found = True
                ranges = self.shown.ranges(int(item[name]), int(item[name]))
                if not ranges:
                    return []
                changed[name] = ranges[0][0]
            elif low in _TIME_NAMES:
                self.found = True
                moment = self.shown.moment(float(item[name]))
                if moment is None:
                    return []
                changed[name] = round(moment, 6)
        return [changed]

    @staticmethod
    def _is_number(value: Any) -> bool:
        return isinstance(value, int | float) and not isinstance(value, bool)
