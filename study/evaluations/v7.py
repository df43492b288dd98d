"""V7: one cycle of a walk limps; the rest follows."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from retime.search.poses.references import Reference
from retime.search.session import Session
from retime.warp.spline import linear_warp
from study.answers.by_hand import example_of, limp
from study.baselines.aligned import align_warp
from study.baselines.keyed import spline_through
from study.clips.library import Library
from study.clips.walks import cycles, steps, walking_spans
from study.defaults import DEFAULTS
from study.evaluations.evaluation import Evaluation, PaperRow
from study.evaluations.timing import solve_timed
from study.evaluations.versions import VersionMaker
from study.figures.shown import Subject

KEY = "V7"
PAPER = PaperRow(573, 143, 45, 8, 0.9, 1.8, 0.14)


def evaluate(clips: Library, repeats: int) -> Evaluation:
    """Give the walk the timing of its one limping cycle, its length kept."""
    motion = replace(clips["29_01"].frames(0, 573), name="29_01")
    truth = limp(motion)
    first = next(a for a, _ in cycles(motion) if a.side == "left")
    end = next(b for a, b in cycles(motion) if a.time > first.time)
    reference = example_of(motion, truth, first.time, end.time)
    options: dict[str, Any] = {"length": "100%", "max_skip": 8, "upsample": 4}
    found, row = solve_timed(motion, reference, {**DEFAULTS, **options}, repeats=repeats)
    free = Session(motion, reference=Reference(reference), **DEFAULTS).solve(length="free", max_skip=8, upsample=4)
    subject = Subject(motion, reference, truth=truth, spans=walking_spans(motion))
    show = VersionMaker(subject)
    spline = spline_through(truth, [step.time for step in steps(motion)], rate=float(motion.rate))
    versions = (
        show.input(),
        show.version("by hand", "every cycle warped by hand: the answer", truth),
        show.version("linear", "the length is kept: as captured", linear_warp(found.warp.keytimes)),
        show.version("spline with keys", f"through {len(spline.keytimes)} of the hand's times: every step", spline),
        show.version(
            "aligned", "dynamic time warping to the cycle, repeated", align_warp(motion, reference, loop=True)
        ),
        show.guided(free, "length found by the search", "guided, free"),
        show.guided(found, "length kept, as in the paper"),
    )
    return Evaluation(
        KEY,
        "A walk made to limp",
        "One cycle was warped by hand, so that the left leg's half is hurried and the right one's lingers; the rest of "
        "the walk takes its timing from that cycle.",
        "CMU 29_01: walk, turn, walk; the first 573 frames, guided by one cycle of it.",
        motion,
        versions,
        found,
        row,
        subject.flights,
        options,
    )
