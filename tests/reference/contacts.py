"""Contacts and slip by definition: one foot after another, one frame after another."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from retime.motion.body import body_joint
from retime.motion.motion import Motion
from tests.reference.kinematics import end_position, global_matrix

Place = tuple[int, int | None]  # joint, end site


def positions(motion: Motion, foot: Place) -> list[np.ndarray]:
    joint, site = foot
    if site is not None:
        return [end_position(motion, frame, site) for frame in range(motion.n_frames)]
    return [global_matrix(motion, frame, joint)[:3, 3] for frame in range(motion.n_frames)]


def lowest_of_all(motion: Motion) -> list[float]:
    """Least height of any joint or end site of the body, in each frame."""
    body = body_joint(motion)

    def hangs_on_it(joint: int) -> bool:
        return joint == body or (joint >= 0 and hangs_on_it(motion.skeleton.parents[joint]))

    everything = [(joint, None) for joint in range(motion.skeleton.n_joints) if hangs_on_it(joint)]
    everything += [(site.parent, i) for i, site in enumerate(motion.skeleton.end_sites) if hangs_on_it(site.parent)]
    heights = [[point[1] for point in positions(motion, place)] for place in everything]
    return [min(column) for column in zip(*heights, strict=True)]


def at_rest(motion: Motion, foot: Place, metres: float, *, speed: float = 0.2, **options: float) -> list[bool]:
    """Whether a foot stands, in each frame: it is held in place, or it rolls."""
    rolls = slow_and_low(motion, foot, metres, speed=speed, **options)
    return [one or other for one, other in zip(held(motion, foot, metres, speed=speed, **options), rolls, strict=True)]


def held(motion: Motion, foot: Place, metres: float, **options: float) -> list[bool]:
    """Whether a foot is held in place, in each frame."""
    return slow_and_low(motion, foot, metres, **{**options, "swing_share": 0.0})


def slow_and_low(
    motion: Motion,
    foot: Place,
    metres: float,
    *,
    speed: float = 0.2,
    swing_share: float = 0.12,
    most_speed: float = 0.6,
    rise: float = 0.04,
    height: float = 0.25,
    gap: float = 0.1,
    minimum: float = 0.05,
) -> list[bool]:
    """Whether a foot is both, in each frame."""
    rate, n_frames = float(motion.rate), motion.n_frames
    points = [point * metres for point in positions(motion, foot)]
    lowest = [value * metres for value in lowest_of_all(motion)]

    def reach(seconds: float) -> int:
        return max(1, round(seconds * rate))

    def around(frame: int, frames: int) -> range:
        return range(max(0, frame - frames), min(n_frames - 1, frame + frames) + 1)

    speeds = []
    for frame in range(n_frames):
        near = around(frame, reach(1 / 30))
        moved = math.dist(points[near[0]], points[near[-1]])
        speeds.append(moved / ((len(near) - 1) / rate) if n_frames > 1 else 0.0)
    slow = []
    for frame in range(n_frames):
        swing = max(speeds[other] for other in around(frame, reach(0.5)))
        slow.append(speeds[frame] < max(min(swing_share * swing, most_speed), speed))
    found = []
    for frame in range(n_frames):
        here = points[frame][1]
        places = [points[other][1] for other in around(frame, reach(0.4)) if slow[other]]
        found.append(slow[frame] and here - min(places) <= rise and here - lowest[frame] <= height)
    for stretch in stretches(found, False):
        if stretch[0] > 0 and stretch[-1] < n_frames - 1 and len(stretch) <= gap * rate:
            for frame in stretch:
                found[frame] = True
    for stretch in stretches(found, True):
        if len(stretch) < 2 or len(stretch) < minimum * rate:
            for frame in stretch:
                found[frame] = False
    return found


def stretches(column: Sequence[bool], value: bool) -> list[list[int]]:
    """Neighbouring frames that have a value."""
    found: list[list[int]] = []
    for frame, here in enumerate(column):
        if here == value:
            if found and found[-1][-1] == frame - 1:
                found[-1].append(frame)
            else:
                found.append([frame])
    return found


def shown(column: Sequence[bool], places: Sequence[float]) -> list[tuple[int, int, int]]:
    """Which contact (by number), from which shown frame to which, for shown places in frames."""
    found: list[tuple[int, int, int]] = []
    for number, stretch in enumerate(stretches(column, True)):
        inside = [stretch[0] <= place <= stretch[-1] for place in places]
        found += [(number, part[0], part[-1]) for part in stretches(inside, True)]
    return sorted(found, key=lambda span: span[1])


def slip(motion: Motion, foot: Place, metres: float, first: int, last: int) -> float:
    """How far a foot gets from where it was in the first frame, along the ground, in millimetres."""
    points = positions(motion, foot)
    away = [
        math.hypot(points[frame][0] - points[first][0], points[frame][2] - points[first][2])
        for frame in range(first, last + 1)
    ]
    return max(away) * metres * 1000
