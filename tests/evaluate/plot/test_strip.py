import numpy as np
import pytest

from retime.evaluate.metrics.flights import flight_spans
from retime.evaluate.plot.strip import plan_strip
from retime.warp.curve import Warp
from retime.warp.spline import linear_warp
from tests.evaluate.figures import FLIGHT, flight_of, jumper, keeping_flight, ramp


@pytest.mark.parametrize("n_poses", [12, 17, 24, 30, 41, 60])
@pytest.mark.parametrize("lead", [1.0, 1.37, 2.0])
def test_a_row_that_keeps_the_flight_shows_as_many_poses_of_it_as_the_input(n_poses: int, lead: float) -> None:
    motion = jumper(lead=lead, rest=1.5)
    found = flight_spans(motion)
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
    strip = plan_strip(motion, {"w": keeping_flight(motion, 0.65)}, flight_spans(motion))
    assert not strip.aligned
    assert (strip.left, strip.right) == (0.0, motion.end_time)
    assert [(row.origin, row.start) for row in strip.rows] == [(0.0, 0.0)] * 2
    assert [row.stop for row in strip.rows] == [motion.end_time, 0.65 * motion.end_time]


@pytest.mark.parametrize("lead", [0.5, 30.0, 59.0])
def test_a_long_clip_is_shown_around_its_flight_with_take_off_at_zero(lead: float) -> None:
    motion = jumper(lead=lead, rest=60.0 - lead)
    (flight,) = flight_spans(motion)
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
    strip = plan_strip(motion, {"cut": cut}, flight_spans(motion), 30)
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
    ((start, stop),) = flight_spans(motion)
    begin, end = flight_of(motion, 1.0)
    assert begin <= start < stop <= end
    assert stop - start > FLIGHT / 2
    assert flight_spans(ramp()) == ()
    assert flight_spans(None) == ()
