"""The compiled kernels, and what makes their search quick: order among the reference's frames, and fewer numbers."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

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
    _kernels,
    n_threads,
    turn_axes,
)
from retime.progress import look

# Long kernels tell how far they are, and end where that raises.
_kernels.tell(look)

# A reference of so many frames is worth putting in order for so many triples.
_LONG = 4096
_MANY = 64_000
# kPanel in rough_distances.hpp.
_BLOCK = 64
# Share of the variance that a projection may lose: it makes bounds cheaper, but less tight.
_LOST_VARIANCE = 0.002
# Rows of a reference that tell its directions.
_TELLING = 4096
# Multiplications up to which OpenBLAS, which comes with NumPy, works in the thread that calls it.
_SMALL = 1 << 18
# Stands for a band that there is not.
_ANY = np.zeros((0, 2), dtype=np.int64)
# Bytes of costs that a search in step with a reference makes at once.
_ALIGNED_COSTS = 64 << 20


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
    n_input, n_numbers = inputs.shape
    n_reference = len(reference)
    out = np.full((n_input, steps.n_pairs, *([n_neighbors] if each else [])), np.inf)
    scale = _scale(inputs, reference)
    problem = inputs, reference, steps.table, velocity, acceleration, n_neighbors
    if n_reference < _LONG or n_input * steps.n_pairs < _MANY:
        _kernels.joint_scores(*problem, scale, n_threads(), each, out)
        return out
    parts = reference.reshape(-1, n_numbers)
    directions = _directions(reference, n_numbers) * scale
    low_inputs, low_reference = _products(inputs, directions), _products(parts, directions)
    low_reference = low_reference.reshape(n_reference, -1)
    order = _neighborhoods(low_reference.astype(np.float32))
    place = np.empty(n_reference + 1, dtype=np.int32)
    place[order], place[n_reference] = np.arange(n_reference), -1
    _kernels.bounded_scores(
        *problem, low_inputs, low_reference[order], scale, order, place[order + 1], n_threads(), each, out
    )
    return out


def _scale(inputs: FloatArray, reference: FloatArray) -> float:
    """Return the factor that brings all numbers into [-1, 1]: in single precision, nothing overflows."""
    size = max(_size(reference), _size(inputs))
    return 1.0 / size if size > 1e-300 else 1.0


def _size(numbers: FloatArray) -> float:
    """Return the largest absolute value; without an array for them all."""
    return max(float(numbers.max()), -float(numbers.min()))


def _directions(reference: FloatArray, n_numbers: int) -> FloatArray:
    """Return few orthogonal directions (d, depth) that hold nearly all variance of poses and their differences."""
    # Of long references every so many rows, and of each all its parts.
    some = reference[:: max(1, len(reference) // _TELLING)].reshape(-1, n_numbers)
    variances, directions = np.linalg.eigh(_products(some.T, some))
    left = np.cumsum(np.maximum(variances, 0))
    return np.ascontiguousarray(directions[:, left >= _LOST_VARIANCE * left[-1]])


def _products(rows: FloatArray, columns: FloatArray) -> FloatArray:
    """Multiply matrices (n, d) and (d, m), a small piece after the other: in this thread alone.

    Threads of a linear algebra library wait for each other actively. Where others use the machine too, that costs many
    times what the products do.
    """
    n, depth = rows.shape
    products = np.zeros((n, columns.shape[1]))
    if n <= depth:
        every = max(1, _SMALL // max(1, n * columns.shape[1]))
        for start in range(0, depth, every):
            products += rows[:, start : start + every] @ columns[start : start + every]
        return products
    every = max(1, _SMALL // max(1, columns.size))
    for start in range(0, n, every):
        np.matmul(rows[start : start + every], columns, out=products[start : start + every])
    return products


def _neighborhoods(rows: NDArray[np.float32]) -> IntArray:
    """Order rows so that each block of 64, from the first on, holds rows near one another."""
    order = np.arange(len(rows))
    parts = [(0, len(rows))]
    while parts:
        start, stop = parts.pop()
        n_blocks = -(-(stop - start) // _BLOCK)
        if n_blocks < 2:
            continue
        here = order[start:stop]
        some = rows[here]
        # Across two of them that are far apart.
        few = some[:: max(1, len(some) // 256)]
        one = few[np.argmax(np.square(few - few[0]).sum(axis=1))]
        other = few[np.argmax(np.square(few - one).sum(axis=1))]
        middle = n_blocks // 2 * _BLOCK
        order[start:stop] = here[np.argpartition(np.einsum("rd,d->r", some, other - one), middle)]
        parts += [(start, start + middle), (start + middle, stop)]
    return order


def nearest_poses(inputs: FloatArray, poses: FloatArray, n_neighbors: int) -> IntArray:
    """Find the poses nearest to each input frame; see `retime.kernels.Backend`."""
    # Products lose fewer digits near the poses' middle; to move there takes a rounding of every number.
    origin = poses.mean(axis=0)
    largest = max(_size(inputs), _size(poses))
    # The origin lies among the poses: no number is farther from it than twice the largest.
    scale = 0.5 / largest if largest > 1e-300 else 1.0
    blur = 2.0**-50 * math.sqrt(inputs.shape[1]) * largest * scale
    out = np.empty((len(inputs), n_neighbors), dtype=np.int64)
    _kernels.nearest_poses(inputs, poses, n_neighbors, origin, scale, blur, n_threads(), out)
    return out


def conditional_scores(
    inputs: FloatArray, reference: FloatArray, nearest: IntArray, steps: StepPairs, velocity: float, acceleration: float
) -> FloatArray:
    """Score triples; see `retime.kernels.Backend`."""
    out = np.full((len(inputs), steps.n_pairs), np.inf)
    n_neighbors = nearest.shape[1]
    _kernels.conditional_scores(
        inputs, reference, steps.table, velocity, acceleration, n_neighbors, nearest, n_threads(), out
    )
    return out


def layered_path(problem: PathProblem, memory_limit: int) -> tuple[IntArray, float] | None:
    """Find the best path; see `retime.kernels.Backend`."""
    return _kernels.layered_path(
        problem.scores,
        problem.steps.table,
        problem.positions,
        problem.frames,
        problem.last_position_max,
        problem.start_cost,
        problem.end_cost,
        _ANY if problem.band is None else problem.band,
        memory_limit,
    )


def aligned_path(
    problem: PathProblem,
    inputs: FloatArray,
    reference: FloatArray,
    velocity: float,
    acceleration: float,
    memory_limit: int,
) -> tuple[IntArray, float] | None:
    """Find the path that keeps step with a reference; see `retime.kernels.Backend`."""
    return _kernels.aligned_path(
        inputs,
        reference,
        problem.steps.table,
        velocity,
        acceleration,
        problem.scores,
        problem.positions,
        problem.frames,
        problem.start_cost,
        problem.end_cost,
        n_threads(),
        memory_limit,
        _ALIGNED_COSTS,
    )


def free_path(problem: PathProblem) -> tuple[IntArray, float] | None:
    """Find the best path of any length; see `retime.kernels.Backend`."""
    return _kernels.free_path(
        problem.scores, problem.steps.table, problem.positions, problem.frames, problem.start_cost, problem.end_cost
    )


def priced_path(problem: PathProblem, max_bytes: int) -> PricedPath:
    """Find the best path by a price on the count; see `retime.kernels.Backend`."""
    return PricedPath(
        *_kernels.priced_path(
            problem.scores,
            problem.steps.table,
            problem.positions,
            problem.frames,
            problem.last_position_max,
            problem.start_cost,
            problem.end_cost,
            max_bytes,
        )
    )


def read_rows(text: bytes, rows: RowFormat) -> FloatArray | None:
    """Read rows of numbers; see `retime.kernels.Backend`."""
    # A number takes a digit and what parts it from the next. Pages that nothing is written to cost nothing.
    threads = n_threads()
    numbers = np.empty(len(text) // 2 + threads + 1)
    told = rows.n_columns, rows.delimiter or "\0", rows.decimal_comma, rows.largest, rows.line_bytes
    n_rows, n_columns, n_bytes = _kernels.read_rows(text, *told, threads, numbers)
    if n_rows == 0 or n_bytes < len(text):
        return None
    return numbers[: n_rows * n_columns].reshape(n_rows, n_columns).copy()


def write_rows(rows: FloatArray) -> bytes:
    """Write rows of numbers; see `retime.kernels.Backend`."""
    return _kernels.write_rows(rows)


def three_turns(order: str, angles: FloatArray) -> FloatArray:
    """Multiply turns about three axes; see `retime.kernels.Backend`."""
    quaternions = np.empty((len(angles), 4))
    _kernels.three_turns(angles, *turn_axes(order), quaternions)
    return quaternions


def turn_joints(rows: FloatArray, turned: TurnedJoints, angles: FloatArray, rotations: FloatArray) -> None:
    """Turn joints by their channels; see `retime.kernels.Backend`."""
    told = turned.joints, turned.columns, *turn_axes(turned.order), turned.many
    _kernels.turn_joints(rows, *told, n_threads(), angles, rotations)


def read_joint_rows(
    text: bytes, start: int, piece_bytes: int, rows: RowFormat, channels: JointChannels, into: JointArrays
) -> tuple[int, int]:
    """Read rows of channels into joints; see `retime.kernels.Backend`."""
    turned = [(each.joints, each.columns, *turn_axes(each.order)) for each in channels.turned]
    many = max((each.many for each in channels.turned), default=0.0)
    told = rows.n_columns, rows.decimal_comma, rows.largest, rows.line_bytes
    placed = channels.columns, channels.places, channels.offsets
    arrays = into.angles, into.rotations, into.translations
    return _kernels.read_joint_rows(text, start, piece_bytes, *told, turned, many, *placed, n_threads(), *arrays)


def pose_joints(
    joints: PosedJoints, rotations: FloatArray, translations: FloatArray, out: tuple[FloatArray, ...]
) -> None:
    """Place joints in space; see `retime.kernels.Backend`."""
    told = joints.parents, joints.site_parents, joints.site_offsets, joints.turn
    positions, global_rotations, end_positions = out
    _kernels.pose_joints(*told, rotations, translations, n_threads(), positions, global_rotations, end_positions)


def average_turns(turns: AveragedTurns, rotations: FloatArray, sampled: FloatArray) -> None:
    """Turn joints as averaged poses have them; see `retime.kernels.Backend`."""
    told = turns.parents, turns.groups, turns.widths, turns.own, turns.halves, turns.centres
    _kernels.average_turns(*told, turns.closed, turns.shortest**2, rotations, n_threads(), sampled)


def extent(numbers: FloatArray) -> tuple[float, float]:
    """Find the least and the greatest number; see `retime.kernels.Backend`."""
    return _kernels.extent(numbers, n_threads())


def squared_lengths(quaternions: FloatArray) -> tuple[float, float]:
    """Find the least and the greatest squared length; see `retime.kernels.Backend`."""
    return _kernels.squared_lengths(quaternions, n_threads())
