"""The body in flight: the legs tuck, and it turns so that its angular momentum stays put."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray
from retime.motion import rotation
from retime.motion.kinematics import global_poses
from sample_clip.body import MASSES, NAMES, SIDES
from sample_clip.curves import Knot, quintic
from sample_clip.mass_centre import mass_centre, motion_of
from sample_clip.plan import FINE, JUMPS, RATE, TIMES


def flight_legs(angles: dict[str, FloatArray]) -> None:
    """Carry the legs through each flight: straighten, tuck a little, reach for the ground.

    Angles and their rates are taken over from the pushing leg and handed to the landing one.
    """
    h = 1 / (RATE * FINE)
    tuck = {"Leg": 46.0, "UpLeg": -36.0, "Foot": 12.0, "ToeBase": -6.0}
    for jump in JUMPS:
        first, last = round(jump.takeoff / h), round(jump.touchdown / h)
        t = jump.touchdown - jump.takeoff
        for side, name in enumerate(SIDES):
            knee = angles[f"{name}Leg"][:, 2]
            rates = {
                joint: (
                    (3 * c[first] - 4 * c[first - 1] + c[first - 2]) / (2 * h),
                    (-3 * c[last] + 4 * c[last + 1] - c[last + 2]) / (2 * h),
                )
                for joint, c in ((joint, angles[f"{name}{joint}"]) for joint in tuck)
            }
            # The legs go on unfolding, and begin to give before they land, as long as the knee needs to stop in time.
            off = -2 * (knee[first] - 8.0) / rates["Leg"][0][2]
            on = 2 * (knee[last] - 16.0) / rates["Leg"][1][2]
            for joint, middle in tuck.items():
                before, after = rates[joint]
                for axis in range(3):
                    c = angles[f"{name}{joint}"][:, axis]
                    knots: list[Knot] = [(0.0, c[first], before[axis], -before[axis] / off)]
                    if axis == 2:
                        knots.append(((0.5 + 0.02 * side) * t, middle + 3 * side))
                    knots.append((t, c[last], after[axis], after[axis] / on))
                    c[first : last + 1] = quintic(knots, TIMES[first : last + 1] - jump.takeoff)


def spin(angles: dict[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return angular momentum and moment of inertia about the centre of mass and the X axis, per unit of mass.

    Segments count as points at their centres.
    """
    motion = motion_of(np.zeros((len(TIMES), 3)), angles)
    poses = global_poses(motion)
    middle = mass_centre(motion)
    momentum, inertia = np.zeros((2, len(TIMES)))
    for name, mass, centre in MASSES:
        joint = NAMES.index(name)
        arm = poses.positions[:, joint] + rotation.rotate(poses.rotations[:, joint], np.array(centre)) - middle
        velocity = np.gradient(arm, TIMES, axis=0)
        momentum += mass / 100 * (arm[:, 1] * velocity[:, 2] - arm[:, 2] * velocity[:, 1])
        inertia += mass / 100 * (arm[:, 1] ** 2 + arm[:, 2] ** 2)
    return momentum, inertia


def keep_turning(angles: dict[str, FloatArray]) -> None:
    """Turn the body in flight so that its angular momentum about the side axis stays put: legs forward, trunk forward.

    The turn starts and ends at rest, where feet are on the ground; the momentum is the one that makes it end at 0.
    """
    momentum, inertia = spin(angles)
    for jump in JUMPS:
        window = quintic(
            [(jump.takeoff, 0.0), (jump.takeoff + 0.06, 1.0), (jump.touchdown - 0.06, 1.0), (jump.touchdown, 0.0)],
            TIMES,
        )
        share = window / inertia
        level = (share * momentum).sum() / share.sum()
        rate = share * (level - momentum)
        turn = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2)]) / (RATE * FINE)
        angles["Hips"][:, 2] += np.degrees(turn)
