"""A motion's joints as channels, compared with matrices that are multiplied joint by joint."""

from __future__ import annotations

import numpy as np
import pytest

import retime
from retime import Motion, OptionError, Skeleton, joint_signal
from retime.motion import rotation
from retime.motion.joint_signal import JOINT_SPACES, JointSpace, distinct_names

NAMES = ("Spine", "Hand", "Foot.x", "=Hand", "Hand", "腰", "t")


def figure(seed: int, up: str = "y") -> Motion:
    """Make a figure of joints in any order, with translations, whose quaternions change sign now and then."""
    rng = np.random.default_rng(seed)
    n_joints, n_frames = len(NAMES), 12
    parents = (-1, *(int(rng.integers(0, joint)) for joint in range(1, n_joints)))
    # Slow turns, so that which sign agrees is no matter of chance.
    start, turn = rng.normal(size=(2, n_joints, 3))
    times = np.arange(n_frames)[:, None, None] / n_frames
    rotations = rotation.from_rotation_vectors(2 * start + turn * times)
    rotations *= rng.choice([-1.0, 1.0], size=(n_frames, n_joints, 1))
    names = tuple(rng.permutation(NAMES).tolist())
    return Motion(
        Skeleton(names, parents, rng.normal(size=(n_joints, 3))),
        rotations,
        rng.normal(size=(n_frames, n_joints, 3)),
        rate="30000/1001",
        name="any",
        first_frame=3,
        up=up,  # type: ignore[arg-type]
        root=names[0],
    )


def matrices(motion: Motion, space: str) -> np.ndarray:
    """Joints' spaces as 4 by 4 matrices, shape (n_frames, n_joints, 4, 4)."""
    local = np.zeros((motion.n_frames, motion.skeleton.n_joints, 4, 4))
    local[..., :3, :3] = rotation.to_matrix(motion.rotations)
    local[..., :3, 3] = motion.local_translations
    local[..., 3, 3] = 1
    if space == "local":
        return local
    up = np.eye(4)
    if motion.up == "z":
        up[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    out = local.copy()
    for joint, parent in enumerate(motion.skeleton.parents):
        out[:, joint] = (up if parent < 0 else out[:, parent]) @ local[:, joint]
    root = out[:, 0].copy()
    if space == "heading":
        for frame in root:
            # The turn about Y that is nearest to the root's rotation.
            angle = np.arctan2(frame[0, 2] - frame[2, 0], frame[0, 0] + frame[2, 2])
            frame[:3, :3] = rotation.to_matrix(rotation.about_axis(1, angle))
            frame[1, 3] = 0
    if space != "global":
        out = np.linalg.inv(root)[:, None] @ out
    return out[:, 1:] if space == "torso" else out


@pytest.mark.parametrize("space", JOINT_SPACES)
@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("seed", range(3))
def test_positions_and_rotations_in_each_space(seed: int, up: str, space: str) -> None:
    motion = figure(seed, up)
    expected = matrices(motion, space)
    places = joint_signal(motion, space=space)
    np.testing.assert_allclose(places.values.reshape(*expected.shape[:2], 3), expected[..., :3, 3], atol=1e-9)
    turns = joint_signal(motion, rotations=True, space=space)
    q = turns.values.reshape(*expected.shape[:2], 4)
    np.testing.assert_allclose(rotation.to_matrix(q), expected[..., :3, :3], atol=1e-9)
    assert np.all(np.einsum("fjc,fjc->fj", q[1:], q[:-1]) > 0)
    assert {str(kind) for kind in places.kinds} == {"linear"}
    assert {str(kind) for kind in turns.kinds} == {"quaternion"}
    for signal in (places, turns):
        assert (signal.rate, signal.first_frame, signal.name) == (motion.rate, 3, "any")


def test_channels_are_named_by_joint_and_axis() -> None:
    motion = figure(1)
    names = distinct_names(motion.skeleton.names)
    assert sorted(names) == sorted({*NAMES, "Hand#2"})
    assert joint_signal(motion).names == tuple(f"{name}.{axis}" for name in names for axis in "xyz")
    torso = joint_signal(motion, space="torso", rotations=True).names
    assert torso == tuple(f"{name}.q{axis}" for name in names[1:] for axis in "wxyz")
    assert distinct_names(["a", "a", "a#2", "a", "b"]) == ["a", "a#3", "a#2", "a#4", "b"]


def test_positions_are_global_and_rotations_local_unless_said() -> None:
    clip = retime.sample()[:9]
    np.testing.assert_array_equal(joint_signal(clip).values, joint_signal(clip, space="global").values)
    turns = joint_signal(clip, rotations=True)
    np.testing.assert_array_equal(turns.values, joint_signal(clip, rotations=True, space="local").values)
    np.testing.assert_array_equal(joint_signal(clip).values.reshape(9, -1, 3), clip.positions)


def test_what_has_no_joints_there_is_refused() -> None:
    one = Motion(Skeleton(("root",), (-1,), np.zeros((1, 3))), np.tile([1.0, 0, 0, 0], (4, 1, 1)))
    assert joint_signal(one).names == ("root.x", "root.y", "root.z")
    with pytest.raises(OptionError, match="one joint in its body, which is the origin of torso space"):
        joint_signal(one, space="torso")
    with pytest.raises(OptionError, match="the space of joints is one of global, torso, heading, local; found 'hips'"):
        joint_signal(one, space="hips")  # type: ignore[arg-type]
    with pytest.raises(OptionError, match=r"joint_signal\(motion\) with a motion"):
        joint_signal(joint_signal(one))  # type: ignore[arg-type]


@pytest.mark.parametrize("space", ["torso", "heading"])
@pytest.mark.parametrize("rotations", [False, True])
def test_a_node_above_the_body_is_no_origin(space: JointSpace, rotations: bool) -> None:
    clip = retime.sample()[:40]
    n_joints = clip.skeleton.n_joints
    rig = Skeleton(
        ("Reference", *clip.skeleton.names),
        (-1, *(parent + 1 for parent in clip.skeleton.parents)),
        np.concatenate([np.zeros((1, 3)), clip.skeleton.offsets]),
    )
    q = np.concatenate([np.tile([1.0, 0, 0, 0], (40, 1, 1)), clip.rotations], axis=1)
    p = np.concatenate([np.zeros((40, 1, 3)), clip.local_translations], axis=1)
    below = joint_signal(Motion(rig, q, p, 60), rotations=rotations, space=space)
    plain = joint_signal(clip, rotations=rotations, space=space)
    assert below.names == plain.names
    np.testing.assert_allclose(below.values, plain.values, atol=1e-9)
    assert len(joint_signal(Motion(rig, q, p, 60)).names) == 3 * (n_joints + 1)
