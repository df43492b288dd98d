"""Flights by definition: one frame after another."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from retime.motion.contacts import contacts
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion


def flights(motion: Motion, *, clearance: float = 0.03, minimum: float = 0.06) -> list[tuple[int, int]]:
    rate, n_frames = float(motion.rate), motion.n_frames
    frames = range(n_frames)
    metres = metres_per_unit(motion)
    poses = global_poses(motion)
    lowest, mean = [], []
    for frame in frames:
        joints = [float(place[1]) * metres for place in poses.positions[frame]]
        ends = [float(place[1]) * metres for place in poses.end_positions[frame]]
        lowest.append(min(joints + ends))
        mean.append(sum(joints) / len(joints))
    lags = [max(1, round(rate / 20)), max(1, round(rate / 30))]
    if n_frames <= max(lags):
        return []

    def height(frame: int) -> float:
        # Beyond either end the height goes on as it came, turned about the end.
        if frame < 0:
            return 2 * mean[0] - mean[-frame]
        if frame >= n_frames:
            return 2 * mean[-1] - mean[2 * (n_frames - 1) - frame]
        return mean[frame]

    def acceleration(frame: int, lag: int) -> float:
        return (height(frame + lag) - 2 * height(frame) + height(frame - lag)) * (rate / lag) ** 2

    reach = max(1, round(0.75 * rate))
    stands = contacts(motion).at_rest
    clear = [lowest[f] - min(lowest[max(0, f - reach) : f + reach + 1]) for f in frames]
    off = [clear[f] > 0.02 and not (any(stands[f]) and clear[f] < 0.1) for f in frames]
    falls = [off[f] and min(acceleration(f, lag) for lag in lags) < -9.81 / 2 for f in frames]
    free = [off[f] and acceleration(f, lags[1]) < 9.81 / 4 for f in frames]
    hidden = round(0.06 * rate)

    def most_fall(low: int, high: int) -> bool:
        seconds = [(frame - low) / rate for frame in range(low, high + 1)]
        bends = []
        for joint in range(motion.skeleton.n_joints):
            there = [float(poses.positions[frame, joint, 1]) * metres for frame in range(low, high + 1)]
            bends.append(2 * float(np.polyfit(seconds, there, 2)[0]))
        return float(np.median(bends)) < -9.81 / 2

    # Every fall long enough, widened.
    spans: list[tuple[int, int]] = []
    for first in frames:
        if not falls[first] or (first > 0 and falls[first - 1]):
            continue
        last = first
        while last + 1 < n_frames and falls[last + 1]:
            last += 1
        if last - first + 1 < max(1.0, 0.02 * rate):
            continue
        low, high = first, last
        while low > 0 and free[low - 1] and first - low < hidden:
            low -= 1
        while high + 1 < n_frames and free[high + 1] and high - last < hidden:
            high += 1
        # Near the one before, with nothing that touches between them: the same flight.
        if spans and low - spans[-1][1] - 1 <= hidden and all(off[spans[-1][1] : low]):
            spans[-1] = (spans[-1][0], high)
        else:
            spans.append((low, high))
    return [
        (low, high)
        for low, high in spans
        if high - low + 1 >= max(2.0, minimum * rate)
        and max(clear[low : high + 1]) > clearance
        and sum(falls[low : high + 1]) >= (high - low + 1) / 2
        and (high - low + 1 < max(4.0, 0.2 * rate) or most_fall(low, high))
    ]


def within(times: Iterable[float], spans: Sequence[tuple[float, float]], margin: float) -> list[bool]:
    slack = margin + 1e-9
    return [any(start - slack <= time <= end + slack for start, end in spans) for time in times]
