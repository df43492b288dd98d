"""How evenly walks are hurried or slowed."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from retime.evaluate.metrics.walking import WalkedStep, step_spread, walk_speeds, walked_steps, walking_spans
from retime.warp.curve import Warp
from tests.motion.leaps import jumps, leaper, run
from tests.motion.strides import strides
from tests.motion.walkers import renamed


@pytest.mark.parametrize("rate", [30, 120])
@pytest.mark.parametrize("stance", [0.5, 0.7, 1.0])
def test_steps_of_a_walk_that_is_known(stance: float, rate: int) -> None:
    motion, touches = strides(stance, rate=rate)
    steps = walked_steps(motion)
    # The left foot lands as the clip begins.
    landings = [0.0, *np.sort(np.concatenate([np.flatnonzero(~t[:-1] & t[1:]) + 1 for t in touches.T])) / rate]
    assert len(steps) == len(landings) - 1
    # A foot is known to stand when it has come to rest.
    assert [step.start for step in steps] == pytest.approx(landings[:-1], abs=0.1 + 1e-9)
    assert all(a.side != b.side and a.end == b.start for a, b in itertools.pairwise(steps))
    assert walking_spans(steps) == ((steps[0].start, steps[-1].end),)
    # As long as the plan's; but for the first, which begins with the clip.
    assert [step.end - step.start for step in steps[1:]] == pytest.approx(np.diff(landings)[1:], abs=0.07)


def test_runs_jumps_and_walking_on_the_spot_are_no_walks() -> None:
    assert walked_steps(leaper(run(0.13, 0.13), speed=7.0, lift=0.4)[0]) == ()
    assert walked_steps(leaper(jumps(0.4, 0.4))[0]) == ()
    motion, _ = strides(0.6)
    # On a treadmill: everything goes back as fast as the root gets ahead.
    local = motion.local_translations.copy()
    local[:, 0, 2] = 0
    assert walked_steps(motion)
    assert walked_steps(replace(motion, translations=local)) == ()
    assert walked_steps(renamed(motion, {name: f"n{i}" for i, name in enumerate(motion.skeleton.names)})) == ()


def test_speeds_are_weighed_by_the_input() -> None:
    # 94 % of the walk at unit speed, 6 % in a single step of 1/30 s; outside it something faster still.
    warp = Warp([0.0, 1.0, 10.4, 10.4 + 1 / 30], [-30.0, 0.0, 9.4, 10.0])
    found = walk_speeds(warp, [(0.0, 10.0)])
    assert found is not None
    assert (found.low, found.high) == pytest.approx((1.0, 18.0))
    assert (found.longest_fast, found.longest_slow) == pytest.approx((0.6, 0.0))


def test_stretches_end_with_a_walk_and_where_the_speed_is_even_for_a_moment() -> None:
    # 2 s at twice the speed, then 0.1 s at unit speed, 1 s at twice, 1.5 s at half.
    times = np.cumsum([0.0, 1.0, 0.1, 0.5, 3.0])
    warp = Warp(times, np.cumsum([0.0, 2.0, 0.1, 1.0, 1.5]))
    whole = walk_speeds(warp, [(0.0, 4.6)])
    assert whole is not None
    assert (whole.longest_fast, whole.longest_slow) == pytest.approx((2.0, 1.5))
    apart = walk_speeds(warp, [(0.0, 0.8), (0.8, 1.5), (3.5, 4.0)])
    assert apart is not None
    assert (apart.longest_fast, apart.longest_slow) == pytest.approx((0.8, 0.5))
    assert (apart.low, apart.high) == pytest.approx((0.5, 2.0))


def test_where_nobody_walks_there_are_no_speeds() -> None:
    warp = Warp([0.0, 1.0], [0.0, 1.0])
    assert walk_speeds(warp, []) is None
    assert walk_speeds(warp, [(5.0, 6.0)]) is None


def test_a_spread_of_steps_by_hand() -> None:
    steps = [WalkedStep(0.0, 1.0, "left"), WalkedStep(1.0, 1.5, "right"), WalkedStep(3.0, 4.0, "left")]
    even = Warp([0.0, 2.0], [0.0, 4.0])
    assert step_spread(even, steps) == pytest.approx(0.0)
    # The last step takes all of its time, the others half of it: 0.5, 0.5, 1.
    uneven = Warp([0.0, 1.5, 2.5], [0.0, 3.0, 4.0])
    assert step_spread(uneven, steps) == pytest.approx(np.std([0.5, 0.5, 1.0]))
    assert step_spread(even, steps[:1]) is None
