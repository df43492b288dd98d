"""ASF/AMC: conventions by hand, quirks and damage from files, the cgspeed BVHs as a second opinion."""

from __future__ import annotations

import random
import re
import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from retime.errors import FormatError, FormatWarning, OutputExistsError
from retime.formats import Limits, read, write
from retime.formats.amc import AsfDeclaration
from retime.motion import rotation
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skeleton import EndSite, Skeleton

DATA = Path(__file__).resolve().parents[1] / "data"
AMC = DATA / "amc"
ASF = DATA / "asf"
MOCAP = Path(__file__).resolve().parents[2] / "../shared/mocap"
ARM = AMC / "arm.asf"

needs_mocap = pytest.mark.skipif(not MOCAP.is_dir(), reason="the folder ../shared/mocap is not beside the checkout")


def read_amc(path: Path, **options: object) -> Motion:
    motion = read(path, **{"rate": 120, **options})
    assert isinstance(motion, Motion)
    return motion


@pytest.fixture
def plain() -> Motion:
    return read_amc(AMC / "plain.amc")


def bone(name: str, direction: str, axis: str = "0 0 0 XYZ", dof: str = "", length: float = 1) -> str:
    free = f"dof {dof}\n" if dof else ""
    return f"begin\nname {name}\ndirection {direction}\nlength {length}\naxis {axis}\n{free}end\n"


def asf_text(
    bones: str,
    hierarchy: str,
    *,
    root: str = "order TX TY TZ RX RY RZ\naxis XYZ\nposition 0 0 0\norientation 0 0 0",
    units: str = "angle deg",
) -> str:
    return f":units\n{units}\n:root\n{root}\n:bonedata\n{bones}:hierarchy\nbegin\n{hierarchy}\nend\n"


def pose(folder: Path, asf: str, frame: str, **options: object) -> Motion:
    (folder / "one.asf").write_text(asf)
    (folder / "one.amc").write_text(f":FULLY-SPECIFIED\n:DEGREES\n1\n{frame}\n")
    return read_amc(folder / "one.amc", **options)


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


@needs_mocap
@pytest.mark.parametrize("name", ["02_04", "86_01"])
def test_cmu_comes_back_number_for_number(tmp_path: Path, name: str) -> None:
    path = MOCAP / f"cmu-asfamc/{name}.amc"
    write(read_amc(path), tmp_path / f"{name}.amc")
    # Some C libraries write exponents of three digits.
    expected = re.sub(rb"e-0(\d\d)\b", rb"e-\1", path.read_bytes())
    assert (tmp_path / f"{name}.amc").read_bytes() == expected
    assert (tmp_path / f"{name}.asf").read_bytes() == (MOCAP / f"cmu-asfamc/{name[:2]}.asf").read_bytes()


@needs_mocap
@pytest.mark.parametrize(
    "name", ["cmu-bvh/02_04", "cmu-bvh/35_17", "bvh-other/dab", "bvh-other/makehuman_walk1", "bvh-other/test_mocapbank"]
)
def test_a_bvh_written_as_amc_keeps_its_positions(tmp_path: Path, name: str) -> None:
    motion = read(MOCAP / f"{name}.bvh")
    assert isinstance(motion, Motion)
    write(motion, tmp_path / "out.amc")
    again = read(tmp_path / "out.amc", rate=motion.rate)
    assert isinstance(again, Motion)
    assert_same_places(motion, again, 1e-7 * np.abs(global_poses(motion).positions).max())


def assert_same_places(motion: Motion, again: Motion, tolerance: float) -> None:
    assert again.n_frames == motion.n_frames
    ours, theirs = global_poses(motion), global_poses(again)
    for joint, name in enumerate(("root", *motion.skeleton.names[1:])):
        place = theirs.positions[:, again.skeleton.index(name)]
        assert np.abs(ours.positions[:, joint] - place).max() <= tolerance, name


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


