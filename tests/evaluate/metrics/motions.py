"""Motions whose figures of merit are known: a hip over a foot, and a jump."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from retime.motion.motion import Motion
from retime.motion.rotation import identity
from retime.motion.skeleton import Skeleton
from retime.warp.curve import Warp
from tests.evaluate.figures import FLIGHT, jumper

PAIR = Skeleton(("Hips", "LeftFoot"), (-1, 0), np.array([[0.0, 0.8, 0.0], [0.0, -0.8, 0.0]]))


def moving(places: np.ndarray, rate: int = 60, *, unit: float = 1.0) -> Motion:
    """Move a hip over a foot, without turning; places (n_frames, 3) are added to both."""
    translations = np.repeat(PAIR.offsets[None], len(places), axis=0)
    translations[:, 0] += places
    return Motion(PAIR, identity(len(places), 2), translations, Fraction(rate), metres_per_unit=unit)


def along(axis: int, values: np.ndarray, **how: float) -> Motion:
    places = np.zeros((len(values), 3))
    places[:, axis] = values
    return moving(places, **how)


def linear(motion: Motion, speed: float) -> Warp:
    return Warp([0.0, motion.end_time / speed], [0.0, motion.end_time])


# The whole flight as it was made, not as a threshold finds it.
JUMP = jumper(lead=1.0, rest=1.0)


ALOFT = ((1.0, 1.0 + FLIGHT),)
