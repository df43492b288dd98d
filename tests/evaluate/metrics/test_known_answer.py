"""How close a warp comes to the one that is known to be right."""

from __future__ import annotations

import numpy as np
import pytest

from retime.evaluate.metrics.known_answer import match_warps
from retime.warp.curve import Warp


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
