"""Hands on one stretch of a clip, whose answer for the rest is known: limps, steps, slow jumps, stronger blows."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from retime.brief import brief_repr
from retime.evaluate.metrics import Spans
from retime.evaluate.metrics.flights import flight_spans
from retime.motion.motion import Motion
from retime.warp.curve import Warp
from study.answers.by_hand import frames_of, from_log_speed, part_of, slow_flights
from study.clips.blows import fast_spans, fastest_joint, wrists
from study.clips.library import Library
from study.clips.walks import cycles

# Beside a flight the answer is on its way to the flight's speed and back.
_RAMP = 0.1


@dataclass(frozen=True, eq=False)
class Case:
    """A hand on one stretch of a clip, and what is right for another clip, or for all of the same.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    motion : Motion
        The clip that should follow.
    example_clip : Motion
        The clip in which the example lies; the same, or another.
    example : (int, int)
        Its first and last frame.
    hand : Warp
        Its timing.
    truth : Warp
        The right warp for all of `motion`.
    changed, others : sequence of (float, float)
        Input times of `motion` that the hand treats in one way and in the other: left and right steps, flights and the
        rest. Recovery is how far they come apart.
    """

    kind: str
    motion: Motion
    example_clip: Motion
    example: tuple[int, int]
    hand: Warp
    truth: Warp
    changed: Spans
    others: Spans

    __repr__ = brief_repr

    @property
    def elsewhere(self) -> bool:
        """Whether the example lies in another clip."""
        return self.motion is not self.example_clip

    @property
    def example_times(self) -> tuple[float, float] | None:
        """Input times that the hand has retimed itself; None where the example lies in another clip."""
        if self.elsewhere:
            return None
        first, last = (frame / float(self.motion.rate) for frame in self.example)
        return first, last


Half = tuple[float, float, str]


def halves(motion: Motion) -> list[Half]:
    """List the steps of a walk: when each begins and ends, and whose foot is in front at its beginning.

    Of a step that the clip's beginning or end cuts off, a part is known too.
    """
    found = [(a.time, b.time, a.side) for a, b in cycles(motion)]
    if not found:
        return []
    usual = float(np.mean([end - start for start, end, _ in found]))
    other = {"left": "right", "right": "left"}
    # A walk that goes on to the clip's ends is not always seen to: its last foot may not get in front of the root.
    near = 1.25 * usual
    if found[0][0] < near:
        found.insert(0, (found[0][0] - usual, found[0][0], other[found[0][2]]))
    if motion.end_time - found[-1][1] < near:
        found.append((found[-1][1], found[-1][1] + usual, other[found[-1][2]]))
    return found


def limp(motion: Motion, *, strength: float, both: bool) -> Warp:
    """Hurry over the steps that begin with the left foot in front; where `both`, linger over the others too."""
    times = np.arange(motion.n_frames) / float(motion.rate)
    logs = np.zeros(motion.n_frames)
    for start, end, side in halves(motion):
        if side == "left" or both:
            inside = (times >= start) & (times < end)
            sign = 1.0 if side == "left" else -1.0
            logs[inside] = sign * math.log(strength) * np.sin(np.pi * (times[inside] - start) / (end - start))
    return from_log_speed(logs, motion)


def strengthen(motion: Motion, *, share: float = 0.5) -> Warp:
    """Give blows force: what is fast becomes faster, what is slow slower, between 0.6 and 1.8 times its speed."""
    speed = fastest_joint(motion, wrists(motion))
    logs = share * np.log(np.maximum(speed, 1e-9) / np.median(speed))
    return from_log_speed(np.clip(logs, math.log(0.6), math.log(1.8)), motion)


def _sides(motion: Motion) -> tuple[Spans, Spans]:
    clipped = [(max(0.0, start), min(motion.end_time, end), side) for start, end, side in halves(motion)]
    left, right = (tuple((a, b) for a, b, side in clipped if side == which) for which in ("left", "right"))
    return left, right


def _case(kind: str, motion: Motion, span: tuple[float, float], truth: Warp, changed: Spans, others: Spans) -> Case:
    """Take a stretch of a clip's own answer as the hand."""
    first, last = frames_of(motion, *span)
    hand = part_of(truth, first / float(motion.rate), last / float(motion.rate))
    return Case(kind, motion, motion, (first, last), hand, truth, changed, others)


def _strides(kind: str, motion: Motion, strength: float) -> Iterator[Case]:
    """Take every stride as the example, from either foot."""
    truth = limp(motion, strength=strength, both=True)
    for (a, b), (c, d) in itertools.pairwise(cycles(motion)):
        if b.time == c.time:
            yield _case(kind, motion, (a.time, d.time), truth, *_sides(motion))


