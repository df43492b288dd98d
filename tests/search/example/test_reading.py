"""What an example says of a clip: looked up literally, and on made motion with a known answer."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.motion.signal import Signal
from retime.search.example.reading import FAR, ExampleReading, _looked_up, _median_distance, _stretches, read_example
from retime.search.poses.references import Reference, model_poses
from retime.warp.curve import Warp
from tests.reference import hand_speeds as literal


def reading_of(clip: Signal, span: tuple[float, float], hand: Warp, other: Signal | None = None) -> ExampleReading:
    poses = model_poses(clip, [Reference(other or clip)]).in_own_order()
    return read_example(
        poses, span, hand, rate=30.0, low_pass=0.0, time_scale=0.2, n_neighbors=3, elsewhere=other is not None
    )


def swing(seconds: float, period: float = 1.0, size: float = 1.0, rate: int = 30) -> Signal:
    phase = 2 * np.pi * np.arange(round(seconds * rate) + 1) / rate / period
    return Signal(("x", "y"), size * np.stack([np.cos(phase), np.sin(phase)], axis=1), Fraction(rate), "swing")


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_what_is_nearest_is_looked_up_as_it_is_said(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m, d = rng.integers(1, 9), rng.integers(1, 9), rng.integers(1, 4)
    # Whole numbers make ties; of two that are equally near the earlier one counts.
    points, others = rng.integers(0, 3, (n, d)).astype(float), rng.integers(0, 3, (m, d)).astype(float)
    values = rng.normal(size=m)
    means, nearest = _looked_up(points, others, values, 3)
    wanted = literal.looked_up(points, others, values, 3)
    assert means == pytest.approx(wanted[0])
    assert nearest == pytest.approx(wanted[1])


def test_looking_up_in_parts_is_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(0)
    points, others, values = rng.normal(size=(50, 3)), rng.normal(size=(20, 3)), rng.normal(size=20)
    whole = _looked_up(points, others, values, 3)
    monkeypatch.setattr("retime.search.example.reading._AT_ONCE", 130)
    parts = _looked_up(points, others, values, 3)
    assert np.array_equal(whole[0], parts[0])
    assert np.array_equal(whole[1], parts[1])


@pytest.mark.parametrize("n", [2, 7, 400, 1203])
def test_the_median_of_distances_is_that_of_all_or_of_many(n: int) -> None:
    points = np.random.default_rng(n).normal(size=(n, 2))
    every = np.sqrt(((points[:, None] - points) ** 2).sum(axis=2))
    assert _median_distance(points) == pytest.approx(np.median(every), rel=1e-12 if n <= 500 else 0.03)


def test_every_cycle_gets_the_speeds_of_the_one_that_was_retimed() -> None:
    # Twice as fast in the first half of a cycle, half as fast in the second.
    hand = Warp([0.0, 0.25, 1.25], [0.0, 0.5, 1.0])
    found = reading_of(swing(6.0), (2.0, 3.0), hand)
    phase = (np.arange(len(found.log_speeds)) / 30) % 1.0
    first, second = (phase > 0.1) & (phase < 0.4), (phase > 0.6) & (phase < 0.9)
    assert found.log_speeds[first] == pytest.approx(np.log(2.0), abs=0.02)
    assert found.log_speeds[second] == pytest.approx(-np.log(2.0), abs=0.02)
    assert (found.closed, found.period, found.share, found.unspoken, found.warnings) == (True, None, 1.0, (), ())
    assert (found.slowest, found.fastest) == pytest.approx((0.5, 2.0))


def test_half_a_cycle_leaves_the_other_half_alone() -> None:
    found = reading_of(swing(6.0), (2.0, 2.5), Warp([0.0, 0.25], [0.0, 0.5]))
    phase = (np.arange(len(found.log_speeds)) / 30) % 1.0
    first, second = (phase > 0.1) & (phase < 0.4), (phase > 0.6) & (phase < 0.9)
    assert found.log_speeds[first] == pytest.approx(np.log(2.0), abs=0.02)
    assert found.log_speeds[second] == pytest.approx(0.0, abs=0.02)
    assert (found.closed, found.period) == (False, 1.0)


def test_natural_slowness_is_told_from_a_hands() -> None:
    # The clip slows down by itself, to two thirds of its pace; the hand said "half as fast" of the first cycle.
    t = np.arange(301) / 30
    phase = 2 * np.pi * np.where(t < 5, t, 5 + (t - 5) / 1.5)
    clip = Signal(("x", "y"), np.stack([np.cos(phase), np.sin(phase)], axis=1), Fraction(30))
    found = reading_of(clip, (1.0, 2.0), Warp([0.0, 2.0], [0.0, 1.0]))
    assert found.log_speeds == pytest.approx(-np.log(2.0), abs=1e-6)


def test_what_is_unlike_the_example_is_marked_and_left_alone() -> None:
    t = np.arange(241) / 30
    phase = 2 * np.pi * t
    values = np.stack([np.cos(phase), np.sin(phase)], axis=1)
    # For two seconds it does something else altogether.
    away = (t > 4) & (t < 6)
    values[away] += 5.0
    found = reading_of(Signal(("x", "y"), values, Fraction(30)), (1.0, 2.0), Warp([0.0, 2.0], [0.0, 1.0]))
    assert found.log_speeds[(t > 4.1) & (t < 5.9)] == pytest.approx(0.0, abs=1e-9)
    assert found.share == pytest.approx(0.75, abs=0.02)
    ((start, end),) = found.unspoken
    assert (start, end) == pytest.approx((4.0, 6.0), abs=0.05)
    (warning,) = found.warnings
    assert "25% of the clip" in warning
    assert f"{start:.2f}..{end:.2f}" in warning


def test_from_another_clip_what_counts_is_how_fast_it_moves_at_a_pose() -> None:
    hand = Warp([0.0, 0.25, 1.25], [0.0, 0.5, 1.0])
    other = swing(4.0)
    found = reading_of(swing(6.0, period=1.5), (1.0, 2.0), hand, other)
    assert found.tempo == pytest.approx(1 / 1.5, rel=0.02)
    assert found.elsewhere
    # Scaled to one pace the two circles are one.
    assert found.share == 1.0
    phase = (np.arange(len(found.log_speeds)) / 45) % 1.0
    first, second = (phase > 0.1) & (phase < 0.4), (phase > 0.6) & (phase < 0.9)
    assert found.log_speeds[first] == pytest.approx(np.log(2.0), abs=0.02)
    assert found.log_speeds[second] == pytest.approx(-np.log(2.0), abs=0.02)
    assert [warning for warning in found.warnings if "another clip, which moves 1.5 times as fast" in warning]


def test_a_clip_that_never_moves_says_one_thing_everywhere() -> None:
    still = Signal(("x",), np.zeros((90, 1)), Fraction(30))
    found = reading_of(still, (0.5, 1.5), Warp([0.0, 2.0], [0.0, 1.0]))
    assert np.isfinite(found.log_speeds).all()
    assert found.log_speeds[15:46] == pytest.approx(-np.log(2.0))
    assert found.share == 1.0


def test_moments_between_samples_are_read_between_them() -> None:
    found = ExampleReading(0.0, 1.0, 10.0, np.array([0.0, 1.0, 0.0]), np.array([0.0, 1.0, FAR]), 1.0, 2.0, True)
    assert found.log_speeds_at(np.array([0.05, 0.1, 5.0])) == pytest.approx([0.5, 1.0, 0.0])
    assert found.share == pytest.approx(2 / 3)


def test_short_gaps_are_bridged_and_short_stretches_not_worth_a_mark() -> None:
    marked = np.zeros(100, dtype=bool)
    marked[[*range(10, 20), *range(22, 30), 50, *range(90, 100)]] = True
    assert _stretches(marked, 30.0) == [(10, 29), (90, 99)]
    assert _stretches(np.zeros(5, dtype=bool), 30.0) == []
