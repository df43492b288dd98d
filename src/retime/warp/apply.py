"""Resample a motion by a warp, and average where it was sped up (§3.4)."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import TypeVar

import numpy as np

from retime.errors import RetimeWarning
from retime.kernels import FloatArray
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.curve import Warp

AnyMotion = TypeVar("AnyMotion", Motion, Signal)


def output_frame_times(warp: Warp, rate: float) -> FloatArray:
    """Return the output time of each frame that a warp gives at `rate`, seconds; the last one is the warp's end."""
    n_output = max(1, round(warp.output_duration * rate) + 1)
    times = warp.output_start + np.arange(n_output) / rate
    if n_output > 1:
        times[-1] = warp.output_end
    return times


def apply_warp(motion: AnyMotion, warp: Warp, *, average: bool = True) -> AnyMotion:
    """Show a motion with a warp's timing, at the motion's own rate (§3.4).

    Rotations are slerped, everything else is interpolated linearly. Where the warp plays faster than life by c,
    each output frame is the mean of the input over a window of c frames, so that sway does not become jitter; where
    it does not, poses come straight from the input. The window closes at the ends, whose poses are kept.

    Parameters
    ----------
    motion : Motion or Signal
        The clip that the warp was found for, its full-rate original, another character, a camera.
    warp : Warp
        From output time to input time.
    average : bool
        Average where sped up.

    Returns
    -------
    Motion or Signal
        Same rate, names and channels; ``round(warp.output_duration * rate) + 1`` frames.

    Warns
    -----
    RetimeWarning
        The warp and the motion don't cover the same input times.

    Examples
    --------
    >>> from fractions import Fraction
    >>> ramp = Signal(("x",), np.arange(5.0)[:, None], Fraction(1))
    >>> apply_warp(ramp, Warp([0.0, 2.0], [0.0, 4.0]), average=False).values[:, 0].tolist()
    [0.0, 2.0, 4.0]
    """
    rate = float(motion.rate)
    _compare_ranges(motion, warp)
    output_times = output_frame_times(warp, rate)
    input_times = warp(output_times)
    result = motion.at(input_times)
    if average:
        result = _average_where_fast(result, motion, warp, output_times, input_times)
    return replace(result, first_frame=motion.first_frame)


def _compare_ranges(motion: Motion | Signal, warp: Warp) -> None:
    """Warn where the warp and the motion don't cover the same input times, half a frame aside."""
    name, near = motion.name or "the motion", 0.5 / float(motion.rate)
    low, high = float(warp.input_times.min()), float(warp.input_times.max())
    if low < -near or high > motion.duration + near:
        message = (
            f"the warp reaches input times {low:g} to {high:g} s, but {name} runs from 0 to {motion.duration:g} s; "
            "it is held at its ends"
        )
    elif low > near or high < motion.duration - near:
        message = (
            f"the warp uses input times {low:g} to {high:g} s; {name} runs from 0 to {motion.duration:g} s, and the "
            "rest of it is left out"
        )
    else:
        return
    warnings.warn(message, RetimeWarning, stacklevel=3)


def window_frames(warp: Warp, rate: float, output_times: FloatArray) -> FloatArray:
    """Return how many input frames each output frame averages: its speed where above 1 (§3.4), else 1."""
    period = 1.0 / rate
    before = np.maximum(output_times - period / 2, warp.output_start)
    after = np.minimum(output_times + period / 2, warp.output_end)
    with np.errstate(invalid="ignore", divide="ignore"):
        speed = np.abs(warp(after) - warp(before)) / (after - before)
    return np.asarray(np.maximum(np.nan_to_num(speed, nan=1.0), 1.0))


def _average_where_fast(
    result: AnyMotion, motion: AnyMotion, warp: Warp, output_times: FloatArray, input_times: FloatArray
) -> AnyMotion:
    rate = float(motion.rate)
    half = (window_frames(warp, rate, output_times) - 1.0) / 2
    centre = input_times * rate
    half = np.minimum(half, np.minimum(centre, motion.n_frames - 1 - centre))
    fast = np.flatnonzero(half > 1e-6)
    if not len(fast):
        return result
    low, high = centre[fast] - half[fast], centre[fast] + half[fast]
    if isinstance(result, Signal):
        assert isinstance(motion, Signal)
        values = result.values.copy()
        values[fast] = _window_means(motion.values, low, high)
        return replace(result, values=values)
    assert isinstance(motion, Motion)
    rotations, translations = result.rotations.copy(), result.local_translations.copy()
    # The mean of neighbouring quaternions, all on one side and scaled to unit length, is their mean rotation.
    # Where they go all the way round, and cancel, there is none: those joints keep the sampled rotation.
    turned = _window_means(_one_side(motion.rotations), low, high)
    apart = np.sum(turned * turned, axis=-1) < 0.1**2
    turned[apart] = rotations[fast][apart]
    rotations[fast] = rotation.normalize(turned)
    translations[fast] = _window_means(motion.local_translations, low, high)
    return replace(result, rotations=rotations, translations=translations)


def _one_side(rotations: FloatArray) -> FloatArray:
    """Flip quaternions (n_frames, n_joints, 4) so that each lies on its predecessor's side."""
    turns = np.einsum("fjc,fjc->fj", rotations[1:], rotations[:-1]) < 0
    flips = np.cumsum(turns, axis=0) % 2 == 1
    if not flips.any():
        return rotations
    sides = np.ones((*rotations.shape[:2], 1))
    sides[1:][flips] = -1.0
    return rotations * sides


def _window_means(values: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Mean of the polyline through `values` (n_frames, ...) over each window [low, high], in frames."""
    # Integrals from frame 0, about the mean so that long clips lose no digits.
    origin = values.mean(axis=0)
    centred = values - origin
    integral = np.zeros_like(centred)
    np.cumsum((centred[1:] + centred[:-1]) / 2, axis=0, out=integral[1:])

    def upto(place: FloatArray) -> FloatArray:
        before = np.minimum(place.astype(np.intp), len(values) - 1)
        after = np.minimum(before + 1, len(values) - 1)
        share = (place - before).reshape(-1, *[1] * (values.ndim - 1))
        a = centred[before]
        return np.asarray(integral[before] + share * (a + share / 2 * (centred[after] - a)))

    width = (high - low).reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray(origin + (upto(high) - upto(low)) / width)
