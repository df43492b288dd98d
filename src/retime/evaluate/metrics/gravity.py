"""How hard flights fall."""

from __future__ import annotations

import math

import numpy as np

from retime.arrays import FloatArray
from retime.evaluate.metrics import Spans
from retime.evaluate.metrics.spans import output_intervals
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion
from retime.warp.curve import Warp


def gravity(motion: Motion, spans: Spans) -> FloatArray:
    """Acceleration of fall that a motion's flights imply: a parabola fitted to the mean height of the joints.

    The joints' mean is not the body's centre of mass, so even a capture does not say 9.81. What a warp did shows in the
    ratio of the output's value to the input's: played c times faster, a flight falls c² times harder.

    Parameters
    ----------
    motion : Motion
        Y up.
    spans : sequence of (float, float)
        Its flights, in its own time, seconds.

    Returns
    -------
    float array, shape (n_spans,)
        Metres per second squared, downward; NaN where a flight has fewer than 4 frames.
    """
    rate = float(motion.rate)
    height = global_poses(motion).positions[:, :, 1].mean(axis=1) * metres_per_unit(motion)
    found = np.full(len(spans), np.nan)
    for i, (start, end) in enumerate(spans):
        first, last = math.ceil(start * rate - 1e-6), min(math.floor(end * rate + 1e-6), motion.n_frames - 1)
        if last - first >= 3:
            times = np.arange(first, last + 1) / rate
            found[i] = -2 * np.polynomial.polynomial.polyfit(times - times.mean(), height[first : last + 1], 2)[2]
    return found


def gravity_ratios(motion: Motion, output: Motion, warp: Warp, spans: Spans) -> FloatArray:
    """Gravity in the output's flights over gravity in the input's, shape (n_spans,); 1 is as captured.

    NaN where the output has too few frames of a flight to tell.
    """
    shown = [next(iter(output_intervals(warp, *span)), (0.0, 0.0)) for span in spans]
    return np.asarray(gravity(output, shown) / gravity(motion, spans))
