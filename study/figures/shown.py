"""What figures are measured on: a motion as it is seen, and what it is measured against."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.evaluate.metrics import Spans
from retime.evaluate.metrics.flights import FlightTiming, flight_spans, flight_timing
from retime.evaluate.metrics.speeds import SpeedMatch, joint_speeds, match_speeds
from retime.evaluate.metrics.stillness import idle_spans
from retime.evaluate.metrics.walking import WalkedStep, WalkSpeeds, walk_speeds, walked_steps, walking_spans
from retime.motion.contacts import Contacts, contacts
from retime.motion.motion import Motion
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime
from study.clips.blows import wrists


@dataclass(frozen=True, eq=False)
class Subject:
    """An input, and what its versions are measured against.

    Attributes
    ----------
    motion, reference : Motion
        The input, and whose timing is wanted.
    truth : Warp, optional
        The known answer.
    spans : sequence of (float, float), optional
        Input times at which the answer has something to say; None: everywhere.
    wrists : Motion, optional
        Whose wrists' speeds are wanted.
    """

    motion: Motion
    reference: Motion
    truth: Warp | None = None
    spans: Spans | None = None
    wrists: Motion | None = None

    __repr__ = brief_repr

    @cached_property
    def flights(self) -> tuple[tuple[float, float], ...]:
        """The input's flights, seconds."""
        return flight_spans(self.motion)

    @cached_property
    def idle(self) -> tuple[tuple[float, float], ...]:
        """Where the input stands still, seconds."""
        return idle_spans(self.motion)

    @cached_property
    def steps(self) -> tuple[WalkedStep, ...]:
        """The input's walks, step by step."""
        return walked_steps(self.motion)

    @cached_property
    def standing(self) -> Contacts:
        """When the input's feet stand."""
        return contacts(self.motion)

    @cached_property
    def wrist_speeds(self) -> FloatArray | None:
        """The wrists' speeds that are wanted."""
        return None if self.wrists is None else joint_speeds(self.wrists, wrists(self.wrists))


@dataclass(frozen=True, eq=False)
class Shown:
    """A motion as it is seen: the input, a reference, or the input by a warp.

    Attributes
    ----------
    subject : Subject
        What it is measured against.
    motion : Motion
        What is seen.
    """

    subject: Subject
    motion: Motion

    __repr__ = brief_repr

    @cached_property
    def wrist_speeds(self) -> FloatArray | None:
        """Its own wrists' speeds, where some are wanted."""
        return None if self.subject.wrists is None else joint_speeds(self.motion, wrists(self.motion))

    @cached_property
    def wrists(self) -> SpeedMatch | None:
        """How its wrists' speeds lie to those that are wanted."""
        found, wanted = self.wrist_speeds, self.subject.wrist_speeds
        return None if found is None or wanted is None else match_speeds(found, wanted)


@dataclass(frozen=True, eq=False)
class Warped(Shown):
    """The input by a warp.

    Attributes
    ----------
    warp : Warp
        That warp.
    path : Warp, optional
        What a search decided, where there was one.
    keytimes : sequence of Keytime
        What was asked for.
    """

    warp: Warp
    path: Warp | None = None
    keytimes: Sequence[Keytime] = ()

    __repr__ = brief_repr

    @cached_property
    def decided(self) -> FlightTiming:
        """How flights are played by the path or, where there was no search, by the warp."""
        return flight_timing(self.warp if self.path is None else self.path, self.subject.flights)

    @cached_property
    def seen(self) -> FlightTiming:
        """How flights are played by the warp."""
        return flight_timing(self.warp, self.subject.flights)

    @cached_property
    def walks(self) -> WalkSpeeds | None:
        """How walks are played by the warp; None where nobody walks."""
        return walk_speeds(self.warp, walking_spans(self.subject.steps))
