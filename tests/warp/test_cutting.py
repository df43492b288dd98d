"""Curves cut by a warp: at each output time what the curve has at the warp's time, and keys that stay keys."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from retime.errors import OptionError
from retime.warp.curve import Warp
from retime.warp.cutting import CurveBatch, CurveSegments, SegmentKind, cut_curve, cut_curves
from tests.reference import segments as literal
from tests.warp.drawn import drawn_warp


def drawn_curve(rng: np.random.Generator, n_keys: int, kinds: list[SegmentKind]) -> CurveSegments:
    """Keys at uneven times, every kind of segment between them; handles anywhere within, weights and all."""
    slerp = SegmentKind.SLERP in kinds
    times = np.cumsum(10.0 ** rng.uniform(-3, 0.5, n_keys)) + rng.uniform(-3, 3)
    values = rng.normal(size=(n_keys, 4 if slerp else rng.integers(1, 4)))
    if slerp:
        values /= np.linalg.norm(values, axis=1)[:, None]
    curve = CurveSegments.through(times, values, SegmentKind.CUBIC)
    chosen = rng.choice(kinds, n_keys - 1)
    for segment, kind in enumerate(chosen):
        if kind == SegmentKind.CUBIC:
            inside = np.sort(rng.random(2)) if rng.random() < 0.7 else rng.random(2)
            curve.times[segment, 1:3] = times[segment] + inside * (times[segment + 1] - times[segment])
            curve.values[segment, 1:3] += rng.normal(size=(2, values.shape[1]))
        elif kind == SegmentKind.STEP:
            curve.values[segment] = values[segment]
    return CurveSegments(curve.times, curve.values, chosen.astype(np.int64), curve.end_time, curve.end_value)


def as_lists(curve: CurveSegments):
    return curve.times.tolist(), curve.values.tolist(), curve.kinds.tolist(), curve.end_value.tolist()


KINDS = list(SegmentKind)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 8), st.sampled_from([KINDS, *([kind] for kind in KINDS)]))
def test_a_curve_evaluates_to_its_definition(seed: int, n_keys: int, kinds: list[SegmentKind]) -> None:
    rng = np.random.default_rng(seed)
    curve = drawn_curve(rng, n_keys, kinds)
    times = np.concatenate([curve.times.ravel(), rng.uniform(curve.times[0, 0] - 1, curve.end_time + 1, 20)])
    wanted = [literal.value_at(*as_lists(curve), time) for time in times.tolist()]
    np.testing.assert_allclose(curve(times), wanted, rtol=0, atol=2e-7)  # Slopes in time may be without bound.


@settings(max_examples=150, deadline=None)
@example(26311, 7, 4, False, [SegmentKind.SLERP])
@example(2**32 - 1, 8, 8, True, [SegmentKind.CUBIC])
@given(
    st.integers(0, 2**32 - 1),
    st.integers(2, 8),
    st.integers(2, 10),
    st.booleans(),
    st.sampled_from([KINDS, *([kind] for kind in KINDS)]),
)
def test_a_cut_curve_shows_the_curve_at_the_warps_time(
    seed: int, n_keys: int, n_knots: int, forward: bool, kinds: list[SegmentKind]
) -> None:
    rng = np.random.default_rng(seed)
    curve = drawn_curve(rng, n_keys, kinds)
    warp = drawn_warp(rng, n_knots, forward=forward)
    out, source = cut_curve(curve, warp)
    assert (np.diff(out.times[:, [0, 3]].ravel()) >= 0).all()
    assert len(source) == len(out)
    times = rng.uniform(warp.output_start - 0.5, warp.output_end + 0.5, 60)
    # At a step, and where a handle lies on its own key, a rounding of time shows another value.
    near = np.abs(warp(times)[:, None] - curve.times[:, [0, 3]].ravel()).min(axis=1)
    times = times[(near > 1e-6) & (np.abs(times[:, None] - warp.output_times).min(axis=1) > 1e-6)]
    wanted = [literal.value_at(*as_lists(curve), time) for time in warp(times).tolist()]
    found, wanted = out(times), np.reshape(wanted, (len(times), -1))
    # Played backward a turn begins at its second key, whose sign may be the other one of the two that mean one turn.
    segment = np.searchsorted(curve.times[:, 0], warp(times), side="right") - 1
    turns = (segment >= 0) & (curve.kinds[np.maximum(segment, 0)] == SegmentKind.SLERP)
    other = turns & ((found * wanted).sum(axis=1) < 0)
    np.testing.assert_allclose(np.where(other[:, None], -found, found), wanted, rtol=0, atol=1e-6)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_keys_stay_keys_and_only_knots_add_to_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve = drawn_curve(rng, 6, [SegmentKind.CUBIC])
    # Handles that don't cross: nowhere does the curve stand upright.
    curve.times[:, 1:3].sort(axis=1)
    warp = Warp([0.0, 2.0, 3.0], [curve.times[0, 0] - 0.5, curve.times[2, [0, 3]].mean(), curve.end_time + 1])
    out, source = cut_curve(curve, warp)
    back = warp.inverse()
    keys = np.append(curve.times[:, 0], curve.end_time)
    np.testing.assert_allclose(
        np.append(out.times[:, 0], out.end_time), np.sort(np.append(back(keys), 2.0)), atol=1e-12
    )
    assert len(out) == len(curve) + 1
    assert source.tolist() == [0, 1, 2, 2, 3, 4]
    assert len(out.jumps) == 0


def test_one_speed_scales_the_handles_and_leaves_the_values_to_the_bit() -> None:
    curve = drawn_curve(np.random.default_rng(5), 6, [SegmentKind.CUBIC])
    low, high = curve.times[0, 0], curve.end_time
    out, _ = cut_curve(curve, Warp([0.0, 3 * (high - low)], [low, high]))
    np.testing.assert_array_equal(out.values, curve.values)
    np.testing.assert_allclose(out.times, 3 * (curve.times - low), atol=1e-12)
    mirrored, source = cut_curve(curve, Warp([0.0, high - low], [high, low]))
    np.testing.assert_array_equal(mirrored.values, curve.values[::-1, ::-1])
    assert source.tolist() == [4, 3, 2, 1, 0]


def test_a_curve_that_stands_upright_is_cut_once_more_so_that_no_handle_leaves_its_keys() -> None:
    curve = CurveSegments.through(np.array([0.0, 1.0]), np.array([[0.0], [1.0]]), SegmentKind.CUBIC)
    # Both handles reach across the whole segment: in its middle the curve is upright.
    curve.times[0, 1:3] = [1.0, 0.0]
    for inputs in ([0.0, 0.55, 1.0], [1.0, 0.55, 0.0], [0.1, 0.6, 0.9]):
        warp = Warp([0.0, 1.0, 3.0], inputs)
        out, source = cut_curve(curve, warp)
        assert (out.times[:, 1:3] >= out.times[:, [0]]).all()
        assert (out.times[:, 1:3] <= out.times[:, [3]]).all()
        assert set(source) <= {0, 1}
        times = np.linspace(0.001, 2.999, 400)
        times = times[np.abs(warp(times) - 0.5) > 1e-3]
        np.testing.assert_allclose(out(times), curve(warp(times)), atol=1e-7)
        # What was cut can be cut again.
        again, _ = cut_curve(out, Warp([0.0, 1.0, 2.0], [0.0, 0.7, 3.0]))
        at = np.array([0.3, 0.9, 1.5])
        np.testing.assert_allclose(again(at), out(np.array([0.21, 0.63, 1.85])), atol=1e-7)


def test_a_hold_is_two_keys_of_one_value() -> None:
    curve = CurveSegments.through(np.array([0.0, 1.0]), np.array([[0.0], [10.0]]), SegmentKind.LINEAR)
    out, _ = cut_curve(curve, Warp([0.0, 0.5, 2.0, 2.5], [0.0, 0.5, 0.5, 1.0]))
    assert out.times[:, 0].tolist() == [0.0, 0.5, 2.0]
    np.testing.assert_allclose(out.values[:, [0, 3], 0], [[0, 5], [5, 5], [5, 10]])


def test_backward_a_step_jumps_where_it_began() -> None:
    curve = CurveSegments.through(np.array([0.0, 1.0, 2.0]), np.array([[0.0], [4.0], [6.0]]), SegmentKind.LINEAR)
    stepped = CurveSegments(
        curve.times,
        np.stack([np.zeros((4, 1)), curve.values[1]]),
        np.array([SegmentKind.STEP, SegmentKind.LINEAR]),
        2.0,
        curve.end_value,
    )
    assert len(stepped.jumps) == 0
    out, _ = cut_curve(stepped, Warp([0.0, 2.0], [2.0, 0.0]))
    # 6 down to 4, and then 0, which no key of one value can say.
    assert out.jumps.tolist() == [0]
    np.testing.assert_allclose(out(np.array([0.5, 0.999, 1.0, 1.5])), [[5.0], [4.002], [0.0], [0.0]])


def test_what_lies_outside_the_warp_leaves_one_key() -> None:
    curve = CurveSegments.through(np.array([5.0, 6.0]), np.array([[1.0], [2.0]]), SegmentKind.LINEAR)
    for inputs, value in (([0.0, 4.0], 1.0), ([7.0, 8.0], 2.0), ([7.0, 7.5], 2.0)):
        out, source = cut_curve(curve, Warp([1.0, 3.0], inputs))
        assert (len(out), out.end_time, out.end_value.tolist(), len(source)) == (0, 1.0, [value], 0)
    alone = CurveSegments(np.zeros((0, 4)), np.zeros((0, 4, 1)), np.zeros(0, dtype=np.int64), 0.5, np.array([7.0]))
    out, _ = cut_curve(alone, Warp([1.0, 3.0], [0.0, 1.0]))
    assert (len(out), out.end_time, out.end_value.tolist()) == (0, 1.0, [7.0])


def test_a_handle_outside_its_segment_is_refused() -> None:
    curve = CurveSegments.through(np.array([0.0, 1.0, 2.0]), np.zeros((3, 1)), SegmentKind.CUBIC)
    curve.times[1, 2] = 2.5
    with pytest.raises(OptionError, match="curve segment 1 are out of order"):
        cut_curve(curve, Warp([0.0, 1.0], [0.0, 1.0]))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 6), st.booleans())
def test_many_curves_are_cut_as_each_alone(seed: int, n_curves: int, forward: bool) -> None:
    rng = np.random.default_rng(seed)
    kinds = [SegmentKind.STEP, SegmentKind.LINEAR, SegmentKind.CUBIC]
    curves = []
    for _ in range(n_curves):
        curve = drawn_curve(rng, int(rng.integers(1, 7)), kinds)
        # Of one channel each, as a batch has one width.
        curves.append(
            CurveSegments(curve.times, curve.values[:, :, :1], curve.kinds, curve.end_time, curve.end_value[:1])
        )
    batch = CurveBatch(
        np.concatenate([np.zeros((0, 4)), *(one.times for one in curves)]),
        np.concatenate([np.zeros((0, 4, 1)), *(one.values for one in curves)]),
        np.concatenate([np.zeros(0, dtype=np.int64), *(one.kinds for one in curves)]),
        np.array([len(one) for one in curves], dtype=np.int64),
        np.array([one.end_time for one in curves]),
        np.array([one.end_value for one in curves]).reshape(-1, 1),
    )
    warp = drawn_warp(rng, int(rng.integers(2, 8)), forward=forward)
    cut, source = cut_curves(batch, warp)
    assert len(cut) == n_curves
    for index, curve in enumerate(curves):
        alone, its_source = cut_curve(curve, warp)
        found = cut.curve(index)
        np.testing.assert_array_equal(found.kinds, alone.kinds)
        for name in ("times", "values", "end_time", "end_value"):
            # To the last bits: vectors of other lengths are added in another order.
            np.testing.assert_allclose(getattr(found, name), getattr(alone, name), rtol=1e-12, atol=1e-14)
        np.testing.assert_array_equal(source[cut.starts[index] : cut.starts[index + 1]], its_source)
        shown = float(warp(warp.output_end))
        assert found(np.array([warp.output_end]))[0, 0] == pytest.approx(curve(np.array([shown]))[0, 0], abs=1e-9)
