"""How much of a hand's change comes back outside of its example, and how long the whole gets."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from retime.errors import RetimeWarning
from retime.evaluate.metrics import Spans
from retime.search.guided import guided_warp
from retime.search.imitate import imitate
from retime.search.poses.references import Reference
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from study.clips.library import Library
from study.propagation.cases import KINDS, Case

# What is left of a step beside its example is looked at where it lasts so long, seconds.
_SHORTEST = 0.15


@dataclass(frozen=True)
class Propagated:
    """What one way of propagation made of one case.

    Attributes
    ----------
    kind, clip, example : str
        The case: its kind, its clip, and where its example lies (a clip, or input seconds).
    way : str
        One of `WAYS`.
    length : str
        "free" or "given".
    recovery : float
        How far apart the two kinds of stretch come in log-speed outside of the example, over how far they should: 1 is
        all of it, 0 none, below 0 the wrong way round. NaN where one of them is not there.
    length_ratio : float
        Length of the output over the right one.
    share : float, optional
        How much of the clip the example was said to speak for.
    """

    kind: str
    clip: str
    example: str
    way: str
    length: str
    recovery: float
    length_ratio: float
    share: float | None = None


def recovery(warp: Warp, case: Case) -> float:
    """Say how much of the answer's difference between two kinds of stretch a warp has, outside of the example."""
    found, right = (_apart(one, case) for one in (warp, case.truth))
    return found / right if right else math.nan


def _apart(warp: Warp, case: Case) -> float:
    """Mean log-speed of the changed stretches less that of the others, outside of the example."""
    return _mean_log_speed(warp, case.changed, case.example_times) - _mean_log_speed(
        warp, case.others, case.example_times
    )


def _mean_log_speed(warp: Warp, spans: Spans, apart_from: tuple[float, float] | None) -> float:
    total = weight = 0.0
    for start, end in spans:
        parts = (
            [(start, end)]
            if apart_from is None
            else [(start, min(end, apart_from[0])), (max(start, apart_from[1]), end)]
        )
        for low, high in parts:
            if high - low >= _SHORTEST:
                shown = np.interp([low, high], warp.input_times, warp.output_times)
                total += (high - low) * math.log((high - low) / float(shown[1] - shown[0]))
                weight += high - low
    return total / weight if weight else math.nan


def _as_a_reference(case: Case, length: str) -> tuple[Warp, float | None]:
    first, last = case.example
    shown = apply_warp(case.example_clip.frames(first, last + 1), case.hand, average=False)
    return guided_warp(case.motion, reference=Reference(shown), length=length).warp, None


def _imitated(**how: Any) -> Callable[[Case, str], tuple[Warp, float | None]]:
    def solve(case: Case, length: str) -> tuple[Warp, float | None]:
        first, last = case.example
        other = case.example_clip if case.elsewhere else None
        with warnings.catch_warnings():
            # What it warns of here (turns, other clips) is what is measured.
            warnings.simplefilter("ignore", RetimeWarning)
            found = imitate(case.motion, (first, last + 1), case.hand, example_clip=other, length=length, **how)
        return found.warp, None if found.example is None else found.example.share

    return solve


WAYS: dict[str, Callable[[Case, str], tuple[Warp, float | None]]] = {
    "the paper's": _imitated(paper=True),
    "as a reference": _as_a_reference,
    "the hand's speed": _imitated(),
}
"""Ways of propagation: the paper's; the retimed stretch as a reference, with the defaults of the guided warp; and the
hand's speed, which is `retime.imitate`'s default."""

LENGTHS = ("free", "given")


def propagate_all(clips: Library, *, kinds: tuple[str, ...] = tuple(KINDS)) -> Iterator[Propagated]:
    """Put every case to every way, at a free length and at the right one.

    Parameters
    ----------
    clips : Library
        The captures.
    kinds : tuple of str
        Of `KINDS`.
    """
    for kind in kinds:
        for case in KINDS[kind](clips, kind):
            times = case.example_times
            where = case.example_clip.name if times is None else f"{times[0]:.2f}..{times[1]:.2f}"
            given = f"{case.truth.count_frames(case.motion.rate)}f"
            for way, solve in WAYS.items():
                for length in LENGTHS:
                    warp, share = solve(case, "free" if length == "free" else given)
                    ratio = warp.output_span / case.truth.output_span
                    yield Propagated(kind, case.motion.name, where, way, length, recovery(warp, case), ratio, share)
