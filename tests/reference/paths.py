"""Shortest paths the slow way: by trying every path, and by the paper's recurrence over dictionaries.

Both add a path's costs from its first step to its last, as the definition of the total says, so totals can be
compared bit for bit.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

import numpy as np

Frames = tuple[int, ...]
# Each step that may be taken, and the steps that may be taken next.
Follows = Mapping[int, Sequence[int]]


def follows(steps: Sequence[int], ratio: float) -> Follows:
    """Let steps follow each other where the longer is at most so many times the shorter."""
    most = Fraction(ratio) if ratio < np.inf else Fraction(max(steps))
    return {a: [b for b in steps if max(a, b) <= most * min(a, b)] for a in steps}


def spread(scores: np.ndarray, following: Follows) -> np.ndarray:
    """Put scores (n_input, n_pairs) where those of all steps stand, (n_input, longest, longest)."""
    longest = max(following)
    table = np.full((len(scores), longest, longest), np.inf)
    for j, row in enumerate(scores):
        numbers = iter(row)
        for a in sorted(following):
            for b in sorted(following[a]):
                table[j, a - 1, b - 1] = next(numbers)
        assert next(numbers, None) is None
    return table


def every_path(
    n_input: int,
    n_output: int,
    max_skip: int,
    anchors: Mapping[int, int] = {},
    following: Follows | None = None,
) -> Iterator[Frames]:
    """Yield all increasing paths from frame 0 to the last one that obey `max_skip` and pass the anchors.

    With `following`, each step must be one of those that may follow the step before.
    """

    def extend(path: Frames) -> Iterator[Frames]:
        position = len(path) - 1
        if path[-1] != anchors.get(position, path[-1]):
            return
        if position == n_output - 1:
            if path[-1] == n_input - 1:
                yield path
            return
        for step in following or range(1, max_skip + 1):
            if following and position > 0 and step not in following[path[-1] - path[-2]]:
                continue
            # No step is shorter than one frame: a path that can't stop in time is not worth following.
            if path[-1] + step + (n_output - 2 - position) <= n_input - 1:
                yield from extend((*path, path[-1] + step))

    if n_output >= 1:
        yield from extend((0,))


def total(
    scores: np.ndarray,
    path: Sequence[int],
    start_cost: Sequence[float] | np.ndarray | None = None,
    end_cost: Sequence[float] | np.ndarray | None = None,
) -> float:
    """Add the costs of a path: the first step's, every inner frame's score, the last step's."""
    cost = 0.0 if start_cost is None else float(start_cost[path[1] - path[0] - 1])
    for i, j, k in zip(path[:-2], path[1:-1], path[2:], strict=True):
        cost += float(scores[j, j - i - 1, k - j - 1])
    return cost if end_cost is None else cost + float(end_cost[path[-1] - path[-2] - 1])


def rank(path: Frames) -> tuple[int, ...]:
    """Of paths that tie: the shorter, then the smaller skips, read back from the end."""
    steps = [after - before for before, after in itertools.pairwise(path)]
    return (len(path), *reversed(steps))


def best_path(
    scores: np.ndarray,
    lengths: range,
    anchors: Mapping[int, int] = {},
    start_cost: np.ndarray | None = None,
    end_cost: np.ndarray | None = None,
    following: Follows | None = None,
) -> tuple[Frames, float] | None:
    """Try every path of the given lengths (numbers of frames)."""
    n_input, max_skip = scores.shape[:2]
    best: tuple[float, tuple[int, ...], Frames] | None = None
    for n_output in lengths:
        for path in every_path(n_input, n_output, max_skip, anchors, following):
            cost = total(scores, path, start_cost, end_cost)
            if cost < np.inf and (best is None or (cost, rank(path)) < best[:2]):
                best = (cost, rank(path), path)
    return None if best is None else (best[2], best[0])


def best_loop(
    scores: np.ndarray,
    lengths: range,
    anchors: Mapping[int, int],
    start_cost: np.ndarray,
    end_cost: np.ndarray,
    following: Follows | None = None,
) -> tuple[Frames, float] | None:
    """Try, for each first step, every path that ends with it too; of equal ones take the smaller first step."""
    best: tuple[Frames, float] | None = None
    for step in range(len(start_cost)):
        only = np.full((2, len(start_cost)), np.inf)
        only[:, step] = start_cost[step], end_cost[step]
        found = best_path(scores, lengths, anchors, only[0], only[1], following)
        if found is not None and (best is None or found[1] < best[1]):
            best = found
    return best


def best_free_path(
    scores: np.ndarray,
    through: Sequence[int] = (),
    start_cost: np.ndarray | None = None,
    end_cost: np.ndarray | None = None,
    following: Follows | None = None,
) -> tuple[Frames, float] | None:
    """Try every path of any length that passes the given frames."""
    n_input, max_skip = scores.shape[:2]
    found: list[tuple[float, tuple[int, ...], Frames]] = []
    for n_output in range(2, n_input + 1):
        for path in every_path(n_input, n_output, max_skip, {}, following):
            if set(through) <= set(path):
                found.append((total(scores, path, start_cost, end_cost), rank(path), path))
    least = min(found, default=None)
    return None if least is None or least[0] == np.inf else (least[2], least[0])


def recurrence(
    scores: np.ndarray, n_output: int, anchors: Mapping[int, int] = {}, following: Follows | None = None
) -> tuple[Frames, float] | None:
    """Eq. 3 and 4, one layer of vertices (j, k) after another; at least three frames."""
    n_input, max_skip = scores.shape[:2]
    must = {**anchors, 0: 0, n_output - 1: n_input - 1}

    def allowed(position: int, frame: int) -> bool:
        return frame < n_input and must.get(position, frame) == frame

    cost = {(0, k): 0.0 for k in following or range(1, max_skip + 1) if allowed(1, k)}
    came_from: list[dict[tuple[int, int], int]] = []
    for position in range(2, n_output):
        later: dict[tuple[int, int], float] = {}
        winner: dict[tuple[int, int], int] = {}
        # Larger i is the smaller skip: visited first, it keeps a tie.
        for i, j in sorted(cost, reverse=True):
            for step in following[j - i] if following else range(1, max_skip + 1):
                k = j + step
                if not allowed(position, k):
                    continue
                candidate = cost[i, j] + float(scores[j, j - i - 1, k - j - 1])
                if candidate < later.get((j, k), np.inf):
                    later[j, k], winner[j, k] = candidate, i
        cost = later
        came_from.append(winner)
    if not cost:
        return None
    least = min(cost.values())
    j, k = max(vertex for vertex in cost if cost[vertex] == least)
    path = [k, j]
    for winner in reversed(came_from):
        i = winner[j, k]
        path.append(i)
        j, k = i, j
    return tuple(reversed(path)), least
