"""V6c: weak boxing guided by boxing of more contrast, on one skeleton."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from retime.search.poses.references import Reference
from retime.search.session import Session
from retime.warp.spline import linear_warp
from study.answers.by_hand import weaken
from study.baselines.aligned import align_warp
from study.baselines.keyed import keyed_blows
from study.clips.blows import wrists
from study.clips.library import Library
from study.defaults import AS_PRINTED, DEFAULTS
from study.evaluations.evaluation import Evaluation
from study.evaluations.timing import solve_timed
from study.evaluations.versions import VersionMaker
from study.figures.shown import Subject

KEY = "V6c"
PAPER = None


def evaluate(clips: Library, repeats: int) -> Evaluation:
    """Give the weak passage the timing of the aggressive one, its length kept."""
    motion = replace(clips.stretch("17_10", 9.0, 12.0), name="17_10, 9 to 12 s")
    reference = replace(clips.stretch("17_10", 18.0, 21.0), name="17_10, 18 to 21 s")
    options: dict[str, Any] = {"length": "100%", "max_skip": 8, "upsample": 2}
    found, row = solve_timed(motion, reference, {**DEFAULTS, **options}, repeats=repeats)
    printed = Session(motion, reference=Reference(reference), **AS_PRINTED).solve(**options)
    by_hand = weaken(motion, wrists(motion), share=-0.5)
    subject = Subject(motion, reference, truth=by_hand, wrists=reference)
    show = VersionMaker(subject)
    spline = keyed_blows(motion)
    versions = (
        show.input(),
        show.other("reference", "the aggressive passage", reference),
        show.version("by hand", "its blows strengthened by hand: the answer", by_hand),
        show.version("linear", "the length is kept: as captured", linear_warp(found.warp.keytimes)),
        show.version("spline with keys", f"{len(spline.keytimes)} keytimes by hand: each blow at 1.6 times", spline),
        show.version("aligned", "timing carried over by dynamic time warping", align_warp(motion, reference)),
        show.guided(printed, "torso space, τ = 1/30 s", "guided, as printed"),
        show.guided(found, "length kept"),
    )
    return Evaluation(
        KEY,
        "Weak boxing, guided by boxing of more contrast",
        "Here the reference's blows stand out from what lies between them more than the input's do (contrast), so "
        "that there is something to carry over. The blows strengthened by hand are what a person would want.",
        "CMU 17_10, seconds 9 to 12, guided by seconds 18 to 21 of the same take.",
        motion,
        versions,
        found,
        row,
        subject.flights,
        options,
    )
