"""How fine the input is offered, and how far one step may go, where nobody says (§3.1)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.kernels import StepPairs
from retime.limits import MAX_STEP
from retime.search.reduction import SLOWEST_SEARCHED, Reduction
from retime.search.wishes.asked import Wishes
from retime.search.wishes.room import crawls
from retime.search.wishes.steps import fixed_step, steps_between
from retime.search.wishes.upsampling import MAX_UPSAMPLE, upsample_for
from retime.warp.keytime import Keytime

DEFAULT_MAX_SKIP = 8
# Frames offered per analysis period where a motion may slow down. Another's timing is met two to three times as closely
# in eighths as in quarters (docs/method.md), at three times the cost: worth it up to so many seconds of input.
_QUARTERS, _EIGHTHS, _EIGHTHS_UP_TO = 4, 8, 120.0
# Natural hurry needs speeds such as 1.25; where an input is longer than so many seconds it makes do with 1.5.
_HALVES, _QUARTERS_UP_TO = 2, 120.0
# Where a clip gets longer all of it plays near one speed below 1, which quarters have seldom: steps then last some
# three quarters and others all of their time. Twelfths have thirds and sixths too (docs/study), at some five times the
# cost: worth it up to so many seconds.
_TWELFTHS, _TWELFTHS_UP_TO = 12, 60.0
# How many times faster than life a natural hurry may be anywhere.
_NATURAL_SPEED = 8
# A hand's speeds are followed in sixteenths or finer: in eighths mild ones are rounded (docs/method.md). Half as fine
# where an input is longer than _EIGHTHS_UP_TO.
_SIXTEENTHS = 16
# Steps that follow a hand lie so far apart where whole frames allow it, and of two neighbours the longer is at most
# so many times the shorter.
_APART, _HAND_NEIGHBORS = 1 + 1 / 16, 1.5
# Of two neighbouring steps the longer may be so many times the shorter: one half to one and the like, and a bit.
_NEIGHBORS = 2.05


@dataclass(frozen=True)
class HandGrid:
    """What following a hand needs of the search.

    Attributes
    ----------
    upsample : int
        Frames offered per analysis period.
    fastest : float
        Its fastest speed.
    """

    upsample: int
    fastest: float


def hand_grid(log_speeds: FloatArray, input_end: float) -> HandGrid:
    """Choose how fine an input is offered whose moments should play at given speeds.

    A search that is free plays each moment by the step that comes nearest to its speed; all of them together make the
    length. Of 16 to 24 frames a period (8 to 12 in long takes), what gets the length best is taken: sixteenths play at
    5/16 in place of one third, and all comes out too long.

    Parameters
    ----------
    log_speeds : float array, shape (n,)
        Wanted speeds, logarithms.
    input_end : float
        Seconds.
    """
    coarsest = _SIXTEENTHS if input_end <= _EIGHTHS_UP_TO else _EIGHTHS
    slowest = math.exp(-float(log_speeds.min()))
    coarsest = min(max(coarsest, math.ceil(slowest - 1e-9)), MAX_UPSAMPLE)
    found = coarsest
    least = math.inf
    for upsample in range(coarsest, min(coarsest * 3 // 2, MAX_UPSAMPLE) + 1):
        wanted = np.exp(log_speeds) * upsample
        below = np.maximum(np.floor(wanted), 1.0)
        # Nearest in its logarithm: the price is on that.
        played = np.where(wanted**2 > below * (below + 1), below + 1, below)
        error = abs(float(np.sum(1 / played) - np.sum(1 / wanted)) / float(np.sum(1 / wanted)))
        # A finer grid must be worth its while.
        if error < 0.8 * least - 1e-3:
            found, least = upsample, error
    return HandGrid(found, math.exp(max(0.0, float(log_speeds.max()))))


def choose_upsamples(
    keytimes: Sequence[Keytime],
    wishes: Wishes,
    *,
    itself: bool,
    loop: bool,
    natural: bool = False,
    hand: HandGrid | None = None,
) -> tuple[int, ...]:
    """Choose for each span how many frames are offered per analysis period.

    1 where the input moves like itself and a span gets no longer; else 4, 8, or what the mean speed asks for. Where
    hurry is to be natural, 4 where a span gets shorter, and 12 where it gets longer (4 or 2 in long takes). Where a
    hand is to be followed, what plays its speeds (`hand_grid`).
    """
    usual = _QUARTERS if itself else usual_upsample(wishes.input_end)
    if natural and wishes.input_end > _QUARTERS_UP_TO:
        usual = _HALVES
    if hand is not None:
        usual = hand.upsample
    slower = min([1.0, *(lock.fastest for lock in wishes.locks), *wishes.tangents]) < 1
    # A limit may be slower than anything that a length asks for: no more than the usual most is offered for it.
    limit = 1 if wishes.slowest * MAX_UPSAMPLE < 1 else math.ceil(1 / wishes.slowest - 1e-9)
    chosen = []
    for before, after in itertools.pairwise(keytimes):
        mean = abs(after.input_time - before.input_time) / (after.output_time - before.output_time)
        if math.isinf(after.output_time):
            least = usual
        elif (
            mean < SLOWEST_SEARCHED
            or crawls(before, after, wishes)
            or (itself and mean > 0.999 and not slower and not (natural and mean > 1.001))
        ):
            least = 1
        elif mean < 1:
            fine = _TWELFTHS if natural and wishes.input_end <= _TWELFTHS_UP_TO else usual
            least = max(fine, _ample(1 / mean, 16))
        elif natural:
            least = max(1, usual // max(1, math.floor(mean / 2)))
        else:
            # What plays fast throughout needs no frames so fine.
            least = max(1, usual // math.floor(mean))
        chosen.append(upsample_for(max(limit, least), *wishes.speeds))
    if loop:
        # First and last step must be able to agree.
        chosen[0] = chosen[-1] = max(chosen[0], chosen[-1])
    return tuple(chosen)


def choose_max_skip(
    reduction: Reduction,
    wishes: Wishes,
    *,
    itself: bool,
    natural: bool = False,
    hand: HandGrid | None = None,
) -> int:
    """8, or twice unit speed (eight times where hurry is natural), or ample for the mean step; or what limits say."""
    if wishes.fastest < math.inf:
        return max(1, math.floor(min(wishes.fastest * reduction.upsample, 1e9) + 1e-6))
    anchors = reduction.anchors[:-1] if reduction.free else reduction.anchors
    mean = [(j1 - j0) / (p1 - p0) for (p0, j0), (p1, j1) in itertools.pairwise(anchors)]
    least = [lock.fastest for lock in wishes.locks if lock.fixed] + [lock.slowest for lock in wishes.locks]
    wanted = max([0.0, *least, *wishes.tangents]) * reduction.upsample
    ample = min(_ample(max(mean, default=0.0), 64), MAX_STEP)
    # Another's timing may be twice as fast anywhere.
    usual = DEFAULT_MAX_SKIP if itself else max(DEFAULT_MAX_SKIP, 2 * min(reduction.upsample, _EIGHTHS))
    if natural:
        usual = min(_NATURAL_SPEED * reduction.upsample, MAX_STEP)
    if hand is not None:
        # With a quarter to spare, for what a given length asks for beyond.
        usual = min(max(2 * reduction.upsample, math.ceil(1.25 * hand.fastest * reduction.upsample)), MAX_STEP)
    return max(usual, ample, math.ceil(min(wanted, 1e9) - 1e-6))


def natural_steps(reduction: Reduction, wishes: Wishes, max_skip: int) -> StepPairs:
    """Choose the steps that a natural hurry needs: close together about unit speed, an octave apart at high speeds.

    With 4 frames a period they play at 1/4, 1/2, 3/4, 1, 5/4, 3/2, 2, 3, 4 and 8; with 12 at all twelfths up to 1.
    What wishes ask for is added.

    Parameters
    ----------
    reduction : Reduction
        The spans, with their upsamplings.
    wishes : Wishes
        Locks, tangents and limits.
    max_skip : int
        The longest step.
    """
    found = {1, max_skip} | _wished_steps(reduction, wishes, max_skip)
    for upsample in set(reduction.upsamples):
        # Finer than an eighth of the speed nothing can be told apart; slow speeds have what whole frames give.
        apart = max(1, upsample // _EIGHTHS)
        found |= {step for step in range(1, upsample + 1) if step <= 6 or step % apart == 0}
        # Frames so fine are offered for slow speeds: beyond 1 quarters will do.
        beyond = apart if upsample <= _EIGHTHS else upsample // 4
        found |= {step for step in range(upsample + 1, upsample + upsample // 2 + 1) if step <= 6 or step % beyond == 0}
        found |= {upsample, 3 * upsample}
        found |= {upsample << octave for octave in range(1, MAX_STEP.bit_length())}
    return StepPairs.of(sorted(step for step in found if 1 <= step <= max_skip), ratio=_NEIGHBORS)


def hand_steps(reduction: Reduction, wishes: Wishes, max_skip: int) -> StepPairs:
    """Choose the steps that follow a hand: every speed that differs by a sixteenth, or what whole frames give.

    What wishes ask for is added.

    Parameters
    ----------
    reduction, wishes, max_skip
        As `natural_steps` has them.
    """
    found = {1, max_skip} | set(reduction.upsamples) | _wished_steps(reduction, wishes, max_skip)
    step = 1.0
    while step <= max_skip:
        found.add(round(step))
        step = max(step + 1, step * _APART)
    pairs = StepPairs.of(sorted(step for step in found if 1 <= step <= max_skip), ratio=_HAND_NEIGHBORS)
    # The slowest steps lie farther apart than that: the next one may follow whatever it is.
    place = np.arange(pairs.n_steps)
    return StepPairs(
        pairs.steps,
        np.minimum(pairs.first, np.maximum(place - 1, 0)),
        np.maximum(pairs.end, np.minimum(place + 2, pairs.n_steps)),
    )


def _wished_steps(reduction: Reduction, wishes: Wishes, max_skip: int) -> set[int]:
    """Return the steps of locks and tangents, and the first and last within each range of speeds."""
    found: set[int] = set()
    ranges = [(lock.slowest, lock.fastest) for lock in wishes.locks] + [(wishes.slowest, wishes.fastest)]
    for upsample in set(reduction.upsamples):
        for speed in [*wishes.tangents, *(lock.fastest for lock in wishes.locks if lock.fixed)]:
            step = fixed_step(abs(speed), upsample)
            found |= set() if step is None else {step}
        for slowest, fastest in ranges:
            between = steps_between(slowest, fastest, upsample, max_skip)
            found |= {between[0], between[-1]} if between else set()
    return found


def usual_upsample(input_end: float) -> int:
    """Return the frames offered per analysis period where an input of some seconds moves like another."""
    return _EIGHTHS if input_end <= _EIGHTHS_UP_TO else _QUARTERS


def _ample(mean: float, dear: int) -> int:
    """Twice as much as on average; where that is dear, a quarter more."""
    return max(min(math.ceil(2 * mean - 1e-9), dear), math.ceil(1.25 * mean - 1e-9))
