"""guided_warp(): the one call most people need."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from retime.errors import OptionError
from retime.kernels import FloatArray
from retime.motion.motion import Motion
from retime.motion.rate import parse_rate
from retime.motion.signal import Signal
from retime.motion.timecode import parse_length, parse_time
from retime.warp import features as feature_space
from retime.warp.curve import Keytime, Warp
from retime.warp.keytimes import Reduction, knots_of_path, reduce_to_compression
from retime.warp.path import FramePath, check_feasible, shortest_path
from retime.warp.score import check_reference, triple_scores

DEFAULT_RATE = 30
DEFAULT_MAX_SKIP = 8
DEFAULT_NEIGHBORS = 3
# Seconds. See docs/method.md: with 1/30 (the paper read literally) some clips lose frames of their flights.
DEFAULT_TIME_SCALE = 0.1
# Hz.
DEFAULT_LOW_PASS = 4.0
# Analysis frames averaged by the moving window that smooths the staircase.
DEFAULT_SMOOTHING = 5


@dataclass(frozen=True, eq=False)
class GuidedWarp:
    """A guided warp, and how it came about.

    Attributes
    ----------
    warp : Warp
        The result: output time to input time, smooth.
    steps : Warp
        The same before smoothing: the polyline through the frames of the path.
    path : FramePath
        The selected frames of the unrolled input, their scores and total.
    reduction : Reduction
        What the search was offered.
    n_reference : int
        Reference frames at the analysis rate.
    max_skip, n_neighbors : int
        As used.
    time_scale, low_pass : float
        As used; seconds and Hz.
    seconds : dict of str to float
        Time spent in each stage.
    """

    warp: Warp
    steps: Warp
    path: FramePath
    reduction: Reduction
    n_reference: int
    max_skip: int
    n_neighbors: int
    time_scale: float
    low_pass: float
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def n_input(self) -> int:
        """Frames offered to the search."""
        return self.reduction.n_input

    @property
    def n_output(self) -> int:
        """Frames selected."""
        return self.reduction.n_output

    @property
    def upsample(self) -> int:
        """Unrolled input frames per analysis period."""
        return self.reduction.upsample

    @property
    def rate(self) -> float:
        """Analysis rate, Hz."""
        return self.reduction.rate

    @property
    def total(self) -> float:
        """The objective (Eq. 1): sum of the path's scores."""
        return self.path.total

    @property
    def path_speeds(self) -> FloatArray:
        """Playback speed of each step of the path, shape (n_output - 1,)."""
        return np.diff(self.path.frames) / self.upsample


def as_keytimes(
    motion: Motion | Signal, length: str | int | None, keys: Sequence[tuple[float | str, float | str]]
) -> tuple[Keytime, ...]:
    """Turn a length and keys as people write them into keytimes, ends included.

    Parameters
    ----------
    motion : Motion or Signal
        The input.
    length : str or int, optional
        Of the output (`retime.motion.timecode.parse_length`). Left out: after the last key the input plays on at
        its own speed.
    keys : sequence of (input time, output time)
        Seconds, or text such as ``"120f"``.

    Raises
    ------
    OptionError
        A time or length can't be read, or a key lies beyond the length.
    """
    rate = motion.rate
    pairs = {Keytime(parse_time(o, rate), parse_time(i, rate)) for i, o in keys}
    if all(key.output_time != 0.0 for key in pairs):
        pairs.add(Keytime(0.0, 0.0))
    last = max(pairs)
    if length is not None:
        end = float((parse_length(length, motion.n_frames, rate) - 1) / rate)
        if last.output_time > end + 1e-9:
            raise OptionError(
                f"a keytime stands at output time {last.output_time:g} s, beyond the output's end at {end:g} s"
            )
    else:
        end = last.output_time + (motion.duration - last.input_time)
    if end > last.output_time + 1e-9:
        pairs.add(Keytime(end, motion.duration))
    return tuple(sorted(pairs))


