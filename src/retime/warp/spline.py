"""The baselines: what an animator has today (§4.1)."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from retime.errors import InfeasibleWarpError
from retime.warp.curve import Keytime, Warp, add_times


def linear_warp(keytimes: Sequence[Keytime]) -> Warp:
    """Join keytimes by straight lines: constant speed in each span.

    Examples
    --------
    >>> linear_warp([Keytime(0.0, 0.0), Keytime(2.0, 3.0)]).slopes.tolist()
    [1.5]
    """
    ordered = _ordered(keytimes)
    return Warp(
        np.array([key.output_time for key in ordered]),
        np.array([key.input_time for key in ordered]),
        ordered,
        method="linear",
    )


def spline_warp(keytimes: Sequence[Keytime], *, rate: float = 120.0) -> Warp:
    """Join keytimes by a cubic that is smooth and never turns back between them (Fritsch and Carlson's PCHIP).

    Parameters
    ----------
    keytimes : sequence of Keytime
        At least two. With only two, the spline is the straight line.
    rate : float
        Knots a second of output.
    """
    from scipy.interpolate import PchipInterpolator

    ordered = _ordered(keytimes)
    output_times = np.array([key.output_time for key in ordered])
    input_times = np.array([key.input_time for key in ordered])
    start, end = output_times[0], output_times[-1]
    n_knots = max(2, round((end - start) * rate) + 1)
    times = add_times(output_times, np.linspace(start, end, n_knots))
    values = np.asarray(PchipInterpolator(output_times, input_times)(times))
    values[np.searchsorted(times, output_times)] = input_times
    return Warp(times, values, ordered, method="spline")


def _ordered(keytimes: Sequence[Keytime]) -> tuple[Keytime, ...]:
    ordered = tuple(sorted(keytimes))
    if len(ordered) < 2:
        raise InfeasibleWarpError("a warp needs at least two keytimes, its ends")
    for before, after in itertools.pairwise(ordered):
        if before.output_time == after.output_time:
            raise InfeasibleWarpError(f"two keytimes stand at output time {after.output_time:g} s: move or delete one")
    return ordered
