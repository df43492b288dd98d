"""Where a time lies between frames, in exact arithmetic, one time after another."""

from __future__ import annotations

from fractions import Fraction


def frame_place(input_time: float, rate: Fraction, n_frames: int) -> Fraction:
    """Count the frames before a time, exactly; a time outside the motion is at its nearer end."""
    place = Fraction(input_time) * rate
    return min(max(place, Fraction(0)), Fraction(n_frames - 1))