@pytest.mark.parametrize(
    "name",
    [
        "crlf_tabs_upper_case",
        "cr_only_no_final_newline",
        "comments_and_commas",
        "radians",
        "children_before_parents",
        "hierarchy_bottom_up",
        "units_after_bones",
        "limits_without_end",
        "sections_of_others",
        "other_masses",
    ],
)
def test_odd_asf(plain: Motion, name: str) -> None:
    # The AMC says degrees, whatever the ASF does.
    motion = read_amc(AMC / "plain.amc", skeleton=ASF / f"{name}.asf")
    assert motion.skeleton.names == plain.skeleton.names
    assert motion.skeleton.parents == plain.skeleton.parents
    assert motion.skeleton.offsets.tolist() == plain.skeleton.offsets.tolist()
    assert motion.rotations == pytest.approx(plain.rotations, abs=1e-14)
    assert motion.metres_per_unit == plain.metres_per_unit


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


# Finding the skeleton


@pytest.mark.parametrize(
    ("amc", "there", "found"),
    [
        ("02_04.amc", ["02.asf", "03.asf"], "02.asf"),
        ("02_04.amc", ["02.asf", "02_04.asf"], "02_04.asf"),
        ("02_04.AMC", ["02.ASF", "2.txt", "03.Asf"], "02.ASF"),
        ("02_04.amc", ["2.asf", "3.asf"], "2.asf"),
        ("Walk.amc", ["walk.asf", "run.asf"], "walk.asf"),
        ("walk_2.amc", ["walk.asf", "run.asf"], "walk.asf"),
        ("02_04.amc", ["someone.asf"], "someone.asf"),
    ],
)
def test_the_asf_is_found_beside_the_amc(tmp_path: Path, amc: str, there: list[str], found: str) -> None:
    for name in there:
        # Only the right one has the joints.
        (tmp_path / name).write_bytes(ARM.read_bytes() if name == found else b"another skeleton")
    (tmp_path / amc).write_bytes((AMC / "plain.amc").read_bytes())
    declaration = read_amc(tmp_path / amc).declaration
    assert isinstance(declaration, AsfDeclaration)
    assert declaration.asf_name == found


@pytest.mark.parametrize(
    ("there", "said"),
    [([], "which has no .asf file"), (["a.asf", "b.asf"], r"which has 2 .asf files \(a.asf, b.asf\)")],
)
def test_an_asf_that_is_not_found(tmp_path: Path, there: list[str], said: str) -> None:
    for name in there:
        (tmp_path / name).write_bytes(ARM.read_bytes())
    path = tmp_path / "02_04.amc"
    path.write_bytes((AMC / "plain.amc").read_bytes())
    with pytest.raises(FormatError, match=rf"looked for 02_04\.asf and 02\.asf, .*{said}; name it with --skeleton"):
        read_amc(path)
    assert read_amc(path, skeleton=ARM).n_frames == 3


# Broken


