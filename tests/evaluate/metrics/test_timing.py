"""How far a motion's local timing is from a reference's."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from retime.errors import OptionError
from retime.evaluate.metrics.timing import timing_distance
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from tests.evaluate.metrics.motions import JUMP, along


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
