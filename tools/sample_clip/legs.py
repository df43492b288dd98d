"""The legs, which reach from the hips for the feet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.motion import rotation
from sample_clip.body import HIP, MASSES, OUTWARD, SHANK, SIDES, THIGH
from sample_clip.feet import Foot, turned


@dataclass(frozen=True)
class Leg:
    """One leg reaching from its hip to its ankle, over the whole clip."""

    down: FloatArray  # hip to ankle, (n, 3)
    knee: FloatArray  # its bend
    thigh: FloatArray  # rotation, (n, 4)
    shank: FloatArray
    sole: FloatArray
    mass: FloatArray  # sum of mass times place, (n, 3)


def reach_for(side: int, foot: Foot, root: FloatArray, hips: FloatArray) -> Leg:
    """Bend a leg so that it joins the pelvis to the ankle; a leg that is too short points at it, straight."""
    hip = root + rotation.rotate(hips, HIP * [OUTWARD[side], 1, 1])
    down = foot.ankle - hip
    distance = np.sqrt(np.sum(down**2, axis=-1))
    toward = down / distance[:, None]
    length = np.minimum(distance, THIGH + SHANK - 1e-9)
    knee = np.pi - np.arccos(np.clip((THIGH**2 + SHANK**2 - length**2) / (2 * THIGH * SHANK), -1, 1))
    at_hip = np.arccos(np.clip((THIGH**2 + length**2 - SHANK**2) / (2 * THIGH * length), -1, 1))
    # The knee points where the toes point, a little less outward.
    ahead = np.radians(0.8 * foot.yaw)
    forward = np.stack([np.sin(ahead), np.zeros_like(ahead), np.cos(ahead)], axis=-1)
    across = np.cross(-toward, forward)
    across /= np.sqrt(np.sum(across**2, axis=-1, keepdims=True))
    front = np.cross(across, -toward)
    up = -(np.cos(at_hip)[:, None] * toward + np.sin(at_hip)[:, None] * front)
    thigh = from_axes(across, up, np.cross(across, up))
    shank = rotation.multiply(thigh, rotation.about_axis(0, knee))
    sole = turned(foot.yaw, foot.pitch)
    origin = {"UpLeg": hip, "Leg": hip - THIGH * up, "Foot": foot.ankle}
    turn = {"UpLeg": thigh, "Leg": shank, "Foot": sole}
    mass = np.zeros_like(hip)
    for name, weight, centre in MASSES:
        joint = name.removeprefix(SIDES[side])
        if name != joint and joint in origin:
            mass += weight * (origin[joint] + rotation.rotate(turn[joint], np.array(centre)))
    return Leg(down, np.degrees(knee), thigh, shank, sole, mass)


def pose_leg(side: int, leg: Leg, foot: Foot, hips: FloatArray, angles: dict[str, FloatArray]) -> None:
    """Fill in the angles of a leg."""
    name = SIDES[side]
    angles[f"{name}UpLeg"] = euler(rotation.multiply(rotation.conjugate(hips), leg.thigh))
    angles[f"{name}Leg"][:, 2] = leg.knee
    angles[f"{name}Foot"] = euler(rotation.multiply(rotation.conjugate(leg.shank), leg.sole))
    angles[f"{name}ToeBase"][:, 2] = -foot.toes


def from_axes(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """Return the rotations whose axes are x, y, z; none turns by as much as half a turn here."""
    w = 0.5 * np.sqrt(np.maximum(1 + x[:, 0] + y[:, 1] + z[:, 2], 1e-12))
    return rotation.normalize(
        np.stack(
            [w, (y[:, 2] - z[:, 1]) / (4 * w), (z[:, 0] - x[:, 2]) / (4 * w), (x[:, 1] - y[:, 0]) / (4 * w)], axis=-1
        )
    )


def euler(q: FloatArray) -> FloatArray:
    """Return angles (Z, Y, X) in degrees."""
    return np.degrees(rotation.to_euler("ZYX", q))
