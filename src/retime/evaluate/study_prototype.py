"""The package beside the prototype that went before it: the same questions, as near as they can be asked again.

The prototype was thrown away; its figures are what was written down of it. It used torso space, eleven clips with
jumps of the same database, and a test for flights of its own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from retime.evaluate.metrics import match_warps
from retime.evaluate.sensitivity import Row, default_row, row_of
from retime.evaluate.study_motions import ANSWERS, Answer, Library
from retime.warp.reference import Reference
from retime.warp.session import Session

ACROSS = ("07_01 on 07_09", "07_01 on 07_10", "07_01 on 07_12")
"""A limp put on one clip, imitated on three others of the same person."""

_SHORT, _MIDDLE, _LONG = (1 / 30,), (0.1, 0.2), (1 / 3, 2 / 3)


@dataclass(frozen=True)
class Comparison:
    """One figure of the prototype, and the package's own.

    Attributes
    ----------
    what : str
        What was measured.
    prototype, here : str
        What came out.
    """

    what: str
    prototype: str
    here: str


def compare(clips: Library, rows: Sequence[Row], settings: Mapping[str, Any]) -> Iterator[Comparison]:
    """Put the prototype's questions to the package.

    Parameters
    ----------
    clips : Library
        The captures.
    rows : sequence of sensitivity.Row
        Of the whole sensitivity table: what it has answered is not asked again.
    settings : mapping of str to object
        The main choices, as the package makes them.
    """
    default = default_row(rows)
    for length, prototype in (("80%", "145 of 145"), ("65%", "145 of 145"), ("50%", "113–120 of 145")):
        kept, frames = default.kept_high(length)
        yield Comparison(f"in-flight frames kept at {length}", prototype, f"{kept} of {frames}")
    short = row_of(rows, {**settings, "time_scale": 1 / 30})
    for length, prototype in (("80%", "4 of 11"), ("65%", "3 of 11")):
        asked = [one for one in short.preserved if one.length == length and one.n_high]
        lost = sum(one.n_high_kept < one.n_high for one in asked)
        yield Comparison(f"clips that lose some with τ = 1/30 s, {length}", prototype, f"{lost} of {len(asked)}")
    cases = [ANSWERS[name](clips) for name in ACROSS]
    for score, scales, prototype in (
        ("joint", _SHORT, "0.63–0.79"),
        ("joint", _MIDDLE, "0.93–0.99"),
        ("joint", _LONG, "falls apart"),
        ("conditional", (*_SHORT, *_MIDDLE, *_LONG), "0.96–0.99"),
    ):
        found = [_correlations(cases, {**settings, "score": score, "time_scale": scale}) for scale in scales]
        what = f"limp of 07_01 on three others: correlation, {score}, τ = {_named(scales)} s"
        yield Comparison(what, prototype, _range(found))
    given = _correlations(cases, settings, given=True)
    yield Comparison("… with the right length given", "0.93–0.97", _range([given]))
    for weight, score, scale, prototype in (
        ("sum", "joint", 1 / 30, "47 %, 48 %"),
        ("sum", "joint", 0.1, "72 %, 66 %"),
        ("sum", "joint", 0.2, "95 %, 112 %"),
        ("neutral", "joint", 0.1, "94 %, 90 %"),
        ("neutral", "conditional", 0.1, "104 %, 118 %"),
        ("neutral", "joint", 0.2, "–"),
    ):
        row = row_of(rows, {**settings, "score": score, "time_scale": scale})
        ratios = [
            next(one.length_ratio for one in row.imitated if (one.case, one.length) == (case, weight))
            for case in ("01_01", "49_02")
        ]
        what = f"free length over the right one, 01_01 and 49_02: {weight}, {score}, τ = {_named([scale])} s"
        yield Comparison(what, prototype, ", ".join(f"{ratio * 100:.0f} %" for ratio in ratios))


def _correlations(cases: Iterable[Answer], settings: Mapping[str, Any], *, given: bool = False) -> list[float]:
    found = []
    for case in cases:
        session = Session(case.motion, reference=Reference(case.reference), **settings)
        length: str | int = round(case.truth.output_span * float(case.motion.rate)) + 1 if given else "free"
        found.append(match_warps(session.solve(length=length).warp, case.truth, spans=case.spans).correlation)
    return [float(np.nan_to_num(one)) for one in found]


def _range(found: Iterable[Iterable[float]]) -> str:
    values = [value for some in found for value in some]
    return f"{min(values):.2f}–{max(values):.2f}"


def _named(scales: Sequence[float]) -> str:
    names = {1 / 30: "1/30", 1 / 3: "1/3", 2 / 3: "2/3"}
    texts = [names.get(scale, f"{scale:g}") for scale in scales]
    return texts[0] if len(texts) == 1 else f"{texts[0]} to {texts[-1]}"
