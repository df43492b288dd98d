"""A warp in frames of a scene: beyond its ends, through a strip of the NLA, and backward from input to output.

bpy is not needed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.warp.curve import Warp


@dataclass(frozen=True)
class Line:
    """A straight way from one count of frames to another: ``inner = start + speed * (outer - at)``.

    What an NLA strip makes of scene frames: `outer` is the scene's, `inner` the action's.
    """

    at: float = 0.0
    start: float = 0.0
    speed: float = 1.0

    def inner(self, outer: FloatArray | float) -> FloatArray:
        """Return the action's frames at the scene's."""
        return np.asarray(self.start + self.speed * (np.asarray(outer, dtype=np.float64) - self.at))

    def outer(self, inner: FloatArray | float) -> FloatArray:
        """Return the scene's frames at the action's."""
        return np.asarray(self.at + (np.asarray(inner, dtype=np.float64) - self.start) / self.speed)


@dataclass(frozen=True)
class Timing:
    """New timing for a range of frames; what lies after the range moves along with its end.

    Attributes
    ----------
    warp : Warp
        From output frame to input frame, within the range: `start` shows what it showed.
    rate : float
        Frames a second of the scene.
    """

    warp: Warp
    rate: float

    @classmethod
    def of_seconds(cls, warp: Warp, start: float, rate: float) -> Timing:
        """Take a warp in seconds, from the first frame of the range at `start`; its keytimes stay what they are."""
        keys = [(start + key.input_time * rate, start + key.output_time * rate) for key in warp.keytimes]
        return cls(Warp(start + warp.output_times * rate, start + warp.input_times * rate, keys), rate)

    @property
    def start(self) -> float:
        """First frame of the range, of input and output."""
        return self.warp.output_start

    @property
    def end(self) -> float:
        """Last output frame of the range."""
        return self.warp.output_end

    @property
    def input_end(self) -> float:
        """The input frame that the output ends with."""
        return float(self.warp.input_times[-1])

    def simplified(self, tolerance: float) -> Timing:
        """Return the timing with fewer knots, at most `tolerance` frames off: each knot becomes a key."""
        return Timing(self.warp.simplify(tolerance), self.rate)

    def reaching(self, first: float, last: float) -> Warp:
        """Return the warp as far as some input frames: as it was before the range, later or sooner after it."""
        begin = float(self.warp.input_times[0])
        before, after = max(0.0, begin - first) + 1.0, max(0.0, last - self.input_end) + 1.0
        return Warp(
            np.concatenate([[self.start - before], self.warp.output_times, [self.end + after]]),
            np.concatenate([[begin - before], self.warp.input_times, [self.input_end + after]]),
        )

    def moved(self, frame: float) -> float:
        """Return the output frame that first shows an input frame; of one that is never shown, that of the nearest."""
        warp = self.reaching(frame, frame)
        low = np.minimum(warp.input_times[:-1], warp.input_times[1:])
        high = np.maximum(warp.input_times[:-1], warp.input_times[1:])
        # Which pieces pass it; rounding must not make the last knot miss it.
        passed = np.flatnonzero((low <= frame + 1e-9) & (frame <= high + 1e-9))
        if not len(passed):
            return float(warp.output_times[int(np.argmin(np.abs(warp.input_times - frame)))])
        piece = int(passed[0])
        a, b = warp.input_times[piece : piece + 2]
        t, u = warp.output_times[piece : piece + 2]
        share = 0.0 if a == b else min(1.0, max(0.0, (frame - a) / (b - a)))
        return float(t + share * (u - t))

    def frames(self) -> FloatArray:
        """Return the whole output frames of the range, both ends included."""
        return np.arange(np.ceil(self.start - 1e-6), np.floor(self.end + 1e-6) + 1)

    def in_seconds(self) -> Warp:
        """Return the warp in seconds from the start of the range."""
        return Warp((self.warp.output_times - self.start) / self.rate, (self.warp.input_times - self.start) / self.rate)
