"""Warps in files: JSON, versioned, all or nothing."""

from __future__ import annotations

from os import PathLike

from retime.checks import path_of
from retime.formats.read_options import Limits
from retime.warp.curve import Warp, WarpLike, as_warp


def read_warp(path: str | PathLike[str], *, limits: Limits | None = None) -> Warp:
    """Read a warp from a JSON file that `write_warp` made: `Warp.load`, within limits.

    Raises
    ------
    FormatError
        Not a warp; says where and why.
    OSError
        The file can't be opened.
    """
    return Warp.load(path_of(path, "read_warp(path)"), most_bytes=(limits or Limits()).file_bytes)


def write_warp(warp: WarpLike, path: str | PathLike[str], *, overwrite: bool = False) -> None:
    """Write a warp, or a result's, to a JSON file, whole or not at all: `Warp.save`.

    Raises
    ------
    OptionError
        Something else was passed for the warp.
    OutputExistsError
        The file is there, and `overwrite` is not set.
    """
    as_warp(warp, "write_warp(warp, path)").save(path_of(path, "write_warp(warp, path)"), overwrite=overwrite)
