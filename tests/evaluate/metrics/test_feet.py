"""How far feet slide while they stand."""

from __future__ import annotations

import numpy as np
import pytest

from retime.evaluate.metrics.feet import foot_slip
from tests.evaluate.metrics.motions import along, linear


def test_a_foot_that_slides_slips_as_far_as_it_slides() -> None:
    still = along(0, np.zeros(120))
    slid = along(0, np.linspace(0.0, 0.05, 120))
    warp = linear(still, 1.0)
    assert foot_slip(still, still, warp).largest == pytest.approx(0.0, abs=1e-9)
    assert foot_slip(still, slid, warp).largest == pytest.approx(50.0, rel=1e-6)
