"""A motion prepared for retiming: analysed once, solved as often as its keytimes move.

Features, reference model and scores depend on the clips, not on the keytimes, as long as the input is unrolled
alike: a session keeps them, so that only the search runs again when a keytime is dragged.
"""

from __future__ import annotations

import bisect
import contextlib
import itertools
import math
import time
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import BoolArray, FloatArray, IntArray, as_real
from retime.brief import kind_of
from retime.checks import real, whole
from retime.errors import InfeasibleWarpError, OptionError
from retime.motion.first_frames import hint_at_first_frames
from retime.motion.grammar import parse_length, parse_speed, parse_speeds, read_lock
from retime.motion.rate import parse_rate
from retime.search.inputs import Clip, as_clips, as_references
from retime.search.keytimes import as_keytimes, asking_for_a_share, check_keytimes, refuse_single_frame
from retime.search.path import FramePath, shortest_path
from retime.search.path_curve import knots_of_path
from retime.search.plan import Wishes, reduce_to_fit
from retime.search.poses.references import Reference, model_poses
from retime.search.poses.spaces import PoseOptions, PoseSpace
from retime.search.reduction import Reduction, nearest_frame
from retime.search.result import GuidedWarp
from retime.search.score import Model, ScoreName, build_model, triple_scores
from retime.search.score_table import ScoreTable, score_table
from retime.search.wishes.allowed import end_costs, forbid
from retime.search.wishes.feasible import steps_fit
from retime.search.wishes.kept import kept_positions, kept_speeds, speed_bounds
from retime.search.wishes.locks import Lock
from retime.search.wishes.prices import add_smoothness, neutral_weights, weigh_neutral
from retime.warp.curve import Keytime, Warp, blend
from retime.warp.spline import spline_warp

DEFAULT_RATE = 30
DEFAULT_NEIGHBORS = 3
# Seconds. By docs/study: from 0.1 to 0.2 flights are kept alike, and at 0.2 other timing is imitated best.
DEFAULT_TIME_SCALE = 0.2
# Hz.
DEFAULT_LOW_PASS = 4.0
# Analysis frames averaged by the moving window that smooths the staircase.
DEFAULT_SMOOTHING = 5
SearchName = Literal["priced", "layered", "heuristic"]
SEARCHES = get_args(SearchName)
FreeWeight = Literal["neutral", "sum"]
FREE_WEIGHTS = get_args(FreeWeight)
# Analysis rate of the paper's coarse search, Hz (§3.3).
_COARSE_RATE = 5.0


