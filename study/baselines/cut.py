"""Silence cut out, as an editor would."""

from __future__ import annotations

import numpy as np

from retime.errors import InfeasibleWarpError
from retime.evaluate.metrics.stillness import activity
from retime.motion.motion import Motion
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime


def cut_idle(motion: Motion, n_output: int) -> Warp:
    """Remove silence as an editor would: drop the frames that move least, until the length fits.

    That is one threshold on `retime.evaluate.metrics.stillness.activity`, set to leave `n_output` frames at the
    motion's own rate; the ends stay. Frames are cut, not blended: show it with ``average=False``.

    Raises
    ------
    InfeasibleWarpError
        There are fewer frames than that.
    """
    if not 2 <= n_output <= motion.n_frames:
        raise InfeasibleWarpError(f"cutting leaves 2 to {motion.n_frames} frames; asked for {n_output}")
    speed = activity(motion)
    speed[[0, -1]] = np.inf
    kept = np.sort(np.argsort(-speed, kind="stable")[:n_output])
    rate = float(motion.rate)
    ends = (
        Keytime(input_time=0.0, output_time=0.0),
        Keytime(input_time=motion.end_time, output_time=(n_output - 1) / rate),
    )
    return Warp(np.arange(n_output) / rate, kept / rate, ends, method="cut")
