"""Whether any path meets the keytimes; if none does, what would."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypedDict

import numpy as np

from retime.arrays import BoolArray
from retime.errors import InfeasibleWarpError
from retime.search.reduction import Reduction
from retime.search.wishes.steps import MAX_STEP

# Whether all keytimes can be met, given an upsampling (of all spans or of each) and max_skip.
Fits = Callable[[int | tuple[int, ...], int], bool]


def check_counts(
    reduction: Reduction,
    allowed: BoolArray,
    *,
    n_output: tuple[int, int] | None = None,
    wishes: str = "",
    fits: Fits | None = None,
    last_frame: float = 0.0,
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
    fits : function of (upsample, max_skip), optional
        Whether all keytimes could be met with these: only a remedy that works is offered.
    last_frame : float
        How long the last output frame is shown, seconds: lengths count it, and are offered in frames so long.

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
        if not possible.any_between(least, most):
            raise _infeasible(reduction, span, allowed.shape[1], (least, most), possible, wishes, fits, last_frame)


def steps_fit(allowed: BoolArray, n_steps: int) -> bool:
    """Whether so many allowed steps lead from the first frame of `allowed` to the one after its last."""
    return _StepCounts(allowed, len(allowed)).any_between(n_steps, n_steps)


class _StepCounts:
    """The numbers of steps that cross a span."""

    def __init__(self, allowed: BoolArray, length: int) -> None:
        max_skip = allowed.shape[1]
        inside = np.arange(length)[:, None] + np.arange(1, max_skip + 1) <= length
        if bool(np.all(allowed | ~inside)):
            # Nothing but max_skip: every number between the least and one step a frame.
            least = -(-length // max_skip)
            self._bits = (1 << (length + 1)) - (1 << least)
            return
        # Bit n of a frame: n steps can lead there. Shifting all numbers at once keeps long spans quick.
        ahead = [0] * (max_skip + 1)
        ahead[0] = 1
        for frame in range(length):
            bits = ahead.pop(0) << 1
            ahead.append(0)
            if bits:
                for step in np.flatnonzero(allowed[frame] & inside[frame]).tolist():
                    ahead[step] |= bits
        self._bits = ahead[0]

    def any_between(self, least: int, most: int) -> bool:
        return least <= most and bool(self._bits >> max(least, 0) & ((1 << (most - max(least, 0) + 1)) - 1))

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


class _Values(TypedDict):
    span: int
    n_input: int
    n_output: int
    max_skip: int
    output_times: tuple[float, ...]


def _infeasible(
    reduction: Reduction,
    span: int,
    max_skip: int,
    wanted: tuple[int, int],
    possible: _StepCounts,
    wishes: str,
    fits: Fits | None,
    last_frame: float,
) -> InfeasibleWarpError:
    before, after = reduction.keytimes[span], reduction.keytimes[span + 1]
    length, upsample, rate = (
        reduction.frames[span + 1] - reduction.frames[span],
        reduction.upsamples[span],
        reduction.rate,
    )

    # Where there is no keytime between the ends, the length is what can be changed; it counts the last frame.
    whole = len(reduction.keytimes) == 2 and last_frame > 0

    def asked(steps: int, rounded: Callable[[float], int]) -> str:
        if not whole:
            return f"{rounded(round(1000 * steps / rate, 6)) / 1000:g} s"
        n_frames = rounded(round(steps / (rate * last_frame), 6)) + 1
        return f"{n_frames}f ({n_frames * last_frame:.3f} s)"

    least, most = wanted
    seconds = most / rate if reduction.free else after.output_time - before.output_time
    seconds += last_frame if whole else 0.0
    into = f"{most + 1} output frames" if least == most else f"{least + 1} to {most + 1} output frames"
    where = (
        f"cannot fit input {before.input_time:.2f}–{after.input_time:.2f} s ({length + 1} frames at the analysis rate) "
        f"into {into} ({seconds:.2f} s)"
    )
    values: _Values = {
        "span": span,
        "n_input": length + 1,
        "n_output": most + 1,
        "max_skip": max_skip,
        "output_times": (before.output_time, after.output_time),
    }
    limits = " and ".join([f"max_skip={max_skip}, upsample={upsample}", *([wishes] if wishes else [])])
    if possible.least is None:
        return InfeasibleWarpError(f"{where}: {limits} leave no way through. Loosen one.", **values)
    fewer, more = possible.below(least), possible.above(most)
    if fewer is None:
        assert more is not None
        remedy = f"at least {asked(more, math.ceil)}"
        # A span may hold too few frames for any path of that length, or its steps may be too short.
        finer = False
    elif more is None:
        remedy = f"at most {asked(fewer, math.floor)}"
        finer = True
    else:
        remedy = f"{asked(fewer, round)} or {asked(more, round)}"
        finer = False
    option = None if fits is None else _better_limits(upsample, max_skip, (least, most), length, finer, fits)
    use = f"Use a length of {remedy}" if whole else f"Put these keytimes {remedy} apart"
    offered = [use, *([option] if option else []), *([f"loosen {wishes}"] if wishes else [])]
    return InfeasibleWarpError(
        f"{where}: {limits} allow {possible.least + 1} to {possible.most + 1}. {', or '.join(offered)}.",
        **values,
        min_output=possible.least + 1,
        max_output=possible.most + 1,
    )


def _better_limits(
    upsample: int, max_skip: int, wanted: tuple[int, int], length: int, finer: bool, fits: Fits
) -> str | None:
    """Find a longer step, or a finer upsampling, with which all keytimes can be met."""
    if finer:
        need = upsample * -(-wanted[0] // length)
        for better in range(max(need, upsample + 1), 2 * need + 4):
            for skip in (max_skip, min(MAX_STEP, -(-max_skip * better // upsample))):
                if fits(better, skip):
                    return f"upsample >= {better}" + (f" with max_skip={skip}" if skip != max_skip else "")
        return None
    enough = least_max_skip(upsample, max_skip, fits)
    return None if enough is None else f"max_skip >= {enough}"


def least_max_skip(upsample: int | tuple[int, ...], max_skip: int, fits: Fits) -> int | None:
    """Return the least `max_skip` above the given one with which all keytimes can be met; None where there is none."""
    low, high = max_skip, MAX_STEP
    if max_skip >= MAX_STEP or not fits(upsample, high):
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if fits(upsample, middle) else (middle, high)
    return high
