"""References: the same numbers for whatever moves alike, and honest errors for what doesn't compare."""

from __future__ import annotations

import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import FormatWarning, OptionError
from retime.formats.registry import read
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skeleton import Skeleton
from retime.search.guided import guided_warp
from retime.search.poses.references import Reference, model_poses
from retime.search.poses.spaces import PoseOptions, Track, low_pass, sample
from retime.search.poses.vectors import pose_vectors
from tests.motion.strategies import quaternions
from tests.motion.walkers import (
    N_CYCLE,
    built,
    moved,
    permuted,
    rebuilt,
    renamed,
    resting,
    scaled,
    walker,
    walker_skeleton,
)

WALK = walker()
NAMES = WALK.skeleton.names
SPACES = ("torso", "heading")
# A walk of few frames and few examples of it: one example is a whole motion, thousands of numbers.
STEP = walker(6)
few = settings(max_examples=25)
MOCAPBANK = {"UpLeg": "Hip", "Leg": "Knee", "Foot": "Ankle", "Toe": "Toes", "Shoulder": "Collar", "Arm": "Shoulder"}
MOCAPBANK |= {"ForeArm": "Elbow", "Hand": "Wrist"}


def vectors_of(
    motion: Motion, options: PoseOptions | str, clip: Motion = WALK, **reference
) -> tuple[np.ndarray, np.ndarray]:
    """Pose vectors of the walk and of a reference."""
    model = model_poses(clip, [Reference(motion, **reference)], options)
    return model.input.tracks[0].vectors, model.references[0].tracks[0].vectors


# --- pose options ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("space", SPACES)
def test_chosen_joints_keep_their_numbers_and_their_order(space) -> None:
    chosen = ["RightHand", "Head", "LeftToe"]
    full = pose_vectors(WALK, space).reshape(WALK.n_frames, -1, 3)
    in_skeleton = sorted(NAMES.index(name) for name in chosen)
    expected = np.concatenate([full[:, joint - (space == "torso")] for joint in in_skeleton], axis=1)
    np.testing.assert_array_equal(pose_vectors(WALK, PoseOptions(space, joints=chosen)), expected)


@pytest.mark.parametrize("space", SPACES)
def test_weights_multiply_the_coordinates_of_their_joints(space) -> None:
    weights = {"Head": 2.0, "LeftHand": 0.0, "RightHand": 0.25}
    expected = pose_vectors(WALK, space).reshape(WALK.n_frames, -1, 3).copy()
    for name, weight in weights.items():
        expected[:, NAMES.index(name) - (space == "torso")] *= weight
    found = pose_vectors(WALK, PoseOptions(space, weights=weights))
    np.testing.assert_array_equal(found.reshape(expected.shape), expected)


def test_a_repeated_name_means_every_joint_that_has_it() -> None:
    twins = renamed(WALK, {"LeftHand": "Hand", "RightHand": "Hand"})
    assert pose_vectors(twins, PoseOptions(joints=["Hand"])).shape == (WALK.n_frames, 6)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"space": "body"}, "features must be one of torso, heading, signal; found 'body'"),
        ({"joints": []}, "no joint is chosen"),
        ({"weights": {"Head": -1}}, "weight of 'Head' must be a finite number, 0 or more; found -1"),
        ({"weights": {"Head": float("nan")}}, "found nan"),
        ({"scales": {"x": 0}}, "scale of 'x' must be a finite number, above 0; found 0"),
        ({"scales": {"x": float("inf")}}, "found inf"),
        ({"scales": {"x": 5e-324}}, "above 0; found 5e-324 .1e-09 to 1e.09 can be told apart"),
        ({"weights": {"Head": 1e300}}, "0 or more; found 1e.300"),
    ],
)
def test_pose_options_out_of_range_are_refused(options, message) -> None:
    with pytest.raises(OptionError, match=message):
        PoseOptions(**options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (PoseOptions(joints=["Hed"]), "walker has no 'Hed'; near to it: 'Head'"),
        (PoseOptions(weights={"leftfoot": 2}), "near to it: 'LeftFoot'"),
        (PoseOptions("torso", joints=["Hips"]), "'Hips' has no coordinates of its own in torso space"),
        (PoseOptions(joints=["Head"], weights={"Head": 0}), "every weight is 0"),
        (PoseOptions(scales={"Head": 2}), "joints have weights, not scales"),
        (PoseOptions("signal"), "has a skeleton"),
    ],
)
def test_pose_options_that_do_not_fit_the_motion_are_refused(options, message) -> None:
    with pytest.raises(OptionError, match=message):
        pose_vectors(WALK, options)
    with pytest.raises(OptionError, match=message):
        model_poses(WALK, [Reference(renamed(WALK, {"Neck": "neck"}))], options)


