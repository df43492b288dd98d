"""What a strip shows: each row's poses at even output times, and where its flights lie."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.evaluate.metrics.spans import output_intervals
from retime.motion.any_motion import AnyMotion
from retime.motion.motion import Motion
from retime.warp.curve import Warp

DEFAULT_N_POSES = 34
# Where a whole clip would give its longest flight fewer poses than this, an excerpt gives it as many as that.
_FEWEST_IN_FLIGHT = 2.5
_WANTED_IN_FLIGHT = 4.5
# Most seconds between the poses of a clip that has no flight: steps of a walk take about half a second.
_LONGEST_STEP = 0.4


@dataclass(frozen=True, eq=False)
class Row:
    """One row of a strip.

    Attributes
    ----------
    label : str
        The warp's name, or "input".
    warp : Warp
        Output time to input time; the identity for the input.
    origin : float
        Output time at the strip's zero, seconds.
    start, stop : float
        Output times shown, seconds.
    pose_times : float array, shape (n,)
        Output times of the poses, evenly spaced.
    flights : tuple of (float, float)
        Output times between which the input's flights are shown.
    """

    label: str
    warp: Warp
    origin: float
    start: float
    stop: float
    pose_times: FloatArray
    flights: tuple[tuple[float, float], ...]

    __repr__ = brief_repr

    def poses_in(self, flight: tuple[float, float]) -> int:
        """Count this row's poses in a flight."""
        return int(np.count_nonzero(in_flight(self.pose_times, (flight,))))


@dataclass(frozen=True, eq=False)
class Strip:
    """Rows that share one scale of time.

    Attributes
    ----------
    rows : tuple of Row
        The input's first.
    step : float
        Seconds of output between poses, the same in every row.
    left, right : float
        Seconds at the strip's ends, counted from each row's origin.
    aligned : bool
        Whether an excerpt is shown, with one moment of the input (the take-off of its longest flight, else its middle)
        at zero in each row. Otherwise every row is whole, and zero is output time 0.
    anchor : float
        Input time of that moment.
    """

    rows: tuple[Row, ...]
    step: float
    left: float
    right: float
    aligned: bool
    anchor: float

    __repr__ = brief_repr


def in_flight(output_times: FloatArray, intervals: tuple[tuple[float, float], ...]) -> np.ndarray:
    """Tell for each output time whether it lies in one of some intervals."""
    inside = np.zeros(len(output_times), dtype=bool)
    for start, stop in intervals:
        inside |= (output_times >= start) & (output_times <= stop)
    return inside


def plan_strip(
    motion: AnyMotion,
    warps: Mapping[str, Warp],
    found: tuple[tuple[float, float], ...],
    n_poses: int = DEFAULT_N_POSES,
) -> Strip:
    """Choose the times of a strip's poses.

    Every row has the same step. Each row's poses begin a quarter of a step after the take-off of the input's longest
    flight and go on from there both ways, and that flight takes half a step more than a whole number of steps of the
    input: so a row that keeps the flight shows as many poses of it as the input does, whatever comes before it.

    Parameters
    ----------
    motion : Motion or Signal
        The input.
    warps : mapping of str to Warp
        One more row for each.
    found : tuple of (float, float)
        The input's flights, input times.
    n_poses : int
        About how many poses the longest row gets.
    """
    frame = 1 / float(motion.rate)
    end = motion.end_time if motion.end_time > 0 else frame
    sources = [("input", Warp(np.array([0.0, end]), np.array([0.0, end]))), *warps.items()]
    longest_row = max(warp.output_span for _, warp in sources)
    step = longest_row / n_poses
    flight = max(found, key=lambda times: times[1] - times[0], default=None)
    excerpt = False
    if flight is not None:
        flying = flight[1] - flight[0]
        excerpt = flying < _FEWEST_IN_FLIGHT * step
        if excerpt:
            step = flying / _WANTED_IN_FLIGHT
        elif step < flying:
            step = flying / (round(flying / step - 0.5) + 0.5)
    elif isinstance(motion, Motion) and step > _LONGEST_STEP:
        excerpt, step = True, _LONGEST_STEP
    step = max(step, frame)
    anchor = flight[0] if flight is not None else end / 2 if excerpt else 0.0
    phase = step / 4 if flight is not None else 0.0

    places = [_place_of(warp, anchor) for _, warp in sources]
    origins = places if excerpt else [0.0] * len(sources)
    left = min(warp.output_start - origin for (_, warp), origin in zip(sources, origins, strict=True))
    right = max(warp.output_end - origin for (_, warp), origin in zip(sources, origins, strict=True))
    if excerpt:
        # The moment in the middle, unless the clip begins or ends sooner than that.
        width = step * n_poses
        middle = (flight[1] - flight[0]) / 2 if flight is not None else 0.0
        left = max(left, min(middle - width / 2, right - width))
        right = min(right, left + width)
    rows = []
    for (label, warp), place, origin in zip(sources, places, origins, strict=True):
        start, stop = max(warp.output_start, origin + left), min(warp.output_end, origin + right)
        first = np.ceil((start - place - phase) / step - 1e-9)
        last = np.floor((stop - place - phase) / step + 1e-9)
        times = np.clip(place + phase + np.arange(first, last + 1) * step, start, stop)
        intervals = tuple(part for times_in in found for part in output_intervals(warp, *times_in))
        rows.append(Row(label, warp, origin, start, stop, times, intervals))
    return Strip(tuple(rows), step, left, right, excerpt, anchor)


def _place_of(warp: Warp, anchor: float) -> float:
    """First output time at which a warp shows an input time, or comes nearest to it."""
    pieces = (warp.input_times[:-1] - anchor) * (warp.input_times[1:] - anchor) <= 0
    if not pieces.any():
        return float(warp.output_times[np.abs(warp.input_times - anchor).argmin()])
    piece = int(np.argmax(pieces))
    t0, t1 = warp.output_times[piece : piece + 2]
    w0, w1 = warp.input_times[piece : piece + 2]
    return float(t0 if w0 == w1 else t0 + (anchor - w0) / (w1 - w0) * (t1 - t0))
