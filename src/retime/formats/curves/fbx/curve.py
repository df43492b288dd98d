"""AnimationCurves of FBX as segments, and segments as keys again, for many curves at once.

A key carries how its curve goes on to the next one: constant, linear or cubic; a cubic's slope here, its slope at the
next key, and how long both handles are. Slopes of automatic keys and of those with tension, continuity and bias follow
from the keys beside them. What the rules are was taken from files of Maya and from ufbx, which evaluates the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from retime.arrays import BoolArray, FloatArray, IntArray, doubles
from retime.brief import brief_repr
from retime.errors import FormatError
from retime.formats.curves.fbx.file import FbxFile, Record
from retime.formats.curves.fbx.scene import Item
from retime.warp.cutting import CurveBatch, SegmentKind

CONSTANT, LINEAR, CUBIC = 0x2, 0x4, 0x8
NEXT, AUTO, TCB, USER, BROKEN = 0x100, 0x100, 0x200, 0x400, 0x800
CLAMP, TIME_INDEPENDENT, CLAMP_PROGRESSIVE = 0x1000, 0x2000, 0x4000
WEIGHTED_RIGHT, WEIGHTED_NEXT_LEFT = 0x1000000, 0x2000000
VELOCITIES = 0x10000000 | 0x20000000
TANGENTS = AUTO | TCB | USER | BROKEN | CLAMP | TIME_INDEPENDENT | CLAMP_PROGRESSIVE
_WEIGHTED = WEIGHTED_RIGHT | WEIGHTED_NEXT_LEFT
# Weights are whole numbers of this, two in four bytes; both at a third where a key says nothing.
WEIGHT_STEP = 1e-4
THIRDS = 3333 | 3333 << 16
_LONGEST_SECONDS = 1e7
_LARGEST = 1e30
_PARTS = ("KeyTime", "KeyValueFloat", "KeyAttrFlags", "KeyAttrDataFloat", "KeyAttrRefCount")


class Extrapolation(NamedTuple):
    """How a curve goes on beyond its keys.

    Attributes
    ----------
    mode : str
        C constant, R repeated, A repeated with what it gained added, M mirrored, K straight on.
    times : int
        How often it is repeated; below 0 without end.
    """

    mode: str
    times: int


@dataclass(frozen=True, eq=False)
class Keys:
    """The keys of many curves, one curve after the other.

    Attributes
    ----------
    counts : int array, shape (n_curves,)
        Keys of each.
    ticks : int64 array, shape (n_keys,)
    values : float array, shape (n_keys,)
    flags : int array, shape (n_keys,)
    data : uint32 array, shape (n_keys, 4)
        The bits of each key's four numbers: right slope, slope at the next key, both weights, both velocities; or
        tension, continuity and bias.
    """

    counts: IntArray
    ticks: NDArray[np.int64]
    values: FloatArray
    flags: IntArray
    data: NDArray[np.uint32]

    __repr__ = brief_repr

    @property
    def starts(self) -> IntArray:
        """Where each curve's keys begin, and at the end their number, shape (n_curves + 1,)."""
        return np.concatenate([[0], np.cumsum(self.counts)]).astype(np.int64)


@dataclass(frozen=True, eq=False)
class CurveRecords:
    """Where a curve's numbers stand.

    Attributes
    ----------
    item : Item
    parts : tuple of Record
        KeyTime, KeyValueFloat, KeyAttrFlags, KeyAttrDataFloat, KeyAttrRefCount.
    letters : tuple of str
        The type of each.
    pre, post : Extrapolation
    """

    item: Item
    parts: tuple[Record, ...]
    letters: tuple[str, ...]
    pre: Extrapolation
    post: Extrapolation

    __repr__ = brief_repr


