"""How flights are played."""

from __future__ import annotations

import numpy as np
import pytest

from retime.evaluate.metrics.flights import flight_spans, flight_timing, path_warp
from retime.search.guided import guided_warp
from retime.warp.curve import Warp
from tests.evaluate.metrics.motions import ALOFT, JUMP, linear


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
    assert (whole.n_leapt, lost.n_leapt) == (0, 1)


@pytest.mark.parametrize(("speed", "leapt"), [(3.9, 0), (4.1, 1)])
def test_a_flight_at_four_times_its_speed_is_leapt_over(speed: float, leapt: int) -> None:
    assert flight_timing(linear(JUMP, speed), ALOFT).n_leapt == leapt


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
