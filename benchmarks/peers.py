"""What a user would build this from, written plainly: k-NN of other libraries, and the recurrence in NumPy and Numba.

Nothing here is used by retime. Libraries that are not installed raise ImportError where they are first needed.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def triple_features(poses: Floats, max_skip: int, velocity: float, acceleration: float) -> tuple[Floats, Ints]:
    """Features of every triple, one a row, and where each belongs: (j, a - 1, b - 1)."""
    n = len(poses)
    rows = []
    places = []
    for a in range(1, max_skip + 1):
        for b in range(1, max_skip + 1):
            j = np.arange(a, n - b)
            before, here, after = poses[j - a], poses[j], poses[j + b]
            rows.append(
                np.concatenate(
                    [here, (after - before) * velocity, ((after - here) - (here - before)) * acceleration], axis=1
                )
            )
            places.append(np.stack([j, np.full(len(j), a - 1), np.full(len(j), b - 1)], axis=1))
    return np.concatenate(rows), np.concatenate(places)


def sklearn_neighbors(queries: Floats, reference: Floats, n_neighbors: int, *, algorithm: str) -> Floats:
    """Distances by scikit-learn: algorithm "brute" or "kd_tree", on all cores that it finds."""
    from sklearn.neighbors import NearestNeighbors

    search = NearestNeighbors(n_neighbors=n_neighbors, algorithm=algorithm, n_jobs=-1).fit(reference)
    return np.asarray(search.kneighbors(queries)[0])


def scipy_neighbors(queries: Floats, reference: Floats, n_neighbors: int) -> Floats:
    """Distances by scipy's k-d tree, on all cores."""
    from scipy.spatial import cKDTree

    return np.asarray(cKDTree(reference).query(queries, k=n_neighbors, workers=-1)[0])


def faiss_neighbors(queries: Floats, reference: Floats, n_neighbors: int) -> Floats:
    """Distances by faiss' flat index: exact but for single precision."""
    import faiss

    index = faiss.IndexFlatL2(reference.shape[1])
    index.add(reference.astype(np.float32))
    squares, _ = index.search(queries.astype(np.float32), n_neighbors)
    return np.sqrt(squares.astype(np.float64))


def scores_by(
    neighbors: Callable[[Floats, Floats, int], Floats],
    poses: Floats,
    reference: Floats,
    *,
    max_skip: int,
    n_neighbors: int,
    velocity: float,
    acceleration: float,
    every: int = 1,
) -> Floats:
    """Score triples by some k-NN; with `every` only each so-many-th of them."""
    queries, places = triple_features(poses, max_skip, velocity, acceleration)
    out = np.full((len(poses), max_skip, max_skip), np.inf)
    out[tuple(places[::every].T)] = neighbors(queries[::every], reference, n_neighbors).mean(axis=1)
    return out


def numpy_path(scores: Floats, n_output: int) -> tuple[Ints, float]:
    """Find the best path by the layered recurrence, one layer a step; (k, b) is frame k reached by step b."""
    n_input, max_skip, _ = scores.shape
    cost = np.full((n_input, max_skip), np.inf)
    for b in range(1, max_skip + 1):
        cost[b, b - 1] = 0.0
    won = np.zeros((n_output, n_input, max_skip), dtype=np.uint8)
    for position in range(1, n_output - 1):
        totals = cost[:, :, None] + scores
        won[position] = totals.argmin(axis=1)
        best = totals.min(axis=1)
        cost = np.full((n_input, max_skip), np.inf)
        for b in range(1, max_skip + 1):
            cost[b:, b - 1] = best[: n_input - b, b - 1]
    return _trace_back(cost, won, n_output)


def _trace_back(cost: Floats, won: NDArray[np.uint8], n_output: int) -> tuple[Ints, float]:
    frames = np.empty(n_output, dtype=np.int64)
    k, b = len(cost) - 1, int(cost[-1].argmin()) + 1
    total = float(cost[-1, b - 1])
    frames[-1] = k
    for position in range(n_output - 2, 0, -1):
        k, b = k - b, int(won[position, k - b, b - 1]) + 1
        frames[position] = k
    frames[0] = k - b
    return frames, total


def numba_path() -> Callable[[Floats, int], tuple[Ints, float]]:
    """Compile the layered recurrence as plain loops with Numba."""
    import numba

    @numba.njit(cache=False)
    def layers(scores, n_output):  # type: ignore[no-untyped-def]
        n_input, max_skip, _ = scores.shape
        cost = np.full((n_input, max_skip), np.inf)
        for b in range(1, max_skip + 1):
            cost[b, b - 1] = 0.0
        won = np.zeros((n_output, n_input, max_skip), dtype=np.uint8)
        for position in range(1, n_output - 1):
            following = np.full((n_input, max_skip), np.inf)
            for j in range(position, n_input):
                for b in range(min(max_skip, n_input - 1 - j)):
                    best, step = np.inf, 0
                    for a in range(max_skip):
                        total = cost[j, a] + scores[j, a, b]
                        if total < best:
                            best, step = total, a
                    following[j + b + 1, b] = best
                    won[position, j, b] = step
            cost = following
        return cost, won

    def path(scores: Floats, n_output: int) -> tuple[Ints, float]:
        cost, won = layers(scores, n_output)
        return _trace_back(cost, won, n_output)

    return path
