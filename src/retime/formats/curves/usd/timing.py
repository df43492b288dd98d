"""A warp on a scene's clock, and what it makes of the time samples of an attribute. Runs in the child (`usd.child`).

A time sample is a key: between two of them USD goes straight (rotations along the shortest arc), or holds, where a
type knows no between. So what is cut is one curve for each attribute, of the time that it shows; a value is then that
of a sample, to the bit, or what USD itself finds between two.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np
from pxr import Sdf

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.formats.curves.usd.animation import Span, as_row, span_of
from retime.formats.curves.usd.layers import Clock
from retime.formats.curves.usd.stage import Scene
from retime.formats.read_options import Limits
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp, output_frame_times
from retime.warp.cutting import CurveSegments, SegmentKind, cut_curve
from retime.warp.moments import output_moments

# Types that USD goes through between two samples; all others it holds.
_BETWEEN = re.compile(r"float|(Vec[234][hfd]|Matrix[234][fd]|Quat[hfd]|Half|Float|Double|TimeCode)(Array)?")
_QUATERNION = re.compile(r"Quat[hfd](Array)?")
# Time codes before a jump at which the value that it leaves is said once more.
_JUST_BEFORE = 1e-8
# Beyond this, a time says that there is none (an end that is never).
_MOST_SECONDS = 1e9
Samples = list[tuple[float, Any]]


@dataclass(frozen=True)
class Track:
    """The time samples of one attribute.

    Attributes
    ----------
    codes : float array, shape (n,)
        Where they lie, time codes.
    values : list
        What they are; None where the value is blocked.
    at : function
        What USD finds at a time code.
    """

    codes: FloatArray
    values: list[Any]
    at: Callable[[float], Any]

    __repr__ = brief_repr

    def sample_at(self, code: float) -> int | None:
        """Find the sample at a time code; of two that a jump has put side by side, the nearer one."""
        place, n = int(np.searchsorted(self.codes, code)), len(self.codes)
        nearest = min((place, place - 1), key=lambda one: abs(self.codes[one] - code) if 0 <= one < n else np.inf)
        return nearest if abs(self.codes[nearest] - code) <= 1e-9 * max(1.0, abs(code)) else None

    def shown(self, code: float) -> Any:
        """Return the value at a time code; that of a sample as it is."""
        place = self.sample_at(code)
        return self.at(code) if place is None else self.values[place]

    def differs(self, a: float, b: float) -> bool:
        """Tell whether two time codes are far apart, or so near as a jump puts two samples, and are these."""
        places = self.sample_at(a), self.sample_at(b)
        return abs(a - b) > _JUST_BEFORE or (None not in places and places[0] != places[1])


@dataclass(frozen=True)
class Timing:
    """A warp on a scene's clock.

    Attributes
    ----------
    warp : Warp
        Seconds from the scene's start.
    span : Span
        The scene's clock.
    linear : bool
        Whether the scene's values are interpolated, not held.
    """

    warp: Warp
    span: Span
    linear: bool

    def seconds(self, codes: FloatArray) -> FloatArray:
        """From time codes of the scene to seconds from its start."""
        return (codes - self.span.start) / self.span.per_second

    def code(self, seconds: float) -> float:
        """Make the reverse, without the digits that are rounding."""
        code = self.span.start + float(seconds) * self.span.per_second
        return round(code, 9) if abs(code) < 1e6 else float(f"{code:.15g}")

    @property
    def codes(self) -> tuple[FloatArray, FloatArray]:
        """The warp's knots as time codes: where they are put, and what is shown there."""
        outs = np.array([self.code(one) for one in self.warp.output_times])
        return outs, np.array([self.code(one) for one in self.warp.input_times])

    @property
    def end(self) -> float:
        """The new endTimeCode."""
        return self.code(self.warp.output_end)

    def moment(self, code: float) -> float:
        """Return the time code at which what was there at one is first shown."""
        if not abs(code - self.span.start) / self.span.per_second < _MOST_SECONDS:
            return code
        return self.code(float(output_moments(self.warp, self.seconds(np.array([code])))[0]))

    def moved(self, value: Any) -> Any:
        """Return what a value is with the new timing: one that says a time says another, any other is as it was."""
        if isinstance(value, Sdf.TimeCode):
            return Sdf.TimeCode(self.moment(float(value)))
        if isinstance(value, Sdf.TimeCodeArray):
            return Sdf.TimeCodeArray([self.moment(float(one)) for one in value])
        return value

    def cut(self, codes: FloatArray, straight: list[bool]) -> CurveSegments:
        """Cut the curve of the time that is shown; seconds. Where not straight, it stays at a sample."""
        times = self.seconds(codes)
        curve = CurveSegments.through(times, times[:, None], SegmentKind.LINEAR)
        held = ~np.array(straight, dtype=bool)
        curve.kinds[held] = SegmentKind.STEP
        curve.values[held] = curve.values[held, :1]
        return cut_curve(curve, self.warp)[0]

    def retimed(self, track: Track) -> Samples:
        """Return the samples that show a track with the new timing."""
        kinds = [self.goes_between(a, b) for a, b in pairwise(track.values)]
        curve = self.cut(track.codes, kinds)
        nexts = np.append(curve.values[1:, 0, 0], curve.end_value[0])
        found: dict[float, Any] = {}
        for i in range(len(curve)):
            start, end = self.code(curve.times[i, 0]), self.code(curve.times[i, 3])
            first = track.shown(self.code(curve.values[i, 0, 0]))
            if start == end:
                # A jump that was said by two samples, and they are one now: again two.
                found[just_before(end, by=_JUST_BEFORE)] = first
                continue
            found[start] = first
            held = curve.kinds[i] == SegmentKind.STEP
            last = first if held else track.shown(self.code(curve.values[i, 3, 0]))
            jumps = track.differs(self.code(curve.values[i, 3, 0]), self.code(nexts[i]))
            # What held on is held until the jump anyway, where USD doesn't go from here to there.
            if jumps and not (held and not self.goes_between(last, track.shown(self.code(nexts[i])))):
                found[max(just_before(end, by=_JUST_BEFORE), float(np.nextafter(start, end)))] = last
        found[self.code(curve.end_time)] = track.shown(self.code(curve.end_value[0]))
        return sorted(found.items())

    def goes_between(self, a: Any, b: Any) -> bool:
        """Tell whether USD goes from one value to another, rather than to hold the first."""
        if not self.linear or type(a) is not type(b) or not _BETWEEN.fullmatch(type(a).__name__):
            return False
        return not type(a).__name__.endswith("Array") or len(a) == len(b)

    def baked(
        self, track: Track, rate: Fraction, average: bool, limits: Limits, means: FloatArray | None = None
    ) -> Samples:
        """Return a sample for every output frame; averages over a few frames where sped up.

        `means` are these, a row each, where they are known.
        """
        times = output_frame_times(self.warp, float(rate))
        outs = [self.code(time) for time in times]
        plain = [track.shown(self.code(time)) for time in self.warp(times)]
        if average and self.linear and self.speeds_up:
            means = self._means(track, rate, limits) if means is None else means
            sizes = {None if value is None else np.size(np.array(value)) for value in plain}
            if means is not None and means.shape[0] == len(plain) and sizes == {means.shape[1]}:
                plain = [_typed(row, value) for row, value in zip(means, plain, strict=True)]
        return list(zip(outs, plain, strict=True))

    @property
    def speeds_up(self) -> bool:
        """Whether anything is faster than life."""
        return float(np.abs(self.warp.slopes).max()) > 1

    def _means(self, track: Track, rate: Fraction, limits: Limits) -> FloatArray | None:
        """Average a track; None where its values are no numbers that can be."""
        length = (self.span.end - self.span.start) / self.span.per_second
        n_frames = int(np.ceil(float(rate) * length - 1e-3)) + 1
        if not all(self.goes_between(a, b) for a, b in pairwise(track.values)):
            return None
        values = [track.shown(self.code(frame / float(rate))) for frame in range(n_frames)]
        make = as_row(values[0])
        if make is None or n_frames * len(make(values[0])) * 16 > limits.inflated_bytes:
            return None
        rows = np.stack([make(value) for value in values])
        if not rows.size or not np.isfinite(rows).all():
            return None
        if not _QUATERNION.fullmatch(type(values[0]).__name__):
            return apply_warp(rows, self.warp, average=True, rate=rate)
        names = [f"q{i // 4}.{'xyzw'[i % 4]}" for i in range(rows.shape[1])]
        if (np.linalg.norm(rows.reshape(-1, 4), axis=1) < 1e-6).any():
            return None
        signal = Signal(tuple(names), rows, rate=rate, kinds=["quaternion"] * len(names))
        return apply_warp(signal, self.warp, average=True).values


def _typed(row: FloatArray, like: Any) -> Any:
    """Make a value of a type of numbers, laid out as `as_row` does."""
    kind = type(like)
    if isinstance(like, float):
        return float(row[0])
    if kind.__name__.endswith("Array"):
        old = np.array(like)
        return kind.FromNumpy(row.reshape(old.shape).astype(old.dtype))
    numbers = [float(number) for number in row]
    if hasattr(like, "GetImaginary"):
        return kind(numbers[3], *numbers[:3])
    return kind(*numbers)


def timing_of(scene: Scene, warp: Warp) -> Timing:
    """Lay a warp on a scene's clock."""
    return Timing(warp, span_of(scene), True)


def on_clock(timing: Timing, clock: Clock) -> Timing:
    """Lay a timing on the clock of a layer."""
    span, (offset, scale) = timing.span, clock
    start, end = (span.start - offset) / scale, (span.end - offset) / scale
    return replace(timing, span=Span(start, end, span.per_second / scale, span.keys))


def just_before(code: float, *, by: float) -> float:
    """Return a time code that is less by so much, or by the least that its digits allow."""
    return min(code - by, float(np.nextafter(code, -np.inf)))
