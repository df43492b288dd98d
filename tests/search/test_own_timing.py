"""The clip's own timing: what it costs to leave it, against the formula, and what comes of it."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

import retime
from retime.errors import OptionError
from retime.kernels import StepPairs, backend
from retime.motion.signal import Signal
from retime.search.own_timing import own_timing_costs
from retime.search.reduction import reduce_to_compression
from retime.search.score import build_model, triple_scores
from retime.warp.keytime import Keytime

RATE, TIME_SCALE = 30.0, 0.2


def literal_costs(poses: np.ndarray, upsample_at: list[int], steps: StepPairs) -> np.ndarray:
    """The formula, triple by triple."""
    n = len(poses)
    scale = TIME_SCALE * RATE
    before = [upsample_at[max(0, j - 1)] for j in range(n)]
    whole = [j for j in range(n) if j - before[j] >= 0 and j + upsample_at[j] < n]

    def moves(i: int, j: int, k: int) -> np.ndarray:
        return np.concatenate([scale * (poses[k] - poses[i]) / 2, scale**2 * (poses[k] - 2 * poses[j] + poses[i])])

    costs = np.full((n, steps.n_pairs), math.inf)
    for j in range(n):
        # Frames that have no neighbours at unit speed lie at the ends, or before a span that is offered more finely.
        own = next((m for m in whole if m >= j), whole[-1])
        wanted = moves(own - before[own], own, own + upsample_at[own])
        for pair, (a, b) in enumerate(zip(steps.steps[steps.before], steps.steps[steps.after], strict=True)):
            if j - a >= 0 and j + b < n:
                costs[j, pair] = math.dist(moves(j - a, j, j + b), wanted)
    return costs


@pytest.mark.parametrize("name", ["numpy", None])
@pytest.mark.parametrize("still", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_costs_are_the_formula_s(seed: int, still: bool, name: str | None) -> None:
    rng = np.random.default_rng(seed)
    keys = [(0.0, 0.0), (0.5, 0.4), (0.5, 0.6), (0.2, 1.0), (1.1, 2.0)]
    keytimes = [Keytime(input_time=i, output_time=o) for i, o in keys]
    reduction = reduce_to_compression(keytimes, 1.1, rate=RATE, upsample=[int(u) for u in rng.choice([1, 2, 4], 4)])
    poses = np.zeros((reduction.n_input, 3)) if still else rng.normal(size=(reduction.n_input, 3))
    model = build_model([rng.normal(size=(20, 3))], rate=RATE, time_scale=TIME_SCALE)
    steps = StepPairs.of([1, 2, 3, 4, 6, 8])
    costs = own_timing_costs(poses, reduction, steps, model, use=backend(name))
    expected = literal_costs(poses, reduction.upsample_at.tolist(), steps)
    np.testing.assert_allclose(costs, expected, rtol=1e-9, atol=1e-9)


def test_unit_speed_costs_nothing() -> None:
    rng = np.random.default_rng(3)
    reduction = reduce_to_compression(
        [Keytime(input_time=t, output_time=t) for t in (0.0, 1.0)], 1.0, rate=RATE, upsample=4
    )
    poses = rng.normal(size=(reduction.n_input, 2))
    model = build_model([rng.normal(size=(20, 2))], rate=RATE, time_scale=TIME_SCALE)
    steps = StepPairs.up_to(8)
    costs = own_timing_costs(poses, reduction, steps, model)
    unit = int(steps.pair_of(np.array([4]), np.array([4]))[0])
    np.testing.assert_array_equal(costs[4:-4, unit], 0.0)
    assert (np.delete(costs[8:-8], unit, axis=1) > 0).all()


def clip(seed: int, n: int) -> Signal:
    rng = np.random.default_rng(seed)
    return Signal(("x", "y"), np.cumsum(rng.normal(size=(n, 2)), axis=0), Fraction(30))


@pytest.mark.parametrize("seed", range(5))
def test_the_path_is_the_best_of_all(seed: int) -> None:
    """By enumeration: a free length, the clip's own timing binding."""
    weight = 0.7
    motion, other = clip(seed, 9), clip(100 + seed, 12)
    found = retime.guided_warp(
        motion, reference=other, length="free", own_timing=weight, free_weight="neutral", upsample=1, max_skip=3
    )
    poses, model, steps = found.input_poses, found.model, StepPairs.up_to(3)
    scores = triple_scores(poses, model, steps=steps) + weight * literal_costs(poses, [1] * len(poses), steps)
    best = math.inf
    for n_inner in range(1, 8):
        for inner in itertools.combinations(range(1, 8), n_inner):
            path = [0, *inner, 8]
            skips = np.diff(path)
            if skips.max() > 3:
                continue
            total = sum(
                scores[j, 3 * (a - 1) + b - 1] * math.sqrt((a + b) / 2)
                for j, a, b in zip(inner, skips[:-1], skips[1:], strict=True)
            )
            best = min(best, total)
    assert found.total == pytest.approx(best, rel=1e-9)
    assert np.nansum(found.explain().costs) == pytest.approx(best, rel=1e-9)


def test_a_reference_that_says_nothing_leaves_the_clip_its_own_timing() -> None:
    """The reference never comes near the clip's poses: the scores alone drift, the clip's own timing stays."""
    t = np.arange(90) / 30
    motion = Signal(("x",), np.sin(4 * t)[:, None], Fraction(30))
    far = Signal(("x",), 50 + 3 * np.sin(9 * t)[:, None], Fraction(30))
    lengths = [
        retime.guided_warp(motion, reference=far, length="free", own_timing=weight).n_output for weight in (0.0, 1000.0)
    ]
    assert abs(lengths[1] - 90) <= 1 < abs(lengths[0] - 90)


def test_a_weight_below_zero_is_refused() -> None:
    with pytest.raises(OptionError, match=r"own timing must be from 0 to 1e\+06"):
        retime.guided_warp(clip(1, 40), own_timing=-1.0)
