"""How fast a hand plays each moment of its input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from retime.search.example.timing import FASTEST, SLOWEST, hand_log_speeds
from retime.warp.curve import Warp
from tests.reference.hand_speeds import seconds_shown


@st.composite
def hands(draw: st.DrawFn) -> Warp:
    """Draw warps that play, hold and run back."""
    pieces = draw(st.integers(1, 6))
    durations = draw(st.lists(st.floats(0.05, 1.0), min_size=pieces, max_size=pieces))
    moves = draw(st.lists(st.sampled_from([-0.4, 0.0, 0.1, 0.5, 1.0]), min_size=pieces, max_size=pieces))
    inputs = np.concatenate([[0.0], np.cumsum(moves)])
    if np.ptp(inputs) == 0:
        inputs[-1] += 0.3
    return Warp(np.concatenate([[0.0], np.cumsum(durations)]), inputs)


@given(hands(), st.floats(0.0, 1.0), st.floats(0.01, 0.3))
def test_a_speed_is_input_over_all_the_output_that_shows_it(hand: Warp, share: float, window: float) -> None:
    low, high = float(hand.input_times.min()), float(hand.input_times.max())
    half = min(window, high - low) / 2
    middle = min(max(low + share * (high - low), low + half), high - half)
    edges = middle - half, middle + half
    # A hold at the very edge of the window belongs to either side.
    if any(abs(x - edge) < 1e-6 for x in hand.input_times for edge in edges):
        return
    shown = seconds_shown(hand.output_times, hand.input_times, *edges)
    wanted = -math.log(min(max(shown / (2 * half), 1 / FASTEST), 1 / SLOWEST))
    assert hand_log_speeds(hand, [middle], window)[0] == pytest.approx(wanted, abs=1e-9)


def test_beyond_its_input_a_hand_plays_as_at_its_ends() -> None:
    hand = Warp([0.0, 2.0, 3.0], [0.5, 1.5, 4.5])
    assert np.exp(hand_log_speeds(hand, [-1.0, 0.0, 9.0], 0.1)) == pytest.approx([0.5, 0.5, 3.0])


def test_a_hold_is_slow_and_a_stretch_run_back_and_forth_plays_a_third_as_fast() -> None:
    hold = Warp([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 1.0, 2.0])
    assert math.exp(hand_log_speeds(hold, [1.0], 0.2)[0]) == pytest.approx(0.2 / 1.2)
    again = Warp([0.0, 2.0, 3.0, 5.0], [0.0, 2.0, 1.0, 3.0])
    assert np.exp(hand_log_speeds(again, [0.5, 1.5, 2.5], 0.1)) == pytest.approx([1.0, 1 / 3, 1.0])
