"""How fast a warp plays, and how fast joints move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from retime.evaluate.metrics.speeds import fastest_speed, joint_speeds, match_speeds, speed_contrast
from retime.warp.curve import Warp
from tests.evaluate.metrics.motions import JUMP, along, linear


def test_the_fastest_speed_of_a_cut_is_what_it_skips() -> None:
    # Half a second is skipped between two frames at 60 Hz.
    warp = Warp([0.0, 1.0, 1.0 + 1 / 60, 2.0], [0.0, 1.0, 1.5 + 1 / 60, 2.5])
    assert fastest_speed(warp) == pytest.approx((0.5 + 1 / 30) * 30, rel=1e-6)
    assert fastest_speed(linear(JUMP, 1.7)) == pytest.approx(1.7)


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


def test_contrast_is_that_of_blows_and_not_of_tempo() -> None:
    # A hundredth of the time at 10, the rest at 1: the mean is 1.09.
    speeds = np.concatenate([np.ones(9_900), np.full(100, 10.0)])
    assert speed_contrast(speeds[:9_950]) == pytest.approx(1 / speeds[:9_950].mean())
    assert speed_contrast(np.concatenate([speeds, [10.0] * 100])) == pytest.approx(10 / (11_900 / 10_100))
    assert speed_contrast(3 * speeds) == pytest.approx(speed_contrast(speeds))
