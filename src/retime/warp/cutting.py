"""Animation curves cut by a warp, their keys kept: no curve is sampled.

Between two knots a warp is affine, and an affine map of time takes a straight line to a straight line and a cubic
Bézier curve to one. So a curve is cut where the warp has a knot (de Casteljau's construction, exact), and each piece is
laid where the warp shows it. What was a key stays one, at a new time.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr
from retime.errors import OptionError
from retime.motion.rotation import slerp
from retime.warp.curve import Warp, WarpLike, as_warp

# Seconds of output. A shorter piece is a cut beside a key that is there already, and is left out.
_SHORTEST = 1e-10


class SegmentKind(IntEnum):
    """How a curve runs from one key to the next."""

    STEP = 0
    """It stays at the first key's value."""
    LINEAR = 1
    """Straight."""
    CUBIC = 2
    """A cubic Bézier curve, in time as in value."""
    SLERP = 3
    """Quaternions (four values) turned evenly, the short way."""


@dataclass(frozen=True, eq=False)
class CurveSegments:
    """An animation curve: what lies between its keys, end to end.

    Parameters
    ----------
    times : float array, shape (n, 4)
        Seconds: each segment's first key, its two handles, its second key. Within a segment they must not leave it (a
        handle longer than its segment has no one value at a time). Where nothing else is asked, handles lie at a third.
        A segment begins where the one before ends.
    values : float array, shape (n, 4, k)
        The same for the values. Between `values[i, 3]` and `values[i + 1, 0]` the curve may jump.
    kinds : int array, shape (n,)
        `SegmentKind` of each. Handles count for CUBIC alone.
    end_time : float
        Seconds: of the last key. With no segment it is the only one.
    end_value : float array, shape (k,)
        From the last key on.
    """

    times: FloatArray
    values: FloatArray
    kinds: IntArray
    end_time: float
    end_value: FloatArray

    __repr__ = brief_repr

    @classmethod
    def through(cls, times: FloatArray, values: FloatArray, kind: SegmentKind) -> CurveSegments:
        """Make the curve of one kind through keys: `times` of shape (n_keys,), `values` of shape (n_keys, k).

        CUBIC makes straight lines whose handles may then be moved.
        """
        third = np.arange(4) / 3
        spread = times[:-1, None] + third * np.diff(times)[:, None]
        spread[:, 3] = times[1:]
        between = values[:-1, None] + third[:, None] * np.diff(values, axis=0)[:, None]
        between[:, 3] = values[1:]
        if kind is SegmentKind.STEP:
            between[:] = values[:-1, None]
        kinds = np.full(len(times) - 1, kind, dtype=np.int64)
        return cls(spread, between, kinds, float(times[-1]), values[-1])

    def __len__(self) -> int:
        return len(self.times)

    @property
    def jumps(self) -> IntArray:
        """The segments after which the value jumps where a key of one value can't say so, shape (n_jumps,).

        After a STEP segment the next key's value says it. What is no more than rounding is no jump.
        """
        nexts = np.concatenate([self.values[1:, 0], self.end_value[None]])
        apart = np.abs(self.values[:, 3] - nexts) > 1e-9 * np.abs(self.values).max(initial=0.0)
        return np.flatnonzero(apart.any(axis=1) & (self.kinds != SegmentKind.STEP))

    def __call__(self, times: FloatArray) -> FloatArray:
        """Evaluate the curve: at a key what begins there, before the first key and after the last what these hold.

        Parameters
        ----------
        times : float array, shape (m,)
            Seconds.

        Returns
        -------
        float array, shape (m, k)
        """
        times = np.asarray(times, dtype=np.float64)
        out = np.broadcast_to(self.end_value, (len(times), len(self.end_value))).copy()
        if not len(self):
            return out
        before = times < self.times[0, 0]
        out[before] = self.values[0, 0]
        inside = ~before & (times < self.end_time)
        segment = np.searchsorted(self.times[:, 0], times[inside], side="right") - 1
        share = _shares(self, segment, times[inside])
        out[inside] = _points(self.values[segment], share, self.kinds[segment])
        return out


