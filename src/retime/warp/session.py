"""A motion prepared for retiming: analysed once, solved as often as its keytimes move.

Features, reference model and scores depend on the clips, not on the keytimes, as long as the input is unrolled
alike: a session keeps them, so that only the search runs again when a keytime is dragged.
"""

from __future__ import annotations

import bisect
import itertools
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import FloatArray, IntArray
from retime.motion.motion import Motion
from retime.motion.rate import parse_rate
from retime.motion.signal import Signal
from retime.motion.timecode import parse_length
from retime.warp import control
from retime.warp.control import BoolArray, Lock
from retime.warp.curve import Keytime, Warp, add_times, blend
from retime.warp.explain import Explanation, explain_path
from retime.warp.features import PoseOptions
from retime.warp.keytimes import Reduction, as_keytimes, knots_of_path, reduce_to_compression
from retime.warp.path import FramePath, shortest_path
from retime.warp.picture import facts_html, warp_html
from retime.warp.reference import Reference, model_poses
from retime.warp.score import Model, build_model, triple_scores
from retime.warp.spline import spline_warp

Clip = Motion | Signal

DEFAULT_RATE = 30
DEFAULT_MAX_SKIP = 8
DEFAULT_NEIGHBORS = 3
# Seconds. See docs/method.md: with 1/30 (the paper read literally) some clips lose frames of their flights.
DEFAULT_TIME_SCALE = 0.1
# Hz.
DEFAULT_LOW_PASS = 4.0
# Analysis frames averaged by the moving window that smooths the staircase.
DEFAULT_SMOOTHING = 5
SEARCHES = ("priced", "layered", "heuristic")
FREE_WEIGHTS = ("neutral", "sum")
# Analysis rate of the paper's coarse search, Hz (§3.3).
_COARSE_RATE = 5.0


@dataclass(frozen=True, eq=False)
class GuidedWarp:
    """A guided warp, and how it came about.

    Attributes
    ----------
    warp : Warp
        The result: output time to input time, smooth.
    steps : Warp
        The guided warp before smoothing and blending: the polyline through the frames of the path.
    path : FramePath
        The selected frames of the unrolled input, their scores and total.
    reduction : Reduction
        What the search was offered.
    model : Model
        The reference frames.
    references : tuple of str
        Names of the references.
    input_poses : float array, shape (n_input, n_numbers)
        Pose vectors of the unrolled input.
    allowed : bool array, shape (n_input, max_skip)
        Steps that the search was allowed.
    n_reference : int
        Reference frames at the analysis rate, of all references.
    max_skip, n_neighbors : int
        As used.
    time_scale, low_pass : float
        As used; seconds and Hz.
    score : str
        "joint" or "conditional".
    excess : float, optional
        For the heuristic search: by what share its total exceeds the optimum.
    seconds : dict of str to float
        Time spent in each stage.
    """

    warp: Warp
    steps: Warp
    path: FramePath
    reduction: Reduction
    model: Model
    references: tuple[str, ...]
    input_poses: FloatArray
    allowed: BoolArray
    n_reference: int
    max_skip: int
    n_neighbors: int
    time_scale: float
    low_pass: float
    score: str
    excess: float | None = None
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
        """Playback speed of each step of the path, shape (n_output - 1,); 0 in a hold, below 0 backward."""
        frames = self.path.frames
        direction = np.sign(np.diff(self.reduction.input_times[frames]))
        return np.asarray(direction * np.diff(frames) / self.upsample)

    def explain(self) -> Explanation:
        """Say for each output frame what it scored, what it was matched with, and what was binding."""
        return explain_path(
            self.reduction,
            self.path,
            self.model,
            self.input_poses,
            self.allowed,
            references=self.references,
            n_neighbors=self.n_neighbors,
            score=self.score,
        )

    def _repr_html_(self) -> str:
        facts = {
            "n_input": self.n_input,
            "n_output": self.n_output,
            "n_reference": self.n_reference,
            "max_skip": self.max_skip,
            "upsample": self.upsample,
            "rate": f"{self.rate:g} Hz",
            "total": f"{self.total:.6g}",
            "optimal": "proved" if self.path.optimal else "no",
            "seconds": f"{sum(self.seconds.values()):.3f}",
        }
        return warp_html(self.warp) + facts_html(facts)


