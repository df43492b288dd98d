"""Clips made by arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from retime import EndSite, Motion, Signal, Skeleton
from retime.motion import rotation

RATE = 60
FLIGHT = (1.75, 2.25)


def figure(name: str = "jump", *, seconds: float = 4.0, swing: float = 1.2) -> Motion:
    """Make a figure of two legs and a trunk, in metres: it walks on the spot, jumps once, and stands still."""
    skeleton = Skeleton(
        ("Hips", "Chest", "LeftLeg", "LeftFoot", "RightLeg", "RightFoot"),
        (-1, 0, 0, 2, 0, 4),
        np.array([[0, 0.9, 0], [0, 0.5, 0], [0.1, 0, 0], [0, -0.45, 0], [-0.1, 0, 0], [0, -0.45, 0]], dtype=float),
        (EndSite(1, (0.0, 0.3, 0.0)), EndSite(3, (0.0, -0.45, 0.0)), EndSite(5, (0.0, -0.45, 0.0))),
    )
    t = np.arange(round(seconds * RATE) + 1) / RATE
    walking = np.clip(1.5 - t, 0.0, 0.25) * 4
    leap = np.clip((t - FLIGHT[0]) * (FLIGHT[1] - t), 0.0, None)
    angles = np.zeros((len(t), 6, 3))
    stride = walking * 0.4 * np.sin(2 * np.pi * swing * t)
    tuck = 10 * leap
    angles[:, 2, 0], angles[:, 4, 0] = stride + tuck, tuck - stride
    angles[:, 3, 0], angles[:, 5, 0] = -2 * tuck, -2 * tuck
    angles[:, 1, 1] = 0.3 * stride + 0.05 * np.sin(1.7 * t)
    translations = np.broadcast_to(skeleton.offsets, (len(t), 6, 3)).copy()
    # The feet stay where the ground is: the hips come down as the legs swing out.
    translations[:, 0, 1] += 0.9 * (np.cos(stride) - 1) + 9.81 / 2 * leap
    return Motion(skeleton, rotation.from_euler("XYZ", angles), translations, Fraction(RATE), name)


def curve(name: str = "camera", *, first: float = 0.0) -> Signal:
    """Make a signal of two channels, two seconds at 30 Hz."""
    t = first + np.arange(60) / 30
    return Signal(("pan", "tilt"), np.stack([np.sin(t**2), np.cos(3 * t)], axis=1), Fraction(30), name, "time")
