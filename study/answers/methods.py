"""How close the method comes to known answers, and how close others come. One entry of `METHODS` is one way."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from retime.brief import brief_repr
from retime.errors import RetimeWarning
from retime.evaluate.metrics.known_answer import WarpMatch, match_warps
from retime.search.imitate import imitate
from retime.search.poses.references import Reference
from retime.search.session import Session
from retime.warp.curve import Warp
from study.answers.by_hand import part_of
from study.answers.cases import ANSWERS, Answer
from study.baselines.aligned import align_warp
from study.baselines.steady import untouched
from study.clips.library import Library


@dataclass(frozen=True, eq=False)
class Asked:
    """A case, and the analysis that the guided warps share.

    Attributes
    ----------
    answer : Answer
        The case.
    settings : mapping of str to object
        Of the guided warps' analysis.
    """

    answer: Answer
    settings: Mapping[str, Any]

    __repr__ = brief_repr

    @cached_property
    def session(self) -> Session:
        """The input, analysed once."""
        return self.analysed()

    def analysed(self, **other: Any) -> Session:
        """Analyse the input with other choices."""
        return Session(self.answer.motion, reference=Reference(self.answer.reference), **{**self.settings, **other})

    def aligned(self, *, loop: bool = False) -> Warp:
        """Carry the reference's timing over by dynamic time warping."""
        answer = self.answer
        return align_warp(answer.motion, answer.reference, features=self.settings.get("features"), loop=loop)


def _imitated(asked: Asked) -> Warp | None:
    answer = asked.answer
    if not answer.free or answer.example is None:
        return None
    first, last = answer.example
    hand = part_of(answer.truth, *(frame / float(answer.motion.rate) for frame in answer.example))
    with warnings.catch_warnings():
        # What it warns of, examples that are no cycle and clips that do more than their example, is the question here.
        warnings.simplefilter("ignore", RetimeWarning)
        return imitate(answer.motion, (first, last + 1), hand, **asked.settings).warp


def _of_free_length(solve: Callable[[Asked], Warp]) -> Callable[[Asked], Warp | None]:
    """Ask only where the length is for the search to find."""
    return lambda asked: solve(asked) if asked.answer.free else None


def _at_given_length(asked: Asked) -> Warp:
    n_output = round(asked.answer.truth.output_span * float(asked.answer.motion.rate)) + 1
    return asked.session.solve(length=f"{n_output}f").warp


METHODS: dict[str, Callable[[Asked], Warp | None]] = {
    "nothing": lambda asked: untouched(asked.answer.motion),
    "aligned": lambda asked: asked.aligned(),
    "aligned, repeated": lambda asked: asked.aligned(loop=True),
    "guided, free": _of_free_length(lambda asked: asked.session.solve(length="free").warp),
    "imitate()": _imitated,
    "guided, conditional": _of_free_length(
        lambda asked: asked.analysed(score="conditional").solve(length="free").warp,
    ),
    "guided, plain sum": _of_free_length(
        lambda asked: asked.session.solve(length="free", free_weight="sum").warp,
    ),
    "guided, given length": _at_given_length,
}
"""What is compared, by name: doing nothing; dynamic time warping to the reference, and to the reference played over and
over; the guided warp at the length that it finds; the hand's speed carried over by `retime.imitate`; the guided warp by
the conditional score, and by the paper's plain sum; and at the right length. Each gives None for a case that it can't
be asked."""


@dataclass(frozen=True, eq=False)
class Attempt:
    """One method on one case.

    Attributes
    ----------
    method : str
        One of `METHODS`.
    warp : Warp
        What it found.
    inside : retime.evaluate.metrics.known_answer.WarpMatch
        Its closeness where the answer has something to say.
    whole : retime.evaluate.metrics.known_answer.WarpMatch
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
        asked = Asked(answer, settings)
        found = {method: solve(asked) for method, solve in METHODS.items()}
        attempts = [
            Attempt(method, warp, match_warps(warp, answer.truth, spans=answer.spans), match_warps(warp, answer.truth))
            for method, warp in found.items()
            if warp is not None
        ]
        yield Answered(answer, tuple(attempts))
