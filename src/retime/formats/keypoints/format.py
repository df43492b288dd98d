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

import re
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from retime.errors import FormatError, OptionError
from retime.files import read_bytes
from retime.formats.file_signatures import foreign_kind
from retime.formats.keypoints.frames import NUMBERS, Found, Frame, named_number, plain, same_layout, shape_of
from retime.formats.keypoints.layouts import MEDIAPIPE, names_of
from retime.formats.keypoints.mediapipe import Landmarks, chosen_list
from retime.formats.keypoints.openpose import (
    ENDING,
    FRAME_FILE,
    found_by,
    frame_files,
    is_frame,
    is_many_files,
    people_of,
    person_points,
)
from retime.formats.keypoints.signal import signal_of
from retime.formats.read_options import Limits, ReadOptions
from retime.motion.any_motion import AnyMotion
from retime.motion.rate import parse_rate
from retime.motion.signal import Signal
from retime.strict_json import parse_json

LEAST_CONFIDENCE = 0.3
"""Below it a point counts as missing, unless a person says otherwise."""

# Text takes some ten times its bytes as objects.
_MOST_JSON_BYTES = 256 << 20

# What the lists of frames, and the rate, are called by those who write them; letters alone count, in any case.
_FRAMES = ("frames", "data", "results", "poses", "sequence", "keypoints", "landmarks")
_RATES = ("fps", "framerate", "rate")
_ABOUT = ("metadata", "meta", "videoinfo", "info", "video")


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
    return signal_of(path, found, options)


def write(motion: AnyMotion, path: Path, *, overwrite: bool) -> None:
    """Refuse to: detectors write keypoints; raise FormatError."""
    raise FormatError("keypoints can be read, but not written; a signal is written as .csv", path=path)


def _read_files(path: Path, limits: Limits, least: float) -> Found:
    """Read the files of OpenPose, one for each frame."""
    numbers, files = frame_files(path)
    if len(files) > limits.frames:
        raise FormatError(f"{len(files)} frames, the limit is {limits.frames} (Limits.frames)", path=path)
    rest = limits.file_bytes
    frames = []
    layout: tuple[int, int] | None = None
    for file in files:
        data = read_bytes(file, min(rest, _MOST_JSON_BYTES))
        rest -= len(data)
        document = _parsed(file, data)
        if not is_frame(document):
            raise FormatError(
                f"expected the people of a frame of OpenPose ({{'people': [...]}}), found {shape_of(document)}",
                path=file,
            )
        poses = [person_points(file, number, one, least) for number, one in enumerate(people_of(file, document))]
        layout = same_layout(file, layout, poses)
        frames.append(Frame([pose for pose in poses if np.isfinite(pose).any()]))
    return found_by(frames, layout, path, first_number=numbers[0])


def _read_one(path: Path, data: bytes, least: float) -> Found:
    document = _parsed(path, data)
    if is_frame(document):
        match = FRAME_FILE.fullmatch(path.name)
        name = path.name.replace(match[2], f"%0{len(match[2])}d") if match else f"take_%012d{ENDING}"
        raise FormatError(f"one frame of OpenPose: give the folder of its frames, or their pattern ({name})", path=path)
    rate, entries = _entries(path, document)
    if not entries:
        raise FormatError("no frame", path=path)
    if all(is_frame(entry) for _, entry in entries):
        frames = []
        layout: tuple[int, int] | None = None
        for place, (_, entry) in enumerate(entries):
            people = people_of(path, entry)
            poses = [person_points(path, who, one, least) for who, one in enumerate(people)]
            layout = same_layout(path, layout, poses)
            number = named_number(path, place, entry, NUMBERS)
            frames.append(Frame([pose for pose in poses if np.isfinite(pose).any()], number))
        return replace(found_by(frames, layout, path, first_number=0), rate=rate)
    reader = Landmarks(path, least, chosen_list(entry for _, entry in entries))
    frames = [reader.frame(place, number, entry) for place, (number, entry) in enumerate(entries)]
    names: tuple[str, ...] = reader.names
    if reader.layout is None:
        raise FormatError("nobody is found in any frame", path=path)
    title, usual = names_of(MEDIAPIPE, reader.layout[0])
    return Found(frames, "MediaPipe", title, names or usual, rate, reader.time_name, reader.time_form)


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


def _entries(path: Path, document: Any) -> tuple[Fraction | None, list[tuple[float | None, Any]]]:
    """Find the list of frames in a document, and the rate that it says; of frames by number, with those."""
    rate = None
    listed = document
    if isinstance(document, dict):
        rate = _said_rate(path, document)
        if document and all(isinstance(key, str) and re.fullmatch(r"[0-9]{1,9}", key) for key in document):
            return None, [(float(key), document[key]) for key in sorted(document, key=int)]
        inside = {plain(key): value for key, value in document.items()}
        found = next((inside[name] for name in _FRAMES if isinstance(inside.get(name), list | dict)), None)
        if isinstance(found, dict):
            return rate, _entries(path, found)[1]
        listed = found
    if not isinstance(listed, list):
        raise FormatError(
            "no keypoints of OpenPose or MediaPipe: expected a list of frames, or an object with one (frames), found "
            f"{shape_of(document)}",
            path=path,
        )
    return rate, [(None, entry) for entry in listed]


def _said_rate(path: Path, document: Mapping[str, Any]) -> Fraction | None:
    """Find a rate among what a document says of itself."""
    inside = {plain(key): value for key, value in document.items()}
    for about in (inside, *(inside[name] for name in _ABOUT if isinstance(inside.get(name), dict))):
        for key, value in about.items():
            if plain(key) in _RATES and value is not None:
                try:
                    return parse_rate(value if isinstance(value, str) else repr(value))
                except OptionError as error:
                    raise FormatError(f"{key}: {error}", path=path) from None
    return None
