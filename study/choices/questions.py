"""The questions, and what becomes of each setting when they are put to it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from retime.errors import InfeasibleWarpError
from retime.evaluate.metrics import Spans
from retime.evaluate.metrics.flights import flight_spans, flight_timing, path_warp
from retime.evaluate.metrics.known_answer import match_warps
from retime.motion.motion import Motion
from retime.search.poses.references import Reference
from retime.search.session import Session
from study.answers.cases import ANSWERS, Answer
from study.choices.settings import CHOSEN, PRINTED, Setting
from study.clips.library import Library
from study.defaults import parted

JUMPS = ("05_18", "05_08", "05_15", "05_16", "86_01", "02_04", "01_01", "49_02", "49_04", "49_05", "sample")
"""Clips with flights."""


HIGH = 0.15
"""Metres of clearance that make a flight a high one: no doubt about those."""


LENGTHS = ("80%", "65%", "50%", "150%")


@dataclass(frozen=True)
class Preserved:
    """How one clip's flights fared at one length.

    Attributes
    ----------
    clip, length : str
        Which.
    n_frames, n_kept : int
        In-flight frames of the input, and those at exactly unit speed; none kept where no warp is feasible.
    n_high, n_high_kept : int
        The same of high flights alone.
    """

    clip: str
    length: str
    n_frames: int
    n_kept: int
    n_high: int = 0
    n_high_kept: int = 0


@dataclass(frozen=True)
class Imitated:
    """How close one case came to its known answer.

    Attributes
    ----------
    case, kind : str
        Which; "limp", "jump" or "boxing".
    length : str
        "given", or how a free length was weighed: "neutral", "sum".
    correlation, log_speed_error, mean_error : float
        As `retime.evaluate.metrics.known_answer.WarpMatch` has them, where the answer has something to say.
    length_ratio : float
        Length of the whole output over the right one.
    """

    case: str
    kind: str
    length: str
    correlation: float
    log_speed_error: float
    mean_error: float
    length_ratio: float


@dataclass(frozen=True)
class Row:
    """What became of one setting."""

    setting: Setting
    preserved: tuple[Preserved, ...]
    imitated: tuple[Imitated, ...]

    def kept(self, length: str | None = None) -> tuple[int, int]:
        """In-flight frames kept, and all of them; at one length, or together."""
        some = [one for one in self.preserved if length in (None, one.length)]
        return sum(one.n_kept for one in some), sum(one.n_frames for one in some)

    def kept_high(self, length: str | None = None) -> tuple[int, int]:
        """Frames of high flights kept, and all of them."""
        some = [one for one in self.preserved if length in (None, one.length)]
        return sum(one.n_high_kept for one in some), sum(one.n_high for one in some)

    def mean(self, what: str, *, kind: str | None = None, length: str | None = None) -> float:
        """Mean of an attribute of `Imitated` over some cases; of a length's ratio, the mean error in percent.

        A correlation that does not exist (the warp found has one speed) counts as 0. NaN where there is no such case.
        """
        values = [
            getattr(one, what) for one in self.imitated if kind in (None, one.kind) and length in (None, one.length)
        ]
        if not values:
            return math.nan
        if what == "length_ratio":
            return float(np.mean([abs(math.log(value)) for value in values])) * 100
        return float(np.mean(np.nan_to_num(values)))


def measure(
    clips: Library,
    rows: Sequence[Setting],
    *,
    jumps: Sequence[str] = JUMPS,
    lengths: Sequence[str] = LENGTHS,
    answers: Sequence[str] = tuple(ANSWERS),
) -> Iterator[Row]:
    """Answer every question with every setting, one row at a time."""
    cases = [ANSWERS[name](clips) for name in answers]
    flights = {
        clip: (flight_spans(clips[clip]), flight_spans(clips[clip], clearance=HIGH) if clip != "sample" else ())
        for clip in jumps
    }
    for setting in rows:
        preserved = [one for clip in jumps for one in _preserve(clips[clip], clip, flights[clip], setting, lengths)]
        imitated = [one for case in cases for one in _imitate(case, setting)]
        yield Row(setting, tuple(preserved), tuple(imitated))


def _session(motion: Motion, setting: Setting, reference: Motion | None = None) -> tuple[Session, dict[str, Any]]:
    """Prepare a motion with a setting's choices for the analysis, and return those for the search."""
    analysis, search = parted(setting.options)
    if callable(analysis.get("features")):
        analysis["features"] = analysis["features"](motion)
    other = None if reference is None else Reference(reference)
    return Session(motion, reference=other, **analysis), search


def _preserve(
    motion: Motion, clip: str, flights: tuple[Spans, Spans], setting: Setting, lengths: Sequence[str]
) -> Iterator[Preserved]:
    session, search = _session(motion, setting)
    spans, high = flights
    untouched = path_warp(session.solve(length="100%"))
    frames, high_frames = (flight_timing(untouched, some).n_frames for some in flights)
    for length in lengths:
        options = dict(search)
        # The longest step is a question about speeds above 1, upsampling about those below.
        if float(length.rstrip("%")) > 100:
            if "upsample" not in options:
                options.pop("max_skip", None)
        elif "upsample" in options:
            options = {name: value for name, value in options.items() if name not in ("upsample", "max_skip")}
        try:
            found = path_warp(session.solve(length=length, **options))
        except InfeasibleWarpError:
            yield Preserved(clip, length, frames, 0, high_frames, 0)
            continue
        kept, high_kept = (flight_timing(found, some).n_kept for some in (spans, high))
        yield Preserved(clip, length, frames, kept, high_frames, high_kept)


def _imitate(case: Answer, setting: Setting) -> Iterator[Imitated]:
    session, search = _session(case.motion, setting, case.reference)
    if "upsample" not in search:
        search.pop("max_skip", None)
    given = f"{round(case.truth.output_span * float(case.motion.rate)) + 1}f"
    asked: list[tuple[str, dict[str, Any]]] = [("given", {"length": given})]
    if case.free:
        asked += [(weight, {"length": "free", "free_weight": weight}) for weight in ("neutral", "sum")]
    for label, options in asked:
        found = session.solve(**options, **search).warp
        match = match_warps(found, case.truth, spans=case.spans)
        yield Imitated(
            case.name,
            case.kind,
            label,
            match.correlation,
            match.log_speed_error,
            match.mean_error,
            match.length_ratio,
        )


def default_row(rows: Sequence[Row]) -> Row:
    """Find the row of the recommended setting."""
    return next(row for row in rows if row.setting.group == CHOSEN)


def printed_row(rows: Sequence[Row]) -> Row:
    """Find the row of the paper, read literally."""
    return next(row for row in rows if row.setting.group == PRINTED)


def row_of(rows: Sequence[Row], options: Mapping[str, Any]) -> Row | None:
    """Find the row of a setting by its options; None where there is none."""
    return next((row for row in rows if row.setting.options == options), None)
