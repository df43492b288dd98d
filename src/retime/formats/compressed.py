"""Files that are compressed as a whole, such as ``walk.bvh.gz``: read as what is in them, within the limits.

Nothing is believed of what such a file claims to hold: it is unpacked piece by piece, and stops at a limit.
"""

from __future__ import annotations

import bz2
import gzip
import warnings
import zlib
from collections.abc import Callable
from io import BytesIO
from os import PathLike
from pathlib import Path
from typing import BinaryIO

from retime.errors import FormatError, FormatWarning
from retime.files import read_bytes
from retime.formats.read_options import Limits
from retime.kernels import read_file

_OPENERS: dict[str, Callable[[BytesIO], BinaryIO]] = {
    ".gz": lambda file: gzip.GzipFile(fileobj=file),  # type: ignore[dict-item, return-value]
    ".bz2": lambda file: bz2.BZ2File(file),  # type: ignore[dict-item, return-value]
}
COMPRESSED = tuple(_OPENERS)
"""Endings that compressed files add to that of their format."""
_PACKERS = {".gz": "gzip", ".bz2": "bzip2"}
_PIECE_BYTES = 1 << 20
# A small file may be all alike, and so compress well past the ratio; only a large one can hurt.
_SMALL_BYTES = 1 << 20
# Bytes from which on large pages pay.
_LONG_FILE = 1 << 22


def is_compressed(path: str | PathLike[str]) -> bool:
    """Tell by a file's name whether it is compressed as a whole."""
    return Path(path).suffix.lower() in COMPRESSED


def plain_path(path: str | PathLike[str]) -> Path:
    """Return the path without the ending of compression, if it has one.

    Examples
    --------
    >>> plain_path("walk.bvh.gz").name, plain_path("walk.bvh").name
    ('walk.bvh', 'walk.bvh')
    """
    path = Path(path)
    return path.with_suffix("") if is_compressed(path) else path


def refuse_compressed(path: str | PathLike[str]) -> None:
    """Refuse to write under the name of a compressed file; raise FormatError, which says what to do."""
    path = Path(path)
    if is_compressed(path):
        packer = _PACKERS[path.suffix.lower()]
        raise FormatError(
            f"{path.suffix} files are read, not written: write {plain_path(path).name}, then compress it ({packer} "
            f"{plain_path(path).name})",
            path=path,
        )


def _contents(file: BinaryIO, most: int) -> bytes:
    """Read a file from its begin: so many bytes, or as many as it has."""
    data = read_file(file.fileno(), most) if most > _LONG_FILE else None
    return file.read(most) if data is None else data


def read_plain(path: Path, limits: Limits, *, repair: bool = False) -> bytes:
    """Read a file, unpacked where its name says that it is compressed.

    Parameters
    ----------
    path : Path
        The file.
    limits : Limits
        ``file_bytes`` for the file itself, ``zip_ratio`` and ``inflated_bytes`` for what is in it.
    repair : bool
        Of a damaged compressed file, return what can still be unpacked, with a warning.

    Raises
    ------
    FormatError
        The file is larger than a limit, or what is in it, or it is damaged.
    OSError
        The file can't be opened.

    Warns
    -----
    FormatWarning
        It is damaged, and this is what came before.
    """
    data = read_bytes(path, limits.file_bytes, contents=_contents)
    if not is_compressed(path):
        return data
    if not data:
        raise FormatError("the file is empty; expected compressed data", path=path)
    by_ratio = max(_SMALL_BYTES, limits.zip_ratio * len(data))
    pieces: list[bytes] = []
    n_bytes = 0
    try:
        with _OPENERS[path.suffix.lower()](BytesIO(data)) as file:
            while piece := file.read(_PIECE_BYTES):
                n_bytes += len(piece)
                pieces.append(piece)
                if n_bytes > limits.inflated_bytes:
                    raise FormatError(
                        f"holds more than {limits.inflated_bytes} bytes, which is the limit (Limits.inflated_bytes)",
                        path=path,
                    )
                if n_bytes > by_ratio:
                    raise FormatError(
                        f"{len(data)} bytes hold more than {by_ratio}, beyond {limits.zip_ratio}:1 (Limits.zip_ratio)",
                        path=path,
                    )
    except (EOFError, zlib.error, OSError) as error:
        what = str(error).rstrip(".")
        if not repair or not pieces:
            raise FormatError(f"damaged compressed data: {what}", path=path) from None
        warnings.warn(
            f"{path}: damaged compressed data: {what}; read the {n_bytes} bytes that came before",
            FormatWarning,
            stacklevel=4,
        )
    return b"".join(pieces)
