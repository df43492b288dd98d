"""Pose, velocity and acceleration of analysis frames (§3.2).

Everything here is for looking at the motion; the output is never made from it.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from retime.errors import OptionError
from retime.motion.kinematics import global_poses, heading_positions, torso_positions
from retime.motion.motion import Motion, frame_positions
from retime.motion.rotation import FloatArray
from retime.motion.signal import Signal

POSE_SPACES = ("torso", "heading", "signal")


def pose_vectors(motion: Motion | Signal, space: str | None = None) -> FloatArray:
    """Describe each frame's pose by a vector of numbers.

    Parameters
    ----------
    motion : Motion or Signal
        What moves.
    space : {"torso", "heading", "signal"}, optional
        ``torso``: positions of all joints but the root in the root's space (the paper's). ``heading``: positions of
        all joints with ground position and turn removed, height and tilt kept. ``signal``: the columns themselves,
        each divided by its standard deviation. Left out: ``torso`` for a motion, ``signal`` for a signal.

    Returns
    -------
    float array, shape (n_frames, n_numbers)
        Length units for a motion, standard deviations for a signal.

    Raises
    ------
    OptionError
        No such space, or not one for this kind of motion.
    """
    if space is None:
        space = "torso" if isinstance(motion, Motion) else "signal"
    if space not in POSE_SPACES:
        raise OptionError(f"features must be one of {', '.join(POSE_SPACES)}; found {space!r}")
    if isinstance(motion, Signal):
        if space != "signal":
            raise OptionError(
                f"{motion.name or 'the signal'} has no skeleton: its features are 'signal', not {space!r}"
            )
        return motion.values
    if space == "signal":
        raise OptionError(f"{motion.name or 'the motion'} has a skeleton: its features are 'torso' or 'heading'")
    poses = global_poses(motion)
    positions = torso_positions(poses) if space == "torso" else heading_positions(poses)
    if positions.shape[1] == 0:
        raise OptionError(f"{motion.name or 'the motion'} has one joint: torso features need more; use 'heading'")
    return np.ascontiguousarray(positions.reshape(len(positions), -1))


def low_pass(vectors: FloatArray, rate: Fraction, cutoff: float) -> FloatArray:
    """Remove fast detail from each column: uniform and zero-phase (§3.2, against temporal aliasing).

    The Gaussian of discrete time, with the width that halves the power at `cutoff`; ends are continued by point
    reflection, so they keep their slope.

    Parameters
    ----------
    vectors : float array, shape (n_frames, n_numbers)
        At `rate` frames a second.
    rate : Fraction
        Frames a second.
    cutoff : float
        Hz; 0, or anything from half the rate up, changes nothing.
    """
    if not (math.isfinite(cutoff) and cutoff >= 0):
        raise OptionError(f"the low-pass cutoff must be 0 (off) or more Hz, found {cutoff}")
    if cutoff == 0 or cutoff >= float(rate) / 2 or len(vectors) < 2:
        return vectors
    from scipy.special import ive

    # Taps e^-t I_n(t) pass exp(t (cos ω - 1)) of a wave at ω. Samples of the Gaussian itself would pass too much where
    # the cutoff comes near half the rate.
    # (The floor keeps a cutoff of next to nothing finite: an average of everything.)
    variance = math.log(2) / max(4 * math.sin(math.pi * cutoff / float(rate)) ** 2, 1e-8)
    reach = min(math.ceil(4 * math.sqrt(variance)) + 2, len(vectors) - 1)
    taps = ive(np.abs(np.arange(-reach, reach + 1)), variance)
    taps /= taps.sum()
    wide = np.pad(vectors, ((reach, reach), (0, 0)), mode="reflect", reflect_type="odd")
    out = taps[reach] * vectors
    n_frames = len(vectors)
    for lag in range(1, reach + 1):
        out += taps[reach + lag] * (
            wide[reach - lag : reach - lag + n_frames] + wide[reach + lag : reach + lag + n_frames]
        )
    return np.asarray(out)


def sample(vectors: FloatArray, rate: Fraction, input_times: ArrayLike) -> FloatArray:
    """Read pose vectors between frames, by a cubic through the two frames to either side.

    A straight line would put corners, false accelerations, into an input that is upsampled (§3.1). At a frame the
    value is that frame's, bit for bit.

    Parameters
    ----------
    vectors : float array, shape (n_frames, n_numbers)
        At `rate` frames a second.
    input_times : float array, shape (n,)
        Seconds from the first frame; held at the ends outside.

    Returns
    -------
    float array, shape (n, n_numbers)
    """
    before, after, fraction = frame_positions(input_times, rate, len(vectors))
    out: FloatArray = vectors[before]
    between = np.flatnonzero(fraction)
    if not len(between):
        return out
    last = len(vectors) - 1
    b, a, t = before[between], after[between], fraction[between][:, None]
    p1, p2 = vectors[b], vectors[a]
    # Beyond the ends the nearest piece goes straight on.
    p0 = np.where((b > 0)[:, None], vectors[np.maximum(b - 1, 0)], 2 * p1 - p2)
    p3 = np.where((a < last)[:, None], vectors[np.minimum(a + 1, last)], 2 * p2 - p1)
    m1, m2 = (p2 - p0) / 2, (p3 - p1) / 2
    out[between] = p1 + t * (m1 + t * (3 * (p2 - p1) - 2 * m1 - m2 + t * (m1 + m2 - 2 * (p2 - p1))))
    return out


def timing_features(poses: FloatArray, *, rate: float, time_scale: float) -> FloatArray:
    """Features of consecutive frames: pose, scaled velocity, scaled acceleration (§3.2).

    ``[y, τ (y₊ - y₋) / 2Δ, τ² (y₊ - 2y + y₋) / Δ²]`` with Δ = 1 / `rate` and τ = `time_scale`.

    Parameters
    ----------
    poses : float array, shape (n_frames, n_numbers)
        Pose vectors of a reference, one analysis period apart; at least three.
    rate : float
        Analysis rate, Hz.
    time_scale : float
        τ, seconds: how much velocity and acceleration weigh against pose. τ = Δ is the paper read literally.

    Returns
    -------
    float array, shape (n_frames - 2, 3 * n_numbers)
        All three blocks in pose units.
    """
    velocity, acceleration = difference_scales(rate, time_scale)
    before, here, after = poses[:-2], poses[1:-1], poses[2:]
    return np.concatenate(
        [here, (after - before) * velocity, ((after - here) - (here - before)) * acceleration], axis=1
    )


def difference_scales(rate: float, time_scale: float) -> tuple[float, float]:
    """Return what to multiply first and second differences by: τ / 2Δ and τ² / Δ²."""
    if not (math.isfinite(time_scale) and time_scale >= 0):
        raise OptionError(f"the time scale must be 0 or more seconds, found {time_scale}")
    return time_scale * rate / 2, (time_scale * rate) ** 2
