"""Locks: spans of the input that play at given speeds, and where they bind the unrolled input."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from retime.checks import real
from retime.errors import OptionError
from retime.kernels import StepPairs
from retime.search.reduction import Reduction, nearest_frame
from retime.search.wishes.steps import NOTHING_NAMED, Named, fixed_step, playable, steps_between


@dataclass(frozen=True)
class Lock:
    """A span of the input that plays at a given speed, or inside a range of speeds.

    A lock from 0 to 1 keeps every frame: the span may be slowed down but not cut.

    Attributes
    ----------
    start, end : float
        Input times, seconds.
    slowest, fastest : float
        Playback speeds; equal ones fix the speed.

    Raises
    ------
    OptionError
        The span is empty, or the speeds are no range of speeds above 0.
    """

    start: float
    end: float
    slowest: float = 1.0
    fastest: float = 1.0

    def __post_init__(self) -> None:
        for name in ("start", "end", "slowest", "fastest"):
            object.__setattr__(self, name, real(getattr(self, name), f"the {name} of a lock"))
        if not (math.isfinite(self.start) and math.isfinite(self.end) and self.start < self.end):
            raise OptionError(f"a lock needs a span of the input; {self.start:g} s to {self.end:g} s is none")
        if not (0 <= self.slowest <= self.fastest and 0 < self.fastest < math.inf):
            raise OptionError(
                f"a lock needs speeds above 0, the slowest first; found {self.slowest:g} to {self.fastest:g}"
            )

    @property
    def fixed(self) -> bool:
        """Whether only one speed is allowed."""
        return self.slowest == self.fastest

    def __str__(self) -> str:
        speeds = f"{self.slowest:g}" if self.fixed else f"{self.slowest:g} to {self.fastest:g}"
        return f"{self.start:g}–{self.end:g} s at {speeds}"


@dataclass(frozen=True)
class LockedSpan:
    """Where a lock binds the unrolled input.

    Attributes
    ----------
    first, last : int
        Unrolled frames that the path must visit.
    steps : tuple of int
        The steps that it may take between them, in rising order.
    speed : float, optional
        Where the lock fixes it.
    span : int
        The span between keytimes that it lies in.
    start, end : float
        The lock's own input times, which the frames come nearest to.
    """

    first: int
    last: int
    steps: tuple[int, ...]
    speed: float | None = None
    span: int = 0
    start: float = 0.0
    end: float = 0.0


def locked_spans(
    reduction: Reduction, steps: StepPairs, input_end: float, locks: Sequence[Lock], *, named: Named = NOTHING_NAMED
) -> tuple[LockedSpan, ...]:
    """Find the unrolled frames that locks bind.

    A lock begins at the unrolled frame nearest to its start, and ends after the whole number of steps that brings it
    nearest to its end. It binds every span between keytimes that shows some of it, forward or backward, each on its
    own: a keytime inside a lock is kept, and the lock goes on from there.

    Parameters
    ----------
    reduction : Reduction
        The spans.
    steps : StepPairs
        The steps that there are.
    input_end : float
        Time of the last input frame, seconds.
    locks : sequence of Lock
        In input time.
    named : Named
        What messages may call by name.

    Returns
    -------
    tuple of LockedSpan
        In the order in which they are shown.

    Raises
    ------
    OptionError
        A lock that leaves the clip, holds a hold, binds nothing, or has a speed that no step plays.
    """
    for i, lock in enumerate(locks):
        _check_lock(lock, i, reduction, steps, input_end, named)
    bound: list[LockedSpan] = []
    places: list[list[int]] = [[] for _ in locks]
    for span in range(len(reduction.keytimes) - 1):
        if reduction.held[reduction.frames[span]]:
            # What crawls is not searched; the curve keeps the lock there (`retime.search.promised_curve`).
            for i, lock in enumerate(locks):
                if _overlap(reduction, span, lock) > 1e-9:
                    places[i].append(1)
            continue
        shown = [(*place, i) for i, lock in enumerate(locks) if (place := _place_in_span(reduction, span, lock))]
        for first, last, i in sorted(shown):
            playing = lock_steps(locks[i], reduction.upsamples[span], steps)
            # Rounding up to whole steps must not run into the lock that follows.
            room = min((other for other, *_ in shown if other >= last), default=reduction.frames[span + 1]) - first
            lengths = _sums_of(playing, room)
            nearest = min(lengths, key=lambda length: (abs(first + length - last), -length))
            places[i].append(nearest)
            if nearest:
                lock = locks[i]
                speed = lock.fastest if lock.fixed else None
                bound.append(LockedSpan(first, first + nearest, playing, speed, span, lock.start, lock.end))
    for i, (lock, lengths) in enumerate(zip(locks, places, strict=True)):
        if not any(lengths):
            why = (
                f"is too short: at that speed one frame of the search, {1000 / reduction.rate:.0f} ms, shows more"
                if lengths
                else "is nowhere shown"
            )
            raise OptionError(f"the lock {lock} {why}", option="locks", item=i)
    return tuple(bound)


def _check_lock(lock: Lock, place: int, reduction: Reduction, steps: StepPairs, input_end: float, named: Named) -> None:
    """Refuse a lock (`place` of them) that contradicts the clip, a hold between keytimes, or the steps there are."""
    near = 1 / reduction.rate
    if lock.start < -near or lock.end > input_end + near:
        raise OptionError(
            f"the lock {lock} leaves the clip, which runs from 0 to {input_end:g} s", option="locks", item=place
        )
    for before, after in itertools.pairwise(reduction.keytimes):
        if before.input_time == after.input_time and lock.start + 1e-9 < before.input_time < lock.end - 1e-9:
            raise OptionError(
                f"the lock {lock} lies across input time {before.input_time:g} s, where keytimes hold the pose: end "
                "one lock there, and begin another",
                option="locks",
                item=place,
            )
    for span, upsample in enumerate(reduction.upsamples):
        if _place_in_span(reduction, span, lock) and not lock_steps(lock, upsample, steps):
            raise OptionError(
                f"the lock {lock} can't be played: {playable(upsample, steps.longest, named)}",
                option="locks",
                item=place,
            )


def lock_steps(lock: Lock, upsample: int, steps: StepPairs) -> tuple[int, ...]:
    """Return the steps that a lock allows, of those that there are."""
    if not lock.fixed:
        allowed = steps_between(lock.slowest, lock.fastest, upsample, steps.longest)
        return tuple(step for step in steps.steps.tolist() if step in allowed)
    step = fixed_step(lock.fastest, upsample, steps.longest)
    return () if step is None or step not in steps.steps else (step,)


def _place_in_span(reduction: Reduction, span: int, lock: Lock) -> tuple[int, int] | None:
    """Unrolled frames nearest to a lock's ends, where a moving span shows some of it."""
    before, after = reduction.keytimes[span].input_time, reduction.keytimes[span + 1].input_time
    low, high = max(lock.start, min(before, after)), min(lock.end, max(before, after))
    begin, stop = reduction.frames[span], reduction.frames[span + 1]
    if _overlap(reduction, span, lock) <= 1e-9 or reduction.held[begin]:
        return None
    grid = reduction.rate * reduction.upsamples[span]
    origin = nearest_frame(before * grid)
    ends = sorted(begin + abs(nearest_frame(time * grid) - origin) for time in (low, high))
    first, last = (min(max(frame, begin), stop) for frame in ends)
    return None if first == stop else (first, last)


def _overlap(reduction: Reduction, span: int, lock: Lock) -> float:
    """Seconds of a lock that a span shows."""
    before, after = reduction.keytimes[span].input_time, reduction.keytimes[span + 1].input_time
    return min(lock.end, max(before, after)) - max(lock.start, min(before, after))


def _sums_of(steps: tuple[int, ...], most: int) -> list[int]:
    """List the lengths from 0 to `most` that are sums of steps."""
    # Bit n: a length of n can be had. Each round adds one step to all of them, twice as many as the round before.
    lengths, within = 1, (1 << (most + 1)) - 1
    for step in steps:
        shift = step
        while shift <= most:
            lengths |= (lengths << shift) & within
            shift *= 2
    return [length for length, bit in enumerate(reversed(f"{lengths:b}")) if bit == "1"]
