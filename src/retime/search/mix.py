"""Less than the whole of a guided warp: a mix with a spline that keeps what the guided warp was asked to keep (§5).

The spline through the keytimes knows nothing of locks, limits and tangents. Here it runs through the guided warp's
anchors too: a stretch at a fixed speed is the same in both, and elsewhere both stay within their bounds, so that every
mix of the two keeps them.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from retime.arrays import FloatArray
from retime.search.promised_curve import Stretch
from retime.warp.curve import Warp
from retime.warp.knots import add_times
from retime.warp.spline import pchip_slopes

# Of the part of the guided warp that is straight beside a tangent, a spline has so much.
_TANGENT_PART = 1 / 16


def _shared(guided: Warp, stretches: Sequence[Stretch]) -> list[Stretch]:
    """Shorten the stretches that are fixed by tangents: a spline has that speed at the keytime, and goes on from it.

    What is left of each has the bounds of what is beside it.
    """
    found: list[Stretch] = []
    for i, stretch in enumerate(stretches):
        if not stretch.tangent:
            found.append(stretch)
            continue
        beside = i - stretch.tangent
        other = stretches[beside] if 0 <= beside < len(stretches) else stretch
        part = (stretch.end - stretch.start) * _TANGENT_PART
        if other.tangent or part < 1e-6:
            found.append(stretch)
        elif stretch.tangent < 0:
            middle = stretch.start + part
            found += [replace(stretch, end=middle), replace(other, start=middle, end=stretch.end)]
        else:
            middle = stretch.end - part
            found += [replace(other, start=stretch.start, end=middle), replace(stretch, start=middle)]
    keys = {key.output_time for key in guided.keytimes}
    joined: list[Stretch] = []
    for stretch in found:
        before = joined[-1] if joined else None
        if (
            before is not None
            and before.end not in keys
            and replace(before, start=0, end=0) == replace(stretch, start=0, end=0)
        ):
            joined[-1] = replace(before, end=stretch.end)
        else:
            joined.append(stretch)
    return joined


def spline_within(guided: Warp, stretches: Sequence[Stretch], rate: float) -> Warp:
    """Join the ends of a guided warp's stretches by a spline that keeps to their bounds.

    Parameters
    ----------
    guided : Warp
        The warp that it is to be mixed with.
    stretches : sequence of Stretch
        They follow on one another from its beginning to its end.
    rate : float
        Knots a second of output.

    Returns
    -------
    Warp
        Straight where a stretch has one speed; elsewhere a cubic that never turns back, flattened as far towards the
        straight line as the bounds ask for.
    """
    stretches = _shared(guided, stretches)
    edges = np.array([stretches[0].start, *(stretch.end for stretch in stretches)])
    places = guided(edges)
    means = np.diff(places) / np.diff(edges)
    n_knots = max(2, round((edges[-1] - edges[0]) * rate) + 1)
    times = add_times(edges, np.linspace(edges[0], edges[-1], n_knots))
    values = np.empty(len(times))
    slopes = pchip_slopes(edges, places)
    # At a keytime the spline is what it would be if nothing but keytimes were asked for.
    keys = np.array([[key.output_time, key.input_time] for key in guided.keytimes])
    at_keys = np.searchsorted(edges, keys[:, 0])
    slopes[at_keys] = pchip_slopes(keys[:, 0], keys[:, 1])
    for i, stretch in enumerate(stretches):
        first, last = np.searchsorted(times, edges[i : i + 2])
        here = times[first : last + 1]
        line = places[i] + means[i] * (here - edges[i])
        if stretch.fixed or means[i] == 0:
            values[first : last + 1] = line
            continue
        ends = []
        for edge, other in ((i, i - 1), (i + 1, i + 1)):
            beside = stretches[other] if 0 <= other < len(stretches) else None
            # Beside a fixed speed the cubic has that speed, where it can without turning back.
            slope = means[other] if beside is not None and beside.fixed else slopes[edge]
            same = slope * means[i] > 0
            ends.append(math.copysign(min(abs(slope), 3 * abs(means[i])), means[i]) if same else 0.0)
        cubic = _cubic(here, edges[i], edges[i + 1], places[i], places[i + 1], ends[0], ends[1])
        values[first : last + 1] = _flattened(here, line, cubic, stretch)
        values[[first, last]] = places[i : i + 2]
    return Warp(times, values, guided.keytimes, method="spline")


def _cubic(
    times: FloatArray, start: float, end: float, first: float, last: float, begin: float, finish: float
) -> FloatArray:
    """Evaluate the cubic from (start, first) to (end, last) with given slopes at its ends."""
    width = end - start
    t = (times - start) / width
    rise = last - first
    return first + rise * t * t * (3 - 2 * t) + width * (begin * t * (1 - t) ** 2 - finish * t * t * (1 - t))


def _flattened(times: FloatArray, line: FloatArray, curve: FloatArray, stretch: Stretch) -> FloatArray:
    """Move a curve towards the straight line as far as the bounds of its speed ask for, and no farther."""
    mean = abs(line[-1] - line[0]) / (times[-1] - times[0])
    speeds = np.diff(curve) / np.diff(times) * (1 if line[-1] > line[0] else -1)
    apart = speeds - mean
    share = 1.0
    for bound, beyond in ((stretch.fastest, speeds > stretch.fastest), (stretch.slowest, speeds < stretch.slowest)):
        if beyond.any():
            share = min(share, max(0.0, float(((bound - mean) / apart[beyond]).min())))
    return curve if share == 1.0 else line + share * (curve - line)


def mixed_within(spline: Warp, guided: Warp, share: FloatArray, stretches: Sequence[Stretch]) -> Warp:
    """Mix two warps that keep the bounds of all stretches: so does the mix.

    A share that changes makes speeds of its own. In a stretch where these would leave the bounds, the share's changes
    are scaled down to the most that keeps them.

    Parameters
    ----------
    spline, guided : Warp
        They meet wherever a stretch ends.
    share : float array, shape () or (n, 2)
        0 is the spline, 1 the guided warp; or a curve of output times and shares.
    stretches : sequence of Stretch
        As `spline_within` has them.
    """
    stretches = _shared(guided, stretches)
    edges = np.array([stretches[0].start, *(stretch.end for stretch in stretches)])
    inner = guided.output_times if share.ndim == 0 else np.concatenate([guided.output_times, share[:, 0]])
    times = add_times(spline.output_times, inner[(inner > edges[0]) & (inner < edges[-1])])
    one, other = spline(times), guided(times)
    weights = np.full(len(times), float(share)) if share.ndim == 0 else np.interp(times, share[:, 0], share[:, 1])
    values = other.copy()
    # An edge is a knot of the spline, and stays one. A fixed stretch is straight in both.
    ends = np.searchsorted(times, edges - 1e-9)
    for stretch, (first, last) in zip(stretches, itertools.pairwise(ends.tolist()), strict=True):
        piece = slice(first, last + 1)
        if stretch.fixed:
            values[piece] = one[piece]
        else:
            values[piece] = _mixed(times[piece], one[piece], other[piece], weights[piece], stretch)
    values[0], values[-1] = other[0], other[-1]
    return Warp(times, values, guided.keytimes, method="guided", name=guided.name)


def _mixed(times: FloatArray, one: FloatArray, other: FloatArray, share: FloatArray, stretch: Stretch) -> FloatArray:
    sign = 1.0 if other[-1] >= other[0] else -1.0
    middle = float(share.mean())

    def mixed(scale: float) -> FloatArray:
        weight = middle + scale * (share - middle)
        # A weight of 1 gives the other one to the last bit.
        return np.where(weight == 1.0, other, one + weight * (other - one))

    def beyond(values: FloatArray) -> float:
        """How far the worst speed lies beyond the bounds."""
        speeds = np.diff(values) / np.diff(times) * sign
        return float(max((stretch.slowest - speeds).max(), (speeds - stretch.fastest).max(), 0.0))

    # What both sides are off themselves, by rounding or because nothing better can be had, is no reason to change.
    allowed = max(beyond(one), beyond(other)) * (1 + 1e-9) + 1e-12
    if beyond(mixed(1.0)) <= allowed:
        return np.maximum.accumulate(mixed(1.0) * sign) * sign
    low, high = 0.0, 1.0
    for _ in range(40):
        scale = (low + high) / 2
        low, high = (low, scale) if beyond(mixed(scale)) > allowed else (scale, high)
    # Not even a rounding error may turn it back.
    return np.maximum.accumulate(mixed(low) * sign) * sign
