"""One speed for all."""

from __future__ import annotations

import numpy as np

from retime.motion.motion import Motion
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime
from retime.warp.spline import linear_warp


def untouched(motion: Motion) -> Warp:
    """Play a whole clip as it is."""
    ends = np.array([0.0, motion.end_time])
    return Warp(ends, ends)


def at_one_speed(motion: Motion, output_span: float) -> Warp:
    """Play a whole clip at the one speed that puts its last frame at an output time, seconds."""
    return linear_warp(
        [Keytime(input_time=0.0, output_time=0.0), Keytime(input_time=motion.end_time, output_time=output_span)]
    )
