"""BVH files that are odd but legal: each loads, with the right values."""

from __future__ import annotations

import re
import warnings
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatWarning
from retime.formats import read
from retime.formats.bvh import BvhDeclaration
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.rotation import to_matrix

DATA = Path(__file__).resolve().parents[1] / "data/bvh"

ROOT_CHANNELS = ("Xposition", "Yposition", "Zposition", "Zrotation", "Yrotation", "Xrotation")
TURNS = ("Zrotation", "Yrotation", "Xrotation")


def load(name: str, **options: object) -> Motion:
    motion = read(DATA / f"{name}.bvh", **options)
    assert isinstance(motion, Motion)
    return motion


def matrix(axis: str, degrees: float) -> np.ndarray:
    """Write out a rotation matrix as a textbook does."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return {
        "X": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
        "Y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
        "Z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
    }[axis]


def turn(order: str, *degrees: float) -> np.ndarray:
    result = np.eye(3)
    for axis, angle in zip(order, degrees, strict=True):
        result = result @ matrix(axis, angle)
    return result


def assert_rotation(motion: Motion, frame: int, joint: int, expected: np.ndarray) -> None:
    np.testing.assert_allclose(to_matrix(motion.rotations[frame, joint]), expected, atol=1e-12)


def assert_plain(motion: Motion, names: tuple[str, ...] = ("Hips", "Knee")) -> None:
    """Check the two frames that most of the quirky files hold."""
    assert motion.skeleton.names == names
    assert motion.skeleton.parents == (-1, 0)
    assert motion.skeleton.offsets.tolist() == [[0, 0, 0], [0, -4, 0]]
    assert [(site.parent, site.offset) for site in motion.skeleton.end_sites] == [(1, (0.0, -3.0, 0.5))]
    assert motion.rate == 30
    assert motion.local_translations.tolist() == [[[1, 2, 3], [0, -4, 0]], [[1.5, 2.5, -3.5], [0, -4, 0]]]
    assert_rotation(motion, 0, 0, turn("Z", 90))
    assert_rotation(motion, 0, 1, np.eye(3))
    assert_rotation(motion, 1, 0, np.eye(3))
    assert_rotation(motion, 1, 1, turn("ZYX", 10, 20, 30))
    assert motion.declaration is not None
    assert motion.declaration.channels == (ROOT_CHANNELS, TURNS)
    assert motion.declared_angles is not None
    np.testing.assert_allclose(np.degrees(motion.declared_angles[1, 1]), [10, 20, 30])


def test_plain() -> None:
    motion = load("plain")
    assert_plain(motion)
    assert motion.name == "plain"
    assert motion.metres_per_unit is None
    assert motion.first_frame == 0
    assert motion.declaration == BvhDeclaration("bvh", (ROOT_CHANNELS, TURNS), "0.033333")
    poses = global_poses(motion)
    # A quarter turn about Z carries the leg from -Y to +X.
    np.testing.assert_allclose(poses.positions[0], [[1, 2, 3], [5, 2, 3]], atol=1e-12)
    np.testing.assert_allclose(poses.end_positions[0], [[8, 2, 3.5]], atol=1e-12)


@pytest.mark.parametrize(
    "name",
    [
        "bare_points_and_plus_signs",
        "blank_lines_and_trailing_spaces",
        "braces_on_the_line_before",
        "byte_order_mark",
        "channels_before_offset",
        "channels_wrapped",
        "cr_only",
        "crlf",
        "crlf_no_final_newline",
        "end_name_without_site",
        "end_site_with_name",
        "end_site_without_any_word",
        "lower_case_keywords",
        "mixed_line_ends",
        "no_final_newline",
        "rows_wrapped",
        "scientific_notation",
        "spaces_around_colons",
        "tabs",
        "utf16_big_endian",
        "utf16_little_endian",
    ],
)
def test_another_writing_of_the_same_motion(name: str) -> None:
    assert_plain(load(name))


@pytest.mark.parametrize(
    ("name", "names"),
    [
        ("joint_called_end", ("Hips", "Knee_End")),
        ("name_that_ends_in_a_brace", ("Hips", "Knee {")),
        ("names_cjk", ("センター", "左ひざ")),
        ("names_duplicate", ("Hips", "Hips")),
        ("names_with_spaces_colons_dots", ("Armature: Hips", "mixamorig:Left Leg.001")),
    ],
)
def test_names(name: str, names: tuple[str, ...]) -> None:
    assert_plain(load(name), names)


def test_names_that_are_not_utf8() -> None:
    with pytest.warns(FormatWarning, match="names_latin1.bvh: the joint names are not UTF-8; read as Latin-1"):
        motion = load("names_latin1")
    assert_plain(motion, ("Hips", "Genou_droit_é"))


def test_decimal_comma() -> None:
    assert_plain(load("broken_11_decimal_comma", decimal_comma=True))


def test_rotation_order_differs_by_joint() -> None:
    motion = load("rotation_order_differs_by_joint")
    assert_rotation(motion, 0, 0, turn("ZYX", 10, 20, 30))
    assert_rotation(motion, 0, 1, turn("XYZ", 40, 50, 60))
    assert_rotation(motion, 0, 2, turn("YZX", 70, 80, -85))
    assert motion.declared_angles is not None
    np.testing.assert_allclose(np.degrees(motion.declared_angles[0, 2]), [70, 80, -85])


def test_rotation_before_position_and_positions_in_another_order() -> None:
    motion = load("rotation_before_position")
    assert motion.local_translations[0, 0].tolist() == [8, 9, 7]
    assert_rotation(motion, 0, 0, turn("ZYX", 10, 20, 30))
    assert_rotation(motion, 0, 1, turn("ZYX", 40, 50, 60))


def test_positions_replace_the_offset_of_their_joint() -> None:
    motion = load("positions_on_inner_joints")
    assert motion.local_translations[0].tolist() == [[0, 0, 0], [0.5, 6, -0.5], [0, 2, 0.25]]
    head = turn("ZYX", 10, 20, 30) @ (np.array([0.5, 6, -0.5]) + turn("ZYX", 40, 50, 60) @ np.array([0, 2, 0.25]))
    np.testing.assert_allclose(global_poses(motion).positions[0, 2], head, atol=1e-12)


def test_mixed_3_and_6_channels() -> None:
    motion = load("mixed_3_and_6_channels")
    assert motion.local_translations[0].tolist() == [[0, 0, 0], [0, 5, 0], [0.5, 3, -0.5]]
    assert_rotation(motion, 0, 1, turn("ZYX", 40, 50, 60))
    assert_rotation(motion, 0, 2, turn("ZYX", 70, 80, -85))


def test_an_axis_without_a_channel_keeps_its_offset() -> None:
    motion = load("position_on_one_axis")
    assert motion.local_translations[0].tolist() == [[1, 9, 3], [0, 5, -4], [0, 2, 0.25]]
    assert_rotation(motion, 0, 1, np.eye(3))


def test_fewer_than_3_rotations() -> None:
    motion = load("fewer_than_3_rotations")
    assert_rotation(motion, 0, 0, turn("XZ", 40, 50))
    assert_rotation(motion, 0, 1, np.eye(3))
    assert_rotation(motion, 0, 2, turn("Y", -85))
    assert motion.local_translations[0].tolist() == [[1, 2, 3], [0, 5, 0], [0, 2, 0.25]]


def test_zero_length_offsets() -> None:
    motion = load("zero_length_offsets")
    np.testing.assert_allclose(global_poses(motion).positions[0], np.zeros((3, 3)), atol=0)


@pytest.mark.parametrize(
    ("name", "sites"),
    [
        ("joint_without_end_site", []),
        ("several_end_sites", [(1, (1.0, 0.0, 0.0)), (1, (-1.0, 0.0, 0.0)), (2, (0.0, 1.0, 0.0))]),
    ],
)
def test_end_sites(name: str, sites: list[object]) -> None:
    assert [(site.parent, site.offset) for site in load(name).skeleton.end_sites] == sites


def test_angles_beyond_half_turns() -> None:
    motion = load("angles_beyond_half_turns")
    assert_rotation(motion, 0, 0, turn("ZYX", 10, 170, -160))
    assert motion.declared_angles is not None
    np.testing.assert_allclose(np.degrees(motion.declared_angles[0, 1]), [-540, 95, 1000])


def test_single_frame() -> None:
    motion = load("single_frame")
    assert motion.n_frames == 1
    assert motion.end_time == 0


@pytest.mark.parametrize(
    ("name", "n_frames", "message"),
    [
        ("frames_claims_one_more", 2, ":17: Frames: 3 claimed, 2 there; kept all 2"),
        ("frames_claims_one_less", 2, ":17: Frames: 1 claimed, 2 there; kept all 2"),
        ("frames_claims_far_less", 8, ":17: Frames: 2 claimed, 8 there; kept all 8"),
    ],
)
def test_another_count_of_frames_than_claimed(name: str, n_frames: int, message: str) -> None:
    path = DATA / f"{name}.bvh"
    with pytest.warns(FormatWarning, match=f"^{re.escape(str(path) + message)}$"):
        motion = read(path)
    assert motion.n_frames == n_frames


def test_120_hz_called_30() -> None:
    motion = load("plain", rate=120)
    assert motion.rate == 120
    assert motion.declaration is not None
    assert motion.declaration.frame_time == "0.033333"


@pytest.mark.parametrize(
    "name",
    [
        "broken_08_frame_time_zero",
        "broken_08_frame_time_negative",
        "broken_08_frame_time_nan",
        "broken_08_frame_time_missing",
    ],
)
def test_a_given_rate_makes_up_for_a_broken_frame_time(name: str) -> None:
    motion = load(name, rate="30000/1001")
    assert motion.rate == Fraction(30000, 1001)
    assert motion.n_frames == 2
    assert motion.declaration is not None
    assert motion.declaration.frame_time == ""


def test_blender_export() -> None:
    motion = load("blender_two_roots")
    assert motion.rate == 24
    assert motion.skeleton.names == ("__0", "pelvis", "spine", "thigh.L", "prop")
    assert motion.skeleton.parents == (-1, 0, 1, 1, 0)
    poses = global_poses(motion)
    np.testing.assert_allclose(
        poses.positions[0], [[0, 0, 0], [0, 0.9, 0], [0, 1.1, 0], [0.1, 0.9, 0], [1, 0, 0]], atol=1e-12
    )
    # Frame 1: the pelvis turns by 90 degrees about Y, so that its x points to -z; the prop by as much about Z.
    np.testing.assert_allclose(
        poses.positions[1],
        [[0, 0, 0], [0.01, 0.95, -0.02], [0.01, 1.15, -0.02], [0.01, 0.96, -0.14], [1.5, 0.25, 0]],
        atol=1e-12,
    )
    np.testing.assert_allclose(poses.end_positions[1, 2], [1.0, 0.25, 0], atol=1e-12)


def test_no_warning_where_nothing_is_odd() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load("plain")


@pytest.mark.parametrize("wrap", [7, 64, 100, 193])
def test_wrapped_rows_across_the_blocks_that_are_parsed_at_once(tmp_path: Path, wrap: int) -> None:
    """Rows wrapped at any width, in a file longer than a block of the parser (half a megabyte)."""
    n_joints, n_frames = 64, 600
    values = np.round(np.random.default_rng(3).normal(size=(n_frames, 3 * n_joints)), 3)
    joints = "".join(
        f"JOINT j{i}\n{{\nOFFSET 0 1 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n" for i in range(n_joints)
    )
    text = ["HIERARCHY\n", joints.replace("JOINT", "ROOT", 1), "}\n" * n_joints]
    text.append(f"MOTION\nFrames: {n_frames}\nFrame Time: 0.01\n")
    for row in values:
        for start in range(0, len(row), wrap):
            text.append(" ".join(f"{value:.3f}" for value in row[start : start + wrap]) + "\n")
    path = tmp_path / "wrapped.bvh"
    path.write_text("".join(text))
    motion = read(path)
    assert isinstance(motion, Motion)
    assert motion.declared_angles is not None
    np.testing.assert_array_equal(motion.declared_angles.reshape(n_frames, -1), np.deg2rad(values))


@pytest.mark.parametrize(
    ("written", "rate", "words"),
    [("33.333", 30, "taken for milliseconds, 30 Hz"), ("30", 30, "taken for a rate, 30 Hz")],
)
def test_a_frame_time_that_is_none_is_repaired_aloud(tmp_path: Path, written: str, rate: int, words: str) -> None:
    text = (DATA / "plain.bvh").read_text()
    before = next(line for line in text.splitlines() if line.startswith("Frame Time:"))
    path = tmp_path / "wrong.bvh"
    path.write_text(text.replace(before, f"Frame Time: {written}"))
    line = text.splitlines().index(before) + 1
    with pytest.warns(FormatWarning, match=rf"wrong.bvh:{line}: a frame time of {written} s .* {words}"):
        assert read(path).rate == rate
    # Who says the rate is believed, and nothing is repaired.
    assert read(path, rate=25).rate == 25
    path.write_text(text.replace(before, "Frame Time: 3"))
    assert read(path).rate == Fraction(1, 3)