@dataclass(frozen=True, eq=False)
class CurveBatch:
    """Curves one after the other: what many short ones are cut as, for NumPy's sake.

    Attributes
    ----------
    times, values, kinds : arrays
        The segments of all curves, as `CurveSegments` has those of one.
    counts : int array, shape (n_curves,)
        How many segments each has.
    end_times : float array, shape (n_curves,)
    end_values : float array, shape (n_curves, k)
    """

    times: FloatArray
    values: FloatArray
    kinds: IntArray
    counts: IntArray
    end_times: FloatArray
    end_values: FloatArray

    __repr__ = brief_repr

    def __len__(self) -> int:
        return len(self.counts)

    @property
    def starts(self) -> IntArray:
        """Where each curve's segments begin, and at the end their number, shape (n_curves + 1,)."""
        return np.concatenate([[0], np.cumsum(self.counts)]).astype(np.int64)

    def curve(self, index: int) -> CurveSegments:
        """Return one of the curves."""
        stop = int(self.counts[: index + 1].sum())
        part = slice(stop - int(self.counts[index]), stop)
        return CurveSegments(
            self.times[part], self.values[part], self.kinds[part], float(self.end_times[index]), self.end_values[index]
        )


def cut_curve(curve: CurveSegments, warp: WarpLike) -> tuple[CurveSegments, IntArray]:
    """Retime an animation curve: cut it at the knots of a warp and lay the pieces where the warp shows them.

    Exact up to rounding: at each output time t the result has the value of ``curve`` at ``warp(t)``, for holds,
    backward spans and any speed. Pieces shorter than a ten-billionth of a second are left out.

    Parameters
    ----------
    curve : CurveSegments
        In input time. Beyond its ends it holds.
    warp : Warp or GuidedWarp
        The timing; `Warp.simplify` first, for fewer cuts.

    Returns
    -------
    segments : CurveSegments
        In output time, within the warp's domain; beyond its ends it holds, as the warp does.
    source : int array, shape (n,)
        The segment of `curve` that each came from; -1 where `curve` holds before its first key, its number of segments
        where it holds after its last.

    Raises
    ------
    OptionError
        The curve's times are out of order.
    """
    alone = CurveBatch(
        curve.times,
        curve.values,
        curve.kinds,
        np.array([len(curve)]),
        np.array([curve.end_time]),
        np.asarray(curve.end_value)[None],
    )
    batch, source = cut_curves(alone, as_warp(warp, "cut_curve(curve, warp)"))
    return batch.curve(0), source


def cut_curves(curves: CurveBatch, warp: WarpLike) -> tuple[CurveBatch, IntArray]:
    """Retime many curves at once, each as `cut_curve` would.

    Parameters
    ----------
    curves : CurveBatch
        In input time.
    warp : Warp or GuidedWarp
        The timing of all of them.

    Returns
    -------
    batch : CurveBatch
        In output time.
    source : int array, shape (n,)
        For each new segment, the old one among its own curve's, as `cut_curve` counts them.

    Raises
    ------
    OptionError
        A curve's times are out of order.
    """
    warp = as_warp(warp, "cut_curves(curves, warp)")
    n_curves = len(curves)
    owners = np.repeat(np.arange(n_curves), curves.counts)
    _check(curves, owners)
    whole, first_whole = _with_holds(curves, owners, float(warp.input_times.min()), float(warp.input_times.max()))
    piece, segment, owner, ends_shown = _overlaps(whole, first_whole, warp)
    start_values, end_values = _values_shown(curves, whole, ends_shown, warp)

    times, values, segment = _laid(whole, warp, piece, segment)
    long = times[:, 3] - times[:, 0] > _SHORTEST
    times, values, segment = times[long], values[long], segment[long]
    owner = np.searchsorted(first_whole, segment, side="right") - 1
    source = segment - first_whole[owner] - 1
    # What only holds before the first key or after the last needs no key of its own.
    real = np.flatnonzero((source >= 0) & (source < curves.counts[owner]))
    row = np.searchsorted(owner, np.arange(n_curves + 1))
    shown = np.bincount(owner[real], minlength=n_curves) > 0
    first = np.zeros(n_curves, dtype=np.int64)
    last = np.full(n_curves, -1)
    kept = np.flatnonzero(shown)
    first[kept] = real[np.searchsorted(owner[real], kept, side="left")]
    last[kept] = real[np.searchsorted(owner[real], kept, side="right") - 1]
    followed = np.flatnonzero(shown & (last + 1 < row[1:]))
    end_values[followed] = whole.values[segment[last[followed] + 1], 0]
    end_values[~shown] = start_values[~shown]
    # Played backward, a curve that ends in a step jumps where its last key was: that hold must be kept.
    preceded = np.flatnonzero(shown & (first > row[:-1]))
    jumping = preceded[(values[first[preceded] - 1, 3] != values[first[preceded], 0]).any(axis=1)]
    first[jumping] = row[:-1][jumping]
    places = np.arange(len(owner))
    used = np.flatnonzero((first[owner] <= places) & (places <= last[owner]))
    end_times = np.full(n_curves, warp.output_start)
    end_times[shown] = times[last[shown], 3]
    times, values, owner = times[used], values[used], owner[used]
    # Where a short piece was left out, its neighbours meet.
    meet = np.flatnonzero(owner[1:] == owner[:-1])
    times[meet + 1, 0] = times[meet, 3]
    counts = np.bincount(owner, minlength=n_curves)
    kinds = whole.kinds[segment[used]]
    return CurveBatch(times, values, kinds, counts, end_times, end_values), source[used]


