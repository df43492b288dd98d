"""The baselines: what an animator has today (§4.1)."""

from __future__ import annotations

import itertools
import math
import warnings
from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from retime.errors import InfeasibleWarpError, RetimeWarning
from retime.kernels import FloatArray
from retime.motion.rate import parse_rate
from retime.warp.curve import Keytime, KeytimeLike, Warp, add_times, check_speed, keytimes_of


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
        Something that is no keytime, or no rate.

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
    from scipy.interpolate import PchipInterpolator

    ordered = _ordered(keytimes)
    output_times = np.array([key.output_time for key in ordered])
    input_times = np.array([key.input_time for key in ordered])
    start, end = output_times[0], output_times[-1]
    n_knots = max(2, round((end - start) * float(parse_rate(rate))) + 1)
    times = add_times(output_times, np.linspace(start, end, n_knots))
    spline = PchipInterpolator(output_times, input_times)
    if all(key.speed is None for key in ordered):
        values = np.asarray(spline(times))
    else:
        values = _hermite(output_times, input_times, *_slopes(ordered, np.asarray(spline(output_times, 1))), times)
    values[np.searchsorted(times, output_times)] = input_times
    return Warp(times, values, ordered, method="spline")


def _slopes(keytimes: Sequence[Keytime], slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
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


def _hermite(
    output_times: FloatArray, input_times: FloatArray, begin: FloatArray, end: FloatArray, times: FloatArray
) -> FloatArray:
    """Evaluate cubics through the keytimes that begin and end each span with the given slopes."""
    span = np.clip(np.searchsorted(output_times, times, side="right") - 1, 0, len(output_times) - 2)
    width = np.diff(output_times)[span]
    rise = np.diff(input_times)[span]
    t = (times - output_times[span]) / width
    a, b = begin[span] * width - rise, rise - end[span] * width
    return np.asarray(input_times[span] + t * (rise + (1 - t) * (a * (1 - t) + b * t)))


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
