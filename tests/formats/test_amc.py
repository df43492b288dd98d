"""AMC: conventions worked out by hand, odd but legal files, and the cgspeed BVHs as a second opinion."""

from __future__ import annotations

import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatWarning
from retime.formats import read, write
from retime.formats.amc_declaration import AsfDeclaration
from retime.motion import rotation
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.skeleton import EndSite
from tests.formats.amc_files import AMC, ASF, MOCAP, asf_text, bone, needs_mocap, pose, read_amc

# Conventions, worked out by hand


def test_a_bone_turns_about_its_own_axes(tmp_path: Path) -> None:
    # Turned by 90 degrees about z, the bone's x axis is the global y axis.
    asf = asf_text(bone("a", "1 0 0", "0 0 90 XYZ", "rx", 2), "root a")
    motion = pose(tmp_path, asf, "root 0 0 0 0 0 0\na 90")
    assert global_poses(motion).end_positions[0] == pytest.approx(np.array([[0, 0, -2]]), abs=1e-12)


def test_the_first_rotation_listed_is_done_first(tmp_path: Path) -> None:
    # x takes (0, 0, 1) to (0, -1, 0), which y leaves where it is; the other way round it would end at (1, 0, 0).
    for dof in ("rx ry rz", "rx ry"):
        asf = asf_text(bone("a", "0 0 1", dof=dof), "root a")
        motion = pose(tmp_path, asf, "root 0 0 0 0 0 0\na 90 90" + " 0" * (len(dof) == 8))
        assert global_poses(motion).end_positions[0] == pytest.approx(np.array([[0, -1, 0]]), abs=1e-12)
    asf = asf_text(bone("a", "0 0 1", dof="ry rx"), "root a")
    motion = pose(tmp_path, asf, "root 0 0 0 0 0 0\na 90 90")
    assert global_poses(motion).end_positions[0] == pytest.approx(np.array([[1, 0, 0]]), abs=1e-12)


def test_axis_order(tmp_path: Path) -> None:
    # Y first and X second take the bone's z axis to the global x axis, about which it then turns.
    asf = asf_text(bone("a", "0 1 0", "90 90 0 YXZ", "rz"), "root a")
    motion = pose(tmp_path, asf, "root 0 0 0 0 0 0\na 90")
    assert global_poses(motion).end_positions[0] == pytest.approx(np.array([[0, 0, 1]]), abs=1e-12)


def test_the_root_turns_in_the_order_of_its_channels_wherever_its_translations_stand(tmp_path: Path) -> None:
    bones = bone("a", "0 0 1")
    for order, place in (("RX TX RY TY TZ RZ", "90 5 90 6 7 0"), ("TZ TY TX RX RY RZ", "7 6 5 90 90 0")):
        motion = pose(tmp_path, asf_text(bones, "root a", root=f"order {order}"), f"root {place}")
        assert global_poses(motion).positions[0, 0].tolist() == [5, 6, 7]
        assert global_poses(motion).end_positions[0] == pytest.approx(np.array([[5, 5, 7]]), abs=1e-12)
    motion = pose(tmp_path, asf_text(bones, "root a", root="order TX TY TZ RZ RY RX"), "root 5 6 7 0 90 90")
    assert global_poses(motion).end_positions[0] == pytest.approx(np.array([[6, 6, 7]]), abs=1e-12)


def test_a_preset_root_turns_first_and_is_warned_of(tmp_path: Path) -> None:
    root = "order TX TY TZ RX RY RZ\naxis XYZ\nposition 1 2 3\norientation 0 90 0"
    with pytest.warns(FormatWarning, match="preset position or orientation"):
        motion = pose(tmp_path, asf_text(bone("a", "0 0 1"), "root a", root=root), "root 10 20 30 0 0 90")
    # The orientation takes (0, 0, 1) to (1, 0, 0), the AMC's rotation about the global z axis that to (0, 1, 0).
    assert global_poses(motion).end_positions[0] == pytest.approx(np.array([[11, 23, 33]]), abs=1e-12)
    write(motion, tmp_path / "again.amc")
    with pytest.warns(FormatWarning, match="preset"):
        again = read_amc(tmp_path / "again.amc")
    assert again.declared_angles == pytest.approx(motion.declared_angles)
    assert again.local_translations.tolist() == motion.local_translations.tolist()