class Session:
    """A motion and its references, analysed; `solve` finds warps.

    Parameters are those of `retime.guided_warp` that don't depend on keytimes.

    Examples
    --------
    >>> from fractions import Fraction
    >>> from retime import Signal
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
        features: PoseSpace | PoseOptions | Sequence[PoseOptions] | None = None,
        score: ScoreName = "joint",
    ) -> None:
        clock = Clock()
        n_neighbors = whole(n_neighbors, "n_neighbors", option="n_neighbors")
        time_scale = real(time_scale, "the time scale", option="time_scale")
        low_pass = real(low_pass, "the low-pass cutoff", option="low_pass")
        self.rate = float(parse_rate(DEFAULT_RATE if rate is None else rate))
        self.clips = as_clips(motion, rate)
        self.motion = self.clips[0]
        refuse_single_frame(self.motion)
        for clip in self.clips:
            hint_at_first_frames(clip)
        self.itself = reference is None or reference is motion
        self.n_neighbors, self.time_scale, self.low_pass, self.score = n_neighbors, time_scale, low_pass, score
        poses = model_poses(
            self.clips, () if self.itself else as_references(reference, len(self.clips), rate), features
        ).in_own_order()
        self._tracks, references = poses.input, poses.references
        self._own_name = self._tracks.name if self.itself else ""
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
                own_name=self._own_name,
            )
        }
        self._reference_tracks = references
        self._table: ScoreTable | None = None
        self._analysis_seconds = {"features": clock.lap()}

    def __repr__(self) -> str:
        clips = ", ".join(map(repr, self.clips))
        return f"Session({clips if len(clips) <= 200 else f'{len(self.clips)} clips'}, analysed at {self.rate:g} Hz)"

    def solve(
        self,
        *,
        length: str | float | None = None,
        min_length: str | float | None = None,
        max_length: str | float | None = None,
        free_weight: FreeWeight = "neutral",
        keys: Sequence[str | Sequence[float | str | None]] = (),
        locks: Sequence[Lock | str] = (),
        speed: str | Sequence[float | str] | None = None,
        smoothness: float = 0.0,
        influence: ArrayLike = 1.0,
        loop: bool = False,
        max_skip: int | None = None,
        upsample: int | None = None,
        smoothing: int = DEFAULT_SMOOTHING,
        search: SearchName = "priced",
    ) -> GuidedWarp:
        """Find the warp; see `retime.guided_warp` for the parameters and errors."""
        clock = Clock()
        if search not in SEARCHES:
            raise OptionError(f"the search must be one of {', '.join(SEARCHES)}; found {search!r}")
        if free_weight not in FREE_WEIGHTS:
            raise OptionError(f"the free weight must be one of {', '.join(FREE_WEIGHTS)}; found {free_weight!r}")
        max_skip = None if max_skip is None else whole(max_skip, "max_skip", option="max_skip")
        upsample = None if upsample is None else whole(upsample, "upsample", option="upsample")
        window = real(smoothing, "smoothing", option="smoothing")
        smoothness = real(smoothness, "smoothness", option="smoothness")
        if (
            isinstance(locks, Lock | str)
            or not isinstance(locks, Sequence)
            or not all(isinstance(one, Lock | str) for one in locks)
        ):
            raise OptionError(
                f"locks are a sequence of Lock, as in locks=[Lock(6.12, 6.52)]; found {kind_of(locks)}", option="locks"
            )
        slowest, fastest = _speeds(speed)
        if not 0 <= slowest <= fastest or fastest == 0:
            raise OptionError(
                f"speed limits must be above 0, the slowest first; found {slowest:g} to {fastest:g}", option="speed"
            )
        keytimes = check_keytimes(as_keytimes(self.motion, length, keys), self.motion.end_time)
        free = math.isinf(keytimes[-1].output_time)
        if (min_length is not None or max_length is not None) and not free:
            raise OptionError("bounds on the length need a free length (length='free')", option="length")
        if loop:
            _check_loop(keytimes, search)
        bounds = self._length_bounds(min_length, max_length)
        wishes = Wishes(
            self.motion.end_time,
            float(1 / self.motion.rate),
            tuple(_lock(lock, i, self.motion.rate) for i, lock in enumerate(locks)),
            tuple(key.speed for key in keytimes if key.speed is not None),
            slowest,
            fastest,
        )
        with asking_for_a_share(self.motion, length):
            reduction, max_skip = reduce_to_fit(
                keytimes,
                wishes,
                rate=self.rate,
                itself=self.itself,
                loop=loop,
                upsample=upsample,
                max_skip=max_skip,
                counts=lambda reduction: self._length_range(bounds, reduction),
            )
        locked, allowed = wishes.locked(reduction, max_skip), wishes.allowed(reduction, max_skip)
        counts = self._length_range(bounds, reduction) if free else None

        scores, poses = self._scores(reduction, max_skip)
        seconds = dict(self._analysis_seconds)
        seconds["scores"] = clock.lap()
        neutral = free and free_weight == "neutral"
        if wishes.any or smoothness or neutral:
            scores = scores.copy()
        add_smoothness(scores, smoothness, reduction)
        if wishes.any:
            forbid(scores, allowed)
        if neutral:
            weigh_neutral(scores, reduction)

        anchors = reduction.anchors[:-1] if free else reduction.anchors
        n_output: int | tuple[int, int] | None = reduction.n_output if counts is None else counts
        if free and len(keytimes) == 2 and bounds == (2, None):
            # Keytimes inside the clip have places in the output, so that the count matters; here nothing counts.
            n_output = None
        excess = None
        if search == "heuristic":
            path, excess = self._heuristic(reduction, scores, allowed, max_skip, anchors, n_output)
        elif loop:
            seam = self._seam_costs(reduction, poses, max_skip)
            if neutral:
                ends = reduction.upsamples[-1], reduction.upsamples[0]
                seam = seam * np.diagonal(neutral_weights(max_skip, *ends))
            path = _loop(scores, allowed, seam, anchors, n_output, search)
        else:
            start, end = end_costs(allowed)
            path = shortest_path(
                scores, n_output=n_output, anchors=anchors, start_cost=start, end_cost=end, search=search
            )
        if free:
            least_end, most_end = (math.inf if n is None else float((n - 1) / self.motion.rate) for n in bounds)
            reduction = reduction.with_path(
                path.frames, float(self.motion.rate), least_end=least_end, most_end=most_end
            )
        seconds["path"] = clock.lap()

        speeds = kept_speeds(reduction, path.frames, locked=locked, slowest=slowest, fastest=fastest, loop=loop)
        limits = speed_bounds(
            reduction, path.frames, max_skip, locked=locked, slowest=slowest, fastest=fastest, loop=loop
        )
        steps = knots_of_path(reduction, path.frames, speeds=speeds, bounds=limits)
        warp = smooth_steps(
            steps,
            # A window of one frame averages nothing.
            0.0 if window in (0, 1) else window / self.rate,
            float(self.motion.rate),
            keep=steps.output_times[kept_positions(reduction, path.frames, locked)],
            loop=loop,
        )
        share = as_real(influence, "influence", error=OptionError)
        if share.ndim or share != 1.0:
            warp = blend(self._spline(reduction.keytimes, steps, loop=loop), warp, share)
            warp = replace(warp, method="guided", keytimes=reduction.keytimes)
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
            locked=locked,
            n_reference=self.n_reference,
            max_skip=max_skip,
            n_neighbors=self.n_neighbors,
            time_scale=self.time_scale,
            low_pass=self.low_pass,
            score=self.score,
            clips=self.clips,
            loop=loop,
            excess=excess,
            seconds=seconds,
        )

    def _length_bounds(self, least: str | float | None, most: str | float | None) -> tuple[int, int | None]:
        """Bounds on a free length, in frames of the motion."""
        low, high = (self._bound("min_length", least), self._bound("max_length", most))
        if low is not None and high is not None and low > high:
            raise OptionError(f"the least length, {least}, is more than the most, {most}", option="max_length")
        return low or 2, high

    def _bound(self, option: str, text: str | float | None) -> int | None:
        if text is None:
            return None
        try:
            return parse_length(text, self.motion.n_frames, self.motion.rate)
        except OptionError as error:
            raise OptionError(str(error), option=option) from None

    def _length_range(self, bounds: tuple[int, int | None], reduction: Reduction) -> tuple[int, int]:
        """Bounds on a free length, in analysis frames: what the unrolled input and the keytimes allow of it."""
        low, high = (
            None if n is None else nearest_frame(float((n - 1) / self.motion.rate) * self.rate) + 1 for n in bounds
        )
        shortest = reduction.positions[-2] + 2
        longest = reduction.positions[-2] + 1 + reduction.frames[-1] - reduction.frames[-2]
        least = max(low or 2, shortest)
        most = longest if high is None else min(high, longest)
        if least > most:
            words = "" if high is None else f" to {high}"
            raise InfeasibleWarpError(
                f"no length lies within the bounds of {low}{words} frames (at the analysis rate): the keytimes and "
                f"upsample={reduction.upsamples[-1]} allow {shortest} to {longest}. Change the bounds, or use "
                "another upsample",
                min_output=shortest,
                max_output=longest,
                option="min_length" if longest < (low or 2) else "max_length",
            )
        return least, most

    def _spline(self, keytimes: Sequence[Keytime], steps: Warp, *, loop: bool) -> Warp:
        """Join the keytimes by a spline to mix with; that of a loop has one speed at both ends."""
        if loop and len(keytimes) > 2:
            means = [
                abs((b.input_time - a.input_time) / (b.output_time - a.output_time))
                for a, b in (keytimes[:2], keytimes[-2:])
            ]
            # A spline passes at no more than three times the mean speed beside a keytime.
            speed = min(float(abs(steps.slopes[0])), *(3 * mean for mean in means)) or None
            keytimes = [
                replace(key, speed=key.speed or speed) if key in (keytimes[0], keytimes[-1]) else key
                for key in keytimes
            ]
        return spline_warp(keytimes, rate=float(self.motion.rate))

    def _scores(self, reduction: Reduction, max_skip: int) -> tuple[FloatArray, FloatArray]:
        """Scores and poses of the unrolled input; kept, for little of it changes while keytimes are dragged."""
        if self._table is None or not self._table.serves(reduction, max_skip):
            skip = max_skip if self._table is None else self._table.next_skip(max_skip)

            def score(poses: FloatArray) -> FloatArray:
                return triple_scores(
                    poses, self._model_at[self.rate], max_skip=skip, n_neighbors=self.n_neighbors, score=self.score
                )

            poses = self._tracks.at(reduction.input_times, self.low_pass)
            self._table = score_table(reduction, skip, poses, score, self._table)
        return self._table.up_to(max_skip), self._table.poses

    def _seam_costs(self, reduction: Reduction, poses: FloatArray, max_skip: int) -> FloatArray:
        """Score the triple across a loop's seam, where the last frame is the first again; shape (max_skip,)."""
        reach = min(max_skip, reduction.n_input - 1)
        around = np.concatenate([poses[len(poses) - 1 - reach : -1], poses[: reach + 1]])
        scores = triple_scores(
            around, self._model_at[self.rate], max_skip=reach, n_neighbors=self.n_neighbors, score=self.score
        )
        costs = np.full(max_skip, np.inf)
        costs[:reach] = np.diagonal(scores[reach])
        return costs

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
        start, end = end_costs(allowed)
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
            anchors=_with_feasible(anchors, list(found), allowed),
            start_cost=start,
            end_cost=end,
        )
        best = shortest_path(scores, n_output=n_output, anchors=anchors, start_cost=start, end_cost=end)
        excess = (path.total - best.total) / best.total if best.total > 0 else 0.0
        return replace(path, lower_bound=best.lower_bound, optimal=path.total <= best.total, search="heuristic"), excess

    def _coarse_model(self, rate: float) -> Model:
        if rate not in self._model_at:
            try:
                self._model_at[rate] = build_model(
                    [track.at_rate(rate, self.low_pass) for track in self._reference_tracks],
                    rate=rate,
                    # The paper's features count in frames: at a lower rate its time scale is as much longer.
                    time_scale=self.time_scale * self.rate / rate,
                    n_neighbors=self.n_neighbors,
                    weights=[track.weight for track in self._reference_tracks],
                    own_name=self._own_name,
                )
            except OptionError:
                # There are frames enough at the analysis rate, or this would not be reached.
                raise OptionError(
                    f"too few frames for the heuristic search, which looks at {rate:g} Hz first: take search='priced' "
                    "(--search priced)",
                    option="search",
                ) from None
        return self._model_at[rate]


