"""Messages between this process and one that runs a native decoder: JSON, arrays of numbers, and files.

A damaged file may end the decoder's process, or make it say anything. So nothing that could run is exchanged (no
pickle): a message is one JSON object, then arrays of few types, then bytes, each as long as the object declares; what
doesn't fit is refused.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from retime.brief import brief_repr
from retime.errors import FormatError
from retime.strict_json import parse_json

NO_MEMORY = "no memory"
"""The error that a process answers which has too little."""

_HEAD = struct.Struct("<8sQ")
_MAGIC = b"retimex1"
_MOST_HEADER = 256 << 20
_TYPES = ("<f8", "<f4", "<i8", "|u1")


@dataclass(frozen=True)
class Message:
    """What is asked, or answered.

    Attributes
    ----------
    facts : dict of str to JSON values
    arrays : dict of str to arrays
        Of 64-bit and 32-bit floats, 64-bit whole numbers, and bytes.
    files : dict of str to bytes
    """

    facts: dict[str, Any]
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    files: Mapping[str, bytes] = field(default_factory=dict)

    __repr__ = brief_repr


def send(message: Message, to: IO[bytes]) -> None:
    """Write a message, and flush."""
    arrays = {name: np.ascontiguousarray(array) for name, array in message.arrays.items()}
    header = json.dumps(
        {
            "facts": message.facts,
            "arrays": [[name, array.dtype.str, list(array.shape)] for name, array in arrays.items()],
            "files": [[name, len(data)] for name, data in message.files.items()],
        },
        allow_nan=False,
    ).encode()
    to.write(_HEAD.pack(_MAGIC, len(header)) + header)
    for array in arrays.values():
        to.write(array.tobytes())
    for data in message.files.values():
        to.write(data)
    to.flush()


def receive(source: IO[bytes], most_bytes: int) -> Message | None:
    """Read a message; None where there is none.

    Parameters
    ----------
    source : binary file
        A pipe.
    most_bytes : int
        More than this, of arrays and files together, is refused.

    Raises
    ------
    FormatError
        It is no message, or ends too soon.
    """
    head = source.read(_HEAD.size)
    if not head:
        return None
    if len(head) < _HEAD.size or head[:8] != _MAGIC or _HEAD.unpack(head)[1] > _MOST_HEADER:
        raise FormatError("not a message")
    header = parse_json(_exactly(source, _HEAD.unpack(head)[1]), what="a message")
    if not isinstance(header, dict) or not isinstance(header.get("facts"), dict):
        raise FormatError("a message without facts")
    rows = [_array_row(row) for row in _list(header, "arrays")]
    names = [_file_row(row) for row in _list(header, "files")]
    total = sum(size for *_, size in rows) + sum(size for _, size in names)
    if total > most_bytes:
        raise FormatError(f"a message of {total} bytes, the limit is {most_bytes}")
    arrays = {}
    for name, kind, shape, size in rows:
        arrays[name] = np.frombuffer(_exactly(source, size), dtype=kind).reshape(shape)
    return Message(header["facts"], arrays, {name: _exactly(source, size) for name, size in names})


def _list(header: dict[str, Any], name: str) -> list[Any]:
    found = header.get(name)
    if not isinstance(found, list) or len(found) > 1 << 20:
        raise FormatError(f"a message without {name}")
    return found


def _array_row(row: Any) -> tuple[str, str, tuple[int, ...], int]:
    if not isinstance(row, list) or len(row) != 3 or not isinstance(row[0], str) or row[1] not in _TYPES:
        raise FormatError("a message with an array of no known type")
    shape = row[2]
    if not isinstance(shape, list) or len(shape) > 4 or not all(_is_size(length) for length in shape):
        raise FormatError("a message with an array of no shape")
    size = np.dtype(row[1]).itemsize
    for length in shape:
        size *= length
    return row[0], row[1], tuple(shape), size


def _file_row(row: Any) -> tuple[str, int]:
    if not isinstance(row, list) or len(row) != 2 or not isinstance(row[0], str) or not _is_size(row[1]):
        raise FormatError("a message with a file of no size")
    return row[0], row[1]


def _is_size(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < 1 << 40


def _exactly(source: IO[bytes], size: int) -> bytes:
    data = source.read(size)
    if len(data) < size:
        raise FormatError("a message that ends too soon")
    return data