def test_a_bone_moves_along_its_own_axes(tmp_path: Path) -> None:
    bones = bone("a", "0 1 0", length=3) + bone("b", "0 1 0", "0 0 90 XYZ", "tx rz ty tz")
    motion = pose(tmp_path, asf_text(bones, "root a\na b"), "root 0 0 0 0 0 0\nb 0.5 90 0 0.25")
    poses = global_poses(motion)
    assert poses.positions[0, 2] == pytest.approx([0, 3.5, 0.25], abs=1e-12)
    assert poses.end_positions[0] == pytest.approx(np.array([[-1, 3.5, 0.25]]), abs=1e-12)
    write(motion, tmp_path / "again.amc")
    assert (tmp_path / "again.amc").read_text().splitlines()[-1] == "b 0.5 90 0 0.25"


def test_joints_stand_at_the_bases_of_bones(plain: Motion) -> None:
    skeleton = plain.skeleton
    assert skeleton.names == ("root", "upper", "lower", "hand", "tail")
    assert skeleton.parents == (-1, 0, 1, 2, 0)
    assert skeleton.offsets.tolist() == [[0, 0, 0], [0, 0, 0], [3, 4, 0], [0, 4, 0], [0, 0, 0]]
    assert skeleton.end_sites == (EndSite(3, (0.0, 0.0, 2.0)), EndSite(4, (0.0, 0.0, -1.5)))
    assert rotation.to_matrix(plain.rotations[:, 4]) == pytest.approx(np.broadcast_to(np.eye(3), (3, 3, 3)))
    assert plain.local_translations[1, 0].tolist() == [1.125, 17.25, -0.5]
    assert (plain.first_frame, plain.rate, plain.name) == (1, 120, "plain")
    assert plain.metres_per_unit == pytest.approx(0.056444, abs=1e-6)


def test_declared_angles_are_the_files_in_its_order(plain: Motion) -> None:
    assert plain.declared_angles is not None
    assert np.rad2deg(plain.declared_angles[0]) == pytest.approx(
        np.array([[-3.5, 4.25, 0.5], [10, -20.5, 30], [45, 0, 0], [-12.25, 9, 0], [0, 0, 0]])
    )
    declaration = plain.declaration
    assert isinstance(declaration, AsfDeclaration)
    assert declaration.format == "amc"
    assert declaration.channels[0] == ("Xposition", "Yposition", "Zposition", "Xrotation", "Yrotation", "Zrotation")
    assert declaration.channels[1:] == (
        ("Xrotation", "Yrotation", "Zrotation"),
        ("Xrotation",),
        ("Xrotation", "Zrotation"),
        (),
    )


@pytest.mark.parametrize(("units", "metres"), [("length 1.0", None), ("angle deg", None), ("length 2", 0.0127)])
def test_metres_are_known_where_the_unit_of_length_is_not_1(tmp_path: Path, units: str, metres: float | None) -> None:
    motion = pose(tmp_path, asf_text("", "root", units=units), "root 0 0 0 0 0 0")
    assert motion.metres_per_unit == pytest.approx(metres)


# The same trial, converted to BVH by somebody else

