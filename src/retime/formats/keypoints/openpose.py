"""What OpenPose writes of a frame: people, each a list of numbers, three or four a point."""

from __future__ import annotations

import itertools
import re
from pathlib import Path
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, OptionError
from retime.formats.keypoints.frames import MOST_PEOPLE, Found, Frame, confident, number_of, shape_of
from retime.formats.keypoints.layouts import OPENPOSE, names_of

ENDING = "_keypoints.json"
FRAME_FILE = re.compile(r"(.*?)_?(\d{1,12})_keypoints\.json", re.ASCII | re.DOTALL)
_PATTERN = re.compile(r"%0?(\d{0,2})d", re.ASCII)
_BODIES = ("pose_keypoints_2d", "pose_keypoints", "pose_keypoints_3d")


def is_many_files(path: Path) -> bool:
    """Tell whether a path stands for a file a frame: a folder, or a pattern of names."""
    return path.is_dir() or (_PATTERN.search(path.name) is not None and path.name.lower().endswith(".json"))


def frame_files(path: Path) -> tuple[list[int], list[Path]]:
    """Find the files of a folder, or of a pattern, and their numbers."""
    by_take: dict[str, dict[int, Path]] = {}
    pattern = None
    folder = path
    if not path.is_dir():
        folder = path.parent
        marks = list(_PATTERN.finditer(path.name))
        if len(marks) != 1:
            raise OptionError(f"{path}: expected one pattern such as %012d in the name, found {len(marks)}")
        before, after = path.name[: marks[0].start()], path.name[marks[0].end() :]
        pattern = re.compile(f"({re.escape(before)})(\\d{{1,12}}){re.escape(after)}", re.ASCII)
    for entry in folder.iterdir():
        match = (pattern or FRAME_FILE).fullmatch(entry.name)
        if match:
            by_take.setdefault(match[1], {})[int(match[2])] = entry
    if not by_take:
        raise FormatError(
            f"no file in it is called …{ENDING}" if pattern is None else "no file is called so", path=path
        )
    if len(by_take) > 1:
        some = ", ".join(f"{take}_%012d{ENDING}" for take in sorted(by_take)[:4])
        raise FormatError(f"holds {len(by_take)} takes: give one of them, by its pattern ({some})", path=path)
    (files,) = by_take.values()
    numbers = sorted(files)
    missing = next((a + 1 for a, b in itertools.pairwise(numbers) if b != a + 1), None)
    if missing is not None:
        raise FormatError(f"frame {missing} is missing between {numbers[0]} and {numbers[-1]}", path=path)
    return numbers, [files[number] for number in numbers]


def is_frame(document: Any) -> bool:
    """Tell whether a document is what OpenPose writes of a frame."""
    return isinstance(document, dict) and isinstance(document.get("people"), list)


def people_of(path: Path, document: dict[str, Any]) -> list[Any]:
    """Return the people of a frame; raise FormatError where they are too many."""
    people: list[Any] = document["people"]
    if len(people) > MOST_PEOPLE:
        raise FormatError(f"{len(people)} people in one frame; {MOST_PEOPLE} are the most", path=path)
    return people


def person_points(path: Path, number: int, person: Any, least: float) -> FloatArray:
    """Return a person's points (n_points, 2 or 3)."""
    if not isinstance(person, dict):
        raise FormatError(f"person {number}: expected an object, found {shape_of(person)}", path=path)
    # What wasn't looked for is an empty list.
    key = next((key for key in _BODIES if person.get(key)), None)
    if key is None:
        if not any(key in person for key in _BODIES):
            raise FormatError(f"person {number} has no {_BODIES[0]}", path=path)
        return np.empty((0, 2))
    n_axes = 3 if key.endswith("3d") else 2
    flat = person[key]
    if not isinstance(flat, list) or len(flat) % (n_axes + 1):
        raise FormatError(
            f"person {number}: {key} is to be a list of {n_axes + 1} numbers for each point, found {shape_of(flat)}",
            path=path,
        )
    points = np.array([number_of(path, f"person {number}: {key}", value) for value in flat]).reshape(-1, n_axes + 1)
    return confident(points[:, :n_axes], points[:, n_axes], least)


def found_by(frames: list[Frame], layout: tuple[int, int] | None, path: Path, *, first_number: int) -> Found:
    """Name the points of frames that were read; raise FormatError where nobody is in any."""
    if layout is None:
        raise FormatError("nobody is found in any frame", path=path)
    title, names = names_of(OPENPOSE, layout[0])
    return Found(frames, "OpenPose", title, names, first_number=first_number)
