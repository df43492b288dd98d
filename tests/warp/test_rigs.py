"""Skeletons as files have them: joints in any order, in any tree, with feet anywhere."""

from __future__ import annotations

import warnings
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from retime.errors import RetimeWarning
from retime.motion import rotation
from retime.motion.body import body_joints
from retime.motion.contacts import Contacts, Foot, contacts
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton
from retime.search.guided import guided_warp
from retime.search.poses.references import Reference
from retime.search.result import GuidedWarp
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp, output_frame_times
from retime.warp.slip import retimed_slip
from tests.motion.walkers import built, moved, permuted, renamed, walker
from tests.reference import contacts as literal
from tests.reference.averaging import averaged_pose
from tests.warp.motions import wandering_motion
from tests.warp.rigs import contacts_of, moving_rigs, orders, stretches, warps_of


def assert_is_the_definition(result: Motion, motion: Motion, warp: Warp, standing: Contacts | None, **how) -> None:
    times = output_frame_times(warp, float(motion.rate))
    assert result.n_frames == len(times)
    found = global_poses(result).rotations
    for frame, time in enumerate(times.tolist()):
        turns, translations = averaged_pose(motion, warp, time, standing, **how)
        wanted = Rotation.concatenate(turns)
        apart = (Rotation.from_quat(found[frame], scalar_first=True).inv() * wanted).magnitude()
        assert apart.max() < 1e-7
        np.testing.assert_allclose(result.local_translations[frame], translations, rtol=0, atol=1e-9)


# Name, parent. Feet are not the last joints, as in rigs with toe tips or twist bones.
RIG = {"Hips": "", "Spine": "Hips", "Hand": "Spine", "Leg": "Hips", "Foot": "Leg", "Toe": "Foot", "Tip": "Toe"}


@pytest.mark.parametrize(
    "order",
    [
        pytest.param("Hips Leg Foot Toe Tip Spine Hand", id="leg_first"),
        pytest.param("Hips Spine Hand Leg Foot Toe Tip", id="spine_first"),
        pytest.param("Hips Spine Leg Hand Foot Toe Tip", id="mixed"),
        pytest.param("Hips Leg Foot Spine Toe Tip Hand", id="spine_between_feet"),
    ],
)
def test_joints_below_a_foot_may_come_before_or_after_the_rest(order: str) -> None:
    names = order.split()
    parents = tuple(names.index(RIG[name]) if RIG[name] else -1 for name in names)
    rng = np.random.default_rng(3)
    turns = np.concatenate([wandering_motion(30, 30, seed).rotations for seed in (1, 2)], axis=1)
    skeleton = Skeleton(tuple(names), parents, rng.normal(0, 0.3, (7, 3)))
    motion = Motion(skeleton, turns[:, :7])
    # The heel leaves the ground before the toes do.
    at_rest = np.repeat([[True, True], [False, True], [False, False], [True, True]], (8, 5, 9, 8), axis=0)
    standing = Contacts((Foot(names.index("Foot")), Foot(names.index("Toe"))), at_rest, motion.rate)
    warp = Warp([0.0, 0.3, 0.5], [0.0, 0.6, motion.end_time])
    assert_is_the_definition(apply_warp(motion, warp, contacts=standing), motion, warp, standing)


@settings(max_examples=60)
@given(st.data())
def test_any_rig_is_averaged_as_defined(data: st.DataObject) -> None:
    motion = data.draw(moving_rigs())
    warp, standing = data.draw(warps_of(motion)), data.draw(contacts_of(motion))
    result = apply_warp(motion, warp, contacts=standing)
    assert_is_the_definition(result, motion, warp, standing)


@settings(max_examples=50)
@given(st.data())
def test_any_rig_is_averaged_as_in_the_paper(data: st.DataObject) -> None:
    motion = data.draw(moving_rigs())
    warp = data.draw(warps_of(motion))
    result = apply_warp(motion, warp, contacts=None, keep_root_path=False)
    assert_is_the_definition(result, motion, warp, None, keep_root_path=False)


