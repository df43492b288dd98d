"""Trunk, head and arms: curves over the plan's times, and swings that answer the feet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from sample_clip.body import NAMES, OUTWARD, SIDES
from sample_clip.curves import AFTER, flow, soften, wander
from sample_clip.feet import Foot
from sample_clip.plan import FINE, JUMPS, RATE, TIMES, WALKS


def over_jumps(*keys: tuple[str, float, float], rest: float = 0.0, scaled: bool = False) -> list[tuple[float, float]]:
    """Lay keys (event, seconds after it, value) over both jumps, `rest` outside; `scaled`: by how high the arms go."""
    result = [(-1.0, rest)]
    for jump in JUMPS:
        for event, after, value in keys:
            t = getattr(jump, event) + after
            result.append((t, value * (jump.arms / 110 if scaled and value > 0 else 1.0)))
    return [*result, (AFTER[0], rest)]


def shared(angles: dict[str, FloatArray], axis: int, total: FloatArray, shares: dict[str, float]) -> None:
    """Spread an angle over a chain of joints; `axis` 0 is Z, 1 is Y, 2 is X."""
    for name, share in shares.items():
        angles[name][:, axis] += share * total


TRUNK = {"Spine": 0.4, "Spine1": 0.35, "Chest": 0.25}
NECK = {"Neck": 0.45, "Head": 0.55}


@dataclass(frozen=True)
class Gait:
    """What trunk and arms answer, over the whole clip."""

    stride: FloatArray  # 1 with the left foot a full step ahead, -1 with the right
    late: FloatArray  # the same, as the upper body follows it
    walking: FloatArray  # 1 at full speed, 0 at rest and in a jump
    push: FloatArray  # forward acceleration, outside of jumps
    carries: FloatArray  # 1 where the right leg bears all, -1 the left
    breath: FloatArray


def read_gait(feet: tuple[Foot, Foot], centre: FloatArray, ground: FloatArray) -> Gait:
    """Read off the feet, the centre of pressure and the path of the centre of mass how the figure walks."""
    stride = soften((feet[0].ankle[:, 2] - feet[1].ankle[:, 2]) / 65, 0.045)
    lag = int(0.045 * RATE * FINE)
    late = np.concatenate([np.full(lag, stride[0]), stride[:-lag]])
    jumping = np.zeros(len(TIMES), dtype=bool)
    for jump in JUMPS:
        jumping |= (jump.dip < TIMES) & (jump.stand > TIMES)
    speed = np.gradient(ground[:, 1], TIMES) / 120
    push = np.where(jumping, 0.0, soften(np.gradient(speed, TIMES), 0.08))
    walking = soften(np.where(jumping, 0.0, np.clip(speed, 0.0, 1.0)), 0.1)
    left, right = feet[0].ankle[:, 0], feet[1].ankle[:, 0]
    carries = soften(np.clip(2 * (centre[:, 0] - left) / (right - left) - 1, -1.2, 1.2), 0.05)
    return Gait(stride, late, walking, push, carries, np.sin(2 * np.pi * 0.28 * TIMES + 0.6))


def carriage(gait: Gait) -> dict[str, FloatArray]:
    """Return the Euler angles (Z, Y, X) of the root and of every joint above the legs; the legs' are 0."""
    angles = {name: np.zeros((len(TIMES), 3)) for name in NAMES}
    hold_trunk(gait, angles)
    for side in (0, 1):
        swing_arm(side, gait, angles)
    return angles


