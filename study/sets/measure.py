"""Plays every clip of both sets at every length, by each version of the search, and measures what comes of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from retime.errors import InfeasibleWarpError
from retime.evaluate.metrics.flights import path_warp
from retime.motion.motion import Motion
from retime.search.session import Session
from retime.warp.apply import apply_warp
from retime.warp.spline import linear_warp
from study.clips.library import Library
from study.clips.sources import FIRST, SECOND
from study.defaults import AS_PRINTED, WITHOUT_HURRY, parted
from study.figures.figure import Figures
from study.figures.registry import FIGURES
from study.figures.shown import Subject, Warped

SETS: dict[str, tuple[str, ...]] = {"first": (*FIRST, "sample"), "second": tuple(SECOND)}
"""Clips of each set."""

LENGTHS = ("80%", "65%", "50%", "120%", "150%")

VERSIONS: dict[str, Mapping[str, Any]] = {
    "the paper, read literally": AS_PRINTED,
    "without natural hurry": WITHOUT_HURRY,
    "the default": {},
}
"""What is compared, beside the linear warp: options of `retime.guided_warp`; the last is what it chooses by itself."""

LINEAR = "linear"

MEASURED = (
    *("flight_frames", "flight_frames_kept", "flights_leapt", "skipped"),
    *("walk_low", "walk_high", "walk_fast", "walk_slow", "steps_spread", "idle", "jerk"),
)
"""Figures of merit, by their names in `study.figures.registry.FIGURES`."""


@dataclass(frozen=True)
class Played:
    """How one clip fared at one length.

    Attributes
    ----------
    clips : str
        The set: "first" or "second".
    clip, length, version : str
        Which.
    figures : mapping of str to object
        `MEASURED`, by name; None where one does not apply.
    optimal : bool
        Whether the search proved that its path is the best.
    """

    clips: str
    clip: str
    length: str
    version: str
    figures: Figures
    optimal: bool = True


def play_sets(
    clips: Library,
    *,
    sets: Mapping[str, Sequence[str]] = SETS,
    lengths: Sequence[str] = LENGTHS,
    versions: Mapping[str, Mapping[str, Any]] = VERSIONS,
) -> Iterator[Played]:
    """Play every clip, by every version.

    A length that a version has no warp for is left out there.
    """
    for name, members in sets.items():
        for clip in members:
            motion = clips[clip]
            subject = Subject(motion, motion)
            sessions = {version: _session(motion, options) for version, options in versions.items()}
            for length in lengths:
                keytimes = None
                for version, (session, search) in sessions.items():
                    try:
                        found = session.solve(length=length, **search)
                    except InfeasibleWarpError:
                        continue
                    keytimes = found.warp.keytimes
                    shown = Warped(subject, apply_warp(motion, found.warp), found.warp, path_warp(found), keytimes)
                    yield Played(name, clip, length, version, measured(shown), found.path.optimal)
                if keytimes is not None:
                    even = linear_warp(keytimes)
                    shown = Warped(subject, apply_warp(motion, even), even, None, keytimes)
                    yield Played(name, clip, length, LINEAR, measured(shown))


def _session(motion: Motion, options: Mapping[str, Any]) -> tuple[Session, Mapping[str, Any]]:
    """Prepare a clip with a version's choices for the analysis, and return those for the search."""
    analysis, search = parted(options)
    return Session(motion, **analysis), search


def measured(shown: Warped) -> dict[str, Any]:
    """Measure what is asked of both sets."""
    return {figure.name: figure.measure(shown) for figure in FIGURES if figure.name in MEASURED}
