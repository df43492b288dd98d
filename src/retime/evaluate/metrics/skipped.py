"""What a warp does not show."""

from __future__ import annotations

import math

import numpy as np

from retime.arrays import FloatArray
from retime.evaluate.metrics import ANALYSIS_RATE
from retime.motion.body import body_joint
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion
from retime.warp.curve import Warp


def worst_skipped_pose(motion: Motion, warp: Warp, *, rate: float = ANALYSIS_RATE) -> float:
    """Measure how far the worst pose that is skipped lies from what is shown in its place, metres.

    A warp shows one pose an analysis period; what of the input's analysis frames lies between two of them is skipped.
    In its place the eye sees the way straight from the one to the other. The distance is the root mean square over the
    joints, of each skipped pose from the pose at its time on that way; where on the ground the root is counts for
    nothing. To rush through stillness costs nothing; to leap over a hop costs much.

    Parameters
    ----------
    motion : Motion
        The input.
    warp : Warp
        Plays it; of a search, its path (`retime.evaluate.metrics.flights.path_warp`).
    rate : float
        Analysis rate, Hz.

    Returns
    -------
    float
        0 where nothing is skipped.
    """
    shown = warp(np.arange(math.floor(warp.output_span * rate + 1e-6) + 1) / rate + warp.output_start)
    before, after = np.minimum(shown[:-1], shown[1:]), np.maximum(shown[:-1], shown[1:])
    # Of every step its skipped frames; a frame that is shown, but for a rounding, is not skipped.
    first, last = np.ceil(before * rate + 1e-6).astype(int), np.floor(after * rate - 1e-6).astype(int)
    n_skipped = np.maximum(last - first + 1, 0)
    step = np.repeat(np.arange(len(before)), n_skipped)
    if not len(step):
        return 0.0
    frames = first[step] + np.arange(len(step)) - np.repeat(np.cumsum(n_skipped) - n_skipped, n_skipped)
    share = (frames / rate - before[step]) / (after[step] - before[step])
    starts, ends, skipped = (_on_the_spot(motion.at(times)) for times in (before[step], after[step], frames / rate))
    apart = skipped - (starts + share[:, None, None] * (ends - starts))
    squares = np.mean(np.sum(apart * apart, axis=-1), axis=-1)
    return float(np.sqrt(squares.max())) * metres_per_unit(motion)


def _on_the_spot(motion: Motion) -> FloatArray:
    """Positions of all joints with the root's place on the ground removed, shape (n_frames, n_joints, 3).

    Not in heading space: a figure that lies or turns over has no steady heading.
    """
    positions = global_poses(motion).positions
    return np.asarray(positions - positions[:, [body_joint(motion)]] * np.array([1.0, 0.0, 1.0]))
