"""A warp that was found on a figure, applied to the camera that follows it."""

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

CAMERA_RATE = Fraction(24)
"""A film's: another rate than the motion's, as cameras have."""


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