def hold_trunk(gait: Gait, angles: dict[str, FloatArray]) -> None:
    """Fill in pelvis, spine, neck and head: each level's turn in the world, spread over the joints below it."""
    walking, quiet, carries = gait.walking, 1 - gait.walking, gait.carries
    pelvis_pitch = flow(
        over_jumps(
            ("dip", 0, 0),
            ("bottom", 0, 33),
            ("takeoff", -0.02, 2),
            ("middle", 0, 3),
            ("touchdown", 0, 8),
            ("absorbed", 0.02, 24),
            ("stand", 0, 0),
            rest=0.0,
        )
    )
    trunk_pitch = flow(
        over_jumps(
            ("dip", 0, 1),
            ("bottom", -0.02, 57),
            ("takeoff", 0, 8),
            ("middle", 0, 12),
            ("touchdown", 0, 20),
            ("absorbed", 0.05, 38),
            ("stand", 0.05, 1),
            rest=1.0,
        )
    )
    gaze_pitch = flow(
        over_jumps(
            ("dip", 0, 4),
            ("bottom", -0.1, 14),
            ("takeoff", 0.02, -4),
            ("middle", 0, 10),
            ("touchdown", 0, 16),
            ("absorbed", 0.05, 15),
            ("stand", 0.1, 3),
            rest=3.0,
        ),
        0.05,
    )
    pelvis_pitch += 2.0 * walking + 0.6 * wander(3) * quiet
    trunk_pitch += 1.0 + 2.5 * walking + 1.5 * gait.push + 0.5 * wander(4)
    trunk_pitch = soften(trunk_pitch, 0.03)
    gaze_pitch += 1.2 * wander(5) + 3.0 * walking

    pelvis_yaw = -5.5 * gait.stride + 1.0 * wander(6) * quiet
    chest_yaw = 5.0 * gait.late + 1.2 * wander(7) * quiet
    pause, resume = WALKS[0][-1].strike, WALKS[1][0].lift
    first, second = JUMPS
    look = flow(
        [
            *((-1.0, 0.0), (0.0, 2.0), (0.7, -3.0), (1.3, 0.0), (pause - 0.1, 0.0), (pause + 0.35, 30.0)),
            *((pause + 0.62, 32.0), (pause + 1.05, -26.0), (pause + 1.25, -27.0), (first.dip + 0.1, 0.0)),
            *(
                (first.stand - 0.2, 0.0),
                (first.stand + 0.25, -14.0),
                (resume + 0.2, -1.0),
                (second.touchdown + 0.5, 0.0),
            ),
            *((second.stand + 0.05, 12.0), (second.stand + 0.5, 14.0), (AFTER[0], 2.0)),
        ],
        0.05,
    )
    chest_yaw += 0.16 * soften(look, 0.1)
    head_yaw = look + 0.3 * chest_yaw + 1.5 * wander(8)

    # The hip of the swinging leg drops; a resting one drops more slowly and further.
    pelvis_roll = carries * (-3.8 * walking - 2.6 * quiet)
    chest_roll = -carries * (1.6 * walking) + carries * 0.9 * quiet + 0.4 * wander(9)
    head_roll = 0.4 * chest_roll + 1.0 * wander(10)

    angles["Hips"][:] = np.stack([pelvis_roll, pelvis_yaw, pelvis_pitch], axis=-1)
    for axis, lower, upper, top in (
        (0, pelvis_roll, chest_roll, head_roll),
        (1, pelvis_yaw, chest_yaw, head_yaw),
        (2, pelvis_pitch, trunk_pitch, gaze_pitch),
    ):
        shared(angles, axis, upper - lower, TRUNK)
        shared(angles, axis, top - upper, NECK)
    angles["Chest"][:, 2] -= 0.7 * gait.breath
    angles["Neck"][:, 2] += 0.7 * gait.breath


def swing_arm(side: int, gait: Gait, angles: dict[str, FloatArray]) -> None:
    """Fill in an arm, with its shoulder: it swings with the other leg, and helps in a jump."""
    name, out, walking = SIDES[side], OUTWARD[side], gait.walking
    lag = 0.012 * (1 - 2 * side)
    swing = gait.late * (1 if side else -1)  # forward with the other foot
    reach = flow(
        over_jumps(
            ("dip", 0.0, 0),
            ("bottom", -0.18 + lag, -52),
            ("bottom", -0.03 + lag, -38),
            ("takeoff", 0.02 + lag, 95),
            ("middle", -0.06, 110),
            ("touchdown", lag, 62),
            ("absorbed", 0.04 + lag, 56),
            ("stand", -0.15 + lag, -5),
            ("stand", 0.25, 0),
            scaled=True,
        ),
        0.035,
    )
    bend = flow(
        over_jumps(
            ("dip", 0.0, 0),
            ("bottom", -0.12 + lag, 6),
            ("bottom", 0.08 + lag, 30),
            ("takeoff", -0.03 + lag, 52),
            ("middle", 0, 32),
            ("touchdown", lag, 26),
            ("absorbed", 0.02, 42),
            ("stand", -0.1, 6),
            ("stand", 0.25, 0),
        ),
        0.035,
    )
    spread = flow(
        over_jumps(
            ("dip", 0, 0),
            ("bottom", -0.1, 7),
            ("takeoff", 0, 4),
            ("middle", 0, 14),
            ("touchdown", 0, 16),
            ("absorbed", 0.05, 14),
            ("stand", 0, 0),
        ),
        0.05,
    )
    flex = reach + (17.0 + 2 * side) * swing * np.clip(walking * 1.3, 0, 1) - 2.0 * walking + 1.2 * wander(11 + side)
    elbow = 13 + 2 * side + bend + walking * (8 + 9 * swing) + 1.5 * wander(13 + side)
    raised = np.clip(reach / 90, 0.0, 1.2)
    # The shoulder girdle goes along with an arm that rises or swings.
    angles[f"{name}Shoulder"][:, 0] = out * (0.12 * np.maximum(reach, 0) + 0.8 * gait.breath)
    angles[f"{name}Shoulder"][:, 1] = -out * (0.10 * flex)
    angles[f"{name}Arm"][:] = np.stack(
        [
            out * ((7.5 + spread) * (1 - 0.8 * raised) - 0.12 * np.maximum(reach, 0) + 0.7 * wander(15 + side)),
            -out * (14 - 36 * raised),
            -flex,
        ],
        axis=-1,
    )
    angles[f"{name}ForeArm"][:, 2] = -elbow
    angles[f"{name}ForeArm"][:, 1] = -out * (7 + 0.04 * bend) * (1 - 0.8 * raised)
    angles[f"{name}Hand"][:, 2] = -6 - 0.15 * elbow + 2 * wander(17 + side)
    angles[f"{name}Hand"][:, 0] = -out * 3.0
