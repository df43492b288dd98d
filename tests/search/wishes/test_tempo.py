"""Natural hurry: the price is what it says, the search stays exact with it, and clips come out as they should."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest

import retime
from retime.errors import OptionError
from retime.kernels import StepPairs
from retime.motion.signal import Signal
from retime.search.reduction import reduce_to_compression
from retime.search.session import Session
from retime.search.wishes.tempo import tempo_of, tempo_prices
from retime.warp.keytime import Keytime
from tests.reference import tempo as literal
from tests.reference import wishes as paths_by_hand
from tests.reference.wishes import Wishes

RATE = 30.0


def moves_and_stands(rng: np.random.Generator, n_frames: int) -> np.ndarray:
    """Pose vectors that stand still here and there."""
    moving = np.repeat(rng.random(n_frames // 5 + 1) < 0.6, 5)[:n_frames]
    return np.cumsum(rng.normal(size=(n_frames, 4)) * moving[:, None], axis=0)


@pytest.mark.parametrize("seed", range(6))
def test_activity_is_what_its_definition_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rate, time_scale = float(rng.choice([15, 24, 30, 60])), float(rng.choice([1 / 30, 0.2]))
    poses = moves_and_stands(rng, int(rng.integers(3, 60)))
    found = tempo_of(poses, rate, time_scale, [])
    scale, activities = literal.activity(literal.movement(poses.tolist(), rate, time_scale))
    assert found.scale == pytest.approx(scale, rel=1e-12)
    np.testing.assert_allclose(found.activity, activities, rtol=1e-9, atol=1e-12)


def test_what_never_moves_has_no_price() -> None:
    still = tempo_of(np.ones((40, 3)), RATE, 0.2, [])
    assert still.scale == 0.0
    assert not still.activity.any()


def test_flights_reach_one_analysis_frame_to_either_side() -> None:
    found = tempo_of(np.zeros((40, 1)), RATE, 0.2, [(10 / 30, 12 / 30)])
    assert np.flatnonzero(found.flying(np.arange(40) / 30)).tolist() == [9, 10, 11, 12, 13]


@pytest.mark.parametrize("seed", range(8))
def test_prices_are_those_of_the_literal_twin(seed: int) -> None:
    rng = np.random.default_rng(seed)
    keys = [(0.0, 0.0), (0.8, 0.5), (0.8, 0.7), (0.3, 1.2), (1.2, 1.6)]
    keytimes = [Keytime(input_time=i, output_time=o) for i, o in keys]
    upsamples = [int(u) for u in rng.choice([1, 2, 4], len(keys) - 1)]
    reduction = reduce_to_compression(keytimes, 1.2, rate=RATE, upsample=upsamples)
    tempo = tempo_of(moves_and_stands(rng, 37), RATE, 0.2, [(0.2, 0.4)])
    steps = StepPairs.of([1, 2, 3, 4, 6, 8], ratio=2.05)
    weights = {"evenness": float(rng.choice([0.0, 4.0])), "keep_flights": float(rng.choice([0.0, 24.0]))}
    prices = tempo_prices(tempo, reduction, steps, **weights)
    activities = tempo.activity_at(reduction.input_times)
    flying = tempo.flying(reduction.input_times)
    held, upsample_at = reduction.held, reduction.upsample_at
    for frame in range(reduction.n_input):
        for place, step in enumerate(steps.steps.tolist()):
            if frame + step >= reduction.n_input:
                continue
            passed = slice(frame, frame + step + 1)
            expected = literal.price(
                step, int(upsample_at[frame]), activities[passed], flying[passed], scale=tempo.scale, **weights
            )
            assert prices[frame, place] == pytest.approx(0.0 if held[frame] else expected, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("wish", ["none", "lock", "tangent", "limits", "key"])
@pytest.mark.parametrize("seed", range(4))
def test_the_path_has_the_least_sum_of_scores_and_prices(seed: int, wish: str) -> None:
    """Every path of a small problem is tried."""
    rng = np.random.default_rng(100 + seed)
    clip = Signal(("x", "y"), moves_and_stands(rng, 9)[:, :2], Fraction(30))
    session = Session(clip, flights=[(2 / 30, 4 / 30)], low_pass=0, n_neighbors=2)
    asked = {
        "none": {},
        "lock": {"locks": [retime.Lock(0.1, 0.2, 1.0, 1.0)]},
        "tangent": {"keys": [(0.13, 0.1, 1.5)]},
        "limits": {"speed": (0.5, 2.0)},
        "key": {"keys": [(0.1, 0.1)]},
    }[wish]
    found = session.solve(length="7f", evenness=4.0, keep_flights=24.0, upsample=2, **asked)
    plan, reduction = found.plan, found.reduction
    assert found.tempo_prices is not None
    # What the search was offered, with every change of speed open where somebody asks for one.
    poses = found.input_poses
    every = StepPairs.of(plan.steps.steps)
    scores = session._triples(poses, every, session._model)
    places = {int(step): place for place, step in enumerate(every.steps)}
    lock = asked.get("locks", [])
    limits = asked.get("speed", (0.0, math.inf))
    totals = {}
    for path in paths_by_hand.paths(reduction, every, Wishes(lock, *limits), [reduction.n_output]):
        cost = found.tempo_prices[0, places[path[1]]]
        for (i, j), (_, k) in itertools.pairwise(itertools.pairwise(path)):
            near = bool(paths_by_hand.follows(plan.steps, j - i, k - j)) or j in plan.loose
            pair = int(every.pair_of(np.array(j - i), np.array(k - j)))
            cost += scores[j, pair] + found.tempo_prices[j, places[k - j]] if near else math.inf
        totals[path] = cost
    least = min(totals.values())
    assert math.isfinite(least)
    assert found.total == pytest.approx(least, rel=1e-9)
    assert totals[tuple(found.path.frames.tolist())] == pytest.approx(least, rel=1e-9)


# What comes of it


@pytest.fixture(scope="module")
def sample() -> retime.Motion:
    return retime.sample()


def speeds(warp: retime.Warp, start: float, end: float) -> np.ndarray:
    """Playback speeds while a stretch of the input is shown."""
    times = np.linspace(*warp.domain, 3000)[:-1]
    inputs = warp(times)
    return warp.speed(times)[(inputs >= start) & (inputs < end)]


def test_an_unchanged_length_is_the_identity(sample) -> None:
    found = retime.guided_warp(sample, length="100%")
    np.testing.assert_allclose(found.warp.input_times, found.warp.output_times, atol=1e-12)


@pytest.mark.parametrize("length", ["80%", "65%", "150%"])
def test_flights_keep_unit_speed(sample, length) -> None:
    found = retime.guided_warp(sample, length=length)
    assert found.path.optimal
    flights = sample.flights()
    assert len(flights) == 2
    for first, last in flights:
        inside = speeds(found.staircase, first / float(sample.rate), last / float(sample.rate))
        np.testing.assert_allclose(inside, 1.0, atol=1e-9)


def walk(n_frames: int) -> Signal:
    """Something that moves evenly in a circle for ever."""
    t = np.arange(n_frames) / 30
    return Signal(("x", "y"), np.stack([np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)], axis=1), Fraction(30))


def test_what_moves_evenly_is_hurried_evenly() -> None:
    found = retime.guided_warp(walk(150), length="80%", evenness=4.0)
    inside = speeds(found.warp, 0.5, 4.4)
    assert inside.min() > 1.1
    assert inside.max() < 1.4
    rushed = retime.guided_warp(walk(150), length="80%", evenness=0)
    assert np.ptp(speeds(rushed.warp, 0.5, 4.4)) > 2 * np.ptp(inside)


def test_pauses_give_way_first() -> None:
    moving = walk(60).values
    clip = Signal(("x", "y"), np.concatenate([moving, np.repeat(moving[-1:], 60, axis=0), moving]), Fraction(30))
    found = retime.guided_warp(clip, length="75%", evenness=4.0)
    assert speeds(found.warp, 2.3, 3.6).mean() > 2.0
    assert abs(speeds(found.warp, 0.3, 1.7).mean() - 1) < 0.2


def test_signals_and_the_paper_have_no_price_and_figures_have(sample) -> None:
    assert retime.guided_warp(walk(60), length="80%").tempo is None
    assert retime.guided_warp(sample, length="80%", paper=True).tempo is None
    assert retime.guided_warp(sample, length="80%", evenness=0, keep_flights=0).tempo is None
    assert retime.guided_warp(sample, length="80%").tempo is not None


def test_the_paper_is_read_literally(sample) -> None:
    literal_way = retime.guided_warp(
        sample, length="80%", features="torso", time_scale=1 / 30, evenness=0, keep_flights=0
    )
    found = retime.guided_warp(sample, length="80%", paper=True)
    assert np.array_equal(found.path.frames, literal_way.path.frames)
    assert found.total == literal_way.total
    # What is given beside it holds.
    assert retime.guided_warp(sample, length="80%", paper=True, time_scale=0.1).time_scale == 0.1


def test_flights_that_a_person_names_are_kept() -> None:
    clip = walk(150)
    found = retime.guided_warp(clip, length="80%", evenness=4.0, keep_flights=24.0, flights=[(2.0, "2.5s")])
    np.testing.assert_allclose(speeds(found.warp, 2.0, 2.49), 1.0, atol=1e-6)


@pytest.mark.parametrize("flights", [[(2.0,)], ["2..3"], [(3.0, 2.0)], [(-1.0, 2.0)], [(1.0, 99.0)]])
def test_flights_that_are_none_are_refused(flights) -> None:
    with pytest.raises(OptionError, match="flight"):
        retime.guided_warp(walk(60), length="80%", flights=flights)


@pytest.mark.parametrize("length", ["20%", "33%", "90%", "300%", "900%", "free"])
def test_any_length_is_met(sample, length) -> None:
    found = retime.guided_warp(sample, length=length)
    assert found.path.optimal
    if length != "free":
        assert found.apply().n_frames == round(float(length[:-1]) / 100 * sample.n_frames)
