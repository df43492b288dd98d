"""Forward kinematics against one matrix a joint, and the spaces that features live in."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import retime
from retime.motion import kinematics, rotation
from retime.motion.contacts import contacts
from retime.motion.flights import flights
from retime.motion.kinematics import (
    forget_poses,
    global_poses,
    heading_positions,
    heading_rotations,
    limb_places,
    metres_per_unit,
    torso_positions,
)
from retime.motion.motion import Motion
from retime.motion.skeleton import EndSite, Skeleton
from tests.motion.strategies import motions, quaternions, vectors
from tests.reference.kinematics import end_position, global_matrix


def moved(motion: Motion, turn: np.ndarray, shift: np.ndarray) -> Motion:
    """Move a whole motion in space: turn it about the origin, then shift it."""
    rotations, translations = motion.rotations.copy(), motion.local_translations.copy()
    rotations[:, 0] = rotation.multiply(turn, rotations[:, 0])
    translations[:, 0] = rotation.rotate(turn, translations[:, 0]) + shift
    return Motion(motion.skeleton, rotations, translations, motion.rate)


class TestGlobalPoses:
    @given(motions())
    def test_agree_with_a_matrix_for_each_joint(self, motion: Motion) -> None:
        poses = global_poses(motion)
        for frame in range(motion.n_frames):
            for joint in range(motion.skeleton.n_joints):
                matrix = global_matrix(motion, frame, joint)
                np.testing.assert_allclose(poses.positions[frame, joint], matrix[:3, 3], atol=1e-10)
                turned = rotation.to_matrix(poses.rotations[frame, joint])
                np.testing.assert_allclose(turned, matrix[:3, :3], atol=1e-12)
            for site in range(len(motion.skeleton.end_sites)):
                np.testing.assert_allclose(
                    poses.end_positions[frame, site], end_position(motion, frame, site), atol=1e-10
                )

    @given(motions())
    def test_shapes_are_those_promised(self, motion: Motion) -> None:
        poses, skeleton = global_poses(motion), motion.skeleton
        assert poses.positions.shape == (motion.n_frames, skeleton.n_joints, 3)
        assert poses.rotations.shape == (motion.n_frames, skeleton.n_joints, 4)
        assert poses.end_positions.shape == (motion.n_frames, len(skeleton.end_sites), 3)

    @given(motions(), st.data())
    def test_points_alone_are_where_the_whole_body_has_them(self, motion: Motion, data: st.DataObject) -> None:
        # A copy, whose poses nobody knows yet.
        again = motion.with_rate(motion.rate)
        sites = [(site.parent, i) for i, site in enumerate(motion.skeleton.end_sites)]
        joints = [(joint, None) for joint in range(motion.skeleton.n_joints)]
        points = data.draw(st.lists(st.sampled_from([*joints, *sites]), max_size=4))
        places = limb_places(again, points)
        poses = global_poses(motion)
        for i, (joint, site) in enumerate(points):
            expected = poses.positions[:, joint] if site is None else poses.end_positions[:, site]
            np.testing.assert_array_equal(places[:, i], expected)
        np.testing.assert_array_equal(limb_places(motion, points), places)

    def test_a_chain_as_deep_as_any_file_may_be(self) -> None:
        # 1 degree a joint: the chain closes to a regular polygon after 360 joints.
        n_joints = 361
        offsets = np.vstack([np.zeros(3), np.tile([1.0, 0, 0], (n_joints - 1, 1))])
        chain = Skeleton(tuple(f"j{i}" for i in range(n_joints)), (-1, *range(n_joints - 1)), offsets)
        poses = global_poses(Motion(chain, rotation.about_axis(2, np.full((1, n_joints), np.radians(1)))))
        np.testing.assert_allclose(poses.positions[0, -1], 0.0, atol=1e-11)
        across = np.linalg.norm(poses.positions[0, 180] - poses.positions[0, 0])
        assert across == pytest.approx(1 / np.sin(np.radians(0.5)))

    def test_without_rotations_a_pose_is_the_sum_of_its_offsets(self) -> None:
        body = Skeleton(
            ("a", "b", "c"), (-1, 0, 0), np.array([[1.0, 2, 3], [4, 5, 6], [7, 8, 9]]), (EndSite(1, (1, 1, 1)),)
        )
        poses = global_poses(Motion(body, rotation.identity(1, 3)))
        assert poses.positions[0].tolist() == [[1, 2, 3], [5, 7, 9], [8, 10, 12]]
        assert poses.end_positions[0].tolist() == [[6, 8, 10]]


class TestSpaces:
    @given(motions(), quaternions(), vectors())
    def test_torso_space_does_not_know_where_the_body_is(self, motion: Motion, turn, shift) -> None:
        here, there = torso_positions(global_poses(motion)), torso_positions(global_poses(moved(motion, turn, shift)))
        assert here.shape == (motion.n_frames, motion.skeleton.n_joints - 1, 3)
        np.testing.assert_allclose(here, there, atol=1e-10)

    @given(motions())
    def test_torso_space_is_what_a_still_root_sees(self, motion: Motion) -> None:
        rotations, translations = motion.rotations.copy(), motion.local_translations.copy()
        rotations[:, 0], translations[:, 0] = [1, 0, 0, 0], 0.0
        still = global_poses(Motion(motion.skeleton, rotations, translations, motion.rate))
        np.testing.assert_allclose(torso_positions(global_poses(motion)), still.positions[:, 1:], atol=1e-10)

    @given(motions(), st.floats(-7, 7), st.floats(-100, 100), st.floats(-100, 100))
    def test_heading_space_does_not_know_the_ground_place_nor_the_turn(self, motion, angle, x, z) -> None:
        elsewhere = moved(motion, rotation.about_axis(1, angle), np.array([x, 0.0, z]))
        here, there = heading_positions(global_poses(motion)), heading_positions(global_poses(elsewhere))
        # A root within a rounding error of upside down has no heading to speak of.
        upright = np.hypot(motion.rotations[:, 0, 0], motion.rotations[:, 0, 2]) > 1e-3
        np.testing.assert_allclose(here[upright], there[upright], atol=1e-7)

    @given(motions(), st.floats(-100, 100))
    def test_heading_space_keeps_the_height(self, motion: Motion, y: float) -> None:
        poses = global_poses(moved(motion, rotation.identity(), np.array([0.0, y, 0.0])))
        np.testing.assert_allclose(heading_positions(poses)[..., 1], poses.positions[..., 1], atol=1e-10)

    @given(st.floats(-3, 3), st.floats(-1.5, 1.5), st.floats(-np.pi, np.pi))
    def test_heading_is_the_turn_about_the_vertical_and_tilt_is_kept(self, turn, tilt, around) -> None:
        # A tilt about any level axis, then a turn.
        axis = Rotation.from_rotvec([tilt * np.cos(around), 0, tilt * np.sin(around)]).as_quat(scalar_first=True)
        root = rotation.multiply(rotation.about_axis(1, turn), axis)
        body = Skeleton(("hip", "head"), (-1, 0), np.array([[0.0, 0, 0], [0, 1, 0]]))
        poses = global_poses(Motion(body, np.stack([root, [1, 0, 0, 0]])[None]))
        np.testing.assert_allclose(
            rotation.to_matrix(heading_rotations(poses)[0]), rotation.to_matrix(rotation.about_axis(1, turn)), atol=1e-9
        )
        np.testing.assert_allclose(heading_positions(poses)[0, 1], rotation.rotate(axis, [0, 1, 0]), atol=1e-9)

    @pytest.mark.parametrize("flip", [[0, 1, 0, 0], [0, 0, 0, 1], [0, 0.6, 0, 0.8], [1e-12, 1, 0, 0]])
    def test_a_root_on_its_head_has_no_heading_and_keeps_the_identity(self, flip) -> None:
        poses = global_poses(Motion(Skeleton(("hip",), (-1,), np.zeros((1, 3))), np.array([[flip]])))
        assert heading_rotations(poses).tolist() == [[1, 0, 0, 0]]


class TestSize:
    def body(self, **changes) -> Motion:
        offsets = np.array([[0.0, 0, 0], [0, 60, 0], [0, -80, 0]])
        body = Skeleton(
            ("hip", "head", "foot"), (-1, 0, 0), offsets, (EndSite(1, (0, 20, 0)), EndSite(2, (10, -10, 0)))
        )
        return Motion(body, rotation.identity(1, 3), **changes)

    def test_the_files_word_is_taken(self) -> None:
        assert metres_per_unit(self.body(metres_per_unit=0.0254)) == 0.0254

    def test_else_the_body_is_taken_for_a_person(self) -> None:
        assert metres_per_unit(self.body()) == pytest.approx(1.7 / 170)

    def test_where_the_root_stands_does_not_matter(self) -> None:
        body = self.body().skeleton
        offsets = body.offsets + np.array([[0, 5000, 0], [0, 0, 0], [0, 0, 0]])
        far = Motion(Skeleton(body.names, body.parents, offsets, body.end_sites), rotation.identity(1, 3))
        assert metres_per_unit(far) == pytest.approx(0.01)

    def test_a_body_of_no_size_is_measured_in_metres(self) -> None:
        assert metres_per_unit(Motion(Skeleton(("hip",), (-1,), np.ones((1, 3))), rotation.identity(1, 1))) == 1.0


@given(motion=motions())
def test_long_takes_have_the_same_places_and_keep_none(motion: Motion) -> None:
    known = global_poses(motion)
    standing, flying = contacts(motion), flights(motion)
    # The same motion, taken for a long one, and posed in pieces.
    other = motion.with_rate(motion.rate)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kinematics, "_MOST_KEPT", 0)
        patch.setattr(kinematics, "_FRAMES", 3)
        places = kinematics.global_places(other)
        assert places.positions.tobytes() == known.positions.tobytes()
        assert places.end_positions.tobytes() == known.end_positions.tobytes()
        # Whoever asks while somebody has them gets these.
        assert kinematics.global_places(other) is places
        assert global_poses(other).rotations.tobytes() == known.rotations.tobytes()
        assert global_poses(other) is not global_poses(other)
        assert np.array_equal(contacts(other).at_rest, standing.at_rest)
        assert flights(other) == flying
        del places
        assert kinematics._HELD[other]() is None


def test_poses_that_are_let_go_are_found_again() -> None:
    motion = retime.sample()
    before = global_poses(motion)
    assert global_poses(motion) is before
    forget_poses(motion)
    again = global_poses(motion)
    assert again is not before
    np.testing.assert_array_equal(again.positions, before.positions)
    forget_poses(motion)
    forget_poses(motion)
