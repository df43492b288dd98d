"""Following a hand's speeds, literally: one moment, one frame, one step after the other."""

from __future__ import annotations

import itertools
import math

import numpy as np


def seconds_shown(output_times, input_times, low: float, high: float) -> float:
    """Output seconds in which a warp shows input from `low` to `high`."""
    total = 0.0
    for (t0, t1), (x0, x1) in zip(itertools.pairwise(output_times), itertools.pairwise(input_times), strict=True):
        a, b = min(x0, x1), max(x0, x1)
        if a == b:
            total += t1 - t0 if low < a < high else 0.0
        else:
            total += (t1 - t0) * max(0.0, min(b, high) - max(a, low)) / (b - a)
    return total


def looked_up(points, others, values, n_neighbors: int) -> tuple[list[float], list[float]]:
    """For each point the mean value at its nearest others, and the distance to the nearest."""
    means, nearest = [], []
    for point in points:
        apart = [(math.dist(point, other), i) for i, other in enumerate(others)]
        chosen = sorted(apart)[:n_neighbors]
        means.append(float(np.mean([values[i] for _, i in chosen])))
        nearest.append(chosen[0][0])
    return means, nearest


def hand_price(log_speeds, activity, scale: float, upsample: int, frame: int, step: int) -> float:
    """Price of the step from `frame` to `frame + step`."""
    shown = range(frame, frame + step + 1)
    wanted = sum(log_speeds[j] for j in shown) / len(shown)
    moving = sum(max(activity[j], 0.1) for j in shown) / len(shown)
    speed = step / upsample
    return scale * moving * speed * (math.log(speed) - wanted) ** 2
