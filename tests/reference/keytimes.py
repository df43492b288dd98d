"""Speeds scaled between bounds, literally."""

from __future__ import annotations

import numpy as np


def bounded(
    spacing: np.ndarray, moved: np.ndarray, change: float, choice: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """Find the one factor by halving; the caller knows that there is one."""

    def moves(factor: float) -> list[float]:
        found = []
        for i in range(len(moved)):
            speed = moved[i] / spacing[i]
            if choice[i]:
                speed = min(max(factor * speed, low[i]), high[i])
            found.append(speed * spacing[i])
        return found

    small, large = 1e-6, 1e6
    for _ in range(200):
        middle = (small * large) ** 0.5
        if sum(moves(middle)) < change:
            small = middle
        else:
            large = middle
    return np.array(moves(large))
