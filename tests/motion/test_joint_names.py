from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from retime.errors import OptionError
from retime.motion.joint_names import body_parts, match_joints, mirror_partners, near_names, take_apart
from tests.motion.walkers import walker_skeleton

# The same joints as each of these calls them: hips and head, then those of each side from the thigh to the hand.
SKELETONS = {
    "CMU BVH": ("Hips Head", "{}UpLeg {}Leg {}Foot {}ToeBase {}Shoulder {}Arm {}ForeArm {}Hand", "Left Right"),
    "CMU ASF": ("root head", "{}femur {}tibia {}foot {}toes {}clavicle {}humerus {}radius {}wrist", "l r"),
    "Mixamo": (
        "mixamorig:Hips mixamorig:Head",
        "mixamorig:{0}UpLeg mixamorig:{0}Leg mixamorig:{0}Foot mixamorig:{0}ToeBase "
        "mixamorig:{0}Shoulder mixamorig:{0}Arm mixamorig:{0}ForeArm mixamorig:{0}Hand",
        "Left Right",
    ),
    "hips and elbows": ("Hips Head", "{}Hip {}Knee {}Ankle {}Toes {}Collar {}Shoulder {}Elbow {}Wrist", "Left Right"),
    "MakeHuman": ("Hips Head", "UpLeg_{} LoLeg_{} Foot_{} Toe_{} Clavicle_{} UpArm_{} LoArm_{} Hand_{}", "L R"),
    "Rigify": (
        "DEF-pelvis DEF-head",
        "DEF-thigh.{} DEF-shin.{} DEF-foot.{} DEF-toe.{} DEF-shoulder.{} DEF-upper_arm.{} DEF-forearm.{} DEF-hand.{}",
        "L R",
    ),
    "Biped": (
        "Bip01_Pelvis Bip01_Head",
        "Bip01_{0}_Thigh Bip01_{0}_Calf Bip01_{0}_Foot Bip01_{0}_Toe0 "
        "Bip01_{0}_Clavicle Bip01_{0}_UpperArm Bip01_{0}_Forearm Bip01_{0}_Hand",
        "L R",
    ),
    "Unreal": ("pelvis head", "thigh_{} calf_{} foot_{} ball_{} clavicle_{} upperarm_{} lowerarm_{} hand_{}", "l r"),
    "VRM": (
        "J_Bip_C_Hips J_Bip_C_Head",
        "J_Bip_{0}_UpperLeg J_Bip_{0}_LowerLeg J_Bip_{0}_Foot J_Bip_{0}_ToeBase "
        "J_Bip_{0}_Shoulder J_Bip_{0}_UpperArm J_Bip_{0}_LowerArm J_Bip_{0}_Hand",
        "L R",
    ),
    "Poser": ("hip head", "{}Thigh {}Shin {}Foot {}Toe {}Collar {}Shldr {}ForeArm {}Hand", "l r"),
    "depth camera": (
        "PELVIS HEAD",
        "{0}_HIP# {0}_KNEE {0}_FOOT {0}_TOE {0}_COLLAR {0}_SHOULDER# {0}_ELBOW {0}_HAND",
        "LEFT RIGHT",
    ),
    "lower case": ("hip head", "{}hip {}knee {}ankle {}toe {}collar {}shoulder {}elbow {}wrist", "left right"),
}


def names_of(skeleton: str) -> list[str]:
    middle, sided, sides = SKELETONS[skeleton]
    return [*middle.split(), *(name.format(side, side) for side in sides.split() for name in sided.split())]


@pytest.mark.parametrize("one", SKELETONS)
@pytest.mark.parametrize("other", SKELETONS)
def test_well_known_skeletons_match_joint_by_joint(one, other) -> None:
    match = match_joints(names_of(one), names_of(other))
    assert match.pairs == tuple((joint, joint) for joint in range(18))


@pytest.mark.parametrize("name", SKELETONS)
def test_left_and_right_of_well_known_skeletons_are_partners(name) -> None:
    assert mirror_partners(names_of(name)) == (0, 1, *range(10, 18), *range(2, 10))


def test_joints_that_share_a_name_are_partners_as_their_parents_are() -> None:
    # Two fingers to a hand, whose tips are called alike; the hands list them the other way round.
    names = [
        "Hand.L",
        "Hand.R",
        "Thumb.L",
        "Index.L",
        "Tip.L",
        "Tip.L",
        "Index.R",
        "Thumb.R",
        "Tip.R",
        "Tip.R",
        "Tip.R",
    ]
    parents = [-1, 0, 0, 0, 2, 3, 1, 1, 6, 7, 1]
    assert mirror_partners(names, parents) == (1, 0, 7, 6, 9, 8, 3, 2, 5, 4, None)
    # Without the parents, the first belongs to the first.
    assert mirror_partners(names)[4:6] == (8, 9)


def test_a_part_is_said_once_or_of_every_joint() -> None:
    names = ["Hips", "LeftFoot", "LeftAnkle", "RightFoot"]
    once, all_of_them = body_parts(names), body_parts(names, repeated=True)
    assert [part and part.base for part in once] == ["hips", "foot", None, "foot"]
    assert [part and part.base for part in all_of_them] == ["hips", "foot", "foot", "foot"]


