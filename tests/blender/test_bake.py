"""A key on every frame: turns in and out of what Blender holds, and averaging."""

from __future__ import annotations

import numpy as np
import pytest

from blender.bake import Channels, agreeing, baked, numbers_of, quaternions_of
from blender.timing import Timing
from retime.motion import rotation
from retime.warp.curve import Warp
from retime.warp.cutting import CurveSegments, SegmentKind

MODES = ("QUATERNION", "AXIS_ANGLE", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
FAST = Timing(Warp([1.0, 31.0], [1.0, 121.0]), 24.0)
SAME = Timing(Warp([1.0, 121.0], [1.0, 121.0]), 24.0)


def turning(rng, n):
    """Turn slowly about an axis that wanders."""
    steps = rotation.from_rotation_vectors(rng.normal(scale=0.05, size=(n, 3)))
    rows = [rotation.normalize(rng.normal(size=4))]
    for step in steps[1:]:
        rows.append(rotation.multiply(rows[-1], step))
    return np.array(rows)


def curve(values):
    return CurveSegments.through(np.arange(1.0, len(values) + 1), np.asarray(values)[:, None], SegmentKind.LINEAR)


@pytest.mark.parametrize("mode", MODES)
def test_turns_go_in_and_out(mode):
    rng = np.random.default_rng(3)
    q = turning(rng, 200)
    first = numbers_of(mode, q[:1], np.zeros((1, 4 if mode in MODES[:2] else 3)) + 0.1)
    rows = [first[0]]
    for one in q[1:]:
        rows.append(numbers_of(mode, one[None], rows[-1][None])[0])
    rows = np.array(rows)
    back = quaternions_of(mode, rows)
    np.testing.assert_allclose(np.abs((back * q).sum(axis=1)), 1.0, atol=1e-9)
    # Near its neighbour, so that curves have no leaps (an Euler triple may turn over near its lock).
    if mode in MODES[:2]:
        assert np.abs(np.diff(rows, axis=0)).max() < 0.6


def test_blenders_orders_turn_about_the_first_letter_first():
    x, y, z = 0.3, -0.8, 1.1
    about = [rotation.about_axis(axis, angle) for axis, angle in enumerate((x, y, z))]
    expected = rotation.multiply(about[1], rotation.multiply(about[2], about[0]))
    np.testing.assert_allclose(quaternions_of("XZY", np.array([x, y, z])), expected, atol=1e-12)


def test_nothing_is_a_turn_of_none():
    assert quaternions_of("QUATERNION", np.zeros(4)).tolist() == [1, 0, 0, 0]
    assert quaternions_of("AXIS_ANGLE", np.array([0.0, 0, 0, 0])).tolist() == [1, 0, 0, 0]


def test_signs_agree_with_their_neighbours():
    q = turning(np.random.default_rng(4), 50)
    signs = np.where(np.arange(50) % 3 == 0, -1.0, 1.0)
    np.testing.assert_allclose(agreeing(q * signs[:, None]), q * signs[0], atol=1e-12)


def chains(rng, mode):
    """Make an object and a bone in it with a rest turn, and the curves of both."""
    rest = np.eye(4)
    rest[:3, :3] = rotation.to_matrix(rotation.normalize(rng.normal(size=4)))
    rest[:3, 3] = rng.normal(size=3)
    turn = np.array([1.0, 0, 0, 0]) if mode in MODES[:2] else np.zeros(3)
    both = [
        Channels("", "rig", -1, np.eye(4), "XYZ", np.zeros(3), np.zeros(3)),
        Channels('pose.bones["b"].', "b", 0, rest, mode, np.zeros(3), turn),
    ]
    numbers = [numbers_of(mode, turning(rng, 1), turn[None])[0]]
    for step in rotation.from_rotation_vectors(rng.normal(scale=0.04, size=(120, 3))):
        after = rotation.multiply(quaternions_of(mode, numbers[-1]), step)
        numbers.append(numbers_of(mode, after[None], numbers[-1][None])[0])
    rows = np.array(numbers)
    curves = {(both[1].turn_path, i): curve(rows[:, i]) for i in range(rows.shape[1])}
    curves |= {(both[1].prefix + "location", i): curve(np.cumsum(rng.normal(scale=0.1, size=121))) for i in range(3)}
    curves[both[1].prefix + "scale", 0] = curve(1 + 0.1 * (np.arange(121) % 2))
    return both, curves


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("average", [False, True])
def test_where_nothing_is_sped_up_all_stays_as_it_was(mode, average):
    both, curves = chains(np.random.default_rng(5), mode)
    out = baked(curves, both, SAME, average=average)
    for name, one in curves.items():
        if mode == "QUATERNION" and "quaternion" in name[0]:
            continue
        np.testing.assert_allclose(out[name], one(np.arange(1.0, 122.0))[:, 0], atol=1e-9)


@pytest.mark.parametrize("mode", MODES)
def test_what_is_sped_up_is_averaged_and_ends_are_kept(mode):
    rng = np.random.default_rng(6)
    both, curves = chains(rng, mode)
    plain, calm = (baked(curves, both, FAST, average=average) for average in (False, True))
    for name in curves:
        assert len(calm[name]) == 31
        np.testing.assert_allclose(calm[name][[0, -1]], plain[name][[0, -1]], atol=1e-6)
    # A flicker from frame to frame is gone; what is far from the flicker's size stays.
    shaking = calm[both[1].prefix + "scale", 0]
    assert np.ptp(shaking[3:-3]) < 0.02
    turns = quaternions_of(mode, np.stack([calm[both[1].turn_path, i] for i in range(both[1].n_turns)], axis=1))
    were = quaternions_of(mode, np.stack([plain[both[1].turn_path, i] for i in range(both[1].n_turns)], axis=1))
    assert np.abs((turns * were).sum(axis=1)).min() > 0.97
    assert np.abs((turns * were).sum(axis=1)).min() < 1 - 1e-7


def test_switches_are_never_averaged():
    name = "hide_render", 0
    out = baked({name: curve(np.arange(121) % 2)}, [], FAST, average=True, discrete=frozenset([name]))
    assert set(out[name].tolist()) <= {0.0, 1.0}


def test_a_turn_of_which_a_part_is_animated_stays_numbers():
    rng = np.random.default_rng(7)
    both, curves = chains(rng, "XYZ")
    part = {name: one for name, one in curves.items() if name != (both[1].turn_path, 2)}
    out = baked(part, both, FAST, average=True)
    assert out.keys() == part.keys()


@pytest.mark.parametrize("speed", [1.5, 4.0, 7.3])
def test_nothing_is_averaged_across_a_jump(speed):
    """A curve that is held and switched keeps its own values; beside a jump another one does too, and only there."""
    rng = np.random.default_rng(7)
    n = 120
    held = np.repeat(rng.normal(size=n // 8), 8)
    steps = CurveSegments.through(np.arange(1.0, n + 1), held[:, None], SegmentKind.STEP)
    shaking = np.arange(n) % 2 + 0.1 * np.arange(n)
    mixed = CurveSegments.through(np.arange(1.0, n + 1), shaking[:, None], SegmentKind.LINEAR)
    mixed.values[59, 3] += 5.0
    last = 1 + (n - 1) / speed
    timing = Timing(Warp([1.0, last], [1.0, float(n)]), 24.0)
    found = baked({("held", 0): steps, ("mixed", 0): mixed}, [], timing, average=True)
    frames = timing.frames()
    np.testing.assert_allclose(found["held", 0], steps(timing.warp(frames))[:, 0], atol=1e-12)
    plain = mixed(timing.warp(frames))[:, 0]
    near = np.abs(timing.warp(frames) - 61.0) < (speed - 1) / 2 + 1
    np.testing.assert_array_equal(found["mixed", 0][near], plain[near])
    assert near.any()
    if speed > 3:
        inner = ~near & (frames > 3) & (frames < frames[-1] - 2)
        assert np.ptp(found["mixed", 0][inner] - 0.1 * timing.warp(frames)[inner]) < 0.8
