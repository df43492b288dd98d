"""Why a warp is as it is: what each output frame scored, what it was matched with, and what held it back."""

from __future__ import annotations

import bisect
import csv
import io
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.errors import MissingExtraError
from retime.search.explain_picture import explanation_html
from retime.search.path import FramePath
from retime.search.reduction import Reduction
from retime.search.score import Model, ScoreName, distances_to, matched_frames
from retime.search.wishes.locks import LockedSpan

if TYPE_CHECKING:
    import pandas as pd


# What can bind a frame, in the order in which it is told.
BINDINGS = ("key", "tangent", "hold", "lock", "flight", "even", "fastest", "slowest")


@dataclass(frozen=True, eq=False)
class Explanation:
    """One row for each output frame at the analysis rate.

    Attributes
    ----------
    output_times, input_times : float arrays, shape (n_output,)
        Seconds, on the analysis grid.
    speeds : float array, shape (n_output,)
        Playback speed of the step from this frame to the next; the last one repeats.
    scores : float array, shape (n_output,)
        Local score (Eq. 2): the mean distance to the matched reference frames. nan at the two ends, which have none.
    costs : float array, shape (n_output,)
        What the search paid for the frame: the score, weighted where a free length is neutral, the charge for a
        change of speed where smoothness is asked for, and the prices of the step to the next frame. At the ends what
        the first and the last step cost by themselves, nan where that is nothing. All of them and `seam_cost` add up
        to the total.
    tempo_costs : float array, shape (n_output,)
        Of these the price of the step from this frame to the next: what evenness and kept flights charged. 0 where
        there is none.
    references : int array, shape (n_output, n_neighbors)
        Which reference each match is from, the nearest first; -1 at the ends.
    reference_times : float array, shape (n_output, n_neighbors)
        Its time there, seconds; nan at the ends.
    binding : tuple of str
        What bound the frame, or a step beside it, joined by "+": "key", a keytime; "tangent", its speed; "lock", a
        lock's speed or its ends; "fastest" and "slowest", the speed limits (of `max_skip` and `upsample` where none
        are given); "hold"; "flight", which keeps its own speed; "even", hurried as what moves beside it, at a price
        above its score. "" where nothing did.
    reference_names : tuple of str
        Names of the references.
    seam_cost : float
        What a loop paid for the three frames across its seam; 0 where it is none.
    """

    output_times: FloatArray
    input_times: FloatArray
    speeds: FloatArray
    scores: FloatArray
    costs: FloatArray
    tempo_costs: FloatArray
    references: IntArray
    reference_times: FloatArray
    binding: tuple[str, ...]
    reference_names: tuple[str, ...]
    seam_cost: float = 0.0

    def __repr__(self) -> str:
        bound = sorted({word for words in self.binding for word in words.split("+") if word})
        scores = self.scores[np.isfinite(self.scores)]
        mean = f"mean score {scores.mean():.4g}" if len(scores) else "no scores"
        return f"Explanation({len(self.output_times)} output frames, {mean}, binding: {', '.join(bound) or 'nothing'})"

    def _repr_html_(self) -> str:
        return explanation_html(self.output_times, self.scores, self.binding, self.reference_names)

    def to_frame(self) -> pd.DataFrame:
        """Return a pandas table: one row an output frame, with the columns of `to_csv`.

        Raises
        ------
        MissingExtraError
            pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError as error:
            raise MissingExtraError("a table of an explanation", package="pandas", extra="pandas") from error
        columns: dict[str, object] = {
            "output_time": self.output_times,
            "input_time": self.input_times,
            "speed": self.speeds,
            "score": self.scores,
            "cost": self.costs,
            "tempo_cost": self.tempo_costs,
        }
        names = np.array([*self.reference_names, ""], dtype=object)
        for i in range(self.references.shape[1]):
            # Frames without a match have -1, which is the last name.
            columns[f"reference_{i + 1}"] = names[self.references[:, i]]
            columns[f"reference_time_{i + 1}"] = self.reference_times[:, i]
        columns["binding"] = list(self.binding)
        return pd.DataFrame(columns)

    def to_csv(self) -> str:
        """Return a table with a header: one row an output frame, one pair of columns a matched reference frame."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        n_neighbors = self.references.shape[1]
        matches = [f"{what}_{i + 1}" for i in range(n_neighbors) for what in ("reference", "reference_time")]
        writer.writerow(["output_time", "input_time", "speed", "score", "cost", "tempo_cost", *matches, "binding"])
        for i in range(len(self.output_times)):
            row: list[str] = [f"{value:.6f}" for value in (self.output_times[i], self.input_times[i], self.speeds[i])]
            row += [
                "" if np.isnan(value) else f"{value:.6g}"
                for value in (self.scores[i], self.costs[i], self.tempo_costs[i])
            ]
            for which, when in zip(self.references[i], self.reference_times[i], strict=True):
                row += ["", ""] if which < 0 else [self.reference_names[which], f"{when:.6f}"]
            writer.writerow([*row, self.binding[i]])
        return out.getvalue()


