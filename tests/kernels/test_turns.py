"""Turns of joints: right, and the same bits by every backend and every width of vectors."""

from __future__ import annotations

import hashlib
import math
import os
import subprocess
import sys
from fractions import Fraction

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from retime.kernels import BACKENDS, LARGEST_TURN, TurnedJoints, backend, compiled_available
from retime.kernels.numpy_backend import sines
from retime.motion import rotation
from tests.reference.sines import sine_and_cosine

here = [name for name in BACKENDS if name == "numpy" or compiled_available()]
ORDERS = ["XYZ", "YZX", "ZXY", "ZYX", "YXZ", "XZY"]


def some_angles(seed: int, n: int = 2000) -> np.ndarray:
    """Angles of every size, exact quarters of turns and their neighbours, zeros of both signs; shape (n, 3)."""
    generator = np.random.default_rng(seed)
    angles = generator.choice([1e-300, 1e-9, 1.0, 4.0, 1000.0, LARGEST_TURN], size=(n, 3))
    angles *= generator.uniform(-1, 1, size=(n, 3))
    quarters = generator.integers(-9, 10, size=(n, 3)) * (math.pi / 4)
    angles = np.where(generator.random((n, 3)) < 0.3, quarters, angles)
    angles = np.where(generator.random((n, 3)) < 0.1, np.nextafter(angles, 9), angles)
    angles[:3] = [[0.0, -0.0, 0.0], [LARGEST_TURN] * 3, [-LARGEST_TURN] * 3]
    return angles


def test_sines_are_off_by_less_than_one_digit_in_the_last_place() -> None:
    angles = some_angles(1, 300).ravel() / 2
    for angle, found in zip(angles.tolist(), np.transpose(sines(angles)).tolist(), strict=True):
        for one, right in zip(found, sine_and_cosine(angle), strict=True):
            digit = Fraction(math.ulp(float(right)))
            assert abs(Fraction(one) - right) <= Fraction(8, 10) * digit, angle


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("name", here)
def test_three_turns_are_multiplied_in_order(name: str, order: str) -> None:
    angles = np.random.default_rng(2).uniform(-7, 7, size=(97, 3))
    found = backend(name).three_turns(order, angles)
    expected = rotation.identity(97)
    for axis, turns in zip(order, angles.T, strict=True):
        expected = rotation.multiply(expected, rotation.about_axis("XYZ".index(axis), turns))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-15)
    others = Rotation.from_euler(order, angles).as_quat(scalar_first=True)
    assert np.abs(np.sum(found * others, axis=1)).min() > 1 - 1e-14


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("n", [0, 1, 95, 96, 97, 5000])
def test_both_backends_turn_alike_to_the_last_bit(order: str, n: int) -> None:
    angles = some_angles(3, max(n, 3))[:n]
    found = {backend(name).three_turns(order, angles).tobytes() for name in here}
    assert len(found) == 1


def test_turns_beyond_the_largest_are_right_too() -> None:
    angles = np.array([[LARGEST_TURN * 3, 0.25, -LARGEST_TURN * 1e6], [1.0, 2.0, 3.0]])
    expected = Rotation.from_euler("ZXY", angles).as_quat(scalar_first=True)
    found = rotation.from_euler("ZXY", angles)
    assert np.abs(np.sum(found * expected, axis=1)).min() > 1 - 1e-12
    assert np.array_equal(found[1], rotation.from_euler("ZXY", angles[1]))


@pytest.mark.parametrize("n_rows", [1, 7, 1500])
@pytest.mark.parametrize("seed", range(4))
def test_joints_are_turned_by_their_channels(n_rows: int, seed: int) -> None:
    generator = np.random.default_rng(seed)
    n_joints, n_turned = 6, int(generator.integers(1, 7))
    joints = generator.permutation(n_joints)[:n_turned]
    columns = generator.permutation(20)[: 3 * n_turned].reshape(n_turned, 3)
    order = str(generator.choice(ORDERS))
    rows = np.degrees(some_angles(seed, 10 * n_rows).reshape(-1)[: 20 * n_rows]).reshape(n_rows, 20)
    rows[generator.random(rows.shape) < 0.05] = 5e26
    turned = TurnedJoints(order, joints, columns, 1e6)
    answers = []
    for name in here:
        angles, rotations = np.full((n_rows, n_joints, 3), 7.0), np.full((n_rows, n_joints, 4), 7.0)
        backend(name).turn_joints(rows, turned, angles, rotations)
        answers.append((angles, rotations))
        # The same as by the functions that know nothing of channels; other joints are left alone.
        for joint in range(n_joints):
            if joint in joints:
                radians = rotation.radians(rows[:, columns[joints.tolist().index(joint)]])
                assert np.array_equal(angles[:, joint], radians)
                assert np.array_equal(rotations[:, joint], rotation.from_euler(order, radians))
            else:
                assert (angles[:, joint] == 7.0).all()
                assert (rotations[:, joint] == 7.0).all()
    for angles, rotations in answers:
        assert angles.tobytes() == answers[0][0].tobytes()
        assert rotations.tobytes() == answers[0][1].tobytes()


@pytest.mark.skipif(not compiled_available(), reason="the compiled kernels were not built")
@pytest.mark.parametrize("variables", [{"RETIME_SIMD": "plain"}, {"RETIME_SIMD": "avx2"}, {"RETIME_THREADS": "1"}])
def test_narrower_vectors_and_fewer_threads_give_the_same_bits(variables: dict[str, str]) -> None:
    child = "from tests.kernels.test_turns import digest_of_turns; print(digest_of_turns())"
    done = subprocess.run(
        [sys.executable, "-c", child], env=os.environ | variables, capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == digest_of_turns()


def digest_of_turns() -> str:
    """Hash what the compiled kernel makes of some channels."""
    rows = np.degrees(some_angles(5, 6000)).reshape(-1, 9)
    turned = TurnedJoints("ZXY", np.array([2, 0, 1]), np.arange(9).reshape(3, 3), 1e6)
    angles, rotations = np.empty((len(rows), 3, 3)), np.empty((len(rows), 3, 4))
    backend("compiled").turn_joints(rows, turned, angles, rotations)
    return hashlib.sha256(angles.tobytes() + rotations.tobytes()).hexdigest()