@settings(max_examples=80)
@given(st.data())
def test_the_slip_of_any_rig_is_measured_as_defined(data: st.DataObject) -> None:
    motion = data.draw(moving_rigs())
    warp, standing = data.draw(warps_of(motion)), data.draw(contacts_of(motion))
    report = retimed_slip(motion, warp, contacts=standing)
    scale = metres_per_unit(motion)
    # A billionth of a frame beside a frame is that frame.
    places = np.round(warp(output_frame_times(warp, float(motion.rate))) * float(motion.rate), 9)
    outputs = (
        (report.unaveraged, apply_warp(motion, warp, average=False)),
        (report.plain, apply_warp(motion, warp, contacts=None, keep_root_path=False)),
        (report.contact_aware, apply_warp(motion, warp, contacts=standing)),
    )
    # A foot that rolls slips by none of that.
    held = standing.where_held().at_rest.T.tolist()
    for foot, (point, column) in enumerate(zip(standing.feet, held, strict=True)):
        wanted = [(first, last) for _, first, last in literal.shown(column, places.tolist())]
        for found, output in outputs:
            here = [i for i, span in enumerate(found.contacts) if span.foot == foot]
            assert [(found.contacts[i].first_frame, found.contacts[i].last_frame) for i in here] == wanted
            for i, (first, last) in zip(here, wanted, strict=True):
                slid = literal.slip(output, (point.joint, point.end_site), scale, first, last)
                assert found.millimetres[i] == pytest.approx(slid, abs=1e-6)


def written_otherwise(motion: Motion, seed: int, *, names: bool) -> tuple[Motion, list[int]]:
    """The same motion with its joints in another order, and with names that say nothing; and where each one went."""
    order = orders(motion.skeleton, seed)
    other = permuted(motion, order)
    if names:
        # In an order of their own.
        said = [f"bone {n}" for n in np.random.default_rng(seed).permutation(len(order)).tolist()]
        other = replace(other, skeleton=replace(other.skeleton, names=tuple(said)))
    return other, order


def moved_contacts(standing: Contacts, order: list[int]) -> Contacts:
    feet = [replace(foot, joint=order.index(foot.joint)) for foot in standing.feet]
    # In another order too.
    held = standing.where_held().at_rest
    return Contacts(tuple(feet[::-1]), standing.at_rest[:, ::-1], standing.rate, held[:, ::-1])


def assert_same_motion(found: Motion, order: list[int], wanted: Motion) -> None:
    turns = np.sum(found.rotations * wanted.rotations[:, order], axis=-1, keepdims=True)
    apart = found.rotations * np.sign(turns) - wanted.rotations[:, order]
    np.testing.assert_allclose(apart, 0.0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.local_translations, wanted.local_translations[:, order], rtol=0, atol=1e-9)


