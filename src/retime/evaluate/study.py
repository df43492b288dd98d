"""The paper's eight evaluations (§4, V1 to V8) on public captures, at sizes as near to Table 1 as those allow.

Each is shown as the paper's video shows it, beside what else a person could do, and measured by
`retime.evaluate.metrics`. `retime study` runs it all; docs/study tells what came out.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from retime.brief import brief_repr
from retime.evaluate import metrics
from retime.evaluate.study_baselines import align_warp, cut_idle, keyed_spline, spans_to_keep, spline_through
from retime.evaluate.study_choices import AS_PRINTED, SETTINGS
from retime.evaluate.study_motions import (
    WRISTS,
    Library,
    boxing_answer,
    cycles,
    example_of,
    fast_spans,
    limp,
    limp_answer,
    slow_flights,
    steps,
    walking_spans,
)
from retime.motion.contacts import contacts
from retime.motion.motion import Motion
from retime.warp.apply import apply_warp
from retime.warp.curve import Keytime, Warp
from retime.warp.reference import Reference
from retime.warp.result import GuidedWarp
from retime.warp.session import Session
from retime.warp.spline import linear_warp

_ANALYSIS = ("n_neighbors", "time_scale", "low_pass", "features", "score", "rate")


@dataclass(frozen=True)
class PaperRow:
    """A row of the paper's Table 1; seconds on a 2.4 GHz Pentium 4.

    Attributes
    ----------
    n_input, n_output, n_reference, max_skip : int
        Its n, m, r, s.
    objective, search : float
        Seconds for evaluating the objective and for the full optimization.
    heuristic : float, optional
        Seconds for the optimization with the heuristic.
    """

    n_input: int
    n_output: int
    n_reference: int
    max_skip: int
    objective: float
    search: float
    heuristic: float | None


PAPER = {
    "V1": PaperRow(493, 280, 493, 8, 1.3, 2.7, 0.17),
    "V2": PaperRow(316, 180, 316, 10, 1.7, 1.4, 0.11),
    "V3": PaperRow(378, 180, 378, 8, 1.9, 1.4, 0.14),
    "V4": PaperRow(486, 320, 486, 8, 1.0, 2.6, 0.20),
    "V5": PaperRow(401, 150, 101, 4, 0.3, 0.7, 0.06),
    "V6": PaperRow(601, 301, 301, 8, 1.3, 3.8, 0.23),
    "V7": PaperRow(573, 143, 45, 8, 0.9, 1.8, 0.14),
    "V8": PaperRow(1524, 590, 91, 8, 2.5, 0.1, None),
}


@dataclass(frozen=True)
class TableRow:
    """A row of this study's table.

    Attributes
    ----------
    n_input, n_output, n_reference, max_skip, upsample : int
        Sizes of the search; upsample 1 is plain compression.
    features, objective, search : float
        Seconds for pose vectors, for scores, and for the exact search; medians of several runs.
    layered : float
        Seconds for the paper's own recurrence, which finds the same path.
    heuristic, excess : float, optional
        Seconds for the paper's coarse-to-fine search with its coarse scores, and the share by which its total exceeds
        the optimum; None where the length is free.
    optimal : bool
        Whether the path is proved to be the best.
    """

    n_input: int
    n_output: int
    n_reference: int
    max_skip: int
    upsample: int
    features: float
    objective: float
    search: float
    layered: float
    heuristic: float | None
    excess: float | None
    optimal: bool


@dataclass(frozen=True)
class Figures:
    """Figures of merit of one version; None where one does not apply.

    Attributes
    ----------
    seconds : float
        Length.
    keytimes_missed : float, optional
        Seconds by which the worst keytime is missed.
    fastest : float, optional
        The highest speed, over one analysis period.
    flight_frames, flight_frames_kept : int, optional
        In-flight frames of the input, and those at exactly unit speed (of the path, for a guided warp).
    flight_slowest, flight_fastest : float, optional
        Mean speeds of the slowest and fastest flight.
    gravity : float, optional
        Of all flights the gravity ratio that is farthest from 1; infinite where a flight is left with too few frames.
    idle : float, optional
        Seconds of standing still that are left.
    jerk : float
        Root mean square, m/s³.
    slip : float, optional
        Mean slip of feet that stand, millimetres a contact.
    distance : float
        Of local timing to the reference, centimetres a frame.
    speeds : tuple of float, optional
        Wrists: 50th, 90th and 99th percentile, m/s.
    speeds_distance : float, optional
        Of the wrists' speeds to those that are wanted, m/s.
    closeness : retime.evaluate.metrics.WarpMatch, optional
        To the known answer.
    """

    seconds: float
    keytimes_missed: float | None
    fastest: float | None
    flight_frames: int | None
    flight_frames_kept: int | None
    flight_slowest: float | None
    flight_fastest: float | None
    gravity: float | None
    idle: float | None
    jerk: float
    slip: float | None
    distance: float
    speeds: tuple[float, ...] | None = None
    speeds_distance: float | None = None
    closeness: metrics.WarpMatch | None = None


@dataclass(frozen=True, eq=False)
class Version:
    """One way to play a clip.

    Attributes
    ----------
    label : str
        What stands above it.
    note : str
        What it is.
    motion : Motion
        What is seen.
    warp : Warp, optional
        How the input became that; None for the input and for a reference.
    figures : Figures
        How it turned out.
    """

    label: str
    note: str
    motion: Motion
    warp: Warp | None
    figures: Figures

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class Evaluation:
    """One of the paper's evaluations, run.

    Attributes
    ----------
    key : str
        "V1" to "V8"; "V6b" and "V7b" are further ones, with known answers.
    title, about, clip : str
        What it shows, in words, and on which capture.
    motion : Motion
        The input.
    versions : tuple of Version
        The input's first; the one called "guided" is the method's.
    guided : GuidedWarp
        The method's result.
    row : TableRow
        Sizes and times.
    flights : tuple of (float, float)
        Of the input, seconds.
    options : mapping of str to object
        What `retime.guided_warp` was asked for, beyond `SETTINGS`.
    """

    key: str
    title: str
    about: str
    clip: str
    motion: Motion
    versions: tuple[Version, ...]
    guided: GuidedWarp
    row: TableRow
    flights: tuple[tuple[float, float], ...]
    options: Mapping[str, Any]

    __repr__ = brief_repr

    def version(self, label: str) -> Version:
        """Return a version by its label; raise KeyError where there is none."""
        for version in self.versions:
            if version.label == label:
                return version
        raise KeyError(label)


class _Looker:
    """Measures versions of one input."""

    def __init__(
        self,
        motion: Motion,
        reference: Motion,
        *,
        truth: Warp | None = None,
        spans: metrics.Spans | None = None,
        wrists: Motion | None = None,
    ) -> None:
        self.motion, self.reference, self.truth, self.spans = motion, reference, truth, spans
        self.flights = metrics.flight_spans(motion)
        self.idle = metrics.idle_spans(motion)
        self.wanted = None if wrists is None else metrics.joint_speeds(wrists, WRISTS)
        self.standing = contacts(motion)

    def figures(
        self, shown: Motion, warp: Warp | None, *, path: Warp | None = None, keys: Sequence[Keytime] = ()
    ) -> Figures:
        """Measure what is shown; `path` is what a search decided, where there was one."""
        distance = metrics.timing_distance(shown, self.reference, **_seen_as(SETTINGS)) * 100
        speeds = match = None
        if self.wanted is not None:
            match = metrics.match_speeds(metrics.joint_speeds(shown, WRISTS), self.wanted)
            speeds = match.quantiles
        common: dict[str, Any] = {
            "seconds": shown.end_time,
            "jerk": metrics.rms_jerk(shown),
            "distance": distance,
            "speeds": speeds,
            "speeds_distance": None if match is None else match.distance,
        }
        if warp is None:
            return Figures(
                keytimes_missed=None,
                fastest=None,
                flight_frames=None,
                flight_frames_kept=None,
                flight_slowest=None,
                flight_fastest=None,
                gravity=None,
                idle=None,
                slip=None,
                **common,
            )
        timing = metrics.flight_timing(warp if path is None else path, self.flights)
        speeds_seen = metrics.flight_timing(warp, self.flights)
        ratios = metrics.gravity_ratios(self.motion, shown, warp, self.flights)
        return Figures(
            keytimes_missed=metrics.match_keytimes(warp, keys).largest_error if keys else None,
            fastest=metrics.fastest_speed(warp),
            flight_frames=timing.n_frames if self.flights else None,
            flight_frames_kept=timing.n_kept if self.flights else None,
            flight_slowest=speeds_seen.slowest if self.flights else None,
            flight_fastest=speeds_seen.fastest if self.flights else None,
            gravity=_worst(ratios) if self.flights else None,
            idle=metrics.seconds_shown(warp, self.idle) if self.idle else None,
            slip=metrics.foot_slip(self.motion, shown, warp, standing=self.standing).mean
            if self.standing.at_rest.any()
            else None,
            closeness=None
            if self.truth is None or warp is self.truth
            else metrics.match_warps(warp, self.truth, spans=self.spans),
            **common,
        )

    def input(self, note: str = "as captured") -> Version:
        """Show the input as it is."""
        warp = _identity(self.motion)
        return Version("input", note, self.motion, None, self.figures(self.motion, warp))

    def version(self, label: str, note: str, warp: Warp, *, average: bool = True, **how: Any) -> Version:
        """Show the input by a warp."""
        shown = apply_warp(self.motion, warp, average=average)
        return Version(label, note, shown, warp, self.figures(shown, warp, keys=warp.keytimes, **how))

    def guided(self, found: GuidedWarp, note: str, label: str = "guided") -> Version:
        """Show the input by a guided warp."""
        return self.version(label, note, found.warp, path=metrics.path_warp(found))

    def other(self, label: str, note: str, motion: Motion) -> Version:
        """Show another motion beside it."""
        return Version(label, note, motion, None, self.figures(motion, None))


def _identity(motion: Motion) -> Warp:
    return Warp([0.0, motion.end_time], [0.0, motion.end_time])


def _seen_as(settings: Mapping[str, Any]) -> dict[str, Any]:
    return {name: settings[name] for name in ("features", "time_scale") if name in settings}


def _worst(ratios: np.ndarray) -> float:
    """Of some ratios the one that is farthest from 1; infinite where one could not be had."""
    if np.isnan(ratios).any() or np.any(ratios <= 0):
        return math.inf
    return float(ratios[np.argmax(np.abs(np.log(ratios)))])


def solve_timed(
    motion: Motion, reference: Motion | None, options: Mapping[str, Any], *, repeats: int = 5
) -> tuple[GuidedWarp, TableRow]:
    """Find a guided warp, several times over, and time its stages.

    Parameters
    ----------
    motion, reference : Motion
        Input and reference; None: the input itself.
    options : mapping of str to object
        Of `retime.guided_warp`.
    repeats : int
        Runs that the medians are of.
    """
    analysis = {name: value for name, value in options.items() if name in _ANALYSIS}
    search = {name: value for name, value in options.items() if name not in _ANALYSIS}
    seconds: list[dict[str, float]] = []
    layered, heuristic = [], []
    excess = None
    for _ in range(repeats):
        session = Session(motion, reference=None if reference is None else Reference(reference), **analysis)
        found = session.solve(**search)
        seconds.append(found.seconds)
        layered.append(session.solve(**search, search="layered").seconds["path"])
        if search.get("length") != "free":
            coarse = session.solve(**search, search="heuristic")
            # It finds the optimum too, to say how much it exceeds it: that is not part of its time.
            heuristic.append(max(0.0, coarse.seconds["path"] - found.seconds["path"]))
            excess = coarse.excess
    row = TableRow(
        found.n_input,
        found.n_output,
        found.n_reference,
        found.max_skip,
        found.upsample,
        statistics.median(one["features"] for one in seconds),
        statistics.median(one["scores"] for one in seconds),
        statistics.median(one["path"] for one in seconds),
        statistics.median(layered),
        statistics.median(heuristic) if heuristic else None,
        excess,
        found.path.optimal,
    )
    return found, row


def _preserve(
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
    """Give a clip another length, with the clip as its own reference (§4.1)."""
    options: dict[str, Any] = {"length": length, "max_skip": max_skip}
    if upsample is not None:
        options["upsample"] = upsample
    found, row = solve_timed(motion, None, {**SETTINGS, **options}, repeats=repeats)
    look = _Looker(motion, motion)
    versions = [look.input()]
    versions.append(look.version("linear", "one speed for all", linear_warp(found.warp.keytimes)))
    keep = spans_to_keep(motion, look.flights) if look.flights else _busy_spans(motion, look.idle)
    if sum(end - start for start, end in keep) < found.warp.output_span:
        what = "take-offs and landings" if look.flights else "beginning and end of what is no idling"
        spline = keyed_spline(motion, keep, found.warp.output_span)
        note = f"through {len(spline.keytimes)} keytimes set by hand: {what}"
        versions.append(look.version("spline with keys", note, spline))
    if silence:
        n_output = round(found.warp.output_span * float(motion.rate)) + 1
        cut = cut_idle(motion, n_output)
        versions.append(look.version("silence cut", "the frames that move least are dropped", cut, average=False))
    if beat is not None:
        at = look.flights[0][0]
        keyed = Session(motion, **SETTINGS).solve(length=length, max_skip=max_skip, keys=[(at, beat)])
        versions.append(look.guided(keyed, f"its first take-off put on a beat, at {beat:g} s", "guided, keyed"))
    versions.append(look.guided(found, "two keytimes, its ends"))
    return Evaluation(key, title, about, clip, motion, tuple(versions), found, row, look.flights, options)


def _busy_spans(motion: Motion, idle: metrics.Spans) -> tuple[tuple[float, float], ...]:
    """Everything but the idle stretches."""
    ends = [0.0, *(time for span in idle for time in span), motion.end_time]
    return tuple((start, end) for start, end in zip(ends[::2], ends[1::2], strict=True) if end > start)


def v1(clips: Library, repeats: int) -> Evaluation:
    """Silence removal on a dance with leaps."""
    return _preserve(
        "V1",
        "Silence removal",
        "Idle stretches are hurried through, leaps keep their time. The paper's 493 frames became 280.",
        "CMU 05_18: dance, attitude/arabesque, jeté en tourant, bending back; the whole clip.",
        clips["05_18"],
        "56.8%",
        max_skip=8,
        silence=True,
        repeats=repeats,
    )


def v2(clips: Library, repeats: int) -> Evaluation:
    """Silence removal on a short dance."""
    return _preserve(
        "V2",
        "Silence removal, a shorter clip",
        "As V1; there is less silence to remove.",
        "CMU 05_08: dance, rond de jambe, jeté, turn; the whole clip.",
        clips["05_08"],
        "57%",
        max_skip=10,
        silence=True,
        repeats=repeats,
    )


def v3(clips: Library, repeats: int) -> Evaluation:
    """Silence removal on a clip that is idle for more than half of its time."""
    return _preserve(
        "V3",
        "Silence removal, mostly silence",
        "Waiting, kneeling down, waiting, getting up: more than half of this clip is standing or kneeling still.",
        "test_mocapbank: the first 378 frames, at 30 Hz as captured.",
        replace(clips["mocapbank"].frames(0, 378), name="mocapbank"),
        "47.6%",
        max_skip=8,
        silence=True,
        repeats=repeats,
    )


def v4(clips: Library, repeats: int) -> Evaluation:
    """Walk, jump, walk, shortened."""
    return _preserve(
        "V4",
        "Walking and jumping, shortened",
        "There is no silence: the walk must give way, and the jumps should not.",
        "CMU 86_01, frames 1 to 1980: walk, jump, walk.",
        clips["86_01"],
        "65%",
        max_skip=8,
        beat=4.0,
        repeats=repeats,
    )


def v5(clips: Library, repeats: int) -> Evaluation:
    """Lengthen a jump."""
    motion = clips["02_04"]
    return _preserve(
        "V5",
        "Walking and jumping, lengthened",
        "The reverse: 150 % of the length, by upsampling four times.",
        "CMU 02_04: jump, balance; the first 401 frames, which are the paper's 101 at 30 Hz.",
        replace(motion.frames(0, 401), name="02_04"),
        "150%",
        max_skip=4,
        upsample=4,
        repeats=repeats,
    )


def v6(clips: Library, repeats: int) -> Evaluation:
    """Guide a slower passage of boxing by an aggressive one."""
    motion = replace(clips.stretch("boxing", 10.0, 20.0), name="boxing, 10 to 20 s")
    reference = replace(clips.stretch("boxing", 0.0, 10.0), name="boxing, 0 to 10 s")
    options: dict[str, Any] = {"length": "100%", "max_skip": 8, "upsample": 2}
    found, row = solve_timed(motion, reference, {**SETTINGS, **options}, repeats=repeats)
    printed = Session(motion, reference=Reference(reference), **AS_PRINTED).solve(**options)
    look = _Looker(motion, reference, wrists=reference)
    spline = _keyed_blows(motion)
    versions = (
        look.input(),
        look.other("reference", "the aggressive passage", reference),
        look.version("linear", "the length is kept: as captured", linear_warp(found.warp.keytimes)),
        look.version("spline with keys", f"{len(spline.keytimes)} keytimes by hand: each blow at 1.6 times", spline),
        look.version("aligned", "timing carried over by dynamic time warping", align_warp(motion, reference)),
        look.guided(printed, "torso space, τ = 1/30 s", "guided, as printed"),
        look.guided(found, "length kept"),
    )
    return Evaluation(
        "V6",
        "Weak boxing made aggressive",
        "A slower passage takes its timing from an aggressive one; the length stays.",
        "Boxing_Toes, seconds 10 to 20, guided by seconds 0 to 10 of the same take.",
        motion,
        versions,
        found,
        row,
        look.flights,
        options,
    )


def _keyed_blows(motion: Motion) -> Warp:
    """Hurry over every blow as an animator would, by keytimes around it; the length stays."""
    blows = spans_to_keep(motion, fast_spans(motion, WRISTS))
    return keyed_spline(motion, blows, motion.end_time, speed=1.6)


def v6b(clips: Library, repeats: int) -> Evaluation:
    """Blows weakened by hand, whose answer is known."""
    answer = boxing_answer("boxing", clips.stretch("boxing", 5.8, 10.3), clips.stretch("boxing", 0.0, 5.8))
    strong = replace(clips.stretch("boxing", 5.8, 10.3), name="boxing, 5.8 to 10.3 s")
    options: dict[str, Any] = {"length": "100%", "max_skip": 8, "upsample": 4}
    found, row = solve_timed(answer.motion, answer.reference, {**SETTINGS, **options}, repeats=repeats)
    look = _Looker(answer.motion, answer.reference, truth=answer.truth, wrists=strong)
    spline = _keyed_blows(answer.motion)
    versions = (
        look.input("its blows weakened by hand"),
        look.version("as it was", "the answer: the blows before they were weakened", answer.truth),
        look.version("linear", "the length is kept: as it came", linear_warp(found.warp.keytimes)),
        look.version("spline with keys", f"{len(spline.keytimes)} keytimes by hand: each blow at 1.6 times", spline),
        look.version("aligned", "timing carried over by dynamic time warping", align_warp(look.motion, look.reference)),
        look.guided(found, "length kept"),
    )
    return Evaluation(
        "V6b",
        "Blows weakened by hand, made strong again",
        "Here the answer is known: the input is an aggressive passage whose blows were slowed by hand, the reference "
        "is another passage. Wrist speeds are compared with the passage as it was.",
        "Boxing_Toes, seconds 5.8 to 10.3, guided by seconds 0 to 5.8.",
        answer.motion,
        versions,
        found,
        row,
        look.flights,
        options,
    )


def v7(clips: Library, repeats: int) -> Evaluation:
    """One cycle of a walk limps; the rest follows."""
    motion = replace(clips["29_01"].frames(0, 573), name="29_01")
    truth = limp(motion)
    first = next(a for a, _ in cycles(motion) if a.side == "left")
    end = next(b for a, b in cycles(motion) if a.time > first.time)
    reference = example_of(motion, truth, first.time, end.time)
    options: dict[str, Any] = {"length": "100%", "max_skip": 8, "upsample": 4}
    found, row = solve_timed(motion, reference, {**SETTINGS, **options}, repeats=repeats)
    free = Session(motion, reference=Reference(reference), **SETTINGS).solve(length="free", max_skip=8, upsample=4)
    look = _Looker(motion, reference, truth=truth, spans=walking_spans(motion))
    spline = spline_through(truth, [step.time for step in steps(motion)], rate=float(motion.rate))
    versions = (
        look.input(),
        look.version("by hand", "every cycle warped by hand: the answer", truth),
        look.version("linear", "the length is kept: as captured", linear_warp(found.warp.keytimes)),
        look.version("spline with keys", f"through {len(spline.keytimes)} of the hand's times: every step", spline),
        look.version(
            "aligned", "dynamic time warping to the cycle, repeated", align_warp(motion, reference, loop=True)
        ),
        look.guided(free, "length found by the search", "guided, free"),
        look.guided(found, "length kept, as in the paper"),
    )
    return Evaluation(
        "V7",
        "A walk made to limp",
        "One cycle was warped by hand, so that the left leg's half is hurried and the right one's lingers; the rest of "
        "the walk takes its timing from that cycle.",
        "CMU 29_01: walk, turn, walk; the first 573 frames, guided by one cycle of it.",
        motion,
        versions,
        found,
        row,
        look.flights,
        options,
    )


def v7b(clips: Library, repeats: int) -> Evaluation:
    """Carry a limp from one clip to another of the same person."""
    answer = limp_answer("07_01 on 07_10", clips["07_01"], clips["07_10"])
    motion, reference, truth = answer.motion, answer.reference, answer.truth
    options: dict[str, Any] = {"length": "free", "max_skip": 8, "upsample": 4}
    found, row = solve_timed(motion, reference, {**SETTINGS, **options}, repeats=repeats)
    given = round(truth.output_span * float(motion.rate)) + 1
    known = Session(motion, reference=Reference(reference), **SETTINGS).solve(length=given, max_skip=8, upsample=4)
    look = _Looker(motion, reference, truth=truth, spans=answer.spans)
    spline = spline_through(truth, [step.time for step in steps(motion)], rate=float(motion.rate))
    versions = (
        look.input(),
        look.version("by hand", "every cycle warped by hand: the answer", truth),
        look.version("linear", "one speed for all, to the hand's length", _stretched(motion, truth.output_span)),
        look.version("spline with keys", f"through {len(spline.keytimes)} of the hand's times: every step", spline),
        look.version(
            "aligned", "dynamic time warping to the cycle, repeated", align_warp(motion, reference, loop=True)
        ),
        look.guided(known, "the right length given", "guided, given length"),
        look.guided(found, "length found by the search"),
    )
    return Evaluation(
        "V7b",
        "The limp of one clip, put on another",
        "One cycle of one clip was warped by hand; another clip of the same person takes its timing from that cycle.",
        "CMU 07_10: walk; the whole clip, guided by one cycle of 07_01.",
        motion,
        versions,
        found,
        row,
        look.flights,
        options,
    )


def v8(clips: Library, repeats: int) -> Evaluation:
    """One jump is slowed; the rest follows, at a length that nobody gave."""
    motion = replace(clips["01_01"].frames(0, 1524), name="01_01")
    truth = slow_flights(motion)
    reference = example_of(motion, truth, 0.9, 3.35)
    options: dict[str, Any] = {"length": "free", "max_skip": 8, "upsample": 4}
    found, row = solve_timed(motion, reference, {**SETTINGS, **options}, repeats=repeats)
    session = Session(motion, reference=Reference(reference), **SETTINGS)
    plain = session.solve(**options, free_weight="sum")
    look = _Looker(motion, reference, truth=truth, spans=tuple((a - 0.3, b + 0.3) for a, b in _flights(motion)))
    spline = keyed_spline(motion, spans_to_keep(motion, look.flights), truth.output_span, speed=0.5)
    versions = (
        look.input(),
        look.version("by hand", "every flight at half its speed: the answer", truth),
        look.version("linear", "one speed for all, to the hand's length", _stretched(motion, truth.output_span)),
        look.version("spline with keys", f"{len(spline.keytimes)} keytimes by hand: take-offs and landings", spline),
        look.version("aligned", "dynamic time warping to the jump, repeated", align_warp(motion, reference, loop=True)),
        look.guided(plain, "guided, weighed by the paper's plain sum", "plain sum"),
        look.guided(found, "free length, each score weighed by the square root of its speed"),
    )
    return Evaluation(
        "V8",
        "Jumps emphasised by slow motion",
        "One flight was slowed to half by hand; the others follow, though they differ from it. The length is free.",
        "CMU 01_01: forward jumps, turn around; the first 1,524 frames, guided by 2.5 s of it.",
        motion,
        versions,
        found,
        row,
        look.flights,
        options,
    )


def _stretched(motion: Motion, output_span: float) -> Warp:
    """Play a whole clip at one speed."""
    return linear_warp(
        [Keytime(input_time=0.0, output_time=0.0), Keytime(input_time=motion.end_time, output_time=output_span)]
    )


def _flights(motion: Motion) -> tuple[tuple[float, float], ...]:
    return metrics.flight_spans(motion)


EVALUATIONS: dict[str, Callable[[Library, int], Evaluation]] = {
    "V1": v1,
    "V2": v2,
    "V3": v3,
    "V4": v4,
    "V5": v5,
    "V6": v6,
    "V6b": v6b,
    "V7": v7,
    "V7b": v7b,
    "V8": v8,
}
"""By key. Each takes the clips, and how often to repeat what is timed."""
