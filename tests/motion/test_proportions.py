from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from retime.errors import OptionError
from retime.motion import rotation
from retime.motion.joint_names import mirror_partners
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.proportions import (
    RestPose,
    fit_skeletons,
    lateral_axis,
    mirror_poses,
    still_joints,
    upright_turn,
)
from retime.motion.skeleton import Skeleton
from tests.motion.strategies import quaternions
from tests.motion.walkers import built, moved, resting, walker, walker_skeleton

SKELETON = walker_skeleton()
EVERY = [(joint, joint) for joint in range(SKELETON.n_joints)]
PARTNERS = [partner for partner in mirror_partners(SKELETON.names) if partner is not None]
few = settings(max_examples=25)
seeds = st.integers(0, 2**32 - 1)


def random_offsets(seed: int, n_joints: int = SKELETON.n_joints) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(n_joints, 3))


def random_skeleton(seed: int) -> Skeleton:
    return Skeleton(SKELETON.names, SKELETON.parents, random_offsets(seed))


@few
@given(seeds, quaternions(), st.floats(0.01, 100))
def test_a_turned_and_scaled_rest_pose_is_turned_and_scaled_back(seed, turn, scale) -> None:
    rest = RestPose.of(random_skeleton(seed))
    other = Skeleton(SKELETON.names, SKELETON.parents, rotation.rotate(turn, rest.offsets) * scale)
    fit = fit_skeletons(rest, RestPose.of(other), EVERY)
    np.testing.assert_allclose(rotation.to_matrix(fit.rotation), rotation.to_matrix(turn).T, atol=1e-9)
    assert fit.scale == pytest.approx(1 / scale, rel=1e-9)
    assert fit.root_scale == pytest.approx(1 / scale, rel=1e-9)
    assert all(part.ratio == pytest.approx(1 / scale, rel=1e-9) for part in fit.stretches)


@few
@given(seeds, seeds, seeds)
def test_no_turn_brings_the_rest_poses_nearer(seed, other_seed, turn_seed) -> None:
    # The stretches between matched joints have the input's lengths; only then the rest poses are compared.
    rest, other = RestPose.of(random_skeleton(seed)), RestPose.of(random_skeleton(other_seed))
    fit = fit_skeletons(rest, other, EVERY)
    places = {0: np.zeros(3)}
    for part in fit.stretches:
        stretch = other.positions[part.reference_joint] - other.positions[part.reference_start]
        places[part.joint] = places[part.start] + part.ratio * stretch
    weights = np.linalg.norm(rest.offsets, axis=1)
    points = np.array([places[joint] for joint, _ in EVERY])

    def distance(turn: np.ndarray) -> float:
        return float(weights @ np.linalg.norm(rotation.rotate(turn, points) - rest.positions, axis=1))

    best = distance(fit.rotation)
    rng = np.random.default_rng(turn_seed)
    for angle in (0.01, 0.1, 1.0):
        small = Rotation.from_rotvec(angle * rng.normal(size=3)).as_quat(scalar_first=True)
        assert best <= distance(rotation.multiply(small, fit.rotation)) * (1 + 1e-3)


@pytest.mark.parametrize("arms", ["down", "forward"])
def test_arms_that_rest_otherwise_do_not_turn_the_body(arms) -> None:
    turns = {}
    for side, sign in (("Left", 1), ("Right", -1)):
        angles = [-sign * 1.2] if arms == "down" else [-sign * np.pi / 2]
        turns[f"{side}Arm"] = rotation.from_euler("Z" if arms == "down" else "Y", np.array(angles))
    other = resting(walker(), turns).skeleton
    assert np.abs(other.offsets - SKELETON.offsets).max() > 0.2
    fit = fit_skeletons(RestPose.of(SKELETON), RestPose.of(other), EVERY)
    angle = np.degrees(2 * np.arccos(min(1.0, abs(fit.rotation[0]))))
    assert angle < 0.5, angle


@few
@given(seeds, quaternions(4, SKELETON.n_joints))
def test_a_body_of_other_proportions_takes_the_same_poses(seed, rotations) -> None:
    motion = Motion(SKELETON, rotations)
    factors = np.random.default_rng(seed).uniform(0.2, 5, SKELETON.n_joints)
    other = built(motion, factors, 1.0)
    fit = fit_skeletons(RestPose.of(SKELETON), RestPose.of(other.skeleton), EVERY)
    placed = fit.place(global_poses(other), {})
    expected = global_poses(motion).positions
    root = placed.positions[:, :1]
    joints = [0, *(part.joint for part in fit.stretches)]
    np.testing.assert_allclose(placed.positions - root, (expected - expected[:, :1])[:, joints], atol=1e-9)