def explain_path(
    reduction: Reduction,
    path: FramePath,
    model: Model,
    input_poses: FloatArray,
    allowed: BoolArray,
    *,
    locked: Sequence[LockedSpan],
    references: tuple[str, ...],
    n_neighbors: int,
    score: ScoreName,
    step_prices: FloatArray | None = None,
    flying: BoolArray | None = None,
    matched: IntArray | None = None,
    end_costs: tuple[float, float] = (0.0, 0.0),
) -> Explanation:
    """Explain a path; the parameters are the fields of `retime.search.result.GuidedWarp`.

    `step_prices`, shape (n_output - 1,), is what the price on tempo charged each step of the path; `flying`, of
    the same shape, says which of them pass a flight that is to keep its speed; `end_costs` is what the first and the
    last step cost by themselves.
    """
    frames = path.frames
    n_output = len(frames)
    which = np.full((n_output, n_neighbors), -1, dtype=np.int64)
    when = np.full((n_output, n_neighbors), np.nan)
    scores = np.full(n_output, np.nan)
    ends = [cost or math.nan for cost in end_costs]
    costs = np.concatenate([ends[:1], path.scores, ends[1:]])
    if n_output > 2:
        if matched is None:
            rows, distances = matched_frames(input_poses, frames, model, n_neighbors=n_neighbors, score=score)
        else:
            rows, distances = matched[:, None], distances_to(input_poses, frames, model, matched)[:, None]
        which[1:-1] = model.reference[rows]
        when[1:-1] = model.frame[rows] / reduction.rate
        scores[1:-1] = distances.mean(axis=1)
    input_times = reduction.input_times[frames]
    speeds = np.diff(input_times) * reduction.rate
    prices = np.zeros(n_output - 1) if step_prices is None else step_prices
    seam_cost = path.total - math.fsum([*path.scores, *end_costs])
    binding = _binding(reduction, frames, allowed, locked)
    if step_prices is not None and flying is not None:
        binding = _with_tempo(binding, reduction, frames, scores, prices, flying)
    return Explanation(
        reduction.keytimes[0].output_time + np.arange(n_output) / reduction.rate,
        input_times,
        np.append(speeds, speeds[-1:]),
        scores,
        costs,
        np.append(prices, 0.0),
        which,
        when,
        binding,
        references,
        # The total is summed in another order, so without a seam the difference is not 0 but a rounding.
        seam_cost if seam_cost > 1e-11 * path.total else 0.0,
    )


def _binding(
    reduction: Reduction, frames: IntArray, allowed: BoolArray, locked: Sequence[LockedSpan]
) -> tuple[str, ...]:
    """Say what bound each frame: the steps beside it at the end of what was allowed, or a keytime."""
    tangents = {frame for key, frame in zip(reduction.keytimes, reduction.frames, strict=True) if key.speed is not None}
    held = reduction.held
    limits = []
    for first, last in itertools.pairwise(reduction.frames):
        anywhere = np.flatnonzero(allowed[first:last].any(axis=0)) + 1
        limits.append((int(anywhere[0]), int(anywhere[-1])))

    def words(start: int, stop: int) -> set[str]:
        if held[start]:
            return {"hold"}
        if start in tangents or stop in tangents:
            return {"tangent"}
        step = stop - start
        choices = np.flatnonzero(allowed[start]) + 1
        following = bisect.bisect_right(reduction.frames, start)
        room = reduction.frames[following] - start
        (slowest, fastest), upsample = limits[following - 1], reduction.upsamples[following - 1]
        inside = any(span.first <= start and stop <= span.last for span in locked)
        found = set()
        # Where a keytime is near, a step ends there at the latest; that is the key's doing, not a limit's.
        if step == choices[-1] and not (step == room < fastest and not inside):
            found.add("fastest" if step == fastest else "lock")
        if step == choices[0] and (upsample > 1 or step > 1) and not (len(choices) == 1 and room == step):
            found.add("slowest" if step == slowest else "lock")
        return {"lock"} if inside and len(choices) == 1 else found

    steps = [words(start, stop) for start, stop in itertools.pairwise(frames.tolist())]
    bound = []
    for position in range(len(frames)):
        found = set().union(*steps[max(position - 1, 0) : position + 1])
        if position in reduction.positions:
            found.add("key")
        bound.append("+".join(word for word in BINDINGS if word in found))
    return tuple(bound)


def _with_tempo(
    binding: tuple[str, ...],
    reduction: Reduction,
    frames: IntArray,
    scores: FloatArray,
    prices: FloatArray,
    flying: BoolArray,
) -> tuple[str, ...]:
    """Add to what bound each frame whether the price on tempo did: by a flight, or by more than the frame's score."""
    unit = np.diff(frames) == reduction.upsample_at[frames[:-1]]
    kept = unit & flying
    score = np.where(np.isnan(scores[:-1]), np.inf, scores[:-1])
    even = ~unit & (prices > score)
    found = []
    for position, words in enumerate(binding):
        beside = slice(max(position - 1, 0), position + 1)
        more = {"flight"} if kept[beside].any() else set()
        more |= {"even"} if even[beside].any() else set()
        all_of_them = more | set(words.split("+"))
        found.append("+".join(word for word in BINDINGS if word in all_of_them))
    return tuple(found)