CGSPEED = {
    "root": "Hips",
    "lhipjoint": "LHipJoint",
    "lfemur": "LeftUpLeg",
    "ltibia": "LeftLeg",
    "lfoot": "LeftFoot",
    "ltoes": "LeftToeBase",
    "rhipjoint": "RHipJoint",
    "rfemur": "RightUpLeg",
    "rtibia": "RightLeg",
    "rfoot": "RightFoot",
    "rtoes": "RightToeBase",
    "lowerback": "LowerBack",
    "upperback": "Spine",
    "thorax": "Spine1",
    "lowerneck": "Neck",
    "upperneck": "Neck1",
    "head": "Head",
    "lclavicle": "LeftShoulder",
    "lhumerus": "LeftArm",
    "lradius": "LeftForeArm",
    "lwrist": "LeftHand",
    "lhand": "LeftFingerBase",
    "lfingers": "LeftHandIndex1",
    "lthumb": "LThumb",
    "rclavicle": "RightShoulder",
    "rhumerus": "RightArm",
    "rradius": "RightForeArm",
    "rwrist": "RightHand",
    "rhand": "RightFingerBase",
    "rfingers": "RightHandIndex1",
    "rthumb": "RThumb",
}


@needs_mocap
def test_cmu_agrees_with_its_cgspeed_bvh() -> None:
    pybvh = pytest.importorskip("pybvh")
    motion = read_amc(MOCAP / "cmu-asfamc/02_04.amc")
    bvh = pybvh.read_bvh_file(str(MOCAP / "cmu-bvh/02_04.bvh"))
    expected = bvh.node_positions()[1:]
    assert motion.n_frames == len(expected) == 483
    skeleton = motion.skeleton
    # The conversion to BVH leaves out the length of a bone that several bones hang on (thorax and wrists; their
    # children have an OFFSET of 0), so it must be left out here too. Up to there nothing is changed.
    forks = {parent for parent in skeleton.parents[1:] if skeleton.parents.count(parent) > 1}
    below = [joint for joint, parent in enumerate(skeleton.parents) if parent in forks]
    translations = motion.local_translations.copy()
    translations[:, below] = 0.0
    poses = global_poses(replace(motion, translations=translations))
    # The BVH's positions of the root have four decimals, which is where the 7e-5 of the difference comes from.
    for joint, name in enumerate(skeleton.names):
        theirs = expected[:, bvh.node_index[CGSPEED[name]]]
        assert np.linalg.norm(poses.positions[:, joint] - theirs, axis=-1).max() < 1e-4, name
    for i, site in enumerate(skeleton.end_sites):
        theirs = expected[:, bvh.node_index[f"EndSite{CGSPEED[skeleton.names[site.parent]]}"]]
        assert np.linalg.norm(poses.end_positions[:, i] - theirs, axis=-1).max() < 1e-4, site


# Odd but legal


@pytest.mark.parametrize(
    "name",
    [
        "crlf",
        "cr_only",
        "tabs",
        "byte_order_mark",
        "utf_16",
        "no_final_newline",
        "lower_case_keywords",
        "upper_case_joints",
        "comments_and_blank_lines",
        "values_run_on",
        "scientific_notation",
        "joints_in_another_order",
        "no_keywords",
        "radians",
        "tail_without_channels_named",
        "says_its_rate",
    ],
)
def test_odd_amc(plain: Motion, name: str) -> None:
    motion = read_amc(AMC / f"{name}.amc")
    assert motion.rotations == pytest.approx(plain.rotations, abs=1e-14)
    assert motion.local_translations.tolist() == plain.local_translations.tolist()
    assert motion.declared_angles == pytest.approx(plain.declared_angles, abs=1e-14)
    assert motion.first_frame == 1


def test_an_amc_without_a_word_on_angles_has_its_asfs(plain: Motion, tmp_path: Path) -> None:
    text = (AMC / "radians.amc").read_text().replace(":RADIANS\n", "")
    (tmp_path / "a.amc").write_text(text)
    motion = read_amc(tmp_path / "a.amc", skeleton=ASF / "radians.asf")
    assert motion.rotations == pytest.approx(plain.rotations, abs=1e-14)