@pytest.mark.parametrize(
    ("names", "joint", "part"),
    [
        # A shoulder is the upper arm, unless another joint is.
        (["LeftShoulder", "LeftElbow"], 0, "upper arm"),
        (["LeftShoulder", "LeftArm"], 0, "collar"),
        # A leg is the shin, unless nothing else is the thigh.
        (["LeftUpLeg", "LeftLeg"], 1, "shin"),
        (["LeftLeg", "LeftKnee"], 0, "thigh"),
        (["LeftHip", "LeftLeg"], 1, "shin"),
        # A hip beside a thigh is what holds it.
        (["LeftHip", "LeftUpLeg"], 0, "hipjoint"),
        # A hand beyond a wrist is the palm.
        (["LeftWrist", "LeftHand"], 1, "palm"),
        (["LeftHand", "LeftFingerBase"], 0, "hand"),
        # The second joint of one part is none.
        (["LeftAnkle", "LeftFoot"], 1, None),
        # Only a root at the top, and no other hips, is the hips.
        (["root", "lfemur", "rfemur"], 0, "hips"),
        (["Root", "Hips"], 0, None),
        (["Hips", "Root"], 1, None),
        # Extra joints of exporters are no parts.
        (["__UpLeg_L", "UpLeg_L"], 0, None),
        (["__UpLeg_L", "UpLeg_L"], 1, "thigh"),
    ],
)
def test_a_word_means_what_it_means_beside_the_others(names, joint, part) -> None:
    found = body_parts(names)[joint]
    assert (found and found.base) == part


def test_a_first_letter_is_a_side_only_where_both_sides_are() -> None:
    assert [name.side for name in take_apart(["lfemur", "rfemur", "lowerback", "ribs", "leg"])] == [
        "left",
        "right",
        "",
        "",
        "",
    ]


def test_equal_names_of_different_parts_are_not_matched() -> None:
    # In the one the shoulder is the collar bone, in the other the upper arm.
    match = match_joints(["Hips", "LeftShoulder", "LeftArm"], ["Hips", "LeftShoulder", "LeftElbow"])
    assert match.pairs == ((0, 0), (2, 1))
    assert match.unmatched_input == ("LeftShoulder",)
    assert match.unmatched_reference == ("LeftElbow",)


@pytest.mark.parametrize(
    ("reference", "spine"),
    [
        (["Hips", "Spine", "Spine1", "Head"], 2),
        # Spine1 of four is another place than Spine1 of two.
        (["Hips", "Spine", "Spine1", "Spine2", "Spine3", "Head"], 0),
        (["Hips", "Spine1", "Spine", "Head"], 0),
        (["Hips", "upperback", "thorax", "Head"], 2),
    ],
)
def test_spines_are_matched_only_where_they_are_alike(reference, spine) -> None:
    match = match_joints(["Hips", "Spine", "Spine1", "Head"], reference)
    assert len(match.pairs) == 2 + spine


def test_unknown_names_match_exactly_or_but_for_case_and_separators() -> None:
    match = match_joints(["Tail", "tail_2", "Ear"], ["rig:ear", "Tail2", "Tail"])
    assert (match.pairs, match.how) == (((0, 2), (1, 1), (2, 0)), ("exact", "name", "name"))


def test_names_that_look_alike_twice_are_left_alone() -> None:
    assert match_joints(["fin"], ["Fin", "FIN"]).pairs == ()
    # Of equal names the first is meant.
    assert match_joints(["fin", "fin"], ["fin", "fin"]).pairs == ((0, 0),)


def test_a_map_goes_before_everything() -> None:
    match = match_joints(["Hips", "LeftFoot"], ["Hips", "LeftFoot", "paw"], {"LeftFoot": "paw"})
    assert (match.pairs, match.how) == (((0, 0), (1, 2)), ("part", "map"))
    assert match.unmatched_reference == ("LeftFoot",)


@pytest.mark.parametrize(
    ("joint_map", "message"),
    [
        ({"LeftFot": "paw"}, "'LeftFot', which the input has not; near to it: 'LeftFoot'"),
        ({"LeftFoot": "pw"}, "'pw', which the reference has not; near to it: 'paw'"),
        ({"LeftFoot": "paw", "Hips": "paw"}, "'paw' to two joints"),
    ],
)
def test_a_wrong_map_is_an_error(joint_map, message) -> None:
    with pytest.raises(OptionError, match=message):
        match_joints(["Hips", "LeftFoot"], ["Hips", "paw"], joint_map)


def test_near_names_are_named_else_what_there_is() -> None:
    assert near_names("Hed", ["Head", "Hand", "Tail"]) == "; near to it: 'Head'"
    assert near_names("?", [f"joint{i}" for i in range(20)]).endswith("'joint11' and 8 more")


names = st.lists(
    st.one_of(
        st.sampled_from(walker_skeleton().names), st.text(max_size=8), st.sampled_from(["L", "left", "_L", "::"])
    ),
    min_size=1,
    max_size=12,
)


@given(names, names)
def test_any_names_can_be_matched(one, other) -> None:
    match = match_joints(one, other)
    inputs, references = [i for i, _ in match.pairs], [j for _, j in match.pairs]
    assert inputs == sorted(set(inputs))
    assert len(set(references)) == len(references)
    assert len(match.unmatched_input) == len(one) - len(inputs)
    assert len(match.unmatched_reference) == len(other) - len(references)


@given(names)
def test_partners_are_mutual(joints) -> None:
    partners = mirror_partners(joints)
    for joint, partner in enumerate(partners):
        assert partner is None or partners[partner] == joint
