"""Quaternions, compared with scipy's rotations, which share no code with ours."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from retime.motion import rotation
from tests.motion.strategies import quaternions, vectors
from tests.reference.angles import nearest_triple

ORDERS = ["".join(order) for order in itertools.permutations("XYZ")]


def scipy_rotation(q: np.ndarray) -> Rotation:
    return Rotation.from_quat(q, scalar_first=True)


def assert_same_rotations(a: np.ndarray, b: np.ndarray, tolerance: float = 1e-12) -> None:
    """Compare quaternions that may differ in sign."""
    a, b = np.broadcast_arrays(a, b)
    side = np.where(np.sum(a * b, axis=-1, keepdims=True) < 0, -1.0, 1.0)
    np.testing.assert_allclose(a, side * b, atol=tolerance, rtol=0)


def test_identity_has_the_shape_asked_for() -> None:
    assert rotation.identity().tolist() == [1, 0, 0, 0]
    assert rotation.identity(2, 3).shape == (2, 3, 4)
    assert np.all(rotation.identity(2, 3) == [1, 0, 0, 0])


class TestNormalize:
    @pytest.mark.parametrize("scale", [1.0, 2.5, 1e200, 1e-200, 5e-324, 1.7e308])
    def test_any_length_becomes_one(self, scale: float) -> None:
        np.testing.assert_allclose(rotation.normalize([0, scale, 0, -scale]), np.array([0, 1, 0, -1]) * np.sqrt(0.5))

    def test_lengths_are_taken_one_by_one(self) -> None:
        q = np.array([[3e200, 4e200, 0, 0], [0, 0, 3e-200, -4e-200]])
        np.testing.assert_allclose(rotation.normalize(q), [[0.6, 0.8, 0, 0], [0, 0, 0.6, -0.8]], rtol=1e-15)

    @pytest.mark.parametrize("bad", [[0, 0, 0, 0], [np.nan, 1, 0, 0], [np.inf, 1, 0, 0]])
    def test_what_has_no_direction_is_refused(self, bad: list[float]) -> None:
        with pytest.raises(ZeroDivisionError, match="is no rotation"):
            rotation.normalize([[1, 0, 0, 0], bad])


class TestProducts:
    @given(quaternions(4), quaternions(4))
    def test_multiply_composes_as_scipy_does(self, a, b) -> None:
        expected = (scipy_rotation(a) * scipy_rotation(b)).as_quat(scalar_first=True)
        assert_same_rotations(rotation.multiply(a, b), expected)

    @given(quaternions(3), quaternions(3), vectors(3))
    def test_multiply_turns_by_the_second_first(self, a, b, v) -> None:
        one_by_one = rotation.rotate(a, rotation.rotate(b, v))
        np.testing.assert_allclose(rotation.rotate(rotation.multiply(a, b), v), one_by_one, atol=1e-11)

    @given(quaternions(3), quaternions(3), quaternions(3))
    def test_multiply_is_associative(self, a, b, c) -> None:
        left = rotation.multiply(rotation.multiply(a, b), c)
        np.testing.assert_allclose(left, rotation.multiply(a, rotation.multiply(b, c)), atol=1e-14)

    @given(quaternions(3))
    def test_conjugate_undoes(self, q) -> None:
        np.testing.assert_allclose(rotation.multiply(q, rotation.conjugate(q)), rotation.identity(3), atol=1e-14)

    @given(quaternions(4), vectors(4))
    def test_rotate_turns_as_scipy_does(self, q, v) -> None:
        np.testing.assert_allclose(rotation.rotate(q, v), scipy_rotation(q).apply(v), atol=1e-11)

    @given(quaternions(4), vectors(4))
    def test_matrices_turn_as_quaternions_do(self, q, v) -> None:
        matrices = rotation.to_matrix(q)
        np.testing.assert_allclose(matrices, scipy_rotation(q).as_matrix(), atol=1e-14)
        np.testing.assert_allclose(np.einsum("nij,nj->ni", matrices, v), rotation.rotate(q, v), atol=1e-11)

    @given(quaternions(4))
    def test_a_matrix_gives_back_its_quaternion(self, q) -> None:
        assert_same_rotations(rotation.from_matrix(scipy_rotation(q).as_matrix()), q, tolerance=1e-15)

    def test_half_turns_about_any_axis_come_back_from_matrices(self) -> None:
        axes = np.random.default_rng(3).normal(size=(200, 3))
        half_turns = rotation.normalize(np.concatenate([np.zeros((200, 1)), axes], axis=1))
        assert_same_rotations(rotation.from_matrix(rotation.to_matrix(half_turns)), half_turns, tolerance=1e-15)

    def test_a_matrix_that_is_nearly_a_rotation_gives_one_near_it(self) -> None:
        rng = np.random.default_rng(4)
        q = rotation.normalize(rng.normal(size=(100, 4)))
        near = rotation.from_matrix(rotation.to_matrix(q) + rng.uniform(-1e-4, 1e-4, (100, 3, 3)))
        assert_same_rotations(near, q, tolerance=3e-4)
        np.testing.assert_allclose(np.sum(near * near, axis=-1), 1, atol=1e-15)

    @pytest.mark.parametrize("length", [0.0, 5e-324, 1e-160, 1e-9, 1e-3, 1.0, np.pi, 2 * np.pi, 7.0, 1e6])
    def test_rotation_vectors_turn_as_scipys_do(self, length: float) -> None:
        axes = rotation.normalize(np.random.default_rng(5).normal(size=(50, 4)))[:, 1:]
        vectors = length * axes / np.sqrt(np.sum(axes * axes, axis=-1, keepdims=True))
        expected = Rotation.from_rotvec(vectors).as_quat(scalar_first=True)
        assert_same_rotations(rotation.from_rotation_vectors(vectors), expected, tolerance=1e-15 * max(1.0, length))

    def test_shapes_broadcast(self) -> None:
        many, one = rotation.identity(5, 3), rotation.about_axis(1, 0.3)
        assert rotation.multiply(many, one).shape == (5, 3, 4)
        assert rotation.multiply(one, many[:1]).shape == (1, 3, 4)
        assert rotation.rotate(many[:, :1], np.ones((1, 3, 3))).shape == (5, 3, 3)


class TestEuler:
    @pytest.mark.parametrize("axis", [0, 1, 2])
    def test_a_turn_about_an_axis(self, axis: int) -> None:
        angles = np.linspace(-7, 7, 29)
        expected = Rotation.from_rotvec(angles[:, None] * np.eye(3)[axis]).as_quat(scalar_first=True)
        assert_same_rotations(rotation.about_axis(axis, angles), expected)

    @pytest.mark.parametrize("order", ["X", "Y", "Z", "XZ", "ZY", "YX", *ORDERS])
    def test_angles_compose_in_the_order_written(self, order: str) -> None:
        angles = np.random.default_rng(7).uniform(-7, 7, (50, len(order)))
        expected = Rotation.from_euler(order, angles).as_quat(scalar_first=True)
        assert_same_rotations(rotation.from_euler(order, angles), expected.reshape(50, 4))

    def test_no_channels_mean_no_rotation(self) -> None:
        assert np.array_equal(rotation.from_euler("", np.zeros((2, 3, 0))), rotation.identity(2, 3))

    @pytest.mark.parametrize("order", ORDERS)
    @given(q=quaternions(5))
    def test_angles_found_mean_the_rotation(self, order: str, q) -> None:
        assert_same_rotations(rotation.from_euler(order, rotation.to_euler(order, q)), q, 1e-9)

    @pytest.mark.parametrize("order", ORDERS)
    def test_away_from_the_lock_they_mean_it_to_the_last_digits(self, order: str) -> None:
        q = Rotation.random(300, rng=3).as_quat(scalar_first=True)
        assert_same_rotations(rotation.from_euler(order, rotation.to_euler(order, q)), q, 1e-14)

    @pytest.mark.parametrize("order", ORDERS)
    def test_no_triple_is_nearer(self, order: str) -> None:
        rng = np.random.default_rng(11)
        rotations, near = Rotation.random(40, rng=rng), rng.uniform(-8, 8, (40, 3))
        found = rotation.to_euler(order, rotations.as_quat(scalar_first=True), near=near)
        expected = [nearest_triple(order, rotations[i], near[i]) for i in range(40)]
        np.testing.assert_allclose(found, expected, atol=1e-12)

    @pytest.mark.parametrize("order", ORDERS)
    @given(degrees=st.tuples(*[st.integers(-400, 400)] * 3))
    @example(degrees=(30, 90, 40))
    @example(degrees=(-200, -90, 360))
    @example(degrees=(10, 270, 20))
    @example(degrees=(10, 450, -20))
    def test_angles_of_a_file_come_back(self, order: str, degrees: tuple[int, int, int]) -> None:
        # At gimbal lock too: there one of the outer angles is free, and stays what it was.
        angles = np.radians(degrees)
        np.testing.assert_allclose(
            rotation.to_euler(order, rotation.from_euler(order, angles), near=angles), angles, atol=1e-7
        )

    @pytest.mark.parametrize("order", ORDERS)
    @pytest.mark.parametrize("off", [0.0, 1e-12, 1e-10, 1e-9, 1e-8, 1e-6])
    @pytest.mark.parametrize("sign", [1, -1])
    def test_near_the_lock_the_rotation_is_kept(self, order: str, off: float, sign: int) -> None:
        q = rotation.from_euler(order, [0.7, sign * (np.pi / 2 - off), -0.4])
        assert_same_rotations(rotation.from_euler(order, rotation.to_euler(order, q)), q, 1e-9)

    @pytest.mark.parametrize("order", ["", "X", "XY", "XYX", "ABC"])
    def test_only_three_different_axes_can_be_solved_for(self, order: str) -> None:
        with pytest.raises(ValueError, match="three different axes"):
            rotation.to_euler(order, rotation.identity(1))


class TestSlerp:
    @given(quaternions(), quaternions(), st.floats(0, 1))
    def test_turns_as_scipy_does(self, a, b, fraction: float) -> None:
        # Half a turn apart there are many shortest ways; any of them will do.
        assume(abs(float(np.dot(a, b))) > 1e-6)
        expected = Slerp([0.0, 1.0], scipy_rotation(np.stack([a, b])))(fraction).as_quat(scalar_first=True)
        assert_same_rotations(rotation.slerp(a, b, fraction), expected, 1e-8)

    @given(quaternions(3), quaternions(3))
    def test_ends_come_back_bit_for_bit(self, a, b) -> None:
        assert np.array_equal(rotation.slerp(a, b, np.zeros(3)), a)
        end = rotation.slerp(a, b, np.ones(3))
        assert np.all(np.all(end == b, axis=-1) | np.all(end == -b, axis=-1))

    @given(quaternions(3), quaternions(3), st.floats(0, 1))
    def test_stays_a_unit_quaternion(self, a, b, fraction: float) -> None:
        length = np.linalg.norm(rotation.slerp(a, b, fraction), axis=-1)
        np.testing.assert_allclose(length, 1.0, atol=1e-12)

    @given(quaternions(3), quaternions(3), st.floats(0, 1))
    def test_the_sign_of_a_quaternion_does_not_matter(self, a, b, fraction: float) -> None:
        assume(np.all(np.abs(np.sum(a * b, axis=-1)) > 1e-6))
        assert_same_rotations(rotation.slerp(a, -b, fraction), rotation.slerp(a, b, fraction))

    def test_opposite_quaternions_are_one_rotation(self) -> None:
        q = rotation.about_axis(2, 1.0)
        assert_same_rotations(rotation.slerp(q, -q, [0.25, 0.5]), np.stack([q, q]), 1e-15)

    @pytest.mark.parametrize("angle", [3.1, 1.0, 8e-3, 1e-3, 1e-7, 1e-9, 1e-12])
    def test_turns_at_a_constant_speed_however_slow(self, angle: float) -> None:
        fractions = np.linspace(0, 1, 11)
        found = rotation.slerp(rotation.about_axis(1, 0.0), rotation.about_axis(1, angle), fractions)
        np.testing.assert_allclose(2 * np.arcsin(found[:, 2]), fractions * angle, rtol=1e-7)


class TestMean:
    @pytest.mark.parametrize("spread", [0.4, 0.2, 0.1])
    def test_agrees_with_the_chordal_mean_to_third_order(self, spread: float) -> None:
        rng = np.random.default_rng(5)
        base = Rotation.random(rng=rng)
        rotations = base * Rotation.from_rotvec(rng.uniform(-spread, spread, (9, 3)))
        weights = rng.uniform(0.1, 1, 9)
        expected = rotations.mean(weights).as_quat(scalar_first=True)
        assert_same_rotations(rotation.mean(rotations.as_quat(scalar_first=True), weights), expected, spread**3 / 4)

    @given(quaternions(), st.lists(st.sampled_from([-1.0, 1.0]), min_size=1, max_size=5))
    def test_of_one_rotation_is_that_rotation_whatever_the_signs(self, q, signs) -> None:
        found = rotation.mean(np.outer(signs, q), np.ones(len(signs)))
        assert_same_rotations(found, q, 1e-15)

    def test_weights_choose_and_their_scale_does_not_matter(self) -> None:
        q = rotation.about_axis(0, np.array([0.0, 0.3, 0.5]))
        assert_same_rotations(rotation.mean(q, [0, 0, 5]), q[2], 1e-15)
        assert_same_rotations(rotation.mean(q, [1, 2, 3]), rotation.mean(q, [1e-3, 2e-3, 3e-3]), 1e-15)

    def test_each_row_along_the_axis_has_its_own(self) -> None:
        q = rotation.about_axis(1, np.array([[0.0, 0.2], [1.0, 1.4], [-2.0, -2.0]]))
        found = rotation.mean(q, np.ones(2), axis=1)
        assert_same_rotations(found, rotation.about_axis(1, np.array([0.1, 1.2, -2.0])), 1e-15)

    def test_weights_that_are_all_zero_are_refused(self) -> None:
        with pytest.raises(ZeroDivisionError, match="length 0"):
            rotation.mean(rotation.identity(3), np.zeros(3))


@given(st.floats(-1e100, 1e100))
@example(5e26)
@example(1e6)
@example(-720.25)
def test_large_angles_are_those_that_their_file_says(angle: float) -> None:
    whole, part = int(angle), angle - int(angle)
    exact = np.deg2rad(whole % 360 + part)
    for function in (np.sin, np.cos):
        np.testing.assert_allclose(function(rotation.radians(angle)), function(exact), atol=1e-9)
        np.testing.assert_allclose(function(rotation.radians(angle, degrees=False)), function(angle), atol=1e-9)
    if abs(angle) <= 1e6:
        # Wound up on purpose, perhaps; and what was read so far stays as it was, to the bit.
        assert rotation.radians(angle) == np.deg2rad(angle)
    elif abs(angle) > 2e6:
        assert abs(rotation.radians(angle)) <= 2 * np.pi
        assert abs(rotation.radians(angle, degrees=False)) <= np.pi
