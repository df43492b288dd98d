"""Joints placed in space, and extents: the same bits by every backend, and what loops over single frames find."""

from __future__ import annotations

import numpy as np
import pytest

from retime.kernels import BACKENDS, PosedJoints, backend, compiled_available
from retime.motion import rotation

here = [name for name in BACKENDS if name == "numpy" or compiled_available()]


def some_joints(generator: np.random.Generator, n_joints: int, n_sites: int, turned: bool) -> PosedJoints:
    parents = [-1, *(int(generator.integers(0, joint)) for joint in range(1, n_joints))]
    return PosedJoints(
        np.array(parents),
        generator.integers(0, n_joints, size=n_sites),
        generator.normal(size=(n_sites, 3)),
        rotation.about_axis(0, -np.pi / 2) if turned else np.zeros(0),
    )


def posed(
    name: str, joints: PosedJoints, rotations: np.ndarray, translations: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    ends = np.full((len(rotations), len(joints.site_parents), 3), 7.0)
    out = np.full_like(translations, 7.0), np.full_like(rotations, 7.0), ends
    backend(name).pose_joints(joints, rotations, translations, out)
    return out


@pytest.mark.parametrize(("n_frames", "n_joints", "n_sites"), [(1, 1, 0), (3, 1, 2), (700, 5, 3), (5000, 12, 0)])
@pytest.mark.parametrize("turned", [False, True])
def test_both_backends_pose_alike_to_the_last_bit(n_frames: int, n_joints: int, n_sites: int, turned: bool) -> None:
    generator = np.random.default_rng(n_frames)
    joints = some_joints(generator, n_joints, n_sites, turned)
    rotations = rotation.normalize(generator.normal(size=(n_frames, n_joints, 4)))
    translations = generator.normal(size=(n_frames, n_joints, 3))
    # Nothing that moves, and zeros of both signs.
    rotations[: n_frames // 3] = [1.0, -0.0, 0.0, 0.0]
    translations[: n_frames // 4] = -0.0
    first, *others = (posed(name, joints, rotations, translations) for name in here)
    for other in others:
        assert [array.tobytes() for array in first] == [array.tobytes() for array in other]
    # Frame by frame, joint by joint, from the parent's.
    positions, turns, ends = first
    for frame in {0, n_frames // 2, n_frames - 1}:
        for joint in range(n_joints):
            parent = joints.parents[joint]
            q, p = rotations[frame, joint], translations[frame, joint]
            if joint:
                above = turns[frame, parent]
                q, p = rotation.multiply(above, q), positions[frame, parent] + rotation.rotate(above, p)
            elif turned:
                q, p = rotation.multiply(joints.turn, q), p[[0, 2, 1]] * [1, 1, -1]
            np.testing.assert_allclose(turns[frame, joint], q, rtol=0, atol=1e-14)
            np.testing.assert_allclose(positions[frame, joint], p, rtol=0, atol=1e-12)
        for site, parent in enumerate(joints.site_parents):
            end = positions[frame, parent] + rotation.rotate(turns[frame, parent], joints.site_offsets[site])
            np.testing.assert_allclose(ends[frame, site], end, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", here)
@pytest.mark.parametrize("n", [1, 31, 32, 33, 1000, 200_000])
@pytest.mark.parametrize("bad", [None, np.nan, np.inf, -np.inf])
def test_extents(name: str, n: int, bad: float | None) -> None:
    generator = np.random.default_rng(n)
    numbers = generator.normal(size=(n, 4)) * 10.0 ** generator.integers(-100, 100, size=(n, 1))
    squares = np.sum(numbers * numbers, axis=1)
    expected = [(numbers.min(), numbers.max()), (squares.min(), squares.max())]
    if bad is not None:
        numbers[generator.integers(n), generator.integers(4)] = bad
        expected = [(np.nan, np.nan)] * 2
    kernels = backend(name)
    assert np.array_equal(kernels.extent(numbers), expected[0], equal_nan=True)
    np.testing.assert_allclose(kernels.squared_lengths(numbers), expected[1], rtol=1e-14)


@pytest.mark.parametrize("name", here)
def test_squares_that_overflow_are_not_finite(name: str) -> None:
    assert np.isnan(backend(name).squared_lengths(np.full((3, 4), 1e200))).all()
    assert np.isnan(backend(name).extent(np.array([1.0, np.nan, 2.0]))).all()
    assert backend(name).squared_lengths(np.zeros((1, 4))) == (0.0, 0.0)
