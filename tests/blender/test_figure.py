"""A figure made of the matrices of bones."""

from __future__ import annotations

import numpy as np
import pytest

from blender.figure import Bones, figure_of, turns_of
from retime.motion import rotation
from retime.motion.body import body_joint


def some_bones(rng, n=12, n_frames=9):
    """Make random bones, parents before children, and random poses of them: rest, poses, world."""
    parents = [-1, *(int(rng.integers(0, i)) for i in range(1, n))]
    rest, poses = np.tile(np.eye(4), (n, 1, 1)), np.tile(np.eye(4), (n_frames, n, 1, 1))
    for bone in range(n):
        rest[bone, :3, :3] = rotation.to_matrix(rotation.normalize(rng.normal(size=4)))
        rest[bone, :3, 3] = rng.normal(size=3)
        for frame in range(n_frames):
            poses[frame, bone, :3, :3] = rotation.to_matrix(rotation.normalize(rng.normal(size=4)))
            poses[frame, bone, :3, 3] = rng.normal(size=3)
    names = [f"bone {i}" for i in rng.permutation(n)]
    deforms = rng.random(n) < 0.6
    world = np.tile(np.eye(4), (n_frames, 1, 1))
    world[:, :3, :3] = rotation.to_matrix(rotation.normalize(rng.normal(size=(n_frames, 4))))
    world[:, :3, 3] = rng.normal(size=(n_frames, 3))
    return Bones(names, parents, rest, rng.uniform(0.1, 1, n), deforms), poses, world


@pytest.mark.parametrize("seed", range(8))
def test_joints_are_where_blender_has_the_bones(seed):
    rng = np.random.default_rng(seed)
    bones, poses, world = some_bones(rng)
    # Scale makes no pose: each bone has its own, and keeps its place.
    poses[..., :3, :3] *= rng.uniform(0.5, 2, (*poses.shape[:2], 1, 3))
    motion = figure_of(bones, poses, world, rate=24.0, name="rig")
    assert motion.up == "z"
    places = np.einsum("fij,fbj->fbi", world, poses[..., 3])[..., :3]
    # Y is up in global space, where the motion's own Z is.
    x, y, z = np.moveaxis(places, -1, 0)
    np.testing.assert_allclose(motion.positions[:, 1:], np.stack([x, z, -y], axis=-1), atol=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_deforming_bones_hang_below_the_next_one_that_deforms(seed):
    bones, _, _ = some_bones(np.random.default_rng(seed), n=20)
    chosen = bones.deforming()
    if bones.deforms.sum() < 3:
        assert chosen is bones
        return
    for name, parent in zip(chosen.names, chosen.parents, strict=True):
        above = bones.parents[bones.names.index(name)]
        while above >= 0 and not bones.deforms[above]:
            above = bones.parents[above]
        assert (chosen.names[parent] if parent >= 0 else None) == (bones.names[above] if above >= 0 else None)


def test_a_figure_of_no_persons_size_has_no_unit():
    bones, poses, world = some_bones(np.random.default_rng(1))
    assert figure_of(bones, poses, world, rate=24.0, name="rig").metres_per_unit == 1.0
    assert figure_of(bones, poses, world, rate=24.0, name="rig", metres_per_unit=0.5).metres_per_unit == 0.5
    assert figure_of(bones, poses, world, rate=24.0, name="rig", metres_per_unit=100.0).metres_per_unit is None


def test_a_root_may_be_named():
    bones, poses, world = some_bones(np.random.default_rng(2))
    motion = figure_of(bones, poses, world, rate=24.0, name="rig", root=bones.names[4])
    assert motion.skeleton.names[body_joint(motion)] == bones.names[4]


def test_what_has_no_size_keeps_the_turn_that_it_had():
    rng = np.random.default_rng(5)
    turns = rotation.to_matrix(rotation.normalize(rng.normal(size=(7, 3, 4))))
    sizes = np.ones((7, 3))
    sizes[[0, 3, 4], 0] = 0.0
    sizes[:, 1] = 0.0
    found = turns_of(turns * sizes[..., None, None])
    np.testing.assert_allclose(found[[0, 1, 2, 3, 4, 5, 6], 0], turns[[1, 1, 2, 2, 2, 5, 6], 0], atol=1e-12)
    np.testing.assert_array_equal(found[:, 1], np.tile(np.eye(3), (7, 1, 1)))
    np.testing.assert_allclose(found[:, 2], turns[:, 2], atol=1e-12)


def test_flat_and_mirrored_ones_give_turns_too():
    rng = np.random.default_rng(6)
    turns = rotation.to_matrix(rotation.normalize(rng.normal(size=(5, 2, 4))))
    flat, mirrored = turns.copy(), turns * np.array([-1.0, 2.0, 3.0])
    flat[2, 0, :, 1] = 0.0
    np.testing.assert_allclose(turns_of(flat)[2, 0], turns[1, 0], atol=1e-12)
    found = turns_of(mirrored)
    np.testing.assert_allclose(np.linalg.det(found), 1.0, atol=1e-12)
    # Turned by half a turn about one of its own axes, in every frame alike.
    np.testing.assert_allclose(found @ np.diag([1.0, -1.0, -1.0]), turns, atol=1e-12)
