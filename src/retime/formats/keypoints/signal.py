"""A signal of the people in frames: who is whom, and when each frame is."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, FormatWarning
from retime.formats.channel_meaning import make_signal
from retime.formats.keypoints.frames import Found
from retime.formats.keypoints.people import follow
from retime.formats.made_frames import too_many_made
from retime.formats.read_options import ReadOptions
from retime.formats.tables.time_column import numeric_times
from retime.motion.channels import LINEAR
from retime.motion.gaps import GapPolicy
from retime.motion.rate import usual_rate
from retime.motion.signal import Signal

# People who are seen in a smaller share of the frames are passers-by, or none.
_SELDOM = 0.1


def signal_of(path: Path, found: Found, options: ReadOptions) -> Signal:
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
    n_numbers = sum(len(one.poses) for one in often) * len(found.names) * n_axes
    if too_many_made(n_frames, n_channels, n_rows=len(places), n_numbers=n_numbers):
        longest = int(np.diff(places).argmax())
        before, after = (first_frame + place for place in places[longest : longest + 2])
        gigabytes = 8 * n_frames * n_channels / 1e9
        raise FormatError(
            f"from frame {before} on to {after} nothing is there, and {n_frames} frames of {n_channels} channels "
            f"({gigabytes:.2g} GB) would be made of {len(places)}; is that number or time right?",
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


def _timing(path: Path, found: Found, given: Fraction | None) -> tuple[list[int], Fraction, int]:
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


def _at_even_rate(path: Path, found: Found, seconds: FloatArray, rate: Fraction) -> list[int]:
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
