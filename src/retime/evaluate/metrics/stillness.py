"""Where a figure stands still, and how much it moves."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray
from retime.motion.body import body_of
from retime.motion.kinematics import global_poses, metres_per_unit, torso_positions
from retime.motion.motion import Motion

# Seconds to either side: over one frame of 120 Hz, capture noise alone makes a tenth of a metre a second.
_SPEED_WINDOW = 1 / 30


def idle_spans(
    motion: Motion, *, root_speed: float = 0.2, joint_speed: float = 0.1, minimum: float = 0.25
) -> tuple[tuple[float, float], ...]:
    """Find stretches in which a figure stands still.

    Parameters
    ----------
    motion : Motion
        The input.
    root_speed : float
        Metres a second that the root stays below.
    joint_speed : float
        Metres a second that the other joints stay below, against the root, on average.
    minimum : float
        Shortest stretch, seconds.

    Returns
    -------
    tuple of (float, float)
        Input times, seconds.
    """
    rate = float(motion.rate)
    root, joints = _speeds(motion)
    still = (root < root_speed) & (joints < joint_speed)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    spans = [(first / rate, (stop - 1) / rate) for first, stop in edges.reshape(-1, 2).tolist()]
    return tuple(span for span in spans if span[1] - span[0] >= minimum)


def activity(motion: Motion) -> FloatArray:
    """How fast a figure moves in each frame: root, and mean joint against the root, together; metres a second."""
    root, joints = _speeds(motion)
    return root + joints


def _speeds(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Speed of the root, and mean speed of the other joints in its space, metres a second; shape (n_frames,) each."""
    motion = body_of(motion)
    scale, rate = metres_per_unit(motion), float(motion.rate)
    poses = global_poses(motion)
    frames = np.arange(motion.n_frames)
    lag = max(1, round(_SPEED_WINDOW * rate))
    before, after = np.maximum(frames - lag, 0), np.minimum(frames + lag, motion.n_frames - 1)
    seconds = np.maximum(after - before, 1) / rate
    inner = torso_positions(poses)
    root = np.linalg.norm(poses.positions[after, 0] - poses.positions[before, 0], axis=-1)
    joints = np.linalg.norm(inner[after] - inner[before], axis=-1).mean(axis=-1)
    return root * scale / seconds, joints * scale / seconds
