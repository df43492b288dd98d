"""The keys of one F-curve as arrays: what they draw, and the keys that draw it with new timing.

Blender's own rules of how a curve runs between its keys and beyond them are written out here, so that what a warp cuts
is what Blender plays. All times are frames, and may be fractions of one. bpy is not needed.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr
from retime.warp.curve import Warp
from retime.warp.cutting import CurveSegments, SegmentKind, cut_curve
from retime.warp.knots import add_times

# How Blender numbers the ways from one key to the next; what is above BEZIER eases in or out (sine, bounce, ...).
CONSTANT, LINEAR, BEZIER = 0, 1, 2
KINDS = {CONSTANT: SegmentKind.STEP, LINEAR: SegmentKind.LINEAR, BEZIER: SegmentKind.CUBIC}

# Where a curve jumps, a second key says so, so many frames after the first: Blender takes a key for what is within a
# ten-thousandth of a frame of it, and single precision tells frames up to a quarter of a million so far apart.
_JUMP = 2.0**-10
# An eased segment is drawn in pieces until each is as near as this to it, in shares of its height, or lasts no more
# than so many frames. Single precision, in which Blender evaluates it, tells no more.
_EASED, _NARROWEST = 2e-5, 1 / 16

Evaluate = Callable[[FloatArray], FloatArray]
"""Values of an F-curve at frames, as Blender itself has them."""


@dataclass(frozen=True, eq=False)
class Keys:
    """The keys of an F-curve.

    Attributes
    ----------
    times, values : float arrays, shape (n,)
        Frames, increasing; and what the curve has there.
    left, right : float arrays, shape (n, 2)
        Handles: frame and value.
    interpolation : int array, shape (n,)
        How the curve goes on from each key, as Blender numbers it.
    straight_on : bool
        Beyond its ends the curve goes straight on (Blender's LINEAR extrapolation) instead of holding.
    source : int array, shape (n,)
        For keys that were made by `retimed`: the key that each was, -1 where the curve was cut. Otherwise 0, 1, 2, ...
    """

    times: FloatArray
    values: FloatArray
    left: FloatArray
    right: FloatArray
    interpolation: IntArray
    straight_on: bool
    source: IntArray

    __repr__ = brief_repr

    def __len__(self) -> int:
        return len(self.times)

    @classmethod
    def straight(cls, times: FloatArray, values: FloatArray, *, straight_on: bool = False) -> Keys:
        """Make keys with straight lines between them; both arrays of shape (n,)."""
        points = np.stack([times, values], axis=1).astype(np.float64)
        third = np.diff(points, axis=0, append=points[-1:] + np.array([[3.0, 0.0]])) / 3
        before = np.concatenate([[[1.0, 0.0]], third[:-1]]) if len(points) else third
        kinds = np.full(len(points), LINEAR, dtype=np.int64)
        return cls(
            points[:, 0], points[:, 1], points - before, points + third, kinds, straight_on, np.arange(len(points))
        )


@dataclass(frozen=True)
class Cycles:
    """A Cycles modifier: the keys come again before the first and after the last.

    Attributes
    ----------
    before, after : str
        ``NONE``, ``REPEAT``, ``REPEAT_OFFSET`` or ``MIRROR``.
    n_before, n_after : int
        How often; 0 is for ever.
    """

    before: str
    after: str
    n_before: int = 0
    n_after: int = 0


def segments_of(
    keys: Keys, *, evaluate: Evaluate | None = None, discrete: bool = False
) -> tuple[CurveSegments, IntArray]:
    """Say what keys draw between the first and the last, as segments that can be cut.

    Parameters
    ----------
    keys : Keys
        At least one.
    evaluate : function, optional
        Needed where a segment eases (sine, bounce, ...): such a segment becomes as many cubic pieces as it takes.
    discrete : bool
        The property has no values between (a switch, a choice): whatever the keys say, Blender holds each.

    Returns
    -------
    segments : CurveSegments
        In frames, with values of shape (n, 4, 1).
    source : int array, shape (n + 1,)
        The key at which each segment begins, -1 inside an eased one; last comes the last key.
    """
    n = max(0, len(keys) - 1)
    times = np.stack([keys.times[:n], keys.right[:n, 0], keys.left[1:, 0], keys.times[1:]], axis=1)
    values = np.stack([keys.values[:n], keys.right[:n, 1], keys.left[1:, 1], keys.values[1:]], axis=1)
    code = np.zeros(n, dtype=np.int64) if discrete else keys.interpolation[:n]
    kinds = np.where(code == LINEAR, SegmentKind.LINEAR, SegmentKind.CUBIC)
    kinds = np.where(code == CONSTANT, SegmentKind.STEP, kinds)
    _shorten_handles(times, values)
    apart = np.flatnonzero(code < BEZIER)
    times[apart] = keys.times[apart, None] + np.arange(4) / 3 * np.diff(times[apart][:, [0, 3]])
    times[apart, 3] = keys.times[apart + 1]
    values[apart[code[apart] == CONSTANT]] = keys.values[apart[code[apart] == CONSTANT], None]
    for segment in apart[code[apart] == LINEAR]:
        values[segment] = np.linspace(values[segment, 0], values[segment, 3], 4)
    source = np.arange(n + 1)
    curve = CurveSegments(times, values[:, :, None], kinds, float(keys.times[-1]), keys.values[-1:])
    # Keys at one frame: the later one counts, and nothing lies between.
    wide = times[:, 3] > times[:, 0]
    eased = np.flatnonzero((code > BEZIER) & wide)
    if len(eased) and evaluate is None:
        raise ValueError("an eased segment needs the function that evaluates it")
    pieces = {int(segment): _eased(times[segment, 0], times[segment, 3], evaluate) for segment in eased if evaluate}
    if pieces or not wide.all():
        curve, source = _replaced(curve, source, wide, pieces)
    return curve, source


def _shorten_handles(times: FloatArray, values: FloatArray) -> None:
    """Shorten handles that are longer than their segment, as Blender does before it draws: in place."""
    width = times[:, 3] - times[:, 0]
    for handle, key in ((1, 0), (2, 3)):
        reach = np.abs(times[:, handle] - times[:, key])
        long = reach > width
        share = np.where(long, width / np.where(long, reach, 1.0), 1.0)
        for rows in (times, values):
            rows[:, handle] = rows[:, key] + share * (rows[:, handle] - rows[:, key])
    # A handle that points away from its segment makes time run back there, which Blender draws as if it stood upright.
    times[:, 1:3] = np.clip(times[:, 1:3], times[:, [0]], times[:, [3]])


def _eased(start: float, end: float, evaluate: Evaluate) -> tuple[FloatArray, FloatArray]:
    """Draw an eased segment in cubic pieces, each through four of its points; times and values, shape (n, 4).

    Pieces are halved where they are off: a bounce has corners.
    """
    height = max(float(np.ptp(evaluate(np.linspace(start, end, 33)))), 1e-9)
    share = np.array([1 / 6, 1 / 2, 5 / 6])
    weights = np.stack([(1 - share) ** 3, 3 * share * (1 - share) ** 2, 3 * share**2 * (1 - share), share**3])
    edges = np.linspace(start, end, 5)
    while True:
        width = np.diff(edges)
        times = edges[:-1, None] + np.arange(4) / 3 * width[:, None]
        times[:, 3] = edges[1:]
        p0, a, b, p3 = evaluate(times.ravel()).reshape(-1, 4).T
        inner = (-5 * p0 + 18 * a - 9 * b + 2 * p3) / 6, (2 * p0 - 9 * a + 18 * b - 5 * p3) / 6
        values = np.stack([p0, *inner, p3], axis=1)
        shown = evaluate((edges[:-1, None] + share * width[:, None]).ravel()).reshape(-1, 3)
        off = np.abs(values @ weights - shown).max(axis=1)
        wrong = (off > _EASED * height) & (width > _NARROWEST)
        if not wrong.any():
            return times, values
        edges = np.sort(np.concatenate([edges, (edges[:-1] + width / 2)[wrong]]))


def _replaced(
    curve: CurveSegments, source: IntArray, wide: BoolArray, pieces: dict[int, tuple[FloatArray, FloatArray]]
) -> tuple[CurveSegments, IntArray]:
    times, values, kinds, sources = [], [], [], []
    for segment in np.flatnonzero(wide).tolist():
        own = pieces.get(segment, (curve.times[[segment]], curve.values[[segment], :, 0]))
        times.append(own[0])
        values.append(own[1])
        kinds.append(np.full(len(own[0]), SegmentKind.CUBIC if segment in pieces else curve.kinds[segment]))
        sources.append(np.concatenate([[source[segment]], np.full(len(own[0]) - 1, -1)]))
    if not times:
        return replace(curve, times=curve.times[:0], values=curve.values[:0], kinds=curve.kinds[:0]), source[-1:]
    joined = CurveSegments(
        np.concatenate(times),
        np.concatenate(values)[:, :, None],
        np.concatenate(kinds),
        curve.end_time,
        curve.end_value,
    )
    return joined, np.concatenate([*sources, source[-1:]])


def stretched_curve(curve: CurveSegments, start: float, to: float, scale: float) -> CurveSegments:
    """Move what keys draw as `stretched` moves keys."""
    return replace(curve, times=to + scale * (curve.times - start), end_time=to + scale * (curve.end_time - start))


def end_slopes(keys: Keys) -> tuple[float, float]:
    """Return how steeply the curve goes on before its first key and after its last, in values a frame; 0: it holds.

    Blender goes on along the handle of a Bézier key, and along the last line of a straight one.
    """
    if not keys.straight_on:
        return 0.0, 0.0
    slopes = []
    for end, neighbour, handle in ((0, 1, keys.left), (-1, -2, keys.right)):
        code = int(keys.interpolation[end])
        if code == CONSTANT or (code == LINEAR and len(keys) < 2):
            slopes.append(0.0)
            continue
        other = (keys.times[neighbour], keys.values[neighbour]) if code == LINEAR else (handle[end, 0], handle[end, 1])
        width = float(keys.times[end] - other[0])
        slopes.append(float(keys.values[end] - other[1]) / width if width else 0.0)
    return slopes[0], slopes[1]


def continued(
    curve: CurveSegments, source: IntArray, slopes: tuple[float, float], first: float, last: float
) -> tuple[CurveSegments, IntArray]:
    """Add the straight lines on which a curve goes on, as far as `first` and `last` (frames) and a little more."""
    start, begin = (
        (float(curve.times[0, 0]), float(curve.values[0, 0, 0]))
        if len(curve)
        else (
            curve.end_time,
            float(curve.end_value[0]),
        )
    )
    low, high = min(first, start) - 1.0, max(last, curve.end_time) + 1.0
    end = float(curve.end_value[0])
    lines = [
        CurveSegments.through(
            np.array([low, start]), np.array([[begin - slopes[0] * (start - low)], [begin]]), SegmentKind.LINEAR
        ),
        CurveSegments.through(
            np.array([curve.end_time, high]),
            np.array([[end], [end + slopes[1] * (high - curve.end_time)]]),
            SegmentKind.LINEAR,
        ),
    ]
    joined = CurveSegments(
        np.concatenate([lines[0].times, curve.times, lines[1].times]),
        np.concatenate([lines[0].values, curve.values, lines[1].values]),
        np.concatenate([lines[0].kinds, curve.kinds, lines[1].kinds]),
        high,
        lines[1].end_value,
    )
    return joined, np.concatenate([[-1], source, [-1]])


def unrolled(
    curve: CurveSegments, source: IntArray, cycles: Cycles, first: float, last: float
) -> tuple[CurveSegments, IntArray]:
    """Write out what a Cycles modifier repeats, as far as `first` and `last` (frames).

    Returns
    -------
    segments, source
        As `segments_of` has them; repeated keys keep the number of the key that they repeat.
    """
    if not len(curve):
        return curve, source
    start, end = float(curve.times[0, 0]), curve.end_time
    width = end - start
    height = float(curve.end_value[0] - curve.values[0, 0, 0])
    before = _copies(start - first, width, cycles.before, cycles.n_before)
    after = _copies(last - end, width, cycles.after, cycles.n_after)
    parts = []
    for copy in range(-before, after + 1):
        mode = cycles.before if copy < 0 else cycles.after
        times, values, kinds, own = curve.times, curve.values, curve.kinds, source[:-1]
        if mode == "MIRROR" and copy % 2:
            mirrored = _mirrored(curve)
            times, values, kinds, own = mirrored.times, mirrored.values, mirrored.kinds, source[:0:-1]
        lift = height * copy if mode == "REPEAT_OFFSET" else 0.0
        parts.append((times + width * copy, values + lift, kinds, own))
    for one, other in itertools.pairwise(parts):
        # Where copies meet they meet exactly.
        other[0][0, 0] = one[0][-1, 3]
    end_value = parts[-1][1][-1, 3]
    if parts[-1][2][-1] == SegmentKind.STEP and not (cycles.after == "MIRROR" and after % 2):
        end_value = curve.end_value + (height * after if cycles.after == "REPEAT_OFFSET" else 0.0)
    end_time = float(parts[-1][0][-1, 3])
    if after and after == cycles.n_after and end_time < last:
        # Counted repetitions are over: Blender shows the curve's own last value again, and before them its first.
        end_value = curve.end_value
    begin = float(parts[0][0][0, 0])
    if before and before == cycles.n_before and first < begin:
        held = np.linspace(first - 1.0, begin, 4)[None]
        parts.insert(0, (held, np.full((1, 4, 1), curve.values[0, 0, 0]), np.array([SegmentKind.STEP]), np.array([-1])))
    joined = CurveSegments(
        np.concatenate([part[0] for part in parts]),
        np.concatenate([part[1] for part in parts]),
        np.concatenate([part[2] for part in parts]),
        end_time,
        end_value,
    )
    return joined, np.concatenate([*(part[3] for part in parts), source[-1:]])


def _copies(beyond: float, width: float, mode: str, most: int) -> int:
    if mode == "NONE" or beyond <= 0:
        return 0
    needed = int(np.ceil(beyond / width))
    return min(needed, most) if most else needed


def _mirrored(curve: CurveSegments) -> CurveSegments:
    """Play a curve backward between its own ends."""
    start, end = float(curve.times[0, 0]), curve.end_time
    values = curve.values[::-1, ::-1].copy()
    # A step holds the value of the key before it, whichever way it is passed.
    kinds = curve.kinds[::-1].copy()
    return CurveSegments((start + end - curve.times[::-1, ::-1]), values, kinds, end, curve.values[0, 0])


def retimed(curve: CurveSegments, source: IntArray, warp: Warp, *, last_code: int, straight_on: bool) -> Keys:
    """Give a curve a warp's timing: keys that draw it exactly.

    Parameters
    ----------
    curve, source
        As `segments_of` has them.
    warp : Warp
        From output frame to input frame; it reaches beyond the curve's keys where these shall not be lost.
    last_code : int
        How the last key goes on.
    straight_on : bool
        Beyond its ends the curve goes straight on.

    Returns
    -------
    Keys
        Times in order, and apart in single precision, in which Blender keeps them.
    """
    cut, piece = cut_curve(curve, warp)
    if len(cut.jumps):
        # What leaves begins a moment later, at a key of its own: the curve is cut there too.
        later = cut.times[cut.jumps, 3] + _JUMP
        later = later[later < warp.output_end]
        times = add_times(warp.output_times, later)
        cut, piece = cut_curve(curve, Warp(times, warp(times)))
    if not len(cut):
        keys = Keys.straight(np.array([cut.end_time]), cut.end_value, straight_on=straight_on)
        return replace(keys, interpolation=np.array([last_code]), source=source[-1:])
    ends = np.concatenate([curve.times[:, 0], [curve.end_time]])
    inside = np.clip(piece, 0, len(curve) - 1)
    # Only a cut that falls on a segment's own beginning (its end, played backward) is that key.
    begun = warp(cut.times[:, 0])
    own = np.where(np.abs(ends[inside] - begun) < 1e-6, source[inside], -1)
    own = np.where(np.abs(ends[inside + 1] - begun) < 1e-6, source[inside + 1], own)
    arrives = float(warp(cut.end_time))
    near = int(np.argmin(np.abs(ends - arrives)))
    end_own = int(source[near]) if abs(ends[near] - arrives) < 1e-6 else -1
    codes = np.array([CONSTANT, LINEAR, BEZIER])[cut.kinds]
    return _apart(_keys_of(cut, codes, np.append(own, end_own), last_code, straight_on))


def _keys_of(cut: CurveSegments, codes: IntArray, source: IntArray, last_code: int, straight_on: bool) -> Keys:
    n = len(cut)
    times = np.append(cut.times[:, 0], cut.end_time)
    values = np.append(cut.values[:, 0, 0], cut.end_value[0])
    right = np.stack([cut.times[:, 1], cut.values[:, 1, 0]], axis=1)
    left = np.stack([cut.times[:, 2], cut.values[:, 2, 0]], axis=1)
    # Nothing lies beyond the ends: their outer handles mirror the inner ones, as a hand would draw them.
    left = np.concatenate([[[2 * times[0] - right[0, 0], 2 * values[0] - right[0, 1]]], left])
    right = np.concatenate([right, [[2 * times[n] - left[n, 0], 2 * values[n] - left[n, 1]]]])
    keys = Keys(times, values, left, right, np.append(codes, last_code), straight_on, source)
    jumps = cut.jumps
    if not len(jumps):
        return keys
    # At the frame of a jump the curve still has what arrives, until the next key, a moment later.
    for jump in jumps.tolist():
        keys.values[jump + 1] = cut.values[jump, 3, 0]
        keys.interpolation[jump + 1] = CONSTANT
        if jump + 1 == n:
            end = Keys.straight(times[n:] + _JUMP, cut.end_value)
            keys = _joined(
                [replace(keys, source=source), replace(end, interpolation=np.array([last_code]), source=np.array([-1]))]
            )
    return keys


def _apart(keys: Keys) -> Keys:
    """Make one key of those that single precision can't tell apart: what arrives at the first, leaves from the last."""
    single = keys.times.astype(np.float32)
    last = np.append(single[1:] > single[:-1], True)
    if last.all():
        return keys
    first = np.append(True, last[:-1])
    # The key that a person made is the one to keep its marks.
    group = np.cumsum(first) - 1
    source = np.full(int(group[-1]) + 1, -1, dtype=np.int64)
    np.maximum.at(source, group, keys.source)
    return Keys(
        keys.times[last],
        keys.values[last],
        keys.left[first],
        keys.right[last],
        keys.interpolation[last],
        keys.straight_on,
        source,
    )


def stretched(keys: Keys, start: float, to: float, scale: float) -> Keys:
    """Move keys so that frame `start` comes to `to`, and time passes `scale` times as slowly around it; above 0."""

    def frames(rows: FloatArray) -> FloatArray:
        return np.asarray(to + scale * (rows - start))

    left, right = keys.left.copy(), keys.right.copy()
    left[:, 0], right[:, 0] = frames(left[:, 0]), frames(right[:, 0])
    return replace(keys, times=frames(keys.times), left=left, right=right)


def negated_from(keys: Keys, frame: float) -> Keys:
    """Turn the signs of the values of all keys from a frame on, with their handles."""
    from_there = keys.times >= frame - 1e-6
    values, left, right = keys.values.copy(), keys.left.copy(), keys.right.copy()
    values[from_there] *= -1
    left[from_there, 1] *= -1
    right[from_there, 1] *= -1
    return replace(keys, values=values, left=left, right=right)


def on_whole_frames(keys: Keys) -> Keys:
    """Move keys to whole frames: keys that a person made keep their values, cuts take the curve's value there.

    Between the moved keys the curve keeps its slopes at the keys. It is no longer exact: `difference` says by how much.
    """
    frames = np.rint(keys.times)
    made = keys.source >= 0
    order = np.lexsort((np.arange(len(keys)), made, frames))
    last = np.append(frames[order][1:] > frames[order][:-1], True)
    chosen = np.sort(order[last])
    curve = segments_of(keys)[0]
    at = frames[chosen]
    values = np.where(made[chosen], keys.values[chosen], curve(at)[:, 0])
    step = keys.interpolation[chosen] == CONSTANT
    values = np.where(step & ~made[chosen], keys.values[chosen], values)
    slopes = [_slope(keys, handle, chosen) for handle in (keys.left, keys.right)]
    width = np.diff(at, append=at[-1] + 1.0) / 3
    before = np.concatenate([[1 / 3], width[:-1]])
    left = np.stack([at - before, values - before * slopes[0]], axis=1)
    right = np.stack([at + width, values + width * slopes[1]], axis=1)
    return Keys(at, values, left, right, keys.interpolation[chosen], keys.straight_on, keys.source[chosen])


def _slope(keys: Keys, handle: FloatArray, chosen: IntArray) -> FloatArray:
    """Slope at keys toward one handle, values a frame; 0 where it stands upright."""
    width = handle[chosen, 0] - keys.times[chosen]
    upright = np.abs(width) < 1e-9
    return np.where(upright, 0.0, (handle[chosen, 1] - keys.values[chosen]) / np.where(upright, 1.0, width))


def difference(keys: Keys, exact: Keys) -> float:
    """Return the largest difference of two curves at whole frames, from the first key of both to the last."""
    first = np.floor(min(keys.times[0], exact.times[0]))
    frames = np.arange(first, np.ceil(max(keys.times[-1], exact.times[-1])) + 1)
    return float(np.abs(segments_of(keys)[0](frames) - segments_of(exact)[0](frames)).max())


def with_samples(keys: Keys, frames: FloatArray, values: FloatArray) -> Keys:
    """Put a key on each frame in place of what keys draw between the first and the last of these frames.

    Parameters
    ----------
    keys : Keys
        As `retimed` makes them.
    frames, values : float arrays, shape (n,)
        Increasing frames, and what the curve has there; straight lines join them.
    """
    low, high = float(frames[0]), float(frames[-1])
    samples = Keys.straight(frames, values)
    # Where nothing changes there needs to be no key on every frame.
    steps = np.abs(np.diff(values)) > 1e-9 * max(1.0, float(np.abs(values).max()))
    needed = np.concatenate([[True], steps[1:] | steps[:-1], [True]]) if len(values) > 1 else np.ones(1, dtype=bool)
    before, after = keys.times < low - 1e-6, keys.times > high + 1e-6
    # At both ends the curve was cut, so there are keys to arrive by and to leave from.
    for end, frame, whole in ((0, low, before), (-1, high, after)):
        at = int(np.argmin(np.abs(keys.times - frame)))
        if whole.any() and abs(keys.times[at] - frame) < 1e-6:
            side, own = (samples.left, keys.left) if end == 0 else (samples.right, keys.right)
            side[end] = own[at]
            if end:
                samples.interpolation[end] = keys.interpolation[at]
    joined = _joined([_some(keys, before), _some(samples, needed), _some(keys, after)])
    return replace(joined, straight_on=keys.straight_on, source=np.full(len(joined), -1))


def _joined(parts: Sequence[Keys]) -> Keys:
    return Keys(
        np.concatenate([part.times for part in parts]),
        np.concatenate([part.values for part in parts]),
        np.concatenate([part.left for part in parts]),
        np.concatenate([part.right for part in parts]),
        np.concatenate([part.interpolation for part in parts]),
        parts[0].straight_on,
        np.concatenate([part.source for part in parts]),
    )


def _some(keys: Keys, chosen: BoolArray) -> Keys:
    return Keys(
        keys.times[chosen],
        keys.values[chosen],
        keys.left[chosen],
        keys.right[chosen],
        keys.interpolation[chosen].copy(),
        keys.straight_on,
        keys.source[chosen],
    )
