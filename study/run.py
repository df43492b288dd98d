"""Runs the study: all of its questions, in an order that keeps timings clean."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from retime.brief import brief_repr
from retime.errors import OptionError
from study.answers.methods import Answered, answer_all
from study.choices.questions import Row, measure
from study.choices.settings import settings
from study.clips.library import Library
from study.defaults import DEFAULTS
from study.evaluations.evaluation import Evaluation
from study.evaluations.registry import EVALUATIONS
from study.propagation.measure import Propagated, propagate_all
from study.sets.measure import Played, play_sets
from study.signals.ball import SignalResult, warp_signal
from study.signals.camera import CameraResult, warp_camera
from study.signals.curve import CurveResult, warp_curve

PARTS = (*EVALUATIONS, "sets", "answers", "propagation", "sensitivity", "signals")
"""What `run` can be asked for."""


@dataclass(frozen=True, eq=False)
class Results:
    """What came out.

    Attributes
    ----------
    evaluations : tuple of Evaluation
        Those that were run, V1 first.
    played : tuple of Played
        Both sets of clips; empty where they were not asked for.
    answered : tuple of Answered
        Known answers; empty where they were not asked for.
    propagated : tuple of Propagated
        What came of each hand; empty where it was not asked for.
    sensitivity : tuple of Row
        One a setting; empty where it was not asked for.
    camera, curve, ball : CameraResult, CurveResult and SignalResult, optional
        Beyond motion.
    seconds : float
        For all of it.
    machine : dict of str to str
        What it ran on, as far as it matters to times.
    """

    evaluations: tuple[Evaluation, ...]
    played: tuple[Played, ...]
    answered: tuple[Answered, ...]
    propagated: tuple[Propagated, ...]
    sensitivity: tuple[Row, ...]
    camera: CameraResult | None
    curve: CurveResult | None
    ball: SignalResult | None
    seconds: float
    machine: dict[str, str]

    __repr__ = brief_repr


def chosen_parts(only: str | None) -> tuple[str, ...]:
    """Read a choice of parts such as ``V1,V7,answers``; None is all of them.

    Raises
    ------
    OptionError
        There is no such part.

    Examples
    --------
    >>> chosen_parts("v7, answers")
    ('V7', 'answers')
    """
    if only is None:
        return PARTS
    by_name = {part.lower(): part for part in PARTS}
    asked = [name.strip() for name in only.split(",") if name.strip()]
    for name in asked:
        if name.lower() not in by_name:
            raise OptionError(f"the study has no part {name!r}; it has {', '.join(PARTS)}")
    if not asked:
        raise OptionError(f"no part of the study is named; it has {', '.join(PARTS)}")
    wanted = {by_name[name.lower()] for name in asked}
    return tuple(part for part in PARTS if part in wanted)


def run(
    clips: Library,
    parts: Sequence[str] = PARTS,
    *,
    quick: bool = False,
    say: Callable[[str], None] = lambda text: None,
) -> Results:
    """Run some parts of the study, or all.

    Parameters
    ----------
    clips : Library
        The captures.
    parts : sequence of str
        From `PARTS`.
    quick : bool
        Time each thing once, and compare the main settings alone.
    say : function
        Called with the name of each part as it begins.
    """
    start, worked = time.perf_counter(), time.process_time()
    evaluations = []
    for key, evaluate in EVALUATIONS.items():
        if key in parts:
            say(key)
            evaluations.append(evaluate(clips, 1 if quick else 7))
    played: tuple[Played, ...] = ()
    if "sets" in parts:
        say("two sets of clips")
        played = tuple(play_sets(clips))
    answered: tuple[Answered, ...] = ()
    if "answers" in parts:
        say("known answers")
        answered = tuple(answer_all(clips, DEFAULTS))
    propagated: tuple[Propagated, ...] = ()
    if "propagation" in parts:
        say("propagation")
        propagated = tuple(propagate_all(clips))
    rows: tuple[Row, ...] = ()
    if "sensitivity" in parts:
        say("sensitivity")
        chosen = settings(DEFAULTS)
        rows = tuple(measure(clips, chosen[:2] if quick else chosen))
    camera = curve = ball = None
    if "signals" in parts:
        say("beyond motion")
        shortened = next((one for one in evaluations if one.key == "V4"), None) or EVALUATIONS["V4"](clips, 1)
        camera = warp_camera(shortened.motion, shortened.guided.warp)
        curve = warp_curve(shortened.motion, shortened.guided.warp)
        ball = warp_signal()
    machine = {
        "python": platform.python_version(),
        "processor": platform.machine(),
        "cores": str(os.cpu_count()),
        # Of all threads: what it takes where nothing else runs is this or less.
        "processor time": f"{time.process_time() - worked:.0f} s",
    }
    return Results(
        tuple(evaluations),
        played,
        answered,
        propagated,
        rows,
        camera,
        curve,
        ball,
        time.perf_counter() - start,
        machine,
    )
