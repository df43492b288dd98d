"""Where a boxer strikes: when one of some joints is fast."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from retime.arrays import FloatArray
from retime.errors import OptionError
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion

_WRISTS = (("LeftWrist", "RightWrist"), ("lwrist", "rwrist"))


def wrists(motion: Motion) -> tuple[str, ...]:
    """Name the joints that are a clip's wrists; raise OptionError where it has none that are known."""
    for names in _WRISTS:
        if set(names) <= set(motion.skeleton.names):
            return names
    raise OptionError(f"{motion.name or 'the motion'} has no joints that are known to be wrists")


def fast_spans(motion: Motion, joints: Sequence[str], *, share: float = 0.15) -> tuple[tuple[float, float], ...]:
    """Find blows: input times of the `share` of all frames in which the faster of some joints is fastest."""
    speed = fastest_joint(motion, joints)
    fast = np.concatenate([[0], (speed > np.quantile(speed, 1 - share)).astype(np.int8), [0]])
    edges = np.flatnonzero(np.diff(fast)).reshape(-1, 2) / float(motion.rate)
    return tuple((float(start), min(float(end), motion.end_time)) for start, end in edges)


def fastest_joint(motion: Motion, joints: Sequence[str]) -> FloatArray:
    """Speed of the fastest of some joints in each frame, smoothed over 0.3 s; units a frame."""
    places = [motion.skeleton.index(name) for name in joints]
    positions = global_poses(motion).positions[:, places]
    fastest = np.linalg.norm(np.gradient(positions, axis=0), axis=-1).max(axis=1)
    half = round(0.15 * float(motion.rate))
    window = np.hanning(2 * half + 3)[1:-1]
    return np.asarray(np.convolve(np.pad(fastest, half, mode="edge"), window / window.sum(), "valid"))
