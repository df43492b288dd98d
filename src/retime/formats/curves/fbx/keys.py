"""Curves that were cut, as keys of FBX: flags and attributes stay where they still say what the curve does."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr
from retime.formats.curves.fbx.curve import (
    BROKEN,
    CONSTANT,
    CUBIC,
    LINEAR,
    NEXT,
    TANGENTS,
    TCB,
    THIRDS,
    USER,
    VELOCITIES,
    WEIGHT_STEP,
    WEIGHTED_NEXT_LEFT,
    WEIGHTED_RIGHT,
    Keys,
    resolved,
)
from retime.warp.cutting import CurveBatch, SegmentKind

_WEIGHTED = WEIGHTED_RIGHT | WEIGHTED_NEXT_LEFT
# A handle that stands upright has no slope; this is the steepest that is written.
_STEEPEST = 1e30
_MOST_STEPS = 10_000
# A segment whose handles miss by more than this share of its curve's largest value is halved, a few times at most.
_FAR_OFF, _MOST_HALVINGS = 4e-6, 4
# How often steps to the next key's value are looked through; a long row of them may fall, each by the one behind it.
_MOST_TURNS = 10


@dataclass(frozen=True, eq=False)
class OldCurves:
    """Curves before they are cut.

    Attributes
    ----------
    keys : Keys
    batch : CurveBatch
        Their segments, those that stand for an extrapolation included.
    key : int array, shape (n_segments,)
        The key that begins each, or began what is repeated.
    own : bool array, shape (n_segments,)
        Whether it lies between keys of the file, not beyond them.
    """

    keys: Keys
    batch: CurveBatch
    key: IntArray
    own: BoolArray

    __repr__ = brief_repr


@dataclass(eq=False)
class _Pieces:
    """The new segments, each with the key that begins it; all of shape (n_segments,).

    Attributes
    ----------
    owner : int array
        The curve.
    begin, end : int arrays
        Ticks.
    first, last : float arrays
        Values.
    kind : int array
    right, left : float arrays
        Slopes at its beginning and its end, value a second.
    right_weight, left_weight : float arrays
        Handles, in shares of its length.
    base : int array
        The flags of the old key that began it.
    old : int array
        That key.
    kept : bool array
        Whether that key's flags and attributes may stand as they are.
    stored : float array
        The value of its key, which is not what it begins with where a step goes to the next key's value.
    """

    owner: IntArray
    begin: NDArray[np.int64]
    end: NDArray[np.int64]
    first: FloatArray
    last: FloatArray
    kind: IntArray
    right: FloatArray
    left: FloatArray
    right_weight: FloatArray
    left_weight: FloatArray
    base: IntArray
    old: IntArray
    kept: BoolArray
    stored: FloatArray

    def doubled(self, places: IntArray) -> tuple[_Pieces, IntArray]:
        """Return the pieces with a copy behind each of some of them, and where the copies are."""
        columns = {one.name: getattr(self, one.name) for one in fields(self)}
        copies = places + 1 + np.arange(len(places))
        return _Pieces(**{name: np.insert(one, places + 1, one[places]) for name, one in columns.items()}), copies


def new_keys(old: OldCurves, cut: CurveBatch, source: IntArray, ticks_a_second: int) -> Keys:
    """Return the keys of curves that were cut.

    Cubic segments become cubics with slopes of their own. A key whose slopes and weights come out as they must with its
    old flags, automatic ones say, keeps these. A jump that FBX has no flag for takes two keys, one tick apart.

    Parameters
    ----------
    old : OldCurves
        Before the cut.
    cut, source : CurveBatch, int array
        What `retime.warp.cutting.cut_curves` made of them.
    ticks_a_second : int
        The file's unit of time.
    """
    cut, source, handles = _refined(cut, source)
    pieces = _pieces(old, cut, source, handles, ticks_a_second)
    pieces = _with_jumps(pieces, cut.end_values[:, 0])
    counts = np.bincount(pieces.owner, minlength=len(cut))
    explicit, kept = _keys(pieces, old, cut, counts, ticks_a_second)
    key = np.arange(len(pieces.owner)) + pieces.owner
    old_key = np.zeros(len(kept), dtype=np.int64)
    old_key[key] = pieces.old
    old_key[np.cumsum(counts) + np.arange(len(counts))] = old.keys.starts[1:] - 1
    old_flags, old_data = old.keys.flags[old_key], old.keys.data[old_key]
    # Their slopes follow from the keys beside them; of some of these by tension, continuity and bias.
    following = old_flags & (CUBIC | CONSTANT | USER) == CUBIC
    automatic = following & (old_flags & TCB == 0)
    # What key i says of the slope at key i + 1 is that one's bias, where it is automatic.
    bias = old.keys.data[np.maximum(old_key[1:] - 1, 0), 1]
    beside = np.ones(len(kept) - 1, dtype=bool)
    beside[explicit.starts[1:-1] - 1] = False
    while True:
        data = np.where(kept[:, None], old_data, explicit.data)
        itself = kept & automatic
        data[itself, 1] = explicit.data[itself, 1]
        data[:-1, 1] = np.where(itself[1:] & beside, bias, data[:-1, 1])
        flags = np.where(kept, old_flags, explicit.flags)
        keys = Keys(explicit.counts, explicit.ticks, explicit.values, flags, data)
        wrong = _wrong(pieces, key, keys, kept & following, ticks_a_second) & kept
        if not wrong.any():
            return keys
        kept &= ~wrong


def _refined(cut: CurveBatch, source: IntArray) -> tuple[CurveBatch, IntArray, _Handles]:
    """Halve the cubic segments whose handles, in whole steps of weight, would move the curve too far.

    Returns the curves, where their segments came from, and the handles of those that are cubic.
    """
    for turn in range(_MOST_HALVINGS + 1):
        cubic = np.flatnonzero(cut.kinds == SegmentKind.CUBIC)
        handles = _handles(cut.times[cubic], cut.values[cubic, :, 0])
        owner = np.repeat(np.arange(len(cut)), cut.counts)
        largest = np.zeros(len(cut))
        np.maximum.at(largest, owner, np.abs(cut.values[:, (0, 3), 0]).max(axis=1, initial=0.0))
        coarse = cubic[handles.off > _FAR_OFF * largest[owner[cubic]]]
        if not len(coarse) or turn == _MOST_HALVINGS:
            break
        times, first_times, second_times = cut.times, *_halves(cut.times[coarse][:, :, None])
        values, first_values, second_values = cut.values, *_halves(cut.values[coarse])
        parts = np.ones(len(times), dtype=np.int64)
        parts[coarse] = 2
        times, values = np.repeat(times, parts, axis=0), np.repeat(values, parts, axis=0)
        place = coarse + np.arange(len(coarse))
        times[place], times[place + 1] = first_times[:, :, 0], second_times[:, :, 0]
        values[place], values[place + 1] = first_values, second_values
        counts = np.bincount(owner, weights=parts, minlength=len(cut)).astype(np.int64)
        cut = CurveBatch(times, values, np.repeat(cut.kinds, parts), counts, cut.end_times, cut.end_values)
        source = np.repeat(source, parts)
    return cut, source, handles


def _halves(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Part cubic Bézier curves, (n, 4, k), in their middle."""
    lines = (points[:, 1:] + points[:, :-1]) / 2
    bends = (lines[:, 1:] + lines[:, :-1]) / 2
    middle = (bends[:, 1:] + bends[:, :-1]) / 2
    first = np.concatenate([points[:, :1], lines[:, :1], bends[:, :1], middle], axis=1)
    return first, np.concatenate([middle, bends[:, 1:], lines[:, 2:], points[:, 3:]], axis=1)


