"""How jerky a motion is."""

from __future__ import annotations

import math

import numpy as np

from retime.evaluate.metrics import ANALYSIS_RATE
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion


def rms_jerk(motion: Motion, *, rate: float = ANALYSIS_RATE) -> float:
    """Root mean square of the joints' jerk, metres per second cubed: third differences at the analysis rate.

    Over shorter times the noise of a capture would be all that it measures. 0 where the motion is shorter than four
    analysis frames.
    """
    times = np.arange(math.floor(motion.end_time * rate + 1e-6) + 1) / rate
    if len(times) < 4:
        return 0.0
    positions = global_poses(motion.at(times)).positions * metres_per_unit(motion)
    third = np.diff(positions, n=3, axis=0) * rate**3
    return float(np.sqrt(np.mean(np.sum(third * third, axis=-1))))
