"""Fewer knots for a warp, within a stated error: what is written to host programs and curve files stays small."""

from __future__ import annotations

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray


def simplified(output_times: FloatArray, input_times: FloatArray, tolerance: float, keep: FloatArray) -> IntArray:
    """Choose the knots that carry a polyline to within a tolerance.

    From each chosen knot a straight line is drawn as far as it passes all knots between within the tolerance: the
    slopes that do so form an interval, which every further knot narrows, so one pass decides. A line that holds, or
    runs another way than the knots that it stands for, is no substitute for them: where a warp begins or ends to hold,
    or turns, its knots stay.

    Parameters
    ----------
    output_times, input_times : float arrays, shape (n_knots,)
        The polyline, in seconds; output times increase.
    tolerance : float
        The largest error in input time, seconds; at 0 only knots on a straight line go.
    keep : float array
        Output times whose knots stay.

    Returns
    -------
    int array
        The chosen knots, increasing; the first and the last are among them.
    """
    n = len(output_times)
    fixed = _fixed(output_times, input_times, keep)
    chosen = [0]
    start = 0
    while start < n - 1:
        start = _reach(output_times, input_times, tolerance, fixed, start)
        chosen.append(start)
    return np.array(chosen, dtype=np.int64)


def _fixed(output_times: FloatArray, input_times: FloatArray, keep: FloatArray) -> BoolArray:
    """Mark the knots that must stay: the ends, those asked for, and where the warp turns or begins or ends to hold."""
    way = np.sign(np.diff(input_times))
    fixed = np.ones(len(output_times), dtype=bool)
    fixed[1:-1] = (way[1:] != way[:-1]) | np.isin(output_times[1:-1], keep)
    return fixed


def _reach(t: FloatArray, w: FloatArray, tolerance: float, fixed: BoolArray, start: int) -> int:
    """Find the farthest knot that a straight line from `start` reaches within the tolerance."""
    least, most = -np.inf, np.inf
    reached = start + 1
    for knot in range(start + 1, len(t)):
        width = t[knot] - t[start]
        slope = (w[knot] - w[start]) / width
        if least <= slope <= most:
            reached = knot
        # Rounding must not part knots of one straight line.
        slack = tolerance + 4e-16 * (abs(w[knot]) + abs(w[start]))
        least, most = max(least, slope - slack / width), min(most, slope + slack / width)
        if fixed[knot] or least > most:
            break
    return reached
