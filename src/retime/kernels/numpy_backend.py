"""The kernels in NumPy: slower, always there, and the same answers to the last bit.

Distances that end up in a score are summed in the order that the compiled kernels use: 16 running sums over each
part of a vector, halved to one. Products that only choose candidates may round as they like; a bound on their error
makes sure that no neighbour is missed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.kernels import (
    AveragedTurns,
    JointArrays,
    JointChannels,
    PathProblem,
    PosedJoints,
    PricedPath,
    RowFormat,
    StepPairs,
    TurnedJoints,
    turn_axes,
)
from retime.kernels.windows import window_weights
from retime.progress import look

_LANES = 16
# kCancelled in exact_distances.hpp.
_CANCELLED = 1e-3
_BLOCK_NUMBERS = 1 << 20
# Numbers of the pairs that are measured at once.
_PAIR_NUMBERS = 1 << 21
# What rows of numbers are written with.
_NUMBER_BYTES = b"0123456789+-.eE \t\r\n"
# The digits of 0 to 999.
_THREE_DIGITS = np.array([list(b"%03d" % n) for n in range(1000)], dtype=np.uint8)
# A quarter turn in three parts, and the series of sine and cosine: those of turns.cpp.
_QUARTER = float.fromhex("0x1.921fb544p+0"), float.fromhex("0x1.0b4611a6p-34"), float.fromhex("0x1.3198a2e037073p-69")
_QUARTERS = float.fromhex("0x1.45f306dc9c883p-1")
_SINE = [(-1.0) ** (n // 2) / math.factorial(n) for n in range(3, 18, 2)]
_COSINE = [(-1.0) ** (n // 2) / math.factorial(n) for n in range(4, 19, 2)]
# Triples of angles that are turned at once: what they take stays in the cache.
_TRIPLES = 2048
# Frames posed at once, and quaternions measured at once, for the same reason.
_FRAMES = 2048
_QUATERNIONS = 8192


def _padded(numbers: FloatArray) -> FloatArray:
    """Append zeros to the last axis, until all running sums have as many."""
    n = numbers.shape[-1]
    padded = np.zeros((*numbers.shape[:-1], -(-n // _LANES) * _LANES))
    padded[..., :n] = numbers
    return padded


def _added_in_order(terms: FloatArray) -> FloatArray:
    """Add terms over the last axis, in the kernels' order."""
    padded = _padded(terms)
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
        look(begin / len(queries))
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
    n_queries: int,
    measure: Callable[[IntArray, IntArray], FloatArray],
    parts: Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]],
    n_neighbors: int,
    n_numbers: int,
) -> tuple[IntArray, FloatArray]:
    """Measure candidates: rows and distances (n_queries, n_neighbors), the nearest first, ties to the earlier."""
    found = np.empty((n_queries, n_neighbors), dtype=np.int64)
    distances = np.empty((n_queries, n_neighbors))
    most = max(1, _PAIR_NUMBERS // n_numbers)
    for which, query, row in parts:
        distance = np.empty(len(row))
        # One query alone may have all rows as candidates.
        for begin in range(0, len(row), most):
            some = slice(begin, begin + most)
            distance[some] = measure(which[query[some]], row[some])
        order = np.lexsort((row, distance, query))
        place = order[np.searchsorted(query, np.arange(len(which)))[:, None] + np.arange(n_neighbors)]
        found[which], distances[which] = row[place], distance[place]
    return found, distances


def nearest_features(features: FloatArray, reference: FloatArray, n_neighbors: int) -> tuple[IntArray, FloatArray]:
    """Return rows and distances (n_features, n_neighbors) of the nearest reference features, ties to the earlier."""
    parts = _candidates(features, reference, n_neighbors)
    return _nearest(
        len(features),
        lambda query, row: feature_distances(features[query], reference[row]),
        parts,
        n_neighbors,
        reference.shape[1],
    )


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
    return _nearest(
        len(inputs),
        lambda query, row: squared_distances(inputs[query], poses[row]),
        parts,
        n_neighbors,
        poses.shape[1],
    )[0]


class _Triples:
    """Squared distances of triples to reference frames, as in `TripleDistances` (exact_distances.hpp)."""

    def __init__(
        self, inputs: FloatArray, reference: FloatArray, pairs: StepPairs, velocity: float, acceleration: float
    ) -> None:
        n_numbers = inputs.shape[1]
        self.inputs, self.velocity, self.acceleration = inputs, velocity, acceleration
        self.poses = reference[:, :n_numbers]
        self.dz, self.ddz = reference[:, n_numbers : 2 * n_numbers], reference[:, 2 * n_numbers :]
        self.plus = velocity * self.dz + acceleration * self.ddz
        self.minus = velocity * self.dz - acceleration * self.ddz
        self.zz = _dots(self.dz, self.dz) + _dots(self.ddz, self.ddz)
        # Steps of b frames belong to the frame that they leave; squared lengths of two steps together, too.
        single = {int(b) for b in pairs.steps}
        both = {int(length) for length in pairs.steps[pairs.before] + pairs.steps[pairs.after]}
        self.steps = {b: inputs[b:] - inputs[:-b] for b in single if b < len(inputs) - 1}
        self.lengths = {b: squared_distances(inputs[:-b], inputs[b:]) for b in single | both if b < len(inputs)}

    def choose(self, a: int, b: int) -> None:
        """Take triples (i, i + a, i + a + b) next."""
        n_triples = len(self.inputs) - a - b
        self.a, self.b = a, b
        self.f, self.e = self.steps[a][:n_triples], self.steps[b][a:]
        both, twice = self.lengths[a + b], 2 * (self.lengths[b][a:] + self.lengths[a][:n_triples])
        vv, ww = self.velocity * self.velocity, self.acceleration * self.acceleration
        self.moved = vv * both + ww * (twice - both)
        self.size = (vv + ww) * twice

    def movement(self, i: IntArray | slice) -> tuple[FloatArray, FloatArray]:
        """Scaled velocities and accelerations of triples."""
        after, before = self.inputs[self.a + self.b :][i], self.inputs[i]
        return (after - before) * self.velocity, (self.e[i] - self.f[i]) * self.acceleration

    def squares(
        self, i: IntArray, row: IntArray, poses: FloatArray | float, along: FloatArray | None = None
    ) -> FloatArray:
        """Squared distances of pairs of a triple and a row, whose poses are so far apart.

        `along` is the sum of the movements' products, where that is known.
        """
        if along is None:
            along = _dots(self.plus[row], self.e[i]) + _dots(self.minus[row], self.f[i])
        total = poses + ((self.moved[i] - 2 * along) + self.zz[row])
        lost = np.flatnonzero(~(total > _CANCELLED * (self.size[i] + self.zz[row])))
        if len(lost):
            which = row[lost]
            move = np.concatenate([_padded(part) for part in self.movement(i[lost])], axis=1)
            there = np.concatenate([_padded(self.dz[which]), _padded(self.ddz[which])], axis=1)
            total[lost] = (poses[lost] if isinstance(poses, np.ndarray) else poses) + squared_distances(move, there)
        return np.asarray(total)


def joint_scores(
    inputs: FloatArray,
    reference: FloatArray,
    steps: StepPairs,
    velocity: float,
    acceleration: float,
    n_neighbors: int,
    *,
    each: bool = False,
) -> FloatArray:
    """Score triples; see `retime.kernels.Backend`."""
    n_input = len(inputs)
    out = np.full((n_input, steps.n_pairs, n_neighbors), np.inf)
    triples = _Triples(inputs, reference, steps, velocity, acceleration)

    def measure(i: IntArray, row: IntArray) -> FloatArray:
        poses = squared_distances(inputs[i + triples.a], triples.poses[row])
        return np.sqrt(triples.squares(i, row, poses))

    for pair, a, b in _pairs(steps, n_input):
        triples.choose(a, b)
        queries = np.concatenate([inputs[a : n_input - b], *triples.movement(slice(0, n_input - a - b))], axis=1)
        parts = _candidates(queries, reference, n_neighbors)
        out[a : n_input - b, pair] = _nearest(len(queries), measure, parts, n_neighbors, reference.shape[1])[1]
    return out if each else mean_in_order(out)


def conditional_scores(
    inputs: FloatArray,
    reference: FloatArray,
    nearest: IntArray,
    steps: StepPairs,
    velocity: float,
    acceleration: float,
) -> FloatArray:
    """Score triples; see `retime.kernels.Backend`."""
    n_input = len(inputs)
    out = np.full((n_input, steps.n_pairs), np.inf)
    triples = _Triples(inputs, reference, steps, velocity, acceleration)
    for pair, a, b in _pairs(steps, n_input):
        triples.choose(a, b)
        i = np.arange(n_input - a - b)
        distances = np.sqrt(np.stack([triples.squares(i, row[a : n_input - b], 0.0) for row in nearest.T], axis=1))
        distances.sort(axis=1)
        out[a : n_input - b, pair] = mean_in_order(distances)
    return out


def _pairs(steps: StepPairs, n_input: int) -> Iterator[tuple[int, int, int]]:
    """Yield the place of each pair, and its steps in frames; those that fit into so many frames."""
    before, after = steps.steps[steps.before], steps.steps[steps.after]
    for pair in np.flatnonzero(before + after < n_input).tolist():
        # Each takes a while: whoever watches may end the work here.
        look()
        yield pair, int(before[pair]), int(after[pair])


def _every_pair(scores: FloatArray, steps: StepPairs) -> FloatArray:
    """Scores (n_input, n_steps, n_steps), infinite where a pair is not allowed."""
    every = np.full((len(scores), steps.n_steps, steps.n_steps), np.inf)
    every[:, steps.before, steps.after] = scores
    return every


def layered_path(problem: PathProblem, memory_limit: int) -> tuple[IntArray, float] | None:
    """Find the best path; see `retime.kernels.Backend` and layered_path.cpp, whose recurrence this is."""
    scores = _every_pair(problem.scores, problem.steps)
    return _layered(problem, memory_limit, lambda q: scores)


def aligned_path(
    problem: PathProblem,
    inputs: FloatArray,
    reference: FloatArray,
    velocity: float,
    acceleration: float,
    memory_limit: int,
) -> tuple[IntArray, float] | None:
    """Find the path that keeps step with a reference; see `retime.kernels.Backend` and aligned_path.cpp."""
    triples = _Triples(inputs, reference, problem.steps, velocity, acceleration)
    pairs = list(_pairs(problem.steps, len(inputs)))

    def costs(position: int) -> FloatArray:
        row = position - 1
        out = problem.scores.copy()
        poses = squared_distances(inputs, triples.poses[row])
        # Products of single steps, which all triples of a frame share.
        plus = {b: _dots(triples.plus[row], moved) for b, moved in triples.steps.items()}
        minus = {a: _dots(triples.minus[row], moved) for a, moved in triples.steps.items()}
        for pair, a, b in pairs:
            triples.choose(a, b)
            i = np.arange(len(inputs) - a - b)
            along = plus[b][a:] + minus[a][: len(i)]
            squares = triples.squares(i, np.full(len(i), row), poses[a : a + len(i)], along)
            out[a : a + len(i), pair] += np.sqrt(squares)
        return _every_pair(out, problem.steps)

    return _layered(problem, memory_limit, costs)


def _layered(
    problem: PathProblem, memory_limit: int, scores_at: Callable[[int], FloatArray]
) -> tuple[IntArray, float] | None:
    """Run the layered recurrence on the scores (n_input, n_steps, n_steps) of each middle frame's position."""
    last, steps = problem.last_position_max, problem.steps.steps
    n_input, n_steps = len(problem.scores), problem.steps.n_steps
    end_frame, first_end = n_input - 1, int(problem.positions[-1])
    anchors = dict(zip(problem.positions[:-1].tolist(), problem.frames[:-1].tolist(), strict=True))

    def keep(cost: FloatArray, position: int) -> None:
        _keep(cost, anchors.get(position))
        if problem.band is not None:
            low, high = problem.band[position].tolist()
            cost[: max(low, 0)] = np.inf
            cost[max(high + 1, 0) :] = np.inf

    cost = _first_steps(problem)
    keep(cost, 1)

    block = max(1, last - 1)
    if n_input * n_steps * block > memory_limit:
        block = max(1, math.isqrt(8 * last))
    won = np.zeros((block, n_input, n_steps), dtype=np.uint8)
    checkpoints: list[FloatArray] = []
    total, p, step = np.inf, 0, 0
    for q in range(1, last + 1):
        if q >= first_end:
            # A shorter path wins a tie, then the smaller last step.
            ends = cost[end_frame] + problem.end_cost
            a = int(np.argmin(ends))
            if ends[a] < total:
                total, p, step = float(ends[a]), q, a
        if q == last:
            break
        if (q - 1) % block == 0:
            checkpoints.append(cost)
        cost = _advance(scores_at(q), steps, cost, won[(q - 1) % block])
        keep(cost, q + 1)
    if not total < np.inf:
        return None

    path = np.empty(p + 1, dtype=np.int64)
    path[p], path[p - 1] = end_frame, end_frame - steps[step]
    k = end_frame
    while p > 1:
        part = (p - 2) // block
        start = 1 + part * block
        if len(checkpoints) > 1:
            cost = checkpoints[part]
            for q in range(start, p):
                cost = _advance(scores_at(q), steps, cost, won[q - start])
                keep(cost, q + 1)
        for q in range(p, start, -1):
            j = k - int(steps[step])
            step, k = int(won[q - 1 - start, j, step]), j
            path[q - 2] = k - steps[step]
        p = start
    return path, total


def free_path(problem: PathProblem) -> tuple[IntArray, float] | None:
    """Find the best path of any length; see `retime.kernels.Backend`."""
    scores, steps = _every_pair(problem.scores, problem.steps), problem.steps.steps
    n_input, n_steps = scores.shape[:2]
    # No step goes past a frame that must be met.
    reach = np.full(n_input, problem.steps.longest)
    for frame in problem.frames[1:].tolist():
        near = np.arange(max(0, frame - problem.steps.longest), frame)
        reach[near] = np.minimum(reach[near], frame - near)
    cost = _first_steps(problem)
    far = np.flatnonzero((steps > reach[0]) & (steps < n_input))
    cost[steps[far], far] = np.inf
    won = np.zeros((n_input, n_steps), dtype=np.uint8)
    # Steps behind: of equal costs the fewer win, then the smaller one before.
    behind = np.ones((n_input, n_steps), dtype=np.int64)
    for j in range(1, n_input - 1):
        totals = cost[j][:, None] + scores[j]
        tied = totals == totals.min(axis=0)
        best = np.argmin(np.where(tied, behind[j][:, None], n_input), axis=0)
        won[j] = best
        near = np.flatnonzero(steps <= min(int(reach[j]), n_input - 1 - j))
        cost[j + steps[near], near] = totals[best[near], near]
        behind[j + steps[near], near] = behind[j][best[near]] + 1
    ends = cost[-1] + problem.end_cost
    step = int(np.argmin(np.where(ends == ends.min(), behind[-1], n_input)))
    total = float(ends[step])
    if not total < np.inf:
        return None
    path = [n_input - 1, n_input - 1 - int(steps[step])]
    while path[-1] > 0:
        step = int(won[path[-1], step])
        path.append(path[-1] - int(steps[step]))
    return np.array(path[::-1], dtype=np.int64), total


def priced_path(problem: PathProblem, max_bytes: int) -> PricedPath | None:
    """Leave it to the layered recurrence; see `retime.kernels.Backend`."""
    return None


def _first_steps(problem: PathProblem) -> FloatArray:
    """Costs (n_input, n_steps) after the first step."""
    n_input, steps = len(problem.scores), problem.steps.steps
    cost = np.full((n_input, len(steps)), np.inf)
    near = np.flatnonzero(steps < n_input)
    cost[steps[near], near] = problem.start_cost[near]
    return cost


def _keep(cost: FloatArray, frame: int | None) -> None:
    """At an anchor's position only its frame is left."""
    if frame is not None:
        cost[:frame] = np.inf
        cost[frame + 1 :] = np.inf


def _advance(scores: FloatArray, steps: IntArray, cost: FloatArray, won: np.ndarray) -> FloatArray:
    """One layer of Eq. 4; `won` gets the place of the winning step before each (j, b)."""
    look()
    totals = cost[:, :, None] + scores
    best = np.argmin(totals, axis=1)
    won[...] = best
    least = np.take_along_axis(totals, best[:, None, :], axis=1)[:, 0]
    following = np.full_like(cost, np.inf)
    for place, b in enumerate(steps.tolist()):
        if b < len(cost):
            following[b:, place] = least[: len(least) - b, place]
    return following


def read_rows(text: bytes, rows: RowFormat) -> FloatArray | None:
    """Read rows of numbers; see `retime.kernels.Backend`. It leaves more to its caller than the compiled one."""
    if rows.decimal_comma:
        text = text.replace(b",", b".")
    if text.translate(None, _NUMBER_BYTES + rows.delimiter.encode()) or not text or text.isspace():
        return None
    lines = text.decode("ascii").splitlines()
    if len(text) > rows.line_bytes and max(map(len, lines)) > rows.line_bytes:
        return None
    try:
        # With these characters alone loadtxt takes the right grammar, whole fields only, rounded correctly.
        table = np.loadtxt(lines, dtype=np.float64, comments=None, delimiter=rows.delimiter or None, ndmin=2)
    except ValueError:
        return None
    if rows.n_columns not in (0, table.shape[1]) or not (np.abs(table) <= rows.largest).all():
        return None
    return table


def write_rows(rows: FloatArray) -> bytes:
    """Write rows of numbers; see `retime.kernels.Backend`."""
    flat = rows.ravel()
    count = np.rint(np.abs(flat) * 1e6).astype(np.int64)
    whole = count // 1_000_000
    decimals = (count - whole * 1_000_000).astype(np.uint32)
    whole = whole.astype(np.uint32)
    # Each number gets a sign, as many digits as the longest one, a point, six digits and a separator; what it does not
    # need is left out in the end.
    n_groups = -(-len(str(int(whole.max(initial=0)))) // 3)
    point = 1 + 3 * n_groups
    text = np.empty((len(flat), point + 8), dtype=np.uint8)
    keep = np.ones(text.shape, dtype=bool)
    text[:, 0] = ord("-")
    keep[:, 0] = (flat < 0) & (count > 0)
    left = whole
    for stop in range(point, 1, -3):
        upper = left // 1000
        text[:, stop - 3 : stop] = _THREE_DIGITS[left - upper * 1000]
        left = upper
    for digit in range(1, 3 * n_groups):
        keep[:, point - 1 - digit] = whole >= 10**digit
    text[:, point] = ord(".")
    thousandths = decimals // 1000
    text[:, point + 1 : point + 4] = _THREE_DIGITS[thousandths]
    text[:, point + 4 : point + 7] = _THREE_DIGITS[decimals - thousandths * 1000]
    text[:, point + 7] = ord(" ")
    text[rows.shape[1] - 1 :: rows.shape[1], point + 7] = ord("\n")
    return text[keep].tobytes()


def three_turns(order: str, angles: FloatArray) -> FloatArray:
    """Multiply turns about three axes; see `retime.kernels.Backend`."""
    (i, j, k), sign = turn_axes(order)
    out = np.empty((len(angles), 4))
    for start in range(0, len(angles), _TRIPLES):
        (s1, s2, s3), (c1, c2, c3) = sines(np.multiply(angles[start : start + _TRIPLES].T, 0.5, order="C"))
        q = out[start : start + _TRIPLES]
        q[:, 0] = c1 * c2 * c3 - sign * (s1 * s2 * s3)
        q[:, 1 + i] = s1 * c2 * c3 + sign * (c1 * s2 * s3)
        q[:, 1 + j] = c1 * s2 * c3 - sign * (s1 * c2 * s3)
        q[:, 1 + k] = c1 * c2 * s3 + sign * (s1 * s2 * c3)
    return out


def sines(angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return sines and cosines of angles, radians up to a million: the same bits on every machine.

    They are off by 0.8 of a unit in the last place at most; those of a C library differ from one to the next.
    """
    quarters = np.rint(angles * _QUARTERS)
    # What is left of the angle, and what rounding has left of that.
    near, more = angles - quarters * _QUARTER[0], quarters * _QUARTER[1]
    most = near - more
    last = quarters * _QUARTER[2]
    r = most - last
    rest = ((near - most) - more) + ((most - r) - last)
    z = r * r
    half = 0.5 * z
    s, c = np.full_like(z, _SINE[-1]), np.full_like(z, _COSINE[-1])
    for of_sine, of_cosine in zip(_SINE[-2::-1], _COSINE[-2::-1], strict=True):
        s *= z
        s += of_sine
        c *= z
        c += of_cosine
    s = r + (r * z * s + (rest - rest * half))
    one = 1.0 - half
    c = one + (((1.0 - one) - half) + (z * z * c - r * rest))
    which = quarters.astype(np.int64)
    odd = (which & 1) != 0
    sine, cosine = np.where(odd, c, s), np.where(odd, s, c)
    return np.where(which & 2, -sine, sine), np.where((which + 1) & 2, -cosine, cosine)


def turn_joints(rows: FloatArray, turned: TurnedJoints, angles: FloatArray, rotations: FloatArray) -> None:
    """Turn joints by their channels; see `retime.kernels.Backend`."""
    degrees = rows[:, turned.columns]
    degrees = np.where(np.abs(degrees) > turned.many, np.fmod(degrees, 360.0), degrees)
    radians = np.deg2rad(degrees)
    angles[:, turned.joints] = radians
    turns = three_turns(turned.order, radians.reshape(-1, 3))
    rotations[:, turned.joints] = turns.reshape(*radians.shape[:2], 4)


def read_joint_rows(
    text: bytes, start: int, piece_bytes: int, rows: RowFormat, channels: JointChannels, into: JointArrays
) -> tuple[int, int] | None:
    """Leave it to `read_rows` and `turn_joints`; see `retime.kernels.Backend`."""
    return None


def pose_joints(
    joints: PosedJoints, rotations: FloatArray, translations: FloatArray, out: tuple[FloatArray, ...]
) -> None:
    """Place joints in space; see `retime.kernels.Backend`."""
    for start in range(0, len(rotations), _FRAMES):
        frames = slice(start, start + _FRAMES)
        rows = _posed_rows(joints, rotations[frames].transpose(1, 2, 0), translations[frames].transpose(1, 2, 0))
        for to, found in zip(out, rows, strict=True):
            to[frames] = found.transpose(2, 0, 1)


def _posed_rows(
    joints: PosedJoints, rotations: FloatArray, translations: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pose frames that come, and go, with one row a component: (n_joints, 4 or 3, n_frames)."""
    # Rows without gaps: whole-column arithmetic instead of strided fours.
    local_q, local_p = np.ascontiguousarray(rotations), np.ascontiguousarray(translations)
    q = np.empty_like(local_q)
    p = np.empty_like(local_p)
    q[0], p[0] = local_q[0], local_p[0]
    if joints.turn.size:
        _multiply_rows(joints.turn[:, None], local_q[0], q[0])
        p[0] = local_p[0][[0, 2, 1]]
        p[0, 2] *= -1.0
    for joint, parent in enumerate(joints.parents[1:].tolist(), start=1):
        _multiply_rows(q[parent], local_q[joint], q[joint])
        _transform_rows(q[parent], p[parent], local_p[joint], p[joint])
    ends = np.empty((len(joints.site_parents), 3, rotations.shape[2]))
    for site, parent in enumerate(joints.site_parents.tolist()):
        _transform_rows(q[parent], p[parent], joints.site_offsets[site][:, None], ends[site])
    return p, q, ends


def _multiply_rows(a: FloatArray, b: FloatArray, out: FloatArray) -> None:
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]


def _transform_rows(q: FloatArray, origin: FloatArray, v: FloatArray, out: FloatArray) -> None:
    w, x, y, z = q
    tx, ty, tz = 2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])
    out[0] = origin[0] + v[0] + w * tx + y * tz - z * ty
    out[1] = origin[1] + v[1] + w * ty + z * tx - x * tz
    out[2] = origin[2] + v[2] + w * tz + x * ty - y * tx


