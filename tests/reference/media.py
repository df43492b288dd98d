"""Literal twins of the arithmetic of media."""

from __future__ import annotations

import numpy as np


def blended_weights(place: float, half: float, n: int) -> np.ndarray:
    """Return each frame's weight in the mean, over a window, of the line through the frames; by many small steps."""
    times = np.array([place]) if half <= 0 else place + half * (2 * (np.arange(40_000) + 0.5) / 40_000 - 1)
    weights = np.zeros(n)
    for frame in range(n):
        unit = np.zeros(n)
        unit[frame] = 1.0
        weights[frame] = np.interp(times, np.arange(n), unit).mean()
    return weights