def read_curves(file: FbxFile, items: list[Item], ticks_a_second: int) -> tuple[list[CurveRecords], Keys]:
    """Read curves; raise FormatError where their arrays disagree, times go back, or a number is beyond use.

    Curves without a key have none here.
    """
    records, counts = [], []
    columns: list[tuple[NDArray[np.int64], FloatArray, IntArray, NDArray[np.uint32], IntArray]] = []
    for item in items:
        found = _parts(file, item)
        if found is None:
            continue
        one, arrays = found
        times, values, flags, data, runs = arrays
        n = len(times)
        if not n:
            continue
        if len(values) != n:
            raise file.error(f"a curve has {n} times and {len(values)} values", item.record)
        if len(flags) != len(runs) or len(data) != 4 * len(runs):
            raise file.error(
                f"a curve has {len(runs)} runs of attributes, {len(flags)} flags and {len(data)} numbers for them",
                item.record,
            )
        if (runs < 0).any() or int(runs.sum()) != n:
            raise file.error(f"a curve's attributes are for {int(runs.sum())} keys, it has {n}", item.record)
        records.append(one)
        counts.append(n)
        columns.append((times, values, flags, data, runs))
    if not records:
        empty = np.zeros(0, dtype=np.int64)
        return [], Keys(empty, empty, np.zeros(0), empty, np.zeros((0, 4), dtype=np.uint32))
    n_keys = np.array(counts, dtype=np.int64)
    runs = np.concatenate([one[4] for one in columns])
    keys = Keys(
        n_keys,
        np.concatenate([one[0] for one in columns]),
        doubles(np.concatenate([one[1] for one in columns])),
        np.repeat(np.concatenate([one[2] for one in columns]).astype(np.int64) & 0xFFFFFFFF, runs),
        np.repeat(np.concatenate([one[3] for one in columns]).reshape(-1, 4), runs, axis=0),
    )
    refuse_keys(file, records, keys, ticks_a_second)
    return records, keys


def _parts(
    file: FbxFile, item: Item
) -> tuple[CurveRecords, tuple[NDArray[np.int64], FloatArray, IntArray, NDArray[np.uint32], IntArray]] | None:
    by_name: dict[str, Record] = {}
    for child in item.record.children:
        by_name.setdefault(child.name, child)
    if "KeyTime" not in by_name:
        return None
    missing = [name for name in _PARTS if name not in by_name]
    if missing:
        raise file.error(f"a curve has no {' and no '.join(missing)}", item.record)
    parts = tuple(by_name[name] for name in _PARTS)
    times = file.array(parts[0], "l")
    values = file.array(parts[1], "fd")
    flags = file.array(parts[2], "i")
    data = _attributes(file, parts[3])
    runs = file.array(parts[4], "i")
    letters = ("l", "d" if values.dtype.itemsize == 8 else "f", "i", "f" if data.dtype.kind == "f" else "i", "i")
    pre, post = (_extrapolation(file, by_name.get(name)) for name in ("Pre-Extrapolation", "Post-Extrapolation"))
    return CurveRecords(item, parts, letters, pre, post), (times, values, flags, data.view(np.uint32), runs)


def _attributes(file: FbxFile, record: Record) -> NDArray[Any]:
    """Return what keys say of their tangents, as 32 bits each.

    In text these are whole numbers from version 7200 on; some programs write what the bits mean even then.
    """
    if file.version < 7200:
        return file.array(record, "fi")
    try:
        return file.array(record, "if")
    except FormatError:
        return file.array(record, "f")


def _extrapolation(file: FbxFile, record: Record | None) -> Extrapolation:
    kind = record.child("Type") if record is not None else None
    if record is None or kind is None:
        return Extrapolation("C", -1)
    values = file.values(kind)
    mode = values[0].content if values else "C"
    mode = chr(mode) if isinstance(mode, int) and 0 < mode < 128 else str(mode)
    if mode not in ("A", "C", "K", "M", "R"):
        raise file.error(f"a curve goes on beyond its keys in an unknown way, {mode!r}", kind)
    repetition = record.child("Repetition")
    said = file.values(repetition) if repetition is not None else []
    return Extrapolation(mode, file.whole(kind, said[0]) if said else -1)


def refuse_keys(file: FbxFile, records: list[CurveRecords], keys: Keys, ticks_a_second: int) -> None:
    """Raise FormatError for keys that no curve may hold: those of a file, and those that a warp has made of them."""

    def refuse(wrong: BoolArray, problem: str) -> None:
        if wrong.any():
            key = int(np.flatnonzero(wrong)[0])
            curve = int(np.searchsorted(keys.starts, key, side="right")) - 1
            raise file.error(f"key {key - int(keys.starts[curve])} of a curve {problem}", records[curve].item.record)

    longest = _LONGEST_SECONDS * ticks_a_second
    refuse((keys.ticks > longest) | (keys.ticks < -longest), "lies at a time that no clip can have")
    back = np.zeros(len(keys.ticks), dtype=bool)
    back[1:] = keys.ticks[1:] < keys.ticks[:-1]
    back[keys.starts[:-1]] = False
    refuse(back, "lies before the one in front of it")
    refuse(~(np.abs(keys.values) <= _LARGEST), "has a value that is not finite, or beyond any use")


