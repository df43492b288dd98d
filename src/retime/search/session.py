"""A motion prepared for retiming: analysed once, solved as often as its keytimes move.

Features, reference model and scores depend on the clips, not on the keytimes, as long as the input is unrolled
alike: a session keeps them, so that only the search runs again when a keytime is dragged.
"""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray, IntArray
from retime.brief import brief_repr, kind_of
from retime.checks import real
from retime.errors import InfeasibleWarpError, OptionError, RetimeWarning
from retime.kernels import StepPairs, n_threads
from retime.motion.any_motion import AnyMotion
from retime.motion.body import is_rigid
from retime.motion.first_frames import hint_at_first_frames
from retime.motion.grammar import parse_length, parse_speed, parse_speeds, parse_time, read_lock
from retime.motion.group_clock import hint_at_clocks
from retime.motion.motion import Motion
from retime.motion.rate import parse_rate
from retime.motion.size import extent
from retime.search import options
from retime.search.content import content_prices
from retime.search.estimate import check_fits, content_seconds, layered_seconds, loop_seconds, score_seconds
from retime.search.inputs import as_clips, as_references, check_rates
from retime.search.keytimes import as_keytimes, asking_for_a_share, check_keytimes, refuse_single_frame
from retime.search.methods.exact import PathTask, exact_path
from retime.search.methods.heuristic import COARSE_RATE, SLACK, coarse_reduction, heuristic_path
from retime.search.methods.loop import check_loop, loop_path
from retime.search.mix import mixed_within, spline_within
from retime.search.own_timing import own_timing_costs
from retime.search.path import FramePath
from retime.search.path_curve import knots_of_path, smooth_steps
from retime.search.plan import SHORTER, Request, SearchPlan, make_plan
from retime.search.poses.references import Reference, model_poses
from retime.search.poses.spaces import timing_features
from retime.search.promised_curve import promised_curve
from retime.search.promises import broken_promises
from retime.search.reduction import Reduction
from retime.search.reference_tempo import at_tempo, tempo_ratio
from retime.search.result import GuidedWarp
from retime.search.score import Model, ScoreName, build_model, triple_scores, without_copies
from retime.search.score_table import ScoreTables
from retime.search.wishes.allowed import forbid
from retime.search.wishes.asked import Wishes
from retime.search.wishes.kept import speed_bounds
from retime.search.wishes.locks import Lock
from retime.search.wishes.prices import add_smoothness, end_prices, neutral_weights, weigh_neutral
from retime.search.wishes.tempo import Tempo, tempo_of, tempo_prices
from retime.warp.blend import as_shares, blend
from retime.warp.curve import Warp
from retime.warp.spline import spline_warp

DEFAULT_RATE = 30
# Frames in which most clips show already that something changes.
_FEW_FRAMES = 1024
# Weights of the price on tempo, by docs/study: how evenly moving parts share a hurry, for a figure that moves like
# itself and for one that moves like another; and how strongly flights keep their own speed.
EVENNESS, EVENNESS_OF_ANOTHER, KEEP_FLIGHTS = 4.0, 0.1, 24.0


