"""What a C3D shows at other times, point by point and number by number, with nothing averaged."""

from __future__ import annotations

import math


def shown_point(points: list[list[float]], place: float) -> tuple[list[float], float] | None:
    """Show one point between frames: its coordinates and the fourth number of the nearest frame; None where missing.

    `points` are its four numbers in each frame, `place` counts frames.
    """
    place = min(max(place, 0.0), len(points) - 1.0)
    if abs(place - round(place)) < 1e-7:
        place = float(round(place))
    before = math.floor(place)
    share = place - before
    after = before if share == 0 else before + 1
    if points[before][3] < 0 or points[after][3] < 0:
        return None
    coordinates = [points[before][axis] + share * (points[after][axis] - points[before][axis]) for axis in range(3)]
    return coordinates, points[before if share < 0.5 else after][3]


def shown_sample(samples: list[float], place: float) -> float:
    """Show an analog channel between samples."""
    place = min(max(place, 0.0), len(samples) - 1.0)
    before = math.floor(place)
    after = min(before + 1, len(samples) - 1)
    return samples[before] + (place - before) * (samples[after] - samples[before])
