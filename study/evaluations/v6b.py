"""V6b: blows weakened by hand, whose answer is known."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from retime.warp.spline import linear_warp
from study.answers.cases import boxing_answer
from study.baselines.aligned import align_warp
from study.baselines.keyed import keyed_blows
from study.clips.library import Library
from study.defaults import DEFAULTS
from study.evaluations.evaluation import Evaluation
from study.evaluations.timing import solve_timed
from study.evaluations.versions import VersionMaker
from study.figures.shown import Subject

KEY = "V6b"
PAPER = None


def evaluate(clips: Library, repeats: int) -> Evaluation:
    """Give the weakened passage the timing of the other one, its length kept."""
    answer = boxing_answer("boxing", clips.stretch("boxing", 5.8, 10.3), clips.stretch("boxing", 0.0, 5.8))
    strong = replace(clips.stretch("boxing", 5.8, 10.3), name="boxing, 5.8 to 10.3 s")
    options: dict[str, Any] = {"length": "100%", "max_skip": 8, "upsample": 4}
    found, row = solve_timed(answer.motion, answer.reference, {**DEFAULTS, **options}, repeats=repeats)
    subject = Subject(answer.motion, answer.reference, truth=answer.truth, wrists=strong)
    show = VersionMaker(subject)
    spline = keyed_blows(answer.motion)
    versions = (
        show.input("its blows weakened by hand"),
        show.version("as it was", "the answer: the blows before they were weakened", answer.truth),
        show.version("linear", "the length is kept: as it came", linear_warp(found.warp.keytimes)),
        show.version("spline with keys", f"{len(spline.keytimes)} keytimes by hand: each blow at 1.6 times", spline),
        show.version(
            "aligned", "timing carried over by dynamic time warping", align_warp(answer.motion, answer.reference)
        ),
        show.guided(found, "length kept"),
    )
    return Evaluation(
        KEY,
        "Blows weakened by hand, made strong again",
        "Here the answer is known: the input is an aggressive passage whose blows were slowed by hand, the reference "
        "is another passage. Wrist speeds are compared with the passage as it was.",
        "Boxing_Toes, seconds 5.8 to 10.3, guided by seconds 0 to 5.8.",
        answer.motion,
        versions,
        found,
        row,
        subject.flights,
        options,
    )