def _check(curves: CurveBatch, owners: IntArray) -> None:
    times = curves.times
    wrong = (times[:, [0]] > times).any(axis=1) | (times[:, [3]] < times).any(axis=1)
    wrong |= times[:, 0] >= times[:, 3]
    wrong[1:] |= (times[1:, 0] != times[:-1, 3]) & (owners[1:] == owners[:-1])
    if wrong.any() or not np.isfinite(times).all():
        segment = int(np.flatnonzero(wrong)[0]) if wrong.any() else 0
        raise OptionError(f"the times of curve segment {segment} are out of order: {times[segment].tolist()}")


def _with_holds(curves: CurveBatch, owners: IntArray, low: float, high: float) -> tuple[CurveSegments, IntArray]:
    """Add what curves hold before their first keys and after their last, as two segments that reach `low` and `high`.

    Returns all segments, and where those of each curve begin (one more than curves). A curve of one key has none.
    """
    full = np.flatnonzero(curves.counts)
    sizes = np.where(curves.counts > 0, curves.counts + 2, 0)
    first = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
    starts = curves.starts
    times = np.empty((first[-1], 4))
    values = np.empty((first[-1], 4, curves.end_values.shape[1]))
    kinds = np.full(first[-1], SegmentKind.STEP, dtype=np.int64)
    inner = np.arange(len(owners)) - starts[owners] + first[owners] + 1
    times[inner], values[inner], kinds[inner] = curves.times, curves.values, curves.kinds
    begin, end = curves.times[starts[full], 0], curves.end_times[full]
    before, after = first[full], first[full + 1] - 1
    times[before] = np.linspace(np.minimum(low, begin) - 1.0, begin, 4, axis=1)
    times[after] = np.linspace(end, np.maximum(high, end) + 1.0, 4, axis=1)
    values[before] = curves.values[starts[full], :1]
    values[after] = curves.end_values[full][:, None]
    return CurveSegments(times, values, kinds, np.inf, curves.end_values[:1]), first


def _overlaps(whole: CurveSegments, first_whole: IntArray, warp: Warp) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    """Pair each piece of the warp with the segments that it passes, in the order in which it passes them.

    Returns the piece, the segment and the curve of each pair; and the segments that the warp shows at its start and at
    its end, shape (n_curves, 2), for curves that have any.
    """
    n_curves = len(first_whole) - 1
    begin, stop = warp.input_times[:-1], warp.input_times[1:]
    low, high = np.minimum(begin, stop), np.maximum(begin, stop)
    ends = warp.input_times[[0, -1]]
    first = np.zeros((n_curves, len(low)), dtype=np.int64)
    last = np.full((n_curves, len(low)), -1)
    ends_shown = np.zeros((n_curves, 2), dtype=np.int64)
    all_starts = whole.times[:, 0]
    for curve in np.flatnonzero(np.diff(first_whole)).tolist():
        place = first_whole[curve]
        starts = all_starts[place : first_whole[curve + 1]]
        first[curve] = starts.searchsorted(low, side="right") + (place - 1)
        last[curve] = starts.searchsorted(high, side="left") + (place - 1)
        ends_shown[curve] = starts.searchsorted(ends, side="right") + (place - 1)
    shown = last[:, 0] >= 0
    last = np.where(shown[:, None], np.maximum(first, last), last)
    counts = np.where(shown[:, None], last - first + 1, 0).ravel()
    pair = np.repeat(np.arange(len(counts)), counts)
    step = np.arange(len(pair)) - np.repeat(np.cumsum(counts) - counts, counts)
    owner, piece = np.divmod(pair, len(low))
    backward = (stop < begin)[piece]
    segment = np.where(backward, last.ravel()[pair] - step, first.ravel()[pair] + step)
    return piece, segment, owner, ends_shown


