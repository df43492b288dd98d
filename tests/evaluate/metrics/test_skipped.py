"""What a warp does not show."""

from __future__ import annotations

import math

import numpy as np
import pytest

from retime.evaluate.metrics.skipped import worst_skipped_pose
from retime.motion.motion import Motion
from retime.warp.curve import Warp
from tests.evaluate.metrics.motions import PAIR, along, linear, moving


def nodding(heights: np.ndarray, *, unit: float = 1.0) -> Motion:
    """A hip that goes up and down over a foot that stays; one height a frame at 60 Hz."""
    motion = moving(np.stack([0 * heights, heights / unit, 0 * heights], axis=1), unit=unit)
    local = motion.local_translations.copy()
    local[:, 1, 1] -= heights / unit
    return Motion(PAIR, motion.rotations, local, motion.rate, metres_per_unit=unit)


def test_a_hop_that_is_leapt_over() -> None:
    # Up by 10 cm for the single analysis frame at 1 s: half a metre before and half after is shown, or its neighbours.
    heights = np.zeros(121)
    heights[58:63] = [0.0, 0.05, 0.1, 0.05, 0.0]
    motion = nodding(heights)
    leap = Warp([0.0, 0.9, 0.9 + 1 / 30, 1.7], [0.0, 0.9, 1.1, 1.1 + 1.7 - 0.9 - 1 / 30])
    # Of two joints one is 10 cm away from where the way from 0.9 s to 1.1 s passes.
    assert worst_skipped_pose(motion, leap) == pytest.approx(0.1 / math.sqrt(2))
    assert worst_skipped_pose(nodding(heights, unit=0.01), leap) == pytest.approx(0.1 / math.sqrt(2))


def test_what_goes_straight_may_be_skipped_and_so_may_stillness_and_going_ahead() -> None:
    rush = Warp([0.0, 0.1, 0.1 + 1 / 30, 1.0], [0.0, 0.1, 1.0, 1.0 + 0.9 - 1 / 30])
    assert worst_skipped_pose(nodding(np.arange(121) * 0.01), rush) == pytest.approx(0.0, abs=1e-9)
    assert worst_skipped_pose(nodding(np.zeros(121)), rush) == 0.0
    assert worst_skipped_pose(along(0, np.sin(np.arange(121))), rush) == pytest.approx(0.0, abs=1e-9)


def test_at_unit_speed_and_slower_nothing_is_skipped() -> None:
    motion = nodding(np.sin(np.arange(121)))
    assert worst_skipped_pose(motion, linear(motion, 1.0)) == 0.0
    # At half the speed some steps pass a frame between, half way: what is shown is beside it.
    assert worst_skipped_pose(motion, Warp([0.0, 4.0], [0.0, 2.0])) == 0.0


def test_each_step_is_asked_for_all_that_it_skips() -> None:
    # A parabola: of a step of b frames the middle one is (b / 2)² k away from the chord.
    frames = np.arange(241)
    motion = nodding(1e-4 * (frames / 2) ** 2)
    for step in (2, 4, 6):
        warp = Warp([0.0, 120 / step / 30], [0.0, 4.0])
        assert worst_skipped_pose(motion, warp) == pytest.approx(1e-4 * (step / 2) ** 2 / math.sqrt(2), rel=1e-6)