def _lock(lock: Lock | str, item: int, rate: Fraction) -> Lock:
    """Read a lock where it is text."""
    if not isinstance(lock, str):
        return lock
    try:
        return Lock(*read_lock(lock).at(rate))
    except OptionError as error:
        raise OptionError(str(error), option="locks", item=item) from None


def _check_loop(keytimes: Sequence[Keytime], search: str) -> None:
    """Refuse a loop whose ends can't agree in speed."""
    if search == "heuristic":
        raise OptionError("the heuristic search can't keep a loop: use search='priced'")
    first, last = (np.sign(b.input_time - a.input_time) for a, b in (keytimes[:2], keytimes[-2:]))
    if first != last:
        words = {1.0: "plays forward", 0.0: "holds", -1.0: "runs backward"}
        raise OptionError(
            f"a loop needs the same direction at both ends: it {words[float(first)]} at first and "
            f"{words[float(last)]} at last"
        )
    speeds = [key.speed for key in (keytimes[0], keytimes[-1])]
    if None not in speeds and speeds[0] != speeds[1]:
        raise OptionError(f"a loop has one speed at its seam: found {speeds[0]:g} at first and {speeds[1]:g} at last")


def _loop(
    scores: FloatArray,
    allowed: BoolArray,
    seam: FloatArray,
    anchors: Sequence[tuple[int, int]],
    n_output: int | tuple[int, int] | None,
    search: str,
) -> FramePath:
    """Search once for each first step: the last one must equal it, and the triple across the seam costs too."""
    start, end = end_costs(allowed)
    found: list[FramePath] = []
    for step in np.flatnonzero(np.isfinite(start + end + seam)).tolist():
        only, seamed = np.full((2, len(seam)), np.inf)
        only[step], seamed[step] = 0.0, seam[step]
        # Some of these searches have no path; all of them failing is what counts.
        with contextlib.suppress(InfeasibleWarpError):
            found.append(
                shortest_path(
                    scores, n_output=n_output, anchors=anchors, start_cost=only, end_cost=seamed, search=search
                )
            )
    if not found:
        raise InfeasibleWarpError(
            "no path begins and ends at one speed between these keytimes: loosen a lock, a tangent or a speed "
            "limit, or give the output a frame more"
        )
    best = min(found, key=lambda path: path.total)
    return replace(best, lower_bound=min(path.lower_bound for path in found))


