"""What is written of MediaPipe's landmarks: a list of frames, each of points as objects, lists or numbers in a row."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError
from retime.formats.keypoints.frames import (
    MOST_PEOPLE,
    MOST_POINTS,
    NUMBERS,
    Frame,
    confident,
    named_number,
    number_of,
    plain,
    same_layout,
    shape_of,
)

# What the lists of landmarks and the times of frames are called by those who write them; letters alone count, in any
# case.
_BODIES = ("poselandmarks", "landmarks", "pose", "keypoints", "body", "joints", "normalizedlandmarks", "poses")
_ELSE = (
    "poseworldlandmarks", "worldlandmarks", "lefthandlandmarks", "lefthand", "righthandlandmarks", "righthand", "hands",
    "multihandlandmarks", "handlandmarks",
)  # fmt: skip
_TIMES = {
    "timestampms": "ms", "timems": "ms", "ms": "ms", "timestampus": "us", "timestampns": "ns", "timestamp": None,
    "time": None, "t": None, "timestamps": None, "timesec": "s", "times": "s", "seconds": "s", "timestampsec": "s",
    "timeinseconds": "s",
}  # fmt: skip
_CONFIDENCES = ("visibility", "score", "confidence", "presence", "v", "c")


def chosen_list(entries: Iterable[Any]) -> str | None:
    """Say which of the lists in frames is read: of the body, where a frame has one, else of a hand, in all frames."""
    there = {
        plain(key)
        for entry in entries
        if isinstance(entry, dict) and not _is_point(entry) and not _is_named(entry)
        for key, value in entry.items()
        if value
    }
    return next((name for name in (*_BODIES, *_ELSE) if name in there), None)


class Landmarks:
    """Reads frames of landmarks, as MediaPipe finds them.

    Attributes
    ----------
    layout : (int, int), optional
        How many points, and coordinates, people have.
    names : tuple of str
        Of the points, where the file says them.
    time_name, time_form : str, str or None
        Of the times.
    """

    def __init__(self, path: Path, least: float, key: str | None) -> None:
        self.path, self.least, self.key = path, least, key
        self.layout: tuple[int, int] | None = None
        self.names: tuple[str, ...] = ()
        self.time_name: str = ""
        self.time_form: Any = None

    def error(self, place: int, problem: str) -> FormatError:
        """Return what is wrong in a frame."""
        return FormatError(f"frame {place}: {problem}", path=self.path)

    def frame(self, place: int, number: float | None, entry: Any) -> Frame:
        """Read one frame."""
        time = None
        body = entry
        if isinstance(entry, dict) and not _is_point(entry) and not _is_named(entry):
            inside = {plain(key): value for key, value in entry.items()}
            number = named_number(self.path, place, entry, NUMBERS) if number is None else number
            time = self.time(place, entry)
            body = inside.get(self.key) if self.key else None
            known = {*_BODIES, *_ELSE, *NUMBERS, *_TIMES}
            if body is None and not known & set(inside):
                raise self.error(place, f"expected landmarks, found {shape_of(entry)}")
        if body is not None and not isinstance(body, list | dict):
            raise self.error(place, f"expected landmarks, found {shape_of(body)}")
        poses = [self.pose(place, points) for points in _persons(body)]
        if len(poses) > MOST_PEOPLE:
            raise self.error(place, f"{len(poses)} people; {MOST_PEOPLE} are the most")
        self.layout = same_layout(self.path, self.layout, poses)
        return Frame([pose for pose in poses if np.isfinite(pose).any()], number, time)

    def time(self, place: int, entry: Mapping[str, Any]) -> float | None:
        """Return the time that a frame says of itself, as it is written, and note what it is called."""
        for key, value in entry.items():
            if plain(key) in _TIMES and value is not None:
                self.time_name, self.time_form = key, _TIMES[plain(key)]
                return number_of(self.path, f"frame {place}: {key}", value, most=1e18)
        return None

    def pose(self, place: int, points: Any) -> FloatArray:
        """Return a person's points (n_points, 2 or 3)."""
        if isinstance(points, dict):
            names = tuple(map(str, points))
            points = list(points.values())
        else:
            names = tuple(name for point in points if (name := _name_of(point)))
        if len(points) > MOST_POINTS:
            raise self.error(place, f"{len(points)} points of one person; {MOST_POINTS} are the most")
        if len(names) == len(points):
            self.names = self.names or names
            if names != self.names:
                if sorted(names) != sorted(self.names):
                    raise self.error(place, "its points are called otherwise than those of the frames before")
                # The same ones in another order.
                points = [points[names.index(name)] for name in self.names]
        rows = [self.point(place, number, point) for number, point in enumerate(points)]
        with_depth = any(len(row) == 4 for row in rows)
        table = np.array([row if len(row) == 4 or not with_depth else (*row[:2], np.nan, row[2]) for row in rows])
        if not len(table):
            return np.empty((0, 2))
        # Of hands and faces MediaPipe finds no visibility, and says 0 for all.
        unsaid = not table[:, -1].any()
        return confident(table[:, :-1], np.ones(len(table)) if unsaid else table[:, -1], self.least)

    def point(self, place: int, number: int, point: Any) -> tuple[float, ...]:
        """Return x, y, z if there is one, and confidence."""
        what = f"frame {place}: point {number}"
        if point is None:
            return np.nan, np.nan, 0.0
        if isinstance(point, dict):
            inside = {plain(key): value for key, value in point.items()}
            if "x" not in inside or "y" not in inside:
                raise self.error(place, f"point {number}: expected x and y, found {shape_of(point)}")
            axes = [inside[axis] for axis in "xyz" if axis in inside]
            confidence = next((inside[name] for name in _CONFIDENCES if inside.get(name) is not None), None)
        elif isinstance(point, list) and 2 <= len(point) <= 5:
            axes, confidence = point[:3], point[3] if len(point) > 3 else None
        else:
            raise self.error(place, f"point {number}: expected x, y and more, found {shape_of(point)}")
        if any(axis is None for axis in axes):
            return (*[np.nan] * len(axes), 0.0)
        places = [number_of(self.path, what, axis) for axis in axes]
        return (*places, 1.0 if confidence is None else number_of(self.path, f"{what}: confidence", confidence))


