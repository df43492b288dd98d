"""The same motion at another rate, or in steps: its timing stays."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TypeVar

import numpy as np

from retime.arrays import IntArray
from retime.brief import kind_of
from retime.checks import whole
from retime.errors import OptionError
from retime.motion.any_motion import AnyMotion
from retime.motion.motion import Motion
from retime.motion.rate import RateLike, parse_rate
from retime.motion.signal import Signal
from retime.warp.size import refuse_too_large

Shown = TypeVar("Shown", Motion, Signal)

_LONGEST_STEP = 1000


def resample(motion: Shown, rate: RateLike | None = None, *, on: int = 1) -> Shown:
    """Show a clip at another rate, or hold its poses for several frames, with its own timing.

    Frames stand at whole multiples of the new period, from the first frame up to the time of the last one. So a clip
    neither slows down nor speeds up, whatever the rates: 816 frames at 60 Hz end at 815/60 s, and become 327 at 24 Hz,
    which end at 326/24 s, the same time. Where the end lies between two new frames, the last one comes before it.

    Parameters
    ----------
    motion : Motion or Signal
        The clip.
    rate : Fraction, number or str
        Frames a second of the result: 24, 29.97, ``"24000/1001"``. Left out, the clip's own.
    on : int
        How many frames each pose is held: 2 is "on twos", as drawn animation is. Events and clocks of a signal are not
        held.

    Returns
    -------
    Motion or Signal, as `motion` is
        The clip at that rate. Frames that both rates have are the clip's own, bit for bit.

    Raises
    ------
    OptionError
        Not a clip, no rate, or no whole number of frames to hold; or more than a thousand frames for each of the
        clip's, and many.

    Examples
    --------
    >>> ramp = Signal(("x",), np.arange(5.0)[:, None], 4)
    >>> resample(ramp, 6).values[:, 0].round(3).tolist()
    [0.0, 0.667, 1.333, 2.0, 2.667, 3.333, 4.0]
    >>> resample(ramp, on=2).values[:, 0].tolist()
    [0.0, 0.0, 2.0, 2.0, 4.0]
    """
    if not isinstance(motion, AnyMotion):
        raise OptionError(f"expected resample(clip, rate) with a motion or a signal; found {kind_of(motion)}")
    shown: Shown = motion
    if rate is not None and (new := parse_rate(rate)) != motion.rate:
        n_frames = math.floor((motion.n_frames - 1) * new / motion.rate) + 1
        refuse_too_large(motion, n_frames, asks=f"Is {float(motion.rate):.3g} Hz, the clip's own rate, right (--fps)?")
        # In whole numbers up to the last division: far into a clip sums of periods would drift.
        times = np.arange(n_frames) * new.denominator / new.numerator
        first_frame = round(motion.first_frame * new / motion.rate)
        shown = replace(motion.at(times), rate=new, first_frame=first_frame)
    return held(shown, on)


def held(motion: Shown, on: int) -> Shown:
    """Hold each `on`-th pose until the next; raise OptionError where that is no whole number from 1 to 1000."""
    n_held = whole(on, "the number of frames that a pose is held")
    if not 1 <= n_held <= _LONGEST_STEP:
        raise OptionError(f"a pose is held for 1 to {_LONGEST_STEP} frames, found {on}")
    if n_held == 1:
        return motion
    frames: IntArray = np.arange(motion.n_frames) // n_held * n_held
    shown = replace(motion.at(frames / float(motion.rate)), first_frame=motion.first_frame)
    if isinstance(shown, Signal) and isinstance(motion, Signal):
        values = shown.values.copy()
        for place, kind in enumerate(motion.kinds):
            if kind.kind in ("event", "time"):
                values[:, place] = motion.values[:, place]
        return replace(shown, values=values)
    return shown
