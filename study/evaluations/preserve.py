"""What V1 to V5 have in common: a clip gets another length, with the clip as its own reference (§4.1)."""

from __future__ import annotations

from typing import Any

from retime.evaluate.metrics import Spans
from retime.motion.motion import Motion
from retime.search.session import Session
from retime.warp.spline import linear_warp
from study.baselines.cut import cut_idle
from study.baselines.keyed import keyed_spline, spans_to_keep
from study.defaults import DEFAULTS, WITHOUT_HURRY
from study.evaluations.evaluation import Evaluation
from study.evaluations.timing import solve_timed
from study.evaluations.versions import VersionMaker
from study.figures.shown import Subject


def preserve(
    key: str,
    title: str,
    about: str,
    clip: str,
    motion: Motion,
    length: str,
    *,
    max_skip: int,
    upsample: int | None = None,
    silence: bool = False,
    beat: float | None = None,
    repeats: int = 5,
) -> Evaluation:
    """Give a clip another length.

    Parameters
    ----------
    key, title, about, clip : str
        As `Evaluation` has them.
    motion : Motion
        The input.
    length : str
        As `retime.guided_warp` takes it; so are `max_skip` and `upsample`, which are those of the row of Table 1.
    silence : bool
        Whether to show silence cut out, too.
    beat : float, optional
        Output time, seconds: a version with the first take-off there is shown, too.
    repeats : int
        Runs that times are medians of.
    """
    literal: dict[str, Any] = {"length": length, "max_skip": max_skip, **WITHOUT_HURRY}
    if upsample is not None:
        literal["upsample"] = upsample
    # Table 1 is about the paper's own sizes. Natural hurry has steps of its own, so that it can show a speed of 1.25.
    before, row = solve_timed(motion, None, {**DEFAULTS, **literal}, repeats=repeats)
    session = Session(motion, **DEFAULTS)
    found = session.solve(length=length)
    subject = Subject(motion, motion)
    show = VersionMaker(subject)
    versions = [show.input()]
    versions.append(show.version("linear", "one speed for all", linear_warp(found.warp.keytimes)))
    keep = spans_to_keep(motion, subject.flights) if subject.flights else _busy_spans(motion, subject.idle)
    if sum(end - start for start, end in keep) < found.warp.output_span:
        what = "take-offs and landings" if subject.flights else "beginning and end of what is no idling"
        spline = keyed_spline(motion, keep, found.warp.output_span)
        note = f"through {len(spline.keytimes)} keytimes set by hand: {what}"
        versions.append(show.version("spline with keys", note, spline))
    if silence:
        n_output = round(found.warp.output_span * float(motion.rate)) + 1
        cut = cut_idle(motion, n_output)
        versions.append(show.version("silence cut", "the frames that move least are dropped", cut, average=False))
    if beat is not None:
        at = subject.flights[0][0]
        keyed = session.solve(length=length, keys=[(at, beat)])
        versions.append(show.guided(keyed, f"its first take-off put on a beat, at {beat:g} s", "guided, keyed"))
    versions.append(show.guided(before, "no price on tempo, the paper's longest step", "guided, no hurry"))
    versions.append(show.guided(found, "two keytimes, its ends"))
    return Evaluation(key, title, about, clip, motion, tuple(versions), found, row, subject.flights, {"length": length})


def _busy_spans(motion: Motion, idle: Spans) -> tuple[tuple[float, float], ...]:
    """Everything but the idle stretches."""
    ends = [0.0, *(time for span in idle for time in span), motion.end_time]
    return tuple((start, end) for start, end in zip(ends[::2], ends[1::2], strict=True) if end > start)
