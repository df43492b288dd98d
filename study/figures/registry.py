"""All figures of merit, in the order of the table's columns.

`retime.evaluate.metrics` measures them; what each one means is told in docs/study.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from retime.evaluate.metrics.feet import foot_slip
from retime.evaluate.metrics.gravity import gravity_ratios
from retime.evaluate.metrics.keytimes import match_keytimes
from retime.evaluate.metrics.known_answer import WarpMatch, match_warps
from retime.evaluate.metrics.skipped import worst_skipped_pose
from retime.evaluate.metrics.smoothness import rms_jerk
from retime.evaluate.metrics.spans import seconds_shown
from retime.evaluate.metrics.speeds import fastest_speed, speed_contrast
from retime.evaluate.metrics.timing import timing_distance
from retime.evaluate.metrics.walking import WalkSpeeds, step_spread
from study.defaults import DEFAULTS
from study.figures.figure import Column, Figure, Figures, as_number, of_flights, of_warps
from study.figures.shown import Shown, Warped
from study.text import number

_SEEN_AS = {name: DEFAULTS[name] for name in ("features", "time_scale")}


def _keytimes_missed(shown: Warped) -> float | None:
    return match_keytimes(shown.warp, shown.keytimes).largest_error if shown.keytimes else None


def _gravity(shown: Warped) -> float:
    """Of all flights the ratio that is farthest from 1; infinite where one could not be had."""
    subject = shown.subject
    ratios = gravity_ratios(subject.motion, shown.motion, shown.warp, subject.flights)
    if np.isnan(ratios).any() or np.any(ratios <= 0):
        return math.inf
    return float(ratios[np.argmax(np.abs(np.log(ratios)))])


def _idle(shown: Warped) -> float | None:
    return seconds_shown(shown.warp, shown.subject.idle) if shown.subject.idle else None


def _slip(shown: Warped) -> float | None:
    subject = shown.subject
    if not subject.standing.at_rest.any():
        return None
    return foot_slip(subject.motion, shown.motion, shown.warp, standing=subject.standing).mean


def _distance(shown: Shown) -> float:
    """In centimetres."""
    return timing_distance(shown.motion, shown.subject.reference, **_SEEN_AS) * 100


def _closeness(shown: Warped) -> WarpMatch | None:
    truth = shown.subject.truth
    if truth is None or shown.warp is truth:
        return None
    return match_warps(shown.warp, truth, spans=shown.subject.spans)


def _skipped(shown: Warped) -> float:
    """In centimetres; of what a search decided, where there was one."""
    return worst_skipped_pose(shown.subject.motion, shown.warp if shown.path is None else shown.path) * 100


def _of_walks(measure: Callable[[WalkSpeeds], float]) -> Callable[[Shown], Any]:
    """Measure only where the input walks."""
    return of_warps(lambda shown: None if shown.walks is None else measure(shown.walks))


def _walking_speeds(low: float, figures: Figures) -> str:
    return f"{number(low)} to {number(figures['walk_high'])}"


def _walking_stretches(fast: float, figures: Figures) -> str:
    return f"{number(fast)} / {number(figures['walk_slow'])}"


def _count(n: int, figures: Figures) -> str:
    return str(n)


def _flight_speeds(slowest: float, figures: Figures) -> str:
    low, high = number(slowest), number(figures["flight_fastest"])
    return low if low == high else f"{low} to {high}"


FIGURES = (
    Figure("seconds", lambda shown: shown.motion.duration, (Column("length (s)", as_number()),)),
    Figure(
        "keytimes_missed",
        of_warps(_keytimes_missed),
        (Column("keytimes missed by (ms)", as_number(1, scale=1000)),),
    ),
    Figure(
        "fastest",
        of_warps(lambda shown: fastest_speed(shown.warp)),
        (Column("fastest (×)", as_number(1)),),
    ),
    Figure("flight_frames", of_flights(lambda shown: shown.decided.n_frames)),
    Figure(
        "flight_frames_kept",
        of_flights(lambda shown: shown.decided.n_kept),
        (Column("flight frames kept", lambda kept, figures: f"{kept} of {figures['flight_frames']}"),),
    ),
    Figure(
        "flight_slowest",
        of_flights(lambda shown: shown.seen.slowest),
        (Column("flights play at (×)", _flight_speeds),),
    ),
    Figure("flight_fastest", of_flights(lambda shown: shown.seen.fastest)),
    Figure("flights_leapt", of_flights(lambda shown: shown.seen.n_leapt), (Column("flights leapt over", _count),)),
    Figure("gravity", of_flights(_gravity), (Column("gravity (× input's)", as_number()),)),
    Figure("skipped", of_warps(_skipped), (Column("worst pose skipped (cm)", as_number(1)),)),
    Figure("walk_low", _of_walks(lambda walks: walks.low), (Column("walks at, 5 to 95 % (×)", _walking_speeds),)),
    Figure("walk_high", _of_walks(lambda walks: walks.high)),
    Figure(
        "walk_fast",
        _of_walks(lambda walks: walks.longest_fast),
        (Column("longest above 1.6 / below 0.6 (s)", _walking_stretches),),
    ),
    Figure("walk_slow", _of_walks(lambda walks: walks.longest_slow)),
    Figure(
        "steps_spread",
        of_warps(lambda shown: step_spread(shown.warp, shown.subject.steps)),
        (Column("spread of steps", as_number(3)),),
    ),
    Figure("idle", of_warps(_idle), (Column("standing still (s)", as_number()),)),
    Figure("jerk", lambda shown: rms_jerk(shown.motion), (Column("jerk (m/s³)", as_number(0)),)),
    Figure("slip", of_warps(_slip), (Column("foot slip (mm)", as_number(1)),)),
    Figure("distance", _distance, (Column("distance to reference (cm)", as_number(1)),)),
    Figure(
        "speeds",
        lambda shown: None if shown.wrists is None else shown.wrists.quantiles,
        (Column("wrists: 50, 90, 99 % below (m/s)", lambda speeds, _: " / ".join(map(number, speeds))),),
    ),
    Figure(
        "speeds_distance",
        lambda shown: None if shown.wrists is None else shown.wrists.distance,
        (Column("wrists: off by (m/s)", as_number()),),
    ),
    Figure(
        "contrast",
        lambda shown: None if shown.wrist_speeds is None else speed_contrast(shown.wrist_speeds),
        (Column("wrists: contrast", as_number()),),
    ),
    Figure(
        "closeness",
        of_warps(_closeness),
        (
            Column("correlation with the answer", lambda match, _: number(match.correlation)),
            Column("off in time (frames)", lambda match, _: number(match.mean_error, 1)),
        ),
    ),
)


def measured(shown: Shown) -> Figures:
    """Measure everything."""
    return {figure.name: figure.measure(shown) for figure in FIGURES}
