"""Keeping step with a reference, the slow way: every path tried, and the recurrence over dictionaries.

A triple whose middle is shown in position p is compared with the reference's frame p alone: Eq. 2 with a reference of
three frames and one neighbour.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from tests.reference.paths import Follows, Frames, spread
from tests.reference.scores import scores

Prices = np.ndarray


def costs(
    input_poses: np.ndarray,
    reference: np.ndarray,
    prices: Prices,
    following: Follows,
    *,
    rate: float,
    time_scale: float,
) -> dict[int, np.ndarray]:
    """Return for each inner position what triples cost, by frame and both steps in frames."""
    tables = {}
    for p in range(1, len(reference) - 1):
        distances = scores(
            "joint",
            input_poses,
            reference[p - 1 : p + 2],
            following=following,
            rate=rate,
            time_scale=time_scale,
            n_neighbors=1,
        )
        tables[p] = spread(distances + prices, following)
    return tables


def every_path(n_input: int, n_output: int, following: Follows) -> Iterator[Frames]:
    """Yield all paths from the first frame to the last, of which each step may follow the one before."""

    def extend(path: Frames) -> Iterator[Frames]:
        if len(path) == n_output:
            if path[-1] == n_input - 1:
                yield path
            return
        for step in following if len(path) == 1 else following[path[-1] - path[-2]]:
            if path[-1] + step < n_input:
                yield from extend((*path, path[-1] + step))

    return extend((0,))


def total(
    tables: Mapping[int, np.ndarray], path: Frames, start: Mapping[int, float], end: Mapping[int, float]
) -> float:
    """Add what a path costs, from its first step to its last."""
    cost = start[path[1] - path[0]]
    for p in range(1, len(path) - 1):
        cost += float(tables[p][path[p], path[p] - path[p - 1] - 1, path[p + 1] - path[p] - 1])
    return cost + end[path[-1] - path[-2]]


def recurrence(
    tables: Mapping[int, np.ndarray],
    n_input: int,
    n_output: int,
    following: Follows,
    must: Mapping[int, int],
    start: Mapping[int, float],
    end: Mapping[int, float],
) -> float:
    """Return the least total of any path that passes frame ``must[p]`` in position p; inf where there is none."""
    cost = {(0, step): start[step] for step in following if must.get(1, step) == step < n_input}
    for p in range(1, n_output - 1):
        later: dict[tuple[int, int], float] = {}
        for (i, j), so_far in cost.items():
            for step in following[j - i]:
                k = j + step
                if k >= n_input or must.get(p + 1, k) != k:
                    continue
                found = so_far + float(tables[p][j, j - i - 1, step - 1])
                later[j, k] = min(found, later.get((j, k), math.inf))
        cost = later
    return min((so_far + end[k - j] for (j, k), so_far in cost.items() if k == n_input - 1), default=math.inf)


def by_step(costs: Sequence[float] | np.ndarray, following: Follows) -> dict[int, float]:
    """Name what first or last steps cost by their frames."""
    return {step: float(cost) for step, cost in zip(sorted(following), costs, strict=True)}
