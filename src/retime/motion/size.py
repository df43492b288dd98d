"""The largest number that a motion, or a signal, may hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import FloatArray
from retime.kernels import backend

LARGEST = 1e100
"""Distances are squared and added up: what is larger than this would overflow there, far from where it came in."""


def within_size(values: ArrayLike, largest: float = LARGEST) -> np.ndarray:
    """Tell which numbers are finite and no larger than `largest`, of either sign.

    Examples
    --------
    >>> within_size([1.0, -1e300, float("nan")]).tolist()
    [True, False, False]
    """
    return np.asarray(np.abs(values) <= largest)


def extent(values: FloatArray) -> tuple[float, float]:
    """Return the least and the greatest number; both are NaN where one is not finite.

    Examples
    --------
    >>> extent(np.array([3.0, -1.0])), extent(np.array([3.0, np.inf]))
    ((-1.0, 3.0), (nan, nan))
    """
    if values.flags.c_contiguous:
        return backend(warn=False).extent(values)
    # Often one row for all frames, seen as many: no copy is made of it.
    least, greatest = float(values.min()), float(values.max())
    return (least, greatest) if np.isfinite([least, greatest]).all() else (np.nan, np.nan)


def size_problem(value: object) -> str:
    """Say what is wrong with a number, or numbers, that are not within size."""
    if np.all(np.isfinite(np.asarray(value, dtype=np.float64))):
        return f"is larger than {LARGEST:g}, the limit: {value}"
    return f"is not finite: {value}"
