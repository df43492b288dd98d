"""What keypoints are read into: frames of people's points, and the checks that every reader of them makes."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr, kind_of
from retime.errors import FormatError

MOST_POINTS = 2000
MOST_PEOPLE = 100
# No picture is so large, nor a room.
_FARTHEST = 1e7

NUMBERS = ("frame", "framenumber", "frameindex", "frameidx", "frameid", "framenum", "frameno", "index")
"""What the numbers of frames are called by those who write them; letters alone count, in any case."""


@dataclass(frozen=True, eq=False)
class Frame:
    """What stands in a file of one frame.

    Attributes
    ----------
    poses : list of float array, shape (n_points, n_axes)
        Of each person; what isn't there is not a number.
    number, time : float, optional
        What the file says of them.
    """

    poses: list[FloatArray]
    number: float | None = None
    time: float | None = None

    __repr__ = brief_repr


@dataclass
class Found:
    """What was read of a file, or of a folder.

    Attributes
    ----------
    frames : list
        In the order of the file.
    program, layout : str
        Who wrote it, and which points.
    names : tuple of str
        Of the points.
    rate : Fraction, optional
        What is said of it.
    time_name, time_form : str, str or None
        Of the times.
    first_number : int
        Of the first frame, where frames say none.
    """

    frames: list[Frame]
    program: str
    layout: str
    names: tuple[str, ...]
    rate: Fraction | None = None
    time_name: str = ""
    time_form: Any = None
    first_number: int = 0


def same_layout(path: Path, layout: tuple[int, int] | None, poses: Sequence[FloatArray]) -> tuple[int, int] | None:
    """Check that poses have as many points, and axes, as those before."""
    for pose in poses:
        if not len(pose):
            continue
        if len(pose) > MOST_POINTS:
            raise FormatError(f"{len(pose)} points of one person; {MOST_POINTS} are the most", path=path)
        found = pose.shape[0], pose.shape[1]
        if layout is not None and found != layout:
            raise FormatError(
                f"a person of {found[0]} points with {found[1]} coordinates after one of {layout[0]} with {layout[1]}: "
                "all are to have the same points",
                path=path,
            )
        layout = found
    return layout


def confident(places: FloatArray, confidence: FloatArray, least: float) -> FloatArray:
    """Take points of less confidence out, and those at 0, 0 of none, which is how "not found" is written."""
    gone = (confidence < least) | (confidence <= 0)
    return np.where(gone[:, None], np.nan, places)


def named_number(path: Path, place: int, entry: Any, names: Sequence[str]) -> float | None:
    """Return the number that a frame says of itself by one of some names, where it says one."""
    for key, value in entry.items():
        # A frame may be called by the name of its picture.
        if plain(key) in names and isinstance(value, int | float) and not isinstance(value, bool):
            return number_of(path, f"frame {place}: {key}", value, most=1e12)
    return None


def number_of(path: Path, what: str, value: Any, most: float = _FARTHEST) -> float:
    """Return a number; raise FormatError where it is none, or lies in no picture."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FormatError(f"{what}: expected a number, found {shape_of(value)}", path=path)
    if not abs(value) <= most:
        raise FormatError(f"{what}: {value!s:.40} is too large", path=path)
    return float(value)


def plain(key: str) -> str:
    """Return the letters of a key: ``pose_landmarks`` and ``poseLandmarks`` are one."""
    return re.sub(r"[^a-z0-9]", "", key.lower())


def shape_of(value: Any) -> str:
    """Say what a part of a document is."""
    if isinstance(value, dict):
        some = ", ".join(str(key)[:20] for key in list(value)[:4])
        return f"an object with {some}" if some else "an empty object"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    return "nothing" if value is None else f"{value!r:.40}" if isinstance(value, str) else kind_of(value)
