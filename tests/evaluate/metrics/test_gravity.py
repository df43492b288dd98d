"""How hard flights fall."""

from __future__ import annotations

import numpy as np
import pytest

from retime.evaluate.metrics.gravity import gravity, gravity_ratios
from retime.motion.motion import Motion
from retime.warp.apply import apply_warp
from tests.evaluate.figures import GRAVITY, keeping_flight
from tests.evaluate.metrics.motions import ALOFT, JUMP, linear


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
