"""Eq. 2 by explicit loops over exact fractions: nothing rounds before the square root."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from tests.reference.paths import Follows

Vector = list[Fraction]


def exact(rows: np.ndarray) -> list[Vector]:
    """Turn an array of doubles into lists of the very same numbers."""
    return [[Fraction(float(x)) for x in row] for row in rows]


def velocity(before: Vector, after: Vector, rate: Fraction, time_scale: Fraction) -> Vector:
    """τ (y_k - y_i) / 2Δ."""
    period = 1 / rate
    return [time_scale * (k - i) / (2 * period) for i, k in zip(before, after, strict=True)]


def acceleration(before: Vector, here: Vector, after: Vector, rate: Fraction, time_scale: Fraction) -> Vector:
    """τ² (y_k - 2 y_j + y_i) / Δ²."""
    period = 1 / rate
    return [time_scale**2 * (k - 2 * j + i) / period**2 for i, j, k in zip(before, here, after, strict=True)]


def distance(a: Vector, b: Vector) -> float:
    """Euclidean distance, rounded once in the square root and once before it."""
    square = sum(((x - y) ** 2 for x, y in zip(a, b, strict=True)), Fraction(0))
    # A double can't hold every square of a small fraction: scale by a power of four first.
    shift = 0
    while 0 < square < Fraction(1, 4**100):
        square, shift = square * 4**100, shift + 100
    return math.sqrt(square) / 2.0**shift


def mean_of_least(distances: Sequence[float], n_neighbors: int) -> float:
    """Mean of the n_neighbors smallest."""
    return math.fsum(sorted(distances)[:n_neighbors]) / n_neighbors


def nearest_in_pose(
    pose: Vector, reference: Sequence[Vector], weights: Sequence[Fraction], n_neighbors: int
) -> list[int]:
    """Rows nearest to a pose, a weight w making a row w times nearer; of two at the same distance the earlier one."""

    def squared(row: int) -> Fraction:
        return sum(((x - y) ** 2 for x, y in zip(pose, reference[row], strict=True)), Fraction(0)) / weights[row] ** 2

    return sorted(range(len(reference)), key=lambda row: (squared(row), row))[:n_neighbors]


def scores(
    kind: str,
    input_poses: np.ndarray,
    *references: np.ndarray,
    max_skip: int = 0,
    following: Follows | None = None,
    rate: float,
    time_scale: float,
    n_neighbors: int,
    weights: Sequence[float] = (),
) -> np.ndarray:
    """Score every triple; ``kind`` is "joint" or "conditional".

    With `following` those of its steps, (n_input, n_pairs): by the step before, then by the step after.
    """
    hertz, tau = Fraction(rate), Fraction(time_scale)
    poses, moves, weight_of = [], [], []
    for reference, weight in zip(references, weights or [1.0] * len(references), strict=True):
        z = exact(reference)
        for t in range(1, len(z) - 1):
            poses.append(z[t])
            moves.append(velocity(z[t - 1], z[t + 1], hertz, tau) + acceleration(z[t - 1], z[t], z[t + 1], hertz, tau))
            weight_of.append(Fraction(weight))
    y = exact(input_poses)
    every = following or {a: range(1, max_skip + 1) for a in range(1, max_skip + 1)}
    pairs = [(a, b) for a in sorted(every) for b in sorted(every[a])]
    table = np.full((len(y), len(pairs)), np.inf)
    for j in range(len(y)):
        nearest = nearest_in_pose(y[j], poses, weight_of, n_neighbors) if kind == "conditional" else []
        for pair, (a, b) in enumerate(pairs):
            i, k = j - a, j + b
            if i < 0 or k >= len(y):
                continue
            move = velocity(y[i], y[k], hertz, tau) + acceleration(y[i], y[j], y[k], hertz, tau)
            if kind == "joint":
                distances = [
                    distance(y[j] + move, poses[row] + moves[row]) / float(weight_of[row]) for row in range(len(poses))
                ]
            else:
                distances = [distance(move, moves[row]) for row in nearest]
            table[j, pair] = mean_of_least(distances, n_neighbors)
    return table if following else table.reshape(len(y), max_skip, max_skip)
