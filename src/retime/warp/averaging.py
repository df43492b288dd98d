"""Averaging where a warp speeds up (§3.4): over windows of the input, standing feet exempt."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr
from retime.kernels import AveragedTurns, backend
from retime.kernels.windows import window_weights
from retime.motion.any_motion import AnyMotion
from retime.motion.blending import one_side, unit_length, within_turn
from retime.motion.body import above_body
from retime.motion.channels import FULL_TURN, quaternion_groups
from retime.motion.contacts import Contacts
from retime.motion.gaps import bridged
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.curve import Warp

# Half-widths (in frames) up to this count as 0: they are what rounding leaves of a warp's times.
CLOSED = 1e-6


# Windows of more frames are summed one by one.
_LONG = 16
# Of neighbouring quaternions that go all the way round and cancel, the mean is shorter than this, and no rotation.
_SHORTEST = 0.1


def window_frames(warp: Warp, rate: float, output_times: FloatArray, *, loop: bool = False) -> FloatArray:
    """Return how many input frames each output frame averages: its speed where above 1 (§3.4), else 1.

    The speed is the mean over the output frame's own period; what of that lies beyond the ends is left out, or is taken
    from the other end of a loop.
    """
    period = 1.0 / rate
    before, after = output_times - period / 2, output_times + period / 2
    if loop:
        again, gain = warp.output_span, warp.input_times[-1] - warp.input_times[0]
        early, late = before < warp.output_start, after > warp.output_end
        travel = warp(np.where(late, after - again, after)) - warp(np.where(early, before + again, before))
        travel += gain * (early.astype(float) + late)
    else:
        before, after = np.maximum(before, warp.output_start), np.minimum(after, warp.output_end)
        travel = warp(after) - warp(before)
    with np.errstate(invalid="ignore", divide="ignore"):
        speed = np.abs(travel) / (after - before)
    return np.asarray(np.maximum(np.nan_to_num(speed, nan=1.0), 1.0))


@dataclass(frozen=True, eq=False)
class Windows:
    """Where each output frame averages the input, in frames of the input.

    Attributes
    ----------
    centre : float array, shape (n_output,)
        The middles of the windows.
    closing, wrapped : float array, shape (n_output,)
        Their half-widths where they close at the clip's ends, and where they go on across a loop's seam.
    beyond : int
        Frames beyond the seam that they may reach; 0 where the clip is no loop.
    roots : tuple of int
        The joints that carry all of the body, and may have gone on since the first frame.
    """

    centre: FloatArray
    closing: FloatArray
    wrapped: FloatArray
    beyond: int
    roots: tuple[int, ...]

    __repr__ = brief_repr

    @property
    def any_open(self) -> bool:
        """Whether anything is averaged at all."""
        return bool(np.any(self.wrapped > CLOSED))

    def continued(self, values: FloatArray, gain: FloatArray | float = 0.0) -> FloatArray:
        """Continue frames beyond a loop's seam; from one round to the next they gain `gain`."""
        if not self.beyond:
            return values
        last = len(values) - 1
        before, after = values[last - self.beyond : last] - gain, values[1 : self.beyond + 1] + gain
        return np.concatenate([before, values, after])

    def until_rest(self, at_rest: BoolArray) -> FloatArray:
        """Count the frames from each middle to the nearest contact: 0 within one, infinite where there is none."""
        at_rest = self.continued(at_rest.astype(np.float64)) > 0.5
        frames = np.arange(len(at_rest))
        earlier = np.maximum.accumulate(np.where(at_rest, frames, -np.inf))
        later = np.minimum.accumulate(np.where(at_rest, frames, np.inf)[::-1])[::-1]
        place = self.centre + self.beyond
        before, after = np.floor(place).astype(np.intp), np.ceil(place).astype(np.intp)
        away = np.minimum(place - earlier[before], later[after] - place)
        return np.where(at_rest[before] & at_rest[after], 0.0, away)

    def of(self, joints: IntArray, half: FloatArray) -> list[tuple[IntArray, FloatArray]]:
        """Part joints by their half-widths: of a loop, those that carry the body close at the ends."""
        carry = np.isin(joints, self.roots)
        if not (self.beyond and carry.any()):
            return [(joints, half)]
        return [(joints[carry], np.minimum(half, self.closing)), (joints[~carry], half)]

    def means(self, values: FloatArray, half: FloatArray) -> tuple[IntArray, FloatArray]:
        """Find the output frames whose windows are open, and the means of continued values over these."""
        fast = np.flatnonzero(half > CLOSED)
        middle = self.centre[fast] + self.beyond
        return fast, _window_means(values, middle - half[fast], middle + half[fast])