class Session:
    """A motion and its references, analysed; `solve` finds warps.

    Parameters
    ----------
    motion, reference, flights
        As `retime.guided_warp` has them.
    **given
        Its options that don't depend on keytimes: those of the stage "analysis" in `retime.search.options`.

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
        motion: AnyMotion | ArrayLike | Sequence[AnyMotion],
        *,
        reference: AnyMotion | ArrayLike | Reference | Sequence[AnyMotion | Reference] | None = None,
        flights: Sequence[Sequence[float | str]] | None = None,
        **given: Any,
    ) -> None:
        clock = Clock()
        # Chosen joints and their weights come as a value of their own.
        features = given.pop("features", None)
        chosen = options.completed("analysis", given)
        self.paper: bool = chosen["paper"]
        rate = chosen["rate"]
        self.rate = float(parse_rate(DEFAULT_RATE if rate is None else rate))
        self.clips = as_clips(motion, rate)
        self.motion = self.clips[0]
        refuse_single_frame(self.motion)
        check_rates(self.clips, self.rate)
        for clip in self.clips:
            hint_at_first_frames(clip)
        hint_at_clocks(self.clips)
        self.itself = reference is None or reference is motion
        self.n_neighbors: int = chosen["n_neighbors"]
        self.time_scale: float = chosen["time_scale"]
        if self.paper and self.time_scale == options.default_of("time_scale"):
            self.time_scale = 1.0 / self.rate
        if self.paper and features is None and all(isinstance(clip, Motion) for clip in self.clips):
            features = "torso"
        self.low_pass: float = chosen["low_pass"]
        self.score: ScoreName = chosen["score"]
        self._match_tempo: bool = chosen["match_tempo"]
        # How many times as fast the input moves as its reference, where that was asked for.
        self.tempo_ratio = 1.0
        poses = model_poses(
            self.clips, () if self.itself else as_references(reference, len(self.clips), rate), features
        ).in_own_order()
        self._tracks, self._reference_tracks = poses.input, poses.references
        self.references = tuple(track.name for track in self._reference_tracks)
        self._own_name = self._tracks.name if self.itself else ""
        self._models: dict[float, Model] = {}
        self.n_reference = sum(track.count_at(self.rate) for track in self._reference_tracks)
        self._model = self._model_at(self.rate)
        self._warn_of_sameness()
        # How the heuristic is read: as a band so wide about its coarse path, or (None) as keytimes.
        self.slack: int | None = SLACK
        self._tables = ScoreTables()
        # The input as it was unrolled last: its times, and its poses.
        self._poses: tuple[FloatArray, FloatArray] | None = None
        self._tempo: Tempo | None = None
        self._flights = None if flights is None else _read_flights(flights, self.motion)
        self._analysis_seconds = {"features": clock.lap()}

    def _warn_of_sameness(self) -> None:
        """Warn of clips in which the search sees nothing change."""
        for clip, track in zip(self.clips, self._tracks.tracks, strict=True):
            vectors = track.vectors
            least, greatest = extent(vectors) if vectors.size else (0.0, 0.0)
            change = 1e-9 * max(greatest, -least)
            some = (vectors[:_FEW_FRAMES], vectors)
            if clip.n_frames > 1 and not any(np.any(np.ptp(part, axis=0) > change) for part in some):
                warnings.warn(
                    f"{clip.name or 'the input'}: nothing changes in what the search looks at, so one timing is as "
                    "good as another to it: look at other features (features, joints, weights), or lock what matters",
                    RetimeWarning,
                    stacklevel=3,
                )

    def __repr__(self) -> str:
        clips = ", ".join(map(repr, self.clips))
        return f"Session({clips if len(clips) <= 200 else f'{len(self.clips)} clips'}, analysed at {self.rate:g} Hz)"

    def solve(
        self, *, keys: Sequence[str | Sequence[float | str | None]] = (), locks: Sequence[Lock | str] = (), **given: Any
    ) -> GuidedWarp:
        """Find the warp.

        Parameters
        ----------
        keys, locks
            As `retime.guided_warp` has them.
        **given
            Its other options: those of the stage "solve" in `retime.search.options`.

        Raises
        ------
        InfeasibleWarpError, OptionError
            As `retime.guided_warp`.
        """
        clock = Clock()
        chosen = options.completed("solve", given)
        request = self._request(keys, locks, chosen)
        with asking_for_a_share(self.motion, chosen["length"]):
            plan = make_plan(request, rate=self.rate, itself=self.itself)
        self._check_fits(plan, chosen)
        poses = self._unrolled(plan)
        scores = self._scores(plan)
        seconds = dict(self._analysis_seconds)
        seconds["scores"] = clock.lap()
        found = self._search(plan, scores, poses, chosen)
        path = found.path
        reduction = plan.finished(path.frames)
        seconds["path"] = clock.lap()
        curve = self._curve(plan, reduction, path, chosen)
        seconds["curve"] = clock.lap()
        return GuidedWarp(
            warp=curve.warp,
            staircase=curve.staircase,
            given_up=curve.given_up,
            path=path,
            plan=plan,
            tempo=None if found.tempo_prices is None else self.tempo,
            tempo_prices=found.tempo_prices,
            end_costs=found.end_costs,
            reduction=reduction,
            model=self._model,
            references=self.references,
            input_poses=poses,
            n_reference=self.n_reference,
            n_neighbors=self.n_neighbors,
            time_scale=self.time_scale,
            low_pass=self.low_pass,
            score=self.score,
            clips=self.clips,
            loop=request.loop,
            excess=found.excess,
            seconds=seconds,
        )

    def _check_fits(self, plan: SearchPlan, chosen: dict[str, Any]) -> None:
        """Refuse a search that is larger than anybody would wait for, before it is begun."""
        n_input, steps, n_numbers = plan.reduction.n_input, plan.steps, self._model.n_numbers
        n_rows = len(self._model.features)
        several = self.n_neighbors if len(set(self._model.weights.tolist())) > 1 else 0
        # Steps may turn out to have to follow any others.
        n_scores = float(n_input * (StepPairs.of(steps.steps).n_pairs if plan.loose else steps.n_pairs))
        n_bytes = 8 * (
            n_scores * (4.5 + 3 * several) + n_input * (3.0 * n_numbers + 6 * steps.n_steps) + 9.0 * n_rows * n_numbers
        )
        n_output = plan.n_output if isinstance(plan.n_output, int) else n_input
        seconds = self._score_seconds(n_input, steps.n_pairs)
        if chosen["search"] == "layered":
            seconds += layered_seconds(n_input, steps.n_pairs, n_output)
        if plan.request.loop:
            seconds += loop_seconds(n_input, steps.n_pairs, steps.n_steps, len(plan.reduction.still))
        if chosen["content"]:
            n_bytes += 8.0 * n_input * steps.longest
            seconds += content_seconds(n_input, steps.steps.tolist())
        check_fits(
            what=f"a search through {n_input:,} frames in {n_scores / max(1, n_input):.0f} pairs of steps, against "
            f"{n_rows:,} frames of reference,",
            remedy=SHORTER,
            n_bytes=n_bytes,
            seconds=seconds,
        )

    def _score_seconds(self, n_input: int, n_pairs: int) -> float:
        # The conditional score looks for each frame's nearest once, whatever the steps.
        n_pairs = n_pairs if self.score == "joint" else 1 + n_pairs * self.n_neighbors // len(self._model.features)
        return score_seconds(n_input, n_pairs, len(self._model.features), n_threads())

    def _request(
        self, keys: Sequence[str | Sequence[float | str | None]], locks: Sequence[Lock | str], chosen: dict[str, Any]
    ) -> Request:
        """Turn what was asked for, as people write it, into numbers."""
        slowest, fastest = _speeds(chosen["speed"])
        if not 0 <= slowest <= fastest or fastest == 0:
            raise OptionError(
                f"speed limits must be above 0, the slowest first; found {slowest:g} to {fastest:g}", option="speed"
            )
        keytimes = check_keytimes(as_keytimes(self.motion, chosen["length"], keys), self.motion.end_time)
        bounds = self._length_bounds(chosen["min_length"], chosen["max_length"])
        evenness, keep_flights = self._weights(chosen["evenness"], chosen["keep_flights"])
        request = Request(
            keytimes=keytimes,
            wishes=Wishes(
                self.motion.end_time,
                _read_locks(locks, self.motion.rate),
                tuple(key.speed for key in keytimes if key.speed is not None),
                slowest,
                fastest,
            ),
            motion_rate=self.motion.rate,
            length_bounds=bounds,
            loop=chosen["loop"],
            upsample=chosen["upsample"],
            max_skip=chosen["max_skip"],
            evenness=evenness,
            keep_flights=keep_flights,
            # Who says how long a step may be means the frames that there are.
            natural=self.itself and chosen["max_skip"] is None and (evenness > 0 or keep_flights > 0),
        )
        if not request.free and not (chosen["min_length"] is None and chosen["max_length"] is None):
            raise OptionError("bounds on the length need a free length (length='free')", option="length")
        if request.loop:
            check_loop(keytimes, chosen["search"])
        return request

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

    def _weights(self, evenness: float | None, keep_flights: float | None) -> tuple[float, float]:
        """Choose the weights of the price on tempo where they are left out."""
        figure = not self.paper and any(isinstance(clip, Motion) and not is_rigid(clip) for clip in self.clips)
        usual = (EVENNESS, KEEP_FLIGHTS) if self.itself else (EVENNESS_OF_ANOTHER, 0.0)
        return tuple(  # type: ignore[return-value]
            (default if figure else 0.0) if given is None else given
            for given, default in zip((evenness, keep_flights), usual, strict=True)
        )

    def _search(self, plan: SearchPlan, scores: FloatArray, poses: FloatArray, chosen: dict[str, Any]) -> FoundPath:
        """Put prices on scores, and find the path."""
        neutral = self._is_neutral(plan, chosen["free_weight"])

        def task_of(steps: StepPairs, costs: FloatArray) -> tuple[PathTask, FloatArray | None]:
            add_smoothness(costs, chosen["smoothness"], plan.reduction, steps, unit=self._smoothness_unit())
            if chosen["own_timing"]:
                own = own_timing_costs(poses, plan.reduction, steps, self._model)
                costs += chosen["own_timing"] * self._without_gaps(plan, own)
            if neutral:
                weigh_neutral(costs, plan.reduction, steps)
            tempo, first, last = self._step_prices(plan, steps), np.zeros(steps.n_steps), np.zeros(steps.n_steps)
            if chosen["ends"]:
                first, last = end_prices(scores, plan.reduction, steps, chosen["ends"])
            if chosen["content"]:
                left_out = content_prices(
                    poses,
                    plan.reduction,
                    steps,
                    weight=chosen["content"],
                    time_scale=self.time_scale,
                    itself=self.itself,
                )
                left_out = self._nothing_left_out_of_gaps(plan, steps, left_out)
                costs += left_out[:, steps.after]
                first = first + left_out[0]
            if tempo is not None:
                costs += tempo[:, steps.after]
                first = first + tempo[0]
            if plan.request.wishes.any:
                forbid(costs, plan.allowed, steps)
            return PathTask(plan, costs, steps, first, last, chosen["search"]), tempo

        def found(task: PathTask, tempo: FloatArray | None) -> FoundPath:
            path, excess = self._find(task, poses, neutral)
            first, last = np.searchsorted(task.steps.steps, np.diff(path.frames)[[0, -1]])
            return FoundPath(path, excess, tempo, (float(task.first[first]), float(task.last[last])))

        limited = plan.steps
        steps, costs = self._loosened(plan, scores, poses)
        try:
            return found(*task_of(steps, costs))
        except InfeasibleWarpError:
            every = StepPairs.of(limited.steps)
            if limited.n_pairs == every.n_pairs:
                raise
        # Neighbouring speeds that lie near each other leave no way through: any may follow any.
        return found(*task_of(every, self._without_gaps(plan, self._triples(poses, every, self._model))))

    def _step_prices(self, plan: SearchPlan, steps: StepPairs) -> FloatArray | None:
        """Return what each step costs where it begins, beside the scores, shape (n_input, n_steps); None: nothing."""
        evenness, keep_flights = plan.request.evenness, plan.request.keep_flights
        if not evenness and not keep_flights:
            return None
        return tempo_prices(self.tempo, plan.reduction, steps, evenness=evenness, keep_flights=keep_flights)

    def _smoothness_unit(self) -> float | None:
        """Return what a weight of 1 on changes of log-speed charges; None: the median score."""
        return None

    def _is_neutral(self, plan: SearchPlan, free_weight: str) -> bool:
        """Whether scores are weighed so that a free length treats both clocks alike."""
        return plan.request.free and free_weight == "neutral" and not self.paper

    def _loosened(self, plan: SearchPlan, scores: FloatArray, poses: FloatArray) -> tuple[StepPairs, FloatArray]:
        """Return a copy of the scores in which, at loose frames, any step may follow any."""
        limited, every = plan.steps, StepPairs.of(plan.steps.steps)
        if not plan.loose or limited.n_pairs == every.n_pairs:
            return limited, scores.copy()
        costs = np.full((len(scores), every.n_pairs), np.inf)
        costs[:, every.pair_of(limited.steps[limited.before], limited.steps[limited.after])] = scores
        for frame in plan.loose:
            begin, end = max(0, frame - every.longest), min(len(poses), frame + every.longest + 1)
            costs[frame] = self._triples(poses[begin:end], every, self._model)[frame - begin]
        return every, self._without_gaps(plan, costs)

    def _find(self, task: PathTask, poses: FloatArray, neutral: bool) -> tuple[FramePath, float | None]:
        """Find the path by the method that is asked for; of the heuristic also its excess."""
        plan = task.plan
        if task.search == "heuristic":
            every = max(1, round(self.rate / COARSE_RATE))

            def coarse_scores(frames: IntArray, max_skip: int) -> FloatArray:
                coarse = self._tracks.at(plan.reduction.input_times[frames], self.low_pass)
                steps = StepPairs.up_to(max_skip)
                scores = self._triples(coarse, steps, self._coarse_model(self.rate / every))
                request = plan.request
                if request.evenness > 0 or request.keep_flights > 0:
                    prices = tempo_prices(
                        self.tempo,
                        coarse_reduction(plan.reduction, frames, every),
                        steps,
                        evenness=request.evenness,
                        keep_flights=request.keep_flights,
                    )
                    scores += prices[:, steps.after]
                return scores.reshape(-1, max_skip, max_skip)

            return heuristic_path(replace(task, search="priced"), every, coarse_scores, slack=self.slack)
        if not plan.request.loop:
            return exact_path(task), None
        seam = self._seam_costs(task, poses)
        if neutral:
            upsamples = plan.reduction.upsamples
            weights = neutral_weights(StepPairs.up_to(plan.max_skip), upsamples[-1], upsamples[0])
            seam = seam * np.diagonal(weights.reshape(plan.max_skip, plan.max_skip))[task.steps.steps - 1]
        return loop_path(task, seam), None

    @property
    def tempo(self) -> Tempo:
        """How much the input moves, and when it flies."""
        if self._tempo is None:
            poses = self._tracks.at_rate(self.rate, self.low_pass)
            flights = flights_of(self.clips) if self._flights is None else self._flights
            self._tempo = tempo_of(poses, self.rate, self.time_scale, flights)
        return self._tempo

    def _curve(self, plan: SearchPlan, reduction: Reduction, path: FramePath, chosen: dict[str, Any]) -> FinishedCurve:
        """Put the path on its keytimes, smooth it, mix it with the spline, and look whether it keeps its promises."""
        request = plan.request
        share = as_shares(chosen["influence"], "influence")
        mixed = bool(share.ndim or share != 1.0)
        # A window of one frame averages nothing.
        window = 0.0 if chosen["smoothing"] in (0, 1) else chosen["smoothing"] / self.rate
        rate = float(self.motion.rate)
        if not request.wishes.any and not request.loop:
            bounds = speed_bounds(reduction, path.frames, plan.max_skip)
            staircase = knots_of_path(reduction, path.frames, bounds=bounds)
            keep = staircase.output_times[self._flight_ends(plan, reduction, path.frames)]
            warp = smooth_steps(staircase, window, rate, keep=keep)
            if mixed:
                warp = blend(spline_warp(reduction.keytimes, rate=rate), warp, share)
            given_up: tuple[str, ...] = ()
        else:
            promised = promised_curve(
                reduction,
                path.frames,
                request.wishes,
                plan.locked,
                plan.max_skip,
                motion_rate=rate,
                loop=request.loop,
            )
            staircase, given_up = promised.staircase, promised.given_up
            edges = np.array([stretch.end for stretch in promised.stretches])
            flights = promised.position_times[self._flight_ends(plan, reduction, path.frames)]
            warp = smooth_steps(staircase, window, rate, keep=np.concatenate([edges, flights]), loop=request.loop)
            if mixed:
                warp = mixed_within(spline_within(warp, promised.stretches, rate), warp, share, promised.stretches)
        warp = replace(warp, method="guided", keytimes=reduction.keytimes)
        check_promises(warp, request.wishes, loop=request.loop, given_up=given_up)
        return FinishedCurve(staircase, warp, given_up)

    def _flight_ends(self, plan: SearchPlan, reduction: Reduction, frames: IntArray) -> IntArray:
        """List the places in a path where flights at unit speed begin and end: smoothing must not reach across."""
        if not plan.request.keep_flights or not self.tempo.flights:
            return np.zeros(0, dtype=np.int64)
        flying = self.tempo.flying(reduction.input_times[frames]) > 0
        unit = np.diff(frames) == reduction.upsample_at[frames[:-1]]
        aloft = np.concatenate([[False], unit & flying[:-1] & flying[1:], [False]])
        return np.flatnonzero(aloft[1:] != aloft[:-1])

    def _triples(self, poses: FloatArray, steps: StepPairs, model: Model) -> FloatArray:
        return triple_scores(poses, model, steps=steps, n_neighbors=self.n_neighbors, score=self.score)

    def _unrolled(self, plan: SearchPlan) -> FloatArray:
        """Pose vectors of the unrolled input, shape (n_input, n_numbers)."""
        times = plan.reduction.input_times
        if self._poses is None or not np.array_equal(self._poses[0], times):
            # Let go of the old ones before the new ones take their memory.
            self._poses = None
            self._poses = times, self._tracks.at(times, self.low_pass)
        return self._poses[1]

    def _scores(self, plan: SearchPlan) -> FloatArray:
        """Scores of the unrolled input; kept, for little of it changes while keytimes are dragged."""
        table = self._tables.scores(
            plan.reduction,
            plan.steps,
            lambda: self._unrolled(plan),
            lambda some, steps: self._triples(some, steps, self._model),
        )
        return self._without_gaps(plan, table.of(plan.steps))

    def _without_gaps(self, plan: SearchPlan, scores: FloatArray) -> FloatArray:
        """Let frames of gaps weigh nothing: each of their steps scores what it does elsewhere, on average.

        A score of 0 would not be nothing: the path would stay where nothing is known, as that costs least.
        """
        if not self._tracks.has_gaps:
            return scores
        lost = self._tracks.missing_at(plan.reduction.input_times)
        known = np.isfinite(scores) & ~lost[:, None]
        sums = np.where(known, scores, 0.0).sum(axis=0)
        usual = np.divide(sums, known.sum(axis=0), out=np.zeros_like(sums), where=known.any(axis=0))
        return np.where(lost[:, None] & np.isfinite(scores), usual, scores)

    def _nothing_left_out_of_gaps(self, plan: SearchPlan, steps: StepPairs, prices: FloatArray) -> FloatArray:
        """Let frames of gaps weigh nothing in the price on what is left out: such steps cost what they do elsewhere."""
        if not self._tracks.has_gaps:
            return prices
        before = np.concatenate([[0], np.cumsum(self._tracks.missing_at(plan.reduction.input_times))])
        ends = np.minimum(np.arange(len(prices))[:, None] + steps.steps + 1, len(prices))
        lost = before[ends] > before[: len(prices), None]
        sums, known = np.where(lost, 0.0, prices).sum(axis=0), (~lost).sum(axis=0)
        return np.where(lost, np.divide(sums, known, out=np.zeros_like(sums), where=known > 0), prices)

    def _seam_costs(self, task: PathTask, poses: FloatArray) -> FloatArray:
        """Score the triple across a loop's seam, where the last frame is the first again; shape (n_steps,)."""
        steps = task.steps.steps
        reach = min(task.plan.max_skip, task.plan.reduction.n_input - 1)
        around = np.concatenate([poses[len(poses) - 1 - reach : -1], poses[: reach + 1]])
        costs = np.full(len(steps), np.inf)
        near = steps <= reach
        same = StepPairs.of(steps[near], ratio=1.0)
        costs[near] = self._triples(around, same, self._model)[reach]
        return costs

    def _coarse_model(self, rate: float) -> Model:
        """Return the references as the heuristic's coarse search sees them."""
        try:
            return self._model_at(rate)
        except OptionError:
            # There are frames enough at the analysis rate, or this would not be reached.
            raise OptionError(
                f"too few frames for the heuristic search, which looks at {rate:g} Hz first: take search='priced' "
                "(--search priced)",
                option="search",
            ) from None

    def _model_at(self, rate: float) -> Model:
        """Return the references as they are seen at a rate."""
        if rate not in self._models:
            every = build_model(
                [track.at_rate(rate, self.low_pass) for track in self._reference_tracks],
                rate=rate,
                # The paper's features count in frames: at a lower rate its time scale is as much longer.
                time_scale=self.time_scale if rate == self.rate else self.time_scale * self.rate / rate,
                n_neighbors=self.n_neighbors,
                weights=[track.weight for track in self._reference_tracks],
                own_name=self._own_name,
            )
            every = self._without_lost(every, rate)
            if self._match_tempo and not self.itself:
                own = self._tracks.at_rate(rate, self.low_pass) - every.origin
                time_scale = self.time_scale if rate == self.rate else self.time_scale * self.rate / rate
                if len(own) > 2:
                    features = timing_features(own, rate=rate, time_scale=time_scale)
                    self.tempo_ratio = tempo_ratio(features, every)
                    every = at_tempo(every, self.tempo_ratio)
            self._models[rate] = without_copies(every, self.n_neighbors)
        return self._models[rate]

    def _without_lost(self, model: Model, rate: float) -> Model:
        """Leave out frames of references of which something is lost, and those whose speed would be told by one."""
        lost = np.zeros(len(model.weights), dtype=bool)
        for place, track in enumerate(self._reference_tracks):
            if track.has_gaps:
                rows = np.flatnonzero(model.reference == place)
                for beside in (-1, 0, 1):
                    lost[rows] |= track.missing_at((model.frame[rows] + beside) / rate)
        if not lost.any():
            return model
        if len(lost) - lost.sum() < self.n_neighbors:
            raise OptionError("too few frames of the reference are without gaps: bridge them (--gaps bridge:SECONDS)")
        return model.only(np.flatnonzero(~lost))


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