@pytest.mark.parametrize(
    ("name", "line", "says"),
    [
        ("empty", None, "the file is empty; expected an AMC motion"),
        ("blank", None, "the file is empty"),
        ("a_png_picture", None, "this is a PNG picture; expected an AMC motion"),
        ("a_bvh", None, "this is a BVH motion"),
        ("binary", None, "binary data, not text"),
        ("keywords_alone", 2, "ends without a frame"),
        ("no_frame_number", 3, "expected a keyword (:FULLY-SPECIFIED, :DEGREES, :RADIANS) or a frame number"),
        ("unknown_keyword_word", 1, "found 'FULLY-SPECIFIED'"),
        (
            "joint_that_the_asf_lacks",
            11,
            "frame 2 names the joint 'elbow', which ARM does not have; it has root, upper",
        ),
        ("too_many_values", 11, "frame 2 has 2 values for 'lower'; ARM gives it 1 (rx)"),
        ("too_few_values", 10, "frame 2 has 2 values for 'upper'; ARM gives it 3 (rx ry rz)"),
        ("values_for_a_joint_without", 11, "frame 2 has 1 value for 'tail'; ARM gives it none"),
        ("cut_in_a_row", 17, "frame 3 has 1 value for 'hand'; ARM gives it 2 (rx rz)"),
        ("cut_between_rows", 15, "frame 3 (line 13) ends without 'lower', 'hand', which ARM gives channels"),
        ("joint_left_out", 12, "frame 2 (line 8) ends without 'lower', which ARM gives channels"),
        ("joint_twice", 12, "frame 2 gives 'lower' twice; first in line 11"),
        ("frame_left_out", 8, "frame 3 follows frame 1; frame numbers must go up by one"),
        ("frame_twice", 8, "frame 1 follows frame 1"),
        ("frame_minus_5", 8, "expected a joint of frame 1 or the next frame, found '-5'"),
        ("frame_1e3", 8, "expected a joint of frame 1 or the next frame, found '1e3'"),
        ("nan", 11, "frame 2, joint 'lower', rx: expected a finite number, found 'nan'"),
        ("infinite", 11, "expected a finite number, found 'inf'"),
        ("too_large", 11, "1e999"),
        ("underscore", 11, "'4_7'"),
        ("other_digits", 11, "in the digits 0-9"),
        ("decimal_comma", 11, "--decimal-comma"),
        ("run_together", 10, "frame 2, joint 'upper': numbers run together in '11.0-21'"),
        ("run_on_bad_value", 11, "frame 2, joint 'upper', rz: expected a number, found 'x31'"),
        ("code", 11, "expected a number, found '__import__"),
        ("bad_rate_comment", 1, "expected a frame rate"),
    ],
)
def test_broken_amc(name: str, line: int | None, says: str) -> None:
    path = AMC / "broken" / f"{name}.amc"
    with pytest.raises(FormatError) as caught:
        read_amc(path, skeleton=ARM)
    assert caught.value.path == str(path)
    assert caught.value.line == line
    assert says.replace("ARM", str(ARM)) in str(caught.value)


def test_a_bad_number_is_named_by_column() -> None:
    with pytest.raises(FormatError) as caught:
        read_amc(AMC / "broken/run_on_bad_value.amc", skeleton=ARM)
    assert (caught.value.line, caught.value.column) == (11, 6)


