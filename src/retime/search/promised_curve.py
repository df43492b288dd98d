"""From the frames of a path to a curve that keeps what was asked for, to the last digit.

A path is made of whole steps: locks, keytimes and limits lie where the grid comes nearest to them. Here each is put
where it was asked for. Which input every piece of the curve shows is the path's choice; how long it takes is solved
for: a locked piece takes what its speed says, and the others share what is left, each within its limits.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr
from retime.errors import InfeasibleWarpError
from retime.search.path_curve import bounded
from retime.search.reduction import Reduction
from retime.search.wishes.asked import Wishes
from retime.search.wishes.locks import LockedSpan
from retime.search.wishes.room import rounding
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime

# Seconds of input. Two places closer than this are one.
_SAME = 1e-9
# Steps beside a tangent have its speed, or as small a part of them as leaves room for the rest.
_PARTS = tuple(1 / (1 << halvings) for halvings in range(6))


@dataclass(frozen=True)
class Stretch:
    """A part of a curve between two anchors: keytimes, and ends of what has bounds of its own.

    Attributes
    ----------
    start, end : float
        Output times.
    slowest, fastest : float
        Speeds that it must stay between, without the sign of a backward span; equal where the speed is fixed.
    tangent : int
        -1 where it is fixed by a tangent where it starts, 1 by one where it ends; else 0.
    """

    start: float
    end: float
    slowest: float
    fastest: float
    tangent: int = 0

    @property
    def fixed(self) -> bool:
        """Whether only one speed is allowed."""
        return self.slowest == self.fastest


@dataclass(frozen=True, eq=False)
class PromisedCurve:
    """A path's curve before smoothing, and what of it must stay.

    Attributes
    ----------
    staircase : Warp
        Straight lines between its knots.
    stretches : tuple of Stretch
        From the first keytime to the last; holds have no bounds.
    position_times : float array, shape (n_output,)
        Output time of each frame of the path.
    given_up : tuple of str
        What could not be kept, in words: by no more than lengths and times are rounded.
    """

    staircase: Warp
    stretches: tuple[Stretch, ...]
    position_times: FloatArray
    given_up: tuple[str, ...] = ()

    __repr__ = brief_repr


@dataclass(frozen=True)
class _Pieces:
    """A span between keytimes cut into pieces that each have one speed.

    `moved` is the input that each shows (seconds, above 0), `speeds` what the path plays it at, `low` and `high` the
    bounds that were asked for; `soft` those of the search's own steps, `unit` whether the path plays it at unit speed;
    `tangent` is as that of `Stretch`.
    """

    moved: FloatArray
    speeds: FloatArray
    low: FloatArray
    high: FloatArray
    soft: tuple[float, float]
    unit: BoolArray
    tangent: IntArray


def promised_curve(
    reduction: Reduction,
    path: IntArray,
    wishes: Wishes,
    locked: Sequence[LockedSpan],
    max_skip: int,
    *,
    motion_rate: float,
    loop: bool = False,
) -> PromisedCurve:
    """Put a path on its keytimes and locks.

    Parameters
    ----------
    reduction : Reduction
        Not free.
    path : int array, shape (n_output,)
        Unrolled frames.
    wishes : Wishes
        Locks and speed limits; tangents are those of the keytimes.
    locked : sequence of LockedSpan
        Where the grid has the locks.
    max_skip : int
        The longest step.
    motion_rate : float
        Frames a second of the input, by which lengths and times are rounded.
    loop : bool
        Its first and its last speed agree.

    Raises
    ------
    InfeasibleWarpError
        Between two keytimes there is no room for what was asked for; says what would do.
    """
    keytimes, seam = reduction.keytimes, None
    if loop:
        ends = (keytimes[0].speed, keytimes[-1].speed)
        first_step = path[1] - path[0]
        seam = next((speed for speed in ends if speed is not None), None)
        if seam is None and not reduction.still[0]:
            seam = float(first_step) / reduction.upsamples[0]
    spans = []
    for span in range(len(keytimes) - 1):
        known = _Span(reduction, span, path, wishes, locked, max_skip, motion_rate, seam)
        spans.append(known.solved())
    output_times = [np.array([keytimes[0].output_time])]
    input_times = [np.array([keytimes[0].input_time])]
    positions = [np.array([keytimes[0].output_time])]
    for found in spans:
        output_times.append(found.output_times[1:])
        input_times.append(found.input_times[1:])
        positions.append(found.position_times[1:])
    staircase = Warp(np.concatenate(output_times), np.concatenate(input_times), keytimes, method="guided")
    return PromisedCurve(
        staircase,
        tuple(stretch for found in spans for stretch in found.stretches),
        np.concatenate(positions),
        tuple(dict.fromkeys(words for found in spans for words in found.given_up)),
    )


@dataclass(frozen=True)
class _SolvedSpan:
    output_times: FloatArray
    input_times: FloatArray
    position_times: FloatArray
    stretches: tuple[Stretch, ...]
    given_up: tuple[str, ...]


@dataclass(frozen=True)
class _Span:
    """One span between keytimes; see `promised_curve`. Progress is the input shown since its first keytime."""

    reduction: Reduction
    span: int
    path: IntArray
    wishes: Wishes
    locked: Sequence[LockedSpan]
    max_skip: int
    motion_rate: float
    seam: float | None

    @property
    def _keys(self) -> tuple[Keytime, Keytime]:
        before, after = self.reduction.keytimes[self.span : self.span + 2]
        return before, after

    def solved(self) -> _SolvedSpan:
        before, after = self._keys
        change, length = after.input_time - before.input_time, after.output_time - before.output_time
        total = abs(change)
        frames = self.path[self.reduction.positions[self.span] : self.reduction.positions[self.span + 1] + 1]
        if total <= _SAME:
            times = np.linspace(before.output_time, after.output_time, len(frames))
            times[-1] = after.output_time
            places = np.linspace(before.input_time, after.input_time, len(frames))
            hold = (Stretch(before.output_time, after.output_time, 0.0, math.inf),)
            return _SolvedSpan(times, places, times, hold, ())
        progress = self._progress(frames, total)
        edges = self._lock_edges(total)
        found: tuple[_Pieces, FloatArray] | None = None
        for part in _PARTS:
            knots = self._knots(progress, edges, part, total)
            pieces = self._pieces(frames, progress, knots, part, total)
            durations = _durations(pieces, length)
            found = None if durations is None else (pieces, durations)
            if found is not None or not self._tangents:
                break
        given_up: tuple[str, ...] = ()
        if found is None:
            durations, given_up = self._nearest(pieces, length)
            found = pieces, durations
        pieces, durations = found
        since = np.concatenate([[0.0], np.cumsum(durations)])
        times = before.output_time + since * (length / since[-1])
        places = before.input_time + math.copysign(1.0, change) * knots
        times[0], places[0] = before.output_time, before.input_time
        times[-1], places[-1] = after.output_time, after.input_time
        at = np.interp(progress, knots, times)
        at[0], at[-1] = times[0], times[-1]
        return _SolvedSpan(times, places, at, _stretches(times, pieces), given_up)

    def _progress(self, frames: IntArray, total: float) -> FloatArray:
        """Progress of each frame of the path: where locks begin and end, exactly where they were asked for."""
        begin = self.reduction.frames[self.span]
        grid = (frames - begin).astype(np.float64)
        anchors = [(0.0, 0.0), (float(grid[-1]), total)]
        if not self.reduction.still[self.span]:
            for one in self.locked:
                if one.span != self.span:
                    continue
                low, high = self._shown(one.start, one.end, total)
                anchors += [(float(one.first - begin), low), (float(one.last - begin), high)]
        anchors.sort()
        # Two locks, or a lock and a keytime, may meet in one frame: the path has no step between them.
        kept = [anchors[0]]
        for place, exact in anchors[1:-1]:
            if place > kept[-1][0] and exact > kept[-1][1] and place < grid[-1] and exact < total:
                kept.append((place, exact))
        kept.append(anchors[-1])
        places, exacts = zip(*kept, strict=True)
        return np.asarray(np.interp(grid, places, exacts))

    def _shown(self, start: float, end: float, total: float) -> tuple[float, float]:
        """Progress at which a stretch of the input begins and ends to be shown; empty where it is not."""
        before, after = self._keys
        ends = sorted(
            math.copysign(1.0, after.input_time - before.input_time) * (time - before.input_time)
            for time in (start, end)
        )
        return min(max(ends[0], 0.0), total), min(max(ends[1], 0.0), total)

    def _lock_edges(self, total: float) -> FloatArray:
        edges = [edge for lock in self.wishes.locks for edge in self._shown(lock.start, lock.end, total)]
        return np.array([edge for edge in edges if _SAME < edge < total - _SAME])

    @property
    def _tangents(self) -> tuple[tuple[bool, float], ...]:
        """Speeds that are asked for at its ends: whether at the last one, and the speed."""
        before, after = self._keys
        n_spans = len(self.reduction.keytimes) - 1
        at_first = before.speed if before.speed is not None or self.span > 0 else self.seam
        at_last = after.speed if after.speed is not None or self.span < n_spans - 1 else self.seam
        return tuple((last, abs(speed)) for last, speed in ((False, at_first), (True, at_last)) if speed is not None)

    def _knots(self, progress: FloatArray, edges: FloatArray, part: float, total: float) -> FloatArray:
        """Progress where one piece ends and the next begins, both ends included."""
        inner = [progress, edges]
        for last, _ in self._tangents:
            inner.append(np.array([self._tangent_end(progress, part, last, total)]))
        if self.reduction.still[self.span]:
            # Nothing in a crawl is worth a knot.
            inner[0] = progress[[0, -1]]
        found = np.unique(np.concatenate(inner))
        found = found[(found > _SAME) & (found < total - _SAME)]
        # An edge of a lock is the one to stay of two that meet.
        near = np.zeros(len(found), dtype=bool)
        if len(edges):
            apart = np.abs(found[:, None] - edges).min(axis=1)
            near = (apart > 0) & (apart <= _SAME)
        found = found[~near]
        kept = [0.0]
        for place in found.tolist():
            if place - kept[-1] > _SAME:
                kept.append(place)
        return np.array([*kept, total])

    def _tangent_end(self, progress: FloatArray, part: float, last: bool, total: float) -> float:
        """Where the speed of a tangent ends to hold, or begins to, at the span's last keytime."""
        step = progress[-1] - progress[-2] if last else progress[1] - progress[0]
        # Two of them may not meet.
        reach = min(float(step) * part, 0.45 * total if len(self._tangents) > 1 else 0.9 * total)
        return total - reach if last else reach

    def _pieces(self, frames: IntArray, progress: FloatArray, knots: FloatArray, part: float, total: float) -> _Pieces:
        moved, middle = np.diff(knots), (knots[:-1] + knots[1:]) / 2
        upsample = self.reduction.upsamples[self.span]
        steps = np.diff(frames)
        if self.reduction.still[self.span]:
            before, after = self._keys
            speeds = np.full(len(moved), total / (after.output_time - before.output_time))
            soft, unit = (0.0, math.inf), np.zeros(len(moved), dtype=bool)
        else:
            which = np.clip(np.searchsorted(progress, middle, side="right") - 1, 0, len(steps) - 1)
            speeds, unit = steps[which] / upsample, steps[which] == upsample
            soft = 1 / upsample, self.max_skip / upsample
        low, high = np.full(len(moved), self.wishes.slowest), np.full(len(moved), self.wishes.fastest)
        for lock in self.wishes.locks:
            begin, end = self._shown(lock.start, lock.end, total)
            inside = (middle > begin) & (middle < end)
            low[inside], high[inside] = np.maximum(low, lock.slowest)[inside], np.minimum(high, lock.fastest)[inside]
        tangent = np.zeros(len(moved), dtype=np.int64)
        for last, speed in self._tangents:
            edge = self._tangent_end(progress, part, last, total)
            beside = middle > edge if last else middle < edge
            tangent[beside & (low < high)] = 1 if last else -1
            low[beside], high[beside] = np.maximum(low, speed)[beside], np.minimum(high, speed)[beside]
        if (low > high * (1 + 1e-9)).any():
            place = int(np.argmax(low > high * (1 + 1e-9)))
            raise InfeasibleWarpError(
                f"{self._where()} {self.wishes.words_at(self._keys)} contradict each other: a speed of at least "
                f"{low[place]:g} and of at most {high[place]:g} is asked for. Loosen one of them",
                span=self.span,
                output_times=tuple(key.output_time for key in self._keys),
            )
        low = np.minimum(low, high)
        return _Pieces(moved, np.clip(speeds, low, high), low, high, soft, unit, tangent)

    def _where(self) -> str:
        before, after = self._keys
        return f"between output times {before.output_time:g} and {after.output_time:g} s"

    def _nearest(self, pieces: _Pieces, length: float) -> tuple[FloatArray, tuple[str, ...]]:
        """Return the durations that come nearest to what can't be had, and say so; refuse what is too far off."""
        least, most = _bounds(pieces, length)
        fastest, slowest = float(least.sum()), float(most.sum())
        too_short = length < fastest
        wanted = fastest if too_short else slowest
        before, after = self._keys
        at_end = self.span == len(self.reduction.keytimes) - 2
        what = self.wishes.words_at(self._keys, seam=self.seam is not None)
        if abs(length - wanted) > rounding(self.motion_rate, at_end=at_end, length=length):
            asked = f"{'at least' if too_short else 'at most'} {wanted:.4g} s"
            moves = f"{abs(length - wanted):.4g} s {'later' if too_short else 'earlier'}"
            raise InfeasibleWarpError(
                f"cannot keep {what} {self._where()}, where input {before.input_time:.2f}–{after.input_time:.2f} s is "
                f"shown: that takes {asked}, and the keytimes are {length:.4g} s apart. Put the later one {moves}, or "
                f"loosen {what}",
                span=self.span,
                output_times=(before.output_time, after.output_time),
            )
        factor = wanted / length
        return (least if too_short else most), (
            f"{self._where()} {what}: all speeds there are {abs(factor - 1):.2%} "
            f"{'above' if too_short else 'below'} that, for the keytimes leave no more room",
        )