def flights_of(clips: Sequence[AnyMotion]) -> list[tuple[float, float]]:
    """Find the flights of clips that move together: start and end of each, seconds, in the order of time."""
    return sorted(
        (first / float(clip.rate), last / float(clip.rate))
        for clip in clips
        if isinstance(clip, Motion)
        for first, last in clip.flights()
    )


def _read_flights(flights: Sequence[Sequence[float | str]], motion: AnyMotion) -> list[tuple[float, float]]:
    """Read flights, as two times each."""
    found = []
    for flight in flights:
        if isinstance(flight, str) or len(flight) != 2:
            raise OptionError(f"a flight is (start, end), in input time; found {flight!r}", option="flights")
        start, end = (parse_time(time, motion.rate) for time in flight)
        if not 0 <= start < end <= motion.duration:
            raise OptionError(
                f"a flight from {start:g} to {end:g} s is no stretch of the clip, which ends at {motion.end_time:g} s",
                option="flights",
            )
        found.append((start, end))
    return found


def _read_locks(locks: Sequence[Lock | str], rate: Fraction) -> tuple[Lock, ...]:
    """Read locks where they are text; refuse what is none."""
    if (
        isinstance(locks, Lock | str)
        or not isinstance(locks, Sequence)
        or not all(isinstance(one, Lock | str) for one in locks)
    ):
        raise OptionError(
            f"locks are a sequence of Lock, as in locks=[Lock(6.12, 6.52)]; found {kind_of(locks)}", option="locks"
        )
    return tuple(_lock(lock, i, rate) for i, lock in enumerate(locks))


