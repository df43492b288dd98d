"""Resample a motion by a warp, and average where it was sped up (§3.4)."""

from __future__ import annotations

import warnings
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Literal, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike

from retime.brief import kind_of
from retime.errors import OptionError, RetimeWarning
from retime.kernels import FloatArray, IntArray
from retime.motion import rotation
from retime.motion.contacts import BoolArray, Contacts, Slip, slip, slip_of
from retime.motion.contacts import contacts as find_contacts
from retime.motion.motion import Motion
from retime.motion.rate import RateLike
from retime.motion.signal import Signal, signal_of
from retime.warp.curve import Warp, WarpLike, as_warp, output_frame_times

AnyMotion = TypeVar("AnyMotion", Motion, Signal)

# Half-widths (in frames) up to this are none: a warp's times are rounded.
_CLOSED = 1e-6
# Windows of more frames are summed one by one.
_LONG = 16


@overload
def apply_warp(
    motion: AnyMotion,
    warp: WarpLike,
    *,
    average: bool = True,
    contacts: Contacts | Literal["find"] | None = "find",
    keep_root_path: bool = True,
    loop: bool = False,
) -> AnyMotion: ...


@overload
def apply_warp(
    motion: ArrayLike, warp: WarpLike, *, average: bool = True, loop: bool = False, rate: RateLike
) -> FloatArray: ...


def apply_warp(
    motion: Motion | Signal | ArrayLike,
    warp: WarpLike,
    *,
    average: bool = True,
    contacts: Contacts | Literal["find"] | None = "find",
    keep_root_path: bool = True,
    loop: bool = False,
    rate: RateLike | None = None,
) -> Motion | Signal | FloatArray:
    """Show a motion with a warp's timing, at the motion's own rate (§3.4).

    Rotations are slerped, everything else is interpolated linearly. Where the warp plays faster than life by c,
    each output frame is the mean of the input over a window of c frames, so that sway does not become jitter; where
    it does not, poses come straight from the input. The window closes at the ends, whose poses are kept.

    Two things are not averaged unless asked for. While a foot stands, the joints from the root to that foot come
    straight from the input, so that averaging makes no foot slide; toward a contact their window closes, after it it
    opens again, and the other joints go on being averaged. And the root's place is always one that it has in the
    input. The paper averages everything: ``contacts=None, keep_root_path=False``.

    Parameters
    ----------
    motion : Motion, Signal, or array of shape (n_frames, ...)
        The clip that the warp was found for, its full-rate original, another character, a camera; or plain numbers.
    warp : Warp or GuidedWarp
        From output time to input time.
    average : bool
        Average where sped up.
    contacts : Contacts, "find" or None
        When the input's feet stand, frame by frame; "find" looks (`retime.motion.contacts.contacts`). None averages
        feet like everything else. Signals have no feet.
    keep_root_path : bool
        Don't average the root's translation: the output's root goes where the input's went, however fast. Below a root
        that never moves, and has one child, that child is meant.
    loop : bool
        The clip is a cycle, its last frame the first one again, and the warp plays all of it. The averaging window
        then goes on across the seam instead of closing at the ends, so that the seam has no corner. This holds for all
        joints but the root, which may have walked on and turned since the first frame: its window closes as ever. A
        signal goes on from its last value as it did from its first.
    rate : number or str, optional
        Frames a second of an array, which needs it; a clip has its own.

    Returns
    -------
    Motion, Signal or float array, as `motion` is
        Same rate, names and channels; ``warp.count_frames(rate)`` frames.

    Raises
    ------
    OptionError
        The contacts are of another number of frames, or something else was passed than is expected.

    Warns
    -----
    RetimeWarning
        The warp and the motion don't cover the same input times, or a loop's last pose is not its first.

    Examples
    --------
    >>> from fractions import Fraction
    >>> ramp = Signal(("x",), np.arange(5.0)[:, None], Fraction(1))
    >>> apply_warp(ramp, Warp([0.0, 2.0], [0.0, 4.0]), average=False).values[:, 0].tolist()
    [0.0, 2.0, 4.0]
    >>> apply_warp([0.0, 1.0, 2.0, 3.0, 4.0], Warp([0.0, 2.0], [0.0, 4.0]), rate=1, average=False).tolist()
    [0.0, 2.0, 4.0]
    """
    if isinstance(motion, Warp) or isinstance(getattr(motion, "warp", None), Warp):
        raise OptionError("the clip comes first: apply_warp(motion, warp)")
    warp = as_warp(warp, "apply_warp(motion, warp)")
    if not (contacts is None or isinstance(contacts, Contacts) or (isinstance(contacts, str) and contacts == "find")):
        raise OptionError(f"contacts must be Contacts, 'find' or None; found {kind_of(contacts)}")
    if isinstance(motion, Motion):
        if rate is not None:
            raise OptionError("a motion has its own rate; rate= is for arrays")
        _compare_ranges(motion, warp)
        if isinstance(contacts, Contacts):
            contacts.refuse_other(motion)
        if loop:
            _check_seam(motion)
        return _apply(motion, warp, average, contacts, keep_root_path, loop)
    if isinstance(motion, Signal):
        if rate is not None:
            raise OptionError("a signal has its own rate; rate= is for arrays")
        _compare_ranges(motion, warp)
        return _apply(motion, warp, average, contacts, keep_root_path, loop)
    signal = signal_of(motion, rate, call="apply_warp(array, warp, rate=30)")
    _compare_ranges(signal, warp)
    shown = _apply(signal, warp, average, contacts, keep_root_path, loop).values
    return shown.reshape(len(shown), *np.shape(motion)[1:])


