"""Clips that are cameras: where they stand, look, and how much they see."""

from __future__ import annotations

import numpy as np
import pytest

from retime import Motion, Signal, Skeleton
from retime.motion import rotation
from retime.motion.cameras import camera_path

N = 12


def _looks(path: np.ndarray) -> np.ndarray:
    """Say where it looks: along its own -Z."""
    return rotation.rotate(path[:, 3:7], np.array([0.0, 0.0, -1.0]))


def _places(rng: np.random.Generator) -> np.ndarray:
    return rng.normal(size=(N, 3)) * 3


@pytest.mark.parametrize(
    "names",
    [
        ("tx", "ty", "tz"),
        ("cam_pos_x", "cam_pos_y", "cam_pos_z"),
        ("Camera1.translateX", "Camera1.translateY", "Camera1.translateZ"),
        ("location.x", "location.y", "location.z"),
    ],
)
def test_a_signal_of_places_and_angles_is_a_camera(names) -> None:
    rng = np.random.default_rng(len(names[0]))
    places, angles = _places(rng), rng.uniform(-180, 180, (N, 3))
    before = names[0][: names[0].lower().find("pos")] if "pos" in names[0] else ""
    turn = [f"{before}{name}" for name in ("rx", "ry", "rz")]
    # Channels stand in any order, and others beside them.
    columns = np.concatenate([angles, rng.normal(size=(N, 1)), places], axis=1)
    kinds = ["angle:deg"] * 3 + ["linear"] * 4
    path = camera_path(Signal((*turn, "focus", *names), columns, 24, kinds=kinds))
    assert path is not None
    np.testing.assert_allclose(path[:, :3], places)
    np.testing.assert_allclose(path[:, 7], 40.0)
    # X first, then Y, then Z, each about an axis that stays.
    x, y, z = np.radians(angles).T
    ahead = np.zeros((N, 3)) - [0.0, 0.0, 1.0]
    for axis, angle in ((0, x), (1, y), (2, z)):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        turned = ahead.copy()
        turned[:, a] = np.cos(angle) * ahead[:, a] - np.sin(angle) * ahead[:, b]
        turned[:, b] = np.sin(angle) * ahead[:, a] + np.cos(angle) * ahead[:, b]
        ahead = turned
    np.testing.assert_allclose(_looks(path), ahead, atol=1e-9)


def test_pan_turns_to_the_left_and_tilt_up() -> None:
    values = np.array([[0, 0, 0, 0, 0], [0, 0, 0, 90, 0], [0, 0, 0, 0, 45], [0, 0, 0, 90, 90]], dtype=float)
    signal = Signal(("tx", "ty", "tz", "pan", "tilt"), values, 24, kinds={"pan": "angle:deg", "tilt": "angle:deg"})
    path = camera_path(signal)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(_looks(path), [[0, 0, -1], [-1, 0, 0], [0, half, -half], [0, 1, 0]], atol=1e-12)
    radians = Signal(
        signal.names,
        np.concatenate([values[:, :3], np.radians(values[:, 3:])], axis=1),
        24,
        kinds={"pan": "angle:rad", "tilt": "angle:rad"},
    )
    np.testing.assert_allclose(camera_path(radians), path, atol=1e-12)


def test_units_and_lenses_are_read() -> None:
    places = np.ones((N, 3)) * [100.0, 150.0, 300.0]
    turn = rotation.about_axis(1, np.linspace(0, 1, N))
    names = ("x", "y", "z", "qw", "qx", "qy", "qz", "focal")
    columns = np.concatenate([places, turn, np.full((N, 1), 50.0)], axis=1)
    kinds = {"x": "linear:cm", "y": "linear:cm", "z": "linear:cm", "q*": "quaternion"}
    path = camera_path(Signal(names, columns, 24, kinds=kinds), unit=7.0)
    np.testing.assert_allclose(path[:, :3], places / 100)
    np.testing.assert_allclose(path[:, 3:7], turn)
    np.testing.assert_allclose(path[:, 7], np.degrees(2 * np.arctan(12 / 50)))
    plain = Signal(names, columns, 24, kinds={"q*": "quaternion"})
    np.testing.assert_allclose(camera_path(plain, unit=0.5)[:, :3], places / 2)


@pytest.mark.parametrize("name", ["Camera", "shot_cam", "renderCam01"])
def test_a_motion_of_a_joint_that_is_called_a_camera_is_one(name) -> None:
    rng = np.random.default_rng(5)
    turns, places = rotation.normalize(rng.normal(size=(N, 1, 4))), _places(rng)[:, None]
    motion = Motion(Skeleton((name,), (-1,), np.zeros((1, 3))), turns, places, 30, metres_per_unit=0.01)
    path = camera_path(motion)
    np.testing.assert_allclose(path[:, :3], places[:, 0] / 100)
    np.testing.assert_allclose(np.abs(np.sum(path[:, 3:7] * turns[:, 0], axis=1)), 1.0)


def test_what_is_no_camera_is_none() -> None:
    rng = np.random.default_rng(7)
    for names in (("pan", "tilt"), ("tx", "ty", "tz"), ("tx", "ty", "rx", "ry", "rz"), ("x", "y", "z", "w")):
        assert camera_path(Signal(names, rng.normal(size=(N, len(names))), 24)) is None
    for names in (("Hips",), ("Scamper",), ("Camera", "a", "b", "c")):
        n = len(names)
        skeleton = Skeleton(names, (-1, 0, 1, 2)[:n], np.zeros((n, 3)))
        still = np.zeros((N, n, 3))
        assert camera_path(Motion(skeleton, rotation.identity(N, n), still, 30)) is None
