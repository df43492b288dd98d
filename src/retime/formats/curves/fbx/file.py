"""The FBX 7 container: records with values and records within, in binary or in text.

Only what is asked for is decoded. A changed file is its old bytes with some values exchanged: what is not named stays
as it was, and a file without changes is itself.
"""

from __future__ import annotations

import abc
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from retime.errors import FormatError
from retime.formats.read_options import Limits

ARRAYS: dict[str, str] = {"f": "<f4", "d": "<f8", "l": "<i8", "i": "<i4", "b": "u1", "c": "u1"}
"""Element types of arrays, by the letter that binary files have for them."""


class Value(NamedTuple):
    """A value of a record.

    Attributes
    ----------
    letter : str
        Its type, as binary files write it: Y C I L (whole numbers), F D (others), S (text), R (bytes), or one of
        `ARRAYS`. In text, whole numbers are L, others D, and words without quotes C.
    content : int, float, str, bytes or array
    """

    letter: str
    content: Any


@dataclass(slots=True, eq=False)
class Record:
    """A record, by where it lies in the file.

    Attributes
    ----------
    name : str
    start, end : int
        Bytes: from its head, or its name, to behind its last.
    values_start, values_end : int
        Bytes of its values.
    n_values : int
        How many a binary file says that there are; -1 in text, where they are counted.
    children : list of Record
    """

    name: str
    start: int
    end: int
    values_start: int
    values_end: int
    n_values: int
    children: list[Record] = field(default_factory=list)

    def child(self, name: str) -> Record | None:
        """Return the first record within that has a name."""
        for one in self.children:
            if one.name == name:
                return one
        return None


Changes = Mapping[tuple[Record, int], Value]
"""New values, by their record and their place in it."""


class FbxFile(abc.ABC):
    """A file that was taken apart, down to its records.

    Attributes
    ----------
    path : Path
        For messages.
    data : bytes
    limits : Limits
    version : int
        7400, say.
    records : list of Record
        The outermost ones.
    inflated : int
        Bytes of all arrays that were inflated so far.
    """

    path: Path
    data: bytes
    limits: Limits
    version: int
    records: list[Record]
    inflated: int = 0

    @abc.abstractmethod
    def spans(self, record: Record) -> list[tuple[int, int]]:
        """Return where each of a record's values begins and ends."""

    @abc.abstractmethod
    def value(self, record: Record, span: tuple[int, int]) -> Value:
        """Decode the value at a place; an array comes as its numbers."""

    @abc.abstractmethod
    def rewritten(self, changes: Changes) -> bytes:
        """Return the file with some values exchanged."""

    @abc.abstractmethod
    def error(self, problem: str, record: Record | None = None) -> FormatError:
        """Make an error about this file, at a record."""

    def values(self, record: Record) -> list[Value]:
        """Decode all values of a record."""
        return [self.value(record, span) for span in self.spans(record)]

    def section(self, name: str) -> Record | None:
        """Return the first of the outermost records that has a name."""
        for one in self.records:
            if one.name == name:
                return one
        return None

    def array(self, record: Record, kinds: str) -> NDArray[Any]:
        """Decode a record's one array.

        Parameters
        ----------
        record : Record
            What should hold it.
        kinds : str
            Letters of `ARRAYS` that will do; text is read as the first of them.

        Raises
        ------
        FormatError
            There is none, of another kind, or of other numbers than it claims.
        """
        spans = self.spans(record)
        if len(spans) != 1:
            raise self.error(f"{record.name} must hold one array, it has {len(spans)} values", record)
        return self.array_at(record, spans[0], kinds)

    @abc.abstractmethod
    def array_at(self, record: Record, span: tuple[int, int], kinds: str) -> NDArray[Any]:
        """Decode the array at a place."""

    def numbers(self, record: Record, values: list[Value], n: int) -> NDArray[np.float64]:
        """Return the last `n` values as finite numbers; raise FormatError where they are none."""
        found = [one.content for one in values[-n:]] if len(values) >= n else []
        if not found or not all(isinstance(one, int | float) for one in found):
            raise self.error(f"{record.name} must end in {n} numbers, found {[str(one)[:40] for one in found]}", record)
        numbers = np.array([float(one) for one in found])
        if not np.isfinite(numbers).all():
            raise self.error(f"{record.name} holds a number that is not finite", record)
        return numbers

    def whole(self, record: Record, value: Value) -> int:
        """Return a value as a whole number of 64 bits; raise FormatError where it is none."""
        number = value.content
        if isinstance(number, int) and -(2**63) <= number < 2**63:
            return number
        raise self.error(f"{record.name}: expected a whole number, found {str(number)[:40]!r}", record)


def inflated(file: FbxFile, record: Record, packed: bytes, size: int) -> bytes:
    """Inflate an array, never beyond the size that it claims; raise FormatError for a bomb, or where sizes disagree."""
    limits = file.limits
    if size > max(1 << 20, limits.zip_ratio * len(packed)):
        raise file.error(
            f"an array claims {size} bytes in {len(packed)} compressed ones, more than {limits.zip_ratio}:1 "
            "(Limits.zip_ratio)",
            record,
        )
    file.inflated += size
    if file.inflated > limits.inflated_bytes:
        raise file.error(f"its arrays hold more than {limits.inflated_bytes} bytes (Limits.inflated_bytes)", record)
    machine = zlib.decompressobj()
    try:
        data = machine.decompress(packed, size + 1)
    except zlib.error as error:
        raise file.error(f"a compressed array is damaged ({error})", record) from None
    if len(data) != size or not machine.eof:
        raise file.error(f"a compressed array holds {len(data)} bytes, it claims {size}", record)
    return data


def all_records(records: list[Record]) -> list[Record]:
    """Return records and all within them, in no particular order."""
    found = list(records)
    for one in found:
        # The list grows while it is walked.
        found += one.children
    return found
