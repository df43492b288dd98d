"""V7b: carry a limp from one clip to another of the same person."""

from __future__ import annotations

from typing import Any

from retime.search.poses.references import Reference
from retime.search.session import Session
from study.answers.cases import limp_answer
from study.baselines.aligned import align_warp
from study.baselines.keyed import spline_through
from study.baselines.steady import at_one_speed
from study.clips.library import Library
from study.clips.walks import steps
from study.defaults import DEFAULTS
from study.evaluations.evaluation import Evaluation
from study.evaluations.timing import solve_timed
from study.evaluations.versions import VersionMaker
from study.figures.shown import Subject

KEY = "V7b"
PAPER = None


def evaluate(clips: Library, repeats: int) -> Evaluation:
    """Give the walk the timing of the other clip's limping cycle, its length free."""
    answer = limp_answer("07_01 on 07_10", clips["07_01"], clips["07_10"])
    motion, reference, truth = answer.motion, answer.reference, answer.truth
    options: dict[str, Any] = {"length": "free", "max_skip": 8, "upsample": 4}
    found, row = solve_timed(motion, reference, {**DEFAULTS, **options}, repeats=repeats)
    given = f"{round(truth.output_span * float(motion.rate)) + 1}f"
    known = Session(motion, reference=Reference(reference), **DEFAULTS).solve(length=given, max_skip=8, upsample=4)
    subject = Subject(motion, reference, truth=truth, spans=answer.spans)
    show = VersionMaker(subject)
    spline = spline_through(truth, [step.time for step in steps(motion)], rate=float(motion.rate))
    versions = (
        show.input(),
        show.version("by hand", "every cycle warped by hand: the answer", truth),
        show.version("linear", "one speed for all, to the hand's length", at_one_speed(motion, truth.output_span)),
        show.version("spline with keys", f"through {len(spline.keytimes)} of the hand's times: every step", spline),
        show.version(
            "aligned", "dynamic time warping to the cycle, repeated", align_warp(motion, reference, loop=True)
        ),
        show.guided(known, "the right length given", "guided, given length"),
        show.guided(found, "length found by the search"),
    )
    return Evaluation(
        KEY,
        "The limp of one clip, put on another",
        "One cycle of one clip was warped by hand; another clip of the same person takes its timing from that cycle.",
        "CMU 07_10: walk; the whole clip, guided by one cycle of 07_01.",
        motion,
        versions,
        found,
        row,
        subject.flights,
        options,
    )