@pytest.mark.parametrize(
    ("name", "line", "says"),
    [
        ("empty", None, "the file is empty; expected an ASF skeleton"),
        ("an_amc", None, "this is an AMC motion; expected an ASF skeleton"),
        ("a_web_page", None, "this is a web page"),
        ("words_before_keywords", 1, "expected a keyword such as :version or :units, found 'hello'"),
        ("no_root_section", 53, "the file ends without a :root section"),
        ("no_order", 13, "the :root section ends without an order line"),
        ("no_hierarchy", 52, "the file ends without a :hierarchy section"),
        ("two_hierarchies", 59, "a second :hierarchy; the first is in line 53"),
        ("cut_in_a_bone", 38, "the file ends in the bone that begins in line 36; expected end"),
        ("cut_in_the_hierarchy", 56, "the file ends in its hierarchy; expected end"),
        ("no_begin", 27, "expected begin, found 'id'"),
        ("no_end", 26, "expected end of the bone that begins in line 16, found begin"),
        ("end_too_many", 53, "expected begin, found 'end'"),
        ("no_name", 34, "the bone that begins in line 27 has no name"),
        ("two_words_a_name", 29, "a bone's name is one word, found 2"),
        ("no_length", 34, "bone 'lower' has no length"),
        ("no_direction", 34, "bone 'lower' has no direction"),
        ("direction_of_two", 30, "direction of bone 'lower' needs 3 numbers, found 2"),
        ("length_nan", 31, "length of bone 'lower': expected a finite number, found 'nan'"),
        ("length_of_code", 31, "length of bone 'lower': expected a number, found '__import__'"),
        ("bone_too_long", 35, "bone 'lower' is too long"),
        ("unit_length_0", 6, "length must be above 0, found '0'"),
        ("unit_angle_grad", 7, "angle is deg or rad, found 'grad'"),
        ("axis_twice", 32, "axis of bone 'lower' needs an order of the three axes such as XYZ, found 'XYY'"),
        ("dof_twice", 42, "dof of bone 'hand' lists rx twice"),
        ("dof_unknown", 42, "dof of bone 'hand' knows tx, ty, tz, rx, ry and rz, found 'rw'"),
        ("dof_length", 42, "dof of bone 'hand' changes its length (l), which retime can't hold"),
        ("a_bone_called_root", 46, "a bone is called root"),
        ("bone_twice", 46, "a second bone is called 'hand'; the first begins in line 36"),
        ("unknown_child", 57, "the hierarchy names 'paw', which is no bone of :bonedata"),
        ("unknown_parent", 57, "the hierarchy names 'elbow'"),
        ("two_parents", 58, "'hand' is attached to 'tail', and to 'lower' before"),
        ("circle", 16, "bone 'upper' hangs in a circle, not on the root"),
        ("root_below_a_bone", 57, "the root can't be attached to 'lower'"),
        ("orphan", 36, "bone 'hand' has no parent in :hierarchy"),
    ],
)
def test_broken_asf(name: str, line: int | None, says: str) -> None:
    path = ASF / "broken" / f"{name}.asf"
    with pytest.raises(FormatError) as caught:
        read_amc(AMC / "plain.amc", skeleton=path)
    assert caught.value.path == str(path)
    assert says in str(caught.value)
    assert caught.value.line == line


def test_limits(tmp_path: Path) -> None:
    path = AMC / "plain.amc"
    for limits, says in (
        (Limits(frames=2), "more than 2 frames (Limits.frames)"),
        (Limits(joints=4), "Limits.joints"),
        (Limits(depth=3), "'hand' lies deeper than 3 joints (Limits.depth)"),
        (Limits(name_bytes=4), "Limits.name_bytes"),
        (Limits(line_bytes=20), "Limits.line_bytes"),
    ):
        with pytest.raises(FormatError, match=re.escape(says)):
            read_amc(path, limits=limits)
    deep = "".join(bone(f"b{i}", "0 1 0") for i in range(5000))
    chain = "root b0\n" + "\n".join(f"b{i} b{i + 1}" for i in range(4999))
    with pytest.raises(FormatError, match=r"Limits\.joints"):
        pose(tmp_path, asf_text(deep, chain), "root 0 0 0 0 0 0")
    with pytest.raises(FormatError, match=r"deeper than 256 joints"):
        pose(tmp_path, asf_text(deep, chain), "root 0 0 0 0 0 0", limits=Limits(joints=6000))
    (tmp_path / "lines.amc").write_text("\n" * 20_000 + "1\nroot 0 0 0 0 0 0\n")
    with pytest.raises(FormatError, match="no frame begins in the first 10000 lines"):
        read_amc(tmp_path / "lines.amc", skeleton=ARM)


@pytest.mark.parametrize("name", ["too_many_values", "nan", "cut_between_rows", "frame_left_out", "underscore"])
def test_repair_keeps_the_frames_before_the_damage(plain: Motion, name: str) -> None:
    with pytest.warns(FormatWarning, match=r"[12] whole frames were kept; then .*broken"):
        motion = read_amc(AMC / "broken" / f"{name}.amc", skeleton=ARM, repair=True)
    assert motion.n_frames == (2 if name == "cut_between_rows" else 1)
    assert motion.rotations.tolist() == plain.rotations[: motion.n_frames].tolist()


def test_repair_needs_a_whole_frame() -> None:
    with pytest.raises(FormatError):
        read_amc(AMC / "broken/no_frame_number.amc", skeleton=ARM, repair=True)


