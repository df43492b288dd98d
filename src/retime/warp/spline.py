"""The baselines: what an animator has today (§4.1)."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from retime.arrays import FloatArray
from retime.errors import InfeasibleWarpError, OptionError, RetimeWarning
from retime.limits import MOST_FRAMES
from retime.motion.rate import parse_rate
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime, KeytimeLike, check_speed, keytimes_of
from retime.warp.knots import add_times


def linear_warp(keytimes: Sequence[KeytimeLike]) -> Warp:
    """Join keytimes by straight lines: constant speed in each span.

    Parameters
    ----------
    keytimes : sequence of Keytime, or of (input time, output time)
        At least two; seconds.

    Raises
    ------
    InfeasibleWarpError
        Fewer than two keytimes, or two at one output time.
    OptionError
        Something that is no keytime.

    Examples
    --------
    >>> linear_warp([(0.0, 0.0), (3.0, 2.0)]).slopes.tolist()
    [1.5]
    """
    ordered = _ordered(keytimes)
    return Warp(
        np.array([key.output_time for key in ordered]),
        np.array([key.input_time for key in ordered]),
        ordered,
        method="linear",
    )


def spline_warp(keytimes: Sequence[KeytimeLike], *, rate: str | float | Fraction = 120.0) -> Warp:
    """Join keytimes by a cubic that is smooth and never turns back between them (Fritsch and Carlson 1980).

    Slopes at the keytimes are PCHIP's, or the tangents where there are any. A slope beyond three times the mean speed
    of a span beside it would turn the cubic back inside: a tangent is limited to that.

    Parameters
    ----------
    keytimes : sequence of Keytime, or of (input time, output time) or (input time, output time, speed)
        At least two; seconds. With only two and no tangent, the spline is the straight line.
    rate : number or str
        Knots a second of output.

    Raises
    ------
    InfeasibleWarpError
        Fewer than two keytimes, or two at one output time.
    OptionError
        Something that is no keytime, or no rate; more knots than a clip can have frames (`retime.limits.MOST_FRAMES`).

    Warns
    -----
    RetimeWarning
        A tangent had to be limited.

    Examples
    --------
    >>> warp = spline_warp([(0.0, 0.0), (1.0, 1.0, 2.0), (3.0, 2.0)], rate=1000)
    >>> warp.speed([0.9999, 1.0]).round(2).tolist()
    [2.0, 2.0]
    """
    ordered = _ordered(keytimes)
    output_times = np.array([key.output_time for key in ordered])
    input_times = np.array([key.input_time for key in ordered])
    start, end = output_times[0], output_times[-1]
    per_second = float(parse_rate(rate))
    if not (end - start) * per_second < MOST_FRAMES:
        raise OptionError(
            f"a spline over {end - start:g} s of output has {(end - start) * per_second:.3g} knots at {per_second:g} a "
            f"second; {MOST_FRAMES} is the most. Ask for a shorter output"
        )
    n_knots = max(2, round((end - start) * per_second) + 1)
    times = add_times(output_times, np.linspace(start, end, n_knots))
    begin, end_slopes = _with_tangents(ordered, pchip_slopes(output_times, input_times))
    # The page works this out as it is done here, in web/src/spline.ts.
    values = _cubics(output_times, input_times, begin, end_slopes, times)
    values[np.searchsorted(times, output_times)] = input_times
    return Warp(times, values, ordered, method="spline")


def span_slopes(keytimes: Sequence[KeytimeLike]) -> tuple[FloatArray, FloatArray]:
    """Return what `spline_warp` needs besides the keytimes: the slopes with which each span begins and ends.

    Parameters
    ----------
    keytimes : sequence of Keytime, or of (input time, output time) or (input time, output time, speed)
        At least two; seconds.

    Returns
    -------
    (float array, float array), each of shape (n_keytimes - 1,)

    Examples
    --------
    >>> begin, end = span_slopes([(0.0, 0.0), (1.0, 1.0, 2.0), (3.0, 2.0)])
    >>> begin.round(3).tolist(), end.round(3).tolist()
    ([0.5, 2.0], [2.0, 2.5])
    """
    ordered = _ordered(keytimes)
    output_times = np.array([key.output_time for key in ordered])
    input_times = np.array([key.input_time for key in ordered])
    return _with_tangents(ordered, pchip_slopes(output_times, input_times))


def pchip_slopes(output_times: FloatArray, input_times: FloatArray) -> FloatArray:
    """Choose slopes with which cubics through points turn back nowhere but at a point (Fritsch and Butland 1984).

    Inside, a weighted harmonic mean of the mean speeds on either side, or 0 where those differ in sign; at each end,
    the slope there of the parabola through the three nearest points, limited.

    Parameters
    ----------
    output_times : float array, shape (n,)
        Increasing; at least two.
    input_times : float array, shape (n,)
        Any.

    Returns
    -------
    float array, shape (n,)

    Examples
    --------
    >>> pchip_slopes(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 3.0])).round(3).tolist()
    [0.5, 1.333, 2.5]
    """
    widths = np.diff(output_times)
    means = np.diff(input_times) / widths
    if len(means) == 1:
        return np.repeat(means, 2)
    before, after = 2 * widths[1:] + widths[:-1], widths[1:] + 2 * widths[:-1]
    slopes = np.zeros(len(output_times))
    inner = np.sign(means[:-1]) * np.sign(means[1:]) > 0
    # Beside a mean speed too small to divide by, the slope is 0: one over infinity.
    with np.errstate(over="ignore"):
        harmonic = (before[inner] / means[:-1][inner] + after[inner] / means[1:][inner]) / (before + after)[inner]
    slopes[1:-1][inner] = 1 / harmonic
    slopes[0] = _end_slope(widths[0], widths[1], means[0], means[1])
    slopes[-1] = _end_slope(widths[-1], widths[-2], means[-1], means[-2])
    return slopes


def _end_slope(width: float, next_width: float, mean: float, next_mean: float) -> float:
    """Choose the slope at an end from the mean speeds of the two spans next to it."""
    slope = ((2 * width + next_width) * mean - width * next_mean) / (width + next_width)
    if np.sign(slope) != np.sign(mean):
        return 0.0
    if np.sign(mean) != np.sign(next_mean) and abs(slope) > 3 * abs(mean):
        return 3 * mean
    return slope


def _with_tangents(keytimes: Sequence[Keytime], slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Put tangents into the slopes at keytimes; return the slopes with which each span begins and ends."""
    means = np.array(
        [(b.input_time - a.input_time) / (b.output_time - a.output_time) for a, b in itertools.pairwise(keytimes)]
    )
    begin, end = slopes[:-1].copy(), slopes[1:].copy()
    for i, key in enumerate(keytimes):
        # A hold stays at rest. Where the direction turns, each side has the speed in its own direction, as in the
        # guided warp: a corner, for no smooth curve does that.
        sides = [span for span in (i - 1, i) if 0 <= span < len(means) and means[span] != 0]
        if key.speed is None or not sides:
            continue
        most = 3 * min(abs(float(means[span])) for span in sides)
        if key.speed > most * (1 + 1e-9):
            warnings.warn(
                f"the spline can't pass output time {key.output_time:g} s at speed {key.speed:g} without turning "
                f"back; it passes at {most:g}, three times the slower mean speed beside it",
                RetimeWarning,
                stacklevel=3,
            )
        for span in sides:
            (begin if span == i else end)[span] = math.copysign(min(key.speed, most), means[span])
    return begin, end