# --- the same skeleton ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("space", SPACES)
def test_without_references_the_input_is_its_own(space) -> None:
    model = model_poses(WALK, (), space)
    assert model.references[0].tracks[0] is model.input.tracks[0]
    np.testing.assert_array_equal(model.input.tracks[0].vectors, pose_vectors(WALK, space))
    assert model_poses(WALK, [Reference(WALK)], space).references[0].matches == (None,)


@pytest.mark.parametrize("space", SPACES)
def test_the_same_skeleton_is_described_bit_for_bit_as_the_input_is(space) -> None:
    other = moved(walker(50, heading=0.3), rotation.about_axis(1, 1.0), np.array([3.0, 0, 1]))
    options = PoseOptions(space, weights={"Head": 0.5})
    _, found = vectors_of(other, options)
    np.testing.assert_array_equal(found, pose_vectors(other, options))


def test_weight_and_name_go_with_a_reference_and_with_its_mirror_image() -> None:
    model = model_poses(WALK, [Reference(WALK, weight=3, mirror=True, name="a"), Reference(WALK, name="b")])
    assert [(found.name, found.weight, found.mirrored) for found in model.references] == [
        ("a", 3, False),
        ("a, mirrored", 3, True),
        ("b", 1, False),
    ]


# --- another skeleton -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("space", SPACES)
@few
@given(factor=st.floats(1e-3, 1e3), angle=st.floats(-4, 4), x=st.floats(-100, 100), z=st.floats(-100, 100))
def test_units_place_and_direction_do_not_matter(space, factor, angle, x, z) -> None:
    elsewhere = moved(STEP, rotation.about_axis(1, angle), np.array([x, 0, z]))
    expected, found = vectors_of(scaled(elsewhere, factor), space, STEP)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@few
@given(turn=quaternions(), shift=st.tuples(*[st.floats(-100, 100)] * 3))
def test_in_torso_space_no_movement_of_the_whole_matters(turn, shift) -> None:
    other = scaled(moved(STEP, turn, np.array(shift)), 100)
    expected, found = vectors_of(other, "torso", STEP)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("space", SPACES)
@few
@given(data=st.data())
def test_the_order_of_joints_does_not_matter(space, data) -> None:
    # Any order in which parents stand before their children.
    left = set(range(1, len(NAMES)))
    order = [0]
    while left:
        ready = sorted(joint for joint in left if STEP.skeleton.parents[joint] in order)
        order.append(data.draw(st.sampled_from(ready)))
        left.remove(order[-1])
    expected, found = vectors_of(permuted(STEP, order), space, STEP)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("space", SPACES)
def test_names_do_not_matter_where_a_map_gives_them(space) -> None:
    names = {name: f"j{joint}" for joint, name in enumerate(NAMES)}
    expected, found = vectors_of(renamed(WALK, names), space, joint_map=names)
    assert found.shape[1] == 3 * (len(NAMES) - (space == "torso"))
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("space", SPACES)
def test_names_of_another_program_are_matched(space) -> None:
    names = {f"{side}{ours}": f"{side}{theirs}" for ours, theirs in MOCAPBANK.items() for side in ("Left", "Right")}
    model = model_poses(WALK, [Reference(renamed(WALK, names))], space)
    np.testing.assert_allclose(model.references[0].tracks[0].vectors, model.input.tracks[0].vectors, atol=1e-9)
    (match,) = model.references[0].matches
    assert match is not None
    assert match.unmatched_input == ()


