"""Averaging where a warp is fast, by definition: one output frame and one joint after another (§3.4)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from retime.motion.motion import Motion
from tests.reference.curve import window_mean


def half_width(speed: float, place: float, n_frames: int, standing: Sequence[Sequence[bool]]) -> float:
    """Half of a joint's window, in frames of the input: `standing` are the feet that it carries, frame by frame."""
    half = min((max(speed, 1.0) - 1) / 2, place, n_frames - 1 - place)
    for column in standing:
        for frame, here in enumerate(column):
            if here:
                half = min(half, abs(place - frame))
            if frame <= place <= frame + 1 < len(column) and here and column[frame + 1]:
                half = 0.0
    return max(half, 0.0)


def mean_rotation(motion: Motion, joint: int, place: float, half: float) -> Rotation:
    """Mean local rotation of a joint over a window: that of its quaternions, each on its predecessor's side."""
    if half < 1e-6:
        (q,) = motion.at([place / float(motion.rate)]).rotations[:, joint]
        return Rotation.from_quat(q, scalar_first=True)
    column = [motion.rotations[0, joint]]
    for q in motion.rotations[1:, joint]:
        column.append(q if np.dot(q, column[-1]) >= 0 else -q)
    return Rotation.from_quat(window_mean(np.array(column), place - half, place + half), scalar_first=True)


def turn_in_space(motion: Motion, joint: int, place: float, half: float) -> Rotation:
    """How a joint is turned, in space, in the pose averaged over a window."""
    own = mean_rotation(motion, joint, place, half)
    parent = motion.skeleton.parents[joint]
    return own if parent < 0 else turn_in_space(motion, parent, place, half) * own
