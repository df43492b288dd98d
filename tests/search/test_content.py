"""Prices on what is left out, and on the speeds of the ends: what they say, and what comes of them."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

import retime
from retime.kernels import StepPairs
from retime.motion.signal import Signal
from retime.search.content import content_prices
from retime.search.reduction import Reduction, reduce_to_compression
from retime.warp.keytime import Keytime

RATE = 30.0


def literal_price(
    poses: np.ndarray, reduction: Reduction, j: int, b: int, *, weight: float, time_scale: float, itself: bool
) -> float:
    """The formula, pose by pose."""
    upsample = int(reduction.upsample_at[j])
    if b < 2 or reduction.held[j]:
        return 0.0
    p = (time_scale * RATE) ** 2 / 9 * (1 if itself else 2)
    total = 0.0
    for inner in range(j + 1, j + b):
        t = (inner - j) / b
        off = p * (poses[inner] - ((1 - t) * poses[j] + t * poses[j + b]))
        u = int(reduction.upsample_at[inner])
        bent = np.zeros_like(off)
        if itself and u <= inner < len(poses) - u:
            bent = (time_scale * RATE) ** 2 * (poses[inner + u] - 2 * poses[inner] + poses[inner - u])
        total += math.sqrt(float(off @ off + bent @ bent))
    return weight * max(0, b - upsample) / ((b - 1) * upsample) * total


@pytest.mark.parametrize("itself", [True, False])
@pytest.mark.parametrize("seed", range(5))
def test_prices_are_the_formula_s(seed: int, itself: bool) -> None:
    rng = np.random.default_rng(seed)
    keys = [(0.0, 0.0), (0.5, 0.4), (0.5, 0.6), (1.1, 1.0)]
    keytimes = [Keytime(input_time=i, output_time=o) for i, o in keys]
    reduction = reduce_to_compression(keytimes, 1.1, rate=RATE, upsample=[int(u) for u in rng.choice([1, 2, 4], 3)])
    poses = rng.normal(size=(reduction.n_input, 5))
    steps = StepPairs.of([1, 2, 3, 4, 6, 8])
    how = {"weight": 2.0, "time_scale": 0.2, "itself": itself}
    prices = content_prices(poses, reduction, steps, **how)
    for j in range(reduction.n_input):
        for place, b in enumerate(steps.steps.tolist()):
            expected = literal_price(poses, reduction, j, b, **how) if j + b < reduction.n_input else 0.0
            assert prices[j, place] == pytest.approx(expected, rel=1e-9, abs=1e-9)


def hops() -> Signal:
    """Standing, with a short hop in every second."""
    t = np.arange(240) / 30
    return Signal(("y",), np.maximum(0, np.sin(2 * np.pi * t) - 0.6)[:, None], Fraction(30))


def test_content_keeps_what_a_plain_sum_leaps_over() -> None:
    clip = hops()
    shown = [retime.guided_warp(clip, length="20%", content=weight).apply().values.max() for weight in (0.0, 4.0)]
    left_out = [
        len(np.setdiff1d(np.flatnonzero(clip.values[:, 0] > 0.1), found.path.frames))
        for found in (retime.guided_warp(clip, length="20%", content=weight, upsample=1) for weight in (0.0, 4.0))
    ]
    assert shown[1] >= shown[0]
    assert left_out[1] < left_out[0]


@pytest.mark.parametrize("options", [{"content": 2.0}, {"ends": 0.5}, {"content": 1.0, "ends": 0.2, "smoothness": 0.3}])
def test_what_is_paid_adds_up_to_the_total(options) -> None:
    found = retime.guided_warp(retime.sample(), length="75%", **options)
    assert found.path.optimal
    explained = found.explain()
    assert np.nansum(explained.costs) == pytest.approx(found.total, rel=1e-12)
    assert explained.seam_cost == 0.0


def test_calm_ends_begin_and_end_nearer_to_unit_speed() -> None:
    t = np.arange(150) / 30
    clip = Signal(
        ("x",), np.where((t > 1) & (t < 4), np.sin(3 * t), np.sin(3 * np.clip(t, 1, 4)))[:, None], Fraction(30)
    )
    first, last = (
        [abs(math.log(found.path_speeds[end])) for end in (0, -1)]
        for found in (retime.guided_warp(clip, length="70%", ends=weight) for weight in (0.0, 5.0))
    )
    assert sum(last) < sum(first)