@pytest.mark.parametrize("space", SPACES)
@few
@given(turn=quaternions())
def test_axes_of_the_joints_do_not_matter(space, turn) -> None:
    # All joints' axes turned alike, the root's too: another convention.
    other = resting(STEP, dict.fromkeys(NAMES, turn))
    expected, found = vectors_of(other, space, STEP)
    # Turns of less than a millionth are taken for none.
    np.testing.assert_allclose(found, expected, atol=2e-6)


@pytest.mark.parametrize("space", SPACES)
@pytest.mark.parametrize("turn", [("Z", 1.2), ("Z", -0.5), ("Y", 1.5)])
def test_arms_that_rest_otherwise_hardly_matter(space, turn) -> None:
    order, angle = turn
    sides = {"LeftArm": -angle, "RightArm": angle}
    other = resting(WALK, {name: rotation.from_euler(order, np.array([a])) for name, a in sides.items()})
    expected, found = vectors_of(other, space)
    # What is left comes from the rest poses, which can't be laid exactly over each other: below 1 cm.
    assert np.abs(found - expected).max() < 0.01


@few
@given(seed=st.integers(0, 2**32 - 1))
def test_proportions_do_not_matter(seed) -> None:
    factors = np.random.default_rng(seed).uniform(0.3, 3, len(NAMES))
    expected, found = vectors_of(built(STEP, factors, 1.0), "torso", STEP)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_proportions_do_not_matter_in_heading_space_where_the_root_goes_with_the_legs() -> None:
    legs = np.array([1.7 if name.endswith(("Leg", "Foot", "Toe")) else 0.6 for name in NAMES])
    expected, found = vectors_of(built(WALK, legs, 1.7), "heading")
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("space", SPACES)
def test_a_joint_more_in_the_middle_of_a_bone_does_not_matter(space) -> None:
    skeleton = WALK.skeleton
    knee = NAMES.index("LeftLeg")
    half = skeleton.offsets[knee] / 2
    names = (*NAMES[:knee], "twist", *NAMES[knee:])
    later = [parent + (parent >= knee) for parent in skeleton.parents]
    parents = (*later[:knee], later[knee], knee, *later[knee + 1 :])
    offsets = np.concatenate([skeleton.offsets[:knee], [half, half], skeleton.offsets[knee + 1 :]])
    q = np.insert(WALK.rotations, knee, rotation.identity(), axis=1)
    p = np.insert(WALK.local_translations, knee, half, axis=1)
    p[:, knee + 1] = half
    other = rebuilt(WALK, names, parents, offsets, rotations=q, translations=p)
    expected, found = vectors_of(other, space)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("space", SPACES)
def test_a_root_on_the_ground_above_the_hips_does_not_matter(space) -> None:
    # As exporters write it: the scene's root, which may move by itself, and the hips below it.
    skeleton = WALK.skeleton
    names = ("Reference", *NAMES)
    parents = (-1, *(parent + 1 for parent in skeleton.parents))
    offsets = np.concatenate([[[0, 0, 0]], [[0, 0.9, 0]], skeleton.offsets[1:]])
    q = np.insert(WALK.rotations, 0, rotation.identity(), axis=1)
    p = np.insert(WALK.local_translations, 0, np.zeros(3), axis=1)
    other = rebuilt(WALK, names, parents, offsets, rotations=q, translations=p)
    expected, found = vectors_of(other, space)
    assert found.shape[1] == 3 * (len(NAMES) - (space == "torso"))
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_in_heading_space_another_axis_may_be_up() -> None:
    z_up = rotation.about_axis(0, np.pi / 2)
    other = moved(resting(WALK, dict.fromkeys(NAMES, z_up)), z_up, np.array([5.0, 2.0, 0.0]))
    expected, found = vectors_of(other, "heading")
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_in_heading_space_another_floor_is_seen_but_a_jump_is_not() -> None:
    other = scaled(WALK, 100)
    for lift, kept in ((30.0, 0.3), (-95.0, 0.0), (500.0, 0.0)):
        expected, found = vectors_of(moved(other, rotation.identity(), np.array([0, lift, 0])), "heading")
        heights = (found - expected).reshape(WALK.n_frames, -1, 3)[:, :, 1]
        np.testing.assert_allclose(heights, kept, atol=1e-9)


