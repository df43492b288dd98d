"""A guided warp of two plain columns of numbers: a ball that flies, rests, and flies again."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.evaluate.metrics.flights import FlightTiming, flight_timing
from retime.motion.signal import Signal
from retime.search.guided import guided_warp
from retime.search.result import GuidedWarp
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from retime.warp.spline import linear_warp

GRAVITY = 9.81


def bouncing_ball(
    *, n_bounces: int = 6, flight: float = 0.6, rest: float = 0.9, rate: int = 60
) -> tuple[Signal, tuple[tuple[float, float], ...]]:
    """Make a ball that flies, rests, and flies again: metres, with its flights' times in seconds."""
    times = np.arange(round((n_bounces * (flight + rest) + rest) * rate) + 1) / rate
    height, along = np.zeros_like(times), np.zeros_like(times)
    spans = []
    for bounce in range(n_bounces):
        start = rest + bounce * (flight + rest)
        aloft = np.clip(times - start, 0.0, flight)
        height += GRAVITY / 2 * aloft * (flight - aloft)
        along += 1.2 * aloft
        spans.append((start, start + flight))
    # While it rests it rolls a little: silence is rarely silent.
    along += 0.15 * times
    return Signal(("along", "height"), np.stack([along, height], axis=1), Fraction(rate), name="ball"), tuple(spans)


def falls(ball: Signal, warp: Warp, spans: tuple[tuple[float, float], ...]) -> FloatArray:
    """Gravity of each flight after a warp over 9.81, by a parabola through its heights."""
    output, back, rate = apply_warp(ball, warp, average=False), warp.inverse(), float(ball.rate)
    found = []
    for start, end in spans:
        first, last = float(back(start)), float(back(end))
        frames = np.arange(np.ceil(first * rate - 1e-6), np.floor(last * rate + 1e-6) + 1).astype(np.intp)
        curve = np.polynomial.polynomial.polyfit(frames / rate - (first + last) / 2, output.values[frames, 1], 2)
        found.append(-2 * curve[2] / GRAVITY)
    return np.array(found)


@dataclass(frozen=True, eq=False)
class SignalResult:
    """A guided warp of a signal with no skeleton, and the linear one.

    Attributes
    ----------
    signal : Signal
        The input.
    spans : tuple of (float, float)
        Its flights, seconds.
    guided : GuidedWarp
        Found on the signal's own columns.
    linear : Warp
        Beside it.
    timing, linear_timing : retime.evaluate.metrics.flights.FlightTiming
        How flights are played.
    gravity, linear_gravity : float
        The flights' gravity over 9.81, of all that which is farthest from 1.
    """

    signal: Signal
    spans: tuple[tuple[float, float], ...]
    guided: GuidedWarp
    linear: Warp
    timing: FlightTiming
    linear_timing: FlightTiming
    gravity: float
    linear_gravity: float

    __repr__ = brief_repr


def warp_signal(length: str = "60%") -> SignalResult:
    """Shorten the bouncing ball, with itself as the reference."""
    ball, spans = bouncing_ball()
    found = guided_warp(ball, length=length)
    linear = linear_warp(found.warp.keytimes)
    ratios = [falls(ball, warp, spans) for warp in (found.warp, linear)]
    worst = [float(one[np.argmax(np.abs(np.log(one)))]) for one in ratios]
    return SignalResult(
        ball,
        spans,
        found,
        linear,
        flight_timing(found.staircase, spans),
        flight_timing(linear, spans),
        worst[0],
        worst[1],
    )