def _values_shown(
    curves: CurveBatch, whole: CurveSegments, ends_shown: IntArray, warp: Warp
) -> tuple[FloatArray, FloatArray]:
    """Evaluate all curves at the warp's first input time and at its last, shape (n_curves, k) each."""
    found = []
    full = np.flatnonzero(curves.counts)
    for end, time in enumerate(warp.input_times[[0, -1]]):
        values = curves.end_values.copy()
        segment = ends_shown[full, end]
        share = _shares(whole, segment, np.full(len(full), time))
        values[full] = _points(whole.values[segment], share, whole.kinds[segment])
        found.append(values)
    return found[0], found[1]


def _laid(
    whole: CurveSegments, warp: Warp, piece: IntArray, segment: IntArray
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Cut out what each piece of the warp shows of each segment, and lay it in output time.

    Returns the times, the values, and the segment of each: there may be one more where a curve is all but upright.
    """
    from_time = np.clip(warp.input_times[piece], whole.times[segment, 0], whole.times[segment, 3])
    to_time = np.clip(warp.input_times[piece + 1], whole.times[segment, 0], whole.times[segment, 3])
    a, b = _shares(whole, segment, from_time), _shares(whole, segment, to_time)
    steep, middle, middle_time = _upright(whole, segment, a, b)
    if steep.any():
        first = np.cumsum(1 + steep)[steep] - 2
        parts = np.repeat(np.arange(len(piece)), 1 + steep)
        piece, segment = piece[parts], segment[parts]
        from_time, to_time, a, b = from_time[parts], to_time[parts], a[parts], b[parts]
        b[first], to_time[first] = middle[steep], middle_time[steep]
        a[first + 1], from_time[first + 1] = middle[steep], middle_time[steep]
    begin, stop = warp.input_times[piece], warp.input_times[piece + 1]
    start, end = warp.output_times[piece], warp.output_times[piece + 1]
    kinds = whole.kinds[segment]
    values, inner = whole.values[segment], whole.times[segment]
    # Most segments are shown whole.
    part = np.flatnonzero((a != 0) | (b != 1))
    values[part] = _between(values[part], a[part], b[part])
    inner[part] = _between(inner[part][:, :, None], a[part], b[part])[:, :, 0]
    turned = np.flatnonzero(kinds == SegmentKind.SLERP)
    for place, share in ((0, a), (3, b)):
        values[turned, place] = _points(whole.values[segment[turned]], share[turned], kinds[turned])
    stepped = kinds == SegmentKind.STEP
    values[stepped] = whole.values[segment[stepped], :1]
    # A hold stays at one place; any cut of the line from its start to its end will do for the handles.
    still = begin == stop
    inner = np.where(still[:, None], begin[:, None], inner)
    width = np.where(still, 1.0, stop - begin)
    times = start[:, None] + (inner - begin[:, None]) * ((end - start) / width)[:, None]
    times[:, 0] = np.where(from_time == begin, start, times[:, 0])
    times[:, 3] = np.where(to_time == stop, end, times[:, 3])
    third = np.linspace(0, 1, 4)
    times[still] = start[still, None] + third * (end - start)[still, None]
    times[still, 3] = end[still]
    # But for a rounding they are within.
    times[:, 1:3] = np.clip(times[:, 1:3], times[:, [0]], times[:, [3]])
    return times, values, segment


def _upright(
    whole: CurveSegments, segment: IntArray, a: FloatArray, b: FloatArray
) -> tuple[BoolArray, FloatArray, FloatArray]:
    """Find the parts whose handles would leave them, and where to cut these once more so that none does.

    Where a curve stands all but upright within a part, its handle there can lie beyond the part's end, and no key may
    have such a handle. The speed of time along a segment is a parabola that is never negative: between an end and the
    parabola's lowest point it is at least a third of the end's on average, which is what a handle needs.

    Returns
    -------
    steep : bool array, shape (n_parts,)
    middle, middle_time : float arrays, shape (n_parts,)
        Parameter and time of the lowest point, where `steep`.
    """
    steep = np.zeros(len(segment), dtype=bool)
    middle, middle_time = np.zeros(len(segment)), np.zeros(len(segment))
    part = np.flatnonzero((whole.kinds[segment] == SegmentKind.CUBIC) & ((a != 0) | (b != 1)) & (a != b))
    if not len(part):
        return steep, middle, middle_time
    points = whole.times[segment[part]]
    inner = _between(points[:, :, None], a[part], b[part])[:, :, 0]
    low, high = np.sort(inner[:, [0, 3]], axis=1).T
    slack = 1e-12 * (high - low)
    out = ((inner[:, 1:3] < (low - slack)[:, None]) | (inner[:, 1:3] > (high + slack)[:, None])).any(axis=1)
    p1, p2, p3 = (points[:, i] - points[:, 0] for i in (1, 2, 3))
    c2, c3 = 3 * p2 - 6 * p1, p3 - 3 * p2 + 3 * p1
    lowest = -c2 / np.where(out, 3 * c3, 1.0)
    out &= (np.minimum(a[part], b[part]) < lowest) & (lowest < np.maximum(a[part], b[part]))
    steep[part], middle[part] = out, lowest
    middle_time[part] = points[:, 0] + ((c3 * lowest + c2) * lowest + 3 * p1) * lowest
    return steep, middle, middle_time


def _between(points: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    """Take the part from parameter a to parameter b of cubic Bézier curves; b may be the smaller one.

    By polar forms: the part's control points are the curve's blossom at (a, a, a), (a, a, b), (a, b, b), (b, b, b).
    """
    a, b = a[:, None, None], b[:, None, None]

    def towards(rows: FloatArray, share: FloatArray) -> FloatArray:
        return rows[:, :-1] * (1 - share) + rows[:, 1:] * share

    at_a, at_b = towards(points, a), towards(points, b)
    aa, bb = towards(at_a, a), towards(at_b, b)
    parts = [towards(aa, a), towards(aa, b), towards(bb, a), towards(bb, b)]
    out = np.concatenate(parts, axis=1)
    # A segment played backward as a whole keeps its bits.
    return np.where((a == 1) & (b == 0), points[:, ::-1], out)


def _shares(curve: CurveSegments, segment: IntArray, times: FloatArray) -> FloatArray:
    """Find the parameter of each segment's curve at a time within it: 0 at its first key, 1 at its second."""
    points = curve.times[segment]
    start, end = points[:, 0], points[:, 3]
    share = (times - start) / (end - start)
    bent = np.flatnonzero((curve.kinds[segment] == SegmentKind.CUBIC) & (share > 0) & (share < 1))
    if len(bent):
        share[bent] = _solved(points[bent], times[bent], share[bent])
    return np.clip(share, 0.0, 1.0)


def _solved(points: FloatArray, times: FloatArray, guess: FloatArray) -> FloatArray:
    """Solve cubic Bézier curves, which increase in time, for their parameter: Newton's steps within a bracket."""
    start = points[:, 0]
    # As a polynomial of the parameter, from the segment's own start: no digits are lost to a late time.
    p1, p2, p3 = (points[:, i] - start for i in (1, 2, 3))
    c1, c2, c3 = 3 * p1, 3 * p2 - 6 * p1, p3 - 3 * p2 + 3 * p1
    wanted = times - start
    low, high = np.zeros(len(times)), np.ones(len(times))
    share = guess
    for _ in range(100):
        off = ((c3 * share + c2) * share + c1) * share - wanted
        low, high = np.where(off <= 0, share, low), np.where(off >= 0, share, high)
        slope = (3 * c3 * share + 2 * c2) * share + c1
        newton = share - off / np.where(slope > 0, slope, np.inf)
        better = np.where((newton > low) & (newton < high) & (slope > 0), newton, (low + high) / 2)
        better = np.where(off == 0, share, better)
        if np.abs(better - share).max() <= 4e-16:
            return better
        share = better
    return share


def _points(points: FloatArray, share: FloatArray, kinds: IntArray) -> FloatArray:
    """Evaluate segments at their parameters."""
    u = share[:, None]
    v = 1 - u
    cubic = v**3 * points[:, 0] + 3 * v * v * u * points[:, 1] + 3 * v * u * u * points[:, 2] + u**3 * points[:, 3]
    out = np.where((kinds == SegmentKind.STEP)[:, None], points[:, 0], cubic)
    straight = (kinds == SegmentKind.LINEAR)[:, None]
    out = np.where(straight, points[:, 0] * v + points[:, 3] * u, out)
    turned = np.flatnonzero(kinds == SegmentKind.SLERP)
    if len(turned):
        first, second, at = points[turned, 0], points[turned, 3], share[turned]
        # Either of two signs means one turn; a key keeps its own.
        out[turned] = np.where((at == 1)[:, None], second, slerp(first, second, at))
    return out
