"""How long the part between two keytimes may take, whatever path is found: exactly, off any grid."""

from __future__ import annotations

import itertools
import math

from retime.search.reduction import SLOWEST_SEARCHED
from retime.search.wishes.asked import Wishes
from retime.warp.keytime import Keytime

# A difference of so many frames of the motion is what times and lengths are rounded by; it is said, and not refused.
# A length counts its last frame, too. But never where speeds would be off by more than this share.
_ROUNDED, _ROUNDED_AT_END, MOST_OFF = 0.51, 1.51, 0.05


def room_between(before: Keytime, after: Keytime, wishes: Wishes) -> tuple[float, float]:
    """Return the shortest and the longest time that locks and limits leave a span, seconds.

    Parameters
    ----------
    before, after : Keytime
        Its ends; only their input times count.
    wishes : Wishes
        Locks and speed limits.

    Examples
    --------
    >>> from retime.search.wishes.locks import Lock
    >>> wishes = Wishes(4.0, (Lock(1.0, 2.0), ), (), 0.5, 2.0)
    >>> room_between(Keytime(input_time=0.0, output_time=0.0), Keytime(input_time=4.0, output_time=9.0), wishes)
    (2.5, 7.0)
    """
    low, high = sorted((before.input_time, after.input_time))
    if high - low <= 1e-9:
        return 0.0, math.inf
    edges = {low, high}
    for lock in wishes.locks:
        edges |= {edge for edge in (lock.start, lock.end) if low < edge < high}
    ordered = sorted(edges)
    shortest = longest = 0.0
    for start, end in itertools.pairwise(ordered):
        slowest, fastest = wishes.slowest, wishes.fastest
        for lock in wishes.locks:
            if lock.start < (start + end) / 2 < lock.end:
                slowest, fastest = max(slowest, lock.slowest), min(fastest, lock.fastest)
        shortest += (end - start) / fastest
        longest += (end - start) / slowest if slowest > 0 else math.inf
    return shortest, longest


def crawls(before: Keytime, after: Keytime, wishes: Wishes) -> bool:
    """Whether a span's locks leave so much time to the rest of it that this moves too slowly to be searched."""
    low, high = sorted((before.input_time, after.input_time))
    locks = [(max(lock.start, low), min(lock.end, high), lock) for lock in wishes.locks]
    locks = [one for one in locks if one[1] - one[0] > 1e-9]
    if not locks or math.isinf(after.output_time):
        return False
    moved = high - low - sum(end - start for start, end, _ in locks)
    slowest = [(end - start) / lock.slowest if lock.slowest > 0 else math.inf for start, end, lock in locks]
    rest = after.output_time - before.output_time - sum(slowest)
    return 1e-9 < moved < SLOWEST_SEARCHED * rest


def rounding(motion_rate: float, *, at_end: bool, length: float) -> float:
    """Return by how many seconds keytimes may miss that, for times and lengths are rounded to frames."""
    return min((_ROUNDED_AT_END if at_end else _ROUNDED) / motion_rate, MOST_OFF * length)
