"""Keys of F-curves: what they draw against a literal reading of Blender's rules, and what retimed keys draw."""

from __future__ import annotations

import math

import numpy as np
import pytest

from blender.fcurve_keys import (
    BEZIER,
    CONSTANT,
    LINEAR,
    Cycles,
    Keys,
    continued,
    difference,
    end_slopes,
    negated_from,
    on_whole_frames,
    retimed,
    segments_of,
    stretched,
    unrolled,
    with_samples,
)
from blender.timing import Timing
from retime.warp.curve import Warp
from tests.reference.fcurve import cycled_frame, fcurve_value

WARP = Warp([0.0, 10.0, 20.0, 30.0, 55.0], [0.0, 7.0, 33.0, 33.0, 60.0])


def drawn_keys(rng, *, n=9, codes=(CONSTANT, LINEAR, BEZIER), straight_on=False, whole=False):
    times = np.sort(rng.choice(np.arange(2, 60), n, replace=False)).astype(float)
    if not whole:
        times += rng.uniform(0, 0.9, n)
    values = rng.uniform(-3, 3, n)
    reach = rng.uniform(0, 25, (2, n))
    left = np.stack([times - reach[0], values + rng.uniform(-3, 3, n)], axis=1)
    right = np.stack([times + reach[1], values + rng.uniform(-3, 3, n)], axis=1)
    return Keys(times, values, left, right, rng.choice(codes, n), straight_on, np.arange(n))


def literal(keys, frames):
    return np.array([fcurve_value(keys, frame) for frame in frames])


@pytest.mark.parametrize("seed", range(12))
def test_segments_draw_what_blender_draws(seed):
    rng = np.random.default_rng(seed)
    keys = drawn_keys(rng, n=int(rng.integers(1, 12)))
    frames = np.linspace(-5, 70, 500)
    np.testing.assert_allclose(segments_of(keys)[0](frames)[:, 0], literal(keys, frames), atol=1e-9)


@pytest.mark.parametrize("seed", range(12))
def test_retimed_keys_draw_the_curve_at_warped_frames(seed):
    rng = np.random.default_rng(seed)
    keys = drawn_keys(rng, n=int(rng.integers(1, 12)))
    curve, source = segments_of(keys)
    warp = Timing(WARP, 24.0).reaching(float(keys.times[0]), float(keys.times[-1]))
    new = retimed(curve, source, warp, last_code=int(keys.interpolation[-1]), straight_on=False)
    assert (np.diff(new.times.astype(np.float32)) > 0).all()
    frames = np.linspace(-5, 60, 777)
    # Away from cuts and steps by more than single precision can move them.
    away = np.abs(frames[:, None] - new.times).min(axis=1) > 2e-3
    np.testing.assert_allclose(literal(new, frames)[away], literal(keys, warp(frames))[away], atol=1e-6)
    # Every key that a person made is one still, where the warp shows it.
    for key, time in zip(new.source, new.times, strict=True):
        if key >= 0:
            assert warp(time) == pytest.approx(keys.times[key], abs=2e-3)
    assert set(range(len(keys))) <= set(new.source.tolist())


def test_a_warp_that_runs_backward_over_steps_and_lines():
    keys = Keys.straight(np.array([0.0, 10.0, 20.0, 30.0]), np.array([0.0, 1.0, 5.0, 2.0]))
    keys.interpolation[1] = CONSTANT
    curve, source = segments_of(keys)
    warp = Warp([0.0, 40.0, 80.0], [0.0, 30.0, 0.0])
    new = retimed(curve, source, warp, last_code=LINEAR, straight_on=False)
    frames = np.arange(0, 80) + 0.37
    np.testing.assert_allclose(literal(new, frames), literal(keys, warp(frames)), atol=1e-3)


@pytest.mark.parametrize("straight", [False, True])
@pytest.mark.parametrize("seed", range(6))
def test_straight_ends_go_on_through_the_warp(seed, straight):
    rng = np.random.default_rng(seed)
    keys = drawn_keys(rng, n=4, codes=(LINEAR,) if straight else (BEZIER,), straight_on=True)
    curve, source = continued(*segments_of(keys), end_slopes(keys), -10.0, 90.0)
    warp = Timing(WARP, 24.0).reaching(-10.0, 90.0)
    new = retimed(curve, source, warp, last_code=LINEAR, straight_on=True)
    frames = np.linspace(-20, 100, 500)
    expected = literal(keys, warp(np.clip(frames, warp.output_start, warp.output_end)))
    inside = (frames > warp.output_start) & (frames < warp.output_end)
    np.testing.assert_allclose(literal(new, frames)[inside], expected[inside], atol=1e-6)


@pytest.mark.parametrize("mode", ["REPEAT", "REPEAT_OFFSET", "MIRROR"])
@pytest.mark.parametrize("counts", [(0, 0), (1, 2)])
@pytest.mark.parametrize("seed", range(4))
def test_cycles_are_written_out_as_blender_repeats(seed, counts, mode):
    rng = np.random.default_rng(seed)
    keys = drawn_keys(rng, n=5)
    curve, source = segments_of(keys)
    cycles = Cycles(mode, mode, *counts)
    whole, _ = unrolled(curve, source, cycles, -100.0, 200.0)
    frames = np.linspace(-99, 199, 900)
    expected = []
    for frame in frames:
        at, lift = cycled_frame(keys, frame, mode, counts)
        expected.append(fcurve_value(keys, at) + lift)
    width = keys.times[-1] - keys.times[0]
    beside = np.abs((frames - keys.times[0] + width / 2) % width - width / 2) > 1e-6
    np.testing.assert_allclose(whole(frames)[beside, 0], np.array(expected)[beside], atol=1e-9)


