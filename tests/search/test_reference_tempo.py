"""A reference's tempo, measured by a literal twin, and a timing that is taken without it."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.motion.signal import Signal
from retime.search.guided import guided_warp
from retime.search.poses.spaces import timing_features
from retime.search.reference_tempo import at_tempo, tempo_ratio
from retime.search.score import build_model
from retime.search.session import Session


def literal_ratio(own, reference, n: int) -> float:
    """One frame of the clip, one of the reference, at a time."""

    def speed(row) -> float:
        return math.sqrt(sum(x * x for x in row[n : 2 * n]))

    total = weight = 0.0
    for row in own:
        away = [
            (sum((x - y) ** 2 for x, y in zip(row[:n], other[:n], strict=True)), speed(other)) for other in reference
        ]
        near = [quick for _, quick in sorted(away)[:3]]
        mean, here = sum(near) / len(near), speed(row)
        if min(here, mean) > 0:
            total += min(here, mean) * math.log(here / mean)
            weight += min(here, mean)
    return min(max(math.exp(total / weight), 0.25), 4.0)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(5, 40), st.integers(6, 50), st.integers(1, 4))
def test_the_ratio_is_that_of_the_literal_twin(seed: int, n_own: int, n_reference: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    poses = np.cumsum(rng.normal(size=(n_reference, n)), axis=0)
    model = build_model([poses], rate=30.0, time_scale=0.2, n_neighbors=3, weights=[1.0])
    own = np.cumsum(rng.normal(size=(n_own, n)), axis=0) * 10.0 ** rng.uniform(-1, 1)
    features = timing_features(own - model.origin, rate=30.0, time_scale=0.2)
    wanted = literal_ratio(features.tolist(), model.features.tolist(), n)
    assert tempo_ratio(features, model) == pytest.approx(wanted, rel=1e-9)


def wave(speed: float, seconds: float, bend: float = 0.0) -> Signal:
    """Go round at a speed; `bend` hurries on one side and lingers on the other."""
    t = np.arange(round(seconds * 30) + 1) / 30
    turn = 2 * np.pi * 0.5 * speed * t
    turn = turn + bend * np.sin(turn)
    return Signal(("x", "y"), np.stack([np.cos(turn), np.sin(turn)], axis=1), Fraction(30))


@pytest.mark.parametrize("speed", [0.5, 1.0, 1.7])
def test_the_same_motion_at_another_speed_has_that_ratio(speed: float) -> None:
    session = Session(wave(1.0, 8.0), reference=wave(speed, 8.0), match_tempo=True, features="signal")
    assert session.tempo_ratio == pytest.approx(1 / speed, rel=0.02)


def test_a_slow_reference_is_imitated_without_its_slowness() -> None:
    clip, slow = wave(1.0, 8.0), wave(0.5, 16.0, bend=0.5)
    plain = guided_warp(clip, reference=slow, length="free")
    matched = guided_warp(clip, reference=slow, length="free", match_tempo=True)
    assert plain.warp.output_end > 1.6 * clip.end_time
    assert matched.warp.output_end == pytest.approx(clip.end_time, rel=0.2)
    # Where it lingers it still does: the bend slows the side on which x is largest less than the other.
    times = np.linspace(0.5, matched.warp.output_end - 0.5, 200)
    angle = np.pi * matched.warp(times)
    fast, slow_side = np.cos(angle) > 0.7, np.cos(angle) < -0.7
    assert matched.warp.speed(times)[fast].mean() > 1.3 * matched.warp.speed(times)[slow_side].mean()


def test_velocities_and_accelerations_are_scaled_and_poses_stay() -> None:
    poses = np.cumsum(np.random.default_rng(0).normal(size=(9, 2)), axis=0)
    model = build_model([poses], rate=30.0, time_scale=0.2, n_neighbors=3, weights=[1.0])
    faster = at_tempo(model, 3.0)
    np.testing.assert_array_equal(faster.features[:, :2], model.features[:, :2])
    np.testing.assert_allclose(faster.features[:, 2:4], 3 * model.features[:, 2:4])
    np.testing.assert_allclose(faster.features[:, 4:], 9 * model.features[:, 4:])


def test_a_clip_that_stands_still_says_nothing() -> None:
    still = np.zeros((8, 6))
    poses = np.cumsum(np.random.default_rng(0).normal(size=(9, 2)), axis=0)
    model = build_model([poses], rate=30.0, time_scale=0.2, n_neighbors=3, weights=[1.0])
    assert tempo_ratio(still, model) == 1.0
    assert Session(wave(1.0, 4.0), match_tempo=True).tempo_ratio == 1.0
