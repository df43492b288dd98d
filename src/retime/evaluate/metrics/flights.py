"""How flights are played."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from retime.evaluate.metrics import ANALYSIS_RATE, Spans
from retime.evaluate.metrics.spans import seconds_shown
from retime.motion.any_motion import AnyMotion
from retime.motion.flights import flights
from retime.motion.motion import Motion
from retime.search.result import GuidedWarp
from retime.warp.curve import Warp

# A step of the search at unit speed is exactly that; smoothing changes it by rounding alone.
_UNIT = 1e-6
# Of a flight played faster than this too few frames are left to see it.
_LEAPT = 4.0


def flight_spans(motion: AnyMotion | None, *, clearance: float = 0.03) -> tuple[tuple[float, float], ...]:
    """Return take-off and landing of every flight, in seconds; none where there is no skeleton.

    Parameters
    ----------
    motion : Motion, Signal or None
        The input.
    clearance : float
        Metres that everything gets off the ground, at least (see `retime.motion.flights.flights`).
    """
    if not isinstance(motion, Motion):
        return ()
    rate = float(motion.rate)
    return tuple((first / rate, last / rate) for first, last in flights(motion, clearance=clearance))


@dataclass(frozen=True)
class FlightTiming:
    """How flights are played.

    Attributes
    ----------
    n_frames : int
        Analysis periods that lie wholly in a flight of the input: what there was to keep.
    n_kept : int
        Those of them that are played at exactly unit speed from end to end.
    n_flights : int
        Flights of the input.
    n_flights_kept : int
        Flights of which every such period was kept.
    slowest, fastest : float
        Mean speeds of the slowest and of the fastest flight; 1 where there is none.
    n_leapt : int
        Flights that are leapt over: their mean speed is 4 or more.
    """

    n_frames: int
    n_kept: int
    n_flights: int
    n_flights_kept: int
    slowest: float
    fastest: float
    n_leapt: int


def path_warp(found: GuidedWarp) -> Warp:
    """Return the path that a search found as a warp, on the analysis grid: what it decided, before all that follows.

    (`GuidedWarp.staircase` meets ends and keytimes that lie between frames of the grid: its speeds are a little off.)
    """
    times = np.arange(found.n_output) / found.rate
    return Warp(times, found.reduction.input_times[found.path.frames], method="guided")


def flight_timing(warp: Warp, spans: Spans, *, rate: float = ANALYSIS_RATE) -> FlightTiming:
    """Count in-flight frames at exactly unit speed.

    What is counted is frames of the *input*: a flight that the warp rushes through in one step loses all of its frames.
    (Counted among the output's frames it would lose one.)

    Parameters
    ----------
    warp : Warp
        Plays every flight at most once.
    spans : sequence of (float, float)
        Flights of the input, seconds.
    rate : float
        Analysis rate, Hz.

    Examples
    --------
    A flight of a third of a second; its last third is played at twice the speed.

    >>> warp = Warp([0.0, 11 / 90, 20 / 90], [0.0, 11 / 90, 29 / 90])
    >>> flight_timing(warp, [(0.0, 1 / 3)]).n_kept, flight_timing(warp, [(0.0, 1 / 3)]).n_frames
    (3, 10)
    """
    low = np.minimum(warp.input_times[:-1], warp.input_times[1:])
    high = np.maximum(warp.input_times[:-1], warp.input_times[1:])
    off = np.abs(warp.slopes - 1.0) > _UNIT
    n_frames = n_kept = n_flights_kept = 0
    speeds = []
    for start, end in spans:
        first, last = math.ceil(start * rate - 1e-6), math.floor(end * rate + 1e-6)
        kept = 0
        for period in range(first, last):
            a, b = period / rate, (period + 1) / rate
            # A hold belongs to the period that begins where it stands.
            touching = (high > a + 1e-7 * (high > low) - 1e-7 * (high == low)) & (low < b - 1e-7)
            kept += bool(touching.any() and not (touching & off).any())
        n_frames += max(0, last - first)
        n_kept += kept
        n_flights_kept += kept == max(0, last - first)
        shown = seconds_shown(warp, [(start, end)])
        speeds.append((end - start) / shown if shown > 0 else math.inf)
    return FlightTiming(
        n_frames,
        n_kept,
        len(spans),
        n_flights_kept,
        min(speeds, default=1.0),
        max(speeds, default=1.0),
        sum(speed >= _LEAPT for speed in speeds),
    )
