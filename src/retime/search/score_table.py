"""Scores that outlive a drag: when a keytime moves, the rows whose frames stay the same are not scored again."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr
from retime.kernels import StepPairs
from retime.limits import MAX_STEP
from retime.search.reduction import Reduction, nearest_frame

# The most scores of a table that is made larger than needed, so that it need not grow soon.
_MOST_SPARE = 20_000_000


@dataclass(frozen=True, eq=False)
class ScoreTable:
    """The scores of an unrolled input.

    Attributes
    ----------
    reduction : Reduction
        What was unrolled.
    steps : StepPairs
        The pairs of steps that are scored.
    scores : float array, shape (n_input, n_pairs)
        As `retime.search.score.triple_scores` gives them.
    poses : float array, shape (n_input, n_numbers)
        Of the unrolled input.
    """

    reduction: Reduction
    steps: StepPairs
    scores: FloatArray
    poses: FloatArray

    __repr__ = brief_repr

    def serves(self, reduction: Reduction, steps: StepPairs) -> bool:
        """Whether it holds these scores."""
        return self._places(steps) is not None and np.array_equal(self.reduction.input_times, reduction.input_times)

    def of(self, steps: StepPairs) -> FloatArray:
        """Return the scores of pairs of steps, all of which it holds; shape (n_input, n_pairs)."""
        return self.rows(0, len(self.scores), steps)

    def rows(self, first: int, last: int, steps: StepPairs) -> FloatArray:
        """Return the scores of pairs of steps in some rows."""
        places = self._places(steps)
        assert places is not None
        rows = self.scores[first:last]
        return rows if np.array_equal(places, np.arange(self.steps.n_pairs)) else np.ascontiguousarray(rows[:, places])

    def holds(self, steps: StepPairs) -> bool:
        """Whether all pairs of steps are scored."""
        return self._places(steps) is not None

    def _places(self, steps: StepPairs) -> IntArray | None:
        """Places of pairs of steps among its own; None where it lacks one."""
        places = self.steps.pair_of(steps.steps[steps.before], steps.steps[steps.after])
        return None if np.any(places < 0) else places

    def next_steps(self, steps: StepPairs) -> StepPairs:
        """Choose the steps of the table that follows, which must have `steps` and should not grow often."""
        # A list of steps changes with what is wished for, and seldom; what grows as a key is dragged is their number.
        if not (steps.every and self.steps.every):
            return steps
        max_skip, longest = steps.longest, self.steps.longest
        if max_skip <= longest:
            return self.steps if longest <= 1.5 * max_skip else steps
        grown = min(MAX_STEP, max_skip + max_skip // 4)
        return StepPairs.up_to(grown) if self.reduction.n_input * grown**2 <= _MOST_SPARE else steps


def score_table(
    reduction: Reduction,
    steps: StepPairs,
    poses: FloatArray,
    score: Callable[[FloatArray], FloatArray],
    before: ScoreTable | None,
) -> ScoreTable:
    """Score an unrolled input; take from another table of the same clip the rows that it has already.

    A row's scores depend on the frames up to the longest step before and after it, and on nothing else: inside a span
    they are the same wherever the span's ends are.

    Parameters
    ----------
    reduction : Reduction
        What is unrolled.
    steps : StepPairs
        The pairs of steps to score.
    poses : float array, shape (n_input, n_numbers)
        Of the unrolled input.
    score : function
        Scores some consecutive poses: shape (n, n_pairs).
    before : ScoreTable, optional
        Made with the same `score`.
    """
    n_input, longest = len(poses), steps.longest
    kept = [] if before is None or not before.holds(steps) else list(_same_rows(reduction, before.reduction, longest))
    missing = np.ones(n_input, dtype=bool)
    for first, last, _ in kept:
        missing[first:last] = False
    if before is None or missing.sum() > n_input // 2:
        return ScoreTable(reduction, steps, score(poses), poses)
    scores = np.empty((n_input, steps.n_pairs))
    for first, last, other in kept:
        scores[first:last] = before.rows(other, other + last - first, steps)
    for first, last in _runs(missing):
        begin, end = max(0, first - longest), min(n_input, last + longest)
        scores[first:last] = score(poses[begin:end])[first - begin : last - begin]
    return ScoreTable(reduction, steps, scores, poses)


@dataclass(frozen=True)
class _Stretch:
    """A moving span. Its ends at inner keytimes, which may lie between two grids, are left out.

    Places are counted along its direction, on its own grid: `place` is that of the unrolled frame `first`.
    """

    grid: tuple[int, int]
    place: int
    first: int
    length: int
    opens: bool
    closes: bool


def _same_rows(new: Reduction, old: Reduction, max_skip: int) -> Iterator[tuple[int, int, int]]:
    """Yield ranges of unrolled frames that had the same neighbours in an older input, and their places there."""
    for ours, theirs in itertools.product(_stretches(new), _stretches(old)):
        ends = ours.place + ours.length, theirs.place + theirs.length
        begin, end = max(ours.place, theirs.place), min(ends)
        # Where both inputs begin, or end, there is no frame beyond on which a score could depend.
        if not (ours.opens and theirs.opens and ours.place == theirs.place):
            begin += max_skip
        if not (ours.closes and theirs.closes and ends[0] == ends[1]):
            end -= max_skip
        if ours.grid == theirs.grid and begin < end:
            yield ours.first + begin - ours.place, ours.first + end - ours.place, theirs.first + begin - theirs.place


def _stretches(reduction: Reduction) -> Iterator[_Stretch]:
    n_spans = len(reduction.upsamples)
    for span, (before, after) in enumerate(itertools.pairwise(reduction.keytimes)):
        if reduction.still[span]:
            continue
        opens, closes = span == 0, span == n_spans - 1
        upsample, direction = reduction.upsamples[span], 1 if after.input_time > before.input_time else -1
        place = direction * nearest_frame(before.input_time * reduction.rate * upsample)
        first, last = reduction.frames[span], reduction.frames[span + 1]
        left_out = 0 if opens else 1
        length = last - first - left_out + (1 if closes else 0)
        yield _Stretch((upsample, direction), place + left_out, first + left_out, length, opens, closes)


def _runs(missing: BoolArray) -> Iterator[tuple[int, int]]:
    """Yield the ranges that are marked."""
    edges = np.flatnonzero(np.diff(missing.astype(np.int8), prepend=0, append=0))
    yield from zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)
