"""Beyond motion (the paper's Figure 4, and its hope): one warp for a camera, and a guided warp of a plain signal."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from retime.brief import brief_repr
from retime.evaluate.metrics import FlightTiming, flight_timing
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion
from retime.motion.rotation import FloatArray
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from retime.warp.guided import guided_warp
from retime.warp.result import GuidedWarp
from retime.warp.spline import linear_warp

CAMERA_RATE = Fraction(24)
"""A film's: another rate than the motion's, as cameras have."""

GRAVITY = 9.81


def orbit(motion: Motion, *, distance: float = 4.0, seconds_a_turn: float = 20.0) -> Signal:
    """Let a camera go round a figure and look at its root: place and aim, in the motion's units, at 24 Hz."""
    unit = 1 / metres_per_unit(motion)
    times = np.arange(round(motion.end_time * float(CAMERA_RATE)) + 1) / float(CAMERA_RATE)
    root = global_poses(motion.at(times)).positions[:, 0]
    angle = 2 * np.pi * times / seconds_a_turn
    place = root + distance * unit * np.stack([np.cos(angle), np.full_like(angle, 0.25), np.sin(angle)], axis=1)
    names = ("place x", "place y", "place z", "aim x", "aim y", "aim z")
    return Signal(names, np.concatenate([place, root], axis=1), CAMERA_RATE, name="camera")


def aim_errors(camera: Signal, motion: Motion) -> FloatArray:
    """Angle between where a camera looks and where the figure's root is, degrees, at each of the camera's frames."""
    times = np.arange(camera.n_frames) / float(camera.rate)
    root = global_poses(motion.at(times)).positions[:, 0]
    place, aim = camera.values[:, :3], camera.values[:, 3:6]
    a, b = aim - place, root - place
    across = np.linalg.norm(np.cross(a, b), axis=1)
    return np.asarray(np.degrees(np.arctan2(across, np.sum(a * b, axis=1))))


@dataclass(frozen=True)
class CameraResult:
    """What one warp did to a camera that was made for the motion.

    Attributes
    ----------
    before : float
        Largest aim error of the input, degrees.
    together : float
        The same when the warp that was found on the motion is applied to the camera too.
    motion_alone : float
        When the motion is warped, and the camera is not.
    n_input, n_output : int
        Frames of the camera, before and after.
    motion : Motion
        The warped figure.
    shown, left : Signal
        The camera, warped with it and as it was.
    """

    before: float
    together: float
    motion_alone: float
    n_input: int
    n_output: int
    motion: Motion
    shown: Signal
    left: Signal


def warp_camera(motion: Motion, warp: Warp) -> CameraResult:
    """Apply a warp to a motion and to its camera."""
    camera = orbit(motion)
    output, shown = apply_warp(motion, warp), apply_warp(camera, warp)
    left = camera.frames(0, min(camera.n_frames, shown.n_frames))
    return CameraResult(
        float(aim_errors(camera, motion).max()),
        float(aim_errors(shown, output).max()),
        float(aim_errors(left, output).max()),
        camera.n_frames,
        shown.n_frames,
        output,
        shown,
        left,
    )


CURVE_RATE = Fraction(50)


@dataclass(frozen=True)
class CurveResult:
    """What the same warp did to a plain curve that was drawn along the motion: the height of its root.

    Attributes
    ----------
    together : float
        How far the warped curve is off the warped figure's root at most, metres.
    motion_alone : float
        When the curve is left as it was.
    n_input, n_output : int
        Samples of the curve, at 50 Hz, before and after.
    """

    together: float
    motion_alone: float
    n_input: int
    n_output: int


def warp_curve(motion: Motion, warp: Warp) -> CurveResult:
    """Apply a warp that was found on a motion to one column of numbers that belongs to it."""

    def height(of: Motion, times: FloatArray) -> FloatArray:
        return global_poses(of.at(times)).positions[:, 0, 1] * metres_per_unit(motion)

    def clock(n_samples: int) -> FloatArray:
        return np.arange(n_samples) / float(CURVE_RATE)

    times = clock(round(motion.end_time * float(CURVE_RATE)) + 1)
    curve = Signal(("height",), height(motion, times)[:, None], CURVE_RATE, name="height")
    output, shown = apply_warp(motion, warp), apply_warp(curve, warp)
    wanted = height(output, clock(shown.n_frames))
    left = curve.values[: shown.n_frames, 0]
    return CurveResult(
        float(np.abs(shown.values[:, 0] - wanted).max()),
        float(np.abs(left - wanted[: len(left)]).max()),
        curve.n_frames,
        shown.n_frames,
    )


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
    timing, linear_timing : retime.evaluate.metrics.FlightTiming
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
        flight_timing(found.steps, spans),
        flight_timing(linear, spans),
        worst[0],
        worst[1],
    )