def windows_of(
    motion: AnyMotion, warp: Warp, output_times: FloatArray, input_times: FloatArray, *, loop: bool
) -> Windows:
    """Size the windows of all output frames by the warp's speed."""
    rate, last = float(motion.rate), motion.n_frames - 1
    half = (window_frames(warp, rate, output_times, loop=loop) - 1.0) / 2
    centre = np.clip(input_times * rate, 0, last)
    closing = np.minimum(half, np.minimum(centre, last - centre))
    # A window wider than the whole cycle would count some of it more often than the rest.
    wrapped = np.minimum(half, last / 2) if loop else closing
    beyond = min(last, int(np.ceil(wrapped.max()))) if loop else 0
    return Windows(centre, closing, wrapped, beyond, tuple(above_body(motion)) if isinstance(motion, Motion) else ())


@dataclass(frozen=True, eq=False)
class JointGroup:
    """Joints that carry the same feet, and so have the same windows.

    Attributes
    ----------
    joints : int array
        Increasing.
    chain : int array
        These and all joints above them, increasing.
    half : float array, shape (n_output,)
        Half-widths of their windows.
    """

    joints: IntArray
    chain: IntArray
    half: FloatArray

    __repr__ = brief_repr


def joint_groups(motion: Motion, windows: Windows, contacts: Contacts | None) -> list[JointGroup]:
    """Group joints by the feet that they carry; a joint's parent may be in a later group."""
    parents = motion.skeleton.parents
    carried: list[set[int]] = [set() for _ in parents]
    for foot, point in enumerate(() if contacts is None else contacts.feet):
        joint = point.joint
        while joint >= 0:
            carried[joint].add(foot)
            joint = parents[joint]
    members = defaultdict(list)
    for joint, feet in enumerate(carried):
        members[frozenset(feet)].append(joint)
    away = [] if contacts is None else [windows.until_rest(column) for column in contacts.at_rest.T]
    groups = []
    for standing, joints in members.items():
        chain: set[int] = set()
        for joint in joints:
            while joint >= 0 and joint not in chain:
                chain.add(joint)
                joint = parents[joint]
        half = windows.wrapped
        for foot in standing:
            # One frame of width for each frame of distance, and no more: so neither end moves against time. Opening
            # more slowly made nothing smoother.
            half = np.minimum(half, away[foot])
        groups.append(JointGroup(np.array(joints, np.intp), np.array(sorted(chain), np.intp), half))
    return groups


def average_columns(
    sampled: FloatArray, values: FloatArray, columns: IntArray, windows: Windows, half: FloatArray
) -> None:
    """Put the means of columns of numbers (n_frames, n_columns, ...) where windows are open."""
    if not len(columns):
        return
    values = values[:, columns]
    gain = values[-1] - values[0]
    # About the first frame, so that what is constant stays so to the last bit.
    origin = values[0]
    fast, means = windows.means(windows.continued(values - origin, gain), half)
    sampled[fast[:, None], columns] = origin + means


def average_channels(sampled: FloatArray, signal: Signal, windows: Windows) -> FloatArray:
    """Put the means of a signal's channels where windows are open, as their kinds allow.

    Angles are averaged the short way round, rotations as rotations; labels, events and clocks have no mean. Beside a
    gap the window closes, as it does at the ends: no mean holds a number that was never there, and a gap grows no
    wider. What is missing of the sampled values stays so.

    Parameters
    ----------
    sampled : float array, shape (n_output, n_channels)
        The signal at the output's frames.
    signal : Signal
        What it was sampled from.
    windows : Windows
        Where each output frame averages.
    """
    shown = sampled.copy()
    holes, kinds = signal.holes, signal.kinds
    # What is bridged is only there to be summed up around: no window reaches it.
    values = bridged(signal.values, signal.names, kinds) if holes.any() else signal.values
    linear = [place for place, kind in enumerate(kinds) if kind.kind == "linear"]
    for columns, half in _beside_gaps(holes, [(place,) for place in linear], windows):
        average_columns(shown, values, columns, windows, half)
    for place, kind in enumerate(kinds):
        if kind.kind == "angle":
            turn = FULL_TURN[kind.unit]
            ((columns, half),) = _beside_gaps(holes, [(place,)], windows)
            on_and_on, mean = np.unwrap(values[:, place], period=turn)[:, None], sampled[:, columns]
            average_columns(mean, on_and_on, np.array([0]), windows, half)
            averaged = half > CLOSED
            shown[averaged, place] = within_turn(mean[averaged, 0], values[:, place], turn)
    for four in quaternion_groups(signal.names, kinds):
        ((columns, half),) = _beside_gaps(holes, [four], windows)
        rotations = windows.continued(values[:, columns])
        fast, means = windows.means(one_side(unit_length(rotations)), half)
        # Where they go all the way round and cancel there is no mean: those keep the sampled rotation.
        near = np.flatnonzero(np.einsum("fc,fc->f", means, means) >= _SHORTEST**2)
        turned = shown[:, columns]
        turned[fast[near]] = unit_length(means[near])
        shown[:, columns] = one_side(turned)
    return np.where(np.isnan(sampled), np.nan, shown)


