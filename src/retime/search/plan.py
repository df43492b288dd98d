"""What a request comes to: the input as it is offered to the search, and the steps that may be taken through it."""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from retime.arrays import BoolArray, IntArray
from retime.brief import brief_repr
from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import StepPairs
from retime.limits import MAX_STEP
from retime.search.estimate import check_fits
from retime.search.grid import HandGrid, choose_max_skip, choose_upsamples, hand_steps, natural_steps
from retime.search.reduction import Reduction, nearest_frame, reduce_to_compression
from retime.search.wishes.allowed import allowed_steps
from retime.search.wishes.asked import Wishes
from retime.search.wishes.feasible import check_counts, least_max_skip, length_words
from retime.search.wishes.locks import LockedSpan, locked_spans
from retime.search.wishes.room import crawls, room_between
from retime.search.wishes.steps import Named, slowest_words
from retime.search.wishes.upsampling import MAX_UPSAMPLE, upsample_for
from retime.warp.keytime import Keytime

# What makes a search smaller, for messages.
SHORTER = (
    "Ask for a shorter output or hold, less slow-down, narrower speed limits or a lower rate, or take a part of it"
)

Upsamples = int | tuple[int, ...]


@dataclass(frozen=True)
class Request:
    """What is asked of one search, in numbers.

    Attributes
    ----------
    keytimes : tuple of Keytime
        Ends included, in output order.
    wishes : Wishes
        Locks, tangents and speed limits.
    motion_rate : Fraction
        Frames a second of the input.
    length_bounds : (int, int or None)
        Least and most frames of a free length, at the motion's rate; None is no bound.
    loop : bool
        First and last step must be able to agree.
    upsample, max_skip : int, optional
        As `retime.guided_warp` has them; left out, they are chosen.
    evenness, keep_flights : float
        Weights of the price on tempo; 0 is none.
    natural : bool
        Hurry is shared out by a price on tempo, on the grid of steps that this needs.
    hand : HandGrid, optional
        A hand's speeds are to be followed, on the grid of steps that this needs.
    """

    keytimes: tuple[Keytime, ...]
    wishes: Wishes
    motion_rate: Fraction
    length_bounds: tuple[int, int | None] = (2, None)
    loop: bool = False
    upsample: int | None = None
    max_skip: int | None = None
    evenness: float = 0.0
    keep_flights: float = 0.0
    natural: bool = False
    hand: HandGrid | None = None

    @property
    def free(self) -> bool:
        """Whether the length is the search's to find."""
        return math.isinf(self.keytimes[-1].output_time)

    @property
    def named(self) -> Named:
        """What messages may call by name."""
        return Named(self.upsample, self.max_skip)


@dataclass(frozen=True, eq=False)
class SearchPlan:
    """What a request comes to, made once and handed on.

    Attributes
    ----------
    request : Request
        What was asked for.
    reduction : Reduction
        The unrolled input.
    steps : StepPairs
        The steps that there are, and which of them may follow which.
    loose : tuple of int
        Unrolled frames at which any step may follow any, however `steps` limits neighbours: keytimes, ends of locks.
    locked : tuple of LockedSpan
        Where locks bind the unrolled input.
    allowed : bool array, shape (n_input, max_skip)
        Steps that the search may take: ``allowed[j, b - 1]`` from frame j to j + b.
    n_output : int, (int, int) or None
        Frames to select; the least and the most of them where the length is free and the count matters; None where
        nothing counts.
    """

    request: Request
    reduction: Reduction
    steps: StepPairs
    loose: tuple[int, ...]
    locked: tuple[LockedSpan, ...]
    allowed: BoolArray
    n_output: int | tuple[int, int] | None

    __repr__ = brief_repr

    @property
    def max_skip(self) -> int:
        """The largest step."""
        return self.steps.longest

    @property
    def anchors(self) -> tuple[tuple[int, int], ...]:
        """Pairs (output position, unrolled frame) that the path must pass; the end of a free length has no position."""
        return self.reduction.anchors[:-1] if self.request.free else self.reduction.anchors

    def finished(self, path: IntArray) -> Reduction:
        """Return the reduction with the length that the path has."""
        if not self.reduction.free:
            return self.reduction
        rate = self.request.motion_rate
        least, most = (math.inf if n is None else float((n - 1) / rate) for n in self.request.length_bounds)
        before, after = self.request.keytimes[-2:]
        shortest, longest = room_between(before, after, self.request.wishes)
        # To whole frames inside of what locks and limits leave.
        least = max(least, math.ceil((before.output_time + shortest) * rate - 1e-6) / float(rate))
        if math.isfinite(longest):
            most = min(most, max(least, math.floor((before.output_time + longest) * rate + 1e-6) / float(rate)))
        return self.reduction.with_path(path, float(rate), least_end=least, most_end=most)