def _apply(
    motion: AnyMotion,
    warp: Warp,
    average: bool,
    contacts: Contacts | Literal["find"] | None,
    keep_root_path: bool,
    loop: bool,
) -> AnyMotion:
    """Do what `apply_warp` says, without its warnings."""
    output_times = output_frame_times(warp, float(motion.rate))
    input_times = warp(output_times)
    result = motion.at(input_times)
    windows = _windows(motion, warp, output_times, input_times, loop=loop) if average else None
    if windows is None or not windows.any_open:
        return replace(result, first_frame=motion.first_frame)
    if isinstance(result, Signal):
        assert isinstance(motion, Signal)
        values = result.values.copy()
        _average(values, motion.values, np.arange(values.shape[1]), windows, windows.wrapped)
        return replace(result, values=values, first_frame=motion.first_frame)
    assert isinstance(motion, Motion)
    groups = _joint_groups(motion, windows, find_contacts(motion) if contacts == "find" else contacts)
    translations = result.local_translations.copy()
    # Joints that stay where they are in their parents, as most do, have nothing to average.
    moving = np.any(motion.local_translations != motion.local_translations[0], axis=(0, 2))
    moving[: windows.n_roots] &= not keep_root_path
    for group in groups:
        for joints, half in windows.of(group.joints, group.half):
            _average(translations, motion.local_translations, joints[moving[joints]], windows, half)
    return replace(
        result,
        rotations=_average_rotations(result.rotations, motion, windows, groups),
        translations=translations,
        first_frame=motion.first_frame,
    )


def _compare_ranges(motion: Motion | Signal, warp: Warp) -> None:
    """Warn where the warp and the motion don't cover the same input times, half a frame aside."""
    problem = warp.range_problem(motion.end_time, float(motion.rate), motion.name or "the motion")
    if problem:
        warnings.warn(problem, RetimeWarning, stacklevel=3)