class Slopes(NamedTuple):
    """How cubic keys leave and arrive: value a second, and handles in shares of a segment; each of shape (n_keys,)."""

    right: FloatArray
    left: FloatArray
    right_weight: FloatArray
    left_weight: FloatArray


def resolved(keys: Keys, ticks_a_second: int) -> Slopes:
    """Find every key's slopes and weights, whatever its mode is."""
    n = len(keys.ticks)
    flags, values = keys.flags, keys.values
    numbers = doubles(keys.data.view(np.float32))
    numbers = np.where(np.abs(numbers) <= _LARGEST, numbers, 0.0)
    first, last = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
    first[keys.starts[:-1]], last[keys.starts[1:] - 1] = True, True
    step = np.zeros(n)
    step[:-1] = np.diff(keys.ticks) / ticks_a_second
    step[last] = 0.0
    has_next = step > 0
    rise = np.zeros(n)
    rise[:-1] = np.diff(values)
    chord = np.divide(rise, step, out=np.zeros(n), where=has_next)
    before, before_step, before_rise = (_shifted(one, first) for one in (chord, step, rise))
    has_before = before_step > 0
    cubic = (flags & CUBIC != 0) & (flags & CONSTANT == 0)
    linear = ~cubic & (flags & CONSTANT == 0)

    packed = keys.data[:, 2]
    weight = np.where(flags & WEIGHTED_RIGHT, (packed & 0xFFFF) * WEIGHT_STEP, 1 / 3)
    next_weight = np.where(flags & WEIGHTED_NEXT_LEFT, (packed >> 16) * WEIGHT_STEP, 1 / 3)
    tcb = cubic & (flags & TCB != 0)
    plain = ~cubic | tcb
    weight = np.where(~cubic, 1 / 3, np.minimum(weight, 1.0))
    next_weight = np.where(plain, 1 / 3, np.minimum(next_weight, 1.0))
    right = np.where(cubic, numbers[:, 0], np.where(linear, chord, 0.0))
    next_left = np.where(cubic & ~tcb, numbers[:, 1], np.where(linear, chord, 0.0))
    left, left_weight = _shifted(next_left, first), _shifted(next_weight, first, missing=1 / 3)

    automatic = cubic & ~tcb & (flags & USER == 0)
    if automatic.any():
        here = np.flatnonzero(automatic)
        left[here], right[here] = _automatic(
            before[here],
            chord[here],
            before_step[here],
            step[here],
            before_rise[here],
            rise[here],
            left_weight[here],
            weight[here],
            -left[here],
            right[here],
            flags[here],
        )
    if tcb.any():
        edge = ~(has_before & has_next)
        factor = np.where(edge, 1.0, 0.5) * (1 - numbers[:, 0])
        more, less = numbers[:, 1], numbers[:, 2]
        one, two = np.where(has_before, before, 0.0), np.where(has_next, chord, 0.0)
        tcb_left = factor * ((1 + less) * (1 - more) * one + (1 - less) * (1 + more) * two)
        tcb_right = factor * ((1 + less) * (1 + more) * one + (1 - less) * (1 - more) * two)
        left, right = np.where(tcb, tcb_left, left), np.where(tcb, tcb_right, right)
    return Slopes(right, left, weight, left_weight)


def _shifted(column: FloatArray, first: BoolArray, missing: float = 0.0) -> FloatArray:
    """Give each key what the one before it has; `missing` to a curve's first."""
    moved = np.concatenate([[missing], column[:-1]]) if len(column) else column.copy()
    moved[first] = missing
    return moved


