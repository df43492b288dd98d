"""Steps and their pairs: which there are, and where their scores stand."""

from __future__ import annotations

import numpy as np
import pytest

from retime.errors import OptionError
from retime.kernels import StepPairs
from tests.reference.paths import follows

FINE = [1, 2, 3, 4, 5, 6, 8, 12, 16, 32]


def listed(pairs: StepPairs) -> list[tuple[int, int]]:
    return list(zip(pairs.steps[pairs.before].tolist(), pairs.steps[pairs.after].tolist(), strict=True))


@pytest.mark.parametrize("seed", range(40))
def test_pairs_are_those_within_the_ratio_in_order(seed: int) -> None:
    rng = np.random.default_rng(seed)
    steps = sorted(set(rng.integers(1, 256, rng.integers(1, 20)).tolist()))
    ratio = float(rng.choice([1, 1.25, 1.5, 2, 2.05, 3, 10, np.inf]))
    pairs = StepPairs.of(steps, ratio)
    wanted = follows(steps, ratio)
    assert listed(pairs) == [(a, b) for a in steps for b in wanted[a]]
    assert pairs.n_pairs == len(listed(pairs))
    assert (pairs.shortest, pairs.longest) == (steps[0], steps[-1])
    # What a step may follow are neighbours too, which the kernels rely on.
    assert (np.diff(pairs.first) >= 0).all()
    assert (np.diff(pairs.end) >= 0).all()


def test_a_fine_grid_has_44_pairs() -> None:
    assert StepPairs.of(FINE, 2.05).n_pairs == 44


@pytest.mark.parametrize("max_skip", [1, 2, 8, 255])
def test_all_steps_are_laid_out_like_a_square(max_skip: int) -> None:
    pairs = StepPairs.up_to(max_skip)
    assert pairs.every
    square = np.arange(max_skip**2).reshape(max_skip, max_skip)
    assert np.array_equal(square[pairs.before, pairs.after], np.arange(max_skip**2))


def test_some_steps_or_some_pairs_are_not_every() -> None:
    assert not StepPairs.of([1, 2, 4]).every
    assert not StepPairs.of([1, 2, 3], 2).every
    assert StepPairs.of([1, 2], 2).every


def test_pairs_are_found_by_their_steps() -> None:
    pairs = StepPairs.of(FINE, 2.05)
    before, after = pairs.steps[pairs.before], pairs.steps[pairs.after]
    assert np.array_equal(pairs.pair_of(before, after), np.arange(pairs.n_pairs))
    none = pairs.pair_of(np.array([1, 7, 32, 33, 0, 4]), np.array([3, 7, 8, 33, 1, -1]))
    assert none.tolist() == [-1] * 6


@pytest.mark.parametrize("steps", [[], [0, 1], [2, 1], [1, 1], [1, 256], [-1, 2]])
def test_steps_out_of_range_or_order_are_refused(steps: list[int]) -> None:
    with pytest.raises(OptionError, match="steps must rise"):
        StepPairs.of(steps)


@pytest.mark.parametrize("ratio", [0.5, 0, -1, float("nan")])
def test_a_ratio_below_one_is_refused(ratio: float) -> None:
    with pytest.raises(OptionError, match="at least 1"):
        StepPairs.of([1, 2], ratio)