def guided_warp(
    motion: Motion | Signal,
    *,
    reference: Motion | Signal | None = None,
    length: str | int | None = None,
    keys: Sequence[tuple[float | str, float | str]] = (),
    rate: float | str | Fraction = DEFAULT_RATE,
    max_skip: int | None = None,
    upsample: int | None = None,
    n_neighbors: int = DEFAULT_NEIGHBORS,
    time_scale: float = DEFAULT_TIME_SCALE,
    low_pass: float = DEFAULT_LOW_PASS,
    features: str | None = None,
    smoothing: int = DEFAULT_SMOOTHING,
) -> GuidedWarp:
    """Find the warp that meets the keytimes, keeps the input's content, and moves like the reference (§3).

    Parameters
    ----------
    motion : Motion or Signal
        The input.
    reference : Motion or Signal, optional
        Moves with the timing that is wanted; the same skeleton. Left out: the input itself.
    length : str or int, optional
        Length of the output: ``"65%"``, ``"9.3s"``, ``"280f"`` or 280 (frames at the input's rate). Left out: as
        the input.
    keys : sequence of (input time, output time)
        More keytimes, in seconds or as text (``"120f"``); the clip's ends are added.
    rate : number, str or Fraction
        Analysis rate, Hz (the paper's 30). The output keeps the input's own rate.
    max_skip : int, optional
        Largest step between neighbouring selected frames of the upsampled input: no speed goes beyond ``max_skip /
        upsample``. Left out: 8, or twice the mean step where that is more.
    upsample : int, optional
        Frames offered per analysis period: no speed falls below ``1 / upsample``. Left out: 1 where the input moves
        like itself and gets no longer, else 4, or twice the mean slow-down where that is more.
    n_neighbors : int
        Reference frames averaged in a score (the paper's k).
    time_scale : float
        τ, seconds: how much velocity and acceleration weigh against pose.
    low_pass : float
        Cutoff in Hz of the filter that the analysis (never the output) looks through; 0 is off.
    features : {"torso", "heading", "signal"}, optional
        Pose space; see `retime.warp.features.pose_vectors`.
    smoothing : int
        Output frames, at the analysis rate, averaged by the moving window that smooths the path's staircase; 0 or 1
        is off.

    Returns
    -------
    GuidedWarp
        ``.warp`` is the result; the rest tells how it came about.

    Raises
    ------
    InfeasibleWarpError
        No warp meets the keytimes within the limits; says what would.
    OptionError
        Options that contradict each other or the data.

    Examples
    --------
    >>> from fractions import Fraction
    >>> t = np.arange(120) / 30
    >>> wave = Signal(("x",), np.sin(t**2)[:, None], Fraction(30))
    >>> result = guided_warp(wave, length="75%")
    >>> result.n_input, result.n_output, round(float(result.warp(result.warp.output_end)), 3)
    (120, 90, 3.967)
    """
    clock = _Clock()
    analysis_rate = float(parse_rate(rate))
    keytimes = as_keytimes(motion, length, keys)
    itself = reference is None or reference is motion
    upsample = upsample if upsample is not None else _choose_upsample(keytimes, itself)
    reduction = reduce_to_compression(keytimes, motion.duration, rate=analysis_rate, upsample=upsample)
    max_skip = max_skip if max_skip is not None else _choose_max_skip(reduction)
    check_feasible(reduction.anchors, max_skip)

    poses = feature_space.low_pass(feature_space.pose_vectors(motion, features), motion.rate, low_pass)
    if itself:
        model, reference_poses = motion, poses
    else:
        assert reference is not None
        model = reference
        _check_same_kind(motion, reference)
        reference_poses = feature_space.low_pass(feature_space.pose_vectors(model, features), model.rate, low_pass)
    clock.stage("features")
    n_reference = int(np.floor(model.duration * analysis_rate + 1e-6)) + 1
    check_reference(n_reference, n_neighbors)
    scores = triple_scores(
        feature_space.sample(poses, motion.rate, reduction.input_times),
        feature_space.sample(reference_poses, model.rate, np.arange(n_reference) / analysis_rate),
        max_skip=max_skip,
        rate=analysis_rate,
        time_scale=time_scale,
        n_neighbors=n_neighbors,
    )
    clock.stage("scores")
    path = shortest_path(scores, n_output=reduction.n_output, anchors=reduction.anchors)
    clock.stage("path")
    steps = knots_of_path(reduction, path.frames)
    warp = smooth_steps(steps, smoothing / analysis_rate, motion.rate)
    clock.stage("curve")
    return GuidedWarp(
        warp, steps, path, reduction, n_reference, max_skip, n_neighbors, time_scale, low_pass, clock.seconds
    )


def smooth_steps(steps: Warp, window: float, rate: Fraction) -> Warp:
    """Smooth a staircase, with a knot at every output frame of the motion that it will be applied to."""
    n_knots = round(steps.output_duration * float(rate)) + 1
    times: ArrayLike = np.append(steps.output_start + np.arange(n_knots - 1) / float(rate), steps.output_end)
    return steps.smooth(window, at=np.union1d(times, steps.output_times) if window == 0 else times)


def _choose_upsample(keytimes: tuple[Keytime, ...], itself: bool) -> int:
    slowest = 1.0
    for before, after in itertools.pairwise(keytimes):
        change = abs(after.input_time - before.input_time)
        if change > 0:
            slowest = min(slowest, change / (after.output_time - before.output_time))
    if itself and slowest > 0.999:
        return 1
    return max(4, int(np.ceil(2 / slowest)))


def _choose_max_skip(reduction: Reduction) -> int:
    mean_skips = [
        (j1 - j0) / (p1 - p0) for (p0, j0), (p1, j1) in zip(reduction.anchors[:-1], reduction.anchors[1:], strict=True)
    ]
    return max(DEFAULT_MAX_SKIP, int(np.ceil(2 * max(mean_skips))))


def _check_same_kind(motion: Motion | Signal, reference: Motion | Signal) -> None:
    if isinstance(motion, Motion) and isinstance(reference, Motion):
        if motion.skeleton.names != reference.skeleton.names:
            missing = [name for name in motion.skeleton.names if name not in reference.skeleton.names]
            detail = f": it has no {', '.join(missing[:5])}" if missing else " in the same order"
            raise OptionError(
                f"the reference {reference.name or ''} must have the input's {motion.skeleton.n_joints} joints{detail}"
            )
    elif isinstance(motion, Signal) and isinstance(reference, Signal):
        if motion.names != reference.names:
            raise OptionError(
                f"the reference must have the input's channels {', '.join(motion.names)}; it has "
                f"{', '.join(reference.names)}"
            )
    else:
        raise OptionError("input and reference must both be motions, or both be signals")


class _Clock:
    """Seconds of each stage."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def stage(self, name: str) -> None:
        now = time.perf_counter()
        self.seconds[name] = now - self._last
        self._last = now