def _bounds(pieces: _Pieces, length: float) -> tuple[FloatArray, FloatArray]:
    """Return the shortest and the longest that each piece may take, seconds."""
    with np.errstate(divide="ignore"):
        return pieces.moved / pieces.high, np.minimum(pieces.moved / pieces.low, max(length, 1e-9) * 1e6)


def _durations(pieces: _Pieces, length: float) -> FloatArray | None:
    """Say how long each piece takes: as the path has it, but that they add up to `length`; None where nothing does."""
    nominal = pieces.moved / pieces.speeds
    free = pieces.low < pieces.high
    softly = (
        np.maximum(pieces.low, min(pieces.soft[0], *pieces.speeds)),
        np.minimum(pieces.high, max(pieces.soft[1], *pieces.speeds)),
    )
    soft = replace(pieces, low=softly[0], high=softly[1])
    # First those change that are not at unit speed anyway, by no more than a quarter; at last all that may.
    attempts = [
        (soft, free & ~pieces.unit, 0.25),
        (soft, free, 0.25),
        (soft, free, 0.75),
        (soft, free, math.inf),
        (pieces, free, math.inf),
    ]
    for bounds, choice, most in attempts:
        least, longest = _bounds(bounds, length)
        wanted, there = length - nominal[~choice].sum(), nominal[choice].sum()
        if not choice.any():
            if abs(wanted) <= 1e-9 * length:
                return nominal
            continue
        if wanted <= 0 or abs(wanted / there - 1) > most:
            continue
        scaled = np.where(choice, nominal * (wanted / there), nominal)
        found = bounded(np.ones(len(scaled)), scaled, length, choice, least, longest)
        if found is not None:
            return found
    return None


def _stretches(times: FloatArray, pieces: _Pieces) -> tuple[Stretch, ...]:
    """Join neighbouring pieces that have the same bounds."""
    found: list[Stretch] = []
    for (start, end), low, high, tangent in zip(
        itertools.pairwise(times.tolist()),
        pieces.low.tolist(),
        pieces.high.tolist(),
        pieces.tangent.tolist(),
        strict=True,
    ):
        stretch = Stretch(start, end, low, high, tangent)
        if found and replace(found[-1], start=start, end=end) == stretch:
            found[-1] = replace(found[-1], end=end)
        else:
            found.append(stretch)
    return tuple(found)
