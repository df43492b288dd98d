"""A motion prepared for retiming: analysed once, solved as often as its keytimes move.

Features, reference model and scores depend on the clips, not on the keytimes, as long as the input is unrolled
alike: a session keeps them, so that only the search runs again when a keytime is dragged.
"""

from __future__ import annotations

import hashlib
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray, IntArray
from retime.brief import brief_repr
from retime.errors import InfeasibleWarpError, RetimeWarning
from retime.kernels import StepPairs, n_threads
from retime.motion.any_motion import AnyMotion
from retime.motion.first_frames import hint_at_first_frames
from retime.motion.group_clock import hint_at_clocks
from retime.motion.motion import Motion
from retime.motion.rate import parse_rate
from retime.motion.size import extent
from retime.search import options
from retime.search.content import content_prices
from retime.search.estimate import check_fits, content_seconds, layered_seconds, loop_seconds, score_seconds
from retime.search.finished_curve import finish_curve
from retime.search.gap_scores import content_without_gaps, scores_without_gaps
from retime.search.inputs import as_clips, as_references, check_rates
from retime.search.keytimes import asking_for_a_share, refuse_single_frame
from retime.search.methods.exact import PathTask, exact_path
from retime.search.methods.heuristic import COARSE_RATE, SLACK, coarse_reduction, heuristic_path
from retime.search.methods.loop import loop_path
from retime.search.own_timing import own_timing_costs
from retime.search.path import FramePath
from retime.search.plan import SHORTER, Request, SearchPlan, make_plan
from retime.search.poses.references import Reference, model_poses
from retime.search.reference_models import ReferenceModels
from retime.search.requests import read_flights, read_request
from retime.search.result import GuidedWarp
from retime.search.score import Model, ScoreName, triple_scores
from retime.search.score_table import ScoreTables
from retime.search.stage_clock import StageClock
from retime.search.wishes.allowed import forbid
from retime.search.wishes.locks import Lock
from retime.search.wishes.prices import (
    add_after,
    add_smoothness,
    among_every,
    end_prices,
    neutral_weights,
    weigh_neutral,
)
from retime.search.wishes.tempo import Tempo, chosen_weights, flights_of, tempo_of, tempo_prices

DEFAULT_RATE = 30
# Frames in which most clips show already that something changes.
_FEW_FRAMES = 1024
# Frames at which any step may follow any, whose scores are kept: more than a document has keytimes, mostly.
_LOOSE_KEPT = 256


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
        clock = StageClock()
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
        poses = model_poses(
            self.clips, () if self.itself else as_references(reference, len(self.clips), rate), features
        ).in_own_order()
        self._tracks, self._reference_tracks = poses.input, poses.references
        self.references = tuple(track.name for track in self._reference_tracks)
        self._own_name = self._tracks.name if self.itself else ""
        self._models = ReferenceModels(
            self._reference_tracks,
            alike=self._tracks if chosen["match_tempo"] and not self.itself else None,
            rate=self.rate,
            time_scale=self.time_scale,
            low_pass=self.low_pass,
            n_neighbors=self.n_neighbors,
            own_name=self._own_name,
        )
        self.n_reference = sum(track.count_at(self.rate) for track in self._reference_tracks)
        self._model = self._models.at(self.rate)
        # How many times as fast the input moves as its reference, where that was asked for; else 1.
        self.tempo_ratio = self._models.tempo_ratio
        self._warn_of_sameness()
        # How the heuristic is read: as a band so wide about its coarse path, or (None) as keytimes.
        self.slack: int | None = SLACK
        self._tables = ScoreTables()
        # Scores of frames at which any step may follow any, by the poses around them.
        self._loose_rows: dict[tuple[bytes, bytes, int, int], FloatArray] = {}
        # The input as it was unrolled last: its times, and its poses.
        self._poses: tuple[FloatArray, FloatArray] | None = None
        self._tempo: Tempo | None = None
        self._flights = None if flights is None else read_flights(flights, self.motion)
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
        clock = StageClock()
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
        tempo = self.tempo if request.keep_flights else None
        curve = finish_curve(plan, reduction, path, chosen, analysis_rate=self.rate, tempo=tempo)
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
        evenness, keep_flights = chosen_weights(
            self.clips, chosen["evenness"], chosen["keep_flights"], itself=self.itself, paper=self.paper
        )
        return read_request(
            self.motion, keys, locks, chosen, itself=self.itself, evenness=evenness, keep_flights=keep_flights
        )

    def _search(self, plan: SearchPlan, scores: FloatArray, poses: FloatArray, chosen: dict[str, Any]) -> FoundPath:
        """Put prices on scores, and find the path."""
        neutral = self._is_neutral(plan, chosen["free_weight"])

        def task_of(steps: StepPairs, costs: FloatArray) -> tuple[PathTask, FloatArray | None]:
            add_smoothness(costs, chosen["smoothness"], plan.reduction, steps, unit=self._smoothness_unit())
            if chosen["own_timing"]:
                own = own_timing_costs(poses, plan.reduction, steps, self._model)
                costs += chosen["own_timing"] * scores_without_gaps(self._tracks, plan.reduction, own)
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
                left_out = content_without_gaps(self._tracks, plan.reduction, steps, left_out)
                add_after(costs, left_out, steps)
                first = first + left_out[0]
            if tempo is not None:
                add_after(costs, tempo, steps)
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
        return found(
            *task_of(every, scores_without_gaps(self._tracks, plan.reduction, self._triples(poses, every, self._model)))
        )

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
        costs = among_every(scores, limited, every)
        for frame in plan.loose:
            begin, end = max(0, frame - every.longest), min(len(poses), frame + every.longest + 1)
            costs[frame] = self._loose_scores(poses[begin:end], every, frame - begin)
        return every, scores_without_gaps(self._tracks, plan.reduction, costs)

    def _loose_scores(self, around: FloatArray, every: StepPairs, frame: int) -> FloatArray:
        """Score the triples in the middle of few frames; kept, for a keytime that is dragged shows the same pose long.

        To score a single frame takes as long as to make the reference ready: a fifth of a whole search.
        """
        key = hashlib.blake2b(around.tobytes()).digest(), every.steps.tobytes(), len(around), frame
        known = self._loose_rows.pop(key, None)
        if known is None:
            known = self._triples(around, every, self._model)[frame]
        # The last one asked for stands last.
        self._loose_rows[key] = known
        while len(self._loose_rows) > _LOOSE_KEPT:
            del self._loose_rows[next(iter(self._loose_rows))]
        return known

    def _find(self, task: PathTask, poses: FloatArray, neutral: bool) -> tuple[FramePath, float | None]:
        """Find the path by the method that is asked for; of the heuristic also its excess."""
        plan = task.plan
        if task.search == "heuristic":
            every = max(1, round(self.rate / COARSE_RATE))

            def coarse_scores(frames: IntArray, max_skip: int) -> FloatArray:
                coarse = self._tracks.at(plan.reduction.input_times[frames], self.low_pass)
                steps = StepPairs.up_to(max_skip)
                scores = self._triples(coarse, steps, self._models.coarse(self.rate / every))
                request = plan.request
                if request.evenness > 0 or request.keep_flights > 0:
                    prices = tempo_prices(
                        self.tempo,
                        coarse_reduction(plan.reduction, frames, every),
                        steps,
                        evenness=request.evenness,
                        keep_flights=request.keep_flights,
                    )
                    add_after(scores, prices, steps)
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
        return scores_without_gaps(self._tracks, plan.reduction, table.of(plan.steps))

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