def _persons(body: Any) -> Iterator[Any]:
    """Part what stands for a frame into people: each a list of points, or points by name."""
    if isinstance(body, dict) and not _is_point(body):
        inside = {plain(key): value for key, value in body.items()}
        for name in ("landmark", "landmarks", "keypoints"):
            if inside.get(name, 0) is None or isinstance(inside.get(name), list):
                yield from _persons(inside[name])
                return
        if body:
            # What is no point among them is found out when they are read.
            yield body if _is_named(body) else [body]
        return
    if not isinstance(body, list) or not body:
        return
    first = next((one for one in body if one is not None), None)
    if isinstance(first, int | float) and not isinstance(first, bool):
        # All numbers in a row: of each point x, y, z and, where they are as many, how visible it is.
        for count, n_points in ((4, 33), (3, 33), (3, 21), (3, 17)):
            if len(body) == count * n_points:
                yield [body[at : at + count] for at in range(0, len(body), count)]
                return
        yield body
    elif (isinstance(first, dict) and not _is_point(first)) or (
        isinstance(first, list) and first and isinstance(first[0], dict | list)
    ):
        for one in body:
            if one is not None:
                yield from _persons(one)
    elif first is not None:
        yield body


def _is_point(value: Any) -> bool:
    return isinstance(value, dict) and {"x", "y"} <= {plain(key) for key in value}


def _is_named(value: Mapping[str, Any]) -> bool:
    """Tell whether an object holds points by their names."""
    return len(value) > 0 and all(_is_point(one) for one in value.values())


def _name_of(point: Any) -> str:
    if isinstance(point, dict):
        for key in ("name", "part", "landmark", "id"):
            if isinstance(point.get(key), str):
                return str(point[key])
    return ""