def _cubics(
    output_times: FloatArray, input_times: FloatArray, begin: FloatArray, end: FloatArray, times: FloatArray
) -> FloatArray:
    """Evaluate cubics through the keytimes that begin and end each span with the given slopes."""
    span = np.clip(np.searchsorted(output_times, times, side="right") - 1, 0, len(output_times) - 2)
    widths = np.diff(output_times)
    means = np.diff(input_times) / widths
    excess = (begin + end - 2 * means) / widths
    cubic, square = (excess / widths)[span], ((means - begin) / widths - excess)[span]
    t = times - output_times[span]
    # In this order the bits are those of scipy's PchipInterpolator, by which versions before were made.
    return np.asarray(input_times[span] + begin[span] * t + square * (t * t) + cubic * (t * t * t))


def _ordered(keytimes: Sequence[KeytimeLike]) -> tuple[Keytime, ...]:
    ordered = tuple(sorted(keytimes_of(keytimes)))
    if len(ordered) < 2:
        raise InfeasibleWarpError("a warp needs at least two keytimes, its ends")
    for key in ordered:
        check_speed(key)
    for before, after in itertools.pairwise(ordered):
        if before.output_time == after.output_time:
            raise InfeasibleWarpError(f"two keytimes stand at output time {after.output_time:g} s: move or delete one")
    return ordered
