"""Arrays of NumPy as bytes, and archives of them: described, compared with what they claim, and made only then.

Only plain numbers and text are read: nothing is unpickled or evaluated.
"""

from __future__ import annotations

import math
import re
import struct
import warnings
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from io import BytesIO
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray, doubles
from retime.brief import brief_repr
from retime.errors import FormatError, FormatWarning, OptionError
from retime.formats.read_options import Limits, ReadOptions
from retime.motion.rate import parse_rate

MAGIC = b"\x93NUMPY"
_HEADER_BYTES = 4096
_DESCR = rb"['\"]descr['\"]\s*:\s*['\"](?P<descr>[<>|=]?[A-Za-z?][0-9]{0,6})['\"]"
_ORDER = rb"['\"]fortran_order['\"]\s*:\s*(?P<order>True|False)"
_SHAPE = rb"['\"]shape['\"]\s*:\s*\((?P<shape>(?:\s*[0-9]{1,18}L?\s*,)*(?:\s*[0-9]{1,18}L?)?\s*)\)"
# The header is a Python dictionary of these three in any order. Matched, never evaluated.
_HEADERS = tuple(
    re.compile(rb"\{\s*" + rb"\s*,\s*".join(items) + rb"\s*,?\s*\}\s*")
    for items in (
        (_DESCR, _ORDER, _SHAPE),
        (_DESCR, _SHAPE, _ORDER),
        (_ORDER, _DESCR, _SHAPE),
        (_ORDER, _SHAPE, _DESCR),
        (_SHAPE, _DESCR, _ORDER),
        (_SHAPE, _ORDER, _DESCR),
    )
)
_NUMBER_BYTES = {"i": (1, 2, 4, 8), "u": (1, 2, 4, 8), "f": (2, 4, 8), "b": (1,)}
_REFUSED = {"O": "Python objects, which are never loaded", "c": "complex numbers", "m": "time spans", "M": "dates"}
RATES = ("rate", "fps", "framerate", "frame_rate", "mocap_framerate", "mocap_frame_rate")
"""What archives call the frames a second."""
# A small member may be all zeros, and so compress well past the ratio; only a large one can hurt.
_SMALL_MEMBER = 1 << 20
# Letters of a library's own message that are passed on.
_MOST_QUOTED = 160


@dataclass(frozen=True)
class StoredArray:
    """An array that was described and not yet made: its kind, size of an item, byte order, shape and bytes."""

    kind: str
    item_bytes: int
    little: bool
    fortran: bool
    shape: tuple[int, ...]
    data: memoryview

    __repr__ = brief_repr

    @property
    def dtype(self) -> np.dtype:
        """NumPy's type of an item."""
        order, size = "<" if self.little else ">", self.item_bytes
        if self.kind == "b":
            return np.dtype(np.bool_)
        return np.dtype(f"{order}{self.kind}{size // 4 if self.kind == 'U' else size}")


def header_shape(head: bytes) -> tuple[int, ...] | None:
    """Return the shape that the first bytes of an array describe, also one of objects; None where they don't."""
    wide = head[6:7] != b"\x01"
    start = 12 if wide else 10
    length = int.from_bytes(head[8:start], "little")
    header = head[start : start + length]
    match = next((match for pattern in _HEADERS if (match := pattern.fullmatch(header))), None)
    return None if match is None or not head.startswith(MAGIC) else _shape(match)


def _shape(match: re.Match[bytes]) -> tuple[int, ...]:
    return tuple(int(part.strip(b" \t\r\n\v\fL")) for part in match["shape"].split(b",") if part.strip())