def average_turns(turns: AveragedTurns, rotations: FloatArray, sampled: FloatArray) -> None:
    """Turn joints as averaged poses have them; see `retime.kernels.Backend`."""
    poses = [_average_pose(turns, widths, rotations, sampled) for widths in turns.widths]
    for joint, (group, parent) in enumerate(zip(turns.groups.tolist(), turns.parents.tolist(), strict=True)):
        fast = np.flatnonzero(turns.halves[turns.own[group]] > turns.closed)
        own = poses[group][joint][:, fast]
        if parent >= 0 and turns.groups[parent] != group:
            # The parent carries a foot that this joint doesn't, and may be averaged over less.
            above = poses[turns.groups[parent]]
            there, here = (_turn_in_space(pose, turns.parents, parent, fast) for pose in (above, poses[group]))
            there[1:] *= -1.0
            own = _times(_times(there, here), own)
        sampled[fast, joint] = own.T


def _average_pose(
    turns: AveragedTurns, widths: IntArray, rotations: FloatArray, sampled: FloatArray
) -> dict[int, FloatArray]:
    """Local rotations of the joints that a group needs, each (4, n_output), averaged over their windows."""
    pose: dict[int, FloatArray] = {}
    for joint in np.flatnonzero(widths >= 0).tolist():
        half = turns.halves[widths[joint]]
        fast = np.flatnonzero(half > turns.closed)
        turn = sampled[:, joint].T.copy()
        low, high = turns.centres[fast] - half[fast], turns.centres[fast] + half[fast]
        means = _window_sums(_one_side(rotations[:, joint]), low, high).T
        apart = _four(means, means) < turns.shortest**2
        means[:, apart] = turn[:, fast[apart]]
        turn[:, fast] = means / np.sqrt(_four(means, means))
        pose[joint] = turn
    return pose


