"""V6: guide a slower passage of boxing by an aggressive one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from retime.search.poses.references import Reference
from retime.search.session import Session
from retime.warp.spline import linear_warp
from study.baselines.aligned import align_warp
from study.baselines.keyed import keyed_blows
from study.clips.library import Library
from study.defaults import AS_PRINTED, DEFAULTS
from study.evaluations.evaluation import Evaluation, PaperRow
from study.evaluations.timing import solve_timed
from study.evaluations.versions import VersionMaker
from study.figures.shown import Subject

KEY = "V6"
PAPER = PaperRow(601, 301, 301, 8, 1.3, 3.8, 0.23)


def evaluate(clips: Library, repeats: int) -> Evaluation:
    """Give the slower passage the timing of the aggressive one, its length kept."""
    motion = replace(clips.stretch("boxing", 10.0, 20.0), name="boxing, 10 to 20 s")
    reference = replace(clips.stretch("boxing", 0.0, 10.0), name="boxing, 0 to 10 s")
    options: dict[str, Any] = {"length": "100%", "max_skip": 8, "upsample": 2}
    found, row = solve_timed(motion, reference, {**DEFAULTS, **options}, repeats=repeats)
    printed = Session(motion, reference=Reference(reference), **AS_PRINTED).solve(**options)
    subject = Subject(motion, reference, wrists=reference)
    show = VersionMaker(subject)
    spline = keyed_blows(motion)
    versions = (
        show.input(),
        show.other("reference", "the aggressive passage", reference),
        show.version("linear", "the length is kept: as captured", linear_warp(found.warp.keytimes)),
        show.version("spline with keys", f"{len(spline.keytimes)} keytimes by hand: each blow at 1.6 times", spline),
        show.version("aligned", "timing carried over by dynamic time warping", align_warp(motion, reference)),
        show.guided(printed, "torso space, τ = 1/30 s", "guided, as printed"),
        show.guided(found, "length kept"),
    )
    return Evaluation(
        KEY,
        "Weak boxing made aggressive",
        "A slower passage takes its timing from an aggressive one; the length stays.",
        "Boxing_Toes, seconds 10 to 20, guided by seconds 0 to 10 of the same take.",
        motion,
        versions,
        found,
        row,
        subject.flights,
        options,
    )
