"""Warps in files: JSON, versioned, all or nothing."""

from __future__ import annotations

from os import PathLike

from retime.errors import FormatError
from retime.formats.files import read_bytes, write_bytes
from retime.formats.options import Limits
from retime.warp.curve import Warp


def read_warp(path: str | PathLike[str], *, limits: Limits | None = None) -> Warp:
    """Read a warp from a JSON file that `write_warp` made.

    Raises
    ------
    FormatError
        Not a warp; says where and why.
    OSError
        The file can't be opened.
    """
    try:
        return Warp.from_json(read_bytes(path, limits or Limits()))
    except FormatError as error:
        raise FormatError(error.problem, path=path, line=error.line, column=error.column, byte=error.byte) from None


def write_warp(warp: Warp, path: str | PathLike[str], *, overwrite: bool = False) -> None:
    """Write a warp to a JSON file, whole or not at all; raise OutputExistsError where one is there already."""
    write_bytes(path, warp.to_json().encode(), overwrite=overwrite)
