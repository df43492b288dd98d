"""A warp that was found on a figure, applied to a curve that was drawn along it."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from retime.arrays import FloatArray
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp

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
