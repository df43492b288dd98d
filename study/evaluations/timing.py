"""Sizes and times of a search: this study's rows of Table 1."""

from __future__ import annotations

import statistics
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from retime.motion.motion import Motion
from retime.search.poses.references import Reference
from retime.search.result import GuidedWarp
from retime.search.session import Session
from study.defaults import parted


@dataclass(frozen=True)
class TableRow:
    """A row of this study's table.

    Attributes
    ----------
    n_input, n_output, n_reference, max_skip, upsample : int
        Sizes of the search; upsample 1 is plain compression.
    features, objective, search : float
        Seconds for pose vectors, for scores, and for the exact search; medians of several runs.
    layered : float
        Seconds for the paper's own recurrence, which finds the same path.
    heuristic, excess : float, optional
        Seconds for the paper's coarse-to-fine search with its coarse scores, and the share by which its total exceeds
        the optimum; None where the length is free.
    excess_as_keytimes : float, optional
        The same share where the coarse path is read as keytimes, not as the middle of a band.
    optimal : bool
        Whether the path is proved to be the best.
    """

    n_input: int
    n_output: int
    n_reference: int
    max_skip: int
    upsample: int
    features: float
    objective: float
    search: float
    layered: float
    heuristic: float | None
    excess: float | None
    excess_as_keytimes: float | None
    optimal: bool


def solve_timed(
    motion: Motion, reference: Motion | None, options: Mapping[str, Any], *, repeats: int = 5
) -> tuple[GuidedWarp, TableRow]:
    """Find a guided warp, several times over, and time its stages.

    Parameters
    ----------
    motion, reference : Motion
        Input and reference; None: the input itself.
    options : mapping of str to object
        Of `retime.guided_warp`.
    repeats : int
        Runs that the medians are of.
    """
    analysis, search = parted(options)
    seconds: list[dict[str, float]] = []
    layered, heuristic = [], []
    excess = as_keytimes = None
    for _ in range(repeats):
        session = Session(motion, reference=None if reference is None else Reference(reference), **analysis)
        found = session.solve(**search)
        seconds.append(found.seconds)
        layered.append(session.solve(**search, search="layered").seconds["path"])
        if search.get("length") != "free":
            coarse = session.solve(**search, search="heuristic")
            # It finds the optimum too, to say how much it exceeds it: that is not part of its time.
            heuristic.append(max(0.0, coarse.seconds["path"] - found.seconds["path"]))
            excess = coarse.excess
            session.slack = None
            as_keytimes = session.solve(**search, search="heuristic").excess
    row = TableRow(
        found.n_input,
        found.n_output,
        found.n_reference,
        found.max_skip,
        found.upsample,
        statistics.median(one["features"] for one in seconds),
        statistics.median(one["scores"] for one in seconds),
        statistics.median(one["path"] for one in seconds),
        statistics.median(layered),
        statistics.median(heuristic) if heuristic else None,
        excess,
        as_keytimes,
        found.path.optimal,
    )
    return found, row
