"""What a host can't play is refused before anything is written, with the remedy."""

from __future__ import annotations

import numpy as np

from retime.errors import OptionError
from retime.hosts.registry import Host
from retime.warp.curve import Warp

# Seconds: of rounding, a warp that begins at the clip's first frame may lie this far before it.
_ROUNDING = 1e-9
_PLAYS_ALL = "csv, nuke and maya play it as it is"
_PLAYS_BACK = "frames (a list of the frames to show), mlt, nuke, maya and csv play it as it is"


def check_warp(host: Host, warp: Warp) -> None:
    """Refuse spans that a host can't express.

    Raises
    ------
    OptionError
        Names the first span, and which host would do.
    """
    way = np.sign(np.diff(warp.input_times))
    for possible, what, pieces in (
        (host.holds, "holds", way == 0),
        (host.backward, "runs backward", way < 0),
    ):
        if not possible and pieces.any():
            start, end = _span(pieces)
            raise OptionError(
                f"the warp {what} from output time {warp.output_times[start]:g} to {warp.output_times[end]:g} s, which "
                f"{host.name} can't express: it gives each input frame one time. {_PLAYS_BACK}; "
                "or find a warp that always plays forward (--speed 1/4..8)"
            )
    fast = np.abs(warp.slopes) > host.fastest * (1 + 1e-9)
    if fast.any():
        start, end = _span(fast)
        raise OptionError(
            f"from output time {warp.output_times[start]:g} to {warp.output_times[end]:g} s the warp plays at "
            f"{np.abs(warp.slopes[start:end]).max():.3g}x, and {host.name} at {host.fastest:g}x at most: {_PLAYS_ALL}; "
            f"or find a slower warp (--speed 1/4..{host.fastest:g})"
        )
    least = float(warp.input_times.min())
    if not host.before_clip and least < -_ROUNDING:
        knot = int(np.argmin(warp.input_times))
        raise OptionError(
            f"at output time {warp.output_times[knot]:g} s the warp shows the input time {least:g} s, before the "
            f"clip's first frame, which {host.name} can't express: {_PLAYS_ALL}"
        )
    early, late = warp.output_start < -_ROUNDING, warp.output_start > _ROUNDING
    if (early and not host.before_clip) or ((early or late) and not host.begins_late):
        where = "before" if early else "after"
        raise OptionError(
            f"the output begins at {warp.output_start:g} s, {where} time 0, which {host.name} can't express: "
            f"{_PLAYS_ALL}"
        )


def _span(pieces: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]) -> tuple[int, int]:
    """Return the knots at the ends of the first run of pieces."""
    start = int(np.argmax(pieces))
    rest = np.flatnonzero(~pieces[start:])
    return start, start + (int(rest[0]) if len(rest) else len(pieces) - start)
