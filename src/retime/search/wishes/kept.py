"""What of a path must stay as the search left it, when the path is put on its keytimes and smoothed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.search.reduction import Reduction
from retime.search.wishes.locks import LockedSpan
from retime.search.wishes.steps import steps_between


def kept_speeds(
    reduction: Reduction,
    path: IntArray,
    *,
    locked: Sequence[LockedSpan] = (),
    slowest: float = 0.0,
    fastest: float = math.inf,
    loop: bool = False,
) -> FloatArray:
    """Say which steps of a path must keep their speed when it is put on its keytimes, and what speed that is.

    Steps inside a lock at a fixed speed and beside a tangent get that speed. Those at the end of a range stay as they
    are, and so do the first and the last of a loop.

    Parameters
    ----------
    reduction : Reduction
        Not free.
    path : int array, shape (n_output,)
        Unrolled frames.
    locked, slowest, fastest
        As in `allowed_steps`.
    loop : bool
        First and last speed agree.

    Returns
    -------
    float array, shape (n_output - 1,)
        Speeds without the sign of a backward span; nan for steps that may give.
    """
    before, after = path[:-1], path[1:]
    steps = after - before
    speeds = np.full(len(steps), np.nan)
    upsample_at = reduction.upsample_at[before]
    bound = np.zeros(len(steps), dtype=bool)
    for upsample in set(reduction.upsamples):
        limits = steps_between(slowest, fastest, upsample)
        at_limit = ((steps == limits[0]) & (slowest > 0)) | ((steps == limits[-1]) & (fastest < math.inf))
        bound |= (upsample_at == upsample) & at_limit
    if loop:
        bound[[0, -1]] = True
    for span in locked:
        inside = (before >= span.first) & (after <= span.last)
        bound |= inside & ((steps == span.steps[0]) | (steps == span.steps[-1]))
    speeds[bound] = steps[bound] / upsample_at[bound]
    for span in locked:
        if span.speed is not None:
            speeds[(before >= span.first) & (after <= span.last)] = span.speed
    for key, frame in zip(reduction.keytimes, reduction.frames, strict=True):
        if key.speed is not None:
            speeds[(before == frame) | (after == frame)] = abs(key.speed)
    speeds[reduction.held[before]] = np.nan
    return speeds


def speed_bounds(
    reduction: Reduction,
    path: IntArray,
    max_skip: int,
    *,
    locked: Sequence[LockedSpan] = (),
    slowest: float = 0.0,
    fastest: float = math.inf,
    loop: bool = False,
) -> tuple[FloatArray, FloatArray]:
    """Say how slowly and how fast each step of a path may play when it is put on its keytimes.

    Parameters
    ----------
    reduction : Reduction
        Not free.
    path : int array, shape (n_output,)
        Unrolled frames.
    max_skip : int
        Largest step.
    locked, slowest, fastest
        As in `allowed_steps`.
    loop : bool
        First and last speed agree.

    Returns
    -------
    low, high : float arrays, shape (n_output - 1,)
        Speeds without the sign of a backward span: from 1 / upsample to max_skip / upsample, and inside the limits and
        the ranges of locks. Both are the speed itself where that is fixed: by a lock, by a tangent, at a loop's ends.
        Held steps have none: 0 and infinity.
    """
    before, after = path[:-1], path[1:]
    upsample_at = reduction.upsample_at[before].astype(np.float64)
    low, high = np.maximum(1 / upsample_at, slowest), np.minimum(max_skip / upsample_at, fastest)
    for span in locked:
        inside = (before >= span.first) & (after <= span.last)
        low[inside] = np.maximum(low, span.steps[0] / upsample_at)[inside]
        high[inside] = np.minimum(high, span.steps[-1] / upsample_at)[inside]
        if span.speed is not None:
            low[inside] = high[inside] = span.speed
    if loop:
        low[[0, -1]] = high[[0, -1]] = ((after - before) / upsample_at)[[0, -1]]
    for key, frame in zip(reduction.keytimes, reduction.frames, strict=True):
        if key.speed is not None:
            beside = (before == frame) | (after == frame)
            low[beside] = high[beside] = abs(key.speed)
    held = reduction.held[before]
    low[held], high[held] = 0.0, np.inf
    return low, high


def kept_positions(reduction: Reduction, path: IntArray, locked: Sequence[LockedSpan]) -> IntArray:
    """List the places in a path between which it must stay straight: ends of locks, neighbours of tangents."""
    kept = np.isin(path, [frame for span in locked for frame in (span.first, span.last)])
    for key, position in zip(reduction.keytimes, reduction.positions, strict=True):
        if key.speed is not None:
            kept[max(position - 1, 0) : position + 2] = True
    return np.flatnonzero(kept)
