"""Prices on steps, and scores laid out anew, against loops over every triple."""

from __future__ import annotations

import numpy as np
import pytest

from retime.kernels import StepPairs
from retime.search.wishes.prices import add_after, among_every

# Fewer rows than are worked on at once, as many, and some more.
LENGTHS = [1, 1024, 2500]
STEPS = [StepPairs.of([1, 2, 4, 8], ratio=2), StepPairs.of([3]), StepPairs.of([1, 2, 3, 5, 9], ratio=1.7)]


@pytest.mark.parametrize("steps", STEPS, ids=lambda steps: str(steps.steps.tolist()))
@pytest.mark.parametrize("n_input", LENGTHS)
def test_each_triple_pays_for_its_second_step(n_input: int, steps: StepPairs) -> None:
    rng = np.random.default_rng(n_input)
    scores, prices = rng.random((n_input, steps.n_pairs)), rng.random((n_input, steps.n_steps))
    scores[rng.random(scores.shape) < 0.1] = np.inf
    expected = [[scores[j, pair] + prices[j, after] for pair, after in enumerate(steps.after)] for j in range(n_input)]
    add_after(scores, prices, steps)
    np.testing.assert_array_equal(scores, expected)


@pytest.mark.parametrize("steps", STEPS, ids=lambda steps: str(steps.steps.tolist()))
@pytest.mark.parametrize("n_input", LENGTHS)
def test_pairs_that_there_are_not_are_infinite_among_all(n_input: int, steps: StepPairs) -> None:
    scores = np.random.default_rng(n_input).random((n_input, steps.n_pairs))
    every = StepPairs.of(steps.steps)
    expected = np.full((n_input, every.n_steps, every.n_steps), np.inf)
    for pair, (before, after) in enumerate(zip(steps.before, steps.after, strict=True)):
        for j in range(n_input):
            expected[j, before, after] = scores[j, pair]
    found = among_every(scores, steps, every)
    np.testing.assert_array_equal(found, expected.reshape(n_input, -1))
    assert found.flags.c_contiguous