def test_decimal_comma(plain: Motion) -> None:
    motion = read_amc(AMC / "broken/decimal_comma.amc", skeleton=ARM, decimal_comma=True)
    assert motion.rotations.tolist() == plain.rotations.tolist()


def test_the_largest_numbers_are_no_motion(tmp_path: Path) -> None:
    for length, shift, says in (
        (1e308, "0", "1e.100 at most"),
        (1.0, "1.5e308", "1e.100 at most"),
        (1e100, "1e100", "larger"),
    ):
        bones = bone("a", "0 1 0", length=length) + bone("b", "0 1 0", "0 0 45 XYZ", "tx ty")
        with pytest.raises(FormatError, match=says):
            pose(tmp_path, asf_text(bones, "root a\na b"), f"root 0 0 0 0 0 0\nb {shift} {shift}")


@pytest.mark.parametrize("seed", range(8))
def test_damage_ends_in_a_motion_or_a_format_error(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    amc, asf = (AMC / "comments_and_blank_lines.amc").read_bytes(), ARM.read_bytes()
    outcomes = set()
    for _ in range(60):
        (tmp_path / "a.amc").write_bytes(damaged(amc, chance) if chance.random() < 0.6 else amc)
        (tmp_path / "a.asf").write_bytes(damaged(asf, chance) if chance.random() < 0.6 else asf)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FormatWarning)
            try:
                motion = read_amc(tmp_path / "a.amc", repair=chance.random() < 0.3)
                assert np.isfinite(motion.rotations).all()
                outcomes.add("motion")
            except FormatError:
                outcomes.add("error")
    assert outcomes == {"motion", "error"}


def damaged(data: bytes, chance: random.Random) -> bytes:
    """Change, cut, repeat or swap a few pieces."""
    out = bytearray(data)
    for _ in range(chance.randint(1, 4)):
        if not out:
            break
        at, size = chance.randrange(len(out)), chance.randint(1, 12)
        kind = chance.randrange(6)
        if kind == 0:
            out[at] = chance.randrange(256)
        elif kind == 1:
            del out[at : at + size]
        elif kind == 2:
            out[at:at] = out[at : at + size]
        elif kind == 3:
            out[at:at] = chance.choice(
                [b"nan", b"1e308", b"-", b"\n", b"\r", b"\0", b"#", b"99999999999999999999", b"root "]
            )
        elif kind == 4:
            del out[at:]
        else:
            lines = out.splitlines(keepends=True)
            chance.shuffle(lines)
            out = bytearray(b"".join(lines))
    return bytes(out)


# Writing


@pytest.mark.parametrize("name", ["plain", "crlf", "cr_only", "lower_case_keywords"])
def test_a_file_comes_back_byte_for_byte(tmp_path: Path, name: str) -> None:
    path = AMC / f"{name}.amc"
    write(read_amc(path), tmp_path / "out.amc")
    assert (tmp_path / "out.amc").read_bytes() == path.read_bytes()
    assert (tmp_path / "out.asf").read_bytes() == ARM.read_bytes()


def test_radians_come_back(tmp_path: Path) -> None:
    motion = read_amc(AMC / "radians.amc")
    write(motion, tmp_path / "out.amc")
    assert b":RADIANS" in (tmp_path / "out.amc").read_bytes()
    assert read_amc(tmp_path / "out.amc").declared_angles == pytest.approx(motion.declared_angles, abs=1e-9)


def test_a_cut_keeps_its_frame_numbers_and_a_sampled_motion_counts_from_1(tmp_path: Path, plain: Motion) -> None:
    write(plain.frames(1, 3), tmp_path / "cut.amc")
    assert read_amc(tmp_path / "cut.amc").first_frame == 2
    write(plain.at(np.array([0.0, 0.004, 0.01])), tmp_path / "sampled.amc")
    assert read_amc(tmp_path / "sampled.amc").first_frame == 1