def _pieces(old: OldCurves, cut: CurveBatch, source: IntArray, handles: _Handles, ticks_a_second: int) -> _Pieces:
    begin, end = (np.rint(cut.times[:, place] * ticks_a_second).astype(np.int64) for place in (0, 3))
    owner = np.repeat(np.arange(len(cut)), cut.counts)
    # What is shorter than a tick has no place.
    lasting = end > begin
    begin, end, owner, source = begin[lasting], end[lasting], owner[lasting], source[lasting]
    times, values, kind = cut.times[lasting], cut.values[lasting, :, 0], cut.kinds[lasting]
    width = times[:, 3] - times[:, 0]
    cubic = kind == SegmentKind.CUBIC
    chord = np.where(kind == SegmentKind.LINEAR, (values[:, 3] - values[:, 0]) / width, 0.0)
    right, left = chord.copy(), chord.copy()
    right_weight, left_weight = np.full(len(kind), 1 / 3), np.full(len(kind), 1 / 3)
    curved = lasting[cut.kinds == SegmentKind.CUBIC]
    right[cubic], left[cubic] = handles.right[curved], handles.left[curved]
    right_weight[cubic], left_weight[cubic] = handles.right_weight[curved], handles.left_weight[curved]

    within = (source >= 0) & (source < old.batch.counts[owner])
    key, base = np.zeros(len(owner), dtype=np.int64), np.full(len(owner), CONSTANT)
    kept = np.zeros(len(owner), dtype=bool)
    was = (old.batch.starts[owner] + source)[within]
    key[within] = old.key[was]
    base[within] = old.keys.flags[old.key[was]]
    # Shown whole and forward, a segment's key may stay as it is where its length does, or where its slopes follow from
    # the keys beside it.
    same = old.own[was] & (old.batch.values[was, :, 0] == values[within]).all(axis=1)
    first = old.key[was]
    after = np.minimum(first + 1, len(old.keys.ticks) - 1)
    unmoved = (old.keys.ticks[after] - old.keys.ticks[first]) == (end - begin)[within]
    follows = old.keys.flags[first] & (CUBIC | CONSTANT | USER) == CUBIC
    stepped = old.keys.flags[first] & CONSTANT != 0
    kept[within] = same & (unmoved | follows | stepped)
    stored = values[:, 0].copy()
    to_next = kept & (base & CONSTANT != 0) & (base & NEXT != 0)
    stored[to_next] = old.keys.values[key[to_next]]
    return _Pieces(
        owner,
        begin,
        end,
        values[:, 0],
        values[:, 3],
        kind,
        right,
        left,
        right_weight,
        left_weight,
        base,
        key,
        kept,
        stored,
    )


