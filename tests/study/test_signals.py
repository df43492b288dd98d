"""Beyond motion: a camera, a curve and a ball."""

from __future__ import annotations

import numpy as np
import pytest

from retime.warp.curve import Warp
from study.clips.library import read_sample
from study.signals.ball import bouncing_ball, falls, warp_signal
from study.signals.camera import warp_camera
from study.signals.curve import warp_curve

SAMPLE = read_sample()


def test_a_ball_falls_as_made_and_keeps_its_flights_when_guided() -> None:
    ball, spans = bouncing_ball()
    same = Warp([0.0, ball.end_time], [0.0, ball.end_time])
    assert falls(ball, same, spans) == pytest.approx(np.ones(len(spans)))
    result = warp_signal()
    assert result.timing.n_kept == result.timing.n_frames > 0
    assert result.linear_timing.n_kept == 0
    assert result.linear_gravity == pytest.approx((ball.end_time / result.linear.output_span) ** 2, rel=0.02)


def test_one_warp_keeps_a_camera_on_its_figure() -> None:
    result = warp_camera(SAMPLE, Warp([0.0, SAMPLE.end_time * 0.7], [0.0, SAMPLE.end_time]))
    assert result.before < 1e-6
    assert result.together < 1.0 < result.motion_alone


def test_one_warp_keeps_a_curve_on_its_figure() -> None:
    warp = Warp([0.0, SAMPLE.end_time * 0.7], [0.0, SAMPLE.end_time])
    result = warp_curve(SAMPLE, warp)
    assert result.together < 0.01 < 0.1 < result.motion_alone
    assert (result.n_input, result.n_output) == (680, 476)
