"""The figure: its joints, masses, and what its legs and soles reach with."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray
from retime.motion.skeleton import EndSite, Skeleton

# The body: 175 cm, segment lengths near the usual fractions of stature (Drillis and Contini). The rest pose stands
# upright with the arms hanging: joints are near zero most of the time, and Y, the middle angle, far from 90 degrees.
JOINTS: tuple[tuple[str, str, tuple[float, float, float]], ...] = (
    ("Hips", "", (0.0, 97.0, 0.0)),
    ("Spine", "Hips", (0.0, 8.0, -1.0)),
    ("Spine1", "Spine", (0.0, 12.0, -0.5)),
    ("Chest", "Spine1", (0.0, 12.0, 0.0)),
    ("Neck", "Chest", (0.0, 20.0, -0.5)),
    ("Head", "Neck", (0.0, 10.0, 1.5)),
    ("LeftShoulder", "Chest", (3.0, 15.5, 0.5)),
    ("LeftArm", "LeftShoulder", (15.0, -1.0, -1.0)),
    ("LeftForeArm", "LeftArm", (0.0, -29.0, 0.0)),
    ("LeftHand", "LeftForeArm", (0.0, -25.5, 0.0)),
    ("RightShoulder", "Chest", (-3.0, 15.5, 0.5)),
    ("RightArm", "RightShoulder", (-15.0, -1.0, -1.0)),
    ("RightForeArm", "RightArm", (0.0, -29.0, 0.0)),
    ("RightHand", "RightForeArm", (0.0, -25.5, 0.0)),
    ("LeftUpLeg", "Hips", (9.0, -5.0, 0.0)),
    ("LeftLeg", "LeftUpLeg", (0.0, -42.5, 0.0)),
    ("LeftFoot", "LeftLeg", (0.0, -41.5, 0.0)),
    ("LeftToeBase", "LeftFoot", (0.0, -6.0, 13.0)),
    ("RightUpLeg", "Hips", (-9.0, -5.0, 0.0)),
    ("RightLeg", "RightUpLeg", (0.0, -42.5, 0.0)),
    ("RightFoot", "RightLeg", (0.0, -41.5, 0.0)),
    ("RightToeBase", "RightFoot", (0.0, -6.0, 13.0)),
)
END_SITES: tuple[tuple[str, tuple[float, float, float]], ...] = (
    ("Head", (0.0, 16.0, 0.0)),
    ("LeftHand", (0.0, -18.0, 0.0)),
    ("RightHand", (0.0, -18.0, 0.0)),
    ("LeftToeBase", (0.0, -1.0, 6.5)),
    ("RightToeBase", (0.0, -1.0, 6.5)),
)

# Mass in percent of the body and the place of its centre in the joint's space: adjusted Zatsiorsky-Seluyanov parameters
# of men (de Leva 1996), centres at 41, 45, 58 and 46 % of thigh, shank, upper arm and forearm.
MASSES: tuple[tuple[str, float, tuple[float, float, float]], ...] = (
    ("Hips", 11.17, (0.0, 0.5, 0.0)),
    ("Spine1", 16.33, (0.0, 0.0, 1.5)),
    ("Chest", 15.96, (0.0, 8.5, 1.5)),
    ("Head", 6.94, (0.0, 3.0, 1.0)),
    *(
        (f"{side}{joint}", mass, centre)
        for side in ("Left", "Right")
        for joint, mass, centre in (
            ("Arm", 2.71, (0.0, -16.7, 0.0)),
            ("ForeArm", 1.62, (0.0, -11.7, 0.0)),
            ("Hand", 0.61, (0.0, -6.8, 0.0)),
            ("UpLeg", 14.16, (0.0, -17.4, 0.0)),
            ("Leg", 4.33, (0.0, -18.5, 0.0)),
            ("Foot", 1.37, (0.0, -5.0, 5.6)),
        )
    ),
)
WHOLE = sum(mass for _, mass, _ in MASSES)

# What the legs and soles reach with; places from the ankle, in the foot's space.
ANKLE = 8.0
THIGH, SHANK = 42.5, 41.5
HIP = np.array([9.0, -5.0, 0.0])
HEEL = np.array([0.0, -ANKLE, -5.5])
BALL = np.array([0.0, -6.0, 13.0])
SIDES = ("Left", "Right")
OUTWARD = (1.0, -1.0)  # along X
UPPER = sum(mass for name, mass, _ in MASSES if not name.endswith(("Leg", "Foot")))
NAMES = tuple(name for name, _, _ in JOINTS)
SKELETON = Skeleton(
    NAMES,
    tuple(NAMES.index(parent) if parent else -1 for _, parent, _ in JOINTS),
    np.array([offset for _, _, offset in JOINTS]),
    tuple(EndSite(NAMES.index(parent), offset) for parent, offset in END_SITES),
)


def leg_length(knee: FloatArray | float) -> FloatArray:
    """Return the distance from hip to ankle at a knee angle."""
    return np.asarray(np.sqrt(THIGH**2 + SHANK**2 + 2 * THIGH * SHANK * np.cos(np.radians(knee))))
