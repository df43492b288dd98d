from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from retime.errors import OptionError
from retime.motion.signal import Signal
from retime.search.guided import guided_warp
from retime.search.poses.references import Reference, model_poses
from retime.search.poses.spaces import PoseOptions
from retime.search.poses.vectors import pose_vectors

UNSCALED = PoseOptions(scale_signals=False)
QUATERNION = ("qw", "qx", "qy", "qz")


@given(st.floats(-720, 720), st.floats(-720, 720))
def test_angles_are_as_far_apart_as_the_short_way(a: float, b: float) -> None:
    one, other = pose_vectors(Signal(("yaw",), [[a], [b]], kinds=["angle:deg"]), UNSCALED)
    way = np.radians(abs((a - b + 180) % 360 - 180))
    assert np.linalg.norm(one - other) == pytest.approx(np.degrees(2 * np.sin(way / 2)), abs=1e-7)


@given(st.integers(0, 10_000), st.floats(0, np.pi))
def test_rotations_are_as_far_apart_as_they_turn(seed: int, way: float) -> None:
    rng = np.random.default_rng(seed)
    start, side = rng.normal(size=(2, 4))
    start /= np.linalg.norm(start)
    side -= side @ start * start
    side /= np.linalg.norm(side)
    end = np.cos(way / 2) * start + np.sin(way / 2) * side
    signal = Signal(QUATERNION, [start, end * rng.choice([-1, 1])], kinds=["quaternion"] * 4)
    one, other = pose_vectors(signal, UNSCALED)
    assert np.linalg.norm(one - other) == pytest.approx(2 * np.sin(way / 2), abs=1e-9)


def test_degrees_and_radians_are_one_angle() -> None:
    degrees = np.random.default_rng(1).uniform(-180, 180, (50, 1))
    found = [
        pose_vectors(Signal(("yaw",), values, kinds=[kind]))
        for values, kind in ((degrees, "angle:deg"), (np.radians(degrees), "angle:rad"))
    ]
    np.testing.assert_allclose(*found, atol=1e-12)
    scaled = [
        pose_vectors(Signal(("yaw",), values, kinds=[kind]), PoseOptions(scales={"yaw": scale}))
        for values, kind, scale in ((degrees, "angle:deg", 10.0), (np.radians(degrees), "angle:rad", np.radians(10.0)))
    ]
    np.testing.assert_allclose(*scaled, atol=1e-12)


@pytest.mark.parametrize("kind", ["angle:deg", "angle:rad"])
def test_an_angle_weighs_as_much_as_a_length(kind: str) -> None:
    small = np.random.default_rng(2).normal(0, 0.01, 400)
    angle = small if kind == "angle:rad" else np.degrees(small)
    found = pose_vectors(Signal(("x", "a"), np.column_stack([small, angle]), kinds=["linear", kind]))
    x, a = found[:, 0], found[:, 2]
    np.testing.assert_allclose(x - x.mean(), a - a.mean(), atol=1e-3)


def test_what_stands_for_something_does_not_weigh() -> None:
    rng = np.random.default_rng(4)
    values = np.column_stack([rng.normal(size=40), rng.integers(0, 2, 40), rng.uniform(0, 1, 40), np.arange(40)])
    signal = Signal(("x", "left_contact", "likelihood", "timestamp"), values)
    assert [str(kind) for kind in signal.kinds] == ["linear", "label", "linear:likelihood", "time:s"]
    assert np.array_equal(pose_vectors(signal), pose_vectors(Signal(("x",), values[:, :1])))
    for options in (PoseOptions(joints=["left_contact"]), PoseOptions(weights={"left_contact": 2})):
        with pytest.raises(OptionError, match="'left_contact' is label, which the search doesn't look at"):
            pose_vectors(signal, options)
    with pytest.raises(OptionError, match="nothing of the signal weighs in a search: its channels are id label"):
        pose_vectors(Signal(("id",), values[:, 1:2], kinds=["label"]))


def test_a_rotation_is_chosen_and_weighted_as_a_whole() -> None:
    q = np.random.default_rng(5).normal(size=(9, 4))
    signal = Signal((*QUATERNION, "x"), np.column_stack([q / np.linalg.norm(q, axis=1)[:, None], np.arange(9.0)]))
    alone = pose_vectors(signal, PoseOptions(joints=["qy"]))
    assert alone.shape == (9, 10)
    np.testing.assert_array_equal(pose_vectors(signal, PoseOptions(joints=["qy"], weights={"qw": 2})), 2 * alone)
    with pytest.raises(OptionError, match="qw, qx, qy, qz are one rotation, and have one weight; found 2, 3"):
        pose_vectors(signal, PoseOptions(weights={"qw": 2, "qx": 3}))


def test_input_and_reference_agree_on_what_a_channel_is() -> None:
    t = np.arange(60) / 30
    turning = Signal(("yaw",), (170 + 30 * t[:, None] + 180) % 360 - 180, 30)
    still = Signal(("yaw",), 10 * np.sin(t)[:, None], 30)
    assert [str(kind) for clip in (turning, still) for kind in clip.kinds] == ["angle:deg", "linear"]
    for clip, other in ((turning, still), (still, turning)):
        model = model_poses(clip, [Reference(other)], UNSCALED)
        as_told = [Signal(("yaw",), one.values, 30, kinds=["angle:deg"]) for one in (clip, other)]
        expected = model_poses(as_told[0], [Reference(as_told[1])], UNSCALED)
        assert np.array_equal(model.input.tracks[0].vectors, expected.input.tracks[0].vectors)
        assert np.array_equal(model.references[0].tracks[0].vectors, expected.references[0].tracks[0].vectors)


def test_where_an_angle_goes_round_the_warp_is_no_other() -> None:
    t = np.arange(150) / 30
    turn = 100 * np.sin(2 * t) + 40 * t
    shifted = [Signal(("yaw",), ((turn + by + 180) % 360 - 180)[:, None], 30, kinds=["angle"]) for by in (0, 77, 191)]
    paths = [guided_warp(clip, length="70%").path.frames.tolist() for clip in shifted]
    assert paths[1] == paths[0]
    assert paths[2] == paths[0]