class Session:
    """A motion and its references, analysed; `solve` finds warps.

    Parameters are those of `retime.guided_warp` that don't depend on keytimes.

    Examples
    --------
    >>> from fractions import Fraction
    >>> t = np.arange(120) / 30
    >>> session = Session(Signal(("x",), np.sin(t**2)[:, None], Fraction(30)))
    >>> [session.solve(keys=[(2.0, to)], length="75%").n_output for to in (1.4, 1.5, 1.6)]
    [90, 90, 90]
    """

    def __init__(
        self,
        motion: Clip | ArrayLike | Sequence[Clip],
        *,
        reference: Clip | ArrayLike | Reference | Sequence[Clip | Reference] | None = None,
        rate: float | str | None = None,
        n_neighbors: int = DEFAULT_NEIGHBORS,
        time_scale: float = DEFAULT_TIME_SCALE,
        low_pass: float = DEFAULT_LOW_PASS,
        features: str | PoseOptions | None = None,
        score: str = "joint",
    ) -> None:
        clock = Clock()
        self.rate = float(parse_rate(DEFAULT_RATE if rate is None else rate))
        self.clips = as_clips(motion, rate)
        self.motion = self.clips[0]
        self.itself = reference is None or reference is motion
        self.n_neighbors, self.time_scale, self.low_pass, self.score = n_neighbors, time_scale, low_pass, score
        poses = model_poses(
            self.clips, () if self.itself else _as_references(reference, len(self.clips), rate), features
        )
        self._tracks, references = poses.input, poses.references
        self.references = tuple(track.name for track in references)
        sampled = [track.at_rate(self.rate, low_pass) for track in references]
        self.n_reference = sum(len(poses) for poses in sampled)
        self._model_at = {
            self.rate: build_model(
                sampled,
                rate=self.rate,
                time_scale=time_scale,
                n_neighbors=n_neighbors,
                weights=[track.weight for track in references],
            )
        }
        self._reference_tracks = references
        self._scored: tuple[FloatArray, int, FloatArray, FloatArray] | None = None
        self._analysis_seconds = {"features": clock.lap()}

    def solve(
        self,
        *,
        length: str | int | None = None,
        min_length: str | int | None = None,
        max_length: str | int | None = None,
        free_weight: str = "neutral",
        keys: Sequence[Sequence[float | str | None]] = (),
        locks: Sequence[Lock] = (),
        speed: tuple[float, float] | None = None,
        smoothness: float = 0.0,
        influence: ArrayLike = 1.0,
        loop: bool = False,
        max_skip: int | None = None,
        upsample: int | None = None,
        smoothing: int = DEFAULT_SMOOTHING,
        search: str = "priced",
    ) -> GuidedWarp:
        """Find the warp; see `retime.guided_warp` for the parameters and errors."""
        clock = Clock()
        if search not in SEARCHES:
            raise OptionError(f"the search must be one of {', '.join(SEARCHES)}; found {search!r}")
        if free_weight not in FREE_WEIGHTS:
            raise OptionError(f"the free weight must be one of {', '.join(FREE_WEIGHTS)}; found {free_weight!r}")
        slowest, fastest = (0.0, math.inf) if speed is None else speed
        if not 0 <= slowest <= fastest or fastest == 0:
            raise OptionError(f"speed limits must be above 0, the slowest first; found {slowest:g} to {fastest:g}")
        keytimes = as_keytimes(self.motion, length, keys)
        free = math.isinf(keytimes[-1].output_time)
        if (min_length is not None or max_length is not None) and not free:
            raise OptionError("bounds on the length need a free length (length='free')")
        tangents = [key.speed for key in keytimes if key.speed is not None]
        if upsample is None:
            least = 1 if slowest == 0 else math.ceil(1 / slowest - 1e-9)
            wanted = self._choose_upsample(keytimes, locks, tangents) if speed is None else least
            upsample = control.upsample_for(max(least, wanted), locks, tangents)
        reduction = reduce_to_compression(keytimes, self.motion.duration, rate=self.rate, upsample=upsample)
        if max_skip is None:
            max_skip = self._choose_max_skip(reduction, fastest, locks, tangents)
        constrained = bool(locks or tangents) or speed is not None
        allowed = control.allowed_steps(reduction, max_skip, locks=locks, slowest=slowest, fastest=fastest)
        counts = self._length_range(min_length, max_length, reduction) if free else None
        control.check_counts(
            reduction, allowed, max_skip, most=None if counts is None else counts[1], free=free and counts is None
        )

        scores, poses = self._scores(reduction, max_skip)
        seconds = dict(self._analysis_seconds)
        seconds["scores"] = clock.lap()
        if constrained or smoothness or (free and free_weight == "neutral"):
            scores = scores.copy()
        if constrained:
            control.forbid(scores, allowed)
        control.add_smoothness(scores, smoothness, reduction.held)
        if free and free_weight == "neutral":
            scores *= control.neutral_weights(max_skip, upsample)

        anchors = reduction.anchors[:-1] if free else reduction.anchors
        n_output = counts if free else reduction.n_output
        excess = None
        if search == "heuristic":
            path, excess = self._heuristic(reduction, scores, allowed, max_skip, anchors, n_output)
        elif loop:
            path = self._loop(reduction, scores, allowed, poses, max_skip, anchors, n_output, search)
        else:
            start, end = control.end_costs(allowed)
            path = shortest_path(
                scores, n_output=n_output, anchors=anchors, start_cost=start, end_cost=end, search=search
            )
        if free:
            reduction = reduction.with_path(path.frames, float(self.motion.rate))
        seconds["path"] = clock.lap()

        steps = knots_of_path(reduction, path.frames, rigid=allowed.sum(axis=1) == 1 if constrained else None)
        warp = smooth_steps(steps, smoothing / self.rate, float(self.motion.rate), loop=loop)
        share = np.asarray(influence, dtype=np.float64)
        if share.ndim or share != 1.0:
            warp = blend(spline_warp(reduction.keytimes, rate=float(self.motion.rate)), warp, share)
            warp = replace(warp, method="guided")
        seconds["curve"] = clock.lap()
        return GuidedWarp(
            warp=warp,
            steps=steps,
            path=path,
            reduction=reduction,
            model=self._model_at[self.rate],
            references=self.references,
            input_poses=poses,
            allowed=allowed,
            n_reference=self.n_reference,
            max_skip=max_skip,
            n_neighbors=self.n_neighbors,
            time_scale=self.time_scale,
            low_pass=self.low_pass,
            score=self.score,
            excess=excess,
            seconds=seconds,
        )

    def _choose_upsample(self, keytimes: Sequence[Keytime], locks: Sequence[Lock], tangents: Sequence[float]) -> int:
        """1 where the input moves like itself and gets no longer, else 4, or twice the mean slow-down."""
        slowest = min([1.0, *(lock.fastest for lock in locks), *(abs(speed) for speed in tangents)])
        slower = slowest < 1
        for before, after in itertools.pairwise(keytimes):
            change = abs(after.input_time - before.input_time)
            if math.isinf(after.output_time):
                slower = True
            elif change > 0:
                slowest = min(slowest, change / (after.output_time - before.output_time))
        if self.itself and slowest > 0.999 and not slower:
            return 1
        return max(4, math.ceil(2 / slowest - 1e-9))

    def _choose_max_skip(
        self, reduction: Reduction, fastest: float, locks: Sequence[Lock], tangents: Sequence[float]
    ) -> int:
        """8, or twice the mean step where that is more; or what the speed limits say."""
        if fastest < math.inf:
            return max(1, math.floor(fastest * reduction.upsample + 1e-6))
        anchors = reduction.anchors[:-1] if reduction.free else reduction.anchors
        mean = [(j1 - j0) / (p1 - p0) for (p0, j0), (p1, j1) in itertools.pairwise(anchors)]
        least = [lock.fastest for lock in locks if lock.fixed] + [lock.slowest for lock in locks]
        wanted = max([0.0, *least, *(abs(speed) for speed in tangents)]) * reduction.upsample
        return max(DEFAULT_MAX_SKIP, math.ceil(2 * max(mean, default=0.0)), math.ceil(wanted - 1e-6))

    def _length_range(
        self, least: str | int | None, most: str | int | None, reduction: Reduction
    ) -> tuple[int, int] | None:
        """Bounds on a free length, in analysis frames."""
        if least is None and most is None:
            return None
        motion = self.motion

        def frames(text: str | int) -> int:
            seconds = float((parse_length(text, motion.n_frames, motion.rate) - 1) / motion.rate)
            return max(2, math.floor(seconds * self.rate + 0.5 + 1e-6) + 1)

        low = 2 if least is None else frames(least)
        high = reduction.n_input if most is None else min(frames(most), reduction.n_input)
        if low > high:
            raise InfeasibleWarpError(
                f"no length lies between {least or 2} and {most or 'the longest'}: at most {reduction.n_input} "
                f"analysis frames with upsample={reduction.upsample}"
            )
        return low, high

    def _scores(self, reduction: Reduction, max_skip: int) -> tuple[FloatArray, FloatArray]:
        """Scores and poses of the unrolled input; kept, for it rarely changes while keytimes are dragged."""
        if self._scored is not None:
            times, skip, scores, poses = self._scored
            if skip == max_skip and np.array_equal(times, reduction.input_times):
                return scores, poses
        poses = self._tracks.at(reduction.input_times, self.low_pass)
        scores = triple_scores(
            poses, self._model_at[self.rate], max_skip=max_skip, n_neighbors=self.n_neighbors, score=self.score
        )
        self._scored = reduction.input_times, max_skip, scores, poses
        return scores, poses

    def _loop(
        self,
        reduction: Reduction,
        scores: FloatArray,
        allowed: BoolArray,
        poses: FloatArray,
        max_skip: int,
        anchors: Sequence[tuple[int, int]],
        n_output: int | tuple[int, int] | None,
        search: str,
    ) -> FramePath:
        """Search once for each first step: the last one must equal it, and the triple across the seam is scored too."""
        reach = min(max_skip, reduction.n_input - 1)
        seam = np.concatenate([poses[len(poses) - 1 - reach : -1], poses[: reach + 1]])
        across = triple_scores(
            seam, self._model_at[self.rate], max_skip=reach, n_neighbors=self.n_neighbors, score=self.score
        )[reach]
        start, end = control.end_costs(allowed)
        best: FramePath | None = None
        for step in range(1, reach + 1):
            if not (start[step - 1] == 0 and end[step - 1] == 0):
                continue
            only = np.full(max_skip, np.inf)
            only[step - 1] = 0.0
            seamed = np.full(max_skip, np.inf)
            seamed[step - 1] = across[step - 1, step - 1]
            try:
                path = shortest_path(
                    scores, n_output=n_output, anchors=anchors, start_cost=only, end_cost=seamed, search=search
                )
            except InfeasibleWarpError:
                continue
            if best is None or path.total < best.total:
                best = path
        if best is None:
            raise InfeasibleWarpError(
                "no path begins and ends at one speed between these keytimes: loosen a lock, a tangent or a speed "
                "limit, or give the output a frame more"
            )
        return best

    def _heuristic(
        self,
        reduction: Reduction,
        scores: FloatArray,
        allowed: BoolArray,
        max_skip: int,
        anchors: Sequence[tuple[int, int]],
        n_output: int | tuple[int, int] | None,
    ) -> tuple[FramePath, float]:
        """Search from coarse to fine as the paper does (§3.3): a path at 5 Hz sets keytimes for the full rate."""
        if not isinstance(n_output, int):
            raise OptionError("the heuristic search needs a given length")
        start, end = control.end_costs(allowed)
        every = max(1, round(self.rate / _COARSE_RATE))
        frames = _coarse_grid(reduction.n_input, every)
        positions = _coarse_grid(n_output, every)
        nearest = [(_nearest(positions, p), _nearest(frames, j)) for p, j in anchors]
        # At 5 Hz a cycle of a walk is a few frames: a longer step than the keytimes need leaps over whole cycles
        # for nothing.
        mean = [(j1 - j0) / max(1, p1 - p0) for (p0, j0), (p1, j1) in itertools.pairwise(nearest)]
        coarse_skip = min(max_skip, max(2, math.ceil(max(mean))))
        scores_at_coarse = triple_scores(
            self._tracks.at(reduction.input_times[frames], self.low_pass),
            self._coarse_model(self.rate / every),
            max_skip=coarse_skip,
            n_neighbors=self.n_neighbors,
            score=self.score,
        )
        try:
            coarse = shortest_path(scores_at_coarse, n_output=len(positions), anchors=nearest)
        except InfeasibleWarpError as error:
            rate = self.rate / every
            raise InfeasibleWarpError(f"at the heuristic's coarse rate of {rate:g} Hz: {error}") from None
        found = zip(positions.tolist(), frames[coarse.frames].tolist(), strict=True)
        path = shortest_path(
            scores,
            n_output=n_output,
            anchors=_with_feasible(anchors, list(found), max_skip),
            start_cost=start,
            end_cost=end,
        )
        best = shortest_path(scores, n_output=n_output, anchors=anchors, start_cost=start, end_cost=end)
        excess = (path.total - best.total) / best.total if best.total > 0 else 0.0
        return replace(path, lower_bound=best.lower_bound, optimal=path.total <= best.total, search="heuristic"), excess

    def _coarse_model(self, rate: float) -> Model:
        if rate not in self._model_at:
            self._model_at[rate] = build_model(
                [track.at_rate(rate, self.low_pass) for track in self._reference_tracks],
                rate=rate,
                # The paper's features count in frames: at a lower rate its time scale is as much longer.
                time_scale=self.time_scale * self.rate / rate,
                n_neighbors=self.n_neighbors,
                weights=[track.weight for track in self._reference_tracks],
            )
        return self._model_at[rate]