def test_an_asf_that_fits_is_left_alone(tmp_path: Path, plain: Motion) -> None:
    asf = tmp_path / "02.asf"
    # The same skeleton in other words.
    asf.write_bytes((ASF / "comments_and_commas.asf").read_bytes())
    write(plain, tmp_path / "02_01.amc")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["02.asf", "02_01.amc"]
    assert read_amc(tmp_path / "02_01.amc").rotations == pytest.approx(plain.rotations)


def test_an_asf_that_does_not_fit_is_neither_used_nor_replaced(tmp_path: Path, plain: Motion) -> None:
    other = ARM.read_bytes().replace(b"length 5", b"length 6")
    (tmp_path / "02.asf").write_bytes(other)
    write(plain, tmp_path / "02_01.amc")
    assert (tmp_path / "02.asf").read_bytes() == other
    assert (tmp_path / "02_01.asf").read_bytes() == ARM.read_bytes()
    assert read_amc(tmp_path / "02_01.amc").skeleton.offsets.tolist() == plain.skeleton.offsets.tolist()
    # An ASF of the very stem would be taken for this AMC's.
    (tmp_path / "03.ASF").write_bytes(other)
    with pytest.raises(OutputExistsError, match=r"03\.ASF"):
        write(plain, tmp_path / "03.amc")
    assert not (tmp_path / "03.amc").exists()
    write(plain, tmp_path / "03.amc", overwrite=True)
    assert (tmp_path / "03.ASF").read_bytes() == ARM.read_bytes()


def test_nothing_is_written_where_the_amc_is_there(tmp_path: Path, plain: Motion) -> None:
    (tmp_path / "a.amc").write_text("mine")
    with pytest.raises(OutputExistsError):
        write(plain, tmp_path / "a.amc")
    assert [path.name for path in tmp_path.iterdir()] == ["a.amc"]
    assert (tmp_path / "a.amc").read_text() == "mine"


