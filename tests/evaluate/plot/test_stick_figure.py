from fractions import Fraction

import numpy as np
import pytest

import retime
from retime.evaluate.plot.stick_figure import sides_of, view_of
from retime.motion.motion import Motion
from retime.motion.rotation import from_euler, identity
from retime.motion.skeleton import EndSite, Skeleton
from tests.motion.test_body import below_node


def named(*names: str) -> Skeleton:
    return Skeleton(names, (-1, *[0] * (len(names) - 1)), np.zeros((len(names), 3)))


@pytest.mark.parametrize(
    ("left", "right", "middle"),
    [
        ("LeftUpLeg", "RightUpLeg", "LowerBack"),
        ("lfemur", "rfemur", "lowerback"),
        ("hand_l", "hand_r", "spine_l_1"),
        ("Thigh.L", "Thigh.R", "Pelvis"),
        ("Bip01 L Thigh", "Bip01 R Thigh", "Bip01 Pelvis"),
        ("mixamorig:LeftFoot", "mixamorig:RightFoot", "mixamorig:Hips"),
        ("rig:lFoot", "rig:rFoot", "rig:lid"),
        ("ShldrL", "ShldrR", "Tail"),
    ],
)
def test_left_is_what_has_a_mirror_image_on_the_right(left: str, right: str, middle: str) -> None:
    assert sides_of(named("root", left, right, middle)) == ("", "left", "right", "")


def test_a_joint_without_a_mirror_image_is_on_its_parents_side() -> None:
    skeleton = Skeleton(("Hips", "LeftArm", "RightArm", "Watch"), (-1, 0, 0, 1), np.zeros((4, 3)))
    assert sides_of(skeleton) == ("", "left", "right", "left")


def walker(turns: np.ndarray) -> Motion:
    """A figure that faces +Z at turn 0, with feet that point forward; turned about the vertical axis by each angle."""
    skeleton = Skeleton(
        ("Hips", "LeftLeg", "LeftToe", "RightLeg", "RightToe", "Head"),
        (-1, 0, 1, 0, 3, 0),
        np.array([[0, 1, 0], [0.1, 0, 0], [0, -1, 0.2], [-0.1, 0, 0], [0, -1, 0.2], [0, 0.6, 0.0]]),
        (EndSite(5, (0.0, 0.2, 0.0)),),
    )
    rotations = identity(len(turns), 6)
    rotations[:, 0] = from_euler("Y", turns[:, None])
    return Motion(skeleton, rotations, None, Fraction(30))


@pytest.mark.parametrize("facing", [0.0, np.pi / 2, np.pi, -2.0])
def test_the_figure_faces_along_the_time_axis_whichever_way_it_goes(facing: float) -> None:
    motion = walker(np.full(40, facing))
    nodes = view_of(motion).project(motion, np.array([0.5]))[0]
    left_toe, right_toe = nodes[2, 0], nodes[4, 0]
    assert min(left_toe, right_toe) > 0
    # The camera stands a little before the right side, so the left foot, behind, appears to the right of the near one.
    assert left_toe > right_toe


def test_the_camera_keeps_up_with_a_turn_but_not_with_the_sway_of_a_step() -> None:
    time = np.arange(300) / 30
    around = walker(time * 0.8)
    view = view_of(around)
    toes = view.project(around, time)[:, [2, 4], 0]
    assert toes.min() > 0

    swaying = walker(0.15 * np.sin(2 * np.pi * time))
    angles = np.arctan2(*view_of(swaying).across[60:-60].T)
    assert np.ptp(angles) < 0.03


def test_heights_are_kept_and_ground_positions_removed() -> None:
    motion = walker(np.zeros(60))
    moved = motion.local_translations.copy()
    moved[:, 0, 0] += np.linspace(0, 9, 60)
    moved[30, 0, 1] += 0.5
    motion = Motion(motion.skeleton, motion.rotations, moved, motion.rate)
    nodes = view_of(motion).project(motion, np.array([0.0, 1.0]))
    np.testing.assert_allclose(nodes[:, 0, 0], 0.0, atol=1e-12)
    stature = 1.8
    np.testing.assert_allclose(nodes[1, :, 1] - nodes[0, :, 1], 0.5 / stature)
    np.testing.assert_allclose(nodes[0, [2, 4], 1], 0.0, atol=1e-12)


def test_every_visible_joint_is_on_a_chain_of_its_side() -> None:
    motion = walker(np.zeros(3))
    chains = view_of(motion).chains
    assert {node for chain in chains for node in chain.nodes} == {0, 1, 2, 3, 4, 5}
    assert [chain.side for chain in chains] == ["left", "", "right"]


def test_fingers_are_left_out() -> None:
    skeleton = Skeleton(
        ("root", "hand", "Index1", "Index2", "LeftThumb"),
        (-1, 0, 1, 2, 1),
        np.ones((5, 3)),
        (EndSite(3, (1.0, 0.0, 0.0)), EndSite(1, (0.0, 1.0, 0.0))),
    )
    chains = view_of(Motion(skeleton, identity(2, 5))).chains
    assert {node for chain in chains for node in chain.nodes} == {0, 1, 6}


def test_a_lone_joint_and_a_figure_of_no_height_have_a_view() -> None:
    motion = Motion(named("dot"), identity(4, 1))
    view = view_of(motion)
    assert view.head == 0
    assert view.chains == ()
    assert np.isfinite(view.project(motion, np.array([0.0]))).all()


def test_a_deep_skeleton_does_not_recurse() -> None:
    n_joints = 4000
    skeleton = Skeleton(
        tuple(f"j{i}" for i in range(n_joints)), tuple(range(-1, n_joints - 1)), np.full((n_joints, 3), 0.001)
    )
    view = view_of(Motion(skeleton, identity(1, n_joints)))
    assert [len(chain.nodes) for chain in view.chains] == [n_joints]


def test_nodes_above_the_body_are_not_drawn() -> None:
    clip = retime.sample().frames(300, 360)
    more = below_node(clip, props=("prop",))
    one, other = view_of(clip), view_of(more)
    assert (other.stature, other.ground, other.chains) == (one.stature, one.ground, one.chains)
    times = np.array([0.0, 0.3])
    np.testing.assert_array_equal(other.project(more, times), one.project(clip, times))
