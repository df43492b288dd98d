"""A clip of either kind with a warp."""

from __future__ import annotations

from retime.motion.any_motion import AnyMotion
from retime.motion.contacts import Contacts
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from retime.warp.resampling import resample


def retimed(clip: AnyMotion, warp: Warp, *, average: bool, feet: Contacts | None = None, held: int = 1) -> AnyMotion:
    """Apply a warp to whichever kind of clip this is, and hold each pose for some frames.

    `feet`, where they were found already, spare finding them.
    """
    if isinstance(clip, Signal):
        return resample(apply_warp(clip, warp, average=average), on=held)
    return resample(apply_warp(clip, warp, average=average, contacts="find" if feet is None else feet), on=held)
