"""Scores that outlive a drag: when a keytime moves, the rows whose frames stay the same are not scored again."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr
from retime.kernels import StepPairs
from retime.limits import MAX_STEP
from retime.search.reduction import Reduction, nearest_frame

# The most scores of a table that is made larger than needed, so that it need not grow soon.
_MOST_SPARE = 20_000_000
# How many tables are kept, and of how many bytes: while a keytime is dragged from slower than life to faster and back,
# two or three grids take turns. The newest one is kept in any case.
_MOST_TABLES, _MOST_BYTES = 6, 64 << 20


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
    """

    reduction: Reduction
    steps: StepPairs
    scores: FloatArray

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


class ScoreTables:
    """The tables that were made last, one a grid: as fine, and with the same steps."""

    def __init__(self) -> None:
        # The newest one last.
        self._tables: dict[tuple[object, ...], ScoreTable] = {}

    @property
    def latest(self) -> ScoreTable | None:
        """The table that was used last."""
        return next(reversed(self._tables.values()), None)

    def scores(
        self,
        reduction: Reduction,
        steps: StepPairs,
        poses: Callable[[], FloatArray],
        score: Callable[[FloatArray, StepPairs], FloatArray],
    ) -> ScoreTable:
        """Return a table that serves: one that was kept, or a new one, with all rows that are known already.

        Parameters
        ----------
        reduction : Reduction
            What is unrolled.
        steps : StepPairs
            The pairs of steps that are needed.
        poses : function
            Returns the poses of the unrolled input, shape (n_input, n_numbers).
        score : function
            Scores some consecutive poses by some steps: shape (n, n_pairs).
        """
        newest_first = list(reversed(self._tables.items()))
        for grid, known in newest_first:
            if known.serves(reduction, steps):
                self._keep(grid, known)
                return known
        latest = self.latest
        wider = steps if latest is None else latest.next_steps(steps)
        made = score_table(reduction, wider, poses(), lambda some: score(some, wider), [one for _, one in newest_first])
        self._keep((reduction.upsamples, wider.steps.tobytes(), wider.first.tobytes(), wider.end.tobytes()), made)
        return made

    def _keep(self, grid: tuple[object, ...], table: ScoreTable) -> None:
        self._tables.pop(grid, None)
        self._tables[grid] = table
        sizes = [one.scores.nbytes for one in reversed(self._tables.values())]
        n_kept = sum(1 for total in itertools.accumulate(sizes) if total <= _MOST_BYTES)
        for old in list(self._tables)[: -min(max(1, n_kept), _MOST_TABLES)]:
            del self._tables[old]


def score_table(
    reduction: Reduction,
    steps: StepPairs,
    poses: FloatArray,
    score: Callable[[FloatArray], FloatArray],
    before: Sequence[ScoreTable],
) -> ScoreTable:
    """Score an unrolled input; take from other tables of the same clip the rows that they have already.

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
    before : sequence of ScoreTable
        Made with the same scores; of a row that several have, the first one's is taken.
    """
    n_input, longest = len(poses), steps.longest
    missing = np.ones(n_input, dtype=bool)
    kept: list[tuple[int, int, int, ScoreTable]] = []
    for table in before:
        if not missing.any():
            break
        for first, last, other in _same_rows(reduction, table.reduction, longest) if table.holds(steps) else ():
            for start, stop in _runs(missing[first:last]):
                kept.append((first + start, first + stop, other + start, table))
            missing[first:last] = False
    if missing.sum() > n_input // 2:
        return ScoreTable(reduction, steps, score(poses))
    scores = np.empty((n_input, steps.n_pairs))
    for first, last, other, table in kept:
        scores[first:last] = table.rows(other, other + last - first, steps)
    for first, last in _runs(missing):
        begin, end = max(0, first - longest), min(n_input, last + longest)
        scores[first:last] = score(poses[begin:end])[first - begin : last - begin]
    return ScoreTable(reduction, steps, scores)


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