def guided_and_told(motion: Motion, options: dict[str, str]) -> tuple[GuidedWarp, list[str]]:
    """A warp, and what was warned of on the way: a rig may stand all the time, jump at first, or both."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always", RetimeWarning)
        found = guided_warp(motion, **options)
    return found, [str(one.message) for one in told]


def test_a_rig_that_only_turns_once_as_a_whole_is_told_of_its_jump_and_of_its_sameness() -> None:
    """Seen from itself nothing changes: two warnings, which in another order of joints are the same."""
    still = walker(1)
    q = np.repeat(still.rotations, 24, axis=0)
    q[1:, 0] = rotation.multiply(rotation.from_euler("Y", np.array([[1.0]])), q[1:, 0])
    root = Skeleton(still.skeleton.names[:1], (-1,), still.skeleton.offsets[:1])
    other = replace(root, names=("bone 0",))
    options = {"length": "60%", "features": "heading"}
    told = [guided_and_told(Motion(one, q[:, :1], None, 30, name="rig"), options)[1] for one in (root, other)]
    assert told[0] == told[1]
    assert [words.partition(",")[0] for words in told[0]] == [
        "rig: the first frame is probably no part of the movement (a T-pose in front of it?): then the pose jumps by "
        "57 degrees",
        "rig: nothing changes in what the search looks at",
    ]


@settings(max_examples=60)
@given(st.data())
def test_order_and_names_change_no_warp(data: st.DataObject) -> None:
    motion = data.draw(moving_rigs((14, 24, 40)))
    other, order = written_otherwise(motion, data.draw(st.integers(0, 999)), names=data.draw(st.booleans()))
    # Feet are known by their names where these tell, and what flies is told by the feet.
    assume({foot.joint for foot in contacts(motion).feet} == {order[foot.joint] for foot in contacts(other).feet})
    options = {
        "length": data.draw(st.sampled_from(["60%", "100%", "150%"])),
        "features": data.draw(st.sampled_from(["heading", "torso"] if len(body_joints(motion)) > 1 else ["heading"])),
        "score": data.draw(st.sampled_from(["joint", "conditional"])),
    }
    (one, told), (two, told_again) = guided_and_told(motion, options), guided_and_told(other, options)
    assert told == told_again
    assert one.path is not None
    assert two.path is not None
    # Where the rig stands, many paths are equally good: the same one is taken.
    assert one.path.frames.tolist() == two.path.frames.tolist()
    assert one.path.total == two.path.total
    assert np.array_equal(one.warp.output_times, two.warp.output_times)
    assert np.array_equal(one.warp.input_times, two.warp.input_times)


@settings(max_examples=100)
@given(st.data())
def test_order_and_names_change_no_joint_of_the_output(data: st.DataObject) -> None:
    motion = data.draw(moving_rigs())
    warp, standing = data.draw(warps_of(motion)), data.draw(contacts_of(motion))
    other, order = written_otherwise(motion, data.draw(st.integers(0, 999)), names=True)
    contacts_there = moved_contacts(standing, order)
    for loop in (False, True):
        with warnings.catch_warnings():
            # Hardly any rig comes back to its first pose.
            warnings.simplefilter("ignore", RetimeWarning)
            one = apply_warp(motion, warp, contacts=standing, loop=loop)
            two = apply_warp(other, warp, contacts=contacts_there, loop=loop)
        assert_same_motion(two, order, one)
    before, after = (
        retimed_slip(motion, warp, contacts=standing).contact_aware,
        retimed_slip(other, warp, contacts=contacts_there).contact_aware,
    )
    np.testing.assert_allclose(np.sort(after.millimetres), np.sort(before.millimetres), rtol=0, atol=1e-6)


@settings(max_examples=100)
@given(st.data())
def test_order_changes_no_foot_that_is_found(data: st.DataObject) -> None:
    motion = data.draw(moving_rigs())
    other, order = written_otherwise(motion, data.draw(st.integers(0, 999)), names=False)
    one, two = contacts(motion), contacts(other)
    here = {(order.index(foot.joint), foot.end_site): column.tolist() for foot, column in columns_of(one)}
    there = {(foot.joint, foot.end_site): column.tolist() for foot, column in columns_of(two)}
    assert here == there


def columns_of(standing: Contacts) -> list[tuple[Foot, np.ndarray]]:
    return list(zip(standing.feet, standing.at_rest.T, strict=True))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("whose", ["input", "reference", "both"])
@pytest.mark.parametrize("other_body", [False, True])
def test_order_changes_no_warp_to_a_reference(seed: int, whose: str, other_body: bool) -> None:
    motion, reference = walker(60), walker(75)
    # The walk is even; in a mirror, and on another body, it is not quite the same.
    reference = moved(reference, rotation.about_axis(1, 0.4), np.array([1.0, 0.0, 2.0]))
    if other_body:
        factors = np.random.default_rng(seed).uniform(0.7, 1.4, reference.skeleton.n_joints)
        reference = renamed(
            built(reference, factors, 1.1), {"LeftToe": "LeftToeBase", "Head": "head", "Spine": "Belly"}
        )
    one = guided_warp(motion, reference=Reference(reference, mirror=True), length="70%")
    if whose != "reference":
        motion, _ = written_otherwise(motion, seed, names=False)
    if whose != "input":
        reference, _ = written_otherwise(reference, seed + 7, names=False)
    two = guided_warp(motion, reference=Reference(reference, mirror=True), length="70%")
    assert one.path is not None
    assert two.path is not None
    assert one.path.frames.tolist() == two.path.frames.tolist()
    assert one.path.total == two.path.total


@pytest.mark.parametrize("seed", range(4))
def test_order_of_channels_changes_no_warp(seed: int) -> None:
    rng = np.random.default_rng(seed)
    waves = np.cumsum(stretches(rng, 60, 6, 0.5) * rng.normal(size=(60, 6)), axis=0)
    # Two channels that are one, for a while.
    waves[:30, 1] = waves[:30, 0]
    signal = Signal(tuple("abcdef"), waves, Fraction(30))
    order = rng.permutation(6).tolist()
    other = Signal(tuple(f"channel {place}" for place in order), waves[:, order], Fraction(30))
    one, two = guided_warp(signal, length="70%"), guided_warp(other, length="70%")
    assert one.path is not None
    assert two.path is not None
    assert one.path.frames.tolist() == two.path.frames.tolist()
    assert one.path.total == two.path.total


def below_a_still_node(motion: Motion, n_nodes: int = 1) -> Motion:
    """The same motion under nodes that never move, turned and away from the origin, as some programs write it."""
    skeleton = motion.skeleton
    nodes = rotation.normalize(np.random.default_rng(n_nodes).normal(size=(n_nodes, 4)))
    places = np.random.default_rng(n_nodes).normal(size=(n_nodes, 3))
    q, p = motion.rotations.copy(), motion.local_translations.copy()
    for node, place in zip(nodes, places, strict=True):
        q[:, 0] = rotation.multiply(rotation.conjugate(node), q[:, 0])
        p[:, 0] = rotation.rotate(rotation.conjugate(node), p[:, 0] - place)
    below = (n_nodes - 1 if parent < 0 else parent + n_nodes for parent in skeleton.parents)
    return Motion(
        Skeleton(
            (*(f"node {i}" for i in range(n_nodes)), *skeleton.names),
            (*range(-1, n_nodes - 1), *below),
            np.concatenate([places, skeleton.offsets]),
        ),
        np.concatenate([np.broadcast_to(nodes, (motion.n_frames, n_nodes, 4)), q], axis=1),
        np.concatenate([np.broadcast_to(places, (motion.n_frames, n_nodes, 3)), p], axis=1),
        motion.rate,
        metres_per_unit=1.0,
    )


@settings(max_examples=100)
@given(st.data())
def test_a_still_node_above_the_hips_changes_nothing(data: st.DataObject) -> None:
    motion = data.draw(moving_rigs())
    warp, n_nodes = data.draw(warps_of(motion)), data.draw(st.integers(1, 3))
    feet = data.draw(contacts_of(motion))
    joints = [point for point in feet.feet if point.end_site is None]
    at_rest = feet.at_rest[:, [point.end_site is None for point in feet.feet]]
    here = Contacts(tuple(joints), at_rest, motion.rate)
    there = Contacts(tuple(Foot(point.joint + n_nodes) for point in joints), at_rest, motion.rate)
    below = below_a_still_node(motion, n_nodes)
    for loop, keep in ((False, True), (False, False), (True, True)):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always", RetimeWarning)
            one = apply_warp(motion, warp, contacts=here, loop=loop, keep_root_path=keep)
            n_said = len(said)
            two = apply_warp(below, warp, contacts=there, loop=loop, keep_root_path=keep)
        # A loop's root may have walked on and turned: neither is warned of, nor both.
        assert len(said) == 2 * n_said
        places = global_poses(one).positions, global_poses(two).positions[:, n_nodes:]
        np.testing.assert_allclose(places[1], places[0], rtol=0, atol=1e-9)