def test_only_joints_that_every_reference_has_are_compared() -> None:
    without_hands = renamed(WALK, {"LeftHand": "?", "RightHand": "??"})
    without_head = renamed(WALK, {"Head": "???"})
    model = model_poses(WALK, [Reference(without_hands), Reference(without_head), Reference(WALK)])
    kept = [name for name in NAMES if name not in ("LeftHand", "RightHand", "Head")]
    expected = pose_vectors(WALK, PoseOptions(joints=kept))
    np.testing.assert_array_equal(model.input.tracks[0].vectors, expected)
    assert model.references[2].tracks[0] is model.input.tracks[0]
    for found in model.references:
        np.testing.assert_allclose(found.tracks[0].vectors, expected, atol=1e-9)
    (match,) = model.references[0].matches
    assert match is not None
    assert match.unmatched_reference == ("?", "??")


def test_weights_go_by_the_names_of_the_input() -> None:
    other = scaled(renamed(WALK, {"LeftHand": "LeftWrist"}), 100)
    options = PoseOptions(weights={"LeftHand": 3.0}, joints=["LeftHand", "Head"])
    model = model_poses(WALK, [Reference(other)], options)
    np.testing.assert_array_equal(model.input.tracks[0].vectors, pose_vectors(WALK, options))
    np.testing.assert_allclose(model.references[0].tracks[0].vectors, pose_vectors(WALK, options), atol=1e-9)


def strangers(*names: str) -> Motion:
    skeleton = Skeleton(names, (-1, *([0] * (len(names) - 1))), np.eye(3)[np.arange(len(names)) % 3])
    return Motion(skeleton, rotation.identity(5, len(names)), name="the fox")


def test_too_few_matched_joints_are_an_error_that_says_which_and_what_helps() -> None:
    with pytest.raises(OptionError) as caught:
        model_poses(WALK, [Reference(strangers("Hips", "Head", "Tail", "Paw"))])
    message = str(caught.value)
    assert "the fox has another skeleton, and too few of its joints could be matched" in message
    assert "2 ('Hips', 'Head') of at least 3" in message
    assert "'Spine', 'Chest', 'Neck'" in message
    assert "and 11 more of the input and 'Tail', 'Paw' of the reference" in message
    assert "Give a joint map" in message
    # With the map it goes.
    found = model_poses(WALK, [Reference(strangers("Hips", "Head", "Tail", "Paw"), joint_map={"LeftHand": "Paw"})])
    assert found.input.n_numbers == 9


@pytest.mark.parametrize(
    ("reference", "options", "message"),
    [
        (
            Reference(renamed(WALK, {"Head": "x"})),
            PoseOptions(joints=["Head"]),
            "'Head' can't be compared: walker has no",
        ),
        (Reference(WALK, joint_map={"Hed": "Head"}), None, "'Hed', which the input has not; near to it: 'Head'"),
        (Reference(WALK, joint_map={"Head": "Hed"}), None, "'Hed', which the reference has not; near to it: 'Head'"),
        (
            Reference(strangers("Hips", "Head", "Neck", "x")),
            PoseOptions("torso", weights={"Head": 0, "Neck": 0}),
            "no joint that",
        ),
        (Reference(Signal(("x",), np.zeros((5, 1)), name="wave")), None, "walker is a motion, wave is a signal"),
        (Reference((WALK, WALK)), None, "the input has 1 clip and walker has 2"),
        (Reference(strangers("Hips", "Head", "Neck", "Tail"), mirror=True), None, "the fox can't be mirrored"),
    ],
)
def test_references_that_do_not_compare_are_refused(reference, options, message) -> None:
    with pytest.raises(OptionError, match=message):
        model_poses(WALK, [reference], options)


@pytest.mark.parametrize("weight", [0.0, -1.0, float("nan"), float("inf"), 1e-300, 1.7e308])
def test_a_weight_that_is_none_is_refused(weight) -> None:
    with pytest.raises(OptionError, match="weight of a reference must be a finite number above 0"):
        Reference(WALK, weight=weight)


