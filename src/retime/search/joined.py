"""Warps that only join keytimes: what animators have today, with no search."""

from __future__ import annotations

from collections.abc import Sequence

from retime.errors import OptionError
from retime.motion.any_motion import AnyMotion
from retime.search.keytimes import as_keytimes, asking_for_a_share, check_keytimes
from retime.warp.curve import Warp
from retime.warp.keytime import KeytimeLike
from retime.warp.spline import linear_warp, spline_warp


def joined_warp(clip: AnyMotion, length: str | float | None, keys: Sequence[KeytimeLike], method: str) -> Warp:
    """Join a clip's ends and keytimes by straight lines or by a spline.

    Parameters
    ----------
    clip : Motion or Signal
        The input.
    length : str or float, optional
        As of `retime.guided_warp`.
    keys : sequence
        As of `retime.guided_warp`.
    method : {"linear", "spline"}
        How.

    Raises
    ------
    OptionError
        The length is free, or says nothing.
    InfeasibleWarpError
        Keytimes contradict each other or the clip.
    """
    if length == "free":
        raise OptionError(f"a free length needs a search; the method {method} has none", option="length")
    with asking_for_a_share(clip, length):
        keytimes = check_keytimes(as_keytimes(clip, length, keys), clip.end_time)
    return linear_warp(keytimes) if method == "linear" else spline_warp(keytimes, rate=float(clip.rate))