def test_no_asf_stays_behind_where_the_amc_fails(tmp_path: Path, plain: Motion) -> None:
    (tmp_path / "a.amc").mkdir()
    with pytest.raises(OSError):  # noqa: PT011 (which one is the platform's choice)
        write(plain, tmp_path / "a.amc", overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["a.amc"]


def test_a_signal_is_no_amc(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match="holds a motion"):
        write(Signal(("a",), np.zeros((2, 1))), tmp_path / "a.amc")


angle = st.floats(-179.9, 179.9, allow_nan=False).map(lambda value: round(value, 6))


@settings(deadline=None, max_examples=30)
@given(frames=st.lists(st.tuples(*[angle] * 9), min_size=1, max_size=4))
def test_angles_come_back(tmp_path_factory: pytest.TempPathFactory, frames: list[tuple[float, ...]]) -> None:
    folder = tmp_path_factory.mktemp("amc")
    lines = [":FULLY-SPECIFIED", ":DEGREES"]
    for number, a in enumerate(frames, 1):
        lines += [str(number), "root 0 0 0 {:.6f} {:.6f} {:.6f}".format(*a[:3])]
        lines += ["upper {:.6f} {:.6f} {:.6f}".format(*a[3:6]), f"lower {a[6]:.6f}", f"hand {a[7]:.6f} {a[8]:.6f}"]
    (folder / "a.amc").write_text("\n".join(lines))
    motion = read_amc(folder / "a.amc", skeleton=ARM)
    write(motion, folder / "b.amc")
    again = read_amc(folder / "b.amc", skeleton=ARM)
    assert np.rad2deg(again.declared_angles) == pytest.approx(np.rad2deg(motion.declared_angles), abs=1e-6)
    # Without the file's angles to stay close to, others may be found; they must mean the same.
    write(replace(motion, declared_angles=None), folder / "c.amc")
    other = read_amc(folder / "c.amc", skeleton=ARM)
    assert np.abs(np.sum(other.rotations * motion.rotations, axis=-1)) == pytest.approx(1.0, abs=1e-12)


def test_turns_that_the_asf_does_not_free_are_written_as_near_as_can_be(tmp_path: Path, plain: Motion) -> None:
    away = rotation.from_euler("XYZ", np.deg2rad([[0.5, -0.4, 0.3], [20.0, 30.0, -40.0], [0, 0, 0]]))
    rotations = plain.rotations.copy()
    for joint in (2, 3):
        rotations[:, joint] = rotation.multiply(rotations[:, joint], away)
    bent = replace(plain, rotations=rotations)
    with pytest.warns(
        FormatWarning, match=r"joint '(lower|hand)' is off by up to [\d.]+ degrees, at frame 1 \(the largest of 2"
    ):
        write(bent, tmp_path / "a.amc")
    again = read_amc(tmp_path / "a.amc")

    def apart(joint: int, frame: int, turned: np.ndarray) -> float:
        return float(2 * np.arccos(min(1.0, abs(np.sum(rotations[frame, joint] * turned)))))

    # A search over the free angles finds nothing nearer.
    c = {
        2: rotation.from_euler("ZYX", np.deg2rad([20.0, 0, 0])),
        3: rotation.from_euler("ZYX", np.deg2rad([20.0, 0, -90])),
    }
    for joint, order in ((2, "X"), (3, "ZX")):
        for frame in range(2):

            def cost(angles: np.ndarray, joint: int = joint, order: str = order, frame: int = frame) -> float:
                turned = rotation.from_euler(order, angles)
                own = rotation.multiply(rotation.multiply(c[joint], turned), rotation.conjugate(c[joint]))
                return apart(joint, frame, own)

            starts = np.random.default_rng(7).uniform(-3, 3, (6, len(order)))
            best = min(minimize(cost, start, method="Nelder-Mead").fun for start in starts)
            assert apart(joint, frame, again.rotations[frame, joint]) <= best + 1e-6
    assert again.rotations[2] == pytest.approx(plain.rotations[2])


def test_a_joint_that_moves_away_is_refused(tmp_path: Path, plain: Motion) -> None:
    translations = plain.local_translations.copy()
    translations[1, 2, 0] += 0.25
    with pytest.raises(FormatError, match=r"joint 'lower' is 0\.25 units from its place at frame 1, .*write a BVH"):
        write(replace(plain, translations=translations), tmp_path / "a.amc")
    assert list(tmp_path.iterdir()) == []


# A skeleton from elsewhere


def elsewhere(names: tuple[str, ...]) -> Motion:
    """A root with two legs, one of them at its place, and a spine that forks; two end sites on a hand."""
    skeleton = Skeleton(
        names,
        (-1, 0, 0, 2, 3, 3, 3),
        np.array([[0, 1, 0], [0, 0, 0], [0, 2, 0.5], [0, 3, 0], [1, 2, 0], [-1, 2, 0], [1, 2, 0]], dtype=float),
        (EndSite(1, (0, -4, 0)), EndSite(4, (1, 0, 0)), EndSite(4, (1, 1, 0)), EndSite(6, (0, 0, 2))),
    )
    rng = np.random.default_rng(5)
    rotations = rotation.normalize(rng.normal(size=(6, 7, 4)))
    translations = np.broadcast_to(skeleton.offsets, (6, 7, 3)).copy()
    translations[:, 0] = rng.normal(size=(6, 3))
    return Motion(skeleton, rotations, translations, rate=Fraction(30), metres_per_unit=0.01)


def test_a_skeleton_from_elsewhere_gets_an_asf(tmp_path: Path) -> None:
    motion = elsewhere(("Hips", "Leg", "Spine", "Chest", "LeftArm", "RightArm", "Pack"))
    write(motion, tmp_path / "a.amc")
    again = read(tmp_path / "a.amc")
    assert isinstance(again, Motion)
    assert_same_places(motion, again, 1e-8)
    assert again.rate == 30
    assert again.metres_per_unit == pytest.approx(0.01)
    # Joints that stand in one place share a helper; the end sites of a hand have one each.
    helpers = set(again.skeleton.names) - set(motion.skeleton.names) - {"root"}
    assert helpers == {
        "root_to_Spine",
        "Chest_to_LeftArm",
        "Chest_to_RightArm",
        "LeftArm_to_end",
        "LeftArm_to_end_2",
    }
    ends = global_poses(again).end_positions
    for site in range(4):
        expected = global_poses(motion).end_positions[:, site]
        assert min(np.abs(ends[:, i] - expected).max() for i in range(ends.shape[1])) < 1e-8
    # It is an AMC like any other from here on.
    write(again, tmp_path / "b.amc")
    assert (tmp_path / "b.amc").read_bytes() == (tmp_path / "a.amc").read_bytes()


def test_names_that_an_asf_cannot_hold_are_renamed_and_said(tmp_path: Path) -> None:
    motion = elsewhere(("Hips", "left leg", "root", "12", "arm#", "end", "arm#"))
    with pytest.warns(
        FormatWarning, match=r"can't hold 6 of the joints' names; renamed 'left leg' to 'left_leg', 'root' to"
    ):
        write(motion, tmp_path / "a.amc")
    again = read(tmp_path / "a.amc")
    renamed = ("Hips", "left_leg", "root_2", "_12", "arm_", "end_2", "arm__2")
    named = replace(motion, skeleton=replace(motion.skeleton, names=renamed))
    assert_same_places(named, again, 1e-8)


def test_a_motion_whose_skeleton_was_changed_gets_an_asf_of_its_own(tmp_path: Path, plain: Motion) -> None:
    skeleton = replace(plain.skeleton, offsets=plain.skeleton.offsets * 2)
    translations = plain.local_translations * 2
    longer = replace(plain, skeleton=skeleton, translations=translations)
    write(longer, tmp_path / "a.amc")
    assert_same_places(longer, read_amc(tmp_path / "a.amc"), 1e-7)


def test_angles_made_up_for_a_skeleton_from_elsewhere_change_little_between_frames(tmp_path: Path) -> None:
    # A slow turn that passes the right angle of the middle axis, where plain angles jump by half a turn.
    skeleton = Skeleton(("a", "b"), (-1, 0), np.array([[0.0, 0, 0], [0, 1, 0]]))
    angles = np.stack([np.full(200, 0.3), np.linspace(-4, 4, 200), np.full(200, -0.2)], axis=-1)
    rotations = np.stack([rotation.from_euler("ZYX", angles)] * 2, axis=1)
    write(Motion(skeleton, rotations, rate=Fraction(120)), tmp_path / "a.amc")
    written = read_amc(tmp_path / "a.amc").declared_angles
    assert written is not None
    assert np.rad2deg(np.abs(np.diff(written, axis=0))).max() < 3


def test_a_bad_number_far_into_a_long_file(tmp_path: Path) -> None:
    frame = "root 1 2 3 4 5 6\nupper 1 2 3\nlower 4\nhand 5 6\n"
    text = ":FULLY-SPECIFIED\n:DEGREES\n" + "".join(f"{number}\n{frame}" for number in range(11, 4011))
    # Frame 3990 begins in line 3 + 5 * 3979; the hand stands four lines on.
    (tmp_path / "a.amc").write_text(text.replace("3990\n" + frame, "3990\n" + frame.replace("hand 5 6", "hand 5 6x")))
    with pytest.raises(FormatError, match="frame 3990, joint 'hand', rz: expected a number, found '6x'") as caught:
        read_amc(tmp_path / "a.amc", skeleton=ARM)
    assert (caught.value.line, caught.value.column) == (3 + 5 * 3979 + 4, 8)
    with pytest.warns(FormatWarning, match="3979 whole frames were kept"):
        motion = read_amc(tmp_path / "a.amc", skeleton=ARM, repair=True)
    assert (motion.n_frames, motion.first_frame) == (3979, 11)