@pytest.mark.parametrize(
    ("name", "first", "count"), [("starts_at_frame_100", 100, 3), ("starts_at_frame_0", 0, 2), ("single_frame", 1, 1)]
)
def test_first_frame(plain: Motion, name: str, first: int, count: int, tmp_path: Path) -> None:
    motion = read_amc(AMC / f"{name}.amc")
    assert (motion.first_frame, motion.n_frames) == (first, count)
    assert motion.rotations.tolist() == plain.rotations[:count].tolist()
    write(motion, tmp_path / "a.amc")
    assert (tmp_path / "a.amc").read_bytes() == (AMC / f"{name}.amc").read_bytes()


def test_joints_that_a_frame_leaves_out_keep_their_values(plain: Motion) -> None:
    with pytest.warns(FormatWarning, match=r"up to 2 of 3 frames leave out joints .*not :FULLY-SPECIFIED"):
        motion = read_amc(AMC / "changes_only.amc")
    q = motion.rotations
    assert q[:, 1].tolist() == [plain.rotations[0, 1].tolist()] * 3
    assert q[0, 2] == pytest.approx(rotation.identity())
    assert q[1:, 2].tolist() == [plain.rotations[1, 2].tolist()] * 2
    assert q[:, 3].tolist() == plain.rotations[[0, 0, 2], 3].tolist()
    assert motion.local_translations[:, 0].tolist() == plain.local_translations[[0, 0, 2], 0].tolist()


def test_unknown_words_are_passed_over_with_a_warning(tmp_path: Path) -> None:
    bones = bone("a", "0 1 0", dof="rx").replace("dof", "stiffness 3\ndof")
    with pytest.warns(FormatWarning, match=r"one\.asf: the bone's word 'stiffness' in line 14"):
        pose(tmp_path, asf_text(bones, "root a"), "root 0 0 0 0 0 0\na 90")


@pytest.mark.parametrize(
    ("amc", "asf", "warned"),
    [
        ("02_04", "07", True),
        ("02_04", "02", False),
        ("2_04", "002", False),
        ("walk", "07", False),
        ("02_04", "skeleton", False),
        ("02_04", "02_04", False),
    ],
)
def test_another_subjects_skeleton_is_told_by_its_name(tmp_path: Path, amc: str, asf: str, warned: bool) -> None:
    # The only one there, whatever it is called: nothing else in the two files could tell.
    (tmp_path / f"{asf}.asf").write_bytes((AMC / "arm.asf").read_bytes())
    (tmp_path / f"{amc}.amc").write_bytes((AMC / "plain.amc").read_bytes())
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        read(tmp_path / f"{amc}.amc", rate=120)
    told = [str(one.message) for one in caught if "of subject" in str(one.message)]
    assert len(told) == warned
    assert all("07.asf is of subject 07, and the motion of subject 02" in one for one in told)


# The rate


def test_120_hz_is_assumed_and_said() -> None:
    with pytest.warns(FormatWarning, match=r"plain\.amc: AMC files carry no rate; 120 Hz assumed \(most CMU trials\)"):
        motion = read(AMC / "plain.amc")
    assert motion.rate == 120


def test_a_rate_is_kept_in_a_comment(tmp_path: Path, plain: Motion) -> None:
    rate = Fraction(30000, 1001)
    said = read(AMC / "says_its_rate.amc")
    assert said.rate == rate
    write(plain.with_rate(rate), tmp_path / "a.amc")
    assert (tmp_path / "a.amc").read_bytes() == (AMC / "says_its_rate.amc").read_bytes()
    write(said, tmp_path / "b.amc")
    assert (tmp_path / "b.amc").read_bytes() == (AMC / "says_its_rate.amc").read_bytes()
    # The person who reads has the last word; at 120 Hz there is no comment.
    assert read(AMC / "says_its_rate.amc", rate=60).rate == 60
    write(said.with_rate(Fraction(120)), tmp_path / "c.amc")
    assert (tmp_path / "c.amc").read_bytes() == (AMC / "plain.amc").read_bytes()
