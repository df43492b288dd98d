"""The study's material: clips of the data folder, and warps made by hand, whose answer is known.

A warp by hand changes the timing of every cycle (or jump, or punch) of a clip in the same way. Given one of them as
the reference, the method should find the others: so the whole warp is the answer to compare with.
"""

from __future__ import annotations

import importlib.resources
import itertools
import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.brief import brief_repr
from retime.errors import FormatWarning, OptionError
from retime.evaluate.metrics import flight_spans
from retime.formats.registry import read
from retime.motion.joint_names import body_parts
from retime.motion.kinematics import global_poses, heading_positions, metres_per_unit
from retime.motion.motion import Motion
from retime.motion.rotation import FloatArray
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp

# "multiplied by this scale to convert to meters" (CMU's FAQ); the BVH conversions keep the unit.
_CMU_METRES = 2.54 / 45


@dataclass(frozen=True)
class Source:
    """Where a clip comes from.

    Attributes
    ----------
    path : str
        Inside the data folder.
    drop_first : int
        Rows in front that are no capture: the T-pose of the cgspeed conversions. 07_12 has a second one.
    frames : int, optional
        Frames to keep after those; left out, all.
    rate : int
        Frames a second, for files that don't say.
    metres_per_unit : float, optional
        Where the file doesn't say.
    """

    path: str
    drop_first: int = 1
    frames: int | None = None
    rate: int = 120
    metres_per_unit: float | None = _CMU_METRES


def _cmu(trial: str, drop_first: int = 1) -> Source:
    return Source(f"cmu-bvh/{trial}.bvh", drop_first)


SOURCES = {
    trial: _cmu(trial)
    for trial in (
        *("01_01", "02_04", "05_08", "05_15", "05_16", "05_18", "07_01", "07_09", "07_10", "29_01"),
        *("49_02", "49_04", "49_05"),
    )
} | {
    "07_12": _cmu("07_12", drop_first=2),
    # Walk, jump, walk: the punches and kicks come later.
    "86_01": Source("cmu-asfamc/86_01.amc", drop_first=0, frames=1980),
    "mocapbank": Source("bvh-other/test_mocapbank.bvh", drop_first=0, rate=30, metres_per_unit=None),
    "boxing": Source("bvh-other/Boxing_Toes.bvh", drop_first=0, rate=100, metres_per_unit=None),
}


def missing_files(folder: Path) -> list[Path]:
    """List the files of `SOURCES` that a folder lacks."""
    return [folder / source.path for source in SOURCES.values() if not (folder / source.path).is_file()]


class Library:
    """Clips of the data folder, each read once.

    Parameters
    ----------
    folder : Path
        Laid out as `SOURCES` says.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._motions: dict[str, Motion] = {}

    def __getitem__(self, name: str) -> Motion:
        """Return a clip; "sample" is the shipped one. Raise the reader's errors."""
        if name not in self._motions:
            self._motions[name] = read_sample() if name == "sample" else read_source(self.folder, SOURCES[name], name)
        return self._motions[name]

    def stretch(self, name: str, start: float, end: float) -> Motion:
        """Cut a stretch out of a clip by input times, seconds, to the nearest frames; both included."""
        motion = self[name]
        first, last = round(start * float(motion.rate)), round(end * float(motion.rate))
        return replace(motion.frames(first, min(last + 1, motion.n_frames)), first_frame=0)


def read_source(folder: Path, source: Source, name: str) -> Motion:
    """Read a clip as the study uses it: its extra rows dropped, its rate and unit told.

    Raises
    ------
    FormatError
        The file is broken.
    FileNotFoundError
        It is not in the folder.
    """
    with warnings.catch_warnings():
        # What the readers warn of here (AMC says no rate, one header counts a row too few) is known.
        warnings.simplefilter("ignore", FormatWarning)
        motion = read(folder / source.path, rate=Fraction(source.rate))
    assert isinstance(motion, Motion)
    stop = motion.n_frames if source.frames is None else source.drop_first + source.frames
    motion = motion.frames(source.drop_first, stop)
    unit = source.metres_per_unit if motion.metres_per_unit is None else motion.metres_per_unit
    return replace(motion, name=name, first_frame=0, metres_per_unit=unit)