def _check_seam(motion: Motion) -> None:
    """Warn where a loop's last pose is no repetition of its first: where a joint has to turn to get there."""
    n_roots = _n_roots(motion)
    q = motion.rotations[:, n_roots:]
    if motion.n_frames < 2 or not q.size:
        return
    steps, seam = _turns(q[1:], q[:-1]).max(axis=1), _turns(q[-1], q[0])
    joint = int(np.argmax(seam))
    # A clip that ends one frame before its first has a seam of one step. A thousandth of a radian can't be seen.
    if seam[joint] > max(float(np.median(steps)) / 2, 1e-3):
        warnings.warn(
            f"the last pose of {motion.name or 'the motion'} is not its first one again, as a loop's should be: "
            f"{motion.skeleton.names[n_roots + joint]!r} is {np.degrees(seam[joint]):.1f} degrees away",
            RetimeWarning,
            stacklevel=3,
        )


def _n_roots(motion: Motion) -> int:
    """Count the joints that carry all of the body, first in any order: the root, and the child of one that is still.

    Some programs put a node that never moves above the hips.
    """
    parents, q, p = motion.skeleton.parents, motion.rotations, motion.local_translations
    n = 1
    while n < len(parents) and parents.count(n - 1) == 1:
        if np.any(q[:, n - 1] != q[0, n - 1]) or np.any(p[:, n - 1] != p[0, n - 1]):
            break
        n += 1
    return n


def _turns(a: FloatArray, b: FloatArray) -> FloatArray:
    """Angles between rotations (..., 4), radians."""
    return np.asarray(2 * np.arccos(np.minimum(np.abs(np.einsum("...c,...c->...", a, b)), 1.0)))


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
class _Windows:
    """Where each output frame averages the input, in frames of the input.

    Attributes
    ----------
    centre : float array, shape (n_output,)
        The middles of the windows.
    closing, wrapped : float array, shape (n_output,)
        Their half-widths where they close at the clip's ends, and where they go on across a loop's seam.
    beyond : int
        Frames beyond the seam that they may reach; 0 where the clip is no loop.
    n_roots : int
        How many of the first joints carry all of the body, and may have gone on since the first frame.
    """

    centre: FloatArray
    closing: FloatArray
    wrapped: FloatArray
    beyond: int
    n_roots: int

    @property
    def any_open(self) -> bool:
        """Whether anything is averaged at all."""
        return bool(np.any(self.wrapped > _CLOSED))

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
        """Part increasing joints by their half-widths: a loop's root closes at the ends."""
        n = int(np.searchsorted(joints, self.n_roots)) if self.beyond else 0
        return [(joints[:n], np.minimum(half, self.closing)), (joints[n:], half)] if n else [(joints, half)]

    def means(self, values: FloatArray, half: FloatArray) -> tuple[IntArray, FloatArray]:
        """Find the output frames whose windows are open, and the means of continued values over these."""
        fast = np.flatnonzero(half > _CLOSED)
        middle = self.centre[fast] + self.beyond
        return fast, _window_means(values, middle - half[fast], middle + half[fast])


def _windows(
    motion: Motion | Signal, warp: Warp, output_times: FloatArray, input_times: FloatArray, *, loop: bool
) -> _Windows:
    """Size the windows of all output frames by the warp's speed."""
    rate, last = float(motion.rate), motion.n_frames - 1
    half = (window_frames(warp, rate, output_times, loop=loop) - 1.0) / 2
    centre = np.clip(input_times * rate, 0, last)
    closing = np.minimum(half, np.minimum(centre, last - centre))
    # A window wider than the whole cycle would count some of it more often than the rest.
    wrapped = np.minimum(half, last / 2) if loop else closing
    beyond = min(last, int(np.ceil(wrapped.max()))) if loop else 0
    return _Windows(centre, closing, wrapped, beyond, _n_roots(motion) if isinstance(motion, Motion) else 0)


@dataclass(frozen=True, eq=False)
class _JointGroup:
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


def _joint_groups(motion: Motion, windows: _Windows, contacts: Contacts | None) -> list[_JointGroup]:
    """Group joints by the feet that they carry; the groups are in no order that the tree knows of."""
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
        groups.append(_JointGroup(np.array(joints, np.intp), np.array(sorted(chain), np.intp), half))
    return groups


