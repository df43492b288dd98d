"""Binary FBX 7: heads of 32 bits below version 7500, of 64 from there on."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from retime.errors import FormatError
from retime.formats.curves.fbx.file import ARRAYS, Changes, FbxFile, Record, Value, all_records, inflated
from retime.formats.read_options import Limits

MAGIC = b"Kaydara FBX Binary  \x00\x1a\x00"
_START = len(MAGIC) + 4
_PLAIN = {"Y": "<h", "C": "<B", "B": "<B", "I": "<i", "L": "<q", "F": "<f", "D": "<d"}
LAST = bytes.fromhex("f85a8c6adef5d97eece90ce3758f290b")
# Behind the last record: sixteen bytes that stand for the time of creation, zeros up to a multiple of 16, the version,
# 120 zeros, and the mark above.
_FOOT_ID, _FOOT_END = 16, 4 + 120 + 16
_WIDE = 7500
# An array from this size on is compressed where the one in its place was not, too.
_COMPRESSED_FROM = 128


class BinaryFbx(FbxFile):
    """A binary file."""

    def __init__(self, path: Path, data: bytes, limits: Limits) -> None:
        self.path, self.data, self.limits = path, data, limits
        if len(data) < _START:
            raise FormatError(f"a binary FBX has {_START} bytes before its records, this one {len(data)}", path=path)
        self.version = struct.unpack_from("<I", data, len(MAGIC))[0]
        refuse_version(path, self.version)
        self.head = struct.Struct("<QQQB" if self.version >= _WIDE else "<IIIB")
        self.records, self.foot = self._read_records()

    def error(self, problem: str, record: Record | None = None) -> FormatError:
        """Make an error about this file, at a record."""
        return FormatError(problem, path=self.path, byte=None if record is None else record.start)

    def _read_records(self) -> tuple[list[Record], int]:
        """Read the heads of all records; return the outermost ones and where they end."""
        data, head, width = self.data, self.head, self.head.size
        unpack, size = head.unpack_from, len(data)
        outermost: list[Record] = []
        # Records that are open, and where each ends.
        open_lists: list[list[Record]] = [outermost]
        ends: list[int] = [size]
        place, count = _START, 0
        while True:
            if len(open_lists) > 1 and place == ends[-1]:
                open_lists.pop()
                ends.pop()
                continue
            if place + width > ends[-1]:
                raise FormatError("the file ends within its records: it was cut", path=self.path, byte=place)
            end, n_values, values_size, name_size = unpack(data, place)
            if end == 0:
                place += width
                if len(open_lists) == 1:
                    return outermost, place
                if place != ends[-1]:
                    raise FormatError("a record goes on behind its last part", path=self.path, byte=place)
                continue
            values_start = place + width + name_size
            values_end = values_start + values_size
            if values_end > end or end > ends[-1]:
                raise FormatError(
                    f"a record claims to end at byte {end}, its values at {values_end}; what holds it ends at "
                    f"{ends[-1]}: the file was cut or is damaged",
                    path=self.path,
                    byte=place,
                )
            count += 1
            if count > self.limits.records:
                raise FormatError(f"more than {self.limits.records} records (Limits.records)", path=self.path)
            name = data[place + width : values_start].decode("latin-1")
            record = Record(name, place, end, values_start, values_end, n_values)
            open_lists[-1].append(record)
            place = values_end
            if values_end < end:
                if len(open_lists) > self.limits.depth:
                    raise self.error(f"records lie within each other more than {self.limits.depth} deep", record)
                open_lists.append(record.children)
                ends.append(end)

    def spans(self, record: Record) -> list[tuple[int, int]]:
        """Return where each of a record's values begins and ends."""
        place, stop = record.values_start, record.values_end
        # Each takes two bytes at least.
        if record.n_values > (stop - place) // 2:
            raise self.error(f"{record.name} claims {record.n_values} values in {stop - place} bytes", record)
        found = []
        for _ in range(record.n_values):
            end = place + 1 + self._size(record, place, stop)
            if end > stop:
                raise self.error(f"the values of {record.name} go past its end", record)
            found.append((place, end))
            place = end
        if place != stop:
            raise self.error(f"the values of {record.name} end before it says", record)
        return found

    def _size(self, record: Record, place: int, stop: int) -> int:
        letter = self.data[place : place + 1].decode("latin-1") if place < stop else ""
        if letter in _PLAIN:
            return struct.calcsize(_PLAIN[letter])
        if letter and letter in "SR" and place + 5 <= stop:
            return 4 + int(struct.unpack_from("<I", self.data, place + 1)[0])
        if letter in ARRAYS and place + 13 <= stop:
            return 12 + int(struct.unpack_from("<I", self.data, place + 9)[0])
        raise self.error(f"{record.name} holds a value of an unknown type {letter!r}", record)

    def value(self, record: Record, span: tuple[int, int]) -> Value:
        """Decode the value at a place."""
        place, end = span
        letter = chr(self.data[place])
        if letter in _PLAIN:
            return Value(letter, struct.unpack_from(_PLAIN[letter], self.data, place + 1)[0])
        if letter in ARRAYS:
            return Value(letter, self.array_at(record, span, letter))
        content = self.data[place + 5 : end]
        return Value(letter, content if letter == "R" else content.decode("utf-8", "replace"))

    def array_at(self, record: Record, span: tuple[int, int], kinds: str) -> NDArray[Any]:
        """Decode the array at a place."""
        letter = chr(self.data[span[0]])
        if letter not in kinds:
            raise self.error(f"{record.name} must be an array of type {' or '.join(kinds)}, found {letter!r}", record)
        count, packed, size = struct.unpack_from("<III", self.data, span[0] + 1)
        kind = np.dtype(ARRAYS[letter])
        content = self.data[span[0] + 13 : span[1]]
        if packed > 1:
            raise self.error(f"{record.name} is compressed in an unknown way ({packed})", record)
        if packed:
            content = inflated(self, record, content, count * kind.itemsize)
        elif count * kind.itemsize != size:
            raise self.error(f"{record.name} claims {count} numbers in {size} bytes", record)
        return np.frombuffer(content, dtype=kind)

    def rewritten(self, changes: Changes) -> bytes:
        """Return the file with some values exchanged.

        The ends that heads give are moved, and the padding of the foot keeps it where it belongs; all else stays.
        """
        spans = {record: self.spans(record) for record, _ in changes}
        parts = sorted((*spans[record][index], record, value) for (record, index), value in changes.items())
        pieces: list[bytes] = []
        starts, deltas, place = [], [], 0
        values_grow: dict[Record, int] = {}
        for start, end, record, value in parts:
            old = self.data[start:end]
            packed = bool(value.letter in ARRAYS and struct.unpack_from("<I", old, 5)[0])
            new = encoded(value, packed=packed)
            pieces += [self.data[place:start], new]
            place = end
            starts.append(start)
            deltas.append(len(new) - len(old))
            values_grow[record] = values_grow.get(record, 0) + deltas[-1]
        pieces.append(self.data[place : self.foot])
        out = bytearray(b"".join(pieces))
        if any(deltas):
            self._move_ends(out, np.array(starts), np.concatenate([[0], np.cumsum(deltas)]), values_grow)
        return bytes(out) + self._new_foot(len(out))

    def _move_ends(
        self, out: bytearray, starts: NDArray[np.int64], moved: NDArray[np.int64], grow: dict[Record, int]
    ) -> None:
        """Write new ends into the heads; `moved[i]` is by how much bytes between the changes i - 1 and i move."""
        records = all_records(self.records)
        heads = np.array([one.start for one in records])
        ends = np.array([one.end for one in records])
        heads += moved[np.searchsorted(starts, heads, side="right")]
        # A record grows by the changes that begin before its end.
        ends += moved[np.searchsorted(starts, ends, side="left")]
        width = 8 if self.version >= _WIDE else 4
        if width == 4 and len(out) >= 2**32:
            raise self.error("the new file is too large for its version (4 GiB)")
        flat = np.frombuffer(out, dtype=np.uint8)
        number = ends.astype(f"<u{width}").view(np.uint8).reshape(-1, width)
        flat[heads[:, None] + np.arange(width)] = number
        for record, more in grow.items():
            at = record.start + int(moved[np.searchsorted(starts, record.start, side="right")])
            size = record.values_end - record.values_start + more
            struct.pack_into("<Q" if width == 8 else "<I", out, at + 2 * width, size)

    def _new_foot(self, place: int) -> bytes:
        foot = self.data[self.foot :]
        zeros = len(foot) - _FOOT_ID - _FOOT_END
        known = 0 < zeros <= 32 and foot.endswith(LAST) and not any(foot[_FOOT_ID : _FOOT_ID + zeros])
        if not known or place == self.foot:
            return foot
        # Programs differ in what they align, so the version keeps its place within 16 bytes; five zeros are the least.
        rest = (len(self.data) - _FOOT_END - place - _FOOT_ID - 5) % 16
        return foot[:_FOOT_ID] + b"\0" * (5 + rest) + foot[_FOOT_ID + zeros :]


