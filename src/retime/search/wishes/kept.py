"""What of a path must stay as the search left it, when the path is put on its keytimes and smoothed."""

from __future__ import annotations

import math

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.search.reduction import Reduction


def speed_bounds(
    reduction: Reduction,
    path: IntArray,
    max_skip: int,
    *,
    slowest: float = 0.0,
    fastest: float = math.inf,
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
    slowest, fastest : float
        Limits for the whole clip.

    Returns
    -------
    low, high : float arrays, shape (n_output - 1,)
        Speeds without the sign of a backward span: from 1 / upsample to max_skip / upsample, and inside the limits.
        Held steps have none: 0 and infinity.
    """
    before = path[:-1]
    upsample_at = reduction.upsample_at[before].astype(np.float64)
    low, high = np.maximum(1 / upsample_at, slowest), np.minimum(max_skip / upsample_at, fastest)
    held = reduction.held[before]
    low[held], high[held] = 0.0, np.inf
    return low, high
