"""Warps by hand: a walk that limps, flights in slow motion, blows without force."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from retime.arrays import FloatArray
from retime.evaluate.metrics.flights import flight_spans
from retime.motion.motion import Motion
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from study.clips.blows import fastest_joint
from study.clips.walks import cycles


def limp(motion: Motion, *, strength: float = 1.7) -> Warp:
    """Make a walk limp: hurry over every step that begins with the left foot in front, linger over every other.

    The speed goes smoothly from 1 to `strength` and back within each hurried step, and to 1 / `strength` in the others.
    What is no walk keeps its speed. Where the clip begins or ends within a step, the step's warp is cut off there.
    """
    times = np.arange(motion.n_frames) / float(motion.rate)
    log_speed = np.zeros(motion.n_frames)
    halves = cycles(motion)
    spans = [(a.time, b.time, a.side) for a, b in halves]
    if halves:
        usual = float(np.mean([b.time - a.time for a, b in halves]))
        first, last = halves[0][0], halves[-1][1]
        if first.time < usual:
            spans.append((first.time - usual, first.time, "right" if first.side == "left" else "left"))
        if motion.end_time - last.time < usual:
            spans.append((last.time, last.time + usual, last.side))
    for start, end, side in spans:
        inside = (times >= start) & (times < end)
        sign = 1.0 if side == "left" else -1.0
        log_speed[inside] = sign * math.log(strength) * np.sin(np.pi * (times[inside] - start) / (end - start))
    return from_log_speed(log_speed, motion)


def slow_flights(motion: Motion, *, speed: float = 0.5, ramp: float = 0.1) -> Warp:
    """Play every flight at `speed`, with a smooth change in the `ramp` seconds before and after it."""
    times = np.arange(motion.n_frames) / float(motion.rate)
    log_speed = np.zeros(motion.n_frames)
    for start, end in flight_spans(motion):
        inside = np.clip(np.minimum(times - (start - ramp), (end + ramp) - times) / ramp, 0.0, 1.0)
        log_speed = np.minimum(log_speed, math.log(speed) * inside * inside * (3 - 2 * inside))
    return from_log_speed(log_speed, motion)


def weaken(motion: Motion, joints: Sequence[str], *, share: float = 0.5) -> Warp:
    """Take the force out of blows, and keep the length: what is fast becomes slower, what is slow faster.

    The faster of the `joints`, going at v, is played at (v / median v) to the power of - `share`, between 0.45 and 2.2,
    all scaled to the length of the input. A `share` below 0 gives blows force instead.
    """
    smooth = fastest_joint(motion, joints)
    log_speed = -share * np.log(np.maximum(smooth, 1e-9) / np.median(smooth))
    warp = from_log_speed(np.clip(log_speed, math.log(0.45), math.log(2.2)), motion)
    return replace(warp, output_times=warp.output_times * (motion.end_time / warp.output_end))


def from_log_speed(log_speed: FloatArray, motion: Motion) -> Warp:
    """Make the warp that plays each input frame at a speed; knots at the frames."""
    slowness = np.exp(-log_speed)
    output_times = np.concatenate([[0.0], np.cumsum((slowness[1:] + slowness[:-1]) / 2)]) / float(motion.rate)
    return Warp(output_times, np.arange(motion.n_frames) / float(motion.rate), method="hand")


def part_of(warp: Warp, start: float, end: float) -> Warp:
    """Cut out what a forward warp does with a stretch of its input; both times then count from its start."""
    inside = (warp.input_times > start) & (warp.input_times < end)
    back = warp.inverse()
    first, last = float(back(start)), float(back(end))
    return Warp(
        np.concatenate([[0.0], warp.output_times[inside] - first, [last - first]]),
        np.concatenate([[0.0], warp.input_times[inside] - start, [end - start]]),
        method=warp.method,
    )


def example_of(motion: Motion, truth: Warp, start: float, end: float) -> Motion:
    """Retime the stretch of a motion from `start` to `end` (input times, seconds) as the truth does.

    Not averaged where fast: a reference is looked at, not shown.
    """
    rate = float(motion.rate)
    first, last = frames_of(motion, start, end)
    stretch = replace(motion.frames(first, last + 1), first_frame=0, name=f"{motion.name}, by hand")
    return apply_warp(stretch, part_of(truth, first / rate, last / rate), average=False)


def frames_of(motion: Motion, start: float, end: float) -> tuple[int, int]:
    """Round two input times to frames."""
    return round(start * float(motion.rate)), round(end * float(motion.rate))
