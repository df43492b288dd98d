"""Keypoints of people in footage, as detectors write them in JSON: OpenPose and MediaPipe. Read, not written.

OpenPose writes a file for each frame into a folder (``take_000000000000_keypoints.json``): a list of ``people``, each
with ``pose_keypoints_2d``, the numbers x, y and confidence of each point. What is read is the folder, or the pattern
``take_%012d_keypoints.json`` where there are several takes in it.

MediaPipe writes nothing by itself; its users write what it finds: a list of frames, or an object that holds one, each
frame a list of landmarks with ``x``, ``y``, ``z`` and ``visibility``, or an object that holds it beside a time or a
number. Several people are lists in the list. Such a file is told by what it holds, whatever its lists are called.

A point of little confidence is missing: what a detector guesses jumps about. A frame in which nobody is found is a gap.
"""

from __future__ import annotations

import itertools
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr, kind_of
from retime.errors import FormatError, FormatWarning, OptionError
from retime.files import read_bytes
from retime.formats.channel_meaning import make_signal
from retime.formats.file_signatures import foreign_kind
from retime.formats.keypoint_layouts import MEDIAPIPE, OPENPOSE, names_of
from retime.formats.keypoint_people import follow
from retime.formats.read_options import Limits, ReadOptions
from retime.formats.tables.time_column import numeric_times
from retime.motion.any_motion import AnyMotion
from retime.motion.channels import LINEAR
from retime.motion.gaps import GapPolicy
from retime.motion.rate import parse_rate, usual_rate
from retime.motion.signal import Signal
from retime.strict_json import parse_json

LEAST_CONFIDENCE = 0.3
"""Below it a point counts as missing, unless a person says otherwise."""

# Text takes some ten times its bytes as objects.
_MOST_JSON_BYTES = 256 << 20
_MOST_POINTS = 2000
_MOST_PEOPLE = 100
# No picture is so large, nor a room.
_FARTHEST = 1e7
# People who are seen in a smaller share of the frames are passers-by, or none.
_SELDOM = 0.1
_MOST_NUMBERS = 1 << 26

_ENDING = "_keypoints.json"
_FRAME_FILE = re.compile(r"(.*?)_?(\d{1,12})_keypoints\.json", re.ASCII | re.DOTALL)
_PATTERN = re.compile(r"%0?(\d{0,2})d", re.ASCII)
_OPENPOSE_BODY = ("pose_keypoints_2d", "pose_keypoints", "pose_keypoints_3d")

# What the lists of frames and of landmarks, and the times and numbers of frames are called by those who write them;
# letters alone count, in any case.
_FRAMES = ("frames", "data", "results", "poses", "sequence", "keypoints", "landmarks")
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
_NUMBERS = ("frame", "framenumber", "frameindex", "frameidx", "frameid", "framenum", "frameno", "index")
_RATES = ("fps", "framerate", "rate")
_ABOUT = ("metadata", "meta", "videoinfo", "info", "video")
_CONFIDENCES = ("visibility", "score", "confidence", "presence", "v", "c")


@dataclass(frozen=True, eq=False)
class _Frame:
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
class _Found:
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

    frames: list[_Frame]
    program: str
    layout: str
    names: tuple[str, ...]
    rate: Fraction | None = None
    time_name: str = ""
    time_form: Any = None
    first_number: int = 0


def is_many_files(path: Path) -> bool:
    """Tell whether a path stands for a file a frame: a folder, or a pattern of names."""
    return path.is_dir() or (_PATTERN.search(path.name) is not None and path.name.lower().endswith(".json"))


def read(path: Path, data: bytes, options: ReadOptions) -> Signal:
    """Read keypoints.

    Parameters
    ----------
    path : Path
        The file; or a folder of OpenPose, or the pattern of its files, which are read here.
    data : bytes
        What the file holds.
    options : ReadOptions
        What the reader was told. Gaps of up to a second are bridged where nothing is said of them, and longer ones
        kept.

    Returns
    -------
    Signal
        Channels ``left_wrist.x``, ``left_wrist.y`` (down, as in the picture) and, where there is depth,
        ``left_wrist.z``; of several people ``person1.left_wrist.x``.

    Raises
    ------
    FormatError
        It holds no keypoints, a number is none, frames differ in their points, or there is no rate.
    OSError
        A file can't be read.

    Warns
    -----
    FormatWarning
        Gaps; points that are never there; people who are hardly ever.
    """
    least = LEAST_CONFIDENCE if options.confidence is None else options.confidence
    found = _read_files(path, options.limits, least) if is_many_files(path) else _read_one(path, data, least)
    if len(found.frames) > options.limits.frames:
        raise FormatError(
            f"{len(found.frames)} frames, the limit is {options.limits.frames} (Limits.frames)", path=path
        )
    if not any(frame.poses for frame in found.frames):
        raise FormatError("nobody is found in any frame", path=path)
    return _signal(path, found, options)


