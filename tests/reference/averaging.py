"""Averaging where a warp is fast, by definition: one output frame and one joint after another (§3.4)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from retime.motion.body import above_body
from retime.motion.contacts import Contacts
from retime.motion.motion import Motion
from retime.warp.curve import Warp
from tests.reference.curve import evaluate, window_mean


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
    (q,) = motion.at([place / float(motion.rate)]).rotations[:, joint]
    sampled = Rotation.from_quat(q, scalar_first=True)
    if half < 1e-6:
        return sampled
    column = [motion.rotations[0, joint]]
    for q in motion.rotations[1:, joint]:
        column.append(q if np.dot(q, column[-1]) >= 0 else -q)
    mean = window_mean(np.array(column), place - half, place + half)
    # Where a joint goes all the way round, there is no mean.
    return sampled if np.linalg.norm(mean) < 0.1 else Rotation.from_quat(mean, scalar_first=True)


def turn_in_space(motion: Motion, joint: int, place: float, half: float) -> Rotation:
    """How a joint is turned, in space, in the pose averaged over a window."""
    own = mean_rotation(motion, joint, place, half)
    parent = motion.skeleton.parents[joint]
    return own if parent < 0 else turn_in_space(motion, parent, place, half) * own


def carries(motion: Motion, joint: int, below: int) -> bool:
    """Whether a joint is another one, or above it."""
    while below not in (joint, -1):
        below = motion.skeleton.parents[below]
    return below == joint


def mean_speed(warp: Warp, time: float, period: float) -> float:
    """Speed over the period about an output time, as far as it lies in the warp."""
    knots = warp.output_times.tolist(), warp.input_times.tolist()
    low, high = max(time - period / 2, knots[0][0]), min(time + period / 2, knots[0][-1])
    return abs(evaluate(*knots, high) - evaluate(*knots, low)) / (high - low)


def averaged_pose(
    motion: Motion, warp: Warp, time: float, standing: Contacts | None, *, keep_root_path: bool = True
) -> tuple[list[Rotation], np.ndarray]:
    """How each joint is turned in space, and where it is in its parent (n_joints, 3), at one output time."""
    rate = float(motion.rate)
    input_time = evaluate(warp.output_times.tolist(), warp.input_times.tolist(), time)
    place = min(max(input_time * rate, 0.0), motion.n_frames - 1.0)
    turns, translations = [], []
    for joint in range(motion.skeleton.n_joints):
        feet = [] if standing is None else list(zip(standing.feet, standing.at_rest.T.tolist(), strict=True))
        own = [column for foot, column in feet if carries(motion, joint, foot.joint)]
        half = half_width(mean_speed(warp, time, 1 / rate), place, motion.n_frames, own)
        turns.append(turn_in_space(motion, joint, place, half))
        if half < 1e-6 or (joint in above_body(motion) and keep_root_path):
            translations.append(motion.at([input_time]).local_translations[0, joint])
        else:
            translations.append(window_mean(motion.local_translations[:, joint], place - half, place + half))
    return turns, np.array(translations)
