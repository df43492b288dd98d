"""The span of an animation stack, its curves, and what they do beyond their keys."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr
from retime.formats.curves.fbx.curve import CurveRecords, Extrapolation, Keys, read_curves, resolved, segments_of
from retime.formats.curves.fbx.keys import OldCurves
from retime.formats.curves.fbx.scene import FbxScene, Stack
from retime.warp.cutting import CurveBatch, SegmentKind

# Times, values, kinds, keys that begin them, and whether they lie between keys of the file: of some segments.
_Part = tuple[FloatArray, FloatArray, IntArray, IntArray, BoolArray]
Beyond = tuple[int, str]
"""A curve, by its place in `StackCurves.records`, and the side on which it goes on: the record that says so."""
# Segments that repetitions of one curve may come to.
_MOST_REPEATED = 1_000_000


@dataclass(frozen=True, eq=False)
class StackCurves:
    """A stack with its curves read.

    Attributes
    ----------
    stack : Stack
    records : list of CurveRecords
        Of each curve that has a key.
    keys : Keys
    start, end : float
        Seconds: from where the stack says that it begins, or the first key, to where it ends, or the last.
    """

    stack: Stack
    records: list[CurveRecords]
    keys: Keys
    start: float
    end: float

    __repr__ = brief_repr


def read_stack(scene: FbxScene, stack: Stack) -> StackCurves:
    """Read a stack's curves; raise FormatError where they have no key."""
    records, keys = read_curves(scene.file, stack.curves, scene.ticks)
    if not len(keys.ticks):
        raise scene.file.error(
            f"the animation {stack.name!r} moves nothing: no curve of it has a key", stack.item.record
        )
    start, end = (float(tick) / scene.ticks for tick in (keys.ticks.min(), keys.ticks.max()))
    for first, last in (("LocalStart", "LocalStop"), ("ReferenceStart", "ReferenceStop")):
        # What a stack does not say is 0.
        low, high = (scene.seconds(scene.time(stack, name) or 0) for name in (first, last))
        if low is not None and high is not None and low < high:
            start, end = min(start, low), max(end, high)
            break
    return StackCurves(stack, records, keys, start, end)


def extended(scene: FbxScene, curves: StackCurves, low: float, high: float) -> tuple[OldCurves, list[Beyond]]:
    """Return the segments of curves, with what they do beyond their keys from `low` to `high`, seconds.

    Returns
    -------
    old : OldCurves
    written : list of Beyond
        The curves that do something beyond their keys there, other than to hold, and on which side.

    Raises
    ------
    FormatError
        A curve is repeated too often.
    """
    batch, key = segments_of(curves.keys, scene.ticks)
    own = np.ones(len(key), dtype=bool)
    active: list[int] = []
    written: list[Beyond] = []
    full = np.flatnonzero(batch.counts)
    # Before its first key a curve has that key's value, which is not what a step to the next one's begins with.
    first_values = curves.keys.values[curves.keys.starts[full]]
    odd = set(full[batch.values[batch.starts[full], 0, 0] != first_values].tolist())
    for index in full.tolist():
        one = curves.records[index]
        first, last = batch.times[batch.starts[index], 0], batch.end_times[index]
        sides = [
            *(["Pre-Extrapolation"] if one.pre.mode != "C" and low < first else []),
            *(["Post-Extrapolation"] if one.post.mode != "C" and high > last else []),
        ]
        written += [(index, side) for side in sides]
        if sides or (index in odd and low < first):
            active.append(index)
    if not active:
        return OldCurves(curves.keys, batch, key, own), written
    slopes = resolved(curves.keys, scene.ticks)
    parts: list[_Part] = []
    end_times, end_values, counts = batch.end_times.copy(), batch.end_values.copy(), batch.counts.copy()
    place = 0
    for index in active:
        one = curves.records[index]
        begin, stop = batch.starts[index], batch.starts[index + 1]
        if place < begin:
            parts.append(_slice(batch, key, own, place, int(begin)))
        place = int(stop)
        curve = _slice(batch, key, own, int(begin), place)
        first_key, last_key = curves.keys.starts[index], curves.keys.starts[index + 1] - 1
        before: list[_Part] = []
        after: list[_Part] = []
        ends = (float(curves.keys.values[first_key]), float(curves.keys.values[last_key]))
        first, last = float(curve[0][0, 0]), float(batch.end_times[index])
        if low < first and (one.pre.mode != "C" or index in odd):
            before, _ = _beyond(scene, one, one.pre, curve, low, ends, float(slopes.right[first_key]), -1)
        if one.post.mode != "C" and high > last:
            after, end_values[index] = _beyond(scene, one, one.post, curve, high, ends, float(slopes.left[last_key]), 1)
        pieces = [*before[::-1], curve, *after]
        parts += pieces
        counts[index] = sum(len(piece[0]) for piece in pieces)
        if after:
            end_times[index] = after[-1][0][-1, 3]
    parts.append(_slice(batch, key, own, place, len(key)))
    times, values, kinds, keys, owned = (np.concatenate(column) for column in zip(*parts, strict=True))
    # Copies are laid side by side; what rounding parts must meet.
    whole = CurveBatch(times, values, kinds, counts, end_times, end_values)
    inner = np.setdiff1d(np.arange(len(times)), whole.starts)
    times[inner, 0] = times[inner - 1, 3]
    times[:, 1:3] = np.clip(times[:, 1:3], times[:, [0]], times[:, [3]])
    return OldCurves(curves.keys, whole, keys, owned), written


