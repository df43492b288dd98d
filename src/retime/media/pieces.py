"""The warp as sound needs it: straight pieces, long enough to be stretched, exact at keytimes and where time turns."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from retime.warp.curve import Warp
from retime.warp.simplify import simplified

SHORTEST = 0.2
"""Seconds of output; a stretcher hears no pitch in less."""

# How far, in seconds of input, a piece may be off its parts.
_TOLERANCE = 0.002
# Slower than this nothing is left of a sound but a drone: it is a hold.
SLOWEST, FASTEST = 1 / 12, 24.0


class Piece(NamedTuple):
    """A straight piece of the map.

    Attributes
    ----------
    output_start, output_end : float
        Seconds.
    input_start, input_end : float
        Seconds; the second is less where time runs backward.
    """

    output_start: float
    output_end: float
    input_start: float
    input_end: float

    @property
    def speed(self) -> float:
        """Seconds of input a second, below 0 where it plays backward."""
        return (self.input_end - self.input_start) / (self.output_end - self.output_start)

    @property
    def held(self) -> bool:
        """Whether nothing can be heard of the input, because time stands, or all but stands, or races."""
        return not SLOWEST <= abs(self.speed) <= FASTEST


def pieces_of(warp: Warp, shortest: float = SHORTEST) -> list[Piece]:
    """Split a warp into straight pieces.

    Their ends lie on the warp: at its ends, its keytimes, where it turns, and where it begins or ends to hold. Between
    those the curve is parted as finely as it needs, but into no parts of less than `shortest` seconds.

    Examples
    --------
    >>> for piece in pieces_of(Warp([0, 0.5, 1, 3], [0, 0.5, 1, 2])):
    ...     print(*piece)
    0.0 1.0 0.0 1.0
    1.0 3.0 1.0 2.0
    """
    times, values = warp.output_times, warp.input_times
    keys = np.array([key.output_time for key in warp.keytimes])
    way = np.sign(np.diff(values))
    fixed = np.ones(len(times), dtype=bool)
    fixed[1:-1] = (way[1:] != way[:-1]) | np.isin(times[1:-1], keys)
    must = np.flatnonzero(fixed)
    output_times = [times[:1]]
    for start, stop in zip(times[must[:-1]].tolist(), times[must[1:]].tolist(), strict=True):
        # As many equal parts as are long enough; of these, those stay that the curve needs.
        grid = np.linspace(start, stop, max(1, int((stop - start) / shortest)) + 1)
        output_times.append(grid[simplified(grid, warp(grid), _TOLERANCE, grid[:0])][1:])
    ends = np.concatenate(output_times)
    places = warp(ends)
    return [Piece(*map(float, numbers)) for numbers in zip(ends[:-1], ends[1:], places[:-1], places[1:], strict=True)]


def spans_shown(warp: Warp, start: float, stop: float) -> list[tuple[float, float]]:
    """Return the spans of output time in which a span of input time is shown, in their order.

    Examples
    --------
    >>> spans_shown(Warp([0, 2, 4], [0, 4, 2]), 3.0, 4.0)
    [(1.5, 3.0)]
    """
    found: list[tuple[float, float]] = []
    for t0, t1, w0, w1 in zip(
        warp.output_times[:-1].tolist(),
        warp.output_times[1:].tolist(),
        warp.input_times[:-1].tolist(),
        warp.input_times[1:].tolist(),
        strict=True,
    ):
        if w0 == w1:
            inside = (t0, t1) if start <= w0 < stop else None
        else:
            first, last = sorted((min(max((edge - w0) / (w1 - w0), 0.0), 1.0)) for edge in (start, stop))
            inside = (t0 + first * (t1 - t0), t0 + last * (t1 - t0)) if last > first else None
        if inside is None:
            continue
        if found and inside[0] - found[-1][1] < 1e-9:
            found[-1] = (found[-1][0], inside[1])
        else:
            found.append(inside)
    return found