class _Handles(NamedTuple):
    """Slopes and weights of cubic segments at both ends, and by how much they miss the curve; each of shape (n,)."""

    right: FloatArray
    left: FloatArray
    right_weight: FloatArray
    left_weight: FloatArray
    off: FloatArray


def _handles(times: FloatArray, values: FloatArray) -> _Handles:
    """Return the handles of cubic segments.

    Weights are whole steps, but for a third. Of those that lie beside the true ones the pair is taken, with slopes to
    match, that moves the curve least.

    Parameters
    ----------
    times, values : float arrays, shape (n, 4)
    """
    width = times[:, 3] - times[:, 0]
    true = np.stack([times[:, 1] - times[:, 0], times[:, 3] - times[:, 2]]) / width
    rises = np.stack([values[:, 1] - values[:, 0], values[:, 3] - values[:, 2]])
    third = np.abs(true - 1 / 3) < 1e-9
    steps = true / WEIGHT_STEP
    exact = third | (np.abs(steps - np.rint(steps)) < 1e-4)
    weights = np.where(third, 1 / 3, np.clip(np.rint(steps), 1, _MOST_STEPS) * WEIGHT_STEP)
    # A handle keeps its direction, and where it has none its height.
    upright = true < 1e-9
    slopes = rises / (np.where(upright, WEIGHT_STEP, true) * width)
    inexact = np.flatnonzero(~exact.all(axis=0) & ~upright.any(axis=0))
    off = np.zeros(len(times))
    if len(inexact):
        part = (times[inexact], values[inexact], steps[:, inexact], exact[:, inexact], weights[:, inexact])
        slopes[:, inexact], weights[:, inexact], off[inexact] = _nearest_handles(*part, slopes[:, inexact])
    slopes = np.clip(slopes, -_STEEPEST, _STEEPEST)
    return _Handles(slopes[0], slopes[1], weights[0], weights[1], off)


