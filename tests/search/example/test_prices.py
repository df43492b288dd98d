"""The price of a step that does not play as the hand did: literally, and searched among all paths."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import InfeasibleWarpError
from retime.kernels import StepPairs
from retime.motion.signal import Signal
from retime.search.example.prices import hand_prices
from retime.search.example.reading import ExampleReading
from retime.search.example.session import HandSession
from retime.search.poses.references import Reference
from retime.search.reduction import reduce_to_compression
from retime.search.wishes.locks import Lock
from retime.search.wishes.tempo import Tempo
from retime.warp.curve import Keytime
from tests.reference import hand_speeds as literal
from tests.reference.paths import every_path


def _key(input_time: float, output_time: float) -> Keytime:
    return Keytime(input_time=input_time, output_time=output_time)


def random_reading(rng: np.random.Generator, n_frames: int) -> ExampleReading:
    logs = rng.normal(0.0, 0.5, n_frames)
    return ExampleReading(0.0, 1.0, 30.0, logs, np.zeros(n_frames), 0.5, 2.0, True)


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_each_step_costs_what_is_said(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n_frames, upsample = int(rng.integers(3, 8)), int(rng.integers(1, 4))
    end = (n_frames - 1) / 30
    reduction = reduce_to_compression([_key(0.0, 0.0), _key(end, end)], end, rate=30.0, upsample=upsample)
    tempo = Tempo(30.0, rng.uniform(0.0, 1.09, n_frames), float(rng.choice([0.0, 2.5])), ())
    reading = random_reading(rng, n_frames)
    steps = StepPairs.of([1, 2, 3, 5])
    prices = hand_prices(reading, tempo, reduction, steps)
    logs, activity = reading.log_speeds_at(reduction.input_times), tempo.activity_at(reduction.input_times)
    for frame in range(reduction.n_input):
        for place, step in enumerate(steps.steps.tolist()):
            if frame + step < reduction.n_input:
                wanted = literal.hand_price(logs, activity, tempo.scale or 1.0, upsample, frame, step)
                assert prices[frame, place] == pytest.approx(wanted, rel=1e-9, abs=1e-12)


def test_a_hold_costs_nothing() -> None:
    keys = [_key(0.0, 0.0), _key(0.2, 0.2), _key(0.2, 0.4), _key(0.4, 0.6)]
    reduction = reduce_to_compression(keys, 0.4, rate=30.0)
    tempo = Tempo(30.0, np.ones(13), 1.0, ())
    prices = hand_prices(random_reading(np.random.default_rng(0), 13), tempo, reduction, StepPairs.of([1, 2]))
    assert not prices[reduction.held].any()
    assert prices[~reduction.held][:-2].any()


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
def test_of_all_paths_the_one_nearest_to_the_hand_is_found(seed: int, free: bool, locked: bool) -> None:
    rng = np.random.default_rng(seed)
    n_frames = 7
    signal = Signal(("x", "y"), np.cumsum(rng.normal(size=(n_frames, 2)), axis=0), Fraction(30))
    session = HandSession(signal, example=Reference(signal), reading=random_reading(rng, n_frames))
    length = "free" if free else f"{int(rng.integers(5, 10))}f"
    locks = [Lock(2 / 30, 4 / 30, 1.0, 1.0)] if locked else []
    try:
        found = session.solve(length=length, locks=locks, upsample=2, max_skip=4)
    except InfeasibleWarpError:
        assert locked
        return
    plan, steps = found.plan, found.plan.steps.steps.tolist()
    prices = hand_prices(session._reading, session.tempo, plan.reduction, StepPairs.of(steps))

    def costs(bound: bool) -> list[float]:
        """Price every path that keeps the lock, and where `bound`, no step that is too unlike the one before it."""
        totals = []
        for n_output in range(4, 14) if free else [found.n_output]:
            for path in every_path(found.n_input, n_output, 4):
                taken = np.diff(path)
                if locked and not ({4, 8} <= set(path) and all(taken[np.isin(path[:-1], [4, 5, 6, 7])] == 2)):
                    continue
                unlike = plan.steps.pair_of(taken[:-1], taken[1:]) < 0
                if bound and np.any(unlike & ~np.isin(path[1:-1], plan.loose)):
                    continue
                totals.append(sum(prices[j, steps.index(b)] for j, b in zip(path, taken, strict=False)))
        return totals

    totals = costs(bound=True) or costs(bound=False)
    assert found.path.total == pytest.approx(min(totals), abs=1e-9)
    assert found.path.optimal