def make_plan(request: Request, *, rate: float, itself: bool) -> SearchPlan:
    """Unroll the input so that the keytimes can be met; what is left out is chosen.

    Parameters
    ----------
    request : Request
        What is asked for.
    rate : float
        Analysis rate, Hz.
    itself : bool
        The input is its own reference.

    Raises
    ------
    InfeasibleWarpError
        No steps lead through some span; says what would.
    OptionError
        Nothing plays the speeds that are asked for.
    """
    if request.max_skip is not None and not 1 <= request.max_skip <= MAX_STEP:
        raise OptionError(f"max_skip must be from 1 to {MAX_STEP}, found {request.max_skip}", option="max_skip")
    return _Planner(request, rate, itself).plan()


class _Planner:
    """Tries how finely the input is unrolled, and how long steps may be, until the keytimes can be met."""

    def __init__(self, request: Request, rate: float, itself: bool) -> None:
        self.request, self.wishes, self.rate, self.itself = request, request.wishes, rate, itself

    def plan(self) -> SearchPlan:
        """Return the first plan that fits; raise what stands against the first choice where none does."""
        first = choice = self._first_choice()
        refined: set[int] = set()
        while True:
            reduction = self._reduced(choice)
            skip = self._skip_for(reduction)
            if skip > MAX_STEP:
                break
            where = -1
            try:
                return self._attempt(reduction, skip)
            except InfeasibleWarpError as error:
                # A span that can't be crossed; -1 stands for any other obstacle.
                where = -1 if error.span is None else error.span
            except OptionError:
                pass
            if self.request.max_skip is None and (enough := least_max_skip(choice, skip, self._fits)) is not None:
                # Where locks play slowly, the rest has to be faster; and not all of it as fast as can be.
                return self._attempt(reduction, min(MAX_STEP, enough + enough // 4))
            finer = self._refined(choice, where, refined)
            if finer is None:
                break
            choice = finer
        return self._told(self._reduced(first))

    def _first_choice(self) -> Upsamples:
        request = self.request
        if request.upsample is not None:
            return request.upsample
        return choose_upsamples(
            request.keytimes,
            self.wishes,
            itself=self.itself,
            loop=request.loop,
            natural=request.natural,
            hand=request.hand,
        )

    def _refined(self, choice: Upsamples, where: int, refined: set[int]) -> Upsamples | None:
        """Unroll the span that can't be crossed twice as finely; None where that was tried, or is too fine.

        Where locks play fast, the rest may have to be slower than the lengths alone say; and a span that shows as much
        as it takes may lose a frame to rounding.
        """
        if isinstance(choice, int) or where == -1 or where in refined:
            return None
        # The first span and the last one of a loop meet.
        ends = {0, len(choice) - 1} if self.request.loop else set()
        again = ends | {where} if where in ends else {where}
        refined |= again
        if 2 * max(choice[span] for span in again) > MAX_UPSAMPLE:
            return None
        speeds = self.wishes.speeds
        return tuple(upsample_for(2 * one, *speeds) if span in again else one for span, one in enumerate(choice))

    def _told(self, reduction: Reduction) -> SearchPlan:
        """Try the first choice once more, so that what stands against it is said in full."""
        skip = self._skip_for(reduction)
        if skip > MAX_STEP:
            given = self.request.upsample
            raise OptionError(
                f"one warp can't play speeds from {slowest_words(reduction.upsample)} to "
                f"{skip / reduction.upsample:g}: the fastest is at most {MAX_STEP} times the slowest. Ask for speeds "
                f"up to {math.floor(10 * MAX_STEP / reduction.upsample) / 10:g}, or for less slow-down"
                + ("" if given is None else f" than upsample={given}"),
                option="speed",
            )
        return self._attempt(reduction, skip, wishes=str(self.wishes), fits=self._fits)

    def _reduced(self, upsample: Upsamples) -> Reduction:
        keytimes, wishes = self.request.keytimes, self.wishes
        slow = [crawls(*pair, wishes) for pair in itertools.pairwise(keytimes)]
        return reduce_to_compression(keytimes, wishes.input_end, rate=self.rate, upsample=upsample, crawling=slow)

    def _skip_for(self, reduction: Reduction) -> int:
        request = self.request
        if request.max_skip is not None:
            return request.max_skip
        return choose_max_skip(reduction, self.wishes, itself=self.itself, natural=request.natural, hand=request.hand)

    def _fits(self, upsample: Upsamples, max_skip: int) -> bool:
        try:
            self._attempt(self._reduced(upsample), max_skip)
        except (InfeasibleWarpError, OptionError):
            return False
        return True

    def _attempt(self, reduction: Reduction, max_skip: int, **messages: Any) -> SearchPlan:
        request = self.request
        choose_few = hand_steps if request.hand is not None else natural_steps
        if request.hand is not None or (request.natural and request.max_skip is None):
            # A few steps are enough, but where keytimes and locks stand close together.
            with contextlib.suppress(InfeasibleWarpError):
                return self._planned(reduction, choose_few(reduction, self.wishes, max_skip))
        return self._planned(reduction, StepPairs.up_to(max_skip), **messages)

    def _planned(self, reduction: Reduction, steps: StepPairs, **messages: Any) -> SearchPlan:
        """Plan with these steps; raise InfeasibleWarpError where they lead through some span on no path."""
        request, wishes, named = self.request, self.wishes, self.request.named
        check_fits(
            what=f"a search through {reduction.n_input:,} frames in steps of up to {steps.longest}",
            remedy=SHORTER,
            n_bytes=reduction.n_input * (64.0 + 12.0 * steps.longest),
        )
        locked = locked_spans(reduction, steps, wishes.input_end, wishes.locks, named=named)
        allowed = allowed_steps(
            reduction,
            steps.longest,
            steps=steps,
            locked=locked,
            slowest=wishes.slowest,
            fastest=wishes.fastest,
            named=named,
        )
        counts = _length_range(request, reduction) if request.free else None
        last_frame = float(1 / request.motion_rate)
        room = [room_between(*pair, wishes) for pair in itertools.pairwise(request.keytimes)] if wishes.any else []
        check_counts(reduction, allowed, n_output=counts, named=named, last_frame=last_frame, room=room, **messages)
        # Keytimes inside the clip have places in the output, so that the count matters; without them and without
        # bounds nothing counts.
        uncounted = request.free and len(request.keytimes) == 2 and request.length_bounds == (2, None)
        n_output = reduction.n_output if counts is None else None if uncounted else counts
        return SearchPlan(request, reduction, steps, _loose_frames(reduction, locked), locked, allowed, n_output)


def _loose_frames(reduction: Reduction, locked: Sequence[LockedSpan]) -> tuple[int, ...]:
    """List the unrolled frames where somebody asked for a change of speed, however great."""
    found = set(reduction.frames[1:-1])
    found.update(frame for span in locked for frame in (span.first, span.last))
    for place, key in enumerate(reduction.keytimes):
        if key.speed is not None:
            # The steps to and from the keytime have its speed; the ones beside those need not come near it.
            for upsample in reduction.upsamples[max(0, place - 1) : place + 1]:
                step = max(1, round(abs(key.speed) * upsample))
                found.update((reduction.frames[place] - step, reduction.frames[place] + step))
    return tuple(sorted(frame for frame in found if 0 < frame < reduction.n_input - 1))


def _length_range(request: Request, reduction: Reduction) -> tuple[int, int]:
    """Bounds on a free length, in analysis frames: what the unrolled input and the keytimes allow of it."""
    low, high = (
        None if n is None else nearest_frame(float((n - 1) / request.motion_rate) * reduction.rate) + 1
        for n in request.length_bounds
    )
    shortest = reduction.positions[-2] + 2
    longest = reduction.positions[-2] + 1 + reduction.frames[-1] - reduction.frames[-2]
    least = max(low or 2, shortest)
    most = longest if high is None else min(high, longest)
    if least > most:
        raise _out_of_bounds(request, reduction, shortest, longest)
    return least, most


def _out_of_bounds(request: Request, reduction: Reduction, shortest: int, longest: int) -> InfeasibleWarpError:
    """Say that no free length lies within its bounds; `shortest` and `longest` are what keytimes and speeds allow."""
    last_frame = float(1 / request.motion_rate)
    low, high = request.length_bounds
    bounds = f"at least {low}f, {low * last_frame:.3f} s"
    if high is not None:
        bounds = f"{low}f to {high}f, {low * last_frame:.3f} to {high * last_frame:.3f} s"
    upsample = reduction.upsamples[-1]
    too_short = nearest_frame((low - 1) * last_frame * reduction.rate) + 1 > longest
    if too_short:
        # Each step needs a frame of its own in the last span.
        enough = math.ceil(
            ((low - 1) * last_frame * reduction.rate - reduction.positions[-2])
            * upsample
            / (reduction.frames[-1] - reduction.frames[-2])
        )
        limit = f"speeds down to {slowest_words(upsample)} allow no more than " + length_words(
            longest - 1, reduction.rate, last_frame, math.floor
        )
        remedy = f"allow speeds down to {slowest_words(enough)}"
        remedy += f" (upsample={enough})" if request.upsample is not None else f" (speed='{slowest_words(enough)}..')"
    else:
        limit = "the keytimes allow no less than " + length_words(shortest - 1, reduction.rate, last_frame, math.ceil)
        remedy = "move the last keytime"
    return InfeasibleWarpError(
        f"no length lies within the bounds ({bounds}): {limit}. Change the bounds, or {remedy}",
        min_output=shortest,
        max_output=longest,
        option="min_length" if too_short else "max_length",
    )