def _slice(batch: CurveBatch, key: IntArray, own: BoolArray, begin: int, stop: int) -> _Part:
    part = slice(begin, stop)
    return batch.times[part].copy(), batch.values[part], batch.kinds[part], key[part], own[part]


def _beyond(
    scene: FbxScene,
    record: CurveRecords,
    how: Extrapolation,
    curve: _Part,
    limit: float,
    ends: tuple[float, float],
    slope: float,
    way: int,
) -> tuple[list[_Part], float]:
    """Return what lies beyond a curve's keys up to a time, the nearest part first, and the value behind all that.

    `ends` are the values of its first key and its last; `way` is 1 for behind them, -1 for before.
    """
    times, values, kinds, key, _ = curve
    first, last = float(times[0, 0]), float(times[-1, 3])
    edge, at = (last, ends[1]) if way > 0 else (first, ends[0])
    if how.mode in ("K", "C"):
        far = limit + way
        spread = np.linspace(min(edge, far), max(edge, far), 4)[None]
        line = at + (slope if how.mode == "K" else 0.0) * (spread[:, :, None] - edge)
        kind = SegmentKind.LINEAR if how.mode == "K" else SegmentKind.STEP
        return [(spread, line, np.array([kind]), key[-1:], np.zeros(1, dtype=bool))], float(
            line[0, 3 if way > 0 else 0, 0]
        )
    length = last - first
    n = int(min(np.ceil(abs(limit - edge) / length), 2**31))
    n = min(n, how.times) if how.times >= 0 else n
    if n * len(times) > _MOST_REPEATED:
        raise scene.file.error(
            f"a curve of {length:g} s is repeated {n} times up to {limit:g} s: give the stack an end that it reaches",
            record.item.record,
        )
    found: list[_Part] = []
    not_own = np.zeros(len(times), dtype=bool)
    rise = ends[1] - ends[0]
    for turn in range(1, n + 1):
        shift = way * turn * length
        if how.mode == "M" and turn % 2:
            mirrored = (first + last - times)[::-1, ::-1]
            found.append((mirrored + shift, values[::-1, ::-1], kinds[::-1], key[::-1], not_own))
            at = ends[0] if way > 0 else ends[1]
        else:
            gained = way * turn * rise if how.mode == "A" else 0.0
            found.append((times + shift, values + gained, kinds, key, not_own))
            at = (ends[1] if way > 0 else ends[0]) + gained
    if way < 0:
        # What is repeated no more holds; so it does where the warp begins, and its first key must say it.
        begin = first - n * length
        spread = np.linspace(min(limit, begin) - 1.0, begin, 4)[None]
        hold = np.full((1, 4, 1), at)
        found.append((spread, hold, np.array([SegmentKind.STEP]), key[:1], np.zeros(1, dtype=bool)))
    return found, at
