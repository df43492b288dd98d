"""The compiled kernels, with the matrix products that feed them.

A call works through the input in blocks of frames, so that the products stay within a fixed memory however long the
reference is.
"""

from __future__ import annotations

import os

import numpy as np

from retime.kernels import FloatArray, IntArray, PathProblem, PricedPath, _kernels

_BLOCK_BYTES = 96 << 20
# kProductsPadding in scores.hpp.
_PADDING = 64


def n_threads() -> int:
    """Threads to use: RETIME_THREADS, else as many as this process may run on."""
    wanted = os.environ.get("RETIME_THREADS", "")
    if wanted.isascii() and wanted.isdigit() and int(wanted) > 0:
        return int(wanted)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


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
    n_input, n_numbers = inputs.shape
    n_reference = len(reference)
    out = np.full((n_input, max_skip, max_skip, *([n_neighbors] if each else [])), np.inf)
    # |ŷ - ẑ|² / 2 = |ŷ|² / 2 + here - after - before, where each term is linear in one input frame.
    z, dz, ddz = (reference[:, part * n_numbers : (part + 1) * n_numbers] for part in range(3))
    weights = (
        z - 2 * acceleration * ddz,
        velocity * dz + acceleration * ddz,
        acceleration * ddz - velocity * dz,
    )
    # In single precision only ratios matter: scaled to about 1, nothing overflows.
    size = max(float(np.abs(reference).max()), float(np.abs(inputs).max()), 1e-300)
    y = (inputs / size).astype(np.float32)
    padded = -(-n_reference // _PADDING) * _PADDING
    together = np.zeros((3, padded, n_numbers), dtype=np.float32)
    together[:, :n_reference] = np.stack(weights) / size
    by_columns = together.reshape(3 * padded, n_numbers).T
    half_squares = 0.5 * np.sum((reference / size) ** 2, axis=1)
    # Rounding of operands, products and sums of n terms: at most (n + 4) units of |y| |z|, by Cauchy and Schwarz.
    unit = (n_numbers + 8) * 2.0**-24 * 1.01
    lengths = np.sqrt(np.sum((inputs / size) ** 2, axis=1))
    longest = [float(np.sqrt(np.sum((weight / size) ** 2, axis=1)).max()) for weight in weights]
    slack = unit * lengths[:, None] * np.array(longest)
    reference_slack = unit * float(half_squares.max()) + 1e-30
    threads = n_threads()
    rows = max(2 * max_skip + 1, _BLOCK_BYTES // (12 * padded) - 2 * max_skip)
    for begin in range(0, n_input, rows):
        end = min(begin + rows, n_input)
        first, last = max(0, begin - max_skip), min(n_input, end + max_skip)
        products = y[first:last] @ by_columns
        here = products[:, :n_reference]
        np.subtract(half_squares.astype(np.float32), here, out=here)
        _kernels.joint_scores(
            inputs, reference, max_skip, velocity, acceleration, n_neighbors,
            products, np.ascontiguousarray(slack[first:last]), reference_slack,
            first, begin, end, threads, each, out,
        )  # fmt: skip
    return out


def nearest_poses(inputs: FloatArray, poses: FloatArray, n_neighbors: int) -> IntArray:
    """Find the poses nearest to each input frame; see `retime.kernels.Backend`."""
    n_input, n_numbers = inputs.shape
    n_reference = len(poses)
    padded = -(-n_reference // _PADDING) * _PADDING
    size = max(float(np.abs(poses).max()), float(np.abs(inputs).max()), 1e-300)
    half_squares = np.zeros(padded)
    half_squares[:n_reference] = 0.5 * np.sum((poses / size) ** 2, axis=1)
    by_columns = np.zeros((padded, n_numbers), dtype=np.float32)
    by_columns[:n_reference] = poses / size
    unit = (n_numbers + 8) * 2.0**-24 * 1.01
    longest = float(np.sqrt(2 * half_squares.max()))
    slack = unit * (np.sqrt(np.sum((inputs / size) ** 2, axis=1)) * longest + float(half_squares.max())) + 1e-30
    out = np.empty((n_input, n_neighbors), dtype=np.int64)
    rows = max(1, _BLOCK_BYTES // (4 * padded))
    for begin in range(0, n_input, rows):
        part = slice(begin, min(begin + rows, n_input))
        products = (inputs[part] / size).astype(np.float32) @ by_columns.T
        np.subtract(half_squares.astype(np.float32), products, out=products)
        _kernels.nearest_poses(inputs[part], poses, n_neighbors, products, slack[part], out[part])
    return out


def conditional_scores(
    inputs: FloatArray, reference: FloatArray, nearest: IntArray, max_skip: int, velocity: float, acceleration: float
) -> FloatArray:
    """Score triples; see `retime.kernels.Backend`."""
    out = np.full((len(inputs), max_skip, max_skip), np.inf)
    n_neighbors = nearest.shape[1]
    _kernels.conditional_scores(
        inputs, reference, max_skip, velocity, acceleration, n_neighbors, nearest, n_threads(), out
    )
    return out


def layered_path(problem: PathProblem, memory_limit: int) -> tuple[IntArray, float] | None:
    """Find the best path; see `retime.kernels.Backend`."""
    return _kernels.layered_path(
        problem.scores,
        problem.positions,
        problem.frames,
        problem.last_position_max,
        problem.start_cost,
        problem.end_cost,
        memory_limit,
    )


def free_path(problem: PathProblem) -> tuple[IntArray, float] | None:
    """Find the best path of any length; see `retime.kernels.Backend`."""
    return _kernels.free_path(problem.scores, problem.positions, problem.frames, problem.start_cost, problem.end_cost)


def priced_path(problem: PathProblem, max_bytes: int) -> PricedPath:
    """Find the best path by a price on the count; see `retime.kernels.Backend`."""
    return PricedPath(
        *_kernels.priced_path(
            problem.scores,
            problem.positions,
            problem.frames,
            problem.last_position_max,
            problem.start_cost,
            problem.end_cost,
            max_bytes,
        )
    )