def test_rest_poses_that_say_nothing_are_refused_with_the_name_of_the_reference() -> None:
    flat = rebuilt(WALK, NAMES, WALK.skeleton.parents, np.zeros((len(NAMES), 3)), name="flat")
    with pytest.raises(OptionError, match=r"flat can't be compared with the input: .* rest in one place"):
        model_poses(WALK, [Reference(flat)])


# --- mirror images --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("space", SPACES)
def test_an_even_walk_is_its_mirror_image_half_a_cycle_later(space) -> None:
    model = model_poses(WALK, [Reference(WALK, mirror=True)], space)
    plain, mirrored = (found.tracks[0].vectors for found in model.references)
    half = N_CYCLE // 2
    np.testing.assert_allclose(mirrored[:-half], plain[half:], atol=1e-9)
    assert np.abs(mirrored - plain).max() > 0.1


@few
@given(quaternions(3, len(NAMES)))
def test_in_torso_space_a_mirror_image_has_the_other_sides_joints_with_x_turned_round(rotations) -> None:
    motion = Motion(walker_skeleton(), rotations)
    model = model_poses(motion, [Reference(motion, mirror=True)], "torso")
    plain, mirrored = (found.tracks[0].vectors.reshape(3, -1, 3) for found in model.references)
    for joint, name in enumerate(NAMES[1:]):
        swapped = name.replace("Left", "?").replace("Right", "Left").replace("?", "Right")
        expected = plain[:, NAMES.index(swapped) - 1] * [-1, 1, 1]
        np.testing.assert_allclose(mirrored[:, joint], expected, atol=1e-9)


@pytest.mark.parametrize("space", SPACES)
def test_the_mirror_image_of_another_skeleton_is_that_of_the_input(space) -> None:
    expected = model_poses(WALK, [Reference(WALK, mirror=True)], space).references[1].tracks[0].vectors
    z_up = rotation.about_axis(0, np.pi / 2)
    other = scaled(moved(resting(WALK, dict.fromkeys(NAMES, z_up)), z_up, np.zeros(3)), 39.37)
    found = model_poses(WALK, [Reference(other, mirror=True)], space).references[1].tracks[0].vectors
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_a_chosen_joint_is_seen_in_the_mirror_by_its_partner() -> None:
    options = PoseOptions(joints=["LeftHand"])
    found = model_poses(WALK, [Reference(WALK, mirror=True)], options).references[1].tracks[0].vectors
    right = pose_vectors(WALK, PoseOptions(joints=["RightHand"]))
    np.testing.assert_allclose(found, right * [-1, 1, 1], atol=1e-9)


def test_a_joint_of_one_side_only_is_left_out_where_there_is_a_mirror() -> None:
    sword = renamed(WALK, {"LeftHand": "LeftSword", "RightHand": "RightShield"})
    model = model_poses(sword, [Reference(sword, mirror=True)])
    assert model.input.n_numbers == 3 * (len(NAMES) - 2)
    with pytest.raises(OptionError, match="'LeftSword' can't be compared: walker has it on one side only"):
        model_poses(sword, [Reference(sword, mirror=True)], PoseOptions(joints=["LeftSword"]))


def test_a_signal_has_no_mirror_image() -> None:
    wave = Signal(("x",), np.arange(5.0)[:, None], name="wave")
    with pytest.raises(OptionError, match="wave is a signal, which has no left and right"):
        model_poses(wave, [Reference(wave, mirror=True)])


# --- signals --------------------------------------------------------------------------------------------------------


def wave(n_frames: int, *names: str, factor: float = 1.0, rate: int = 30) -> Signal:
    t = np.arange(n_frames) / rate
    values = np.stack([factor * (10**k) * np.sin((k + 1) * t) for k in range(len(names))], axis=1)
    return Signal(names, values, Fraction(rate), name="wave")


