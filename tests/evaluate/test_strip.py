import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from retime.evaluate.strip import flight_times, output_intervals, plan_strip
from retime.warp.curve import Warp
from retime.warp.spline import linear_warp
from tests.evaluate.figures import FLIGHT, flight_of, jumper, keeping_flight, ramp

times = st.integers(0, 12).map(lambda n: n / 4)


@given(
    st.lists(times, min_size=2, max_size=8),
    times,
    times,
    st.lists(st.floats(0, 1), min_size=1, max_size=20),
)
def test_an_output_time_is_in_an_interval_where_its_input_time_is_between(
    inputs: list[float], a: float, b: float, shares: list[float]
) -> None:
    low, high = min(a, b), max(a, b)
    warp = Warp(np.arange(float(len(inputs))), np.array(inputs))
    intervals = output_intervals(warp, low, high)
    for earlier, later in itertools.pairwise(intervals):
        assert earlier[1] < later[0]
    for share in shares:
        output_time = share * warp.output_end
        input_time = float(warp(output_time))
        inside = any(start <= output_time <= stop for start, stop in intervals)
        if min(abs(input_time - low), abs(input_time - high)) > 1e-6:
            assert inside == (low < input_time < high)


def test_a_warp_that_comes_back_shows_a_flight_twice() -> None:
    there_and_back = Warp(np.array([0.0, 4.0, 8.0]), np.array([0.0, 4.0, 0.0]))
    assert output_intervals(there_and_back, 1.0, 2.0) == ((1.0, 2.0), (6.0, 7.0))


def test_a_hold_inside_a_flight_belongs_to_it_and_one_outside_does_not() -> None:
    warp = Warp(np.array([0.0, 1.0, 3.0, 4.0]), np.array([0.0, 1.0, 1.0, 2.0]))
    assert output_intervals(warp, 0.5, 1.5) == ((0.5, 3.5),)
    assert output_intervals(warp, 1.25, 1.5) == ((3.25, 3.5),)


@pytest.mark.parametrize("n_poses", [12, 17, 24, 30, 41, 60])
@pytest.mark.parametrize("lead", [1.0, 1.37, 2.0])
def test_a_row_that_keeps_the_flight_shows_as_many_poses_of_it_as_the_input(n_poses: int, lead: float) -> None:
    motion = jumper(lead=lead, rest=1.5)
    found = flight_times(motion)
    kept = keeping_flight(motion, 0.65)
    linear = linear_warp([(0, 0), (motion.end_time, 0.65 * motion.end_time)])
    strip = plan_strip(motion, {"linear": linear, "kept": kept}, found, n_poses)
    counts = [row.poses_in(row.flights[0]) for row in strip.rows]
    assert counts[2] == counts[0] >= 2
    assert counts[1] < counts[0]
    for row in strip.rows:
        np.testing.assert_allclose(np.diff(row.pose_times), strip.step)
        assert row.pose_times[0] >= row.start
        assert row.pose_times[-1] <= row.stop
        # The whole row is used: not another pose would fit.
        assert row.pose_times[0] - strip.step < row.start
        assert row.pose_times[-1] + strip.step > row.stop


def test_a_short_clip_is_shown_whole() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    strip = plan_strip(motion, {"w": keeping_flight(motion, 0.65)}, flight_times(motion))
    assert not strip.aligned
    assert (strip.left, strip.right) == (0.0, motion.end_time)
    assert [(row.origin, row.start) for row in strip.rows] == [(0.0, 0.0)] * 2
    assert [row.stop for row in strip.rows] == [motion.end_time, 0.65 * motion.end_time]


@pytest.mark.parametrize("lead", [0.5, 30.0, 59.0])
def test_a_long_clip_is_shown_around_its_flight_with_take_off_at_zero(lead: float) -> None:
    motion = jumper(lead=lead, rest=60.0 - lead)
    (flight,) = flight_times(motion)
    warps = {
        "linear": linear_warp([(0, 0), (motion.end_time, 40)]),
        "kept": keeping_flight(motion, 0.65),
    }
    strip = plan_strip(motion, warps, (flight,), 30)
    assert strip.aligned
    for row in strip.rows:
        assert float(row.warp(row.origin)) == pytest.approx(flight[0])
        assert row.flights[0][0] == pytest.approx(row.origin)
        assert row.start - row.origin >= strip.left - 1e-9
        assert row.stop - row.origin <= strip.right + 1e-9
    assert strip.right - strip.left == pytest.approx(30 * strip.step)
    assert strip.left < 0 < flight[1] - flight[0] < strip.right
    counts = [row.poses_in(row.flights[0]) for row in strip.rows]
    assert counts == [5, 3, 5]


def test_of_a_long_clip_that_never_leaves_the_ground_the_middle_is_shown() -> None:
    motion = jumper(lead=100.0, rest=0.0, jump=False)
    strip = plan_strip(
        motion,
        {"w": linear_warp([(0, 0), (motion.end_time, 50)])},
        (),
        30,
    )
    assert strip.aligned
    assert strip.anchor == motion.end_time / 2
    assert [row.origin for row in strip.rows] == pytest.approx([motion.end_time / 2, 25.0])
    assert (strip.left + strip.right) / 2 == pytest.approx(0.0)


def test_poses_are_never_closer_than_frames() -> None:
    motion = jumper(lead=0.5, rest=0.5).frames(0, 5)
    strip = plan_strip(
        motion,
        {"w": linear_warp([(0, 0), (motion.end_time, 0.05)])},
        (),
        30,
    )
    assert strip.step == pytest.approx(1 / 60)
    np.testing.assert_allclose(strip.rows[0].pose_times * 60, np.arange(5), atol=1e-9)


def test_a_single_frame_has_a_strip() -> None:
    motion = jumper(lead=0.5, rest=0.5).frames(0, 1)
    strip = plan_strip(motion, {"hold": Warp(np.array([0.0, 1.0]), np.array([0.0, 0.0]))}, (), 10)
    assert all(len(row.pose_times) for row in strip.rows)


def test_a_warp_that_cuts_the_flight_out_still_has_a_row() -> None:
    motion = jumper(lead=40.0, rest=10.0)
    cut = Warp(np.array([0.0, 20.0]), np.array([0.0, 30.0]))
    strip = plan_strip(motion, {"cut": cut}, flight_times(motion), 30)
    row = strip.rows[1]
    assert row.flights == ()
    # Aligned at the moment nearest to the take-off: its end.
    assert row.origin == 20.0
    assert row.pose_times.max() <= 20.0


def test_a_warp_called_input_is_not_taken_for_the_input() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    strip = plan_strip(motion, {"input": keeping_flight(motion, 0.65)}, ())
    assert [row.stop for row in strip.rows] == [motion.end_time, 0.65 * motion.end_time]


def test_flights_are_those_of_the_motion_in_seconds() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    ((start, stop),) = flight_times(motion)
    begin, end = flight_of(motion, 1.0)
    assert begin <= start < stop <= end
    assert stop - start > FLIGHT / 2
    assert flight_times(ramp()) == ()
    assert flight_times(None) == ()