def parse_array(path: Path, data: bytes, what: str, options: ReadOptions) -> StoredArray:
    """Read the header of an array and compare its claim with the bytes that follow."""
    version = data[6:8]
    if version == b"\x01\x00":
        size, start = struct.calcsize("<H"), 10
    elif version in (b"\x02\x00", b"\x03\x00"):
        size, start = struct.calcsize("<I"), 12
    else:
        raise FormatError(f"{what} has version {version.hex('.')}; expected 1, 2 or 3", path=path, byte=6)
    length = int.from_bytes(data[8 : 8 + size], "little")
    if length > _HEADER_BYTES or start + length > len(data):
        raise FormatError(
            f"{what} claims a header of {length} bytes; {max(len(data) - start, 0)} follow, and the limit is "
            f"{_HEADER_BYTES}",
            path=path,
            byte=8,
        )
    header = data[start : start + length]
    match = next((match for pattern in _HEADERS if (match := pattern.fullmatch(header))), None)
    if match is None:
        text = header[:80].decode("latin-1").strip()
        raise FormatError(
            f"{what} has a header that describes no plain array: {text!r}; records and objects are not read",
            path=path,
            byte=start,
        )
    descr = match["descr"].decode()
    shape = _shape(match)
    kind, item_bytes, little = _item(path, what, descr, start)
    fortran = match["order"] == b"True"
    body = memoryview(data)[start + length :]
    claimed = math.prod(shape) * item_bytes
    if claimed != len(body):
        whole = len(body) // (math.prod(shape[1:]) * item_bytes or 1)
        if options.repair and what == "the array" and not fortran and len(shape) and 0 < whole < shape[0]:
            warnings.warn(f"{path}: {whole} of {shape[0]} frames are there and were kept", FormatWarning, stacklevel=4)
            shape = (whole, *shape[1:])
            body = body[: math.prod(shape) * item_bytes]
        else:
            raise FormatError(
                f"{what} claims shape {shape} of {descr!r}, {claimed} bytes; {len(body)} bytes follow",
                path=path,
                byte=start + length,
            )
    return StoredArray(kind, item_bytes, little, fortran, shape, body)


def _item(path: Path, what: str, descr: str, byte: int) -> tuple[str, int, bool]:
    """Take a type description apart: kind, bytes of an item, and whether the least significant comes first."""
    match = re.fullmatch(r"([<>|=]?)([A-Za-z?])([0-9]*)", descr)
    assert match is not None
    order, kind, digits = match.groups()
    count = int(digits or 0)
    if kind == "?":
        kind, count = "b", 1
    if count in _NUMBER_BYTES.get(kind, ()):
        return kind, count, order != ">"
    if kind in "SU" and count > 0:
        return kind, count * (4 if kind == "U" else 1), order != ">"
    held = _REFUSED.get(kind, f"the type {descr!r}")
    raise FormatError(f"{what} holds {held}; expected real numbers of 1 to 8 bytes", path=path, byte=byte)


def floats_of(path: Path, what: str, array: StoredArray) -> FloatArray:
    """Make an array of doubles."""
    if array.kind in "SU":
        raise FormatError(f"{what} holds text; expected numbers", path=path)
    if array.kind == "b":
        # Any byte but 0 counts as true.
        raw = np.frombuffer(array.data, dtype=np.uint8) != 0
    else:
        order = "<" if array.little else ">"
        raw = np.frombuffer(array.data, dtype=np.dtype(f"{order}{array.kind}{array.item_bytes}"))
    if array.kind in "iu" and array.item_bytes == 8 and len(raw):
        # Beyond this, neighbouring whole numbers are one double.
        largest = max(int(raw.max()), -int(raw.min()))
        if largest > 2**53:
            raise FormatError(f"{what} holds {largest}, more than 2**53, which a double can't hold exactly", path=path)
    # What is no number is refused with its frame and channel later.
    return doubles(raw).reshape(array.shape, order="F" if array.fortran else "C")


def texts_of(path: Path, what: str, array: StoredArray) -> list[str]:
    """Decode an array of texts of fixed length, padded with zeros."""
    encoding = "utf-8" if array.kind == "S" else "utf-32-le" if array.little else "utf-32-be"
    data = bytes(array.data)
    size = array.item_bytes
    try:
        return [data[i : i + size].decode(encoding).rstrip("\0") for i in range(0, len(data), size)]
    except UnicodeDecodeError as error:
        raise FormatError(f"{what} hold no text: {error.reason}", path=path) from None


