"""ASF: odd but legal skeletons, broken ones, and where the one of an AMC is found."""

from __future__ import annotations

from pathlib import Path

import pytest

from retime.errors import FormatError
from retime.formats.amc_declaration import AsfDeclaration
from retime.motion.motion import Motion
from tests.formats.amc_files import AMC, ARM, ASF, read_amc


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
