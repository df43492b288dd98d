"""What a warp was asked to keep, looked at in the warp itself: every key, lock, limit, tangent and the length.

Nothing here knows how a warp is found. A search looks at its own result with it before it hands it on, and tests look
at everybody's.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.search.wishes.locks import Lock
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime

# A speed may be off by this share: slopes between knots a millisecond apart are made of rounded times.
SPEED_TOLERANCE = 1e-6
# Seconds. Pieces shorter than this have no speed that could be told.
_SHORT = 1e-6


@dataclass(frozen=True)
class Broken:
    """One thing that a warp does not keep.

    Attributes
    ----------
    kind : str
        "key", "length", "lock", "limit", "tangent", "seam" or "direction".
    what : str
        What was asked for, in words.
    start, end : float
        Output times between which it is broken worst, seconds.
    found : float
        The speed there, without the sign of a backward span; of a key, the input time.
    off : float
        By what share of the speed that was asked for; of a key, by how many seconds.
    """

    kind: str
    what: str
    start: float
    end: float
    found: float
    off: float

    def __str__(self) -> str:
        if self.kind in ("key", "length"):
            return f"{self.what}: it is {self.off:.3g} s off"
        return f"{self.what}: it plays at {self.found:.4g} from output time {self.start:.3f} to {self.end:.3f} s"


def broken_promises(
    warp: Warp,
    keytimes: Sequence[Keytime],
    *,
    locks: Sequence[Lock] = (),
    slowest: float = 0.0,
    fastest: float = math.inf,
    loop: bool = False,
    tolerance: float = SPEED_TOLERANCE,
) -> tuple[Broken, ...]:
    """List what a warp does not keep; of each lock, limit and tangent the worst place.

    Parameters
    ----------
    warp : Warp
        The result.
    keytimes : sequence of Keytime
        In output order, ends included, with their tangents.
    locks : sequence of Lock
        Bind whatever the warp shows of their input, forward and backward.
    slowest, fastest : float
        Limits for the whole warp. A hold, between two keytimes that show the same, has no speed.
    loop : bool
        Its first and its last speed are one.
    tolerance : float
        Share by which a speed may be off.

    Examples
    --------
    >>> warp = Warp([0.0, 1.0, 2.0], [0.0, 1.0, 3.0])
    >>> keys = [Keytime(input_time=0.0, output_time=0.0), Keytime(input_time=3.0, output_time=2.0)]
    >>> [str(one) for one in broken_promises(warp, keys, locks=[Lock(0.5, 2.0)])]
    ['the lock 0.5–2 s at 1: it plays at 2 from output time 1.000 to 1.500 s']
    """
    found: list[Broken] = []
    ordered = sorted(keytimes)
    if warp.domain != (ordered[0].output_time, ordered[-1].output_time):
        off = abs(warp.output_start - ordered[0].output_time) + abs(warp.output_end - ordered[-1].output_time)
        found.append(Broken("length", f"a length of {ordered[-1].output_time:g} s", *warp.domain, warp.output_end, off))
    for key in ordered:
        shown = float(warp(key.output_time))
        if abs(shown - key.input_time) > 1e-9:
            what = f"the keytime {key.input_time:g} s at {key.output_time:g} s"
            off = abs(shown - key.input_time)
            found.append(Broken("key", what, key.output_time, key.output_time, shown, off))
    asked: list[tuple[str, str, float, float, float, float]] = [
        ("lock", f"the lock {lock}", lock.start, lock.end, lock.slowest, lock.fastest) for lock in locks
    ]
    if slowest > 0 or fastest < math.inf:
        words = f"the speed limits {slowest:g} to {fastest:g}"
        asked.append(("limit", words, -math.inf, math.inf, slowest, fastest))
    for kind, what, start, end, low, high in asked:
        worst: Broken | None = None
        for before, after in itertools.pairwise(ordered):
            if before.input_time == after.input_time:
                continue
            for one in _off(warp, before, after, start, end, low, high, tolerance):
                if worst is None or one[3] > worst.off:
                    worst = Broken(kind, what, *one)
        if worst is not None:
            found.append(worst)
    found += _turns(warp, ordered)
    found += _tangents(warp, ordered, tolerance)
    if loop:
        first, last = float(warp.slopes[0]), float(warp.slopes[-1])
        if abs(first - last) > tolerance * max(abs(first), abs(last)):
            what = f"one speed at the loop's seam, {first:.4g} at first"
            off = abs(last - first) / max(abs(first), 1e-300)
            found.append(Broken("seam", what, float(warp.output_times[-2]), warp.output_end, abs(last), off))
    return tuple(found)


def _pieces(warp: Warp, start: float, end: float, edges: Sequence[float] = ()) -> tuple[FloatArray, FloatArray]:
    """Knots of a part of a warp, with more where it passes input times `edges`."""
    inside = (warp.output_times > start) & (warp.output_times < end)
    times = np.concatenate([[start], warp.output_times[inside], [end]])
    places = warp(times)
    more = []
    for edge in edges:
        for i in np.flatnonzero((places[:-1] - edge) * (places[1:] - edge) < 0).tolist():
            more.append(times[i] + (edge - places[i]) / (places[i + 1] - places[i]) * (times[i + 1] - times[i]))
    times = np.unique(np.concatenate([times, more]))
    return times, warp(times)


def _off(
    warp: Warp,
    before: Keytime,
    after: Keytime,
    start: float,
    end: float,
    low: float,
    high: float,
    tolerance: float,
) -> list[tuple[float, float, float, float]]:
    """Pieces between two keytimes that show input from `start` to `end` at a speed out of range."""
    edges = [edge for edge in (start, end) if math.isfinite(edge)]
    times, places = _pieces(warp, before.output_time, after.output_time, edges)
    seconds, moved = np.diff(times), np.diff(places)
    middle = (places[:-1] + places[1:]) / 2
    speeds = np.abs(moved) / seconds
    # What lies within a billionth of a second of an edge lies on it.
    shown = (middle > start + 1e-9) & (middle < end - 1e-9) & (seconds > _SHORT)
    # Times are rounded to some units in their last place.
    blur = 4 * np.spacing(max(abs(after.output_time), abs(after.input_time), abs(before.input_time))) / seconds
    wrong = shown & (
        (speeds < low * (1 - tolerance) - blur * (1 + low)) | (speeds > high * (1 + tolerance) + blur * (1 + high))
    )
    return [
        (
            float(times[i]),
            float(times[i + 1]),
            float(speeds[i]),
            float(1 - speeds[i] / low if speeds[i] < low else speeds[i] / high - 1),
        )
        for i in np.flatnonzero(wrong)
    ]


def _turns(warp: Warp, ordered: Sequence[Keytime]) -> list[Broken]:
    """Where the warp runs against the direction of its keytimes."""
    for before, after in itertools.pairwise(ordered):
        times, places = _pieces(warp, before.output_time, after.output_time)
        sign = np.sign(after.input_time - before.input_time)
        back = np.diff(places) * sign
        if sign and (back < -1e-9).any():
            i = int(np.argmin(back))
            what = f"playing on from {before.input_time:g} to {after.input_time:g} s"
            speed = float(back[i] / (times[i + 1] - times[i]))
            return [Broken("direction", what, float(times[i]), float(times[i + 1]), speed, -speed)]
        if not sign and np.abs(places - before.input_time).max() > 1e-9:
            what = f"a hold at {before.input_time:g} s"
            return [Broken("direction", what, before.output_time, after.output_time, math.nan, math.inf)]
    return []


def _tangents(warp: Warp, ordered: Sequence[Keytime], tolerance: float) -> list[Broken]:
    found = []
    for place, key in enumerate(ordered):
        if key.speed is None:
            continue
        for other, side in ((place - 1, -1), (place + 1, 1)):
            if not 0 <= other < len(ordered) or ordered[other].input_time == key.input_time:
                continue
            start, end = sorted((key.output_time, ordered[other].output_time))
            times, places = _pieces(warp, start, end)
            i = -1 if side < 0 else 0
            seconds = float(np.diff(times)[i])
            speed = float(abs(np.diff(places)[i])) / seconds
            blur = 4 * float(np.spacing(max(abs(key.output_time), abs(key.input_time)))) / seconds
            if abs(speed - key.speed) > tolerance * key.speed + blur * (1 + key.speed):
                what = f"the tangent {key.speed:g} at output time {key.output_time:g} s"
                off = abs(speed / key.speed - 1)
                found.append(
                    Broken("tangent", what, float(times[i - (side < 0)]), float(times[i + (side > 0)]), speed, off)
                )
    return found
