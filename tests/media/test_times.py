"""Which frames an output frame shows, against literal rules."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from retime.media.pieces import SHORTEST, pieces_of, spans_shown
from retime.media.times import FrameTimes, plan_frames, weights_at
from retime.warp.curve import Warp
from tests.reference.media import blended_weights


def even(n: int, rate: int = 30) -> FrameTimes:
    return FrameTimes(np.arange(n), Fraction(1, rate), Fraction(rate), True)


@pytest.mark.parametrize("seed", range(20))
def test_weights_are_those_of_the_literal_mean(seed) -> None:
    chance = np.random.default_rng(seed)
    n = int(chance.integers(1, 30))
    place = float(chance.choice([chance.uniform(0, n - 1), chance.integers(0, n)]))
    half = float(chance.choice([0.0, chance.uniform(0, 5), 0.5, 1.0]))
    frames, weights = weights_at(place, half, n, "blend")
    assert weights.sum() == pytest.approx(1)
    assert (weights > 0).all()
    assert (np.diff(frames) > 0).all()
    dense = np.zeros(n)
    dense[frames] = weights
    assert dense == pytest.approx(blended_weights(place, half, n), abs=2e-4)


def test_whole_frames_are_averaged_where_nearest_is_asked_for() -> None:
    frames, weights = weights_at(10.0, 0.5, 30, "nearest")
    assert frames.tolist() == [9, 10]
    assert weights.tolist() == [0.5, 0.5]
    assert weights_at(10.5, 0.0, 30, "nearest")[0].tolist() == [11]
    assert weights_at(0.0, 3.0, 3, "nearest")[0].tolist() == [0, 1, 2]


def test_the_input_s_own_timing_is_the_input() -> None:
    plan = plan_frames(even(50), Warp([0, 49 / 30], [0, 49 / 30]))
    assert plan.stamps.tolist() == list(range(50))
    assert plan.halves.max() == 0
    for k in range(50):
        frames, weights = plan.shown(k, 50)
        assert (frames.tolist(), weights.tolist()) == ([k], [1.0])


def test_a_shutter_that_is_half_open_averages_half() -> None:
    warp = Warp([0, 1], [0, 4])
    whole = plan_frames(even(121), warp, shutter=1.0).halves
    half = plan_frames(even(121), warp, shutter=0.5).halves
    assert whole[10] == pytest.approx(1.5)
    assert half[10] == pytest.approx(0.5)
    assert plan_frames(even(121), warp, shutter=0.0).halves.max() == 0


def test_a_lower_rate_averages_too() -> None:
    plan = plan_frames(even(121, 60), Warp([0, 2], [0, 2]), rate=Fraction(15))
    assert len(plan.stamps) == 31
    assert plan.halves[10] == pytest.approx(1.5)


def test_places_follow_frames_that_are_not_even() -> None:
    stamps = np.array([0, 10, 40, 50, 100])
    times = FrameTimes(stamps, Fraction(1, 100), Fraction(5), False)
    assert times.places(np.array([-1.0, 0.25, 0.75, 5.0])).tolist() == [0, 1.5, 3.5, 4]
    plan = plan_frames(times, Warp([0, 2], [0, 1]))
    assert plan.base <= Fraction(1, 10_000)
    assert (plan.stamps * plan.base).tolist() == [Fraction(k, 50) for k in stamps.tolist()]
    assert [plan.shown(k, 5)[0].tolist() for k in range(5)] == [[0], [1], [2], [3], [4]]


def test_the_last_frame_is_shown_for_as_long_as_most_are() -> None:
    """Of a damaged file a stamp may be hours off: a mean made the last frame, and the sound under it, hours long."""
    seconds = [0.0, 0.1, 0.2, 0.3, 61_935.0]
    frames = FrameTimes(
        np.array([round(time * 90_000) for time in seconds]), Fraction(1, 90_000), Fraction(4, 61_935), False
    )
    plan = plan_frames(frames, Warp([0.0, 0.6], [0.0, 0.3]))
    assert float(plan.end * plan.base) == pytest.approx(0.7)
    # Where half of them are shown for longer, so may the last one be.
    frames = FrameTimes(np.array([0, 1, 5, 9]), Fraction(1, 10), Fraction(10, 3), False)
    plan = plan_frames(frames, Warp([0.0, 0.9], [0.0, 0.9]))
    assert float(plan.end * plan.base) == pytest.approx(1.3)


def test_what_is_played_backward_is_shown_again() -> None:
    times = FrameTimes(np.array([0, 10, 40, 50, 100]), Fraction(1, 100), Fraction(5), False)
    plan = plan_frames(times, Warp([0, 1, 2], [0, 1, 0]))
    assert [plan.shown(k, 5)[0].tolist() for k in range(len(plan.stamps))] == [[k] for k in (0, 1, 2, 3, 4, 3, 2, 1, 0)]


@pytest.mark.parametrize("seed", range(10))
def test_pieces_lie_on_the_warp_and_are_long_enough(seed) -> None:
    chance = np.random.default_rng(seed)
    t = np.cumsum(chance.uniform(0.01, 0.1, 200))
    w = np.cumsum(chance.uniform(0.0, 0.15, 200) * (chance.random(200) > 0.1))
    keys = [(float(w[k]), float(t[k])) for k in (50, 120)]
    warp = Warp(t, w, keytimes=keys)
    pieces = pieces_of(warp)
    assert pieces[0].output_start == t[0]
    assert pieces[-1].output_end == t[-1]
    ends = [piece.output_end for piece in pieces]
    for key in warp.keytimes:
        assert key.output_time in ends
    for piece, after in zip(pieces, [*pieces[1:], None], strict=True):
        assert warp(piece.output_end) == pytest.approx(piece.input_end)
        if after is not None:
            assert piece.output_end == after.output_start
    # Of those between holds and keytimes.
    free = pieces_of(Warp(t, np.cumsum(chance.uniform(0.01, 0.1, 200))))
    assert min(piece.output_end - piece.output_start for piece in free) >= SHORTEST - 1e-9


@pytest.mark.parametrize("seed", range(10))
def test_spans_shown_are_those_of_dense_samples(seed) -> None:
    chance = np.random.default_rng(seed)
    t = np.concatenate([[0.0], np.cumsum(chance.uniform(0.1, 1.0, 8))])
    warp = Warp(t, np.cumsum(chance.uniform(-1.0, 1.5, 9)))
    low = float(np.quantile(warp.input_times, 0.3))
    spans = spans_shown(warp, low, low + 0.7)
    dense = np.linspace(0, t[-1], 4001)
    inside = (warp(dense) >= low) & (warp(dense) < low + 0.7)
    said = np.zeros(len(dense), bool)
    for start, stop in spans:
        said |= (dense >= start) & (dense <= stop)
    assert np.mean(inside != said) < 0.006
