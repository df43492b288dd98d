"""Propagation: a stretch of a clip is retimed by hand, and the rest of the clip follows (§4.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from retime.brief import kind_of
from retime.errors import OptionError
from retime.motion.any_motion import AnyMotion
from retime.motion.signal import Signal
from retime.search.grid import DEFAULT_MAX_SKIP, usual_upsample
from retime.search.guided import guided_warp
from retime.search.poses.references import Reference
from retime.search.result import GuidedWarp
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp, WarpLike, as_warp

# Options of guided_warp that need speeds of their own, or say which.
_BOUND_SPEEDS = ("speed", "upsample", "max_skip", "keys", "locks", "min_length", "max_length")
# The table of scores grows with the square of max_skip.
_MOST_UPSAMPLE, _MOST_SKIP = 16, 48


def imitate(
    motion: AnyMotion,
    example: tuple[int, int],
    hand: WarpLike,
    *,
    length: str | float | None = "free",
    **options: Any,
) -> GuidedWarp:
    """Find the warp that gives a whole clip the timing that a stretch of it was given by hand.

    The stretch, retimed, is the reference; the clip then moves like it. Its frames are not averaged where the hand's
    warp is fast: the reference is looked at, not shown. Where nothing else bounds them, the search is offered the
    hand's speeds.

    Parameters
    ----------
    motion : Motion or Signal
        The input.
    example : (int, int)
        The stretch: first frame and the one after its last, counted from 0, as in ``motion.frames(start, stop)``.
    hand : Warp or GuidedWarp
        Its timing, found by whatever means. Input time 0 is the stretch's first frame.
    length : str, float or None
        As `guided_warp` has it; "free" where left out, for the hand's warp says how fast, not how long.
    **options
        The other options of `guided_warp`, but for `reference`.

    Returns
    -------
    GuidedWarp
        For the whole of `motion`.

    Raises
    ------
    OptionError
        The stretch leaves the clip, the hand's warp leaves the stretch, or an option is wrong.
    InfeasibleWarpError
        No warp meets the keytimes within the limits.

    Examples
    --------
    A swing of one second, played by hand at half its speed; the other seven follow.

    >>> import numpy as np
    >>> from fractions import Fraction
    >>> t = np.arange(8 * 30 + 1) / 30
    >>> swing = Signal(("x", "y"), np.stack([np.sin(2 * np.pi * t), np.cos(2 * np.pi * t)], axis=1), Fraction(30))
    >>> slow = imitate(swing, (0, 31), Warp([0.0, 2.0], [0.0, 1.0]))
    >>> round(float(np.median(slow.warp.slopes)), 2)
    0.5
    """
    if not isinstance(motion, AnyMotion):
        raise OptionError(
            f"expected imitate(motion, (start, stop), warp) with a motion or a signal, found {kind_of(motion)}"
        )
    if not isinstance(example, Sequence) or isinstance(example, str) or len(example) != 2:
        raise OptionError(f"the example is (first frame, the one after its last), found {kind_of(example)}")
    hand = as_warp(hand, "imitate(motion, (start, stop), warp)")
    start, stop = example
    stretch = motion.frames(start, stop)
    near = 0.5 / float(motion.rate)
    low, high = float(hand.input_times.min()), float(hand.input_times.max())
    if low < -near or high > stretch.end_time + near:
        raise OptionError(
            f"the warp made by hand shows input times {low:g} to {high:g} s, but its example (frames {start} to "
            f"{stop - 1}) has its last one at {stretch.end_time:g} s: name the frames that it was made for, counted "
            "from their first"
        )
    shown = replace(stretch, name=f"{motion.name or 'the clip'} by hand")
    retimed: AnyMotion
    # Two calls that look alike, so that types tell: apply_warp makes a motion of a motion, a signal of a signal.
    if isinstance(shown, Signal):
        retimed = apply_warp(shown, hand, average=False)
    else:
        retimed = apply_warp(shown, hand, average=False)
    if length == "free" and all(options.get(name) in (None, (), []) for name in _BOUND_SPEEDS):
        options |= _room_for(hand, motion.end_time)
    return guided_warp(motion, reference=Reference(retimed), length=length, **options)


def _room_for(hand: Warp, input_end: float) -> dict[str, int]:
    """Choose upsample and max_skip so that the search can play as slow and as fast as the hand did, within reason."""
    speeds = np.abs(hand.slopes)
    moving = speeds[speeds > 1 / _MOST_UPSAMPLE]
    slowest, fastest = (float(moving.min()), float(moving.max())) if len(moving) else (1.0, 1.0)
    upsample = max(usual_upsample(input_end), math.ceil(1 / slowest - 1e-9))
    return {
        "upsample": upsample,
        "max_skip": min(_MOST_SKIP, max(DEFAULT_MAX_SKIP, upsample, math.ceil(fastest * upsample - 1e-9))),
    }