def _steps(kind: str, motion: Motion) -> Iterator[Case]:
    """Take every step of the left foot as the example: the right one's keep their speed."""
    truth = limp(motion, strength=1.7, both=False)
    for a, b in cycles(motion):
        if a.side == "left":
            yield _case(kind, motion, (a.time, b.time), truth, *_sides(motion))


def _across(kind: str, example_clip: Motion, motion: Motion) -> Iterator[Case]:
    """Take the first stride of one clip as the example for another."""
    hand = limp(example_clip, strength=1.7, both=True)
    for (a, b), (c, d) in itertools.pairwise(cycles(example_clip)):
        if b.time == c.time:
            first, last = frames_of(example_clip, a.time, d.time)
            rate = float(example_clip.rate)
            part = part_of(hand, first / rate, last / rate)
            truth = limp(motion, strength=1.7, both=True)
            yield Case(kind, motion, example_clip, (first, last), part, truth, *_sides(motion))
            return


def _rest(spans: Spans, motion: Motion, margin: float = 0.0) -> Spans:
    """Return what lies between some stretches, and `margin` seconds away from them."""
    edges = [0.0, *(time for start, end in spans for time in (start - margin, end + margin)), motion.end_time]
    return tuple((a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b > a)


def _jump(kind: str, motion: Motion, span: tuple[float, float] | None) -> Case:
    """Slow one flight to half its speed; left out, the first one, with 0.8 s on either side."""
    flights = flight_spans(motion)
    start, end = span or (flights[0][0] - 0.8, flights[0][1] + 0.8)
    return _case(kind, motion, (start, end), slow_flights(motion), flights, _rest(flights, motion, _RAMP))


def _blows(kind: str, motion: Motion, start: float) -> Case:
    """Strengthen two and a half seconds of blows."""
    blows = fast_spans(motion, wrists(motion))
    return _case(kind, motion, (start, start + 2.5), strengthen(motion), blows, _rest(blows, motion))


STEADY = ("07_01", "07_09", "07_10", "07_12", "08_01", "08_08", "08_10")
"""Walks straight on, from the first frame to the last."""

TURNING = ("29_01", "86_01", "sample")
"""Walks that begin and end, turn, stand, or lead up to a jump."""

RUNS = tuple(f"35_{trial}" for trial in range(17, 27))
"""Runs that nothing was chosen on: the method was fixed before they were looked at."""

_ACROSS = (
    *(("07_01", "07_09"), ("07_01", "07_10"), ("07_01", "07_12"), ("08_01", "07_01")),
    *(("29_01", "07_01"), ("29_01", "07_12"), ("86_01", "07_01"), ("sample", "07_01")),
)


def _all(clips: Library, names: Sequence[str], take: Callable[[Motion], Iterator[Case]]) -> Iterator[Case]:
    for name in names:
        yield from take(clips[name])


KINDS: dict[str, Callable[[Library, str], Iterator[Case]]] = {
    "steady walks, a stride": lambda clips, kind: _all(clips, STEADY, lambda one: _strides(kind, one, 1.7)),
    "steady walks, a mild limp": lambda clips, kind: _all(clips, STEADY, lambda one: _strides(kind, one, 1.2)),
    "steady walks, one step": lambda clips, kind: _all(clips, STEADY, lambda one: _steps(kind, one)),
    "turns and stops, a stride": lambda clips, kind: _all(clips, TURNING, lambda one: _strides(kind, one, 1.7)),
    "turns and stops, one step": lambda clips, kind: _all(clips, TURNING, lambda one: _steps(kind, one)),
    "runs (second set), a stride": lambda clips, kind: _all(clips, RUNS, lambda one: _strides(kind, one, 1.7)),
    "runs (second set), one step": lambda clips, kind: _all(clips, RUNS, lambda one: _steps(kind, one)),
    "from another walk, a stride": lambda clips, kind: itertools.chain.from_iterable(
        _across(kind, clips[example], clips[clip]) for example, clip in _ACROSS
    ),
    "jumps": lambda clips, kind: iter(
        [
            _jump(kind, clips["01_01"], (0.9, 3.35)),
            _jump(kind, clips["49_02"], (0.9, 2.05)),
            _jump(kind, clips["sample"], None),
        ]
    ),
    "blows": lambda clips, kind: iter(
        [_blows(kind, clips[name], start) for name, start in (("boxing", 2.0), ("boxing", 6.0), ("17_10", 9.0))]
    ),
}
"""Cases by kind, in the order of the table."""