def _turn_in_space(pose: dict[int, FloatArray], parents: IntArray, joint: int, frames: IntArray) -> FloatArray:
    """Global rotation of a joint in some frames of a pose, (4, n)."""
    turn = pose[joint][:, frames]
    while parents[joint] >= 0:
        joint = int(parents[joint])
        turn = _times(pose[joint][:, frames], turn)
    return turn


def _times(a: FloatArray, b: FloatArray) -> FloatArray:
    out = np.empty_like(a)
    _multiply_rows(a, b, out)
    return out


def _four(a: FloatArray, b: FloatArray) -> FloatArray:
    """Inner products of quaternions, one row a component."""
    return np.asarray(((a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]) + a[3] * b[3])


def _one_side(rotations: FloatArray) -> FloatArray:
    """Flip quaternions (n_frames, 4) so that each lies on its predecessor's side."""
    turns = _four(rotations[1:].T, rotations[:-1].T) < 0
    sides = np.ones(len(rotations))
    sides[1:][np.cumsum(turns) % 2 == 1] = -1.0
    return rotations * sides[:, None]


def _window_sums(values: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Add up the frames (n_frames, ...) of each window as they weigh, one after another."""
    first = np.minimum(low.astype(np.intp), len(values) - 1)
    counts = np.minimum(np.ceil(high).astype(np.intp), len(values) - 1) - first + 1
    sums = np.zeros((len(low), values.shape[1]))
    here = np.arange(len(low))
    for step in range(int(counts.max(initial=0))):
        here = here[counts[here] > step]
        frames = first[here] + step
        sums[here] += values[frames] * window_weights(frames, low[here], high[here])[:, None]
    return sums


def extent(numbers: FloatArray) -> tuple[float, float]:
    """Find the least and the greatest number; see `retime.kernels.Backend`."""
    least, greatest = float(numbers.min(initial=np.inf)), float(numbers.max(initial=-np.inf))
    # The least number is NaN where any is.
    unbounded = numbers.size and not (least > -np.inf and greatest < np.inf)
    return (math.nan, math.nan) if unbounded else (least, greatest)


def squared_lengths(quaternions: FloatArray) -> tuple[float, float]:
    """Find the least and the greatest squared length; see `retime.kernels.Backend`."""
    rows = quaternions.reshape(-1, 4)
    found: list[float] = []
    for start in range(0, len(rows), _QUATERNIONS):
        with np.errstate(over="ignore", invalid="ignore"):
            w, x, y, z = np.square(rows[start : start + _QUATERNIONS].T)
            found += extent(((w + x) + y) + z)
    return extent(np.array(found))
