"""How jerky a motion is."""

from __future__ import annotations

import numpy as np
import pytest

from retime.evaluate.metrics.smoothness import rms_jerk
from tests.evaluate.metrics.motions import along


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0])
def test_a_sine_has_the_jerk_of_its_third_derivative(speed: float) -> None:
    # Slow against 30 Hz: a third difference is then a third derivative.
    omega, times = 2.0, np.arange(20 * 60) / 60
    motion = along(0, 0.3 * np.sin(omega * speed * times))
    assert rms_jerk(motion) == pytest.approx(0.3 * (omega * speed) ** 3 / np.sqrt(2), rel=0.02)


def test_no_jerk_without_four_frames() -> None:
    assert rms_jerk(along(0, np.zeros(3))) == 0.0
