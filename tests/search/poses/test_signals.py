from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from retime.errors import OptionError
from retime.motion.channels import ChannelKind
from retime.motion.signal import Signal
from retime.search.guided import guided_warp
from retime.search.poses.references import Reference, model_poses
from retime.search.poses.signals import points_alike
from retime.search.poses.spaces import PoseOptions
from retime.search.poses.vectors import pose_vectors
from retime.warp.curve import Warp

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


def _markers(values: np.ndarray, unit: str) -> Signal:
    """Make a signal of points, values of shape (n_frames, n_points, 3), their channels in a drawn order."""
    n_points = values.shape[1]
    names = [f"m{point}.{axis}" for point in range(n_points) for axis in "xyz"]
    order = np.random.default_rng(n_points).permutation(len(names))
    kinds = [ChannelKind(unit=unit)] * len(names)
    return Signal(tuple(names[i] for i in order), values.reshape(len(values), -1)[:, order], 60, kinds=kinds)


@given(st.integers(0, 10_000), st.sampled_from(["mm", ""]), st.floats(1e-3, 1e3))
def test_a_point_is_as_far_from_another_however_its_axes_lie(seed: int, unit: str, size: float) -> None:
    """Scaled axis by axis, distances would depend on where the axes point."""
    rng = np.random.default_rng(seed)
    values = size * rng.normal(size=(20, 3, 3)) * rng.uniform(0.01, 1, size=(1, 3, 3))
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    before, after = (pose_vectors(_markers(one, unit)) for one in (values, values @ turn))
    for a, b in rng.integers(20, size=(10, 2)):
        assert np.linalg.norm(before[a] - before[b]) == pytest.approx(np.linalg.norm(after[a] - after[b]), abs=1e-9)
    # On average a point is as far from its mean place as a lone channel is from its mean.
    away = np.square(before - before.mean(axis=0)).sum(axis=1).mean()
    assert away == pytest.approx(3, rel=1e-9)


def test_points_of_one_unit_share_a_scale_and_others_have_their_own() -> None:
    rng = np.random.default_rng(3)
    values = rng.normal(size=(200, 2, 3)) * np.array([1.0, 50.0])[:, None]
    for unit, ratio in (("mm", 50.0), ("", 1.0)):
        signal = _markers(values, unit)
        vectors = pose_vectors(signal)
        small, large = (
            np.sqrt(vectors[:, [i for i, name in enumerate(signal.names) if name[:2] == of]].var(axis=0).sum())
            for of in ("m0", "m1")
        )
        assert large / small == pytest.approx(ratio, rel=0.2)
    mixed = replace(
        signal, names=("f.x", "f.y", "f.z", "m.x", "m.y", "m.z"), kinds=["linear:N"] * 3 + ["linear:mm"] * 3
    )
    assert points_alike(mixed.names, mixed.kinds) == [[(0, 1, 2)], [(3, 4, 5)]]
    # A scale that is given counts, and an axis that never changes stays with its point.
    fixed = pose_vectors(mixed, PoseOptions(scales={"f.x": 2.0}))
    np.testing.assert_array_equal(fixed[:, 0], mixed.values[:, 0] / 2.0)


def test_an_axis_of_noise_does_not_decide_the_warp() -> None:
    """Markers that move in a plane, measured with a little noise across it: the noise must not choose what is shown."""
    t = np.arange(300)[:, None] / 60
    # Faster and slower, so that some of it can be shortened with less harm.
    phase = 2 * np.pi * (0.5 * t + 0.6 * np.sin(0.9 * t))
    swing = np.sin(phase + np.array([0.0, 0.4, 1.0])) * np.array([300.0, 250.0, 200.0])
    lift = 0.5 * np.cos(2 * phase) * np.array([300.0, 250.0, 200.0])

    def warp_with(noise: float, seed: int) -> Warp:
        across = noise * np.random.default_rng(seed).normal(size=(300, 3))
        return guided_warp(_markers(np.stack([swing, lift, across], axis=2), "mm"), length="60%").warp

    plain = warp_with(0.0, 0)
    times = np.linspace(0, plain.output_end, 200)
    for seed in range(3):
        assert np.abs(warp_with(0.3, seed)(times) - plain(times)).max() < 0.02
