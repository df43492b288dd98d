"""Every triple of Euler angles that means a rotation, written out."""

from __future__ import annotations

import itertools

import numpy as np
from scipy.spatial.transform import Rotation


def triples(order: str, rotation: Rotation, turns: int = 2) -> np.ndarray:
    """List the triples (radians, intrinsic) of one rotation, up to so many whole turns away; not at gimbal lock."""
    first, middle, last = rotation.as_euler(order)
    found = []
    for base in ((first, middle, last), (first + np.pi, np.pi - middle, last + np.pi)):
        for shift in itertools.product(range(-turns, turns + 1), repeat=3):
            found.append(np.array(base) + 2 * np.pi * np.array(shift))
    return np.array(found)


def nearest_triple(order: str, rotation: Rotation, near: np.ndarray) -> np.ndarray:
    """Choose the triple closest to given angles."""
    candidates = triples(order, rotation)
    return candidates[np.argmin(np.sum((candidates - near) ** 2, axis=1))]
