"""Knots: the times at which a warp may change its speed."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray

# Seconds. Two knots closer than this are one: the slope between them would be made of rounding errors.
_SAME_TIME = 1e-9


def add_times(times: FloatArray, more: FloatArray) -> FloatArray:
    """Add times to increasing ones, except where one within a billionth of a second is there already."""
    more = np.unique(more)
    place = np.searchsorted(times, more)
    earlier, later = times[np.maximum(place - 1, 0)], times[np.minimum(place, len(times) - 1)]
    more = more[np.minimum(np.abs(more - earlier), np.abs(later - more)) > _SAME_TIME]
    return np.union1d(times, more[np.diff(more, prepend=-np.inf) > _SAME_TIME])