def refuse_version(path: Path, version: int) -> None:
    """Raise FormatError for a version that is not read, with what to do."""
    if version < 7000:
        raise FormatError(
            f"FBX {version // 1000}.{version % 1000 // 100} (version {version}) has its animation in another form; "
            "versions 7.0 to 7.7 are read: open it in Blender 4.5 or later, Maya or MotionBuilder, and export it as "
            "FBX 7.4 or later",
            path=path,
        )
    if version >= 8000:
        raise FormatError(f"FBX version {version} is not known; export it as FBX 7.4 to 7.7", path=path)


def encoded(value: Value, *, packed: bool = False) -> bytes:
    """Return the bytes of a value; an array is compressed where `packed` says so."""
    letter, content = value
    if letter in _PLAIN:
        return letter.encode() + struct.pack(_PLAIN[letter], content)
    if letter in "SR":
        raw = content if isinstance(content, bytes) else content.encode("utf-8", "surrogateescape")
        return letter.encode() + struct.pack("<I", len(raw)) + raw
    numbers = np.ascontiguousarray(content, dtype=ARRAYS[letter])
    raw = numbers.tobytes()
    if packed and len(raw) >= _COMPRESSED_FROM:
        raw = zlib.compress(raw, 1)
    else:
        packed = False
    return letter.encode() + struct.pack("<III", numbers.size, packed, len(raw)) + raw
