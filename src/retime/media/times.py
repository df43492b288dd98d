"""Which input frames an output frame shows, and with what weights. Arithmetic alone; opens nothing.

Places between frames are counted in frames of the input, also where these are not evenly spaced: place 3.5 is halfway
between the times of frames 3 and 4. What is slowed down is sampled at its place (the nearest frame, a blend, or one
made by optical flow); what is sped up is averaged over the frames that it passes, as motions are (§3.4): the mean of
the line through the frames, over a window as long as what passes in one output frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.brief import brief_repr
from retime.errors import OptionError
from retime.limits import MOST_FRAMES
from retime.warp.curve import Warp

FrameMode = Literal["nearest", "blend", "flow"]

# Places this near to a frame are that frame: what rounding leaves of exact times.
_AT_FRAME = 1e-5


@dataclass(frozen=True, eq=False)
class FrameTimes:
    """When the frames of a stream are shown.

    Parameters
    ----------
    stamps : int array, shape (n_frames,)
        Increasing, in ticks of `base`.
    base : Fraction
        Seconds a tick.
    rate : Fraction
        Frames a second: exactly, where they are evenly spaced, else their mean.
    even : bool
        Whether they are evenly spaced, rounding to ticks aside.
    """

    stamps: IntArray
    base: Fraction
    rate: Fraction
    even: bool

    __repr__ = brief_repr

    @property
    def seconds(self) -> FloatArray:
        """Times after the first frame."""
        if self.even:
            # The rate is exact, where stamps may be rounded to a clock's ticks.
            return np.asarray(np.arange(len(self.stamps)) / float(self.rate))
        return np.asarray((self.stamps - self.stamps[0]) * float(self.base))

    def places(self, times: FloatArray) -> FloatArray:
        """Return where times (seconds) lie among the frames; before the first and after the last, at those."""
        seconds = self.seconds
        return np.asarray(np.interp(times, seconds, np.arange(len(seconds), dtype=np.float64)))


@dataclass(frozen=True, eq=False)
class FramePlan:
    """What each output frame shows.

    Attributes
    ----------
    stamps : int array, shape (n_output,)
        When it is shown after the output's start, in ticks of `base`.
    base : Fraction
        Seconds a tick.
    rate : Fraction
        Frames a second of the output, or their mean.
    end : int
        When the last frame ends, in ticks.
    places : float array, shape (n_output,)
        Where it lies among the input's frames.
    halves : float array, shape (n_output,)
        Half-widths of the windows that are averaged, in input frames; 0 where nothing is.
    mode : str
        How places between frames are shown.
    """

    stamps: IntArray
    base: Fraction
    rate: Fraction
    end: int
    places: FloatArray
    halves: FloatArray
    mode: FrameMode

    __repr__ = brief_repr

    def shown(self, frame: int, n_input: int) -> tuple[IntArray, FloatArray]:
        """Return the input frames that an output frame is made of, and their weights, which sum to 1."""
        return weights_at(float(self.places[frame]), float(self.halves[frame]), n_input, self.mode)


def weights_at(place: float, half: float, n_input: int, mode: FrameMode) -> tuple[IntArray, FloatArray]:
    """Return the frames that a place, or a window around it, is made of, and their weights.

    Parameters
    ----------
    place, half : float
        The middle of the window and its half-width, in frames.
    n_input : int
        Frames of the input.
    mode : {"nearest", "blend", "flow"}
        With "nearest" whole frames are averaged, all alike: those whose time lies in the window.

    Returns
    -------
    (int array, float array)
        Increasing frames, and weights above 0 that sum to 1.
    """
    last = n_input - 1
    # Half way goes up, rounding aside.
    near = int(min(max(np.floor(place + 0.5 + _AT_FRAME), 0), last))
    if half <= 0:
        if mode == "nearest" or abs(place - near) < _AT_FRAME:
            return np.array([near]), np.ones(1)
        before = int(np.clip(np.floor(place), 0, last - 1)) if last else 0
        share = min(max(place - before, 0.0), 1.0)
        return np.array([before, min(before + 1, last)]), np.array([1 - share, share])
    if mode == "nearest":
        # The window of a frame's own length is the shortest, so that there always is a frame in it.
        first = int(np.ceil(place - half - 0.5 - _AT_FRAME))
        stop = int(np.ceil(place + half + 0.5 - _AT_FRAME))
        frames = np.arange(max(first, 0), min(max(stop, first + 1), n_input))
        if not len(frames):
            frames = np.array([near])
        return frames, np.full(len(frames), 1 / len(frames))
    low, high = place - half, place + half
    frames = np.arange(max(int(np.floor(low)), 0), min(int(np.ceil(high)), last) + 1)
    # The areas, inside the window, of hats that stand on the frames; beyond the ends the last frame goes on.
    a, b = (np.clip(np.clip(edge, 0, last) - frames, -1.0, 1.0) for edge in (low, high))
    left, right = np.minimum(b, 0) - np.minimum(a, 0), np.maximum(b, 0) - np.maximum(a, 0)
    areas = left * (1 + (np.minimum(a, 0) + np.minimum(b, 0)) / 2) + right * (
        1 - (np.maximum(a, 0) + np.maximum(b, 0)) / 2
    )
    areas[0] += max(0.0, min(high, 0.0) - low)
    areas[-1] += max(0.0, high - max(low, float(last)))
    kept = areas > 1e-9
    return frames[kept], areas[kept] / areas[kept].sum()


def plan_frames(
    frames: FrameTimes,
    warp: Warp,
    *,
    offset: float = 0.0,
    rate: Fraction | Literal["variable"] | None = None,
    mode: FrameMode = "blend",
    shutter: float = 1.0,
) -> FramePlan:
    """Plan the frames of an output.

    Parameters
    ----------
    frames : FrameTimes
        Of the input.
    warp : Warp
        From output time to input time.
    offset : float
        Seconds after the warp's input time 0 at which the input's first frame is shown.
    rate : Fraction, "variable" or None
        Frames a second of the output. "variable" shows each input frame when the warp comes to it, no closer together
        than input frames come; None is the input's own rate, "variable" where that varies.
    mode : {"nearest", "blend", "flow"}
        How places between input frames are shown.
    shutter : float
        Which share of the frames that an output frame passes is averaged, from 0 (none) to 1.

    Returns
    -------
    FramePlan

    Raises
    ------
    OptionError
        More frames than any clip may have.
    """
    if rate is None:
        rate = frames.rate if frames.even else "variable"
    if rate == "variable":
        moments, closest = _visits(frames, warp, offset)
        base = _fine_base(frames)
        stamps = np.round((moments - warp.output_start) / float(base)).astype(np.int64)
        kept = _apart(stamps, max(1, round(closest / float(base) * 0.999)))
        stamps = stamps[kept]
        moments = np.asarray(warp.output_start + stamps * float(base), np.float64)
        # The last frame is shown for as long as most are: by a mean one stamp that is far off would make it hours.
        gaps = np.diff(frames.seconds)
        last = float(np.median(gaps)) if len(gaps) else 1 / float(frames.rate)
        end = max(round(warp.output_span / float(base)), int(stamps[-1])) + max(1, round(last / float(base)))
        shown = Fraction(len(stamps)) / (end * base)
        # Of frames that would come too close together some are left out: those are averaged with their neighbours.
        around = np.concatenate([kept[:1] - 1, kept, kept[-1:] + 1])
        passed = (around[2:] - around[:-2]) / 2
    else:
        count = warp.count_frames(rate)
        stamps, base, end, shown = np.arange(count), 1 / rate, count, rate
        moments = warp.output_start + stamps / float(rate)
        period = 1 / float(rate)
        before = np.maximum(moments - period / 2, warp.output_start)
        after = np.minimum(moments + period / 2, warp.output_end)
        travel = np.abs(frames.places(warp(after) - offset) - frames.places(warp(before) - offset))
        with np.errstate(invalid="ignore", divide="ignore"):
            passed = np.where(after > before, travel * period / (after - before), 0.0)
    places = frames.places(warp(moments) - offset)
    halves = np.zeros(len(places))
    if shutter > 0:
        halves[:] = np.maximum(shutter * passed - 1, 0.0) / 2
        # As of a motion, the window closes at the ends, whose frames stay.
        halves = np.minimum(halves, np.minimum(places, len(frames.stamps) - 1 - places))
        halves[halves < _AT_FRAME] = 0.0
    return FramePlan(stamps, base, shown, int(end), places, halves, mode)


def _fine_base(frames: FrameTimes) -> Fraction:
    """Return ticks fine enough for times that a warp makes."""
    return frames.base if frames.base <= Fraction(1, 10_000) else Fraction(1, 90_000)


def _visits(frames: FrameTimes, warp: Warp, offset: float) -> tuple[FloatArray, float]:
    """Return the output times at which the warp comes to an input frame, and how close together frames may be.

    Its own ends are among them: of a hold at the end nothing else would say how long it is, for many formats know no
    more of a frame's length than when the next one begins.
    """
    seconds = frames.seconds + offset
    found = [np.array([warp.output_start])]
    for t0, t1, w0, w1 in zip(
        warp.output_times[:-1], warp.output_times[1:], warp.input_times[:-1], warp.input_times[1:], strict=True
    ):
        if w0 == w1:
            continue
        first, stop = np.searchsorted(seconds, [min(w0, w1), max(w0, w1)])
        inside = seconds[first : min(stop + 1, len(seconds))]
        inside = inside[(inside >= min(w0, w1)) & (inside <= max(w0, w1))]
        moments = t0 + (inside - w0) / (w1 - w0) * (t1 - t0)
        found.append(moments if w1 > w0 else moments[::-1])
        if sum(map(len, found)) > MOST_FRAMES:
            raise OptionError(f"the output has more than {MOST_FRAMES} frames. Is it the warp of another clip?")
    found.append(np.array([warp.output_end]))
    gaps = np.diff(seconds)
    moments = np.concatenate(found)
    # Where pieces meet both have the frame that is shown there.
    moments = moments[np.append(True, np.diff(moments) > 1e-9)]
    return moments, float(gaps.min()) if len(gaps) else 1 / float(frames.rate)


def _apart(stamps: IntArray, least: int) -> IntArray:
    """Choose stamps that are at least so far apart, the first among them; their numbers."""
    kept = [0]
    for number, stamp in enumerate(stamps.tolist()):
        if stamp - stamps[kept[-1]] >= least:
            kept.append(number)
    return np.array(kept, dtype=np.int64)
