"""The cases: an input, a reference, and the warp that is right. One entry of `ANSWERS` each."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace

from retime.brief import brief_repr
from retime.errors import OptionError
from retime.evaluate.metrics.flights import flight_spans
from retime.motion.motion import Motion
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from study.answers.by_hand import example_of, frames_of, limp, slow_flights, weaken
from study.clips.blows import wrists
from study.clips.library import Library
from study.clips.walks import cycles, walking_spans


@dataclass(frozen=True, eq=False)
class Answer:
    """An input, a reference, and the warp that is right.

    Attributes
    ----------
    name : str
        Of the case.
    kind : str
        "limp", "jump" or "boxing".
    motion : Motion
        The input.
    reference : Motion
        The stretch that was retimed by hand, retimed.
    truth : Warp
        The right warp of the whole input.
    spans : tuple of (float, float)
        Input times at which the truth has something to say: elsewhere it only says "leave it".
    free : bool
        Whether the length is for the search to find.
    example : (int, int), optional
        First and last frame of the retimed stretch, where it is one of the input's own.
    """

    name: str
    kind: str
    motion: Motion
    reference: Motion
    truth: Warp
    spans: tuple[tuple[float, float], ...]
    free: bool = True
    example: tuple[int, int] | None = None

    __repr__ = brief_repr


def _limp_cycle(motion: Motion) -> tuple[float, float]:
    """Find the first whole cycle of a walk that begins with the left foot in front."""
    halves = cycles(motion)
    for (a, b), (c, d) in itertools.pairwise(halves):
        if a.side == "left" and b.time == c.time:
            return a.time, d.time
    raise OptionError(f"{motion.name or 'the motion'} has no whole cycle of a walk")


def limp_answer(name: str, example: Motion, motion: Motion) -> Answer:
    """Give the limp of one cycle of `example` as the reference for `motion` (which may be the same)."""
    cycle = _limp_cycle(example)
    reference = example_of(example, limp(example), *cycle)
    own = frames_of(motion, *cycle) if example is motion else None
    return Answer(name, "limp", motion, reference, limp(motion), walking_spans(motion), example=own)


def jump_answer(name: str, motion: Motion, start: float, end: float) -> Answer:
    """Give a stretch with one slowed flight as the reference for the whole clip."""
    truth = slow_flights(motion)
    spans = tuple((max(0.0, a - 0.3), min(motion.end_time, b + 0.3)) for a, b in flight_spans(motion))
    own = frames_of(motion, start, end)
    return Answer(name, "jump", motion, example_of(motion, truth, start, end), truth, spans, example=own)


def boxing_answer(name: str, strong: Motion, reference: Motion) -> Answer:
    """Weaken blows by hand; the truth gives them their force back."""
    hand = weaken(strong, wrists(strong))
    weak = replace(apply_warp(strong, hand, average=False), name=f"{strong.name}, weakened")
    truth = Warp(hand.input_times, hand.output_times, method="hand")
    return Answer(name, "boxing", weak, reference, truth, ((0.0, weak.end_time),), free=False)


def _jump(clip: str, start: float, end: float) -> Callable[[Library], Answer]:
    return lambda clips: jump_answer(clip, clips[clip], start, end)


def _limp_across(example: str, clip: str) -> Callable[[Library], Answer]:
    return lambda clips: limp_answer(f"{example} on {clip}", clips[example], clips[clip])


def _sample_jump(clips: Library) -> Answer:
    motion = clips["sample"]
    first = flight_spans(motion)[0]
    return jump_answer("sample, jump", motion, first[0] - 0.8, first[1] + 0.8)


ANSWERS: dict[str, Callable[[Library], Answer]] = {
    "29_01": lambda clips: limp_answer("29_01", clips["29_01"], clips["29_01"]),
    "07_01": lambda clips: limp_answer("07_01", clips["07_01"], clips["07_01"]),
    "07_01 on 07_09": _limp_across("07_01", "07_09"),
    "07_01 on 07_10": _limp_across("07_01", "07_10"),
    "07_01 on 07_12": _limp_across("07_01", "07_12"),
    "sample, limp": lambda clips: limp_answer("sample, limp", clips["sample"], clips["sample"]),
    # From standing to standing, with the flight in the middle.
    "01_01": _jump("01_01", 0.9, 3.35),
    "49_02": _jump("49_02", 0.9, 2.05),
    "sample, jump": _sample_jump,
    "boxing": lambda clips: boxing_answer(
        "boxing", clips.stretch("boxing", 5.8, 10.3), clips.stretch("boxing", 0.0, 5.8)
    ),
}
"""Cases by name. The examples of jumps are stretches around one flight, in seconds."""
