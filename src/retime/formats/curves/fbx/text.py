"""FBX 7 in text: records as ``Name: values {records}``, comments behind a semicolon."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from retime.errors import FormatError
from retime.formats.curves.fbx.binary import refuse_version
from retime.formats.curves.fbx.file import ARRAYS, Changes, FbxFile, Record, Value
from retime.formats.number_rows import parse_rows
from retime.formats.read_options import Limits

# What parts records: blanks, line ends and comments.
_GAP = re.compile(rb"(?:[\s\x00]+|;[^\r\n]*)*")
_NAME = re.compile(rb"([A-Za-z_][^\s:,;{}\"]*)[ \t]*:[ \t]*")
_ONE = rb'(?:"[^"]*"|[^\s",;{}*]+)'
# Values in a row: one, and others behind commas, which may stand at the end of a line or at the beginning of the next.
_VALUES = re.compile(_ONE + rb"(?:\s*,\s*" + _ONE + rb")*")
_VALUE = re.compile(_ONE)
_ARRAY = re.compile(rb"\*(\d{1,18})\s*\{\s*(?:a\s*:)?")
_BRACE = re.compile(rb"\s*\{")
_WHOLE = re.compile(rb"[-+]?[0-9]{1,19}")
_NUMBER = re.compile(rb"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
_WHOLES = re.compile(rb"[-+0-9,\s]*")
_VERSION = re.compile(rb"FBXVersion\s*:\s*(\d{1,9})")
_COMMENT = re.compile(rb"[ \t]*;[ \t]*(\w*)")


class TextFbx(FbxFile):
    """A file in text."""

    def __init__(self, path: Path, data: bytes, limits: Limits) -> None:
        self.path, self.data, self.limits = path, data, limits
        found = _VERSION.search(data, 0, 1 << 16)
        if found is None:
            raise FormatError("no FBXVersion near its beginning: it is no FBX of version 7", path=path)
        self.version = int(found[1])
        refuse_version(path, self.version)
        self.records = self._read_records()

    def error(self, problem: str, record: Record | None = None) -> FormatError:
        """Make an error about this file, at a record."""
        return FormatError(problem, path=self.path, line=None if record is None else self._line(record.start))

    def _line(self, place: int) -> int:
        """Count lines up to a place: only for messages, for a file may have a billion."""
        return self.data.count(b"\n" if b"\n" in self.data else b"\r", 0, place) + 1

    def _line_start(self, place: int) -> int:
        # Most lines are short, and one of the two ends may be nowhere in the file.
        reach = 1 << 10
        while True:
            low = max(0, place - reach)
            found = max(self.data.rfind(b"\n", low, place), self.data.rfind(b"\r", low, place))
            if found >= 0 or not low:
                return found + 1
            reach <<= 4

    def _broken(self, problem: str, place: int) -> FormatError:
        return FormatError(problem, path=self.path, line=self._line(place))

    def _read_records(self) -> list[Record]:
        data = self.data
        outermost: list[Record] = []
        open_records: list[Record] = []
        here = outermost
        count = 0
        place = 3 if data.startswith(b"\xef\xbb\xbf") else 0
        while True:
            gap = _GAP.match(data, place)
            place = gap.end() if gap else place
            if place >= len(data):
                break
            if data[place : place + 1] == b"}":
                if not open_records:
                    raise self._broken("a brace too many", place)
                place += 1
                open_records.pop().end = place
                here = open_records[-1].children if open_records else outermost
                continue
            name = _NAME.match(data, place)
            if name is None:
                shown = data[place : place + 20].decode("utf-8", "replace")
                raise self._broken(f"expected the name of a record and a colon, found {shown!r}", place)
            count += 1
            if count > self.limits.records:
                raise FormatError(f"more than {self.limits.records} records (Limits.records)", path=self.path)
            start, place = place, name.end()
            values_end = self._values_end(place)
            record = Record(name[1].decode("latin-1"), start, values_end, place, values_end, -1)
            here.append(record)
            place = values_end
            brace = _BRACE.match(data, place)
            if brace:
                if len(open_records) > self.limits.depth:
                    raise self.error(f"records lie within each other more than {self.limits.depth} deep", record)
                place = brace.end()
                open_records.append(record)
                here = record.children
        if open_records:
            raise self._broken(
                f"the file ends within {open_records[-1].name}, which begins in line "
                f"{self._line(open_records[-1].start)}: it was cut",
                len(data),
            )
        return outermost

    def _values_end(self, place: int) -> int:
        array = _ARRAY.match(self.data, place)
        if array:
            end = self.data.find(b"}", array.end())
            if end < 0:
                raise self._broken("an array has no end: the file was cut", place)
            return end + 1
        values = _VALUES.match(self.data, place)
        return values.end() if values else place

    def spans(self, record: Record) -> list[tuple[int, int]]:
        """Return where each of a record's values begins and ends."""
        start, end = record.values_start, record.values_end
        if self.data[start : start + 1] == b"*":
            return [(start, end)]
        return [match.span() for match in _VALUE.finditer(self.data, start, end) if match[0] != b","]

    def value(self, record: Record, span: tuple[int, int]) -> Value:
        """Decode the value at a place."""
        token = self.data[span[0] : span[1]]
        if token.startswith(b"*"):
            return Value("d", self.array_at(record, span, "d"))
        if token.startswith(b'"'):
            return Value("S", token[1:-1].decode("utf-8", "replace").replace("&quot;", '"'))
        if _WHOLE.fullmatch(token):
            return Value("L", int(token))
        if _NUMBER.fullmatch(token):
            return Value("D", float(token))
        return Value("C", token.decode("latin-1"))

    def array_at(self, record: Record, span: tuple[int, int], kinds: str) -> NDArray[Any]:
        """Decode the array at a place."""
        head = _ARRAY.match(self.data, span[0])
        if head is None:
            raise self.error(f"{record.name} must be an array", record)
        body = self.data[head.end() : span[1] - 1].strip()
        kind = np.dtype(ARRAYS[kinds[0]])
        count = body.count(b",") + 1 if body else 0
        if count != int(head[1]):
            raise self.error(f"{record.name} claims {int(head[1])} numbers, it holds {count}", record)
        if not count:
            return np.zeros(0, dtype=kind)
        if kind.kind == "f":
            rows = parse_rows(re.sub(rb"\s+", b" ", body), count, delimiter=",")
            if rows is None:
                raise self.error(f"{record.name} holds what is no number", record)
            with np.errstate(over="ignore"):
                return np.asarray(rows[0].astype(kind))
        parts = body.split(b",")
        if not _WHOLES.fullmatch(body) or not all(_WHOLE.fullmatch(one.strip()) for one in parts):
            raise self.error(f"{record.name} holds what is no whole number", record)
        try:
            return np.array([int(one) for one in parts], dtype=kind)
        except OverflowError:
            raise self.error(f"{record.name} holds a whole number of more than {8 * kind.itemsize} bits", record) from (
                None
            )

    def rewritten(self, changes: Changes) -> bytes:
        """Return the file with some values exchanged, and without the comments that told the old ones."""
        data = self.data
        parts = [
            (*self.spans(record)[index], self._encoded(record, value)) for (record, index), value in changes.items()
        ]
        for record in {record for record, _ in changes}:
            # A program that explains KeyAttrFlags in a comment does so in the line before.
            here = self._line_start(record.start)
            start = self._line_start(here - (2 if data[max(0, here - 2) : here] == b"\r\n" else 1)) if here else 0
            comment = _COMMENT.match(data, start, here)
            if comment and comment[1].decode("latin-1") == record.name:
                parts.append((start, here, b""))
        pieces, place = [], 0
        for start, end, text in sorted(parts):
            pieces += [data[place:start], text]
            place = end
        return b"".join([*pieces, data[place:]])

    def _encoded(self, record: Record, value: Value) -> bytes:
        if value.letter not in ARRAYS:
            return text_of(value)
        indent = self.data[self._line_start(record.start) : record.start]
        if indent.strip():
            # Other text stands in front of it.
            indent = b""
        newline = b"\r\n" if b"\r\n" in self.data[:4096] else b"\n"
        inner = indent + (indent[:1] if indent[:1] == b"\t" else b"    ")
        numbers = np.asarray(value.content)
        body = b"a: " + array_text(numbers, value.letter) + newline
        return b"*%d {" % numbers.size + newline + inner + body + indent + b"}"


def text_of(value: Value) -> bytes:
    """Return a value that is no array as text."""
    letter, content = value
    if letter == "S":
        return b'"' + str(content).replace('"', "&quot;").encode("utf-8") + b'"'
    if letter in "FD":
        return repr(float(content)).encode()
    return str(content).encode("latin-1")


def array_text(numbers: NDArray[Any], letter: str) -> bytes:
    """Return numbers with commas between: the shortest text that says each of them."""
    return b",".join(numbers.astype(ARRAYS[letter]).astype("S32").tolist())
