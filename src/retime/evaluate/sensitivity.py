"""How much each choice matters: the same questions asked with one choice changed at a time.

Two kinds of question have a known answer. *Preservation*: a clip with jumps gets another length, and every in-flight
frame should keep unit speed. *Imitation*: one stretch is retimed by hand, and the rest should follow (`study_motions`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from retime.errors import InfeasibleWarpError
from retime.evaluate.metrics import Spans, flight_spans, flight_timing, match_warps, path_warp
from retime.evaluate.study_choices import AS_PRINTED
from retime.evaluate.study_motions import ANSWERS, Answer, Library
from retime.motion.joint_names import body_parts
from retime.motion.motion import Motion
from retime.warp.features import PoseOptions
from retime.warp.reference import Reference
from retime.warp.session import Session

JUMPS = ("05_18", "05_08", "05_15", "05_16", "86_01", "02_04", "01_01", "49_02", "49_04", "49_05", "sample")
"""Clips with flights."""

HIGH = 0.15
"""Metres of clearance that make a flight a high one: no doubt about those."""

LENGTHS = ("80%", "65%", "50%", "150%")

CHOSEN = "the default"
"""Group of the row that stands for what the package does by itself."""

_ANALYSIS = ("n_neighbors", "time_scale", "low_pass", "features", "score", "rate")


@dataclass(frozen=True)
class Setting:
    """One row of the table.

    Attributes
    ----------
    group : str
        The choice that is looked at.
    label : str
        What was chosen.
    options : mapping of str to object
        Of `retime.guided_warp`. ``features`` may be a function from a motion to its options.
    """

    group: str
    label: str
    options: Mapping[str, Any] = field(default_factory=dict)


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
        As `retime.evaluate.metrics.WarpMatch` has them, where the answer has something to say.
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


def _without_hands(motion: Motion) -> PoseOptions:
    """Leave out palms, fingers and thumbs: small, and in captures mostly noise."""
    names = motion.skeleton.names
    parts = body_parts(names)
    small = {
        name
        for name, part in zip(names, parts, strict=True)
        if (part is not None and part.base in ("palm", "fingers")) or "thumb" in name.lower()
    }
    return PoseOptions("heading", weights=dict.fromkeys(small, 0.0))


def _few(motion: Motion) -> PoseOptions:
    """Hips, feet, hands, head."""
    names = motion.skeleton.names
    wanted = ("hips", "foot", "hand", "head")
    chosen = [
        name for name, part in zip(names, body_parts(names), strict=True) if part is not None and part.base in wanted
    ]
    return PoseOptions("heading", joints=(names[0], *(name for name in chosen if name != names[0])))


def _root_weighs(factor: float) -> Callable[[Motion], PoseOptions]:
    return lambda motion: PoseOptions("heading", weights={motion.skeleton.names[0]: factor})


def settings(base: Mapping[str, Any]) -> list[Setting]:
    """List the rows: the main choices with each other, then one at a time around `base`."""
    rows = [
        Setting("the paper, read literally", describe(AS_PRINTED), AS_PRINTED),
        Setting(CHOSEN, describe(base), base),
    ]
    for features in ("torso", "heading"):
        for score in ("joint", "conditional"):
            for time_scale in (1 / 30, 0.1, 0.15, 0.2, 0.3):
                options = {"features": features, "score": score, "time_scale": time_scale}
                rows.append(Setting("pose space, score, time scale", describe(options), options))
    single: list[tuple[str, str, Sequence[Any]]] = [
        ("time scale τ (s)", "time_scale", (0.05, 0.25, 0.5)),
        ("low-pass (Hz)", "low_pass", (0.0, 2.0, 3.0, 6.0, 8.0)),
        ("neighbours k", "n_neighbors", (1, 2, 5, 10)),
        ("weight on changes of speed", "smoothness", (0.02, 0.05, 0.1, 0.3)),
        ("averaging window (frames)", "smoothing", (0, 3, 9)),
        ("longest step", "max_skip", (3, 4, 12)),
    ]
    for group, option, values in single:
        rows += [Setting(group, f"{value:g}", {**base, option: value}) for value in values]
    rows += [
        Setting(
            "frames a period, where slowed", f"{n}, longest step {2 * n}", {**base, "upsample": n, "max_skip": 2 * n}
        )
        for n in (2, 4, 6, 12)
    ]
    rows += [
        Setting("joints", "hips, feet, hands, head", {**base, "features": _few}),
        Setting("joints", "no fingers", {**base, "features": _without_hands}),
        Setting("joints", "root counts 4 times", {**base, "features": _root_weighs(4.0)}),
        Setting("joints", "root counts not", {**base, "features": _root_weighs(0.0)}),
    ]
    return rows


def describe(options: Mapping[str, Any]) -> str:
    """Write the main choices in one line."""
    time_scale = options["time_scale"]
    shown = "1/30" if abs(time_scale - 1 / 30) < 1e-9 else f"{time_scale:g}"
    return f"{options['features']}, {options['score']}, τ = {shown} s"


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
    analysis = {name: value for name, value in setting.options.items() if name in _ANALYSIS}
    if callable(analysis.get("features")):
        analysis["features"] = analysis["features"](motion)
    search = {name: value for name, value in setting.options.items() if name not in _ANALYSIS}
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
    given = round(case.truth.output_span * float(case.motion.rate)) + 1
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


def row_of(rows: Sequence[Row], options: Mapping[str, Any]) -> Row:
    """Find the row of a setting by its options; raise KeyError where there is none."""
    for row in rows:
        if row.setting.options == options:
            return row
    raise KeyError(str(dict(options)))


def without(row: Row, clip: str) -> Row:
    """Leave a clip out of a row."""
    return replace(row, preserved=tuple(one for one in row.preserved if one.clip != clip))