def _average(sampled: FloatArray, values: FloatArray, columns: IntArray, windows: _Windows, half: FloatArray) -> None:
    """Put the means of columns of numbers (n_frames, n_columns, ...) where windows are open."""
    if not len(columns):
        return
    values = values[:, columns]
    gain = values[-1] - values[0]
    # About the first frame, so that what is constant stays so to the last bit.
    origin = values[0]
    fast, means = windows.means(windows.continued(values - origin, gain), half)
    sampled[fast[:, None], columns] = origin + means


def _average_rotations(sampled: FloatArray, motion: Motion, windows: _Windows, groups: list[_JointGroup]) -> FloatArray:
    """Turn each joint, in space, as the pose averaged over its window would have it."""
    parents = motion.skeleton.parents
    poses = [
        dict(zip(group.chain.tolist(), _average_pose(sampled, motion, windows, group), strict=True)) for group in groups
    ]
    # Whose windows a joint has, for all joints first: its parent may be in any other group.
    turned_by = {joint: pose for group, pose in zip(groups, poses, strict=True) for joint in group.joints.tolist()}
    rotations = sampled.copy()
    for group, pose in zip(groups, poses, strict=True):
        fast = np.flatnonzero(group.half > _CLOSED)
        for joint in group.joints.tolist():
            own, parent = pose[joint][fast], parents[joint]
            if parent >= 0 and turned_by[parent] is not pose:
                # The parent carries a foot that this joint doesn't, and may be averaged over less.
                there, here = (_turn_in_space(each, parents, parent, fast) for each in (turned_by[parent], pose))
                own = rotation.multiply(rotation.multiply(rotation.conjugate(there), here), own)
            rotations[fast, joint] = own
    return rotations


def _turn_in_space(pose: Mapping[int, FloatArray], parents: Sequence[int], joint: int, frames: IntArray) -> FloatArray:
    """Global rotation of a joint in some frames of a pose."""
    turn = pose[joint][frames]
    while parents[joint] >= 0:
        joint = parents[joint]
        turn = rotation.multiply(pose[joint][frames], turn)
    return turn


def _average_pose(sampled: FloatArray, motion: Motion, windows: _Windows, group: _JointGroup) -> list[FloatArray]:
    """Local rotations of a group's chain, each (n_output, 4), averaged over the group's windows."""
    pose = []
    for joints, half in windows.of(group.chain, group.half):
        result = sampled[:, joints]
        # The mean of neighbouring quaternions, all on one side and scaled to unit length, is their mean rotation.
        # Where they go all the way round, and cancel, there is none: those joints keep the sampled rotation.
        fast, means = windows.means(_one_side(windows.continued(motion.rotations[:, joints])), half)
        apart = np.einsum("fjc,fjc->fj", means, means) < 0.1**2
        if apart.any():
            means[apart] = result[fast][apart]
        result[fast] = rotation.normalize(means)
        pose += [result[:, column] for column in range(len(joints))]
    return pose


def _one_side(rotations: FloatArray) -> FloatArray:
    """Flip quaternions (n_frames, n_joints, 4) so that each lies on its predecessor's side."""
    turns = np.einsum("fjc,fjc->fj", rotations[1:], rotations[:-1]) < 0
    if not turns.any():
        return rotations
    flips = np.cumsum(turns, axis=0) % 2 == 1
    sides = np.ones((*rotations.shape[:2], 1))
    sides[1:][flips] = -1.0
    return rotations * sides


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
        means[window] = _weights(frames, low[window], high[window]) @ flat[frames[0] : frames[-1] + 1]
    # The others step by step, all at once, the longest first. Sums stay local, so long clips lose no digits.
    order = np.argsort(-counts, kind="stable")[len(long) :]
    first, low, high, counts = first[order], low[order], high[order], counts[order]
    total = np.zeros((len(order), flat.shape[1]))
    for step in range(int(counts[0]) if len(counts) else 0):
        n = int(np.searchsorted(-counts, -step, side="left"))
        frames = first[:n] + step
        term = flat[frames]
        term *= _weights(frames, low[:n], high[:n])[:, None]
        total[:n] += term
    means[order] = total
    return means.reshape(len(means), *values.shape[1:])