def _coarse_grid(n_frames: int, every: int) -> IntArray:
    """About every so many frames, both ends included."""
    return np.round(np.linspace(0, n_frames - 1, max(2, round((n_frames - 1) / every) + 1))).astype(np.int64)


def _nearest(grid: IntArray, value: int) -> int:
    return int(np.argmin(np.abs(grid - value)))


def _with_feasible(
    anchors: Sequence[tuple[int, int]], more: Sequence[tuple[int, int]], max_skip: int
) -> list[tuple[int, int]]:
    """Add those anchors that leave a way to their neighbours."""
    merged = sorted(anchors)
    for p, j in more:
        place = bisect.bisect(merged, (p, j))
        if place in (0, len(merged)):
            continue
        (p0, j0), (p1, j1) = merged[place - 1], merged[place]
        if 0 < p - p0 <= j - j0 <= max_skip * (p - p0) and 0 < p1 - p <= j1 - j <= max_skip * (p1 - p):
            merged.insert(place, (p, j))
    return merged


def as_clips(
    motion: Clip | ArrayLike | Sequence[Clip | Reference] | None, rate: float | str | None = None
) -> tuple[Clip, ...]:
    """Take a motion, a signal, an array of numbers, or several clips that move together.

    Parameters
    ----------
    motion : Motion, Signal, sequence of them, or float array of shape (n_frames,) or (n_frames, n_channels)
        What moves.
    rate : float or str, optional
        Frames a second of an array.

    Raises
    ------
    OptionError
        An array with no rate, or nothing at all.
    """
    if isinstance(motion, Motion | Signal):
        return (motion,)
    if isinstance(motion, Sequence) and motion and all(isinstance(clip, Motion | Signal) for clip in motion):
        return tuple(clip for clip in motion if isinstance(clip, Motion | Signal))
    values = np.asarray(motion, dtype=np.float64)
    if values.ndim == 1:
        values = values[:, None]
    if values.ndim != 2 or values.shape[0] == 0:
        raise OptionError(f"expected a motion, or an array of shape (n_frames, n_channels); found shape {values.shape}")
    if rate is None:
        raise OptionError("an array of numbers needs its rate: guided_warp(array, rate=30)")
    return (Signal(tuple(f"c{i}" for i in range(values.shape[1])), values, parse_rate(rate), name="array"),)


