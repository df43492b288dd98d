"""The old defaults beside the new, on two sets of clips."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from study.sets.measure import LENGTHS, LINEAR, VERSIONS, Played
from study.tables.table import Table
from study.text import NOTHING, number


def _values(some: Sequence[Played], name: str) -> list[Any]:
    return [one.figures[name] for one in some if one.figures[name] is not None]


def _mean_and_worst(name: str, digits: int, worst: Callable[[list[float]], float]) -> Callable[[Sequence[Played]], str]:
    def write(some: Sequence[Played]) -> str:
        values = _values(some, name)
        return f"{number(float(np.mean(values)), digits)} ({number(worst(values), digits)})" if values else NOTHING

    return write


def _most(name: str, digits: int) -> Callable[[Sequence[Played]], str]:
    return lambda some: number(max(_values(some, name)), digits) if _values(some, name) else NOTHING


def _sum(name: str, digits: int = 0) -> Callable[[Sequence[Played]], str]:
    return lambda some: number(float(sum(_values(some, name))), digits) if _values(some, name) else NOTHING


def _mean(name: str, digits: int) -> Callable[[Sequence[Played]], str]:
    return lambda some: number(float(np.mean(_values(some, name))), digits) if _values(some, name) else NOTHING


def _kept(some: Sequence[Played]) -> str:
    frames = sum(_values(some, "flight_frames"))
    return f"{sum(_values(some, 'flight_frames_kept'))} of {frames}" if frames else NOTHING


# One entry a figure: what it is called, and how it is written for all clips of a set at one length.
_FIGURES: tuple[tuple[str, Callable[[Sequence[Played]], str]], ...] = (
    ("walks: 95th percentile of speed, mean (worst)", _mean_and_worst("walk_high", 2, max)),
    ("walks: 5th percentile of speed, mean (worst)", _mean_and_worst("walk_low", 2, min)),
    ("walks: longest stretch above 1.6 times (s)", _most("walk_fast", 2)),
    ("walks: longest stretch below 0.6 times (s)", _most("walk_slow", 2)),
    ("walks: spread of steps, mean", _mean("steps_spread", 3)),
    ("flight frames kept", _kept),
    ("flights leapt over", _sum("flights_leapt")),
    ("worst pose skipped (cm), mean (worst)", _mean_and_worst("skipped", 1, max)),
    ("standing still, in all (s)", _sum("idle", 1)),
    ("jerk, mean (m/s³)", _mean("jerk", 0)),
)


def sets_table(played: Sequence[Played], clips: str) -> Table:
    """One set of clips: a row a figure and version, a column a length."""
    own = [one for one in played if one.clips == clips]
    lengths = [length for length in LENGTHS if any(one.length == length for one in own)]
    versions = [LINEAR, *VERSIONS]
    rows: list[tuple[str, ...]] = []
    for heading, write in _FIGURES:
        for version in versions:
            some = [[one for one in own if (one.length, one.version) == (length, version)] for length in lengths]
            rows.append((heading if version == versions[0] else "", version, *(write(group) for group in some)))
    marked = frozenset(i for i, row in enumerate(rows) if row[1] == versions[-1])
    return Table(("figure", "version", *lengths), tuple(rows), numbers_from=2, marked=marked)
