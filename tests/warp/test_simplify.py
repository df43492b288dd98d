"""Fewer knots: within the tolerance everywhere, with what must stay."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import OptionError
from retime.warp.curve import Warp
from tests.warp.drawn import warps


@settings(max_examples=100, deadline=None)
@given(warps(forward=False, keys=4), st.sampled_from([0.0, 1e-6, 0.001, 0.03, 0.5, 10.0]))
def test_a_simplified_warp_keeps_to_its_tolerance(warp: Warp, tolerance: float) -> None:
    simple = warp.simplify(tolerance)
    assert set(simple.output_times) <= set(warp.output_times)
    assert simple.domain == warp.domain
    # Between knots of either the error is linear, so it is largest at one.
    assert (
        np.abs(simple(warp.output_times) - warp.input_times).max() <= tolerance + 1e-12 * np.abs(warp.input_times).max()
    )
    for key in warp.keytimes:
        assert float(simple(key.output_time)) == key.input_time
    # Where it holds, turns or plays forward is as it was.
    middles = (warp.output_times[1:] + warp.output_times[:-1]) / 2
    np.testing.assert_array_equal(np.sign(simple.speed(middles)), np.sign(warp.speed(middles)))


def test_knots_on_a_straight_line_go_at_no_tolerance() -> None:
    times = np.arange(500) / 24
    warp = Warp(times, np.where(times < 7, times * 0.3, 2.1 + (times - 7) * 1.7))
    assert warp.simplify(0).output_times.tolist() == [0.0, 7.0, times[-1]]


def test_a_curved_warp_needs_about_as_many_lines_as_its_bend_says() -> None:
    # A line over a width h misses a second derivative of 1 by h²/8 in its middle.
    times = np.linspace(0, 10, 5001)
    tolerance = 0.002
    simple = Warp(times, times**2 / 2).simplify(tolerance)
    best = 10 / np.sqrt(8 * tolerance)
    assert best <= len(simple.output_times) - 1 <= 1.03 * best + 1


@pytest.mark.parametrize("tolerance", [-1.0, np.inf, np.nan])
def test_a_tolerance_that_is_none_is_refused(tolerance: float) -> None:
    with pytest.raises(OptionError, match="tolerance"):
        Warp([0.0, 1.0], [0.0, 1.0]).simplify(tolerance)