def test_channels_are_divided_by_their_deviation_over_all_references() -> None:
    clip, long, short = wave(50, "x", "y"), wave(90, "x", "y", factor=3), wave(20, "x", "y")
    model = model_poses(clip, [Reference(long), Reference(short)])
    scales = np.concatenate([long.values, short.values]).std(axis=0)
    np.testing.assert_allclose(model.input.tracks[0].vectors, clip.values / scales, rtol=1e-12)
    for found, signal in zip(model.references, (long, short), strict=True):
        np.testing.assert_allclose(found.tracks[0].vectors, signal.values / scales, rtol=1e-12)


@pytest.mark.parametrize("constant", [0.0, 0.1, 1e100])
def test_a_constant_channel_is_left_as_it_is(constant) -> None:
    values = np.stack([np.arange(20.0), np.full(20, constant)], axis=1)
    found = pose_vectors(Signal(("x", "y"), values))
    np.testing.assert_allclose(found[:, 0], np.arange(20.0) / np.arange(20.0).std())
    np.testing.assert_array_equal(found[:, 1], np.full(20, constant))


def test_deviations_of_huge_and_tiny_channels_do_not_overflow() -> None:
    values = np.outer(np.arange(20.0), [1e98, 1e-200])
    found = pose_vectors(Signal(("x", "y"), values))
    np.testing.assert_allclose(found, np.outer(np.arange(20.0), [1, 1]) / np.arange(20.0).std())


def test_scales_and_weights_of_channels_can_be_given() -> None:
    clip = wave(50, "x", "y", "z")
    options = PoseOptions(scales={"y": 4.0}, weights={"z": 0.5}, scale_signals=False, joints=["y", "z"])
    np.testing.assert_allclose(pose_vectors(clip, options), clip.values[:, 1:] / [4.0, 1.0] * [1.0, 0.5])
    with pytest.raises(OptionError, match="wave has no 'w'"):
        pose_vectors(clip, PoseOptions(scales={"w": 1.0}))
    with pytest.raises(OptionError, match="wave has no skeleton: its features are 'signal', not 'torso'"):
        model_poses(clip, (), "torso")


def test_channels_are_matched_by_name_and_by_map() -> None:
    clip, other = wave(50, "x", "y"), Signal(("v", "b", "x"), np.arange(60.0).reshape(20, 3), name="other")
    model = model_poses(clip, [Reference(other, joint_map={"y": "b"})], PoseOptions(scale_signals=False))
    np.testing.assert_array_equal(model.references[0].tracks[0].vectors, other.values[:, [2, 1]])
    with pytest.raises(OptionError, match=r"other has no channel 'y'.* choose channels that both have, or map"):
        model_poses(clip, [Reference(other)])
    model = model_poses(clip, [Reference(other)], PoseOptions(joints=["x"], scale_signals=False))
    np.testing.assert_array_equal(model.references[0].tracks[0].vectors, other.values[:, [2]])


@pytest.mark.parametrize("n_channels", [1, 3])
def test_columns_without_names_are_matched_only_one_to_one(n_channels: int) -> None:
    clip, more = np.arange(40.0).reshape(20, 2), np.arange(20.0 * n_channels).reshape(20, n_channels)
    names = tuple(f"c{i}" for i in range(n_channels))
    for reference in (more, Signal(names, more, name="array"), Reference(Signal(names, more), name="array")):
        with pytest.raises(
            OptionError,
            match=rf"has {n_channels} channels? and the input 2, without names that say .* pass arrays with the same",
        ) as refusal:
            guided_warp(clip, reference=reference, rate=30)
        assert (refusal.value.option, refusal.value.item) == ("reference", 0)
    assert guided_warp(clip, reference=clip[::2], rate=30).n_output == 20
    # Who names the columns knows what is meant.
    chosen = PoseOptions(joints=["c0"])
    assert guided_warp(clip, reference=more, rate=30, features=chosen).n_output == 20
    swapped = Reference(Signal(names, more), joint_map={"c0": names[-1], "c1": "c0"})
    assert guided_warp(clip, reference=swapped, rate=30).n_output == 20