def read_sample() -> Motion:
    """Read the sample clip that is shipped."""
    with importlib.resources.as_file(importlib.resources.files("retime").joinpath("data/sample.bvh")) as path:
        motion = read(path)
    assert isinstance(motion, Motion)
    return replace(motion, name="sample")


@dataclass(frozen=True)
class Step:
    """A moment of a gait: a foot is farthest in front of the root.

    Attributes
    ----------
    time : float
        Input time, seconds.
    side : str
        "left" or "right".
    """

    time: float
    side: str


def steps(motion: Motion, *, reach: float = 0.12, apart: float = 0.2) -> list[Step]:
    """Find the steps of a walk or run, by when each foot is farthest in front of the root.

    Parameters
    ----------
    motion : Motion
        Its skeleton's names say which joints are the feet; forward is +Z in heading space.
    reach : float
        Metres in front of the root that a step gets, at least.
    apart : float
        Seconds within which a foot is nowhere farther in front.

    Raises
    ------
    OptionError
        No foot is known by its name.
    """
    rate = float(motion.rate)
    parts = body_parts(motion.skeleton.names)
    places = heading_positions(global_poses(motion)) * metres_per_unit(motion)
    window = max(1, round(0.1 * rate))
    found = []
    for side in ("left", "right"):
        joints = [i for i, part in enumerate(parts) if part is not None and (part.side, part.base) == (side, "foot")]
        if not joints:
            raise OptionError(f"no joint of {motion.name or 'the motion'} is known to be the {side} foot")
        ahead = places[:, joints[0], 2] - places[:, 0, 2]
        padded = np.pad(ahead, (window // 2, window - 1 - window // 2), mode="edge")
        smooth = np.convolve(padded, np.ones(window) / window, "valid")
        margin = round(apart * rate)
        for frame in range(window // 2 + 1, motion.n_frames - window // 2 - 1):
            near = smooth[max(0, frame - margin) : frame + margin + 1]
            if smooth[frame] > reach and smooth[frame] == near.max():
                found.append(Step(frame / rate, side))
    return sorted(found, key=lambda step: step.time)


def cycles(motion: Motion, *, shortest: float = 0.25, longest: float = 1.1) -> list[tuple[Step, Step]]:
    """Pair each step with the next one, where that is the other foot's and follows in a walker's time, seconds."""
    return [
        (a, b)
        for a, b in itertools.pairwise(steps(motion))
        if a.side != b.side and shortest <= b.time - a.time <= longest
    ]


def limp(motion: Motion, *, strength: float = 1.7) -> Warp:
    """Make a walk limp: hurry over every step that begins with the left foot in front, linger over every other.

    The speed goes smoothly from 1 to `strength` and back within each hurried step, and to 1 / `strength` in the others.
    What is no walk keeps its speed. Where the clip begins or ends within a step, the step's warp is cut off there.
    """
    times = np.arange(motion.n_frames) / float(motion.rate)
    log_speed = np.zeros(motion.n_frames)
    halves = cycles(motion)
    spans = [(a.time, b.time, a.side) for a, b in halves]
    if halves:
        usual = float(np.mean([b.time - a.time for a, b in halves]))
        first, last = halves[0][0], halves[-1][1]
        if first.time < usual:
            spans.append((first.time - usual, first.time, "right" if first.side == "left" else "left"))
        if motion.end_time - last.time < usual:
            spans.append((last.time, last.time + usual, last.side))
    for start, end, side in spans:
        inside = (times >= start) & (times < end)
        sign = 1.0 if side == "left" else -1.0
        log_speed[inside] = sign * math.log(strength) * np.sin(np.pi * (times[inside] - start) / (end - start))
    return from_log_speed(log_speed, motion)


def walking_spans(motion: Motion) -> tuple[tuple[float, float], ...]:
    """Input times of unbroken walks: where `limp` changes whole steps."""
    spans: list[tuple[float, float]] = []
    for a, b in cycles(motion):
        if spans and spans[-1][1] == a.time:
            spans[-1] = (spans[-1][0], b.time)
        else:
            spans.append((a.time, b.time))
    return tuple(spans)


def slow_flights(motion: Motion, *, speed: float = 0.5, ramp: float = 0.1) -> Warp:
    """Play every flight at `speed`, with a smooth change in the `ramp` seconds before and after it."""
    times = np.arange(motion.n_frames) / float(motion.rate)
    log_speed = np.zeros(motion.n_frames)
    for start, end in flight_spans(motion):
        inside = np.clip(np.minimum(times - (start - ramp), (end + ramp) - times) / ramp, 0.0, 1.0)
        log_speed = np.minimum(log_speed, math.log(speed) * inside * inside * (3 - 2 * inside))
    return from_log_speed(log_speed, motion)


def weaken(motion: Motion, joints: Sequence[str], *, share: float = 0.5) -> Warp:
    """Take the force out of blows, and keep the length: what is fast becomes slower, what is slow faster.

    The faster of the `joints`, going at v, is played at (v / median v) to the power of - `share`, between 0.45 and 2.2,
    all scaled to the length of the input.
    """
    smooth = _fastest(motion, joints)
    log_speed = -share * np.log(np.maximum(smooth, 1e-9) / np.median(smooth))
    warp = from_log_speed(np.clip(log_speed, math.log(0.45), math.log(2.2)), motion)
    return replace(warp, output_times=warp.output_times * (motion.end_time / warp.output_end))


def fast_spans(motion: Motion, joints: Sequence[str], *, share: float = 0.15) -> tuple[tuple[float, float], ...]:
    """Find blows: input times of the `share` of all frames in which the faster of some joints is fastest."""
    speed = _fastest(motion, joints)
    fast = np.concatenate([[0], (speed > np.quantile(speed, 1 - share)).astype(np.int8), [0]])
    edges = np.flatnonzero(np.diff(fast)).reshape(-1, 2) / float(motion.rate)
    return tuple((float(start), min(float(end), motion.end_time)) for start, end in edges)


def _fastest(motion: Motion, joints: Sequence[str]) -> FloatArray:
    """Speed of the fastest of some joints in each frame, smoothed over 0.3 s; units a frame."""
    places = [motion.skeleton.index(name) for name in joints]
    positions = global_poses(motion).positions[:, places]
    fastest = np.linalg.norm(np.gradient(positions, axis=0), axis=-1).max(axis=1)
    half = round(0.15 * float(motion.rate))
    window = np.hanning(2 * half + 3)[1:-1]
    return np.asarray(np.convolve(np.pad(fastest, half, mode="edge"), window / window.sum(), "valid"))


def from_log_speed(log_speed: FloatArray, motion: Motion) -> Warp:
    """Make the warp that plays each input frame at a speed; knots at the frames."""
    slowness = np.exp(-log_speed)
    output_times = np.concatenate([[0.0], np.cumsum((slowness[1:] + slowness[:-1]) / 2)]) / float(motion.rate)
    return Warp(output_times, np.arange(motion.n_frames) / float(motion.rate), method="hand")


def part_of(warp: Warp, start: float, end: float) -> Warp:
    """Cut out what a forward warp does with a stretch of its input; both times then count from its start."""
    inside = (warp.input_times > start) & (warp.input_times < end)
    back = warp.inverse()
    first, last = float(back(start)), float(back(end))
    return Warp(
        np.concatenate([[0.0], warp.output_times[inside] - first, [last - first]]),
        np.concatenate([[0.0], warp.input_times[inside] - start, [end - start]]),
        method=warp.method,
    )


@dataclass(frozen=True, eq=False)
class Answer:
    """An input, a reference, and the warp that is right.

    Attributes
    ----------
    name : str
        Of the case.
    kind : str
        "limp", "jump" or "boxing".
    motion : Motion
        The input.
    reference : Motion
        The stretch that was retimed by hand, retimed.
    truth : Warp
        The right warp of the whole input.
    spans : tuple of (float, float)
        Input times at which the truth has something to say: elsewhere it only says "leave it".
    free : bool
        Whether the length is for the search to find.
    example : (int, int), optional
        First and last frame of the retimed stretch, where it is one of the input's own.
    """

    name: str
    kind: str
    motion: Motion
    reference: Motion
    truth: Warp
    spans: tuple[tuple[float, float], ...]
    free: bool = True
    example: tuple[int, int] | None = None

    __repr__ = brief_repr


def example_of(motion: Motion, truth: Warp, start: float, end: float) -> Motion:
    """Retime the stretch of a motion from `start` to `end` (input times, seconds) as the truth does.

    Not averaged where fast: a reference is looked at, not shown.
    """
    rate = float(motion.rate)
    first, last = _frames_of(motion, start, end)
    stretch = replace(motion.frames(first, last + 1), first_frame=0, name=f"{motion.name}, by hand")
    return apply_warp(stretch, part_of(truth, first / rate, last / rate), average=False)


def _frames_of(motion: Motion, start: float, end: float) -> tuple[int, int]:
    return round(start * float(motion.rate)), round(end * float(motion.rate))


def _limp_cycle(motion: Motion) -> tuple[float, float]:
    """Find the first whole cycle of a walk that begins with the left foot in front."""
    halves = cycles(motion)
    for (a, b), (c, d) in itertools.pairwise(halves):
        if a.side == "left" and b.time == c.time:
            return a.time, d.time
    raise OptionError(f"{motion.name or 'the motion'} has no whole cycle of a walk")


def limp_answer(name: str, example: Motion, motion: Motion) -> Answer:
    """Give the limp of one cycle of `example` as the reference for `motion` (which may be the same)."""
    cycle = _limp_cycle(example)
    reference = example_of(example, limp(example), *cycle)
    own = _frames_of(motion, *cycle) if example is motion else None
    return Answer(name, "limp", motion, reference, limp(motion), walking_spans(motion), example=own)


def jump_answer(name: str, motion: Motion, start: float, end: float) -> Answer:
    """Give a stretch with one slowed flight as the reference for the whole clip."""
    truth = slow_flights(motion)
    spans = tuple((max(0.0, a - 0.3), min(motion.end_time, b + 0.3)) for a, b in flight_spans(motion))
    own = _frames_of(motion, start, end)
    return Answer(name, "jump", motion, example_of(motion, truth, start, end), truth, spans, example=own)


WRISTS = ("LeftWrist", "RightWrist")


def boxing_answer(name: str, strong: Motion, reference: Motion) -> Answer:
    """Weaken blows by hand; the truth gives them their force back."""
    hand = weaken(strong, WRISTS)
    weak = replace(apply_warp(strong, hand, average=False), name=f"{strong.name}, weakened")
    truth = Warp(hand.input_times, hand.output_times, method="hand")
    return Answer(name, "boxing", weak, reference, truth, ((0.0, weak.end_time),), free=False)


def _jump(clip: str, start: float, end: float) -> Callable[[Library], Answer]:
    return lambda clips: jump_answer(clip, clips[clip], start, end)


def _limp_across(example: str, clip: str) -> Callable[[Library], Answer]:
    return lambda clips: limp_answer(f"{example} on {clip}", clips[example], clips[clip])


def _sample_jump(clips: Library) -> Answer:
    motion = clips["sample"]
    first = flight_spans(motion)[0]
    return jump_answer("sample, jump", motion, first[0] - 0.8, first[1] + 0.8)


ANSWERS: dict[str, Callable[[Library], Answer]] = {
    "29_01": lambda clips: limp_answer("29_01", clips["29_01"], clips["29_01"]),
    "07_01": lambda clips: limp_answer("07_01", clips["07_01"], clips["07_01"]),
    "07_01 on 07_09": _limp_across("07_01", "07_09"),
    "07_01 on 07_10": _limp_across("07_01", "07_10"),
    "07_01 on 07_12": _limp_across("07_01", "07_12"),
    "sample, limp": lambda clips: limp_answer("sample, limp", clips["sample"], clips["sample"]),
    # From standing to standing, with the flight in the middle.
    "01_01": _jump("01_01", 0.9, 3.35),
    "49_02": _jump("49_02", 0.9, 2.05),
    "sample, jump": _sample_jump,
    "boxing": lambda clips: boxing_answer(
        "boxing", clips.stretch("boxing", 5.8, 10.3), clips.stretch("boxing", 0.0, 5.8)
    ),
}
"""Cases by name. The examples of jumps are stretches around one flight, in seconds."""