def _as_references(
    reference: Clip | ArrayLike | Reference | Sequence[Clip | Reference] | None,
    n_clips: int,
    rate: float | str | None,
) -> list[Reference]:
    """Tell one reference from several: for a group of clips, that many plain clips are one reference."""
    if isinstance(reference, Reference):
        return [reference]
    if isinstance(reference, Sequence) and any(isinstance(one, Reference) for one in reference):
        return [one if isinstance(one, Reference) else Reference(as_clips(one, rate)) for one in reference]
    clips = as_clips(reference, rate)
    return [Reference(clips)] if n_clips > 1 else [Reference(clip) for clip in clips]


def smooth_steps(steps: Warp, window: float, rate: float, *, loop: bool = False) -> Warp:
    """Smooth a staircase, with a knot at every output frame of the motion that it will be applied to."""
    n_knots = round(steps.output_duration * rate) + 1
    times = np.append(steps.output_start + np.arange(n_knots - 1) / rate, steps.output_end)
    return steps.smooth(window, at=add_times(steps.output_times, times) if window == 0 else times, loop=loop)


class Clock:
    """Measures the stages of a job."""

    def __init__(self) -> None:
        self._last = time.perf_counter()

    def lap(self) -> float:
        """Return the seconds since the last lap."""
        now = time.perf_counter()
        lap, self._last = now - self._last, now
        return lap