def test_a_stretch_of_no_length_turns_with_the_joint_before_it() -> None:
    # As in some conversions of captures, where neck and shoulders stand at the chest.
    motion = walker()
    flat = SKELETON.offsets.copy()
    flat[[SKELETON.index(name) for name in ("Neck", "LeftShoulder", "RightShoulder")]] = 0.0
    other = built(motion, np.where(np.any(flat, axis=1), 1.0, 0.0), 1.0)
    fit = fit_skeletons(RestPose.of(SKELETON), RestPose.of(other.skeleton), EVERY)
    placed = fit.place(global_poses(other), {})
    joints = [0, *(part.joint for part in fit.stretches)]
    np.testing.assert_allclose(placed.positions, global_poses(motion).positions[:, joints], atol=1e-9)


def test_a_joint_that_stands_still_is_put_where_the_input_has_it() -> None:
    motion = walker()
    wide = SKELETON.offsets.copy()
    hips = [SKELETON.index("LeftUpLeg"), SKELETON.index("RightUpLeg")]
    wide[hips] = [[0.15, 0.0, 0.0], [-0.15, 0.0, 0.0]]
    other = Motion(Skeleton(SKELETON.names, SKELETON.parents, wide), motion.rotations)
    rest = RestPose.of(SKELETON)
    still = still_joints(global_poses(motion), rest)
    # The hips, and the spine's first joint.
    assert sorted(still) == sorted([0, SKELETON.index("Spine"), *hips])
    fit = fit_skeletons(rest, RestPose.of(other.skeleton), EVERY)
    placed = fit.place(global_poses(other), still)
    own = rotation.rotate(rotation.conjugate(placed.rotations), placed.positions - placed.positions[:, :1])
    order = [part.joint for part in fit.stretches]
    for hip in hips:
        np.testing.assert_allclose(own[:, 1 + order.index(hip)], np.tile(SKELETON.offsets[hip], (80, 1)), atol=1e-12)


def test_a_root_that_is_another_joint_is_placed_by_the_rest_poses() -> None:
    # The reference's root is its chest, above the hips, and nothing of it is called hips.
    names = ("chest", "LeftUpLeg", "LeftLeg", "RightUpLeg", "RightLeg", "Head")
    offsets = np.array([[0, 0, 0], [0.1, -0.4, 0], [0, -0.4, 0], [-0.1, -0.4, 0], [0, -0.4, 0], [0, 0.3, 0]])
    rest = RestPose.of(
        Skeleton(
            ("Hips", *names[1:]),
            (-1, 0, 1, 0, 3, 0),
            np.array([[0, 0, 0], [0.1, 0, 0], [0, -0.4, 0], [-0.1, 0, 0], [0, -0.4, 0], [0, 0.7, 0]]),
        )
    )
    other = RestPose.of(Skeleton(names, (-1, 0, 1, 0, 3, 0), offsets))
    fit = fit_skeletons(rest, other, [(joint, joint) for joint in range(1, 6)])
    np.testing.assert_allclose(fit.shift, [0, 0.4, 0], atol=1e-2)
    np.testing.assert_allclose(fit.rotation, [1, 0, 0, 0], atol=1e-6)


@pytest.mark.parametrize(
    ("offsets", "message"),
    [
        (np.zeros((4, 3)), "rest in one place"),
        (np.array([[0, 0, 0], [0, 1, 0], [0, 1, 0], [0, 1, 0]]), "rest in one line"),
    ],
)
def test_rest_poses_that_say_too_little_are_refused(offsets, message) -> None:
    rest = RestPose.of(Skeleton(("a", "b", "c", "d"), (-1, 0, 1, 2), offsets))
    with pytest.raises(OptionError, match=message):
        fit_skeletons(rest, rest, [(joint, joint) for joint in range(4)])


