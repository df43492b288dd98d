"""How fine the input is offered and how far a step may go, so that every keytime can be met (§3.1)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from retime.arrays import BoolArray
from retime.errors import InfeasibleWarpError, OptionError
from retime.search.reduction import SLOWEST_SEARCHED, Reduction, reduce_to_compression
from retime.search.wishes.allowed import allowed_steps
from retime.search.wishes.feasible import check_counts, least_max_skip
from retime.search.wishes.locks import Lock, LockedSpan, locked_spans
from retime.search.wishes.steps import MAX_STEP
from retime.search.wishes.upsampling import MAX_UPSAMPLE, upsample_for
from retime.warp.curve import Keytime

Upsamples = int | tuple[int, ...]

DEFAULT_MAX_SKIP = 8
# Frames offered per analysis period where a motion may slow down. Another's timing is met two to three times as closely
# in eighths as in quarters (docs/method.md), at three times the cost: worth it up to so many seconds of input.
_QUARTERS, _EIGHTHS, _EIGHTHS_UP_TO = 4, 8, 120.0


@dataclass(frozen=True)
class Wishes:
    """What is asked for beside keytimes.

    Attributes
    ----------
    input_end : float
        Time of the last input frame, seconds.
    last_frame : float
        How long the last output frame is shown, seconds: a frame period of the clip. A length counts it.
    locks : tuple of Lock
        Spans of the input at given speeds.
    tangents : tuple of float
        Speeds at keytimes.
    slowest, fastest : float
        Playback speeds for the whole clip.
    """

    input_end: float
    last_frame: float
    locks: tuple[Lock, ...]
    tangents: tuple[float, ...]
    slowest: float
    fastest: float

    @property
    def any(self) -> bool:
        """Whether anything is."""
        return bool(self.locks or self.tangents) or self.slowest > 0 or self.fastest < math.inf

    @property
    def speeds(self) -> tuple[tuple[Lock, ...], tuple[float, ...], float, float]:
        """Locks, tangents and limits, as `retime.search.wishes.upsampling.upsample_for` takes them."""
        return self.locks, self.tangents, self.slowest, self.fastest

    def locked(self, reduction: Reduction, max_skip: int) -> tuple[LockedSpan, ...]:
        """Find the unrolled frames that locks bind."""
        return locked_spans(reduction, max_skip, self.input_end, self.locks)

    def allowed(self, reduction: Reduction, max_skip: int) -> BoolArray:
        """Say which steps the search may take, shape (n_input, max_skip)."""
        locked = self.locked(reduction, max_skip)
        return allowed_steps(reduction, max_skip, locked=locked, slowest=self.slowest, fastest=self.fastest)

    def __str__(self) -> str:
        words = ["the locks"] if self.locks else []
        words += ["the tangents"] if self.tangents else []
        words += ["the speed limits"] if self.slowest > 0 or self.fastest < math.inf else []
        return " and ".join(words)


def reduce_to_fit(
    keytimes: Sequence[Keytime],
    wishes: Wishes,
    *,
    rate: float,
    itself: bool,
    loop: bool,
    upsample: int | None,
    max_skip: int | None,
    counts: Callable[[Reduction], tuple[int, int]],
) -> tuple[Reduction, int]:
    """Unroll the input so that the keytimes can be met; what is left out is chosen.

    Parameters
    ----------
    keytimes : sequence of Keytime
        Ends included.
    wishes : Wishes
        What else is asked for.
    rate : float
        Analysis rate, Hz.
    itself : bool
        The input is its own reference.
    loop : bool
        First and last step must be able to agree.
    upsample, max_skip : int, optional
        As `retime.guided_warp` has them.
    counts : function of a Reduction
        The least and the most output frames of a free length.

    Returns
    -------
    (Reduction, int)
        The second is `max_skip`.

    Raises
    ------
    InfeasibleWarpError
        No steps lead through some span; says what would.
    OptionError
        Nothing plays the speeds that are asked for.
    """
    if max_skip is not None and not 1 <= max_skip <= MAX_STEP:
        raise OptionError(f"max_skip must be from 1 to {MAX_STEP}, found {max_skip}", option="max_skip")
    chosen: Upsamples = choose_upsamples(keytimes, wishes, itself=itself, loop=loop) if upsample is None else upsample

    def reduced(upsample: Upsamples) -> Reduction:
        return reduce_to_compression(keytimes, wishes.input_end, rate=rate, upsample=upsample)

    def check(upsample: Upsamples, max_skip: int, **more: Any) -> None:
        reduction = reduced(upsample)
        n_output = counts(reduction) if reduction.free else None
        check_counts(
            reduction, wishes.allowed(reduction, max_skip), n_output=n_output, last_frame=wishes.last_frame, **more
        )

    def stuck(upsample: Upsamples, max_skip: int) -> int | None:
        """Return a span that can't be crossed, -1 for another obstacle, None where all keytimes can be met."""
        try:
            check(upsample, max_skip)
        except InfeasibleWarpError as error:
            return -1 if error.span is None else error.span
        except OptionError:
            return -1
        return None

    def fits(upsample: Upsamples, max_skip: int) -> bool:
        return stuck(upsample, max_skip) is None

    choice = chosen
    refined: set[int] = set()
    while True:
        reduction = reduced(choice)
        skip = choose_max_skip(reduction, wishes, itself=itself) if max_skip is None else max_skip
        where = stuck(choice, skip)
        if where is None:
            return reduction, skip
        if max_skip is None and (enough := least_max_skip(choice, skip, fits)) is not None:
            # Where locks play slowly, the rest has to be faster; and not all of it as fast as can be.
            return reduction, min(MAX_STEP, enough + enough // 4)
        # Where locks play fast, the rest may have to be slower than the lengths alone say; and a span that shows
        # as much as it takes may lose a frame to rounding.
        if isinstance(choice, int) or where == -1 or where in refined:
            break
        ends = {0, len(choice) - 1} if loop else set()
        again = ends | {where} if where in ends else {where}
        refined |= again
        if 2 * max(choice[span] for span in again) > MAX_UPSAMPLE:
            break
        choice = tuple(
            upsample_for(2 * one, *wishes.speeds) if span in again else one for span, one in enumerate(choice)
        )
    reduction = reduced(chosen)
    skip = choose_max_skip(reduction, wishes, itself=itself) if max_skip is None else max_skip
    if skip > MAX_STEP:
        raise OptionError(
            f"max_skip must be from 1 to {MAX_STEP}, found {skip} (for the speeds asked for, with "
            f"upsample={reduction.upsample})",
            option="speed",
        )
    check(chosen, skip, wishes=str(wishes), fits=fits)
    return reduction, skip


def choose_upsamples(keytimes: Sequence[Keytime], wishes: Wishes, *, itself: bool, loop: bool) -> tuple[int, ...]:
    """1 where the input moves like itself and a span gets no longer; else 4, 8, or what the mean speed asks for."""
    usual = _QUARTERS if itself else usual_upsample(wishes.input_end)
    slower = min([1.0, *(lock.fastest for lock in wishes.locks), *wishes.tangents]) < 1
    limit = 1 if wishes.slowest == 0 else math.ceil(1 / wishes.slowest - 1e-9)
    chosen = []
    for before, after in itertools.pairwise(keytimes):
        mean = abs(after.input_time - before.input_time) / (after.output_time - before.output_time)
        if math.isinf(after.output_time):
            least = usual
        elif mean < SLOWEST_SEARCHED or (itself and mean > 0.999 and not slower):
            least = 1
        elif mean < 1:
            least = max(usual, _ample(1 / mean, 16))
        else:
            # What plays fast throughout needs no frames so fine.
            least = max(1, usual // math.floor(mean))
        chosen.append(upsample_for(max(limit, least), *wishes.speeds))
    if loop:
        # First and last step must be able to agree.
        chosen[0] = chosen[-1] = max(chosen[0], chosen[-1])
    return tuple(chosen)


def choose_max_skip(reduction: Reduction, wishes: Wishes, *, itself: bool) -> int:
    """8, or twice unit speed, or ample for the mean step; or what the speed limits say."""
    if wishes.fastest < math.inf:
        return max(1, math.floor(wishes.fastest * reduction.upsample + 1e-6))
    anchors = reduction.anchors[:-1] if reduction.free else reduction.anchors
    mean = [(j1 - j0) / (p1 - p0) for (p0, j0), (p1, j1) in itertools.pairwise(anchors)]
    least = [lock.fastest for lock in wishes.locks if lock.fixed] + [lock.slowest for lock in wishes.locks]
    wanted = max([0.0, *least, *wishes.tangents]) * reduction.upsample
    ample = min(_ample(max(mean, default=0.0), 64), MAX_STEP)
    # Another's timing may be twice as fast anywhere.
    usual = DEFAULT_MAX_SKIP if itself else max(DEFAULT_MAX_SKIP, 2 * min(reduction.upsample, _EIGHTHS))
    return max(usual, ample, math.ceil(wanted - 1e-6))


def usual_upsample(input_end: float) -> int:
    """Return the frames offered per analysis period where an input of some seconds moves like another."""
    return _EIGHTHS if input_end <= _EIGHTHS_UP_TO else _QUARTERS


def _ample(mean: float, dear: int) -> int:
    """Twice as much as on average; where that is dear, a quarter more."""
    return max(min(math.ceil(2 * mean - 1e-9), dear), math.ceil(1.25 * mean - 1e-9))
