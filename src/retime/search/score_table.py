"""Scores that outlive a drag: when a keytime moves, the rows whose frames stay the same are not scored again."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from retime.arrays import BoolArray, FloatArray
from retime.brief import brief_repr
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
    max_skip : int
        Largest step.
    scores : float array, shape (n_input, max_skip, max_skip)
        As `retime.search.score.triple_scores` gives them.
    poses : float array, shape (n_input, n_numbers)
        Of the unrolled input.
    """

    reduction: Reduction
    max_skip: int
    scores: FloatArray
    poses: FloatArray

    __repr__ = brief_repr

    def serves(self, reduction: Reduction, max_skip: int) -> bool:
        """Whether it holds these scores."""
        return max_skip <= self.max_skip and np.array_equal(self.reduction.input_times, reduction.input_times)

    def up_to(self, max_skip: int) -> FloatArray:
        """Return the scores of steps no longer than `max_skip`."""
        return np.ascontiguousarray(self.scores[:, :max_skip, :max_skip])

    def next_skip(self, max_skip: int) -> int:
        """Choose the longest step of the next table: `max_skip` or more, so that tables are not made anew too often."""
        if max_skip <= self.max_skip:
            return self.max_skip if self.max_skip <= 1.5 * max_skip else max_skip
        grown = min(MAX_STEP, max_skip + max_skip // 4)
        return grown if self.reduction.n_input * grown**2 <= _MOST_SPARE else max_skip


def score_table(
    reduction: Reduction,
    max_skip: int,
    poses: FloatArray,
    score: Callable[[FloatArray], FloatArray],
    before: ScoreTable | None,
) -> ScoreTable:
    """Score an unrolled input; take from another table of the same clip the rows that it has already.

    A row's scores depend on the frames up to `max_skip` before and after it, and on nothing else: inside a span they
    are the same wherever the span's ends are.

    Parameters
    ----------
    reduction : Reduction
        What is unrolled.
    max_skip : int
        Largest step.
    poses : float array, shape (n_input, n_numbers)
        Of the unrolled input.
    score : function
        Scores some consecutive poses.
    before : ScoreTable, optional
        Made with the same `score`.
    """
    n_input = len(poses)
    kept = (
        [] if before is None or before.max_skip < max_skip else list(_same_rows(reduction, before.reduction, max_skip))
    )
    missing = np.ones(n_input, dtype=bool)
    for first, last, _ in kept:
        missing[first:last] = False
    if before is None or missing.sum() > n_input // 2:
        return ScoreTable(reduction, max_skip, score(poses), poses)
    scores = np.empty((n_input, max_skip, max_skip))
    for first, last, other in kept:
        scores[first:last] = before.scores[other : other + last - first, :max_skip, :max_skip]
    for first, last in _runs(missing):
        begin, end = max(0, first - max_skip), min(n_input, last + max_skip)
        scores[first:last] = score(poses[begin:end])[first - begin : last - begin]
    return ScoreTable(reduction, max_skip, scores, poses)


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