@few
@given(quaternions(3, SKELETON.n_joints), seeds)
def test_a_mirror_image_is_the_motion_of_a_mirrored_skeleton(rotations, seed) -> None:
    # Forward kinematics by hand: every joint stands at its mirrored offset from its parent.
    skeleton = random_skeleton(seed)
    rest = RestPose.of(skeleton)
    lateral = lateral_axis(rest, [(SKELETON.index("LeftLeg"), SKELETON.index("RightLeg"))])
    poses = mirror_poses(global_poses(Motion(skeleton, rotations)), PARTNERS, lateral)
    mirrored = rest.mirrored(PARTNERS, lateral)
    assert mirrored.parents == skeleton.parents
    for joint in range(1, skeleton.n_joints):
        parent = skeleton.parents[joint]
        expected = poses.positions[:, parent] + rotation.rotate(poses.rotations[:, parent], mirrored.offsets[joint])
        np.testing.assert_allclose(poses.positions[:, joint], expected, atol=1e-9)


@few
@given(quaternions(3, SKELETON.n_joints))
def test_a_mirror_image_of_a_mirror_image_is_the_motion(rotations) -> None:
    poses = global_poses(Motion(SKELETON, rotations))
    lateral = np.array([1.0, 0.0, 0.0])
    twice = mirror_poses(mirror_poses(poses, PARTNERS, lateral), PARTNERS, lateral)
    np.testing.assert_allclose(twice.positions, poses.positions, atol=1e-12)
    np.testing.assert_allclose(rotation.to_matrix(twice.rotations), rotation.to_matrix(poses.rotations), atol=1e-12)


def test_the_lateral_axis_is_exact_where_a_skeleton_is_nearly_straight() -> None:
    crooked = SKELETON.offsets.copy()
    crooked[SKELETON.index("LeftUpLeg")] += [0.01, 0.02, -0.01]
    pairs = [(SKELETON.index("LeftUpLeg"), SKELETON.index("RightUpLeg"))]
    rest = RestPose.of(Skeleton(SKELETON.names, SKELETON.parents, crooked))
    assert lateral_axis(rest, pairs).tolist() == [1.0, 0.0, 0.0]
    turned = rotation.rotate(rotation.about_axis(1, np.pi / 4), crooked)
    rest = RestPose.of(Skeleton(SKELETON.names, SKELETON.parents, turned))
    np.testing.assert_allclose(lateral_axis(rest, pairs), [0.68, 0.09, -0.73], atol=0.05)
    with pytest.raises(OptionError, match="same places"):
        lateral_axis(rest, [(0, 0)])


@pytest.mark.parametrize("up", ["Y", "Z", "-Y", "X"])
@pytest.mark.parametrize("lying", [False, True])
def test_a_reference_is_stood_upright_by_its_rest_pose_and_its_motion(up, lying) -> None:
    # The rest pose and the whole of space are turned alike, so that another axis is up; or only the motion lies down.
    turn = rotation.from_euler(
        "XZ", np.array({"Y": [0, 0], "Z": [90, 0], "-Y": [180, 0], "X": [0, -90]}[up]) * np.pi / 180
    )
    motion = walker()
    names = dict.fromkeys(SKELETON.names, turn)
    other = moved(resting(motion, names), turn, np.zeros(3))
    offsets = rotation.rotate(turn, SKELETON.offsets)
    assert np.allclose(other.skeleton.offsets[1:], offsets[1:])
    if lying:
        other = moved(other, rotation.about_axis(2 if up == "X" else 0, np.pi / 2), np.zeros(3))
    fit = fit_skeletons(RestPose.of(SKELETON), RestPose.of(other.skeleton), EVERY)
    found = upright_turn(fit, motion.rotations[:, 0], global_poses(other).rotations[:, 0])
    expected = rotation.identity() if lying else rotation.conjugate(turn)
    np.testing.assert_allclose(
        rotation.rotate(found, rotation.rotate(turn, [0.0, 1.0, 0.0])),
        rotation.rotate(rotation.multiply(expected, turn), [0.0, 1.0, 0.0]),
        atol=1e-9,
    )


def test_a_clip_with_no_upright_says_nothing_about_what_is_up() -> None:
    motion = walker()
    tumbling = rotation.about_axis(0, np.linspace(0, 2 * np.pi, 80, endpoint=False))
    fit = fit_skeletons(RestPose.of(SKELETON), RestPose.of(SKELETON), EVERY)
    assert upright_turn(fit, tumbling, motion.rotations[:, 0]).tolist() == [1, 0, 0, 0]
