"""The mean of a warp over a moving window that keeps its ends and keytimes (§3.4)."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray
from retime.warp.knots import add_times


def smoothed(
    output_times: FloatArray,
    input_times: FloatArray,
    window: float,
    *,
    at: FloatArray,
    keep: FloatArray,
    keep_ends: bool,
) -> tuple[FloatArray, FloatArray]:
    """Average a warp over a window around each time.

    Beyond its ends the warp is continued by point reflection, so the ends stay; near a time that is kept the window
    shrinks, so that time stays. A window that grows or shrinks no faster than time passes keeps a monotone warp
    monotone: between neighbouring times it gains only later values, or loses only earlier ones.

    Parameters
    ----------
    output_times, input_times : float arrays, shape (n_knots,)
        The warp.
    window : float
        Full width in seconds of output time.
    at, keep : float arrays
        Output times of the new knots, and those at which the warp stays as it is; in any order.
    keep_ends : bool
        Keep the first and the last piece too.

    Returns
    -------
    (float array, float array), each of shape (n_new_knots,)
        Output times and input times.
    """
    start, end = output_times[0], output_times[-1]
    kept = np.concatenate([keep, output_times[[0, 1, -2, -1]]]) if keep_ends else keep
    inner = np.unique(kept[(kept > start) & (kept < end)])
    times = add_times(np.concatenate([[start], inner, [end]]), at[(at > start) & (at < end)])
    half = np.full(len(times), min(window, float(end - start)) / 2)
    fixed = np.concatenate([[start], inner, [end]]) if keep_ends else inner
    if len(fixed):
        later = np.clip(np.searchsorted(fixed, times), 0, len(fixed) - 1)
        earlier = np.maximum(later - 1, 0)
        half = np.minimum(half, np.minimum(np.abs(times - fixed[later]), np.abs(times - fixed[earlier])))
    values = np.interp(times, output_times, input_times)
    wide = (half > 0) & (times > start) & (times < end)
    values[wide] = _mean_around(output_times, input_times, times[wide], half[wide])
    return times, values


def _mean_around(t: FloatArray, w: FloatArray, times: FloatArray, half: FloatArray) -> FloatArray:
    """Average over [t - half, t + half], piece by piece: sums stay local, so hours of warp lose no digits."""
    t = np.concatenate([2 * t[0] - t[:0:-1], t, 2 * t[-1] - t[-2::-1]])
    w = np.concatenate([2 * w[0] - w[:0:-1], w, 2 * w[-1] - w[-2::-1]])
    low, high = times - half, times + half
    piece = np.searchsorted(t, low, side="right") - 1
    last = np.searchsorted(t, high, side="left") - 1
    centre = np.interp(times, t, w)
    # Reflected about an end, the shortest pieces may be rounded to a length of 0.
    width = np.diff(t)
    slopes = np.diff(w) / np.where(width > 0, width, np.inf)
    area = np.zeros(len(times))
    live = np.flatnonzero(piece <= last)
    while len(live):
        here = piece[live]
        begin = t[here]
        a, b = np.maximum(low[live], begin), np.minimum(high[live], t[here + 1])
        middle = w[here] + slopes[here] * ((a + b) / 2 - begin) - centre[live]
        area[live] += (b - a) * middle
        piece[live] += 1
        live = live[piece[live] <= last[live]]
    return np.asarray(centre + area / (2 * half))