def _nearest_handles(
    times: FloatArray,
    values: FloatArray,
    steps: FloatArray,
    exact: BoolArray,
    weights: FloatArray,
    slopes: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Choose weights below or above the true ones, and slopes by least squares.

    Returns slopes and weights, (2, n) each, and by how much the curves miss the true ones, (n,).
    """
    width = times[:, 3] - times[:, 0]
    share = np.arange(1, 16) / 16
    basis = np.stack([(1 - share) ** 3, 3 * share * (1 - share) ** 2, 3 * share**2 * (1 - share), share**3])
    along = (times - times[:, :1]) @ basis / width[:, None]
    wanted = values @ basis
    best = np.full(len(times), np.inf)
    best_slopes, best_weights = slopes.copy(), weights.copy()
    for first in (np.floor, np.ceil):
        for second in (np.floor, np.ceil):
            tried = np.stack(
                [np.clip(one(step), 1, _MOST_STEPS) for one, step in zip((first, second), steps, strict=True)]
            )
            tried = np.where(exact, weights, tried * WEIGHT_STEP)
            u = _parameters(tried, along)
            v = 1 - u
            one, two = 3 * u * v * v, 3 * u * u * v
            ends = (v**3 + one) * values[:, :1] + (u**3 + two) * values[:, 3:]
            # How far the handles rise, so that the curve goes through what is wanted as nearly as it can.
            a, b, c = (one * one).sum(axis=1), -(one * two).sum(axis=1), (two * two).sum(axis=1)
            off = wanted - ends
            p, q = (one * off).sum(axis=1), -(two * off).sum(axis=1)
            whole = a * c - b * b
            sound = whole > 1e-12
            safe = np.where(sound, whole, 1.0)
            rises = np.stack([(c * p - b * q) / safe, (a * q - b * p) / safe])
            rises = np.where(sound, rises, slopes * tried * width)
            error = np.abs(off - rises[0][:, None] * one + rises[1][:, None] * two).max(axis=1)
            better = error < best
            best = np.where(better, error, best)
            best_weights = np.where(better, tried, best_weights)
            best_slopes = np.where(better, rises / (tried * width), best_slopes)
    return best_slopes, best_weights, best


def _parameters(weights: FloatArray, along: FloatArray) -> FloatArray:
    """Solve for the parameters at which curves with handles of these weights are `along` their lengths, (n, m)."""
    low, high = np.zeros_like(along), np.ones_like(along)
    first, second = weights[0][:, None], 1 - weights[1][:, None]
    u = along.copy()
    for _ in range(60):
        v = 1 - u
        at = 3 * u * v * v * first + 3 * u * u * v * second + u**3
        low, high = np.where(at <= along, u, low), np.where(at >= along, u, high)
        slope = 3 * v * v * first + 6 * u * v * (second - first) + 3 * u * u * (1 - second)
        step = u - (at - along) / np.where(slope > 1e-9, slope, np.inf)
        better = np.where((step > low) & (step < high) & (slope > 1e-9), step, (low + high) / 2)
        if np.abs(better - u).max() < 1e-13:
            return better
        u = better
    return u


def _with_jumps(pieces: _Pieces, end_values: FloatArray) -> _Pieces:
    """See to it that a key of one value can stand wherever two pieces meet.

    Behind a step anything may follow. A step may go to the next key's value. Any other jump gets a step of one tick.
    """
    if not len(pieces.owner):
        return pieces
    ends = np.append(pieces.owner[1:] != pieces.owner[:-1], True)
    end_values = end_values[pieces.owner]
    stepped = pieces.kind == SegmentKind.STEP
    for turn in range(_MOST_TURNS):
        following = np.where(ends, end_values, np.append(pieces.stored[1:], 0.0))
        fits = stepped & (_single(following) == _single(pieces.first))
        unfit = (pieces.stored != pieces.first) & (~fits | (turn == _MOST_TURNS - 1))
        if not unfit.any():
            break
        pieces.stored[unfit] = pieces.first[unfit]
    follows = np.where(ends, end_values, np.append(pieces.first[1:], 0.0))
    largest = np.maximum(np.abs(follows), np.abs(pieces.last))
    apart = (np.abs(pieces.last - follows) > 1e-9 * largest) & (_single(pieces.last) != _single(follows))
    jumps = apart & ~stepped
    # A step whose value the next key has can begin with what led to it.
    said = jumps & ~ends & np.append(fits[1:], False)
    behind = np.flatnonzero(~ends & ~stepped) + 1
    pieces.stored[behind] = np.where(said[behind - 1], pieces.last[behind - 1], pieces.first[behind])
    rest = np.flatnonzero(jumps & ~said & (pieces.end - pieces.begin > 1))
    pieces, tiny = pieces.doubled(rest)
    pieces.end[tiny - 1] -= 1
    pieces.kept[tiny - 1] = False
    pieces.begin[tiny] = pieces.end[tiny] - 1
    pieces.first[tiny] = pieces.stored[tiny] = pieces.last[tiny]
    pieces.kind[tiny], pieces.base[tiny], pieces.kept[tiny] = SegmentKind.STEP, CONSTANT, False
    pieces.right[tiny] = pieces.left[tiny] = 0.0
    pieces.right_weight[tiny] = pieces.left_weight[tiny] = 1 / 3
    return pieces


def _single(values: FloatArray) -> NDArray[np.float32]:
    # What goes beyond single precision overshot what any reader takes, and is refused when it is written.
    with np.errstate(over="ignore"):
        return values.astype(np.float32)


def _keys(
    pieces: _Pieces, old: OldCurves, cut: CurveBatch, counts: IntArray, ticks_a_second: int
) -> tuple[Keys, BoolArray]:
    """Return the keys with flags and attributes of their own, and whether the old ones may stand, shape (n_keys,)."""
    n = len(pieces.owner)
    key = np.arange(n) + pieces.owner
    end = np.cumsum(counts) + np.arange(len(counts))
    total = n + len(counts)
    ticks, values = np.empty(total, dtype=np.int64), np.empty(total)
    flags, data = np.empty(total, dtype=np.int64), np.zeros((total, 4), dtype=np.uint32)
    kept = np.zeros(total, dtype=bool)
    ticks[key], values[key] = pieces.begin, pieces.stored
    full = np.flatnonzero(counts)
    last = np.cumsum(counts)[full] - 1
    ticks[end] = np.rint(cut.end_times * ticks_a_second)
    ticks[end[full]] = pieces.end[last]
    values[end] = cut.end_values[:, 0]

    cubic = pieces.kind == SegmentKind.CUBIC
    stepped = pieces.kind == SegmentKind.STEP
    arrives = np.zeros(total, dtype=bool)
    arrives[key + 1] = cubic
    arriving = np.zeros(total)
    arriving[key + 1] = pieces.left
    smooth = np.abs(arriving[key] - pieces.right) <= 1e-6 * np.maximum(np.abs(arriving[key]), np.abs(pieces.right))
    rest = pieces.base & ~(TANGENTS | _WEIGHTED | VELOCITIES | CONSTANT | LINEAR | CUBIC)
    weighted = np.where(np.abs(pieces.right_weight - 1 / 3) > 1e-9, WEIGHTED_RIGHT, 0)
    weighted |= np.where(np.abs(pieces.left_weight - 1 / 3) > 1e-9, WEIGHTED_NEXT_LEFT, 0)
    broken = np.where(arrives[key] & ~smooth, BROKEN, pieces.base & BROKEN)
    curved = rest | CUBIC | USER | broken | weighted
    # Straight pieces and steps keep what tangents they would have, as programs do.
    plain = pieces.base & ~(_WEIGHTED | VELOCITIES)
    straight = np.where(pieces.base & (CONSTANT | CUBIC), rest | LINEAR, plain)
    next_flag = np.where(pieces.stored != pieces.first, NEXT, 0)
    level = np.where(pieces.base & CONSTANT, plain & ~NEXT, rest | CONSTANT) | next_flag
    flags[key] = np.where(cubic, curved, np.where(stepped, level, straight))
    data[:, 2] = THIRDS
    data[key, 0] = _single(pieces.right).view(np.uint32)
    data[key, 1] = _single(pieces.left).view(np.uint32)
    packed = [np.rint(one / WEIGHT_STEP).astype(np.int64) for one in (pieces.right_weight, pieces.left_weight)]
    data[key, 2] = (packed[0] | packed[1] << 16).astype(np.uint32)
    kept[key] = pieces.kept

    # A curve's end is as its last key was; where that is gone, or would bend what arrives, as what led to it.
    old_last = old.keys.starts[1:] - 1
    flags[end] = old.keys.flags[old_last]
    data[end] = old.keys.data[old_last]
    kept[end] = True
    flags[end[full]] = np.where(cubic[last], rest[last] | CUBIC | USER, flags[key[last]] & ~_WEIGHTED)
    data[end[full]] = np.array([0, 0, THIRDS, 0], dtype=np.uint32)
    kept[end[full]] = pieces.kept[last] & (pieces.old[last] + 1 == old_last[full])
    return Keys(counts + 1, ticks, values, flags, data), kept


def _wrong(pieces: _Pieces, key: IntArray, keys: Keys, following: BoolArray, ticks_a_second: int) -> BoolArray:
    """Tell which keys don't make the pieces that they must, shape (n_keys,).

    Slopes of `following` keys are their own, whatever the key before them says.
    """
    wrong = np.zeros(len(keys.ticks), dtype=bool)
    slopes = resolved(keys, ticks_a_second)
    width = (pieces.end - pieces.begin) / ticks_a_second
    cubic = pieces.kind == SegmentKind.CUBIC
    size = 1e-7 * np.maximum(np.abs(pieces.first), np.abs(pieces.last))
    ends = (
        (pieces.right, pieces.right_weight, slopes.right[key], slopes.right_weight[key]),
        (pieces.left, pieces.left_weight, slopes.left[key + 1], slopes.left_weight[key + 1]),
    )
    for place, (slope, weight, found_slope, found_weight) in enumerate(ends):
        wanted, found = slope * weight * width, found_slope * found_weight * width
        off = np.abs(found - wanted) > size + 1e-6 * np.abs(wanted)
        off |= np.abs(found_weight - weight) > WEIGHT_STEP / 100
        off &= cubic
        # How a piece arrives is said by the key that begins it, or by the next one, where its slopes follow.
        blamed = key[off] + (place & following[key[off] + 1])
        wrong[blamed] = True
    kind = np.where(keys.flags[key] & CONSTANT, SegmentKind.STEP, np.where(keys.flags[key] & CUBIC, 2, 1))
    wrong[key[kind != pieces.kind]] = True
    to_next = (keys.flags[key] & CONSTANT != 0) & (keys.flags[key] & NEXT != 0)
    shown = np.where(to_next, keys.values[key + 1], keys.values[key])
    wrong[key[(pieces.kind == SegmentKind.STEP) & (_single(shown) != _single(pieces.first))]] = True
    return wrong
