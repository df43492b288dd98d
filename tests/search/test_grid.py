"""How fine the input is offered where nobody says, and what that does to steps of a walk."""

from __future__ import annotations

import math

import numpy as np
import pytest

import retime
from retime.evaluate.metrics.walking import WalkedStep, step_spread
from retime.motion.signal import Signal
from retime.search.grid import choose_upsamples, natural_steps
from retime.search.reduction import reduce_to_compression
from retime.search.wishes.asked import Wishes
from retime.warp.keytime import Keytime

RATE = 30.0


def wishes(end: float) -> Wishes:
    return Wishes(end, (), (), 0.0, math.inf)


@pytest.mark.parametrize(("end", "shorter", "longer"), [(20.0, 4, 12), (60.0, 4, 12), (61.0, 4, 4), (121.0, 2, 3)])
def test_what_gets_longer_is_offered_finely_up_to_a_minute(end: float, shorter: int, longer: int) -> None:
    keytimes = [
        Keytime(input_time=end * i / 3, output_time=end * o / 3) for i, o in ((0, 0), (1, 0.8), (2, 1.8), (3, 3))
    ]
    found = choose_upsamples(keytimes, wishes(end), itself=True, loop=False, natural=True)
    assert found == (shorter, 1, longer)
    # Without natural hurry, twelfths would buy nothing.
    assert choose_upsamples(keytimes, wishes(end), itself=True, loop=False) == (1, 1, 4)


@pytest.mark.parametrize(
    ("given", "another", "expected"),
    [
        ({"length": "80%"}, False, (4, 32)),
        ({"length": "125%"}, False, (12, 96)),
        # The paper's steps: whole frames, and quarters where the clip gets longer.
        ({"length": "80%", "max_skip": 8}, False, (1, 8)),
        ({"length": "125%", "max_skip": 8}, False, (4, 8)),
        ({"length": "80%", "evenness": 0, "keep_flights": 0}, False, (1, 8)),
        ({"length": "100%"}, True, (8, 16)),
    ],
)
def test_a_figure_gets_the_steps_that_the_options_page_says(
    given: dict[str, object], another: bool, expected: tuple[int, int]
) -> None:
    clip = retime.sample()[40:160]
    reference = retime.sample()[100:200] if another else None
    found = retime.guided_warp(clip, reference=reference, **given)
    assert (found.upsample, found.max_skip) == expected


@pytest.mark.parametrize(
    ("upsample", "expected"),
    [
        (1, [1, 2, 3, 4, 8]),
        (2, [1, 2, 3, 4, 6, 8, 16]),
        (4, [1, 2, 3, 4, 5, 6, 8, 12, 16, 32]),
        (12, [*range(1, 13), 15, 18, 24, 36, 48, 64]),
    ],
)
def test_steps_lie_close_about_unit_speed_and_an_octave_apart_beyond(upsample: int, expected: list[int]) -> None:
    ends = [Keytime(input_time=0.0, output_time=0.0), Keytime(input_time=10.0, output_time=12.0)]
    reduction = reduce_to_compression(ends, 10.0, rate=RATE, upsample=upsample)
    steps = natural_steps(reduction, wishes(10.0), min(8 * upsample, 64))
    assert steps.steps.tolist() == expected
    # Whatever speed is played, the next ones to it may follow.
    assert (steps.first[1:] < range(1, steps.n_steps)).all()
    assert (steps.end[:-1] > range(1, steps.n_steps)).all()


@pytest.mark.parametrize("seed", range(3))
def test_steps_of_what_never_rests_are_slowed_alike(seed: int) -> None:
    rng = np.random.default_rng(seed)
    # An even gait, and a little noise; its steps are half turns.
    turns = np.arange(300) / 30
    values = np.column_stack([np.cos(2 * np.pi * turns), np.sin(2 * np.pi * turns), np.cos(4 * np.pi * turns)])
    walk = Signal(("x", "y", "z"), values + rng.normal(scale=0.01, size=values.shape), 30)
    steps = [WalkedStep(i / 2, (i + 1) / 2, "left" if i % 2 else "right") for i in range(2, 17)]
    spreads: dict[int | None, list[float]] = {None: [], 4: []}
    for upsample, found in spreads.items():
        for length in ("110%", "115%", "120%", "125%"):
            warp = retime.guided_warp(walk, length=length, evenness=4.0, upsample=upsample).warp
            spread = step_spread(warp, steps)
            assert spread is not None
            found.append(spread)
    assert max(spreads[None]) < 0.05 < np.mean(spreads[4])
    assert np.mean(spreads[None]) < np.mean(spreads[4]) / 2
