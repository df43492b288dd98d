"""Writing BVH: a file comes back as it was declared; motions from elsewhere get channels that hold them."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatError, FormatWarning, OutputExistsError
from retime.formats import read, write
from retime.formats.bvh import BvhDeclaration
from retime.motion import rotation
from retime.motion.euler import angle_between
from retime.motion.kinematics import global_poses
from retime.motion.motion import Declaration, Motion
from retime.motion.rate import rate_from_frame_time
from retime.motion.signal import Signal
from retime.motion.skeleton import EndSite, Skeleton

DATA = Path(__file__).resolve().parents[1] / "data/bvh"
LEGAL = sorted(path for path in DATA.glob("*.bvh") if not path.stem.startswith("broken_"))


def load(path: Path, **options: object) -> Motion:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        motion = read(path, **options)
    assert isinstance(motion, Motion)
    return motion


def numbers_after_frame_time(path: Path) -> np.ndarray:
    data = path.read_bytes()
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        data = data.decode("utf-16").encode()
    rows = re.split(rb"(?i)frame time:", data)[1].split()[1:]
    return np.array(list(map(float, rows)))


@pytest.mark.parametrize("path", LEGAL, ids=lambda path: path.stem)
def test_a_file_comes_back(path: Path, tmp_path: Path) -> None:
    motion = load(path)
    copy = tmp_path / path.name
    write(motion, copy)
    # Read without leave to warn: what was written is plain.
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        if path.stem == "names_latin1":
            warnings.simplefilter("ignore", FormatWarning)
        again = read(copy)
    assert isinstance(again, Motion)
    assert again.skeleton.names == motion.skeleton.names
    assert again.skeleton.parents == motion.skeleton.parents
    assert again.skeleton.end_sites == motion.skeleton.end_sites
    np.testing.assert_array_equal(again.skeleton.offsets, motion.skeleton.offsets)
    assert again.declaration == motion.declaration
    assert again.rate == motion.rate
    np.testing.assert_allclose(numbers_after_frame_time(copy), numbers_after_frame_time(path), rtol=0, atol=1e-6)


def test_the_text(tmp_path: Path) -> None:
    write(load(DATA / "plain.bvh"), tmp_path / "text.bvh")
    assert (tmp_path / "text.bvh").read_bytes() == (
        b"HIERARCHY\nROOT Hips\n{\n\tOFFSET 0.0 0.0 0.0\n"
        b"\tCHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation\n"
        b"\tJOINT Knee\n\t{\n\t\tOFFSET 0.0 -4.0 0.0\n\t\tCHANNELS 3 Zrotation Yrotation Xrotation\n"
        b"\t\tEnd Site\n\t\t{\n\t\t\tOFFSET 0.0 -3.0 0.5\n\t\t}\n\t}\n}\n"
        b"MOTION\nFrames: 2\nFrame Time: 0.033333\n"
        b"1.000000 2.000000 3.000000 90.000000 0.000000 0.000000 0.000000 0.000000 0.000000\n"
        b"1.500000 2.500000 -3.500000 0.000000 0.000000 0.000000 10.000000 20.000000 30.000000\n"
    )


def test_names_in_latin1_keep_their_bytes(tmp_path: Path) -> None:
    write(load(DATA / "names_latin1.bvh"), tmp_path / "copy.bvh")
    assert b"Genou_droit_\xe9\n" in (tmp_path / "copy.bvh").read_bytes()


def test_frames_between_keep_to_the_angles_of_the_file(tmp_path: Path) -> None:
    """A retimed motion is written with angles near those that the file had, whole turns included."""
    motion = load(DATA / "angles_beyond_half_turns.bvh")
    turned = rotation.from_euler("ZYX", np.radians([[[1.0, 2.0, 3.0]]]))
    nudged = replace(motion, rotations=rotation.multiply(motion.rotations, turned))
    write(nudged, tmp_path / "nudged.bvh")
    values = numbers_after_frame_time(tmp_path / "nudged.bvh")
    # The middle angle of 95 degrees makes the outer ones sensitive, but not by a half turn.
    np.testing.assert_allclose(values, numbers_after_frame_time(DATA / "angles_beyond_half_turns.bvh"), atol=30)
    again = load(tmp_path / "nudged.bvh")
    assert np.degrees(angle_between(again.rotations, nudged.rotations)).max() < 3e-6


@pytest.mark.parametrize(
    "rate",
    [
        Fraction(24),
        Fraction(25),
        Fraction(30),
        Fraction(60),
        Fraction(90),
        Fraction(119),
        Fraction(120),
        Fraction(1000),
        Fraction(24000, 1001),
        Fraction(30000, 1001),
        Fraction(60000, 1001),
        Fraction(100, 3),
        Fraction(7, 3),
        Fraction(59469, 2000),
        Fraction(1, 7),
        Fraction(1, 19),
        Fraction(1, 10**6),
        Fraction(10**6),
        Fraction(1000000, 33333),
    ],
)
def test_any_rate_survives(tmp_path: Path, rate: Fraction) -> None:
    write(load(DATA / "plain.bvh").with_rate(rate), tmp_path / "rate.bvh")
    assert load(tmp_path / "rate.bvh").rate == rate


def test_frame_time_is_as_declared_only_where_it_still_gives_the_rate(tmp_path: Path) -> None:
    write(load(DATA / "plain.bvh", rate=120), tmp_path / "fast.bvh")
    text = (tmp_path / "fast.bvh").read_text()
    assert "Frame Time: 0.008333333\n" in text
    assert rate_from_frame_time("0.008333333") == 120
    write(load(DATA / "plain.bvh", rate=25), tmp_path / "slow.bvh")
    assert "Frame Time: 0.04\n" in (tmp_path / "slow.bvh").read_text()


def test_a_rate_that_no_decimal_gives_is_said(tmp_path: Path) -> None:
    rate = Fraction(10**25 + 1, 3 * 10**23 + 7)
    with pytest.warns(FormatWarning, match="no decimal frame time gives the rate"):
        write(load(DATA / "plain.bvh").with_rate(rate), tmp_path / "rate.bvh")
    assert float(load(tmp_path / "rate.bvh").rate) == float(rate)


def make_arm(**parts: object) -> Motion:
    """Make a motion that no file declared: two joints, three frames."""
    skeleton = Skeleton(("upper", "lower"), (-1, 0), np.array([[0, 1, 0], [2.5, 0, 0]]), (EndSite(1, (1.0, 0.0, 0.0)),))
    angles = np.radians([[[170, 20, 30], [10, 0, 0]], [[179, 25, 30], [20, 0, 0]], [[188, 30, 30], [30, 0, 0]]])
    return replace(Motion(skeleton, rotation.from_euler("ZYX", angles), rate=Fraction(60)), **parts)


def test_motion_from_elsewhere_gets_six_channels_at_the_root(tmp_path: Path) -> None:
    arm = make_arm()
    write(arm, tmp_path / "arm.bvh")
    again = load(tmp_path / "arm.bvh")
    assert again.declaration is not None
    assert again.declaration.channels == (
        ("Xposition", "Yposition", "Zposition", "Zrotation", "Yrotation", "Xrotation"),
        ("Zrotation", "Yrotation", "Xrotation"),
    )
    np.testing.assert_allclose(global_poses(again).positions, global_poses(arm).positions, atol=1e-6)
    np.testing.assert_allclose(global_poses(again).end_positions, global_poses(arm).end_positions, atol=1e-6)
    assert again.skeleton.offsets.tolist() == arm.skeleton.offsets.tolist()
    # Angles run on past the half turn instead of jumping to -172.
    values = numbers_after_frame_time(tmp_path / "arm.bvh").reshape(3, 9)
    np.testing.assert_allclose(values[:, 3], [170, 179, 188], atol=1e-6)


def test_joints_that_leave_their_offset_get_position_channels(tmp_path: Path) -> None:
    arm = make_arm()
    moved = arm.local_translations.copy()
    moved[2, 1, 0] = 2.75
    write(replace(arm, translations=moved), tmp_path / "arm.bvh")
    again = load(tmp_path / "arm.bvh")
    assert again.declaration is not None
    assert again.declaration.channels[1] == (
        *("Xposition", "Yposition", "Zposition"),
        *("Zrotation", "Yrotation", "Xrotation"),
    )
    np.testing.assert_allclose(again.local_translations, moved, atol=1e-6)


def test_joints_in_another_order_are_sorted_into_the_tree(tmp_path: Path) -> None:
    """Braces need a joint's whole subtree before its next sibling; a motion's own order need not be that."""
    skeleton = Skeleton(
        ("hip", "left", "right", "left_toe", "right_toe"),
        (-1, 0, 0, 1, 2),
        np.arange(15.0).reshape(5, 3),
        (EndSite(4, (0.0, 0.0, 4.0)), EndSite(3, (0.0, 0.0, 3.0))),
    )
    generator = np.random.default_rng(5)
    motion = Motion(skeleton, rotation.from_euler("XYZ", generator.normal(size=(4, 5, 3))))
    write(motion, tmp_path / "tree.bvh")
    again = load(tmp_path / "tree.bvh")
    assert again.skeleton.names == ("hip", "left", "left_toe", "right", "right_toe")
    ours, theirs = global_poses(motion), global_poses(again)
    for joint, name in enumerate(skeleton.names):
        np.testing.assert_allclose(
            theirs.positions[:, again.skeleton.index(name)], ours.positions[:, joint], atol=1e-5, err_msg=name
        )
    np.testing.assert_allclose(theirs.end_positions, ours.end_positions[:, ::-1], atol=1e-5)


@pytest.mark.parametrize(
    ("name", "written"),
    [("", "joint_1"), ("  ", "joint_1"), ("a\r\nb\nc", "a_b_c"), (" knee\t", "knee"), ("\ud800", "?")],
)
def test_names_that_bvh_cannot_hold(tmp_path: Path, name: str, written: str) -> None:
    arm = make_arm()
    named = replace(arm, skeleton=Skeleton(("upper", name), (-1, 0), arm.skeleton.offsets))
    message = re.escape(f"arm.bvh: a joint's name that BVH can't hold was changed: {name!r} is written as {written!r}")
    with pytest.warns(FormatWarning, match=message):
        write(named, tmp_path / "arm.bvh")
    assert load(tmp_path / "arm.bvh").skeleton.names == ("upper", written)


@pytest.mark.parametrize(
    "name", ["{", "a {", "}", "JOINT", "a  b", "\x00", "# x", "%s %d", "\x85x", ".\x0b.", '"', "End Site"]
)
def test_strange_names_come_back(tmp_path: Path, name: str) -> None:
    arm = make_arm()
    write(replace(arm, skeleton=Skeleton((name, name), (-1, 0), arm.skeleton.offsets)), tmp_path / "arm.bvh")
    assert load(tmp_path / "arm.bvh").skeleton.names == (name, name)


def declared(*channels: tuple[str, ...]) -> BvhDeclaration:
    return BvhDeclaration("bvh", channels)


@pytest.mark.parametrize("turns", [(), ("Zrotation",), ("Yrotation", "Xrotation"), ("Zrotation", "Xrotation")])
def test_too_few_rotation_channels_write_the_nearest_and_say_how_far_off(
    tmp_path: Path, turns: tuple[str, ...]
) -> None:
    arm = make_arm(declaration=declared(("Zrotation", "Yrotation", "Xrotation"), turns))
    tilt = rotation.from_euler("XYZ", np.radians([[20.0, 30.0, 40.0], [5.0, 5.0, 5.0], [0.0, 0.0, 0.0]]))
    rotations = np.stack([arm.rotations[:, 0], tilt], axis=1)
    with pytest.warns(FormatWarning) as caught:
        write(replace(arm, rotations=rotations), tmp_path / "arm.bvh")
    found = re.search(
        r"joint 'lower' has too few rotation channels for its rotation at frame 0: the nearest was written, "
        r"([0-9.]+) degrees off",
        str(caught[0].message),
    )
    assert found is not None
    again = load(tmp_path / "arm.bvh")
    off = np.degrees(angle_between(again.rotations[:, 1], tilt))
    assert off[0] == pytest.approx(float(found[1]), rel=5e-3)
    # No angles on a fine grid do better.
    order = "".join(name[0] for name in turns)
    if order:
        grid = np.stack(np.meshgrid(*[np.radians(np.arange(-60.0, 60.0, 1.0))] * len(order)), axis=-1)
        candidates = rotation.from_euler(order, grid.reshape(-1, len(order)))
        assert np.degrees(angle_between(candidates, tilt[0])).min() >= off[0] - 1e-6


def test_rotations_that_few_channels_do_express_are_no_cause_to_warn(tmp_path: Path) -> None:
    arm = make_arm(declaration=declared(("Zrotation", "Yrotation", "Xrotation"), ("Yrotation", "Zrotation")))
    turned = rotation.from_euler("YZ", np.radians([[170.0, 20.0], [185.0, 25.0], [200.0, 190.0]]))
    write(replace(arm, rotations=np.stack([arm.rotations[:, 0], turned], axis=1)), tmp_path / "arm.bvh")
    values = numbers_after_frame_time(tmp_path / "arm.bvh").reshape(3, 5)
    np.testing.assert_allclose(values[:, 3], [170, 185, 200], atol=1e-6)


def test_movement_without_channels_is_said(tmp_path: Path) -> None:
    arm = make_arm(declaration=declared(("Yposition", "Zrotation", "Yrotation", "Xrotation"), ("Zrotation",)))
    moved = arm.local_translations.copy()
    moved[1, 0, 2] = -0.75
    message = "joint 'upper' has no channel Zposition: its offset was written at frame 1, 0.75 units off"
    with pytest.warns(FormatWarning, match=message):
        write(replace(arm, translations=moved), tmp_path / "arm.bvh")


@pytest.mark.parametrize("channels", [("Wrotation",), ("Xrotation", "Xrotation"), ("xrotation",)])
def test_a_declaration_that_bvh_does_not_have(tmp_path: Path, channels: tuple[str, ...]) -> None:
    arm = make_arm(declaration=declared(("Yposition",), channels))
    with pytest.raises(FormatError, match="joint 'lower' declares the channels"):
        write(arm, tmp_path / "arm.bvh")
    assert list(tmp_path.iterdir()) == []


def test_a_declaration_of_another_format_or_skeleton_is_not_used(tmp_path: Path) -> None:
    for declaration in (Declaration("amc", (("rx",), ("ry",))), declared(("Xrotation",))):
        write(make_arm(declaration=declaration), tmp_path / "arm.bvh", overwrite=True)
        assert "CHANNELS 3 Zrotation Yrotation Xrotation" in (tmp_path / "arm.bvh").read_text()


def test_a_plain_declaration_is_enough(tmp_path: Path) -> None:
    channels = (("Xrotation", "Yrotation", "Zrotation"), ("Zrotation", "Yrotation", "Xrotation"))
    write(make_arm(declaration=Declaration("bvh", channels, "0.016667")), tmp_path / "arm.bvh")
    again = load(tmp_path / "arm.bvh")
    assert again.declaration is not None
    assert again.declaration.channels == channels
    assert again.declaration.frame_time == "0.016667"


def test_numbers_too_large_for_six_exact_decimals(tmp_path: Path) -> None:
    arm = make_arm()
    far = arm.local_translations.copy()
    far[1, 0] = [1e12 + 0.25, -1e99, 3e9]
    write(replace(arm, translations=far), tmp_path / "arm.bvh")
    assert load(tmp_path / "arm.bvh").local_translations[1, 0].tolist() == far[1, 0].tolist()


def test_offsets_keep_every_digit(tmp_path: Path) -> None:
    offsets = np.array([[1 / 3, -1e-7, 1e22], [5e-324, -0.0, 123456.789]])
    arm = make_arm()
    write(replace(arm, skeleton=Skeleton(("a", "b"), (-1, 0), offsets)), tmp_path / "arm.bvh")
    again = load(tmp_path / "arm.bvh").skeleton.offsets
    assert again.tolist() == offsets.tolist()
    assert np.signbit(again).tolist() == np.signbit(offsets).tolist()
    assert "e" not in (tmp_path / "arm.bvh").read_text().split("OFFSET")[1].split("\n")[0]


def test_an_existing_file_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "arm.bvh"
    path.write_text("mine")
    with pytest.raises(OutputExistsError):
        write(make_arm(), path)
    assert path.read_text() == "mine"
    write(make_arm(), path, overwrite=True)
    assert path.read_text().startswith("HIERARCHY")
    assert list(tmp_path.iterdir()) == [path]


def test_a_signal_is_no_motion(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"a \.bvh file holds a motion, not a signal"):
        write(Signal(("x",), np.zeros((3, 1))), tmp_path / "arm.bvh")


def test_a_deep_skeleton(tmp_path: Path) -> None:
    """A chain of 3,000 joints is written without recursion (and its reading would need another limit)."""
    depth = 3000
    skeleton = Skeleton(tuple(f"j{i}" for i in range(depth)), (-1, *range(depth - 1)), np.ones((depth, 3)))
    write(Motion(skeleton, rotation.identity(1, depth)), tmp_path / "deep.bvh")
    assert (tmp_path / "deep.bvh").read_bytes().count(b"}") == depth


def test_angles_of_billions_of_turns_come_back(tmp_path: Path) -> None:
    text = (
        "HIERARCHY\nROOT Hips\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Yrotation Xrotation\n"
        "End Site\n{\nOFFSET 0 1 0\n}\n}\nMOTION\nFrames: 2\nFrame Time: 0.033333\n90 0 5e26\n0 -7e15 1e9\n"
    )
    (tmp_path / "a.bvh").write_text(text)
    motion = read(tmp_path / "a.bvh")
    angles = [[90, 0, int(5e26) % 360], [0, -int(7e15) % 360, 10**9 % 360]]
    expected = rotation.from_euler("ZYX", np.deg2rad(np.array(angles, dtype=float)))
    assert np.rad2deg(angle_between(motion.rotations[:, 0], expected)).max() < 1e-6
    write(motion, tmp_path / "b.bvh")
    again = read(tmp_path / "b.bvh")
    assert np.rad2deg(angle_between(motion.rotations, again.rotations)).max() < 1e-6
