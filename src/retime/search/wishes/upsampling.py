"""The smallest upsampling that can play every wished speed."""

from __future__ import annotations

import math
from collections.abc import Sequence

from retime.errors import OptionError
from retime.limits import MAX_STEP
from retime.search.wishes.locks import Lock
from retime.search.wishes.steps import fixed_step, steps_between

MAX_UPSAMPLE = 24


def upsample_for(
    least: int,
    locks: Sequence[Lock],
    tangents: Sequence[float],
    slowest: float = 0.0,
    fastest: float = math.inf,
) -> int:
    """Find the smallest upsampling that can play every wished speed.

    A fixed speed needs a step within 3 % of it: `retime.search.path_curve.knots_of_path` makes it exact. A range needs
    a step inside it. The limits of the whole clip need steps within 5 % of them, where less than 24 and steps of 64
    can give that.

    Parameters
    ----------
    least : int
        Upsampling that the keytimes ask for.
    locks : sequence of Lock
        Spans at given speeds.
    tangents : sequence of float
        Speeds at keytimes.
    slowest, fastest : float
        Playback speeds for the whole clip.

    Raises
    ------
    OptionError
        No upsampling plays them all; names one that can't be played.
    """
    fixed = [lock.fastest for lock in locks if lock.fixed] + [abs(speed) for speed in tangents]
    ranges = [(lock.slowest, lock.fastest) for lock in locks if not lock.fixed] + [(slowest, fastest)]

    def plays(upsample: int) -> bool:
        return all(fixed_step(speed, upsample) for speed in fixed) and all(
            steps_between(*pair, upsample) for pair in ranges
        )

    def near_limits(upsample: int) -> bool:
        steps = steps_between(slowest, fastest, upsample)
        low = slowest == 0 or steps[0] <= 1.05 * slowest * upsample
        return low and (fastest == math.inf or 0.95 * fastest * upsample <= steps[-1] <= 64)

    # A long result asks for more than 24 by itself.
    most = MAX_UPSAMPLE if least <= MAX_UPSAMPLE // 2 else 2 * least
    able = [upsample for upsample in range(least, most + 1) if plays(upsample)]
    for upsample in able:
        if near_limits(upsample):
            return upsample
    if able:
        return able[0]
    for speed in fixed:
        if not any(fixed_step(speed, upsample) for upsample in range(1, MAX_UPSAMPLE + 1)):
            raise OptionError(f"a speed of {speed:g} is beyond what can be played, 1/{MAX_UPSAMPLE} to {MAX_STEP}")
    for low, high in ranges:
        if not any(steps_between(low, high, upsample) for upsample in range(1, MAX_UPSAMPLE + 1)):
            raise OptionError(
                f"no speed from {low:g} to {high:g} can be played: speeds are fractions with denominators up to "
                f"{MAX_UPSAMPLE}, and at most {MAX_STEP}. Widen that range"
            )
    wanted = [*(f"{speed:g}" for speed in fixed), *(f"{low:g} to {high:g}" for low, high in ranges if high < math.inf)]
    raise OptionError(
        f"the wanted speeds {', '.join(wanted)} can't all be played in one warp: choose fractions with a common "
        f"denominator of at most {most}, up to {MAX_STEP}"
    )
