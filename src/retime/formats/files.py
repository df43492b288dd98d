"""Reading whole files within limits, and writing them so that a crash leaves the old file or the new one."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable
from os import PathLike
from pathlib import Path

from retime.errors import FormatError, OutputExistsError
from retime.formats.options import Limits


def read_bytes(path: str | PathLike[str], limits: Limits) -> bytes:
    """Read a file, but no more than ``limits.file_bytes`` of it.

    Raises
    ------
    FormatError
        The file is larger, or is not a regular file.
    OSError
        The file can't be opened.
    """
    path = Path(path)
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        data = file.read(limits.file_bytes + 1)
    if len(data) > limits.file_bytes:
        raise FormatError(
            f"the file has {size} bytes, the limit is {limits.file_bytes} (Limits.file_bytes)", path=path
        )
    return data


def write_bytes(path: str | PathLike[str], parts: bytes | Iterable[bytes], *, overwrite: bool) -> None:
    """Write a file beside its place, sync it, and rename it over; nothing is left behind where that fails.

    Raises
    ------
    OutputExistsError
        The file is there, and `overwrite` is not set.
    OSError
        The folder is missing or can't be written, or the disk is full.
    """
    path = Path(path)
    if not overwrite and path.exists():
        raise OutputExistsError(path)
    # Follow a symbolic link, so that the rename replaces the file it means and not the link.
    place = Path(os.path.realpath(path))
    handle, name = tempfile.mkstemp(prefix=f".{place.name[:100]}.", dir=place.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            for part in (parts,) if isinstance(parts, bytes) else parts:
                file.write(part)
            file.flush()
            os.fsync(file.fileno())
        mode = place.stat().st_mode & 0o777 if place.exists() else 0o666 & ~_umask()
        Path(name).chmod(mode)
        if overwrite:
            os.replace(name, place)
        else:
            # A link fails where the name was taken meanwhile; a rename would not.
            try:
                os.link(name, place)
            except FileExistsError:
                raise OutputExistsError(path) from None
            Path(name).unlink()
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    _sync_folder(place.parent)


def _umask() -> int:
    # The process's mask can only be read by setting it.
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _sync_folder(folder: Path) -> None:
    if os.name == "nt":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
