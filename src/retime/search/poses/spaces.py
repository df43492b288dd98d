"""Pose, velocity and acceleration of analysis frames (§3.2).

Everything here is for looking at the motion; the output is never made from it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr, kind_of
from retime.checks import real
from retime.errors import OptionError
from retime.frames import frame_positions
from retime.limits import LEAST_WEIGHT, MOST_WEIGHT
from retime.motion.any_motion import AnyMotion
from retime.motion.joint_names import near_names
from retime.motion.kinematics import GlobalPoses, heading_positions, rises_along_y, torso_positions
from retime.motion.motion import Motion
from retime.motion.signal import Signal

# Seconds. Longer than any clip; with a longer one, its square would leave nothing of the pose but rounding.
_LONGEST_TIME_SCALE = 1000.0
# Frames that are posed, low-passed, and read between, at once.
_FRAMES = 256
_PASSED = 128
_READ = 256
# Frames to either side up to which a low-pass adds up rows; and columns that it works on at once where there are more.
_FEW_TAPS = 24
_COLUMNS = 8
PoseSpace = Literal["torso", "heading", "signal"]
POSE_SPACES = get_args(PoseSpace)


@dataclass(frozen=True)
class PoseOptions:
    """What of a motion makes its pose, and how much each part of it counts.

    Parameters
    ----------
    space : {"torso", "heading", "signal"}, optional
        ``torso``: positions of all joints but the root in the root's space (the paper's). ``heading``: positions of
        all joints with ground position and turn removed, height and tilt kept. ``signal``: the channels themselves.
        Left out: ``heading`` for a motion whose figure rises along Y (`retime.motion.kinematics.rises_along_y`),
        ``torso`` for any other, ``signal`` for a signal. docs/study tells why.
    joints : sequence of str, optional
        Joints (or channels) that count; of a repeated name every joint. Left out: all.
    weights : mapping of str to float
        For joints (or channels) a factor on their coordinates, 0 or more; 1 for those that are not named.
    scales : mapping of str to float
        For channels of a signal what to divide them by, above 0.
    scale_signals : bool
        Divide the channels that are not named in `scales` by their standard deviation over the reference, so that
        metres and degrees compare; the axes of a point (``NAME.x``, ``NAME.y``, ``NAME.z``) by one, and points of one
        unit (markers) by one for all. A channel that is constant there is left as it is.

    Raises
    ------
    OptionError
        No such space, no joint, or a factor that is out of its range.

    Examples
    --------
    >>> PoseOptions("heading", joints=["LeftFoot", "RightFoot"], weights={"LeftFoot": 2}).joints
    ('LeftFoot', 'RightFoot')
    """

    space: PoseSpace | None = None
    joints: Sequence[str] | None = None
    weights: Mapping[str, float] = field(default_factory=dict)
    scales: Mapping[str, float] = field(default_factory=dict)
    scale_signals: bool = True

    __repr__ = brief_repr

    def __post_init__(self) -> None:
        if self.space is not None and self.space not in POSE_SPACES:
            raise OptionError(f"features must be one of {', '.join(POSE_SPACES)}; found {self.space!r}")
        if self.joints is not None:
            joints = (self.joints,) if isinstance(self.joints, str) else tuple(self.joints)
            if not joints:
                raise OptionError("no joint is chosen: name one at least, or leave the choice out for all of them")
            object.__setattr__(self, "joints", joints)
        for what, numbers in (("weight", self.weights), ("scale", self.scales)):
            if not isinstance(numbers, Mapping):
                raise OptionError(f"{what}s are a mapping of names to numbers, found {kind_of(numbers)}")
            floats = {name: real(number, f"the {what} of {name!r}") for name, number in numbers.items()}
            for name, number in floats.items():
                if not (LEAST_WEIGHT <= number <= MOST_WEIGHT or (number == 0 and what == "weight")):
                    least = "0 or more" if what == "weight" else "above 0"
                    raise OptionError(
                        f"the {what} of {name!r} must be a finite number, {least}; found {number}"
                        + (f" ({LEAST_WEIGHT:g} to {MOST_WEIGHT:g} can be told apart)" if number > 0 else "")
                    )
            object.__setattr__(self, f"{what}s", floats)


def as_pose_options(options: PoseOptions | PoseSpace | None) -> PoseOptions:
    """Take the name of a pose space, or nothing, for options."""
    return options if isinstance(options, PoseOptions) else PoseOptions(options)


def pose_space(motion: AnyMotion, options: PoseOptions) -> str:
    """Say which pose space is meant; raise OptionError where it is not one for this kind of motion."""
    if isinstance(motion, Signal):
        if options.space not in (None, "signal"):
            raise OptionError(
                f"{motion.name or 'the signal'} has no skeleton: its features are 'signal', not {options.space!r}"
            )
        return "signal"
    where = motion.name or "the motion"
    if options.space == "signal":
        raise OptionError(f"{where} has a skeleton: its features are 'torso' or 'heading'")
    if options.scales:
        raise OptionError(
            f"{where} has a skeleton, and joints have weights, not scales: found one of {', '.join(options.scales)}"
        )
    return options.space or ("heading" if rises_along_y(motion) else "torso")


def space_joints(motion: Motion, space: str) -> list[int]:
    """List the joints that have coordinates in a pose space; raise OptionError where none has."""
    joints = list(range(1 if space == "torso" else 0, motion.skeleton.n_joints))
    if not joints:
        raise OptionError(f"{motion.name or 'the motion'} has one joint: torso features need more; use 'heading'")
    return joints


def chosen_places(names: Sequence[str], places: Sequence[int], options: PoseOptions, where: str) -> list[int]:
    """Choose joints or channels by `options`, in the order of `places`; check every name that the options mention.

    Raises
    ------
    OptionError
        A name is not among `names`, or its joint has no coordinates (the root, in torso space), or nothing counts.
    """
    there = {names[place] for place in places}
    for name in (*(options.joints or ()), *options.weights, *options.scales):
        if name in there:
            continue
        if name in names:
            raise OptionError(
                f"{name!r} has no coordinates of its own in torso space, whose origin it is; use 'heading'"
            )
        raise OptionError(f"{where or 'the motion'} has no {name!r}{near_names(name, names)}")
    chosen = [place for place in places if options.joints is None or names[place] in options.joints]
    if not any(options.weights.get(names[place], 1.0) for place in chosen):
        raise OptionError(f"every weight is 0: nothing of {where or 'the motion'} counts")
    return chosen


def joint_vectors(
    poses: GlobalPoses, names: Sequence[str], joints: Sequence[int], space: str, options: PoseOptions
) -> FloatArray:
    """Put some joints into a pose space, weight them by their names, and lay each frame out as one vector.

    Parameters
    ----------
    poses : GlobalPoses
        The root first; further rotations are not used.
    names : sequence of str
        Of all joints of `poses`.
    joints : sequence of int
        Those that count.
    space : {"torso", "heading"}
        The pose space; ``torso`` has no root.
    options : PoseOptions
        Whose weights are used.

    Returns
    -------
    float array, shape (n_frames, 3 * len(joints))
    """
    weights = None
    if any(names[joint] in options.weights for joint in joints):
        weights = np.array([options.weights.get(names[joint], 1.0) for joint in joints])[:, None]
    places = [joint - 1 for joint in joints] if space == "torso" else list(joints)
    vectors = np.empty((len(poses.positions), 3 * len(joints)))
    n_there = poses.positions.shape[1] - (space == "torso")
    every = places == list(range(n_there))
    # In pieces that stay in the cache: what comes between needs no memory beside a long take.
    for start in range(0, len(vectors), _FRAMES):
        frames = slice(start, start + _FRAMES)
        here = GlobalPoses(poses.positions[frames], poses.rotations[frames], poses.end_positions[frames])
        positions = torso_positions(here) if space == "torso" else heading_positions(here)
        if not every:
            positions = positions[:, places]
        if weights is not None:
            positions *= weights
        vectors[frames] = positions.reshape(len(positions), -1)
    return vectors


def low_pass(vectors: FloatArray, rate: Fraction, cutoff: float) -> FloatArray:
    """Remove fast detail from each column: uniform and zero-phase (§3.2, against temporal aliasing).

    The Gaussian of discrete time, with the width that halves the power at `cutoff`; ends are continued by point
    reflection, so they keep their slope.

    Parameters
    ----------
    vectors : float array, shape (n_frames, n_numbers)
        At `rate` frames a second.
    rate : Fraction
        Frames a second.
    cutoff : float
        Hz; 0, or anything from half the rate up, changes nothing.
    """
    if not (math.isfinite(cutoff) and cutoff >= 0):
        raise OptionError(f"the low-pass cutoff must be 0 (off) or more Hz, found {cutoff}", option="low_pass")
    if cutoff == 0 or cutoff >= float(rate) / 2 or len(vectors) < 2:
        return vectors
    # The discrete Gaussian passes exp(t (cos ω - 1)) of a wave at ω. Samples of the Gaussian itself would pass too much
    # where the cutoff comes near half the rate.
    # The floor keeps a cutoff near 0 finite: it averages everything.
    variance = math.log(2) / max(4 * math.sin(math.pi * cutoff / float(rate)) ** 2, 1e-8)
    reach = min(math.ceil(4 * math.sqrt(variance)) + 2, len(vectors) - 1)
    waves = np.cos(2 * np.pi * np.arange(4 * reach + 9) / (8 * reach + 16))
    half = np.fft.irfft(np.exp(variance * (waves - 1)))[: reach + 1]
    half /= half[0] + 2 * half[1:].sum()
    return _added_up(vectors, half) if reach <= _FEW_TAPS else _convolved(vectors, half)


def _added_up(vectors: FloatArray, half: FloatArray) -> FloatArray:
    """Add frames to both sides together, from the middle outward: the same bits on every machine."""
    reach = len(half) - 1
    ends = _beyond(vectors[: reach + 1]), _beyond(vectors[: -reach - 2 : -1])[::-1]
    out = np.empty_like(vectors)
    # Some frames at once, which stay in the cache with all that is added up for them.
    for start in range(0, len(vectors), _PASSED):
        stop = min(start + _PASSED, len(vectors))
        wide = vectors[max(0, start - reach) : stop + reach]
        if start < reach:
            wide = np.concatenate([ends[0][start:], wide])
        if stop + reach > len(vectors):
            wide = np.concatenate([wide, ends[1][: stop + reach - len(vectors)]])
        n, here = stop - start, out[start:stop]
        np.multiply(wide[reach : reach + n], half[0], out=here)
        for away in range(1, reach + 1):
            pair = wide[reach - away : reach - away + n] + wide[reach + away : reach + away + n]
            pair *= half[away]
            here += pair
    return out


def _beyond(rows: FloatArray) -> FloatArray:
    """Continue rows, an end first, beyond it: reflected in its point, the farthest first."""
    return np.asarray(2 * rows[0] - rows[:0:-1])


def _convolved(vectors: FloatArray, half: FloatArray) -> FloatArray:
    """Do the same, column by column: quicker where many frames are added up."""
    reach, taps = len(half) - 1, np.concatenate([half[:0:-1], half])
    out = np.empty_like(vectors)
    # A few columns at once: neighbours share the lines of memory that they are read from, and long takes have no room
    # for copies of all.
    for first in range(0, vectors.shape[1], _COLUMNS):
        some = slice(first, first + _COLUMNS)
        wide = np.pad(vectors[:, some].T, ((0, 0), (reach, reach)), mode="reflect", reflect_type="odd")
        out[:, some] = np.array([np.convolve(column, taps, mode="valid") for column in wide]).T
    return out


def sample(vectors: FloatArray, rate: Fraction, input_times: ArrayLike) -> FloatArray:
    """Read pose vectors between frames, by a cubic through the two frames to either side.

    A straight line would put corners, false accelerations, into an input that is upsampled (§3.1). At a frame the
    value is that frame's, bit for bit.

    Parameters
    ----------
    vectors : float array, shape (n_frames, n_numbers)
        At `rate` frames a second.
    input_times : float array, shape (n,)
        Seconds from the first frame; held at the ends outside.

    Returns
    -------
    float array, shape (n, n_numbers)
    """
    before, after, fraction = frame_positions(input_times, rate, len(vectors))
    out: FloatArray = vectors[before]
    between = np.flatnonzero(fraction)
    # Some at once, which stay in the cache: what comes between needs no memory beside a long take.
    for start in range(0, len(between), _READ):
        some = between[start : start + _READ]
        out[some] = _cubic(vectors, before[some], after[some], fraction[some][:, None])
    return out


def _cubic(vectors: FloatArray, b: IntArray, a: IntArray, t: FloatArray) -> FloatArray:
    last = len(vectors) - 1
    p1, p2 = vectors[b], vectors[a]
    # Beyond the ends the nearest piece goes straight on.
    p0 = np.where((b > 0)[:, None], vectors[np.maximum(b - 1, 0)], 2 * p1 - p2)
    p3 = np.where((a < last)[:, None], vectors[np.minimum(a + 1, last)], 2 * p2 - p1)
    m1, m2 = (p2 - p0) / 2, (p3 - p1) / 2
    return np.asarray(p1 + t * (m1 + t * (3 * (p2 - p1) - 2 * m1 - m2 + t * (m1 + m2 - 2 * (p2 - p1)))))


@dataclass(frozen=True, eq=False)
class Track:
    """Pose vectors of one clip at its own rate.

    Attributes
    ----------
    vectors : float array, shape (n_frames, n_numbers)
        One pose a frame.
    rate : Fraction
        Frames a second.
    missing : bool array, shape (n_frames,), optional
        Frames of which something was lost; their vectors are bridged.
    """

    vectors: FloatArray
    rate: Fraction
    missing: BoolArray | None = None
    # The vectors low-passed at the last cutoff: a clip is read many times while its keytimes are dragged. And what was
    # last read of them from end to end, which several stages ask for.
    _passed: dict[float, FloatArray] = field(default_factory=dict, init=False, repr=False)
    _whole: dict[tuple[int, float, float], FloatArray] = field(default_factory=dict, init=False, repr=False)

    __repr__ = brief_repr

    @property
    def end_time(self) -> float:
        """Time of the last frame, seconds."""
        return float((len(self.vectors) - 1) / self.rate)

    def at(self, times: ArrayLike, cutoff: float) -> FloatArray:
        """Low-pass at `cutoff` Hz (0 is off) and read at `times` (seconds); shape (n, n_numbers)."""
        passed = self._passed.get(cutoff)
        if passed is None:
            passed = low_pass(self.vectors, self.rate, cutoff)
            self._passed.clear()
            self._passed[cutoff] = passed
        return sample(passed, self.rate, times)

    def at_rate(self, n_frames: int, rate: float, cutoff: float) -> FloatArray:
        """Read so many frames at `rate` Hz, from the first one on; shape (n_frames, n_numbers), read-only."""
        known = self._whole.get(key := (n_frames, rate, cutoff))
        if known is None:
            known = self.at(np.arange(n_frames) / rate, cutoff)
            known.setflags(write=False)
            self._whole.clear()
            self._whole[key] = known
        return known

    def missing_at(self, times: ArrayLike) -> BoolArray:
        """Tell at which times (n,), seconds, something is lost: on a frame of a gap, or beside one."""
        before, after, fraction = frame_positions(times, self.rate, len(self.vectors))
        if self.missing is None:
            return np.zeros(len(before), dtype=bool)
        return np.asarray(self.missing[before] | (self.missing[after] & (fraction > 0)))


def timing_features(poses: FloatArray, *, rate: float, time_scale: float) -> FloatArray:
    """Features of consecutive frames: pose, scaled velocity, scaled acceleration (§3.2).

    ``[y, τ (y₊ - y₋) / 2Δ, τ² (y₊ - 2y + y₋) / Δ²]`` with Δ = 1 / `rate` and τ = `time_scale`.

    Parameters
    ----------
    poses : float array, shape (n_frames, n_numbers)
        Pose vectors of a reference, one analysis period apart; at least three.
    rate : float
        Analysis rate, Hz.
    time_scale : float
        τ, seconds: how much velocity and acceleration weigh against pose. τ = Δ is the paper read literally.

    Returns
    -------
    float array, shape (n_frames - 2, 3 * n_numbers)
        All three blocks in pose units.
    """
    velocity, acceleration = difference_scales(rate, time_scale)
    before, here, after = poses[:-2], poses[1:-1], poses[2:]
    n_numbers = poses.shape[1]
    features = np.empty((len(here), 3 * n_numbers))
    pose, first, second = (features[:, part * n_numbers : (part + 1) * n_numbers] for part in range(3))
    # In place: new memory costs more than the arithmetic.
    np.subtract(after, here, out=second)
    np.subtract(here, before, out=pose)
    second -= pose
    second *= acceleration
    np.subtract(after, before, out=first)
    first *= velocity
    pose[...] = here
    return features


def difference_scales(rate: float, time_scale: float) -> tuple[float, float]:
    """Return what to multiply first and second differences by: τ / 2Δ and τ² / Δ²."""
    if not 0 <= time_scale <= _LONGEST_TIME_SCALE:
        raise OptionError(
            f"the time scale must be from 0 to {_LONGEST_TIME_SCALE:g} seconds, found {time_scale:g}: it is about as "
            "long as a movement, such as 0.1",
            option="time_scale",
        )
    return time_scale * rate / 2, (time_scale * rate) ** 2
