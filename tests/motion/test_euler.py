"""Angles for declared channels: exact where the channels suffice, the nearest where not, and continuous in time."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from retime.motion import rotation
from retime.motion.euler import angle_between, fit_angles
from tests.motion.strategies import quaternions

ORDERS = ["".join(order) for n in range(1, 4) for order in permutations("XYZ", n)]
FEW = [order for order in ORDERS if len(order) < 3]


@given(q=quaternions(4), p=quaternions(4))
def test_angle_between_against_scipy(q: np.ndarray, p: np.ndarray) -> None:
    between = Rotation.from_quat(q, scalar_first=True).inv() * Rotation.from_quat(p, scalar_first=True)
    np.testing.assert_allclose(angle_between(q, p), between.magnitude(), atol=3e-8)


def test_angle_between_is_accurate_for_small_angles() -> None:
    q = rotation.from_euler("XYZ", [0.3, 0.2, 0.1])
    p = rotation.multiply(q, rotation.from_euler("X", [1e-7]))
    assert angle_between(q, -p) == pytest.approx(1e-7, rel=1e-6)


@given(order=st.sampled_from(ORDERS), data=st.data())
def test_angles_that_mean_the_rotation_already_stay_bit_for_bit(order: str, data: st.DataObject) -> None:
    """Gimbal locks and whole turns included: a file's own angles are never replaced by others as good."""
    angle = st.one_of(st.sampled_from([0.0, np.pi / 2, -np.pi / 2, np.pi, 5 * np.pi / 2]), st.floats(-20, 20))
    angles = data.draw(arrays(np.float64, (3, 2, len(order)), elements=angle))
    fitted = fit_angles(order, rotation.from_euler(order, angles), near=angles)
    assert fitted.tolist() == angles.tolist()


@given(order=st.sampled_from(ORDERS), data=st.data())
def test_expressible_rotations_are_met(order: str, data: st.DataObject) -> None:
    angles = data.draw(arrays(np.float64, (4, len(order)), elements=st.floats(-4, 4)))
    near = data.draw(st.one_of(st.none(), arrays(np.float64, (4, len(order)), elements=st.floats(-9, 9))))
    q = rotation.from_euler(order, angles)
    fitted = fit_angles(order, q, near=near)
    assert angle_between(rotation.from_euler(order, fitted), q).max() < 3e-8
    if near is not None and len(order) < 3:
        assert np.all(np.abs(fitted - near) < np.pi + 1e-9)


@given(order=st.sampled_from(FEW), q=quaternions(1))
def test_too_few_axes_give_the_nearest(order: str, q: np.ndarray) -> None:
    ours = angle_between(rotation.from_euler(order, fit_angles(order, q)), q)[0]
    everywhere = np.meshgrid(*[np.radians(np.arange(-180, 180, 5))] * len(order))
    grid = rotation.from_euler(order, np.stack(everywhere, axis=-1))
    best = angle_between(grid, q[0]).min()
    # No angles of the grid are nearer, and the best of them, 2.5 degrees off at most about each axis, are not far.
    assert best - np.radians(5) <= ours <= best + 3e-8


def test_no_axis_gives_no_angle() -> None:
    assert fit_angles("", rotation.identity(5, 2)).shape == (5, 2, 0)
    assert fit_angles("", rotation.identity(5, 2), near=np.zeros((5, 2, 0))).shape == (5, 2, 0)


@pytest.mark.parametrize("order", ORDERS)
def test_curves_run_on_without_jumps(order: str) -> None:
    """Two and a half turns of each axis in small steps come back as they are, up to whole turns of the start."""
    times = np.linspace(0, 1, 400)[:, None]
    angles = np.linspace([0.1, 0.2, 0.3], [12, 1.2, -15], 400)[:, : len(order)] + 0.1 * np.sin(9 * times)
    if len(order) < 3:
        angles[:, -1] *= 5
    fitted = fit_angles(order, rotation.from_euler(order, angles))
    assert np.abs(np.diff(fitted, axis=0)).max() < 0.3
    assert angle_between(rotation.from_euler(order, fitted), rotation.from_euler(order, angles)).max() < 3e-8


def follow_one_by_one(order: str, q: np.ndarray) -> np.ndarray:
    """Choose each frame's triple closest to the last one's: the slow way."""
    frames = [rotation.to_euler(order, q[0])]
    for frame in q[1:]:
        frames.append(rotation.to_euler(order, frame, near=frames[-1]))
    return np.array(frames)


@pytest.mark.parametrize("order", ["ZYX", "XZY"])
def test_all_frames_at_once_against_one_by_one(order: str) -> None:
    generator = np.random.default_rng(11)
    steps = np.cumsum(generator.normal(scale=0.25, size=(300, 6, 3)), axis=0)
    q = rotation.from_euler("XYZ", steps)
    np.testing.assert_allclose(fit_angles(order, q), follow_one_by_one(order, q), atol=1e-9)


@pytest.mark.parametrize("order", ["ZYX", "XYZ"])
def test_through_a_gimbal_lock(order: str) -> None:
    """A swing that stands still at a right angle: the outer angles are free there, and must not jump."""
    middle = np.radians([70, 80, 90, 90, 90, 100, 110, 100, 90, 80, 70])
    angles = np.stack([np.full(11, 0.7), middle, np.full(11, -0.4)], axis=-1)[:, None]
    fitted = fit_angles(order, rotation.from_euler(order, angles))
    np.testing.assert_allclose(fitted, angles, atol=1e-6)
