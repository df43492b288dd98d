"""Splines through keytimes that are set by hand, as an animator would."""

from __future__ import annotations

from collections.abc import Sequence

from retime.errors import InfeasibleWarpError
from retime.evaluate.metrics import Spans
from retime.motion.motion import Motion
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime
from retime.warp.spline import spline_warp
from study.clips.blows import fast_spans, wrists


def spans_to_keep(motion: Motion, keep: Spans, *, margin: float = 0.1) -> tuple[tuple[float, float], ...]:
    """Widen stretches by `margin` seconds, and join those that then meet."""
    joined: list[tuple[float, float]] = []
    for start, end in sorted(keep):
        a, b = max(0.0, start - margin), min(motion.end_time, end + margin)
        if joined and a <= joined[-1][1]:
            joined[-1] = (joined[-1][0], max(b, joined[-1][1]))
        else:
            joined.append((a, b))
    return tuple(joined)


def keyed_spline(motion: Motion, keep: Spans, output_span: float, *, speed: float = 1.0) -> Warp:
    """Set keytimes as an animator would, at both ends of each stretch whose speed is wanted, and join them.

    The rest shares what time is left, evenly.

    Parameters
    ----------
    motion : Motion
        The input.
    keep : sequence of (float, float)
        Those stretches, input seconds, in order and apart.
    output_span : float
        Seconds.
    speed : float
        That they play at; 1 keeps their duration.

    Returns
    -------
    Warp
        The monotone spline through those keytimes.

    Raises
    ------
    InfeasibleWarpError
        They alone are as long as the output.
    """
    wanted = sum(end - start for start, end in keep)
    kept, rest = wanted / speed, motion.end_time - wanted
    if not kept < output_span:
        raise InfeasibleWarpError(f"{kept:.2f} s are to be kept, in an output of {output_span:.2f} s")
    slowness = (output_span - kept) / rest if rest > 0 else 1.0
    keys = [Keytime(input_time=0.0, output_time=0.0)]
    for start, end in keep:
        for at, pace in ((start, slowness), (end, 1 / speed)):
            before = keys[-1]
            if at > before.input_time:
                keys.append(Keytime(input_time=at, output_time=before.output_time + (at - before.input_time) * pace))
    if motion.end_time - keys[-1].input_time > 1e-9:
        keys.append(Keytime(input_time=motion.end_time, output_time=output_span))
    return spline_warp(keys, rate=float(motion.rate))


def spline_through(truth: Warp, input_times: Sequence[float], *, rate: float) -> Warp:
    """Join keytimes that a known answer has at some moments, and at its ends: all an animator would have to set."""
    within = [t for t in input_times if truth.input_times[0] + 1e-6 < t < truth.input_times[-1] - 1e-6]
    times = [float(truth.input_times[0]), *within, float(truth.input_times[-1])]
    return spline_warp([Keytime(input_time=t, output_time=float(truth.inverse()(t))) for t in times], rate=rate)


def keyed_blows(motion: Motion) -> Warp:
    """Hurry over every blow as an animator would, by keytimes around it; the length stays."""
    blows = spans_to_keep(motion, fast_spans(motion, wrists(motion)))
    return keyed_spline(motion, blows, motion.end_time, speed=1.6)