def _speeds(speed: str | Sequence[float | str] | None) -> tuple[float, float]:
    """Read the slowest and the fastest speed; 0 and inf where none is given."""
    if speed is None:
        return 0.0, math.inf
    if isinstance(speed, str):
        return parse_speeds(speed)
    if not isinstance(speed, Sequence | np.ndarray) or len(speed) != 2:
        raise OptionError(
            f"speed is (slowest, fastest), or a text such as '1/2..4'; found {kind_of(speed)}", option="speed"
        )
    low, high = (parse_speed(one) if isinstance(one, str) else real(one, "a speed", option="speed") for one in speed)
    return low, high


def _coarse_grid(n_frames: int, every: int) -> IntArray:
    """About every so many frames, both ends included."""
    return np.round(np.linspace(0, n_frames - 1, max(2, round((n_frames - 1) / every) + 1))).astype(np.int64)


def _nearest(grid: IntArray, value: int) -> int:
    return int(np.argmin(np.abs(grid - value)))


def _with_feasible(
    anchors: Sequence[tuple[int, int]], more: Sequence[tuple[int, int]], allowed: BoolArray
) -> list[tuple[int, int]]:
    """Add those anchors that leave a way to their neighbours."""
    merged = sorted(anchors)
    for p, j in more:
        place = bisect.bisect(merged, (p, j))
        if place in (0, len(merged)):
            continue
        (p0, j0), (p1, j1) = merged[place - 1], merged[place]
        if steps_fit(allowed[j0:j], p - p0) and steps_fit(allowed[j:j1], p1 - p):
            merged.insert(place, (p, j))
    return merged


class Clock:
    """Measures the stages of a job."""

    def __init__(self) -> None:
        self._last = time.perf_counter()

    def lap(self) -> float:
        """Return the seconds since the last lap."""
        now = time.perf_counter()
        lap, self._last = now - self._last, now
        return lap
