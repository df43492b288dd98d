"""AMC files that are damaged, too large, or end too soon: refused with their place, or repaired."""

from __future__ import annotations

import random
import re
import warnings
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatError, FormatWarning
from retime.formats import Limits
from retime.motion.motion import Motion
from tests.formats.amc_files import AMC, ARM, asf_text, bone, pose, read_amc


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


def test_repair_parts_numbers_that_run_together(tmp_path: Path) -> None:
    text = (AMC / "broken/run_together.amc").read_text()
    (tmp_path / "apart.amc").write_text(text.replace("11.0-21", "11.0 -21"))
    with pytest.warns(FormatWarning, match=r"parted in 1 place; first .*run_together.amc:10.*run together"):
        motion = read_amc(AMC / "broken/run_together.amc", skeleton=ARM, repair=True)
    apart = read_amc(tmp_path / "apart.amc", skeleton=ARM)
    np.testing.assert_array_equal(motion.rotations, apart.rotations)


def test_numbers_that_would_be_too_many_are_not_parted(tmp_path: Path) -> None:
    text = (AMC / "broken/run_together.amc").read_text()
    (tmp_path / "glued.amc").write_text(text.replace("11.0-21", "11.0-21-3"))
    with pytest.warns(FormatWarning, match="1 whole frames were kept.*run together"):
        motion = read_amc(tmp_path / "glued.amc", skeleton=ARM, repair=True)
    assert motion.n_frames == 1


@pytest.mark.parametrize("end", [b"\x1a", bytes(50), b"\r\n\x1a\0\0\n"])
def test_padding_at_the_end_is_no_damage(tmp_path: Path, plain: Motion, end: bytes) -> None:
    (tmp_path / "arm.asf").write_bytes(ARM.read_bytes() + end)
    (tmp_path / "arm.amc").write_bytes((AMC / "plain.amc").read_bytes().rstrip() + end)
    padded = read_amc(tmp_path / "arm.amc")
    np.testing.assert_array_equal(padded.rotations, plain.rotations)
    np.testing.assert_array_equal(padded.local_translations, plain.local_translations)