def test_columns_with_and_without_names_are_not_matched() -> None:
    clip, array = wave(50, "x", "y"), np.arange(40.0).reshape(20, 2)
    for one, other, who in ((clip, array, "array"), (array, clip, "the input")):
        with pytest.raises(OptionError, match=rf"has no channel '(x|c0)'.*\({who} has none, only numbers"):
            guided_warp(one, reference=other, rate=30)


# --- groups ---------------------------------------------------------------------------------------------------------


def test_a_group_is_described_by_its_clips_side_by_side() -> None:
    camera = wave(317, "pan", "tilt", rate=120)
    model = model_poses([WALK, camera])
    assert model.input.end_time == pytest.approx(79 / 30)
    times = np.linspace(0, 2.5, 30)
    expected = np.concatenate(
        [
            sample(low_pass(pose_vectors(WALK), WALK.rate, 4.0), WALK.rate, times),
            sample(low_pass(pose_vectors(camera), camera.rate, 4.0), camera.rate, times),
        ],
        axis=1,
    )
    np.testing.assert_array_equal(model.input.at(times, 4.0), expected)
    np.testing.assert_array_equal(model.references[0].at(times, 4.0), expected)
    assert model.input.at_rate(30, 0).shape == (80, 3 * len(NAMES) + 2)


def test_clips_of_a_group_must_last_alike() -> None:
    short = wave(78, "pan")
    with pytest.raises(
        OptionError, match=r"must last alike \(within 0.017 s\); in the input are wave 2.600 s and walker"
    ):
        model_poses([WALK, short])
    model_poses([WALK, wave(159, "pan", rate=60)])
    with pytest.raises(OptionError, match="in pair are wave"):
        model_poses([WALK, wave(80, "pan")], [Reference((WALK, short), name="pair")])


def test_each_clip_of_a_group_looks_for_its_own_names() -> None:
    camera = wave(80, "pan", "tilt")
    options = PoseOptions("heading", joints=["Head", "tilt"], weights={"tilt": 2.0}, scales={"tilt": 5.0})
    found = model_poses([WALK, camera], (), options).input.tracks
    np.testing.assert_array_equal(found[0].vectors, pose_vectors(WALK, PoseOptions("heading", joints=["Head"])))
    np.testing.assert_allclose(found[1].vectors, camera.values[:, [1]] / 5 * 2)
    each = [PoseOptions(joints=["Head"]), PoseOptions()]
    assert model_poses([WALK, camera], (), each).input.n_numbers == 5
    for wrong, message in (
        (PoseOptions(joints=["Head"]), "none of the chosen joints is in wave"),
        (PoseOptions(weights={"Hed": 2}), "no clip of the group has 'Hed'; near to it: 'Head'"),
        (PoseOptions(scales={"Head": 2}), "no clip of the group has 'Head'"),
        ([PoseOptions()], "2 clips need as many pose options, or one for all; found 1"),
    ):
        with pytest.raises(OptionError, match=message):
            model_poses([WALK, camera], (), wrong)


def test_lengths_of_a_group_are_in_the_unit_of_its_first_clip() -> None:
    inches = scaled(WALK, 1 / 0.0254)
    model = model_poses([WALK, inches])
    np.testing.assert_allclose(model.input.tracks[1].vectors, pose_vectors(WALK), atol=1e-9)
    # A reference's size is made the input's; then its unit.
    found = model_poses([WALK, inches], [Reference((WALK, replace(WALK, metres_per_unit=None)))]).references[0]
    np.testing.assert_allclose(found.tracks[1].vectors, pose_vectors(WALK), atol=1e-9)
    unknown = replace(inches, metres_per_unit=None)
    np.testing.assert_array_equal(model_poses([WALK, unknown]).input.tracks[1].vectors, pose_vectors(unknown))


def test_a_joint_map_serves_the_clips_that_have_its_joints() -> None:
    camera, other = wave(80, "pan"), Signal(("yaw",), np.arange(80.0)[:, None])
    found = model_poses([WALK, camera], [Reference((WALK, other), joint_map={"pan": "yaw"})])
    assert found.references[0].matches == (None, None)
    with pytest.raises(OptionError, match="the joint map names 'pann', which the input has not; near to it: 'pan'"):
        model_poses([WALK, camera], [Reference((WALK, other), joint_map={"pann": "yaw"})])


