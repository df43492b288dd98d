"""A warp in frames of a scene."""

from __future__ import annotations

import numpy as np
import pytest

from blender.timing import Line, Timing
from retime.warp.curve import Warp

TIMING = Timing(Warp([10.0, 20.0, 25.0, 40.0], [10.0, 40.0, 40.0, 60.0]), 24.0)


def test_what_comes_after_the_range_moves_with_its_end():
    warp = TIMING.reaching(-20, 100)
    assert warp([-15, 0, 9, 10, 41, 80]).tolist() == [-15, 0, 9, 10, 61, 100]
    assert [TIMING.moved(frame) for frame in (-7, 10, 25, 40, 60, 75)] == [-7, 10, 15, 20, 40, 55]


def test_a_range_that_is_played_from_its_middle_on():
    timing = Timing(Warp([0.0, 10.0], [5.0, 25.0]), 24.0)
    assert timing.moved(5) == 0
    # Never shown: as near as can be.
    assert timing.moved(30) == 15
    assert timing.reaching(0, 40)([-2.0, 0.0, 10.0, 12.0]).tolist() == [3.0, 5.0, 25.0, 27.0]


def test_a_frame_shown_twice_moves_to_where_it_is_shown_first():
    timing = Timing(Warp([0.0, 10.0, 20.0, 40.0], [0.0, 20.0, 10.0, 30.0]), 24.0)
    assert timing.moved(15) == 7.5
    assert timing.moved(25) == 35


@pytest.mark.parametrize("rate", [24.0, 30 / 1.001, 60.0])
def test_seconds_become_frames_and_seconds_again(rate):
    warp = Warp([0.0, 1.0, 2.5], [0.0, 2.0, 3.0])
    timing = Timing.of_seconds(warp, 101.0, rate)
    assert timing.start == 101.0
    assert timing.end == 101.0 + 2.5 * rate
    np.testing.assert_allclose(timing.in_seconds().input_times, warp.input_times, atol=1e-12)
    np.testing.assert_allclose(timing.in_seconds().output_times, warp.output_times, atol=1e-12)


def test_with_fewer_knots_keytimes_are_met_as_before():
    times = np.linspace(0, 4, 97)
    warp = Warp(times, times + 0.001 * np.sin(9 * times), [(1.0 + 0.001 * np.sin(9.0), 1.0)])
    timing = Timing.of_seconds(warp, 1.0, 24.0).simplified(0.2)
    assert len(timing.warp.output_times) == 3
    assert float(timing.warp(25.0)) == pytest.approx(1 + 24 * float(warp(1.0)), abs=1e-9)


def test_whole_frames_of_a_range_that_ends_between_two():
    assert Timing(Warp([1.0, 3.5], [1.0, 9.0]), 24.0).frames().tolist() == [1.0, 2.0, 3.0]
    # Rounding must not lose the last one.
    assert Timing(Warp([1.0, 3.9999999], [1.0, 9.0]), 24.0).frames().tolist() == [1.0, 2.0, 3.0, 4.0]


def test_a_strip_is_a_line_from_frames_to_frames():
    line = Line(at=10.0, start=3.0, speed=0.5)
    assert float(line.inner(20.0)) == 8.0
    assert line.outer(line.inner(np.array([1.0, 7.0]))).tolist() == [1.0, 7.0]