def write(motion: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Refuse to: detectors write keypoints; raise FormatError."""
    raise FormatError("keypoints can be read, but not written; a signal is written as .csv", path=path)


# OpenPose.


def _read_files(path: Path, limits: Limits, least: float) -> _Found:
    """Read the files of OpenPose, one for each frame."""
    numbers, files = _frame_files(path)
    if len(files) > limits.frames:
        raise FormatError(f"{len(files)} frames, the limit is {limits.frames} (Limits.frames)", path=path)
    rest = limits.file_bytes
    frames = []
    layout: tuple[int, int] | None = None
    for file in files:
        data = read_bytes(file, min(rest, _MOST_JSON_BYTES))
        rest -= len(data)
        document = _parsed(file, data)
        if not _is_openpose(document):
            raise FormatError(
                f"expected the people of a frame of OpenPose ({{'people': [...]}}), found {_shape_of(document)}",
                path=file,
            )
        poses = [_openpose_person(file, number, one, least) for number, one in enumerate(_people(file, document))]
        layout = _same_layout(file, layout, poses)
        frames.append(_Frame([pose for pose in poses if np.isfinite(pose).any()]))
    return _openpose(frames, layout, path, first_number=numbers[0])


def _frame_files(path: Path) -> tuple[list[int], list[Path]]:
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
        match = (pattern or _FRAME_FILE).fullmatch(entry.name)
        if match:
            by_take.setdefault(match[1], {})[int(match[2])] = entry
    if not by_take:
        raise FormatError(
            f"no file in it is called …{_ENDING}" if pattern is None else "no file is called so", path=path
        )
    if len(by_take) > 1:
        some = ", ".join(f"{take}_%012d{_ENDING}" for take in sorted(by_take)[:4])
        raise FormatError(f"holds {len(by_take)} takes: give one of them, by its pattern ({some})", path=path)
    (files,) = by_take.values()
    numbers = sorted(files)
    missing = next((a + 1 for a, b in itertools.pairwise(numbers) if b != a + 1), None)
    if missing is not None:
        raise FormatError(f"frame {missing} is missing between {numbers[0]} and {numbers[-1]}", path=path)
    return numbers, [files[number] for number in numbers]


def _is_openpose(document: Any) -> bool:
    return isinstance(document, dict) and isinstance(document.get("people"), list)


def _people(path: Path, document: dict[str, Any]) -> list[Any]:
    people: list[Any] = document["people"]
    if len(people) > _MOST_PEOPLE:
        raise FormatError(f"{len(people)} people in one frame; {_MOST_PEOPLE} are the most", path=path)
    return people


def _openpose_person(path: Path, number: int, person: Any, least: float) -> FloatArray:
    """Return a person's points (n_points, 2 or 3)."""
    if not isinstance(person, dict):
        raise FormatError(f"person {number}: expected an object, found {_shape_of(person)}", path=path)
    # What wasn't looked for is an empty list.
    key = next((key for key in _OPENPOSE_BODY if person.get(key)), None)
    if key is None:
        if not any(key in person for key in _OPENPOSE_BODY):
            raise FormatError(f"person {number} has no {_OPENPOSE_BODY[0]}", path=path)
        return np.empty((0, 2))
    n_axes = 3 if key.endswith("3d") else 2
    flat = person[key]
    if not isinstance(flat, list) or len(flat) % (n_axes + 1):
        raise FormatError(
            f"person {number}: {key} is to be a list of {n_axes + 1} numbers for each point, found {_shape_of(flat)}",
            path=path,
        )
    points = np.array([_number(path, f"person {number}: {key}", value) for value in flat]).reshape(-1, n_axes + 1)
    return _confident(points[:, :n_axes], points[:, n_axes], least)


def _openpose(frames: list[_Frame], layout: tuple[int, int] | None, path: Path, *, first_number: int) -> _Found:
    if layout is None:
        raise FormatError("nobody is found in any frame", path=path)
    title, names = names_of(OPENPOSE, layout[0])
    return _Found(frames, "OpenPose", title, names, first_number=first_number)


def _same_layout(path: Path, layout: tuple[int, int] | None, poses: Sequence[FloatArray]) -> tuple[int, int] | None:
    """Check that poses have as many points, and axes, as those before."""
    for pose in poses:
        if not len(pose):
            continue
        if len(pose) > _MOST_POINTS:
            raise FormatError(f"{len(pose)} points of one person; {_MOST_POINTS} are the most", path=path)
        found = pose.shape[0], pose.shape[1]
        if layout is not None and found != layout:
            raise FormatError(
                f"a person of {found[0]} points with {found[1]} coordinates after one of {layout[0]} with {layout[1]}: "
                "all are to have the same points",
                path=path,
            )
        layout = found
    return layout


def _confident(places: FloatArray, confidence: FloatArray, least: float) -> FloatArray:
    """Take points of less confidence out, and those at 0, 0 of none, which is how "not found" is written."""
    gone = (confidence < least) | (confidence <= 0)
    return np.where(gone[:, None], np.nan, places)


# One file.


def _parsed(path: Path, data: bytes) -> Any:
    """Parse a file's JSON; raise FormatError with its path."""
    if not data.strip():
        raise FormatError("empty; expected keypoints (JSON)", path=path)
    kind = foreign_kind(data)
    if kind is not None and kind != "a JSON document":
        raise FormatError(f"this is {kind}; expected keypoints (JSON)", path=path)
    if len(data) > _MOST_JSON_BYTES:
        raise FormatError(f"{len(data)} bytes of JSON; {_MOST_JSON_BYTES} are the most", path=path)
    try:
        return parse_json(data, what="keypoints")
    except FormatError as error:
        raise FormatError(error.problem, path=path, line=error.line, column=error.column, byte=error.byte) from None


def _read_one(path: Path, data: bytes, least: float) -> _Found:
    document = _parsed(path, data)
    if _is_openpose(document):
        match = _FRAME_FILE.fullmatch(path.name)
        name = path.name.replace(match[2], f"%0{len(match[2])}d") if match else f"take_%012d{_ENDING}"
        raise FormatError(f"one frame of OpenPose: give the folder of its frames, or their pattern ({name})", path=path)
    rate, entries = _entries(path, document)
    if not entries:
        raise FormatError("no frame", path=path)
    if all(_is_openpose(entry) for _, entry in entries):
        frames = []
        layout: tuple[int, int] | None = None
        for place, (_, entry) in enumerate(entries):
            people = _people(path, entry)
            poses = [_openpose_person(path, who, one, least) for who, one in enumerate(people)]
            layout = _same_layout(path, layout, poses)
            number = _named_number(path, place, entry, _NUMBERS)
            frames.append(_Frame([pose for pose in poses if np.isfinite(pose).any()], number))
        return replace(_openpose(frames, layout, path, first_number=0), rate=rate)
    reader = _Landmarks(path, least, _chosen_list(entry for _, entry in entries))
    frames = [reader.frame(place, number, entry) for place, (number, entry) in enumerate(entries)]
    names: tuple[str, ...] = reader.names
    if reader.layout is None:
        raise FormatError("nobody is found in any frame", path=path)
    title, usual = names_of(MEDIAPIPE, reader.layout[0])
    return _Found(frames, "MediaPipe", title, names or usual, rate, reader.time_name, reader.time_form)


def _entries(path: Path, document: Any) -> tuple[Fraction | None, list[tuple[float | None, Any]]]:
    """Find the list of frames in a document, and the rate that it says; of frames by number, with those."""
    rate = None
    listed = document
    if isinstance(document, dict):
        rate = _said_rate(path, document)
        if document and all(isinstance(key, str) and re.fullmatch(r"[0-9]{1,9}", key) for key in document):
            return None, [(float(key), document[key]) for key in sorted(document, key=int)]
        inside = {_plain(key): value for key, value in document.items()}
        found = next((inside[name] for name in _FRAMES if isinstance(inside.get(name), list | dict)), None)
        if isinstance(found, dict):
            return rate, _entries(path, found)[1]
        listed = found
    if not isinstance(listed, list):
        raise FormatError(
            "no keypoints of OpenPose or MediaPipe: expected a list of frames, or an object with one (frames), found "
            f"{_shape_of(document)}",
            path=path,
        )
    return rate, [(None, entry) for entry in listed]


def _said_rate(path: Path, document: Mapping[str, Any]) -> Fraction | None:
    """Find a rate among what a document says of itself."""
    inside = {_plain(key): value for key, value in document.items()}
    for about in (inside, *(inside[name] for name in _ABOUT if isinstance(inside.get(name), dict))):
        for key, value in about.items():
            if _plain(key) in _RATES and value is not None:
                try:
                    return parse_rate(value if isinstance(value, str) else repr(value))
                except OptionError as error:
                    raise FormatError(f"{key}: {error}", path=path) from None
    return None


def _chosen_list(entries: Iterable[Any]) -> str | None:
    """Say which of the lists in frames is read: of the body, where a frame has one, else of a hand, in all frames."""
    there = {
        _plain(key)
        for entry in entries
        if isinstance(entry, dict) and not _is_point(entry) and not _is_named(entry)
        for key, value in entry.items()
        if value
    }
    return next((name for name in (*_BODIES, *_ELSE) if name in there), None)


class _Landmarks:
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
        return FormatError(f"frame {place}: {problem}", path=self.path)

    def frame(self, place: int, number: float | None, entry: Any) -> _Frame:
        """Read one frame."""
        time = None
        body = entry
        if isinstance(entry, dict) and not _is_point(entry) and not _is_named(entry):
            inside = {_plain(key): value for key, value in entry.items()}
            number = _named_number(self.path, place, entry, _NUMBERS) if number is None else number
            time = self.time(place, entry)
            body = inside.get(self.key) if self.key else None
            known = {*_BODIES, *_ELSE, *_NUMBERS, *_TIMES}
            if body is None and not known & set(inside):
                raise self.error(place, f"expected landmarks, found {_shape_of(entry)}")
        if body is not None and not isinstance(body, list | dict):
            raise self.error(place, f"expected landmarks, found {_shape_of(body)}")
        poses = [self.pose(place, points) for points in _persons(body)]
        if len(poses) > _MOST_PEOPLE:
            raise self.error(place, f"{len(poses)} people; {_MOST_PEOPLE} are the most")
        self.layout = _same_layout(self.path, self.layout, poses)
        return _Frame([pose for pose in poses if np.isfinite(pose).any()], number, time)

    def time(self, place: int, entry: Mapping[str, Any]) -> float | None:
        for key, value in entry.items():
            if _plain(key) in _TIMES and value is not None:
                self.time_name, self.time_form = key, _TIMES[_plain(key)]
                return _number(self.path, f"frame {place}: {key}", value, most=1e18)
        return None

    def pose(self, place: int, points: Any) -> FloatArray:
        """Return a person's points (n_points, 2 or 3)."""
        if isinstance(points, dict):
            names = tuple(map(str, points))
            points = list(points.values())
        else:
            names = tuple(name for point in points if (name := _name_of(point)))
        if len(points) > _MOST_POINTS:
            raise self.error(place, f"{len(points)} points of one person; {_MOST_POINTS} are the most")
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
        return _confident(table[:, :-1], np.ones(len(table)) if unsaid else table[:, -1], self.least)

    def point(self, place: int, number: int, point: Any) -> tuple[float, ...]:
        """Return x, y, z if there is one, and confidence."""
        what = f"frame {place}: point {number}"
        if point is None:
            return np.nan, np.nan, 0.0
        if isinstance(point, dict):
            inside = {_plain(key): value for key, value in point.items()}
            if "x" not in inside or "y" not in inside:
                raise self.error(place, f"point {number}: expected x and y, found {_shape_of(point)}")
            axes = [inside[axis] for axis in "xyz" if axis in inside]
            confidence = next((inside[name] for name in _CONFIDENCES if inside.get(name) is not None), None)
        elif isinstance(point, list) and 2 <= len(point) <= 5:
            axes, confidence = point[:3], point[3] if len(point) > 3 else None
        else:
            raise self.error(place, f"point {number}: expected x, y and more, found {_shape_of(point)}")
        if any(axis is None for axis in axes):
            return (*[np.nan] * len(axes), 0.0)
        places = [_number(self.path, what, axis) for axis in axes]
        return (*places, 1.0 if confidence is None else _number(self.path, f"{what}: confidence", confidence))


def _persons(body: Any) -> Iterator[Any]:
    """Part what stands for a frame into people: each a list of points, or points by name."""
    if isinstance(body, dict) and not _is_point(body):
        inside = {_plain(key): value for key, value in body.items()}
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
    return isinstance(value, dict) and {"x", "y"} <= {_plain(key) for key in value}


def _is_named(value: Mapping[str, Any]) -> bool:
    """Tell whether an object holds points by their names."""
    return len(value) > 0 and all(_is_point(one) for one in value.values())


def _name_of(point: Any) -> str:
    if isinstance(point, dict):
        for key in ("name", "part", "landmark", "id"):
            if isinstance(point.get(key), str):
                return str(point[key])
    return ""


def _named_number(path: Path, place: int, entry: Any, names: Sequence[str]) -> float | None:
    for key, value in entry.items():
        # A frame may be called by the name of its picture.
        if _plain(key) in names and isinstance(value, int | float) and not isinstance(value, bool):
            return _number(path, f"frame {place}: {key}", value, most=1e12)
    return None


def _number(path: Path, what: str, value: Any, most: float = _FARTHEST) -> float:
    """Return a number; raise FormatError where it is none, or lies in no picture."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FormatError(f"{what}: expected a number, found {_shape_of(value)}", path=path)
    if not abs(value) <= most:
        raise FormatError(f"{what}: {value!s:.40} is too large", path=path)
    return float(value)


def _plain(key: str) -> str:
    """Return the letters of a key: ``pose_landmarks`` and ``poseLandmarks`` are one."""
    return re.sub(r"[^a-z0-9]", "", key.lower())


def _shape_of(value: Any) -> str:
    """Say what a part of a document is."""
    if isinstance(value, dict):
        some = ", ".join(str(key)[:20] for key in list(value)[:4])
        return f"an object with {some}" if some else "an empty object"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    return "nothing" if value is None else f"{value!r:.40}" if isinstance(value, str) else kind_of(value)


# Both.


def _signal(path: Path, found: _Found, options: ReadOptions) -> Signal:
    """Make a signal of frames: everyone at their place in time, whoever is whom."""
    places, rate, first_frame = _timing(path, found, options.rate or found.rate)
    people = follow([(place, frame.poses) for place, frame in zip(places, found.frames, strict=True) if frame.poses])
    n_frames = places[-1] + 1
    n_seen = sum(bool(frame.poses) for frame in found.frames)
    often = [one for one in people if len(one.poses) >= _SELDOM * n_seen]
    often = often or [max(people, key=lambda one: len(one.poses))]
    if len(often) < len(people):
        warnings.warn(
            f"{path}: {len(people) - len(often)} more people are seen in under {_SELDOM:.0%} of the frames, and were "
            "left out",
            FormatWarning,
            stacklevel=4,
        )
    n_axes = next(iter(often[0].poses.values())).shape[1]
    n_channels = len(often) * len(found.names) * n_axes
    if n_frames > options.limits.frames or n_channels > options.limits.channels:
        raise FormatError(
            f"{n_frames} frames of {n_channels} channels; the limits are {options.limits.frames} and "
            f"{options.limits.channels} (Limits.frames, Limits.channels)",
            path=path,
        )
    if n_frames * n_channels > _MOST_NUMBERS:
        raise FormatError(
            f"{n_frames} frames of {n_channels} channels are {n_frames * n_channels} numbers, the limit is "
            f"{_MOST_NUMBERS}",
            path=path,
        )
    values = np.full((n_frames, len(often), len(found.names), n_axes), np.nan)
    for who, person in enumerate(often):
        for frame, pose in person.poses.items():
            values[frame, who] = pose
    names = [
        (f"person{who + 1}." if len(often) > 1 else "") + f"{name}.{axis}"
        for who in range(len(often))
        for name in found.names
        for axis in "xyz"[:n_axes]
    ]
    table = values.reshape(n_frames, -1)
    table, names = _without_unseen(path, table, names)
    if options.gaps is None:
        options = replace(options, gaps=GapPolicy.parse("bridge"))
    known = dict.fromkeys(range(len(names)), LINEAR)
    dialect = f"{found.program}, {found.layout}" + (f", {len(often)} people" if len(often) > 1 else "")
    return make_signal(path, names, table, rate, options, known, first_frame=first_frame, dialect=dialect)


def _without_unseen(path: Path, table: FloatArray, names: list[str]) -> tuple[FloatArray, list[str]]:
    """Leave out channels that have no value at all."""
    unseen = np.asarray(np.isnan(table).all(axis=0))
    if not unseen.any():
        return table, names
    gone = list(dict.fromkeys(name[:-2] for name, absent in zip(names, unseen.tolist(), strict=True) if absent))
    more = f" and {len(gone) - 6} more" if len(gone) > 6 else ""
    warnings.warn(
        f"{path}: never seen with enough confidence, and so left out: {', '.join(gone[:6])}{more} (--confidence)",
        FormatWarning,
        stacklevel=5,
    )
    kept = np.flatnonzero(~unseen)
    return np.ascontiguousarray(table[:, kept]), [names[place] for place in kept]


def _timing(path: Path, found: _Found, given: Fraction | None) -> tuple[list[int], Fraction, int]:
    """Find on which frame of an even rate each frame of the file lies, that rate, and the first frame's number."""
    frames = found.frames
    numbers = [frame.number for frame in frames]
    first_number = found.first_number
    if any(number is not None for number in numbers):
        steps = _rising(path, "frame numbers", numbers)
        if not np.array_equal(steps, np.round(steps)):
            raise FormatError("frame numbers are to be whole", path=path)
        first_number = int(steps[0])
        places = [int(step) - first_number for step in steps]
    else:
        places = list(range(len(frames)))
    times = [frame.time for frame in frames]
    if given is not None or all(time is None for time in times):
        if given is None:
            raise FormatError(
                f"nothing says how many frames a second there are, which {found.program} doesn't write: give them "
                "(--fps)",
                path=path,
            )
        return places, given, first_number
    said = _rising(path, f"{found.time_name!r}", times)
    column = numeric_times(found.time_name, said, repr(float(said[0])), found.time_form)
    if len(said) == 1:
        raise FormatError("a single frame, whose time gives no rate: give it (--fps)", path=path)
    seconds = (said - said[0]) / column.ticks
    if places == list(range(len(frames))) and (rate := column.told_rate()) is not None:
        return places, rate, first_number
    if places[-1] != len(frames) - 1:
        # Frames without anybody were left out: their numbers tell.
        rate = usual_rate(places[-1] / float(seconds[-1]))
        return places, rate, first_number
    rate = usual_rate(1 / float(np.median(np.diff(seconds))))
    return _at_even_rate(path, found, seconds, rate), rate, 0


def _at_even_rate(path: Path, found: _Found, seconds: FloatArray, rate: Fraction) -> list[int]:
    """Lay frames whose times are not even on the nearest frames of an even rate; of two on one, the first counts."""
    nearest = np.round(seconds * float(rate)).astype(np.int64)
    keep = np.flatnonzero(np.append(True, np.diff(nearest) > 0))
    found.frames = [found.frames[place] for place in keep.tolist()]
    warnings.warn(
        f"{path}: its times are uneven: each frame stands on the nearest of {float(rate):.6g} a second (--fps takes "
        "them as even)",
        FormatWarning,
        stacklevel=6,
    )
    return [int(place) for place in nearest[keep]]


def _rising(path: Path, what: str, numbers: Sequence[float | None]) -> FloatArray:
    """Return numbers that all frames have, and that increase; raise FormatError."""
    absent = next((place for place, number in enumerate(numbers) if number is None), None)
    if absent is not None:
        raise FormatError(f"frame {absent} has none of the {what} that others have", path=path)
    array = np.array(numbers, dtype=np.float64)
    back = np.flatnonzero(~(np.diff(array) > 0))
    if len(back):
        place = int(back[0])
        raise FormatError(
            f"frame {place + 1}: {what} go from {array[place]:.10g} to {array[place + 1]:.10g}; expected them to "
            "increase",
            path=path,
        )
    return array