def _beside_gaps(
    holes: BoolArray, groups: Sequence[tuple[int, ...]], windows: Windows
) -> list[tuple[IntArray, FloatArray]]:
    """Part groups of columns by where they have gaps; each part with the half-widths that reach into none."""
    parts: dict[bytes, list[int]] = {}
    for group in groups:
        missing = holes[:, group].any(axis=1)
        parts.setdefault(missing.tobytes() if missing.any() else b"", []).extend(group)
    found = []
    for key, columns in parts.items():
        half = windows.wrapped
        if key:
            away = windows.until_rest(np.frombuffer(key, dtype=np.bool_))
            half = np.minimum(half, np.maximum(away - 1.0, 0.0))
        found.append((np.array(columns, dtype=np.intp), half))
    return found


def average_rotations(rotations: FloatArray, motion: Motion, windows: Windows, groups: list[JointGroup]) -> None:
    """Turn each joint, in space, as the pose averaged over its window would have it; sampled rotations change."""
    n_joints = motion.skeleton.n_joints
    turned_by = np.zeros(n_joints, dtype=np.int64)
    widths = np.full((len(groups), n_joints), -1, dtype=np.int64)
    halves: list[FloatArray] = []
    own = []
    for place, group in enumerate(groups):
        turned_by[group.joints] = place
        widths[place, group.chain] = len(halves)
        own.append(len(halves))
        halves.append(group.half)
        for joints, half in windows.of(group.chain, group.half):
            if half is not group.half:
                widths[place, joints] = len(halves)
                halves.append(half)
    turns = AveragedTurns(
        np.array(motion.skeleton.parents, dtype=np.int64),
        turned_by,
        widths,
        np.array(own, dtype=np.int64),
        np.array(halves),
        windows.centre + windows.beyond,
        CLOSED,
        _SHORTEST,
    )
    backend(warn=False).average_turns(turns, np.ascontiguousarray(windows.continued(motion.rotations)), rotations)


def _window_means(values: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Mean of the polyline through `values` (n_frames, ...) over each window [low, high], in frames."""
    flat = values.reshape(len(values), -1)
    means = np.empty((len(low), flat.shape[1]))
    first = np.minimum(low.astype(np.intp), len(flat) - 1)
    # Frames that a window weighs: to both sides of its ends, and between.
    counts = np.minimum(np.ceil(high).astype(np.intp), len(flat) - 1) - first + 1
    long = np.flatnonzero(counts > _LONG)
    for window in long:
        frames = np.arange(first[window], first[window] + counts[window])
        means[window] = window_weights(frames, low[window], high[window]) @ flat[frames[0] : frames[-1] + 1]
    # The others step by step, all at once, the longest first. Sums stay local, so long clips lose no digits.
    order = np.argsort(-counts, kind="stable")[len(long) :]
    first, low, high, counts = first[order], low[order], high[order], counts[order]
    total = np.zeros((len(order), flat.shape[1]))
    for step in range(int(counts[0]) if len(counts) else 0):
        n = int(np.searchsorted(-counts, -step, side="left"))
        frames = first[:n] + step
        term = flat[frames]
        term *= window_weights(frames, low[:n], high[:n])[:, None]
        total[:n] += term
    means[order] = total
    return means.reshape(len(means), *values.shape[1:])
