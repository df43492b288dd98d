"""Figures of merit, on made-up motion whose figures are known."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from retime.errors import OptionError
from retime.evaluate.metrics import (
    activity,
    fastest_speed,
    flight_spans,
    flight_timing,
    foot_slip,
    gravity,
    gravity_ratios,
    idle_spans,
    joint_speeds,
    match_keytimes,
    match_speeds,
    match_warps,
    path_warp,
    rms_jerk,
    seconds_shown,
    timing_distance,
)
from retime.motion.motion import Motion
from retime.motion.rotation import identity
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton
from retime.warp.apply import apply_warp
from retime.warp.curve import Keytime, Warp
from retime.warp.guided import guided_warp
from tests.evaluate.figures import FLIGHT, GRAVITY, jumper, keeping_flight

PAIR = Skeleton(("Hips", "LeftFoot"), (-1, 0), np.array([[0.0, 0.8, 0.0], [0.0, -0.8, 0.0]]))


def moving(places: np.ndarray, rate: int = 60, *, unit: float = 1.0) -> Motion:
    """Move a hip over a foot, without turning; places (n_frames, 3) are added to both."""
    translations = np.repeat(PAIR.offsets[None], len(places), axis=0)
    translations[:, 0] += places
    return Motion(PAIR, identity(len(places), 2), translations, Fraction(rate), metres_per_unit=unit)


def along(axis: int, values: np.ndarray, **how: float) -> Motion:
    places = np.zeros((len(values), 3))
    places[:, axis] = values
    return moving(places, **how)


def linear(motion: Motion, speed: float) -> Warp:
    return Warp([0.0, motion.end_time / speed], [0.0, motion.end_time])


# The whole flight as it was made, not as a threshold finds it.
JUMP = jumper(lead=1.0, rest=1.0)
ALOFT = ((1.0, 1.0 + FLIGHT),)


def test_a_fall_at_9_81_is_measured_as_such() -> None:
    assert gravity(JUMP, ALOFT) == pytest.approx([GRAVITY])


def test_a_fall_is_measured_in_metres_whatever_the_unit() -> None:
    places = np.repeat(JUMP.local_translations, 1, axis=0) * 20
    big = Motion(JUMP.skeleton, JUMP.rotations, places, JUMP.rate, metres_per_unit=0.05)
    assert gravity(big, ALOFT) == pytest.approx([GRAVITY])


def test_a_flight_of_three_frames_says_nothing() -> None:
    assert np.isnan(gravity(JUMP, [(1.0, 1.0 + 2 / 60)])).all()


@pytest.mark.parametrize("speed", [0.5, 1.0, 1.5, 2.0])
def test_played_c_times_faster_a_flight_falls_c_squared_times_harder(speed: float) -> None:
    warp = linear(JUMP, speed)
    shown = apply_warp(JUMP, warp, average=False)
    assert gravity_ratios(JUMP, shown, warp, ALOFT) == pytest.approx([speed**2], rel=0.03)


def test_a_warp_that_keeps_the_flight_keeps_gravity() -> None:
    warp = keeping_flight(JUMP, 0.7)
    assert gravity_ratios(JUMP, apply_warp(JUMP, warp), warp, ALOFT) == pytest.approx([1.0], rel=1e-3)


def test_flights_are_found_and_counted_in_seconds() -> None:
    (found,) = flight_spans(JUMP)
    assert found[0] >= ALOFT[0][0] - 1 / 60
    assert found[1] <= ALOFT[0][1] + 1 / 60


def test_frames_in_flight_are_those_of_the_input() -> None:
    whole = flight_timing(linear(JUMP, 1.0), ALOFT)
    assert (whole.n_frames, whole.n_kept, whole.n_flights_kept) == (15, 15, 1)
    # Rushed through in a single step, every one of them is lost, not one.
    rushed = Warp([0.0, 1.0, 1.0 + 1 / 30, 2.0], [0.0, 1.0, 1.5, 2.5])
    lost = flight_timing(rushed, ALOFT)
    assert (lost.n_frames, lost.n_kept, lost.n_flights_kept) == (15, 0, 0)
    assert lost.fastest == pytest.approx(15.0)


def test_a_hundredth_too_fast_is_not_unit_speed() -> None:
    assert flight_timing(linear(JUMP, 1.01), ALOFT).n_kept == 0


def test_half_of_a_flight_may_be_kept() -> None:
    warp = Warp([0.0, 1.2, 2.2], [0.0, 1.2, 2.5])
    timing = flight_timing(warp, ALOFT)
    assert (timing.n_kept, timing.n_frames, timing.n_flights_kept) == (6, 15, 0)


@pytest.mark.parametrize(("held", "kept"), [(1.0, 14), (1.2, 14), (1.21, 14), (1.5, 15)])
def test_a_flight_that_is_held_loses_the_frame_where_it_is_held(held: float, kept: int) -> None:
    warp = Warp([0.0, held, held + 0.3, 2.8], [0.0, held, held, 2.5])
    assert flight_timing(warp, ALOFT).n_kept == kept


def test_a_flight_that_is_never_shown_is_not_kept() -> None:
    assert flight_timing(Warp([0.0, 0.5], [0.0, 0.5]), ALOFT).n_kept == 0


def test_without_flights_there_is_nothing_to_keep() -> None:
    timing = flight_timing(linear(JUMP, 2.0), ())
    assert (timing.n_frames, timing.n_flights, timing.slowest, timing.fastest) == (0, 0, 1.0, 1.0)


def test_the_path_is_judged_before_its_ends_are_moved_to_the_clips() -> None:
    found = guided_warp(JUMP, length="70%")
    path = path_warp(found)
    assert np.allclose(path.slopes, found.path_speeds)
    assert path.output_times[1] == pytest.approx(1 / 30)


def test_standing_still_is_found_and_shown_for_as_long_as_the_warp_says() -> None:
    walk = np.concatenate([np.zeros(60), np.arange(1, 61) / 60 * 1.4, np.full(90, 1.4)])
    spans = idle_spans(along(0, walk))
    # Speeds are taken over a thirtieth of a second to either side.
    assert np.ravel(spans) == pytest.approx([0.0, 59 / 60, 2.0, 209 / 60], abs=1 / 30 + 1e-9)
    assert seconds_shown(Warp([0.0, 3.5 / 2], [0.0, 3.5]), spans) == pytest.approx(1.25, abs=0.05)


def test_a_short_stop_is_no_idling() -> None:
    walk = np.concatenate([np.arange(60) / 60, np.full(8, 1.0), 1.0 + np.arange(60) / 60])
    assert idle_spans(along(0, walk)) == ()


def test_activity_is_the_speed_of_the_root() -> None:
    assert activity(along(0, np.arange(120) / 60 * 2.0)) == pytest.approx(np.full(120, 2.0))


def test_the_fastest_speed_of_a_cut_is_what_it_skips() -> None:
    # Half a second is skipped between two frames at 60 Hz.
    warp = Warp([0.0, 1.0, 1.0 + 1 / 60, 2.0], [0.0, 1.0, 1.5 + 1 / 60, 2.5])
    assert fastest_speed(warp) == pytest.approx((0.5 + 1 / 30) * 30, rel=1e-6)
    assert fastest_speed(linear(JUMP, 1.7)) == pytest.approx(1.7)


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
def test_a_sine_has_the_jerk_of_its_third_derivative(speed: float) -> None:
    # Slow against 30 Hz: a third difference is then a third derivative.
    omega, times = 2.0, np.arange(20 * 60) / 60
    motion = along(0, 0.3 * np.sin(omega * speed * times))
    assert rms_jerk(motion) == pytest.approx(0.3 * (omega * speed) ** 3 / np.sqrt(2), rel=0.02)


def test_no_jerk_without_four_frames() -> None:
    assert rms_jerk(along(0, np.zeros(3))) == 0.0


def test_a_foot_that_slides_slips_as_far_as_it_slides() -> None:
    still = along(0, np.zeros(120))
    slid = along(0, np.linspace(0.0, 0.05, 120))
    warp = linear(still, 1.0)
    assert foot_slip(still, still, warp).largest == pytest.approx(0.0, abs=1e-9)
    assert foot_slip(still, slid, warp).largest == pytest.approx(50.0, rel=1e-6)


def test_a_motion_has_no_distance_to_itself_but_for_its_other_neighbours() -> None:
    motion = along(0, np.sin(np.arange(240) / 20))
    assert timing_distance(motion, motion, features="heading", n_neighbors=1) == pytest.approx(0.0, abs=1e-6)


def test_the_distance_grows_with_the_change_of_timing() -> None:
    signal = Signal(("x",), np.sin(np.arange(300) / 12)[:, None], Fraction(60))
    slow, slower = (apply_warp(signal, Warp([0.0, 300 / 60 / c], [0.0, 299 / 60])) for c in (0.8, 0.5))
    near, far = (timing_distance(one, signal, n_neighbors=1) for one in (slow, slower))
    assert 0 < near < far


def test_a_timing_needs_three_frames() -> None:
    with pytest.raises(OptionError, match="three analysis frames"):
        timing_distance(JUMP, JUMP.frames(0, 3), features="heading")


def test_speeds_are_those_of_the_joint() -> None:
    motion = along(0, np.arange(121) / 60 * 3.0)
    assert joint_speeds(motion, ["LeftFoot"]) == pytest.approx(np.full(60, 3.0))
    assert joint_speeds(replace(motion, metres_per_unit=0.5), ["LeftFoot"]) == pytest.approx(np.full(60, 1.5))


def test_a_distribution_moved_by_one_is_one_away() -> None:
    speeds = np.random.default_rng(1).gamma(2.0, 1.0, 500)
    match = match_speeds(speeds, speeds + 1.0)
    assert match.distance == pytest.approx(1.0)
    assert np.subtract(match.wanted, match.quantiles) == pytest.approx(np.ones(3))


def test_the_distance_of_distributions_is_that_of_scipy() -> None:
    from scipy.stats import wasserstein_distance

    generator = np.random.default_rng(2)
    a, b = generator.gamma(2.0, 1.0, 70), generator.gamma(3.0, 0.5, 41)
    assert match_speeds(a, b).distance == pytest.approx(wasserstein_distance(a, b))


def wavy(strength: float, duration: float = 4.0) -> Warp:
    times = np.linspace(0.0, duration, 241)
    return Warp(times, times + strength * np.sin(2 * np.pi * times / duration) * duration / (2 * np.pi))


def test_a_warp_matches_itself() -> None:
    match = match_warps(wavy(0.4), wavy(0.4))
    assert (match.mean_error, match.largest_error, match.length_ratio) == (0.0, 0.0, 1.0)
    assert match.correlation == pytest.approx(1.0)
    assert match.log_speed_error == pytest.approx(0.0, abs=1e-12)


def test_the_opposite_warp_has_the_opposite_speeds() -> None:
    assert match_warps(wavy(0.2), wavy(-0.2)).correlation < -0.95


def test_one_speed_for_all_has_no_correlation_and_a_known_error() -> None:
    match = match_warps(Warp([0.0, 2.0], [0.0, 1.0]), Warp([0.0, 1.0], [0.0, 1.0]))
    assert np.isnan(match.correlation)
    assert match.largest_error == pytest.approx(30.0)
    assert match.mean_error == pytest.approx(15.0)
    assert match.log_speed_error == pytest.approx(np.log(2))
    assert match.length_ratio == 2.0


def test_inside_a_span_errors_count_from_its_start() -> None:
    # A second's delay before the span; inside it nothing is wrong.
    late = Warp([0.0, 2.0, 3.0], [0.0, 1.0, 2.0])
    truth = Warp([0.0, 2.0], [0.0, 2.0])
    assert match_warps(late, truth, spans=[(1.0, 2.0)]).largest_error == pytest.approx(0.0, abs=1e-9)
    assert match_warps(late, truth).largest_error == pytest.approx(30.0)


def test_a_hold_is_passed_in_its_middle() -> None:
    held = Warp([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 1.0, 2.0])
    truth = Warp([0.0, 2.0], [0.0, 2.0])
    assert match_warps(held, truth, rate=1.0).largest_error == pytest.approx(1.0)
    assert match_warps(held, truth, rate=1.0).mean_error == pytest.approx(0.5)


def test_keytimes_are_met_or_missed_by_seconds() -> None:
    warp = Warp([0.0, 2.0], [0.0, 4.0])
    met = match_keytimes(
        warp,
        [
            Keytime(input_time=0.0, output_time=0.0),
            Keytime(input_time=2.0, output_time=1.0),
            Keytime(input_time=4.0, output_time=2.0),
        ],
    )
    assert (met.n_keytimes, met.largest_error) == (3, 0.0)
    assert (
        match_keytimes(
            warp,
            [
                Keytime(input_time=0.0, output_time=0.0),
                Keytime(input_time=2.5, output_time=1.0),
                Keytime(input_time=4.0, output_time=2.0),
            ],
        ).largest_error
        == 0.5
    )
    assert (
        match_keytimes(
            warp, [Keytime(input_time=0.0, output_time=0.0), Keytime(input_time=4.0, output_time=2.5)]
        ).largest_error
        == 0.5
    )
