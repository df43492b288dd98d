"""What stands above a body in a file is no part of it: nothing that is found or searched changes with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

import retime
from retime.arrays import FloatArray
from retime.errors import OptionError
from retime.motion import rotation
from retime.motion.body import above_body, body_joint, body_joints, body_of
from retime.motion.contacts import contacts
from retime.motion.kinematics import global_poses, heading_rotations, metres_per_unit, seems_z_up
from retime.motion.motion import Motion
from retime.motion.skeleton import EndSite, Skeleton
from tests.motion.walkers import permuted, walker
from tests.warp.rigs import orders


def below_node(
    motion: Motion,
    name: str = "Reference",
    turns: FloatArray | None = None,
    places: FloatArray | None = None,
    props: Sequence[str] = (),
) -> Motion:
    """Put a node above all joints, with props beside them; global poses stay as they were."""
    n, skeleton = motion.n_frames, motion.skeleton
    q = np.broadcast_to(rotation.identity(n) if turns is None else turns, (n, 4))
    p = np.broadcast_to(np.zeros(3) if places is None else places, (n, 3))
    names = (name, *skeleton.names, *props)
    parents = (-1, *(parent + 1 for parent in skeleton.parents), *(0 for _ in props))
    offsets = np.concatenate([np.zeros((1, 3)), skeleton.offsets, np.zeros((len(props), 3))])
    sites = tuple(replace(site, parent=site.parent + 1) for site in skeleton.end_sites)
    rotations, translations = motion.rotations.copy(), motion.local_translations.copy()
    if turns is not None or places is not None:
        back = rotation.conjugate(q)
        rotations[:, 0] = rotation.multiply(back, rotations[:, 0])
        translations[:, 0] = rotation.rotate(back, translations[:, 0] - p)
    still = np.zeros((n, len(props), 3))
    return replace(
        motion,
        skeleton=Skeleton(names, parents, offsets, sites),
        rotations=np.concatenate([q[:, None], rotations, rotation.identity(n, len(props))], axis=1),
        translations=np.concatenate([p[:, None], translations, still], axis=1),
        declaration=None,
        declared_angles=None,
    )


@pytest.fixture(scope="module")
def clip() -> Motion:
    """A stretch of the sample with its first jump."""
    return retime.sample().frames(300, 460)


def facts(motion: Motion) -> tuple[object, ...]:
    body = body_joints(motion)
    feet = contacts(motion)
    return (
        motion.flights(),
        seems_z_up(motion),
        metres_per_unit(motion),
        [body.index(foot.joint) for foot in feet.feet],
        feet.at_rest.tolist(),
        retime.guided_warp(motion, length="65%").warp.output_times.tolist(),
    )


class TestNodesAbove:
    @pytest.mark.parametrize("nodes", [("Reference",), ("Scene", "joint_Root"), ("a", "b", "c")])
    def test_nodes_that_stay_at_the_origin_change_nothing(self, clip: Motion, nodes: tuple[str, ...]) -> None:
        motion = clip
        for name in nodes:
            motion = below_node(motion, name)
        assert body_joint(motion) == len(nodes)
        assert above_body(motion) == list(range(len(nodes) + 1))
        assert facts(motion) == facts(clip)
        assert len(clip.flights()) == 1

    def test_a_reference_with_a_node_is_the_reference_without(self, clip: Motion) -> None:
        other, more = clip.frames(20, 150), below_node(clip)
        wanted = retime.guided_warp(clip, reference=other, length="100%").warp
        for motion, reference in ((more, other), (clip, below_node(other)), (more, below_node(other))):
            found = retime.guided_warp(motion, reference=reference, length="100%").warp
            np.testing.assert_array_equal(found.input_times, wanted.input_times)
            np.testing.assert_array_equal(found.output_times, wanted.output_times)

    def test_props_beside_the_body_are_no_part_of_it(self, clip: Motion) -> None:
        assert facts(below_node(clip, "root", props=("ik_foot_root", "weapon"))) == facts(clip)

    def test_a_node_may_stand_elsewhere_and_be_turned(self, clip: Motion) -> None:
        # An armature of a program with Z up.
        quarter = rotation.from_euler("X", np.array([-np.pi / 2]))
        motion = below_node(clip, "Armature", quarter, np.array([3.0, -40.0, 7.0]))
        assert motion.skeleton.names[body_joint(motion)] == clip.skeleton.names[0]
        np.testing.assert_allclose(body_of(motion).positions, clip.positions, atol=1e-9)
        assert motion.flights() == clip.flights()
        assert not seems_z_up(motion)
        assert metres_per_unit(motion) == metres_per_unit(clip)

    def test_the_path_over_the_ground_is_not_the_body(self, clip: Motion) -> None:
        # As game engines write it: the root slides below the pelvis and turns with it.
        places = clip.positions[:, 0] * [1.0, 0.0, 1.0]
        turns = rotation.from_euler("Y", np.linspace(0, 1, clip.n_frames)[:, None])
        motion = below_node(clip, "root", turns, places, props=("ik_hand_gun",))
        assert motion.skeleton.names[body_joint(motion)] == clip.skeleton.names[0]
        assert motion.flights() == clip.flights()
        np.testing.assert_allclose(body_of(motion).positions, clip.positions, atol=1e-9)

    @pytest.mark.parametrize("props", [(), ("ik_foot_root", "ik_hand_root")])
    @pytest.mark.parametrize("share", [[0, 1, 0], [1, 0, 1], [1, 0.5, 1], [0.2, 1, 0.7]])
    def test_a_path_that_has_some_of_the_place_is_not_the_body(
        self, clip: Motion, share: list[float], props: tuple[str, ...]
    ) -> None:
        motion = below_node(clip, "path", None, clip.positions[:, 0] * share, props)
        assert facts(motion) == facts(clip)

    @pytest.mark.parametrize(
        ("share", "turns"),
        [([0, 1, 0], False), ([0, 1, 0], True), ([1, 0, 1], False), ([1, 0, 1], True), ([1, 1, 1], False)],
    )
    def test_a_path_below_nodes_that_stay_put_is_not_the_body(
        self, clip: Motion, share: list[float], turns: bool
    ) -> None:
        heading = heading_rotations(global_poses(clip)) if turns else None
        motion = below_node(below_node(clip, "path", heading, clip.positions[:, 0] * share), "Armature")
        assert motion.skeleton.names[body_joint(motion)] == clip.skeleton.names[0]
        assert motion.flights() == clip.flights()
        assert not seems_z_up(motion)
        np.testing.assert_allclose(body_of(motion).positions, clip.positions, atol=1e-9)

    def test_one_node_for_the_ground_and_one_for_the_height(self, clip: Motion) -> None:
        place = clip.positions[:, 0]
        motion = below_node(below_node(clip, "height", None, place * [0, 1, 0]), "ground", None, place * [1, 0, 1])
        assert body_joint(motion) == 2
        assert facts(motion) == facts(clip)

    def test_a_path_in_a_file_with_z_up(self, clip: Motion) -> None:
        quarter = rotation.from_euler("X", np.array([np.pi / 2]))
        rotations, places = clip.rotations.copy(), clip.local_translations.copy()
        rotations[:, 0] = rotation.multiply(quarter, rotations[:, 0])
        places[:, 0] = rotation.rotate(quarter, places[:, 0])
        lying = replace(clip, rotations=rotations, translations=places, declaration=None, declared_angles=None)
        assert seems_z_up(lying)
        about_z = heading_rotations(global_poses(clip))[:, [0, 1, 3, 2]]
        for turns, share in ((None, [0, 0, 1]), (None, [1, 1, 1]), (about_z, [1, 1, 0])):
            motion = below_node(lying, "path", turns, places[:, 0] * share)
            assert motion.skeleton.names[body_joint(motion)] == clip.skeleton.names[0]
            assert seems_z_up(motion)
            assert replace(motion, up="z").flights() == clip.flights()

    @pytest.mark.parametrize("seed", range(3))
    def test_any_rig_below_any_nodes(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        motion = walker(int(rng.integers(40, 70)))
        wanted = retime.guided_warp(motion, length="80%").warp
        more = motion
        for _ in range(int(rng.integers(1, 4))):
            more = below_node(more, f"n{rng.integers(1000)}", props=("p", "q")[: int(rng.integers(3))])
        found = retime.guided_warp(more, length="80%").warp
        assert body_joint(more) > 0
        np.testing.assert_array_equal(found.input_times, wanted.input_times)
        np.testing.assert_array_equal(found.output_times, wanted.output_times)


class TestWhatIsTheBody:
    def test_a_figure_carries_itself(self, clip: Motion) -> None:
        assert body_joint(clip) == 0
        assert body_of(clip) is clip

    def test_hips_that_stay_put_keep_the_legs(self) -> None:
        # A figure that sits: hips and legs don't move, the spine turns.
        skeleton = Skeleton(
            ("Hips", "Spine", "Head", "LeftLeg", "RightLeg"), (-1, 0, 1, 0, 0), np.eye(5, 3), (EndSite(2, (0, 1, 0)),)
        )
        q = rotation.identity(20, 5)
        q[:, 1] = rotation.about_axis(0, np.linspace(0, 1, 20))
        assert body_joint(Motion(skeleton, q)) == 0

    @pytest.mark.parametrize("less", [[0, 0, 0], [1, 0, 1], [0, 1, 0], [1, 1, 1]])
    def test_joints_that_are_told_by_places_alone_keep_their_legs(self, clip: Motion, less: list[int]) -> None:
        # No joint ever turns: all of them move in their parents, about hips that may stay at the origin or on a level.
        parents = list(clip.skeleton.parents)
        places = clip.positions - clip.positions[:, :1] * less
        places[:, 1:] -= places[:, parents[1:]]
        skeleton = replace(clip.skeleton, end_sites=())
        assert body_joint(Motion(skeleton, rotation.identity(*places.shape[:2]), places, clip.rate)) == 0

    def test_a_chain_that_is_told_by_places_alone_keeps_its_joints(self) -> None:
        arm = Skeleton(("shoulder", "elbow", "wrist", "hand"), (-1, 0, 1, 2), np.eye(4, 3))
        angles = np.sin(np.arange(50)[:, None] / 7 + np.arange(4))
        places = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=-1)
        places[:, 0] = np.arange(50)[:, None] * [0.1, 0.02, 0.0]
        assert body_joint(Motion(arm, rotation.identity(50, 4), places)) == 0

    def test_a_chain_that_winds_on_a_level_keeps_its_joints(self) -> None:
        chain = Skeleton(tuple("abcdef"), (-1, 0, 1, 2, 3, 4), np.ones((6, 3)))
        angles = np.sin(np.arange(60)[:, None] / 5 + np.arange(6))
        places = np.tile(chain.offsets, (60, 1, 1))
        places[:, 0, 0] = np.arange(60) * 0.1
        assert body_joint(Motion(chain, rotation.from_euler("Y", angles[..., None]), places)) == 0
        # Its first joint may not turn at all.
        angles[:, 0] = 0.0
        assert body_joint(Motion(chain, rotation.from_euler("Y", angles[..., None]), places)) == 0

    def test_where_nothing_moves_the_root_is_as_good_as_any(self) -> None:
        chain = Skeleton(("a", "b", "c"), (-1, 0, 1), np.eye(3))
        assert body_joint(Motion(chain, rotation.identity(20, 3))) == 0

    def test_a_stretch_in_which_nothing_moves_keeps_the_body(self, clip: Motion) -> None:
        motion = below_node(clip)
        assert body_joint(motion.frames(10, 11)) == 1

    @pytest.mark.parametrize("seed", range(3))
    def test_neither_names_nor_order_count(self, clip: Motion, seed: int) -> None:
        motion = below_node(clip, "Hips", props=("a", "b"))
        order = orders(motion.skeleton, seed)
        other = permuted(motion, order)
        assert order[body_joint(other)] == 1

    def test_a_lone_prop_below_a_node(self) -> None:
        skeleton = Skeleton(("Scene", "Camera"), (-1, 0), np.zeros((2, 3)))
        p = np.zeros((20, 2, 3))
        p[:, 1, 0] = np.arange(20)
        motion = Motion(skeleton, rotation.identity(20, 2), p)
        assert body_joint(motion) == 1
        assert body_of(motion).skeleton.names == ("Camera",)

    def test_rounding_in_a_file_is_no_movement(self, clip: Motion) -> None:
        jitter = np.random.default_rng(1).uniform(-1e-6, 1e-6, (clip.n_frames, 3))
        assert body_joint(below_node(clip, places=jitter)) == 1

    def test_a_person_names_it(self, clip: Motion) -> None:
        named = replace(below_node(clip), root="Reference")
        assert body_joint(named) == 0
        spine = clip.skeleton.children(0)[0]
        other = replace(clip, root=clip.skeleton.names[spine])
        assert body_of(other).skeleton.names[0] == clip.skeleton.names[spine]
        np.testing.assert_allclose(
            body_of(other).positions, clip.positions[:, body_joints(other)], atol=1e-9 * np.abs(clip.positions).max()
        )
        with pytest.raises(OptionError, match=r"no joint of .* is called 'Hip'"):
            replace(clip, root="Hip")

    def test_end_sites_come_along(self) -> None:
        motion = below_node(walker(30), turns=rotation.from_euler("Z", np.array([0.4])))
        whole, body = global_poses(motion), global_poses(body_of(motion))
        np.testing.assert_allclose(body.end_positions, whole.end_positions, atol=1e-9)
        np.testing.assert_allclose(body.rotations, whole.rotations[:, body_joints(motion)], atol=1e-9)