@pytest.mark.parametrize("group", [[], ["clip"], "clip"])
def test_what_is_no_group_is_refused(group) -> None:
    with pytest.raises(OptionError, match=r"a group|or several of them"):
        model_poses(group)


# --- tracks ---------------------------------------------------------------------------------------------------------


def test_a_track_is_low_passed_at_its_own_rate_whatever_was_asked_before() -> None:
    vectors = np.random.default_rng(3).normal(size=(100, 4))
    track = Track(vectors, Fraction(120))
    times = np.linspace(-0.1, 1.0, 37)
    for cutoff in (4.0, 0.0, 10.0, 4.0, 4.0):
        expected = sample(low_pass(vectors, Fraction(120), cutoff), Fraction(120), times)
        np.testing.assert_array_equal(track.at(times, cutoff), expected)
    assert track.end_time == 99 / 120


# --- real motions ---------------------------------------------------------------------------------------------------


def test_one_capture_on_two_skeletons_gets_the_same_numbers(mocap: Path) -> None:
    # The BVH lost the stretches from chest to neck and from wrist to palm in its conversion, and has other names.
    acclaim = read(mocap / "cmu-asfamc/02_04.amc", rate=120)
    bvh = read(mocap / "cmu-bvh/02_04.bvh")
    assert isinstance(acclaim, Motion)
    assert isinstance(bvh, Motion)
    bvh = bvh.frames(1, bvh.n_frames)
    for space in SPACES:
        for one, other in ((acclaim, bvh), (bvh, acclaim)):
            model = model_poses(one, [Reference(other)], space)
            expected, found = model.input.tracks[0].vectors, model.references[0].tracks[0].vectors
            assert model.input.n_numbers == 3 * (31 - (space == "torso"))
            # Units of 5.6 cm; the files have five or six digits.
            assert np.abs(found - expected).max() < 0.01


@pytest.mark.parametrize(
    ("file", "n_joints"),
    [
        ("bvh-other/Boxing_Toes.bvh", 17),
        ("bvh-other/test_mocapbank.bvh", 15),
        ("bvh-other/dab.bvh", 17),
        ("bvh-other/test_freebvh.bvh", 19),
        ("bvh-other/makehuman_walk1.bvh", 17),
    ],
)
def test_people_on_other_skeletons_stand_as_the_input_does(mocap: Path, file, n_joints) -> None:
    clip = read(mocap / "cmu-bvh/07_01.bvh")
    assert isinstance(clip, Motion)
    with warnings.catch_warnings():
        # One of them has a frame more than it says.
        warnings.simplefilter("ignore", FormatWarning)
        reference = Reference(read(mocap / file))
    for space in SPACES:
        model = model_poses(clip, [reference], space)
        assert model.input.n_numbers == 3 * (n_joints + (space == "heading"))
        names = [name for name in clip.skeleton.names if name not in model.references[0].matches[0].unmatched_input]
        first = 0 if space == "heading" else 1
        places = {name: at for at, name in enumerate(names[first:])}
        poses = [tracks.tracks[0].vectors.reshape(-1, len(places), 3) for tracks in (model.input, model.references[0])]
        mean = [found.mean(axis=0) for found in poses]
        for name in ("UpLeg", "Foot", "Arm"):
            # Left on the left, right on the right.
            assert all(found[places["Left" + name], 0] > found[places["Right" + name], 0] + 1 for found in mean), name
        # Heads up, feet below, toes forward.
        assert all(found[places["Head"], 1] - found[places["LeftFoot"], 1] > 15 for found in mean)
        if "LeftToeBase" in places:
            assert all(found[places["LeftToeBase"], 2] > found[places["LeftFoot"], 2] + 0.5 for found in mean)
        # Limbs have the input's lengths, in every frame.
        for end, start in (("LeftLeg", "LeftUpLeg"), ("RightForeArm", "RightArm")):
            length = [np.linalg.norm(found[:, places[end]] - found[:, places[start]], axis=1) for found in poses]
            np.testing.assert_allclose(length[1], length[0].mean(), rtol=0.02)