def _brief(error: Exception) -> str:
    """Say what a library found, without the kilobytes of the file that it may quote."""
    words = str(error)
    return words if len(words) <= _MOST_QUOTED else words[:_MOST_QUOTED] + "..."


def _refuse_dangerous(path: Path, members: list[zipfile.ZipInfo], limits: Limits, n_bytes: int) -> None:
    """Raise FormatError for members that no NPZ has, and for claims past the limits."""
    seen = set()
    for member in members:
        name = member.filename
        shown = repr(name[:80])
        if name.startswith(("/", "\\")) or ".." in re.split(r"[/\\]", name) or ":" in name or "\0" in name:
            raise FormatError(f"the member {shown} leads out of the archive", path=path)
        if name in seen:
            raise FormatError(f"two members are called {shown}", path=path)
        seen.add(name)
        if member.flag_bits & 0x1:
            raise FormatError(f"the member {shown} is encrypted", path=path)
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise FormatError(f"the member {shown} is compressed by method {member.compress_type}", path=path)
        if member.file_size > max(_SMALL_MEMBER, limits.zip_ratio * member.compress_size):
            raise FormatError(
                f"the member {shown} claims {member.file_size} bytes in {member.compress_size} compressed ones, "
                f"more than {limits.zip_ratio}:1 (Limits.zip_ratio)",
                path=path,
            )
    compressed = sum(member.compress_size for member in members)
    if compressed > n_bytes:
        raise FormatError(f"the members claim {compressed} compressed bytes; the file has {n_bytes}", path=path)
    total = sum(member.file_size for member in members)
    if total > limits.inflated_bytes:
        raise FormatError(
            f"the members claim {total} bytes, the limit is {limits.inflated_bytes} (Limits.inflated_bytes)", path=path
        )


def number_of(path: Path, array: StoredArray, what: str, kinds: str) -> float:
    """Return the only number of an array of one of some kinds ("iuf"); raise FormatError."""
    if array.kind not in kinds or math.prod(array.shape) != 1:
        raise FormatError(f"{what} has shape {array.shape} and kind {array.kind!r}; expected one number", path=path)
    return float(floats_of(path, what, array).reshape(()))


def rate_of(path: Path, array: StoredArray, key: str) -> Fraction:
    """Read a rate, which may be a number or text; raise FormatError."""
    value: str | float
    if array.kind in "SU":
        if math.prod(array.shape) != 1:
            raise FormatError(f"{key} has shape {array.shape}; expected one text or number", path=path)
        (value,) = texts_of(path, key, array)
    else:
        value = number_of(path, array, key, "iuf")
    try:
        return parse_rate(value)
    except OptionError as error:
        raise FormatError(f"{key}: {error}", path=path) from None


@contextmanager
def archive_of(path: Path, data: bytes, limits: Limits) -> Iterator[zipfile.ZipFile]:
    """Open an archive of arrays whose members are harmless; what is damaged in it raises FormatError."""
    try:
        with zipfile.ZipFile(BytesIO(data)) as archive:
            _refuse_dangerous(path, archive.infolist(), limits, len(data))
            yield archive
    except (zipfile.BadZipFile, zlib.error, struct.error, EOFError, NotImplementedError) as error:
        raise FormatError(f"a damaged zip archive: {_brief(error)}", path=path) from None
    except (RuntimeError, ValueError, OverflowError, OSError) as error:
        if isinstance(error, FormatError):
            raise
        raise FormatError(f"a zip archive that can't be read: {_brief(error)}", path=path) from None


def member_bytes(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
    """Inflate a member, and no more of it than it claims."""
    with archive.open(member) as file:
        return file.read(member.file_size + 1)


def array_bytes(array: np.ndarray) -> bytes:
    """Store an array as a .npy has it."""
    file = BytesIO()
    np.lib.format.write_array(file, np.asarray(array), allow_pickle=False)
    return file.getvalue()
