"""How close the method comes to known answers, and how close others come."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from retime.brief import brief_repr
from retime.evaluate.metrics import WarpMatch, match_warps
from retime.evaluate.study_baselines import align_warp
from retime.evaluate.study_motions import ANSWERS, Answer, Library, part_of
from retime.warp.curve import Warp
from retime.warp.imitate import imitate
from retime.warp.reference import Reference
from retime.warp.session import Session

METHODS = (
    *("nothing", "aligned", "aligned, repeated", "guided, free", "imitate()", "guided, conditional"),
    *("guided, plain sum", "guided, given length"),
)
"""What is compared: doing nothing; dynamic time warping to the reference, and to the reference played over and over;
the guided warp at the length that it finds, the same asked for by `retime.imitate`, by the conditional score, and by
the paper's plain sum; and at the right length."""


@dataclass(frozen=True, eq=False)
class Attempt:
    """One method on one case.

    Attributes
    ----------
    method : str
        One of `METHODS`.
    warp : Warp
        What it found.
    inside : retime.evaluate.metrics.WarpMatch
        Its closeness where the answer has something to say.
    whole : retime.evaluate.metrics.WarpMatch
        Its closeness over the whole clip, what has no counterpart in the reference included.
    """

    method: str
    warp: Warp
    inside: WarpMatch
    whole: WarpMatch

    __repr__ = brief_repr


@dataclass(frozen=True, eq=False)
class Answered:
    """A case and what the methods made of it."""

    answer: Answer
    attempts: tuple[Attempt, ...]

    __repr__ = brief_repr

    def attempt(self, method: str) -> Attempt | None:
        """Return a method's attempt; None where it was not asked."""
        return next((one for one in self.attempts if one.method == method), None)


def answer_all(
    clips: Library, settings: Mapping[str, Any], *, names: Sequence[str] = tuple(ANSWERS)
) -> Iterator[Answered]:
    """Put every case to every method.

    Parameters
    ----------
    clips : Library
        The captures.
    settings : mapping of str to object
        Of the guided warp's analysis.
    names : sequence of str
        Cases.
    """
    for name in names:
        answer = ANSWERS[name](clips)
        found = dict(_warps(answer, settings))
        attempts = [
            Attempt(method, warp, match_warps(warp, answer.truth, spans=answer.spans), match_warps(warp, answer.truth))
            for method, warp in found.items()
        ]
        yield Answered(answer, tuple(attempts))


def _warps(answer: Answer, settings: Mapping[str, Any]) -> Iterator[tuple[str, Warp]]:
    motion, reference = answer.motion, answer.reference
    features = settings.get("features")
    yield METHODS[0], Warp([0.0, motion.end_time], [0.0, motion.end_time])
    yield METHODS[1], align_warp(motion, reference, features=features)
    yield METHODS[2], align_warp(motion, reference, features=features, loop=True)
    session = Session(motion, reference=Reference(reference), **settings)
    if answer.free:
        yield METHODS[3], session.solve(length="free").warp
        if answer.example is not None:
            first, last = answer.example
            hand = part_of(answer.truth, *(frame / float(motion.rate) for frame in answer.example))
            yield METHODS[4], imitate(motion, (first, last + 1), hand, **settings).warp
        other = Session(motion, reference=Reference(reference), **{**settings, "score": "conditional"})
        yield METHODS[5], other.solve(length="free").warp
        yield METHODS[6], session.solve(length="free", free_weight="sum").warp
    yield METHODS[7], session.solve(length=round(answer.truth.output_span * float(motion.rate)) + 1).warp
