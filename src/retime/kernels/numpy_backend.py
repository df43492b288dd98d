"""The kernels in NumPy: slower, always there, and the same answers to the last bit.

Distances that end up in a score are summed in the order that the compiled kernels use: 32 running sums over the
vector, halved to one. Products that only choose candidates may round as they like; a bound on their error makes
sure that no neighbour is missed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from retime.kernels import FloatArray, IntArray, PathProblem, PricedPath

_LANES = 32
# kCancelled in scores.cpp.
_CANCELLED = 1e-3
_BLOCK_NUMBERS = 4 << 20
# Numbers of the pairs that are measured at once.
_PAIR_NUMBERS = 1 << 21


def _added_in_order(terms: FloatArray) -> FloatArray:
    """Add terms over the last axis, in the kernels' order."""
    n = terms.shape[-1]
    padded = np.zeros((*terms.shape[:-1], -(-n // _LANES) * _LANES))
    padded[..., :n] = terms
    lanes = np.zeros((*terms.shape[:-1], _LANES))
    for start in range(0, padded.shape[-1], _LANES):
        lanes += padded[..., start : start + _LANES]
    half = _LANES // 2
    while half:
        lanes = lanes[..., :half] + lanes[..., half : 2 * half]
        half //= 2
    return np.asarray(lanes[..., 0])


def squared_distances(a: FloatArray, b: FloatArray) -> FloatArray:
    """Squared distances between rows (..., n), summed in the kernels' order."""
    difference = a - b
    return _added_in_order(difference * difference)


def _dots(a: FloatArray, b: FloatArray) -> FloatArray:
    """Inner products of rows (..., n), summed in the kernels' order."""
    return _added_in_order(a * b)


def feature_distances(a: FloatArray, b: FloatArray) -> FloatArray:
    """Distances between features (..., 3 d): pose and movement are summed apart, then added."""
    n_numbers = a.shape[-1] // 3
    poses = squared_distances(a[..., :n_numbers], b[..., :n_numbers])
    return np.sqrt(poses + squared_distances(a[..., n_numbers:], b[..., n_numbers:]))


def _candidates(
    queries: FloatArray, rows: FloatArray, n_neighbors: int, blur: float = 0.0
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Find pairs (query, row) that hold every query's nearest rows, for some queries at a time.

    Yields the queries of a part, and its pairs, sorted by query. `blur` bounds what a distance is off by. However many
    rows are as near as the nearest, a part has few pairs, or a single query.
    """
    half = 0.5 * np.sum(rows * rows, axis=1)
    longest = math.sqrt(2 * half.max())
    most = max(1, _PAIR_NUMBERS // rows.shape[1])
    block = max(1, _BLOCK_NUMBERS // len(rows))
    for begin in range(0, len(queries), block):
        part = queries[begin : begin + block]
        value = half - part @ rows.T
        kth = np.partition(value, n_neighbors - 1, axis=1)[:, n_neighbors - 1]
        lengths = np.sqrt(np.sum(part * part, axis=1))
        slack = (rows.shape[1] + 8) * 2.0**-52 * (lengths * longest + half.max()) + 1e-300
        slack += blur * (lengths + longest + blur)
        near = value <= (kth + 2 * slack)[:, None]
        n_pairs = np.cumsum(near.sum(axis=1))
        start = 0
        while start < len(part):
            before = n_pairs[start - 1] if start else 0
            stop = max(start + 1, int(np.searchsorted(n_pairs, before + most, side="right")))
            query, row = np.nonzero(near[start:stop])
            yield np.arange(begin + start, begin + stop), query, row
            start = stop


def _nearest(
    exact: tuple[FloatArray, FloatArray],
    measure: Callable[[FloatArray, FloatArray], FloatArray],
    parts: Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]],
    n_neighbors: int,
) -> tuple[IntArray, FloatArray]:
    """Measure candidates: rows and distances (n_queries, n_neighbors), the nearest first, ties to the earlier."""
    queries, rows = exact
    found = np.empty((len(queries), n_neighbors), dtype=np.int64)
    distances = np.empty((len(queries), n_neighbors))
    most = max(1, _PAIR_NUMBERS // rows.shape[1])
    for which, query, row in parts:
        distance = np.empty(len(row))
        # One query alone may have all rows as candidates.
        for begin in range(0, len(row), most):
            some = slice(begin, begin + most)
            distance[some] = measure(queries[which[query[some]]], rows[row[some]])
        order = np.lexsort((row, distance, query))
        place = order[np.searchsorted(query, np.arange(len(which)))[:, None] + np.arange(n_neighbors)]
        found[which], distances[which] = row[place], distance[place]
    return found, distances


def nearest_features(features: FloatArray, reference: FloatArray, n_neighbors: int) -> tuple[IntArray, FloatArray]:
    """Return rows and distances (n_features, n_neighbors) of the nearest reference features, ties to the earlier."""
    parts = _candidates(features, reference, n_neighbors)
    return _nearest((features, reference), feature_distances, parts, n_neighbors)


def mean_in_order(distances: FloatArray) -> FloatArray:
    """Mean over the last axis, added from the first to the last as the compiled kernels add."""
    total = np.zeros(distances.shape[:-1])
    for neighbor in range(distances.shape[-1]):
        total += distances[..., neighbor]
    return np.asarray(total / distances.shape[-1])


def nearest_poses(inputs: FloatArray, poses: FloatArray, n_neighbors: int) -> IntArray:
    """Return the reference frames nearest in pose to each input frame, (n_input, n_neighbors); ties to the earlier."""
    # Products lose fewer digits near the poses' middle; to move there takes a rounding of every number.
    origin = poses.mean(axis=0)
    blur = 2.0**-50 * math.sqrt(poses.shape[1]) * max(float(np.abs(inputs).max()), float(np.abs(poses).max()))
    parts = _candidates(inputs - origin, poses - origin, n_neighbors, blur)
    return _nearest((inputs, poses), squared_distances, parts, n_neighbors)[0]


def _triples(
    inputs: FloatArray, a: int, b: int, velocity: float, acceleration: float
) -> tuple[slice, FloatArray, FloatArray, FloatArray]:
    """Return the middle frames of skips (a, b), and their poses, velocities and accelerations."""
    n_input = len(inputs)
    before, here, after = inputs[: n_input - a - b], inputs[a : n_input - b], inputs[a + b :]
    return (
        slice(a, n_input - b),
        here,
        (after - before) * velocity,
        ((after - here) - (here - before)) * acceleration,
    )


def joint_scores(
    inputs: FloatArray,
    reference: FloatArray,
    max_skip: int,
    velocity: float,
    acceleration: float,
    n_neighbors: int,
    *,
    each: bool = False,
) -> FloatArray:
    """Score triples; see `retime.kernels.Backend`."""
    out = np.full((len(inputs), max_skip, max_skip, n_neighbors), np.inf)
    for a in range(1, max_skip + 1):
        for b in range(1, max_skip + 1):
            if a + b >= len(inputs):
                break
            middle, *features = _triples(inputs, a, b, velocity, acceleration)
            queries = np.concatenate(features, axis=1)
            out[middle, a - 1, b - 1] = nearest_features(queries, reference, n_neighbors)[1]
    return out if each else mean_in_order(out)


def conditional_scores(
    inputs: FloatArray, reference: FloatArray, nearest: IntArray, max_skip: int, velocity: float, acceleration: float
) -> FloatArray:
    """Score triples; see `retime.kernels.Backend`, and conditional_rows in scores.cpp, whose arithmetic this is."""
    n_input, n_numbers = inputs.shape
    n_neighbors = nearest.shape[1]
    out = np.full((n_input, max_skip, max_skip), np.inf)
    reach = min(max_skip, n_input - 2)
    moves = reference[:, n_numbers:]
    # Inner products of the steps after a frame (e), before it (f), and the reference's movement (dz, ddz).
    e = [inputs[b:] - inputs[:-b] for b in range(1, reach + 1)]
    ee = [_dots(step, step) for step in e]
    near = [(moves[nearest[:, m], :n_numbers], moves[nearest[:, m], n_numbers:]) for m in range(n_neighbors)]
    zz = [_dots(dz, dz) + _dots(ddz, ddz) for dz, ddz in near]
    e_near = [[[_dots(step, z[: len(step)]) for z in pair] for pair in near] for step in e]
    f_near = [[[_dots(step, z[len(z) - len(step) :]) for z in pair] for pair in near] for step in e]
    vv, ww = velocity * velocity, acceleration * acceleration
    for a in range(1, reach + 1):
        for b in range(1, reach + 1):
            if a + b >= n_input:
                break
            middle, _, speed, change = _triples(inputs, a, b, velocity, acceleration)
            # Rows of e belong to the frame that they leave, rows of f to the one that they reach.
            after, before = slice(a, None), slice(0, n_input - a - b)
            ef = _dots(e[b - 1][after], e[a - 1][before])
            total = ee[b - 1][after] + ee[a - 1][before]
            moved = vv * (total + 2 * ef) + ww * (total - 2 * ef)
            size = (vv + ww) * (2 * total)
            squares = np.empty((len(total), n_neighbors))
            for m in range(n_neighbors):
                (e_dz, e_ddz), (f_dz, f_ddz) = e_near[b - 1][m], f_near[a - 1][m]
                along = velocity * (e_dz[after] + f_dz[before]) + acceleration * (e_ddz[after] - f_ddz[before])
                square = (moved - 2 * along) + zz[m][middle]
                lost = np.flatnonzero(~(square > _CANCELLED * (size + zz[m][middle])))
                if len(lost):
                    move = np.concatenate([speed[lost], change[lost]], axis=1)
                    square[lost] = squared_distances(move, moves[nearest[middle][lost, m]])
                squares[:, m] = square
            distance = np.sqrt(squares)
            distance.sort(axis=1)
            out[middle, a - 1, b - 1] = mean_in_order(distance)
    return out


def layered_path(problem: PathProblem, memory_limit: int) -> tuple[IntArray, float] | None:
    """Find the best path; see `retime.kernels.Backend` and layered.cpp, whose recurrence this is."""
    scores, last = problem.scores, problem.last_position_max
    n_input, max_skip = scores.shape[:2]
    end_frame, first_end = n_input - 1, int(problem.positions[-1])
    anchors = dict(zip(problem.positions[:-1].tolist(), problem.frames[:-1].tolist(), strict=True))
    cost = _first_steps(problem)
    _keep(cost, anchors.get(1))

    block = max(1, last - 1)
    if n_input * max_skip * block > memory_limit:
        block = max(1, math.isqrt(8 * last))
    won = np.zeros((block, n_input, max_skip), dtype=np.uint8)
    checkpoints: list[FloatArray] = []
    total, p, step = np.inf, 0, 0
    for q in range(1, last + 1):
        if q >= first_end:
            # A shorter path wins a tie, then the smaller last step.
            ends = cost[end_frame] + problem.end_cost
            a = int(np.argmin(ends))
            if ends[a] < total:
                total, p, step = float(ends[a]), q, a + 1
        if q == last:
            break
        if (q - 1) % block == 0:
            checkpoints.append(cost)
        cost = _advance(scores, cost, won[(q - 1) % block])
        _keep(cost, anchors.get(q + 1))
    if not total < np.inf:
        return None

    path = np.empty(p + 1, dtype=np.int64)
    path[p], path[p - 1] = end_frame, end_frame - step
    k = end_frame
    while p > 1:
        part = (p - 2) // block
        start = 1 + part * block
        if len(checkpoints) > 1:
            cost = checkpoints[part]
            for q in range(start, p):
                cost = _advance(scores, cost, won[q - start])
                _keep(cost, anchors.get(q + 1))
        for q in range(p, start, -1):
            j = k - step
            step, k = int(won[q - 1 - start, j, step - 1]), j
            path[q - 2] = k - step
        p = start
    return path, total


def free_path(problem: PathProblem) -> tuple[IntArray, float] | None:
    """Find the best path of any length; see `retime.kernels.Backend`."""
    scores = problem.scores
    n_input, max_skip = scores.shape[:2]
    reach = np.full(n_input, max_skip)
    for frame in problem.frames[1:].tolist():
        near = np.arange(max(0, frame - max_skip), frame)
        reach[near] = np.minimum(reach[near], frame - near)
    cost = _first_steps(problem)
    for b in range(int(reach[0]) + 1, max_skip + 1):
        cost[b : b + 1, b - 1] = np.inf
    won = np.zeros((n_input, max_skip), dtype=np.uint8)
    # Steps behind: of equal costs the fewer win, then the smaller one before.
    behind = np.ones((n_input, max_skip), dtype=np.int64)
    for j in range(1, n_input - 1):
        totals = cost[j][:, None] + scores[j]
        tied = totals == totals.min(axis=0)
        best = np.argmin(np.where(tied, behind[j][:, None], n_input), axis=0)
        won[j] = best + 1
        steps = np.arange(min(int(reach[j]), n_input - 1 - j))
        cost[j + 1 + steps, steps] = totals[best[steps], steps]
        behind[j + 1 + steps, steps] = behind[j][best[steps]] + 1
    ends = cost[-1] + problem.end_cost
    step = int(np.argmin(np.where(ends == ends.min(), behind[-1], n_input))) + 1
    total = float(ends[step - 1])
    if not total < np.inf:
        return None
    path = [n_input - 1, n_input - 1 - step]
    while path[-1] > 0:
        step = int(won[path[-1], step - 1])
        path.append(path[-1] - step)
    return np.array(path[::-1], dtype=np.int64), total


def priced_path(problem: PathProblem, max_bytes: int) -> PricedPath | None:
    """Leave it to the layered recurrence; see `retime.kernels.Backend`."""
    return None


def _first_steps(problem: PathProblem) -> FloatArray:
    """Costs (n_input, max_skip) after the first step."""
    n_input, max_skip = problem.scores.shape[:2]
    cost = np.full((n_input, max_skip), np.inf)
    steps = np.arange(min(max_skip, n_input - 1))
    cost[steps + 1, steps] = problem.start_cost[steps]
    return cost


def _keep(cost: FloatArray, frame: int | None) -> None:
    """At an anchor's position only its frame is left."""
    if frame is not None:
        cost[:frame] = np.inf
        cost[frame + 1 :] = np.inf


def _advance(scores: FloatArray, cost: FloatArray, won: np.ndarray) -> FloatArray:
    """One layer of Eq. 4; `won` gets the winning step before each (j, b)."""
    totals = cost[:, :, None] + scores
    best = np.argmin(totals, axis=1)
    won[...] = best + 1
    least = np.take_along_axis(totals, best[:, None, :], axis=1)[:, 0]
    following = np.full_like(cost, np.inf)
    for b in range(1, min(cost.shape[1], len(cost) - 1) + 1):
        following[b:, b - 1] = least[: len(least) - b, b - 1]
    return following
