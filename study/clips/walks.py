"""Where a figure walks: its steps, cycle by cycle."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from retime.errors import OptionError
from retime.motion.joint_names import body_parts
from retime.motion.kinematics import global_poses, heading_positions, metres_per_unit
from retime.motion.motion import Motion


@dataclass(frozen=True)
class Step:
    """A moment of a gait: a foot is farthest in front of the root.

    Attributes
    ----------
    time : float
        Input time, seconds.
    side : str
        "left" or "right".
    """

    time: float
    side: str


def steps(motion: Motion, *, reach: float = 0.12, apart: float = 0.2) -> list[Step]:
    """Find the steps of a walk or run, by when each foot is farthest in front of the root.

    Parameters
    ----------
    motion : Motion
        Its skeleton's names say which joints are the feet; forward is +Z in heading space.
    reach : float
        Metres in front of the root that a step gets, at least.
    apart : float
        Seconds within which a foot is nowhere farther in front.

    Raises
    ------
    OptionError
        No foot is known by its name.
    """
    rate = float(motion.rate)
    parts = body_parts(motion.skeleton.names)
    places = heading_positions(global_poses(motion)) * metres_per_unit(motion)
    window = max(1, round(0.1 * rate))
    found = []
    for side in ("left", "right"):
        joints = [i for i, part in enumerate(parts) if part is not None and (part.side, part.base) == (side, "foot")]
        if not joints:
            raise OptionError(f"no joint of {motion.name or 'the motion'} is known to be the {side} foot")
        ahead = places[:, joints[0], 2] - places[:, 0, 2]
        padded = np.pad(ahead, (window // 2, window - 1 - window // 2), mode="edge")
        smooth = np.convolve(padded, np.ones(window) / window, "valid")
        margin = round(apart * rate)
        for frame in range(window // 2 + 1, motion.n_frames - window // 2 - 1):
            near = smooth[max(0, frame - margin) : frame + margin + 1]
            if smooth[frame] > reach and smooth[frame] == near.max():
                found.append(Step(frame / rate, side))
    return sorted(found, key=lambda step: step.time)


def cycles(motion: Motion, *, shortest: float = 0.25, longest: float = 1.1) -> list[tuple[Step, Step]]:
    """Pair each step with the next one, where that is the other foot's and follows in a walker's time, seconds."""
    return [
        (a, b)
        for a, b in itertools.pairwise(steps(motion))
        if a.side != b.side and shortest <= b.time - a.time <= longest
    ]


def walking_spans(motion: Motion) -> tuple[tuple[float, float], ...]:
    """Input times of unbroken walks: where `limp` changes whole steps."""
    spans: list[tuple[float, float]] = []
    for a, b in cycles(motion):
        if spans and spans[-1][1] == a.time:
            spans[-1] = (spans[-1][0], b.time)
        else:
            spans.append((a.time, b.time))
    return tuple(spans)
