"""V8: one jump is slowed; the rest follows, at a length that nobody gave."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from retime.evaluate.metrics.flights import flight_spans
from retime.search.poses.references import Reference
from retime.search.session import Session
from study.answers.by_hand import example_of, slow_flights
from study.baselines.aligned import align_warp
from study.baselines.keyed import keyed_spline, spans_to_keep
from study.baselines.steady import at_one_speed
from study.clips.library import Library
from study.defaults import DEFAULTS
from study.evaluations.evaluation import Evaluation, PaperRow
from study.evaluations.timing import solve_timed
from study.evaluations.versions import VersionMaker
from study.figures.shown import Subject

KEY = "V8"
PAPER = PaperRow(1524, 590, 91, 8, 2.5, 0.1, None)


def evaluate(clips: Library, repeats: int) -> Evaluation:
    """Give the clip the timing of its one slowed jump, its length free."""
    motion = replace(clips["01_01"].frames(0, 1524), name="01_01")
    truth = slow_flights(motion)
    reference = example_of(motion, truth, 0.9, 3.35)
    options: dict[str, Any] = {"length": "free", "max_skip": 8, "upsample": 4}
    found, row = solve_timed(motion, reference, {**DEFAULTS, **options}, repeats=repeats)
    session = Session(motion, reference=Reference(reference), **DEFAULTS)
    plain = session.solve(**options, free_weight="sum")
    subject = Subject(motion, reference, truth=truth, spans=tuple((a - 0.3, b + 0.3) for a, b in flight_spans(motion)))
    show = VersionMaker(subject)
    spline = keyed_spline(motion, spans_to_keep(motion, subject.flights), truth.output_span, speed=0.5)
    versions = (
        show.input(),
        show.version("by hand", "every flight at half its speed: the answer", truth),
        show.version("linear", "one speed for all, to the hand's length", at_one_speed(motion, truth.output_span)),
        show.version("spline with keys", f"{len(spline.keytimes)} keytimes by hand: take-offs and landings", spline),
        show.version("aligned", "dynamic time warping to the jump, repeated", align_warp(motion, reference, loop=True)),
        show.guided(plain, "guided, weighed by the paper's plain sum", "plain sum"),
        show.guided(found, "free length, each score weighed by the square root of its speed"),
    )
    return Evaluation(
        KEY,
        "Jumps emphasised by slow motion",
        "One flight was slowed to half by hand; the others follow, though they differ from it. The length is free.",
        "CMU 01_01: forward jumps, turn around; the first 1,524 frames, guided by 2.5 s of it.",
        motion,
        versions,
        found,
        row,
        subject.flights,
        options,
    )