def test_a_jump_has_two_keys_that_single_precision_tells_apart():
    keys = Keys.straight(np.array([1.0, 11.0]), np.array([0.0, 5.0]))
    curve, source = unrolled(*segments_of(keys), Cycles("NONE", "REPEAT"), 1.0, 31.0)
    new = retimed(curve, source, Warp([0.0, 20000.0], [0.0, 40.0]), last_code=LINEAR, straight_on=False)
    assert (np.diff(new.times.astype(np.float32)) > 0).all()
    at = np.array([5500.0, 5499.9, 5501.0])
    np.testing.assert_allclose(literal(new, at), [5.0, 4.9999, 0.001], atol=1e-3)


def test_keys_on_whole_frames_keep_values_that_a_person_set():
    rng = np.random.default_rng(5)
    keys = drawn_keys(rng, n=8, codes=(BEZIER,), whole=True)
    curve, source = segments_of(keys)
    exact = retimed(curve, source, Timing(WARP, 24.0).reaching(2, 60), last_code=BEZIER, straight_on=False)
    snapped = on_whole_frames(exact)
    assert (snapped.times == np.rint(snapped.times)).all()
    assert (np.diff(snapped.times) > 0).all()
    for time, value, key in zip(snapped.times, snapped.values, snapped.source, strict=True):
        if key >= 0:
            assert value == keys.values[key]
        else:
            assert value == pytest.approx(fcurve_value(exact, time), abs=1e-6)
    frames = np.arange(math.floor(exact.times[0]), math.ceil(exact.times[-1]) + 1)
    off = np.abs(literal(snapped, frames) - literal(exact, frames)).max()
    assert difference(snapped, exact) == pytest.approx(off, abs=1e-6)


def test_samples_replace_what_lies_between_and_leave_what_does_not():
    rng = np.random.default_rng(6)
    keys = drawn_keys(rng, n=10, codes=(BEZIER,))
    curve, source = segments_of(keys)
    cut = retimed(curve, source, Warp([0.0, 20.0, 40.0, 61.0], [0.0, 20.0, 40.0, 61.0]), last_code=2, straight_on=False)
    frames = np.arange(20.0, 41.0)
    values = np.sin(frames)
    baked = with_samples(cut, frames, values)
    np.testing.assert_allclose(literal(baked, frames)[1:-1], values[1:-1], atol=1e-9)
    outside = np.array([*np.linspace(0, 19, 60), *np.linspace(41, 61, 60)])
    near = (outside > keys.times[keys.times < 20].max()) & (outside < keys.times[keys.times > 40].min())
    np.testing.assert_allclose(literal(baked, outside)[~near], literal(keys, outside)[~near], atol=1e-6)


def test_what_does_not_change_needs_no_key_on_every_frame():
    keys = Keys.straight(np.array([5.0]), np.array([2.0]))
    baked = with_samples(keys, np.arange(1.0, 101.0), np.full(100, 2.0))
    assert baked.times.tolist() == [1.0, 100.0]


def test_stretching_moves_handles_along():
    keys = drawn_keys(np.random.default_rng(7), n=6)
    moved = stretched(keys, 10.0, -3.0, 2.5)
    frames = np.linspace(5, 60, 200)
    np.testing.assert_allclose(literal(moved, -3 + 2.5 * (frames - 10)), literal(keys, frames), atol=1e-9)
    again = stretched(moved, -3.0, 10.0, 1 / 2.5)
    np.testing.assert_allclose(again.left, keys.left, atol=1e-12)


def test_an_eased_segment_needs_its_function_and_is_drawn_by_it():
    keys = Keys.straight(np.array([0.0, 20.0, 30.0]), np.array([0.0, 4.0, 1.0]))
    keys.interpolation[0] = 12
    with pytest.raises(ValueError, match="eased"):
        segments_of(keys)

    def ease(frames):
        return np.where(frames < 20, 4 - 4 * np.cos(frames / 20 * np.pi / 2), np.interp(frames, [20, 30], [4.0, 1.0]))

    curve, source = segments_of(keys, evaluate=ease)
    frames = np.linspace(0, 30, 301)
    np.testing.assert_allclose(curve(frames)[:, 0], ease(frames), atol=2e-4)
    assert source[0] == 0
    assert source[-2:].tolist() == [1, 2]


def test_a_switch_is_held_whatever_its_keys_say():
    keys = Keys.straight(np.array([0.0, 20.0]), np.array([0.0, 1.0]))
    curve, _ = segments_of(keys, discrete=True)
    assert curve(np.array([0.0, 19.9, 20.0])).ravel().tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize("seed", range(4))
def test_negated_keys_draw_the_same_below_zero_from_there(seed):
    rng = np.random.default_rng(seed)
    keys = drawn_keys(rng, whole=True)
    at = 4
    frames = np.linspace(-3, 70, 400)
    found = literal(negated_from(keys, keys.times[at]), frames)
    after, before = frames >= keys.times[at], frames < keys.times[at - 1]
    np.testing.assert_allclose(found[after], -literal(keys, frames)[after], atol=1e-12)
    np.testing.assert_allclose(found[before], literal(keys, frames)[before], atol=1e-12)
