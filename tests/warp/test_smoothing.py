"""The mean of a warp over a window, against its definition; ends, keytimes and order kept."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import OptionError
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime
from tests.reference import curve as literal
from tests.warp.drawn import warps


@settings(max_examples=40)
@given(warps(forward=False, keys=3), st.floats(0, 3), st.booleans())
def test_smooth_is_the_mean_over_its_window(warp: Warp, window: float, elsewhere: bool) -> None:
    at = np.linspace(warp.output_start, warp.output_end, 9) if elsewhere else None
    smooth = warp.smooth(window, at=at)
    o, i = warp.output_times.tolist(), warp.input_times.tolist()
    keys = [key.output_time for key in warp.keytimes]
    size = np.abs(warp.input_times).max()
    for time, value in zip(smooth.output_times, smooth.input_times, strict=True):
        assert value == pytest.approx(literal.moving_average(o, i, keys, window, time), rel=1e-9, abs=1e-9 * size)
    wanted = set(warp.output_times.tolist() if at is None else at.tolist()) | {o[0], o[-1], *keys}
    np.testing.assert_allclose(smooth.output_times, sorted(wanted), rtol=0, atol=1e-9)


@settings(max_examples=40)
@given(warps(forward=False, keys=4), st.floats(0, 50))
def test_smooth_keeps_ends_and_keytimes_exactly(warp: Warp, window: float) -> None:
    smooth = warp.smooth(window)
    assert (smooth.output_start, smooth.output_end) == (warp.output_start, warp.output_end)
    assert smooth.keytimes == warp.keytimes
    ends = [Keytime(input_time=float(warp.input_times[k]), output_time=float(warp.output_times[k])) for k in (0, -1)]
    for key in (*warp.keytimes, *ends):
        assert float(smooth(key.output_time)) == key.input_time
        assert key.output_time in smooth.output_times


@settings(max_examples=40)
@given(warps(keys=4), st.floats(0, 50), st.integers(2, 200))
def test_a_monotone_warp_stays_monotone_when_smoothed(warp: Warp, window: float, n_knots: int) -> None:
    assert warp.monotone
    assert warp.smooth(window).monotone
    assert warp.smooth(window, at=np.linspace(warp.output_start, warp.output_end, n_knots)).monotone


@pytest.mark.parametrize("speed", [1.0, 0.25, -1.0, 0.0])
def test_a_straight_warp_stays_straight_when_smoothed(speed: float) -> None:
    times = np.arange(40) / 30
    warp = Warp(times, 3 + speed * times)
    np.testing.assert_allclose(warp.smooth(0.5).input_times, 3 + speed * times, rtol=0, atol=1e-14)


def test_smooth_leaves_holds_between_keytimes_at_rest() -> None:
    keys = [(0, 0), (1, 1), (2, 1), (3, 0), (4, 4)]
    warp = Warp(
        *np.array(keys, dtype=float).T, tuple(Keytime(input_time=float(i), output_time=float(o)) for o, i in keys)
    )
    smooth = warp.smooth(0.4, at=np.arange(0, 4.01, 0.01))
    inside = (smooth.output_times >= 1) & (smooth.output_times <= 2)
    assert (smooth.input_times[inside] == 1.0).all()
    backward = (smooth.output_times >= 2) & (smooth.output_times <= 3)
    assert (np.diff(smooth.input_times[backward]) < 0).all()


def test_smooth_takes_keytimes_in_any_order() -> None:
    times = np.arange(11.0)
    steps = np.cumsum([0.0, 1, 3, 1, 3, 1, 3, 1, 3, 1, 3])
    keys = [Keytime(input_time=float(np.interp(time, times, steps)), output_time=time) for time in (8.0, 2.0, 5.0)]
    shuffled = Warp(times, steps, tuple(keys)).smooth(4)
    ordered = Warp(times, steps, tuple(sorted(keys))).smooth(4)
    assert np.array_equal(shuffled.input_times, ordered.input_times)


@pytest.mark.parametrize("window", [-1.0, float("nan"), float("inf")])
def test_a_window_that_is_no_time_is_refused(window: float) -> None:
    with pytest.raises(OptionError, match="window"):
        Warp([0, 1], [0, 1]).smooth(window)
