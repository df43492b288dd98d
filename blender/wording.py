"""What became of a motion, in words for the panel. bpy is not needed."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from retime.evaluate.metrics.flights import flight_spans, flight_timing, path_warp
from retime.motion.any_motion import AnyMotion
from retime.search.result import GuidedWarp
from retime.warp.curve import Warp

from .timing import Timing

# A stretch is worth a word where it plays so much faster or slower than the whole.
_MUCH = 1.25


def summary(timing: Timing, clip: AnyMotion, found: GuidedWarp | None) -> list[str]:
    """Say how long a motion is now, how fast it plays, which jumps were kept and what was squeezed or stretched.

    Parameters
    ----------
    timing : Timing
        In the scene's frames.
    clip : Motion or Signal
        What was retimed, from the first frame of the range.
    found : GuidedWarp, optional
        Where the timing was searched for.

    Returns
    -------
    list of str
        A line each.
    """
    warp = timing.warp
    before, after = timing.input_end - timing.start + 1, timing.end - timing.start + 1
    lines = [
        f"{before:g} → {after:g} frames ({after / timing.rate:.2f} s), {after / before:.0%}",
        f"speed {_times(float(warp.slopes.min()))} to {_times(float(warp.slopes.max()))}",
    ]
    spans = flight_spans(clip)
    if spans:
        shown = timing.in_seconds() if found is None else path_warp(found)
        flights = flight_timing(shown, spans)
        lines.append(f"{flights.n_flights_kept} of {flights.n_flights} jumps keep their own speed")
    return lines + list(_extremes(warp))


def _extremes(warp: Warp) -> Iterable[str]:
    """Name the stretch that was squeezed most and the one that was stretched most, a sixth of the range long."""
    length = float(warp.output_span)
    mean = float(warp.input_times[-1] - warp.input_times[0]) / length
    width = length / 6
    begins = np.linspace(warp.output_start, warp.output_end - width, 61)
    ends = warp(begins + width)
    speeds = (ends - warp(begins)) / width
    for word, place, share in (
        ("squeezed", int(np.argmax(speeds)), float(speeds.max()) / mean if mean > 0 else 1.0),
        ("stretched", int(np.argmin(speeds)), mean / max(float(speeds.min()), 1e-9)),
    ):
        if share > _MUCH:
            first, last = float(warp(begins[place])), float(ends[place])
            yield f"{word} most: frames {first:.0f} to {last:.0f}, at {_times(float(speeds[place]))}"


def _times(speed: float) -> str:
    return f"{speed:.2f}×"
