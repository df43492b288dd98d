"""Scores kept from one solve to the next are the scores that a fresh start would give, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest

from retime.arrays import FloatArray
from retime.errors import InfeasibleWarpError
from retime.kernels import StepPairs
from retime.search import score_table as score_tables
from retime.search.reduction import Reduction, reduce_to_compression
from retime.search.score import build_model, triple_scores
from retime.search.score_table import ScoreTable, ScoreTables, score_table
from retime.warp.keytime import Keytime

RATE, DURATION = 30.0, 8.0


def poses_at(times: FloatArray) -> FloatArray:
    phases = np.arange(6)
    return np.sin(times[:, None] * (1 + 0.3 * phases) + phases) + 0.1 * times[:, None] ** 1.5


REFERENCE = poses_at(np.arange(0, DURATION, 1 / RATE))
MODEL = build_model([REFERENCE], rate=RATE, time_scale=0.2, n_neighbors=3, weights=[1.0])


# All steps up to some, a few of them, and few pairs of these.
STEPS = [
    *(StepPairs.up_to(most) for most in (3, 4, 6)),
    StepPairs.of([1, 2, 3, 4, 6, 8]),
    StepPairs.of([1, 2, 3, 4, 6, 8], ratio=2.05),
]


class Scorer:
    """Scores poses, and counts them."""

    def __init__(self, steps: StepPairs, score: str = "joint") -> None:
        self.steps, self.score, self.n_scored = steps, score, 0

    def __call__(self, poses: FloatArray) -> FloatArray:
        self.n_scored += len(poses)
        return triple_scores(poses, MODEL, steps=self.steps, score=self.score)


def table(reduction: Reduction, scorer: Scorer, *before: ScoreTable) -> ScoreTable:
    return score_table(reduction, scorer.steps, poses_at(reduction.input_times), scorer, before)


def reduction_through(inner: list[tuple[float, float]], upsample: int | list[int]) -> Reduction:
    keys = [
        Keytime(input_time=0.0, output_time=0.0),
        *(Keytime(input_time=into, output_time=out) for into, out in inner),
        Keytime(input_time=DURATION, output_time=9.0),
    ]
    return reduce_to_compression(keys, DURATION, rate=RATE, upsample=upsample)


@pytest.mark.parametrize("score", ["joint", "conditional"])
def test_rows_that_are_kept_equal_rows_that_are_scored(score: str) -> None:
    rng = np.random.default_rng(3)
    before: list[ScoreTable] = []
    saved = 0
    for turn in range(40):
        scorer = Scorer(STEPS[rng.integers(len(STEPS))], score)
        # Forward, held and backward spans; the same keys a little elsewhere, most of the time.
        if turn % 4 == 0:
            into = rng.uniform(0.5, 7.5, 2)
            into[1] = into[0] if turn % 8 == 0 else into[1]
            upsamples = rng.choice([1, 2], 3).tolist()
        moved = np.clip(into + rng.uniform(-0.2, 0.2), 0.1, 7.9)
        try:
            reduction = reduction_through([(moved[0], 3.0), (moved[1], 6.0)], upsamples)
        except InfeasibleWarpError:
            continue
        found = table(reduction, scorer, *before)
        fresh = triple_scores(poses_at(reduction.input_times), MODEL, steps=scorer.steps, score=score)
        assert np.array_equal(found.scores, fresh)
        saved += scorer.n_scored < reduction.n_input
        # Tables of several grids, the newest first.
        before = [found, *before[:3]]
    assert saved > 10


def test_a_key_that_moves_scores_only_what_lies_beside_it() -> None:
    scorer = Scorer(StepPairs.up_to(8))
    before = table(reduction_through([(4.0, 3.0)], [1, 4]), scorer)
    scorer.n_scored = 0
    after = table(reduction_through([(4.1, 3.0)], [1, 4]), scorer, before)
    # Around the key, with as many frames again for the steps that lead there.
    assert scorer.n_scored < 45
    assert after.reduction.n_input > 500


def test_grids_that_take_turns_are_scored_once() -> None:
    tables, scorer = ScoreTables(), Scorer(StepPairs.up_to(8))
    slower, faster = [reduction_through([(4.0, out)], grid) for out, grid in ((5.0, [3, 1]), (3.0, [1, 4]))]

    def scores(reduction: Reduction) -> FloatArray:
        def score(some: FloatArray, steps: StepPairs) -> FloatArray:
            assert np.array_equal(steps.steps, scorer.steps.steps)
            return scorer(some)

        return tables.scores(reduction, scorer.steps, lambda: poses_at(reduction.input_times), score).scores

    for turn in range(3):
        for reduction in (slower, faster):
            fresh = triple_scores(poses_at(reduction.input_times), MODEL, steps=scorer.steps)
            assert np.array_equal(scores(reduction), fresh)
        if turn == 0:
            assert scorer.n_scored == slower.n_input + faster.n_input
    assert scorer.n_scored == slower.n_input + faster.n_input
    # A key that moves on one grid takes nothing from the other.
    for moved in (4.1, 4.2, 4.3, 4.4, 4.5, 4.6, 4.7, 4.8):
        scores(reduction_through([(moved, 5.0)], [3, 1]))
    so_far = scorer.n_scored
    scores(faster)
    assert scorer.n_scored == so_far


def test_of_large_tables_the_newest_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    scorer = Scorer(StepPairs.up_to(4))
    tables = ScoreTables()
    monkeypatch.setattr(score_tables, "_MOST_BYTES", 1)

    def made(upsample: int) -> ScoreTable:
        reduction = reduction_through([], upsample)
        poses = poses_at(reduction.input_times)
        return tables.scores(reduction, scorer.steps, lambda: poses, lambda some, _: scorer(some))

    first = made(1)
    assert tables.latest is first
    second = made(2)
    assert made(2) is second
    assert made(1) is not first


def test_longer_steps_are_scored_anew() -> None:
    four, five, six = (StepPairs.up_to(most) for most in (4, 5, 6))
    before = table(reduction_through([], 1), Scorer(four))
    scorer = Scorer(six)
    after = table(reduction_through([], 1), scorer, before)
    assert scorer.n_scored == after.reduction.n_input
    assert not before.serves(after.reduction, six)
    assert before.serves(after.reduction, four)
    assert after.serves(before.reduction, four)
    assert np.array_equal(after.of(four), before.scores)
    # What grows once grows further; what shrinks a little stays.
    assert before.next_steps(StepPairs.up_to(20)).longest > 20
    assert after.next_steps(five).longest == 6
    assert after.next_steps(StepPairs.up_to(2)).longest == 2
    # A list of steps has what it says, and is had from a table of all.
    few = StepPairs.of([1, 2, 4], ratio=2.0)
    assert after.serves(after.reduction, few)
    assert not before.serves(before.reduction, StepPairs.of([1, 5]))
    assert after.next_steps(few) is few
    assert np.array_equal(after.of(few), triple_scores(poses_at(after.reduction.input_times), MODEL, steps=few))
