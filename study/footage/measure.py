"""What a warp from footage does: to flights that are known, and to a clip of which nothing is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from retime.brief import brief_repr
from retime.evaluate.metrics.flights import FlightTiming, flight_timing
from retime.media.features import video_signal
from retime.search.guided import guided_warp
from retime.search.poses.spaces import PoseOptions
from retime.warp.curve import Warp
from retime.warp.spline import linear_warp
from study.footage.ball import spans

LENGTHS = ("80%", "65%", "50%", "150%")
# Nobody sees a difference in speed that is smaller.
_AT_OWN_SPEED = 0.01


@dataclass(frozen=True, eq=False)
class BallRow:
    """The made clip at a length.

    Attributes
    ----------
    length : str
        Of the input's.
    warp : Warp
        The guided one.
    guided, played, linear, scaled : FlightTiming
        How flights are played: by the frames that the search chose, by the smooth warp that is made of them, by an even
        one, and by frames chosen with each channel scaled by its own spread.
    """

    length: str
    warp: Warp
    guided: FlightTiming
    played: FlightTiming
    linear: FlightTiming
    scaled: FlightTiming

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class TakeRow:
    """A real clip at a length.

    Attributes
    ----------
    length : str
        Of the input's.
    warp : Warp
        The guided one.
    at_own_speed : float
        Share of the output.
    extreme : float
        The speed that is farthest from 1, by its logarithm.
    """

    length: str
    warp: Warp
    at_own_speed: float
    extreme: float

    __repr__ = brief_repr


def measure_ball(path: Path, lengths: Sequence[str] = LENGTHS) -> list[BallRow]:
    """Warp the made clip, and look at its flights."""
    signal, flights, rows = video_signal(path), spans(), []
    for length in lengths:
        found = guided_warp(signal, length=length, features=PoseOptions(scale_signals=False))
        scaled = guided_warp(signal, length=length, features=PoseOptions(scale_signals=True))
        rows.append(
            BallRow(
                length,
                found.warp,
                flight_timing(found.staircase, flights),
                flight_timing(found.warp, flights),
                flight_timing(linear_warp(found.warp.keytimes), flights),
                flight_timing(scaled.staircase, flights),
            )
        )
    return rows


def measure_take(path: Path, lengths: Sequence[str] = LENGTHS) -> list[TakeRow]:
    """Warp a real clip, and look at its speeds."""
    signal, rows = video_signal(path), []
    for length in lengths:
        warp = guided_warp(signal, length=length, features=PoseOptions(scale_signals=False)).warp
        seconds, speeds = np.diff(warp.output_times), warp.slopes
        own = np.abs(speeds - 1.0) < _AT_OWN_SPEED
        farthest = speeds[np.argmax(np.abs(np.log(np.maximum(speeds, 1e-3))))]
        rows.append(TakeRow(length, warp, float(seconds[own].sum() / seconds.sum()), float(farthest)))
    return rows


def tables(ball: Sequence[BallRow], take: Sequence[TakeRow]) -> str:
    """Write what was measured as tables of the docs."""
    lines = [
        "| length | flight frames kept, as chosen | as played | linear | as chosen, channels scaled each for itself |",
        "| :-- | --: | --: | --: | --: |",
    ]
    for row in ball:
        cells = [
            row.length.replace("%", " %"),
            f"{row.guided.n_kept} of {row.guided.n_frames}",
            f"{row.played.n_kept} of {row.played.n_frames}",
            str(row.linear.n_kept),
            str(row.scaled.n_kept),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    if take:
        lines += ["", "| length | output at its own speed | fastest or slowest |", "| :-- | --: | --: |"]
        lines += [
            f"| {row.length.replace('%', ' %')} | {100 * row.at_own_speed:.0f} % | {row.extreme:.2g}x |" for row in take
        ]
    return "\n".join(lines)
