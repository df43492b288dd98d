"""Rounded spans of other programs' curves, drawn by lines to within a stated error."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError
from retime.hosts.shot import Place

_MOST_PIECES = 1 << 15
# Between two points of the drawing the error is measured at these parts of the way.
_BETWEEN = np.array([0.25, 0.5, 0.75])


def drawn(x: FloatArray, y: FloatArray, tolerance: float, place: Place) -> tuple[FloatArray, FloatArray]:
    """Draw a cubic Bezier curve by lines.

    Parameters
    ----------
    x, y : float arrays, shape (4,)
        Control points: output times and input times, seconds.
    tolerance : float
        The largest error of y, seconds, above 0.
    place : dict
        Where the span begins, for messages.

    Returns
    -------
    float arrays, shape (n,)
        The points after the first; the last is the curve's end.

    Raises
    ------
    FormatError
        The curve turns back in time, or is too steep to be drawn so finely.
    """
    if not (x[0] <= x[1] <= x[3] and x[0] <= x[2] <= x[3]):
        raise FormatError(
            "a handle reaches beyond the keys beside it, so that time would turn back; shorten it", **place
        )
    if not tolerance > 0:
        raise FormatError(
            "this span is a curve, which lines can't follow exactly: allow an error (--tolerance)", **place
        )
    pieces = 4
    while pieces <= _MOST_PIECES:
        ends = np.linspace(0.0, 1.0, pieces + 1)
        inner = (ends[:-1, None] + _BETWEEN / pieces).ravel()
        xs, ys = _at(x, ends), _at(y, ends)
        if np.abs(_at(y, inner) - np.interp(_at(x, inner), xs, ys)).max() <= tolerance:
            return xs[1:], ys[1:]
        pieces *= 2
    raise FormatError(f"this span is too steep to be drawn by lines to within {tolerance:g} s (--tolerance)", **place)


def _at(points: FloatArray, u: FloatArray) -> FloatArray:
    """Return a coordinate of the curve; its ends exactly."""
    v = 1 - u
    weights = np.stack([v**3, 3 * v**2 * u, 3 * v * u**2, u**3])
    return np.asarray(points @ weights)