def _lock(lock: Lock | str, item: int, rate: Fraction) -> Lock:
    """Read a lock where it is text."""
    if not isinstance(lock, str):
        return lock
    try:
        return Lock(*read_lock(lock).at(rate))
    except OptionError as error:
        raise OptionError(str(error), option="locks", item=item) from None


@dataclass(frozen=True, eq=False)
class FoundPath:
    """What a search found.

    Attributes
    ----------
    path : FramePath
        The path.
    excess : float, optional
        By how much the heuristic's path exceeds the optimum; None of an exact search.
    tempo_prices : float array, shape (n_input, n_steps), optional
        Prices on tempo; None: there were none.
    end_costs : (float, float)
        What the first and the last step cost.
    """

    path: FramePath
    excess: float | None
    tempo_prices: FloatArray | None
    end_costs: tuple[float, float]

    __repr__ = brief_repr


@dataclass(frozen=True)
class FinishedCurve:
    """A warp, the staircase that it was before smoothing and mixing, and what it could not keep."""

    staircase: Warp
    warp: Warp
    given_up: tuple[str, ...]


def check_promises(warp: Warp, wishes: Wishes, *, loop: bool, given_up: Sequence[str]) -> None:
    """Look at a result once more before it is handed on; say what it does not keep.

    Warns
    -----
    RetimeWarning
        Something had to be given up, by no more than lengths and times are rounded.

    Raises
    ------
    InfeasibleWarpError
        Something is not kept, and nobody said so.
    """
    broken = broken_promises(
        warp, warp.keytimes, locks=wishes.locks, slowest=wishes.slowest, fastest=wishes.fastest, loop=loop
    )
    unsaid = [one for one in broken if not given_up or one.kind in ("key", "length", "direction")]
    if unsaid:
        raise InfeasibleWarpError(
            f"no curve was found that keeps {'; '.join(map(str, unsaid))}. Loosen one of the wishes there, or move a "
            "keytime",
            output_times=(unsaid[0].start, unsaid[0].end),
        )
    for words in given_up:
        warnings.warn(f"not quite kept {words}", RetimeWarning, stacklevel=4)


class Clock:
    """Measures the stages of a job."""

    def __init__(self) -> None:
        self._last = time.perf_counter()

    def lap(self) -> float:
        """Return the seconds since the last lap."""
        now = time.perf_counter()
        lap, self._last = now - self._last, now
        return lap
