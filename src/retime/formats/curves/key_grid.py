"""The frames on which a scene's keys lie, where the file declares no rate."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from retime.arrays import FloatArray

# Frames a second that keys are made at, tried in this order, and what is taken where keys lie on no such grid.
_RATES = (24, 25, 30, 48, 50, 60, 90, 100, 120, 240)
_NO_GRID = Fraction(60)


def grid_rate(times: list[FloatArray], start: float) -> Fraction:
    """Find the frame rate on whose frames all keys lie, to single precision; 60 where there is none."""
    keys = np.unique(np.concatenate(times)) - start
    for rate in _RATES:
        places = keys * rate
        if np.abs(places - np.rint(places)).max() < 2e-3:
            return Fraction(rate)
    return _NO_GRID