def _automatic(
    before: FloatArray,
    after: FloatArray,
    before_step: FloatArray,
    after_step: FloatArray,
    before_rise: FloatArray,
    after_rise: FloatArray,
    left_weight: FloatArray,
    right_weight: FloatArray,
    left_bias: FloatArray,
    right_bias: FloatArray,
    flags: IntArray,
) -> tuple[FloatArray, FloatArray]:
    """Find the slopes of automatic keys: left and right.

    `before` and `after` are the slopes of the straight lines to the keys beside, with their lengths and rises.
    """
    whole = before_step + after_step
    inside = (before_step > 0) & (after_step > 0)
    safe = np.where(whole > 0, whole, 1.0)
    across = (before_rise + after_rise) / safe
    share = before_step / safe
    mixed = 0.5 * across + 0.5 * (before * (1 - share) + after * share)
    timed = flags & TIME_INDEPENDENT == 0
    # A left slope and a right one that differ are biases in opposite directions.
    same = np.abs(right_bias - left_bias) <= 1e-4
    found = []
    for bias in (np.where(same, right_bias, left_bias), right_bias):
        strength = np.abs(bias) / 100
        target = np.where(bias > 0, after, before)
        biased = mixed * (1 - strength) + target * strength
        toward = np.where(np.abs(target - mixed) > 1e-5, target - mixed, bias)
        far = np.maximum(strength - 5, 0.0) ** 2 * 40
        biased = biased + far * np.where(toward > 0, 1.0, -1.0)
        slope = np.where(timed, np.where(strength > 1e-4, biased, mixed), across)
        found.append(
            _bounded(slope, before_rise, after_rise, left_weight * before_step, right_weight * after_step, flags)
        )
    # At the ends there is one line to go by.
    edge = np.where(before_step > 0, before, after)
    bias = np.where(before_step > 0, left_bias, right_bias)
    far = np.maximum(np.abs(bias) / 100 - 5, 0.0) ** 2 * 40
    edge = edge + np.where(timed, far * np.where(bias > 0, 1.0, -1.0), 0.0)
    still = (flags & CLAMP_PROGRESSIVE != 0) | ((flags & CLAMP != 0) & (before_rise + after_rise == 0)) | (whole <= 0)
    edge = np.where(still, 0.0, edge)
    return np.where(inside, found[0], edge), np.where(inside, found[1], edge)


def _bounded(
    slope: FloatArray,
    before_rise: FloatArray,
    after_rise: FloatArray,
    left_range: FloatArray,
    right_range: FloatArray,
    flags: IntArray,
) -> FloatArray:
    """Keep handles of automatic keys from going past the values of the keys beside them."""
    sign = np.where(slope >= 0, 1.0, -1.0)
    size = np.abs(slope)
    for rise, range_ in ((before_rise, left_range), (after_rise, right_range)):
        most = np.divide(sign * rise, range_, out=np.zeros(len(slope)), where=range_ > 0)
        size = np.minimum(size, np.maximum(most, 0.0))
    slope = np.where(flags & CLAMP_PROGRESSIVE, sign * size, slope)
    level = (flags & CLAMP != 0) & ((before_rise == 0) | (after_rise == 0))
    return np.where(level, 0.0, slope)


def segments_of(keys: Keys, ticks_a_second: int) -> tuple[CurveBatch, IntArray]:
    """Return curves as segments, in seconds, and the key that begins each.

    Keys at one time make a jump; there is no segment between them.
    """
    slopes = resolved(keys, ticks_a_second)
    last = np.zeros(len(keys.ticks), dtype=bool)
    last[keys.starts[1:] - 1] = True
    key = np.flatnonzero(~last)
    key = key[keys.ticks[key + 1] > keys.ticks[key]]
    owner = np.searchsorted(keys.starts, key, side="right") - 1
    times = keys.ticks / ticks_a_second
    begin, end = times[key], times[key + 1]
    width = end - begin
    first, second = keys.values[key], keys.values[key + 1]
    flags = keys.flags[key]
    constant = flags & CONSTANT != 0
    cubic = ~constant & (flags & CUBIC != 0)
    kinds = np.where(constant, SegmentKind.STEP, np.where(cubic, SegmentKind.CUBIC, SegmentKind.LINEAR))
    leave, arrive = slopes.right_weight[key] * width, slopes.left_weight[key + 1] * width
    out, into = slopes.right[key] * leave, slopes.left[key + 1] * arrive
    third = ~cubic
    leave[third], arrive[third] = width[third] / 3, width[third] / 3
    out[third], into[third] = ((second - first) / 3)[third], ((second - first) / 3)[third]
    spread = np.stack([begin, begin + leave, end - arrive, end], axis=1)
    spread[:, 1:3] = np.clip(spread[:, 1:3], spread[:, [0]], spread[:, [3]])
    values = np.stack([first, first + out, second - into, second], axis=1)
    held = np.where(flags & NEXT, second, first)
    values[constant] = held[constant, None]
    ends = keys.starts[1:] - 1
    counts = np.bincount(owner, minlength=len(keys.counts))
    batch = CurveBatch(spread, values[:, :, None], kinds.astype(np.int64), counts, times[ends], keys.values[ends, None])
    return batch, key