def _weights(frames: IntArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Weight of frames in the means over windows: the areas, inside the window, of the hats that stand on them."""
    a, b = np.clip(low - frames, -1.0, 1.0), np.clip(high - frames, -1.0, 1.0)
    # From a to b: 1 + x where x < 0, 1 - x where x > 0. Each side is a width times its middle's height.
    left, right = np.minimum(b, 0.0) - np.minimum(a, 0.0), np.maximum(b, 0.0) - np.maximum(a, 0.0)
    area = left * (1.0 + (np.minimum(a, 0.0) + np.minimum(b, 0.0)) / 2)
    area += right * (1.0 - (np.maximum(a, 0.0) + np.maximum(b, 0.0)) / 2)
    return np.asarray(area / (high - low))


@dataclass(frozen=True, eq=False)
class SlipReport:
    """How far feet slide while they stand, before and after a warp.

    Attributes
    ----------
    input : Slip
        Of the input itself.
    unaveraged, plain, contact_aware : Slip
        Of the output, in the same contacts as far as output frames fall into them: without averaging, with everything
        averaged as in the paper, and with standing feet exempted.
    """

    input: Slip
    unaveraged: Slip
    plain: Slip
    contact_aware: Slip

    def __repr__(self) -> str:
        means = ", ".join(f"{name} {each.mean:.1f}" for name, each in self._measured())
        guessed = ", the figure's size guessed" * self.input.size_guessed
        return f"SlipReport({len(self.input.contacts)} contacts, mean slip in mm{guessed}: {means})"

    def _repr_html_(self) -> str:
        from retime.warp.report_picture import slip_html

        return slip_html(self)

    def _measured(self) -> list[tuple[str, Slip]]:
        return [(field.name, getattr(self, field.name)) for field in fields(self)]


def retimed_slip(motion: Motion, warp: WarpLike, *, contacts: Contacts | None = None, loop: bool = False) -> SlipReport:
    """Measure what a warp, and averaging, do to standing feet.

    Parameters
    ----------
    motion : Motion
        The input.
    warp : Warp or GuidedWarp
        From output time to input time.
    contacts : Contacts, optional
        When the input's feet stand; left out, they are found. An output frame is in a contact if the input is, at
        the time that it shows.
    loop : bool
        As in `apply_warp`.

    Returns
    -------
    SlipReport
        Four measurements as `retime.motion.contacts.slip` defines them. Without averaging a foot is only where the
        input had it, so there is no more slip than in the input, but for the frame from which it is counted.
    """
    if not isinstance(motion, Motion):
        raise OptionError(f"expected retimed_slip(motion, warp) with a Motion, for feet slip; found {kind_of(motion)}")
    warp = as_warp(warp, "retimed_slip(motion, warp)")
    _compare_ranges(motion, warp)
    if not (contacts is None or isinstance(contacts, Contacts)):
        raise OptionError(f"contacts must be Contacts or None, which finds them; found {kind_of(contacts)}")
    if contacts is not None:
        contacts.refuse_other(motion)
    if loop:
        _check_seam(motion)
    standing = find_contacts(motion) if contacts is None else contacts
    shown = standing.where_held().spans_at(warp(output_frame_times(warp, float(motion.rate))))

    def measured(average: bool, exempt: Contacts | None, keep_root_path: bool) -> Slip:
        return slip_of(_apply(motion, warp, average, exempt, keep_root_path, loop), standing.feet, shown)

    return SlipReport(
        input=slip(motion, standing),
        unaveraged=measured(False, None, True),
        plain=measured(True, None, False),
        contact_aware=measured(True, standing, True),
    )
