"""Whether any path meets the keytimes; if none does, what would."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np

from retime.arrays import BoolArray
from retime.errors import InfeasibleWarpError
from retime.limits import MAX_STEP
from retime.progress import look
from retime.search.reduction import Reduction
from retime.search.wishes.room import rounding
from retime.search.wishes.steps import NOTHING_NAMED, Named, slowest_words

# Upsamplings that are tried, for one to offer.
_MOST_TRIED = 16
# Tells whether all keytimes can be met, given an upsampling (of all spans or of each) and max_skip.
Fits = Callable[[int | tuple[int, ...], int], bool]


def check_counts(
    reduction: Reduction,
    allowed: BoolArray,
    *,
    n_output: tuple[int, int] | None = None,
    wishes: str = "",
    named: Named = NOTHING_NAMED,
    fits: Fits | None = None,
    last_frame: float = 0.0,
    room: Sequence[tuple[float, float]] = (),
) -> None:
    """Refuse keytimes between which no number of allowed steps fits.

    Parameters
    ----------
    reduction : Reduction
        The spans.
    allowed : bool array, shape (n_input, max_skip)
        From `allowed_steps`.
    n_output : (int, int), optional
        The least and the most output frames, where the length is free.
    wishes : str
        What besides `max_skip` and the upsampling forbids steps, for the message.
    named : Named
        Which of these two the message may name, and offer others of.
    fits : function of (upsample, max_skip), optional
        Whether all keytimes could be met with these: only a remedy that works is offered.
    last_frame : float
        How long the last output frame is shown, seconds: lengths count it, and are offered in frames so long.
    room : sequence of (float, float)
        For each span the shortest and the longest time that it may take, off any grid, seconds
        (`retime.search.wishes.room`); left out, any.

    Raises
    ------
    InfeasibleWarpError
        Names the span, what fits there, and what would make it feasible.
    """
    for span in range(len(reduction.keytimes) - 1):
        first, last = reduction.frames[span], reduction.frames[span + 1]
        least = most = reduction.positions[span + 1] - reduction.positions[span]
        if n_output is not None and span == len(reduction.keytimes) - 2:
            least, most = (count - 1 - reduction.positions[span] for count in n_output)
        possible = _StepCounts(allowed[first:last], last - first)
        fit, off = possible.any_between(least, most), 0
        if room:
            shortest, longest = room[span]
            before, after = reduction.keytimes[span : span + 2]
            length = after.output_time - before.output_time
            at_end = span == len(reduction.keytimes) - 2
            near = rounding(1 / last_frame, at_end=at_end, length=length) if length < math.inf else 0.0
            if length < math.inf and not shortest - near <= length <= longest + near:
                fit, off = False, -1 if length < shortest else 1
            if not fit:
                # Only what fits both the grid and the room is offered; where nothing does, what is a rounding off.
                near = rounding(1 / last_frame, at_end=at_end, length=shortest)
                if reduction.still[span]:
                    # A crawl has one step a frame, however long it is.
                    possible.be_up_to(math.ceil(min(longest, length) * reduction.rate) + 1)
                possible.keep_between(shortest * reduction.rate, longest * reduction.rate, near * reduction.rate)
        if not fit:
            raise _Refusal(
                reduction, span, allowed.shape[1], (least, most), possible, wishes, named, fits, last_frame, off
            ).error()


def steps_fit(allowed: BoolArray, n_steps: int) -> bool:
    """Whether so many allowed steps lead from the first frame of `allowed` to the one after its last."""
    return _StepCounts(allowed, len(allowed)).any_between(n_steps, n_steps)


class _StepCounts:
    """The numbers of steps that cross a span."""

    def __init__(self, allowed: BoolArray, length: int) -> None:
        max_skip = allowed.shape[1]
        inside = np.arange(length)[:, None] + np.arange(1, max_skip + 1) <= length
        anywhere = allowed.any(axis=0)
        steps = (np.flatnonzero(anywhere) + 1).tolist()
        if bool(np.all(allowed | ~inside | ~anywhere)) and _each_is_two(steps):
            # The same steps everywhere, of which each can be taken as two: every number from the fewest to one a frame.
            self._bits = (1 << (length + 1)) - (1 << _fewest(length, steps))
            return
        # Bit n of a frame: n steps can lead there. Shifting all numbers at once keeps long spans quick.
        ahead = [0] * (max_skip + 1)
        ahead[0] = 1
        for frame in range(length):
            if frame % 1024 == 0:
                look(frame / length)
            bits = ahead.pop(0) << 1
            ahead.append(0)
            if bits:
                for step in np.flatnonzero(allowed[frame] & inside[frame]).tolist():
                    ahead[step] |= bits
        self._bits = ahead[0]

    def any_between(self, least: int, most: int) -> bool:
        return least <= most and bool(self._bits >> max(least, 0) & ((1 << (most - max(least, 0) + 1)) - 1))

    def be_up_to(self, most: int) -> None:
        """Allow any number from 1 to `most`."""
        self._bits = (1 << (most + 1)) - 2

    def keep_between(self, least: float, most: float, near: float) -> None:
        """Forget the numbers outside of a range, or where none is inside those not near it."""
        every = self._bits
        for more in (1e-6, near):
            self._bits = every >> (low := max(0, math.ceil(least - more))) << low
            if most + more < every.bit_length():
                self._bits &= (1 << max(0, math.floor(most + more) + 1)) - 1
            if self._bits:
                return

    @property
    def least(self) -> int | None:
        return (self._bits & -self._bits).bit_length() - 1 if self._bits else None

    @property
    def most(self) -> int:
        return int(self._bits.bit_length()) - 1

    def below(self, count: int) -> int | None:
        bits = self._bits & ((1 << max(count, 0)) - 1)
        return bits.bit_length() - 1 if bits else None

    def above(self, count: int) -> int | None:
        bits = self._bits >> (count + 1)
        return count + (bits & -bits).bit_length() if bits else None


def _each_is_two(steps: list[int]) -> bool:
    """Whether there is a step of 1, and every other step is a sum of two."""
    known = set(steps)
    return 1 in known and all(step == 1 or any(step - one in known for one in steps if one < step) for step in steps)


def _fewest(length: int, steps: list[int]) -> int:
    """Return the fewest steps that make a length; one of them is 1."""
    longest = steps[-1]
    # So many longest steps are in every shortest way; what is left is counted.
    many = max(0, length // longest - longest)
    rest = length - many * longest
    fewest = [0] * (rest + 1)
    for n in range(1, rest + 1):
        fewest[n] = 1 + min(fewest[n - step] for step in steps if step <= n)
    return many + fewest[rest]


def length_words(n_steps: int, rate: float, last_frame: float, rounded: Callable[[float], int] = round) -> str:
    """Write a length in frames that are shown for `last_frame` seconds each, and in seconds; steps are of 1 / rate."""
    n_frames = rounded(round(n_steps / (rate * last_frame), 6)) + 1
    return f"{n_frames}f ({n_frames * last_frame:.3f} s)"


@dataclass(frozen=True)
class _Refusal:
    """A span that can't be crossed, and what is known of it; see `check_counts`."""

    reduction: Reduction
    span: int
    max_skip: int
    wanted: tuple[int, int]
    possible: _StepCounts
    wishes: str
    named: Named
    fits: Fits | None
    last_frame: float
    off: int = 0

    def error(self) -> InfeasibleWarpError:
        """Name the span, what fits there, and what would make it feasible."""
        before, after = self.reduction.keytimes[self.span : self.span + 2]
        least, most = self.wanted
        # Off the grid the span may be too short (-1) or too long (1) for a number of steps that fits.
        fewer = None if self.off < 0 else self.possible.below(least + (self.off > 0))
        more = None if self.off > 0 else self.possible.above(most - (self.off < 0))
        known: _Values = {
            "span": self.span,
            "n_input": self._n_offered + 1,
            "n_output": most + 1,
            "max_skip": self.max_skip,
            "output_times": (before.output_time, after.output_time),
        }
        into = (
            self._given()
            if least == most and not self.reduction.free
            else f"{self._asked(least)} to {self._asked(most)}"
        )
        where = f"cannot fit input {before.input_time:.2f}–{after.input_time:.2f} s into {into}"
        if self.possible.least is None or (fewer is None and more is None):
            return InfeasibleWarpError(f"{where}: {self._limits()} leave no way through. Loosen one.", **known)
        if fewer is None:
            assert more is not None
            remedy = f"at least {self._asked(more, math.ceil)}"
            # The fastest step, or the longest way through few frames.
            allows = f"{self._limits('up')} allow no less than {self._asked(more, math.ceil)}"
        elif more is None:
            remedy = f"at most {self._asked(fewer, math.floor)}"
            allows = f"{self._limits('down')} allow no more than {self._asked(fewer, math.floor)}"
        else:
            remedy = f"{self._asked(fewer)} or {self._asked(more)}"
            allows = f"{self._limits()} allow {remedy}, and nothing between"
        offered = [f"Use a length of {remedy}" if self._whole else f"Put these keytimes {remedy} apart"]
        if better := self._better_limits(finer=more is None):
            offered.append(better)
        if self.wishes:
            offered.append(f"loosen {self.wishes}")
        return InfeasibleWarpError(
            f"{where}: {allows}. {', or '.join(offered)}.",
            **known,
            min_output=self.possible.least + 1,
            max_output=self.possible.most + 1,
        )

    @property
    def _n_offered(self) -> int:
        """Steps of one frame across the span."""
        return self.reduction.frames[self.span + 1] - self.reduction.frames[self.span]

    @property
    def _upsample(self) -> int:
        return self.reduction.upsamples[self.span]

    @property
    def _whole(self) -> bool:
        """Whether there is no keytime between the ends: the length can be changed then, which counts the last frame."""
        return len(self.reduction.keytimes) == 2 and self.last_frame > 0

    def _given(self) -> str:
        """Write the length that was asked for; the search counts it in its own frames, to the nearest one."""
        before, after = self.reduction.keytimes[self.span : self.span + 2]
        seconds = after.output_time - before.output_time
        if self._whole:
            n_frames = round(seconds / self.last_frame) + 1
            return f"{n_frames}f ({n_frames * self.last_frame:.3f} s)"
        return f"{round(seconds, 3):g} s"

    def _asked(self, n_steps: int, rounded: Callable[[float], int] = round) -> str:
        """Write how long so many steps take, as a person would ask for it."""
        if self._whole:
            return length_words(n_steps, self.reduction.rate, self.last_frame, rounded)
        return f"{rounded(round(1000 * n_steps / self.reduction.rate, 6)) / 1000:g} s"

    def _limits(self, end: str = "") -> str:
        """Say what forbids steps: speeds (those at one end, "up" or "down", where only it counts), and wishes."""
        if self.wishes and not self.named.names:
            return self.wishes
        slowest, fastest = slowest_words(self._upsample), f"{self.max_skip / self._upsample:g}"
        speeds = {"up": f"speeds up to {fastest}", "down": f"speeds down to {slowest}"}.get(
            end, f"speeds from {slowest} to {fastest}"
        )
        by = f" ({self.named})" if self.named.names else ""
        return f"{speeds}{by} and {self.wishes}" if self.wishes else f"{speeds}{by}"

    def _better_limits(self, *, finer: bool) -> str | None:
        """Find a longer step, or a finer upsampling, with which all keytimes can be met."""
        if self.fits is None or not self.named.names:
            return None
        if not finer:
            enough = least_max_skip(self.reduction.upsamples, self.max_skip, self.fits)
            return None if enough is None else f"max_skip >= {enough}"
        need = self._upsample * -(-self.wanted[0] // self._n_offered)
        if need > MAX_STEP:
            return None
        # Each of them is a search for a way; what needs more than so many is not worth the wait.
        first = max(need, self._upsample + 1)
        for better in range(first, min(2 * need + 4, first + _MOST_TRIED)):
            for skip in (self.max_skip, min(MAX_STEP, -(-self.max_skip * better // self._upsample))):
                if self.fits(better, skip):
                    return f"upsample >= {better}" + (f" with max_skip={skip}" if skip != self.max_skip else "")
        return None


class _Values(TypedDict):
    span: int
    n_input: int
    n_output: int
    max_skip: int
    output_times: tuple[float, ...]


def least_max_skip(upsample: int | tuple[int, ...], max_skip: int, fits: Fits) -> int | None:
    """Return the least `max_skip` above the given one with which all keytimes can be met; None where there is none."""
    low, high = max_skip, MAX_STEP
    if max_skip >= MAX_STEP or not fits(upsample, high):
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if fits(upsample, middle) else (middle, high)
    return high
