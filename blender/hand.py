"""What a hand did to the timing of a stretch: read from its keys before and after. bpy is not needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.errors import OptionError
from retime.warp.curve import Warp

# Frames. Keys that moved less lie where they were.
_MOVED = 0.01


@dataclass(frozen=True)
class HandTiming:
    """A stretch that was retimed by hand.

    Attributes
    ----------
    start, end : float
        Its first and last frame, before.
    warp : Warp
        From output frame to input frame; it begins at `start`, whatever came before.
    """

    start: float
    end: float
    warp: Warp


def hand_timing(
    before: Mapping[Any, tuple[FloatArray, FloatArray]], after: Mapping[Any, tuple[FloatArray, FloatArray]]
) -> HandTiming:
    """Read a hand's timing from the keys of the same curves before and after.

    Parameters
    ----------
    before, after : mapping from a curve's name to (frames, values)
        Keys in order. Only curves that have as many keys, with the same values, on both sides say something.

    Returns
    -------
    HandTiming
        From the first gap between keys that has another length to the last.

    Raises
    ------
    OptionError
        No key was moved, or keys of one frame were moved to several.
    """
    pairs: dict[float, list[float]] = {}
    for curve in before.keys() & after.keys():
        (old, was), (new, now) = before[curve], after[curve]
        if len(old) == len(new) and np.allclose(was, now, rtol=1e-4, atol=1e-5):
            for a, b in zip(old.tolist(), new.tolist(), strict=True):
                pairs.setdefault(round(a, 2), []).append(b)
    frames = np.array(sorted(pairs))
    for frame in frames:
        if np.ptp(pairs[frame]) > 0.5:
            raise OptionError(
                f"the keys of frame {frame:g} were moved to frames {min(pairs[frame]):g} to {max(pairs[frame]):g}: "
                "move all keys of a frame together",
                option="before",
            )
    to = np.array([np.mean(pairs[frame]) for frame in frames])
    changed = np.flatnonzero(np.abs(np.diff(to) - np.diff(frames)) > _MOVED) if len(frames) else np.zeros(0, int)
    if not len(changed):
        raise OptionError(
            "no keys were moved: in the action before, and in the one now, the same keys must lie at other frames",
            option="before",
        )
    used = slice(int(changed[0]), int(changed[-1]) + 2)
    return _timing(frames[used], to[used])


def keyed_timing(keytimes: Sequence[tuple[float, float]], start: float, end: float) -> HandTiming:
    """Take the keytimes (input frame, output frame) from `start` to `end` for a hand's timing.

    Raises
    ------
    OptionError
        There are fewer than two.
    """
    chosen = sorted(pair for pair in keytimes if start <= pair[0] <= end)
    if len(chosen) < 2:
        raise OptionError(
            f"between frames {start:g} and {end:g} there are {len(chosen)} keytimes: two or more say how a stretch was "
            "retimed",
            option="keys",
        )
    frames, to = np.array(chosen, dtype=np.float64).T
    return _timing(frames, to)


def _timing(frames: FloatArray, to: FloatArray) -> HandTiming:
    if (np.diff(to) <= 0).any():
        at = int(np.flatnonzero(np.diff(to) <= 0)[0])
        raise OptionError(
            f"frame {frames[at + 1]:g} was moved to {to[at + 1]:g}, which is not after frame {frames[at]:g}'s "
            f"{to[at]:g}: keys must stay in order",
            option="keys",
        )
    return HandTiming(float(frames[0]), float(frames[-1]), Warp(to - to[0] + frames[0], frames))
