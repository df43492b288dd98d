"""Broken BVH files: each is refused with its place, what was expected and what was found. And the limits."""

from __future__ import annotations

import time
import tracemalloc
from pathlib import Path

import pytest

from retime.errors import FormatError, FormatWarning
from retime.formats import Limits, read

DATA = Path(__file__).resolve().parents[1] / "data/bvh"

REPAIR = "--repair (repair=True) keeps what is there"
RATE = "where the file is no help, give the rate (--fps, rate=)"
COMMA = "if this file writes decimals with a comma, say so (--decimal-comma, decimal_comma=True)"
COUNT = "expected a whole number of 0 or more, found"
ALLOWED = "Xposition, Yposition, Zposition, Xrotation, Yrotation, Zrotation"

# What a person reads, after the name of the file. The numbers are those of the list in the reliability notes.
MESSAGES = {
    "01_empty": ": empty; expected HIERARCHY",
    "01_blank": ": empty; expected HIERARCHY",
    "02_png": ":1: expected HIERARCHY, found a PNG picture",
    "02_web_page": ":2: expected HIERARCHY, found a web page (HTML)",
    "03_cut_in_hierarchy": (
        ":10: expected JOINT, End Site or '}', found the end of the file; the file ends here with 2 braces open: "
        "ROOT 'Hips' (line 2), JOINT 'Knee' (line 6)"
    ),
    "03_cut_in_offset": (
        ":12: OFFSET of the End Site of 'Knee': expected 3 values, found 1; the file ends here with 3 braces open: "
        "ROOT 'Hips' (line 2), JOINT 'Knee' (line 6), the End Site of 'Knee' (line 10)"
    ),
    "03_cut_before_motion": ":15: expected MOTION, found the end of the file",
    "03_cut_before_frame_time": ":17: expected 'Frame Time:', found the end of the file",
    "03_cut_before_rows": (
        f":17: Frames: 2 claimed, but the 0 bytes left hold at most 0 frames of 9 channels; {REPAIR}"
    ),
    "04_cut_in_row": ":20: frame 1 has 7 values, but the hierarchy declares 9 channels. The file ends here.",
    "04_cut_in_number": ":20: frame 1 has 2 values, but the hierarchy declares 9 channels. The file ends here.",
    "04_short_row": ":19: frame 0 has 7 values, but the hierarchy declares 9 channels.",
    "04_long_row": ":19: frame 0 has 10 values, but the hierarchy declares 9 channels.",
    "05_1000_frames_claimed_3_there": (
        f":17: Frames: 1000 claimed, but the 117 bytes left hold at most 6 frames of 9 channels; {REPAIR}"
    ),
    "05_5_frames_claimed_3_there": f":17: Frames: 5 claimed, 3 there; {REPAIR}",
    "06_two_billion_frames_claimed": (
        f":17: Frames: 2000000000 claimed, but the 77 bytes left hold at most 4 frames of 9 channels; {REPAIR}"
    ),
    "07_minus_five_frames": f":17: Frames: {COUNT} '-5'",
    "07_frames_1e3": f":17: Frames: {COUNT} '1e3'",
    "08_frame_time_zero": (
        f":18: Frame Time: expected a frame time from 1e-06 to 1000000.0 seconds, found '0.0'; {RATE}"
    ),
    "08_frame_time_negative": f":18: Frame Time: expected a positive decimal number, found '-0.033333'; {RATE}",
    "08_frame_time_nan": f":18: Frame Time: expected a finite number, found 'nan'; {RATE}",
    "08_frame_time_missing": f":18: expected 'Frame Time:', found '1.0 2.0 3.0 90.0 0.0 0.0 0.0 0.0 0.0'; {RATE}",
    "09_nan": ":20:31: frame 1, joint 'Knee', Yrotation: expected a finite number, found 'nan'.",
    "09_inf": ":20:36: frame 1, joint 'Knee', Xrotation: expected a finite number, found '-inf'.",
    "09_1e999": (
        ":20:5: frame 1, joint 'Hips', Yposition: expected a finite number, found '1e999', which is too large for one."
    ),
    "10_underscore": ":20:26: frame 1, joint 'Knee', Zrotation: expected a number, found '1_0'.",
    "10_arabic_digits": (":20:26: frame 1, joint 'Knee', Zrotation: expected a number in the digits 0-9, found '١٢'."),
    "11_decimal_comma": f":4:10: OFFSET of ROOT 'Hips': expected a number, found '0,0'; {COMMA}",
    "12_glued": (
        ":19:18: frame 0, joint 'Hips', Yrotation: numbers run together in '0.0-7.5': expected white space before "
        "'-7.5'."
    ),
    "13_channels_6_with_3_names": ":5: CHANNELS of ROOT 'Hips' declares 6 channels, but names 3",
    "13_channels_3_with_6_names": ":5: CHANNELS of ROOT 'Hips' declares 3 channels, but names more",
    "13_channels_1e9": f":5: CHANNELS of ROOT 'Hips': {COUNT} '1e9'",
    "13_channels_1000000000": (
        ":5: ROOT 'Hips' declares '1000000000' channels, the limit is 9 (Limits.joint_channels)"
    ),
    "13_channels_minus_2": f":5: CHANNELS of ROOT 'Hips': {COUNT} '-2'",
    "14_wrotation": f":9: unknown channel 'Wrotation' of JOINT 'Knee'; allowed are {ALLOWED}",
    "15_one_axis_three_times": ":9: CHANNELS of JOINT 'Knee' names Xrotation twice",
    "16_brace_too_many": ":16: a '}' too many: every joint is closed already",
    "16_brace_too_few": (":15: expected JOINT, End Site or '}', found MOTION with 1 brace open: ROOT 'Hips' (line 2)"),
    "18_two_roots": ":16: a second ROOT, 'Second': a motion has one (the first is 'Hips' on line 2)",
    "19_channels_after_child": (
        ":10: CHANNELS of ROOT 'Hips' after its child JOINT 'Knee': it is unclear where its values stand in a frame; "
        "expected CHANNELS before the first JOINT"
    ),
    "20_code_in_offset": (
        """:8:12: OFFSET of JOINT 'Knee': expected a number, found "__import__('os').system('true')\""""
    ),
    "no_channels_at_all": ":17: Frames: no joint has a channel, so nothing moves",
    "no_root": ":2: expected ROOT, found 'JOINT'",
    "offset_missing": ":13: JOINT 'Knee' (line 6) ends without an OFFSET",
    "offset_of_2": ":8: OFFSET of JOINT 'Knee': expected 3 values, found 2",
    "offset_twice": ":5: a second OFFSET of ROOT 'Hips'",
    "channels_missing": (":13: JOINT 'Knee' (line 6) ends without CHANNELS (a joint that has none says CHANNELS 0)"),
    "channels_in_end_site": ":13: expected '}', found 'CHANNELS'",
    "root_without_name": ":2: expected a name after ROOT",
    "text_after_rows": ":21:1: frame 2, joint 'Hips', Xposition: expected a number, found 'Thank'.",
    "half_utf16": ": begins like UTF-16 text, but can't be decoded as such",
}


@pytest.mark.parametrize("name", MESSAGES)
def test_message(name: str) -> None:
    path = DATA / f"broken_{name}.bvh"
    with pytest.raises(FormatError) as caught:
        read(path)
    assert str(caught.value) == str(path) + MESSAGES[name]
    assert caught.value.path == str(path)


def test_every_broken_file_has_its_message() -> None:
    assert {path.stem.removeprefix("broken_") for path in DATA.glob("broken_*.bvh")} == set(MESSAGES)


def test_place_as_attributes() -> None:
    with pytest.raises(FormatError) as caught:
        read(DATA / "broken_12_glued.bvh")
    assert (caught.value.line, caught.value.column) == (19, 18)


def plain() -> str:
    return (DATA / "plain.bvh").read_text()


def refuse(tmp_path: Path, data: str | bytes, limits: Limits | None = None) -> str:
    """Read data that must be refused, and return the message without the path."""
    path = tmp_path / "broken.bvh"
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    with pytest.raises(FormatError) as caught:
        read(path, limits=limits)
    return str(caught.value).removeprefix(str(path))


@pytest.mark.parametrize(
    ("start", "kind"),
    [
        (b"\x1f\x8b\x08\x00", "gzip-compressed data"),
        (b"PK\x03\x04\x14\x00", "a zip archive (or a format made of one, such as NPZ or USDZ)"),
        (b"Kaydara FBX Binary  \x00", "a binary FBX scene"),
        (b"glTF\x02\x00\x00\x00", "a binary glTF scene (GLB)"),
        (b"\x00\x00\x00\x20ftypisom", "an MP4 or MOV video"),
        (b"version https://git-lfs.github.com/spec/v1\n", "a Git LFS pointer"),
        (b":version 1.10\n:name VICON\n", "an ASF skeleton"),
    ],
)
def test_other_kinds_of_file_are_named(tmp_path: Path, start: bytes, kind: str) -> None:
    assert refuse(tmp_path, start).startswith(f":1: expected HIERARCHY, found {kind}")


def test_a_thousand_nested_joints_too_many(tmp_path: Path) -> None:
    depth = 5000
    joints = "".join(f"JOINT j{i}\n{{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n" for i in range(depth))
    text = "HIERARCHY\n" + joints.replace("JOINT", "ROOT", 1) + "}\n" * depth
    text += "MOTION\nFrames: 1\nFrame Time: 0.1\n" + "0 " * depth
    assert refuse(tmp_path, text) == ":1026: joint 'j256' lies too deep; the limit is 256 (Limits.depth)"
    deep = read(tmp_path / "broken.bvh", limits=Limits(depth=depth, joints=depth))
    assert deep.n_frames == 1


def test_braces_of_a_deep_file_are_not_all_listed(tmp_path: Path) -> None:
    text = "HIERARCHY\n" + "".join(f"JOINT j{i}\n{{\nOFFSET 0 0 0\nCHANNELS 0\n" for i in range(6))
    assert refuse(tmp_path, text.replace("JOINT", "ROOT", 1)).endswith(
        "with 6 braces open: ..., JOINT 'j2' (line 10), JOINT 'j3' (line 14), JOINT 'j4' (line 18), "
        "JOINT 'j5' (line 22)"
    )


def test_a_huge_claim_costs_neither_time_nor_memory(tmp_path: Path) -> None:
    rows = "1.0 2.0 3.0 90.0 0.0 0.0 0.0 0.0 0.0\n" * 20_000
    start = time.process_time()
    tracemalloc.start()
    try:
        refuse(tmp_path, plain().replace("Frames: 2", "Frames: 2000000000") + rows)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert time.process_time() - start < 1.0
    assert peak < 10 * len(rows)


def test_a_claim_of_thousands_of_digits(tmp_path: Path) -> None:
    message = refuse(tmp_path, plain().replace("Frames: 2", "Frames: " + "9" * 10_000))
    assert message.startswith(":17: Frames: 10**18 or more claimed, but the 77 bytes left hold at most 4 frames")


@pytest.mark.parametrize(
    ("text", "column"),
    [("1.5 2.5\t-3.5 x", 14), ("1.5 左 0", 5), ("1.5 2.5 1.2.3", 9), ("1.5 2.5 1,000,000", 9)],
)
def test_column_counts_characters(tmp_path: Path, text: str, column: int) -> None:
    assert refuse(tmp_path, plain().replace("1.5 2.5 -3.5 0.0", text)).startswith(f":20:{column}: ")


def test_line_numbers_count_every_kind_of_line_end(tmp_path: Path) -> None:
    broken = plain().replace("30.0\n", "x\n")
    for end in ("\n", "\r", "\r\n"):
        assert refuse(tmp_path, broken.replace("\n", end).encode()).startswith(":20:36: ")


def test_the_line_of_an_error_far_into_a_file(tmp_path: Path) -> None:
    rows = "1.0 2.0 3.0 90.0 0.0 0.0 0.0 0.0 0.0\r\n" * 40_000
    text = plain().replace("Frames: 2", "Frames: 40003") + rows + "1.0 2.0 3.0 90.0 0.0 0.0 0.0 0.0\n"
    assert refuse(tmp_path, text).startswith(":40021: frame 40002 has 8 values")


def test_a_wrapped_frame_with_too_many_values_names_its_lines(tmp_path: Path) -> None:
    text = plain().replace("1.5 2.5", "1.5\n2.5\n3.5")
    assert refuse(tmp_path, text) == (
        ":20: frame 1 (lines 20 to 21) has 2 values, but the hierarchy declares 9 channels."
    )


def test_a_stray_sign_after_the_last_frame_is_not_dropped(tmp_path: Path) -> None:
    assert refuse(tmp_path, plain() + "-").startswith(":21: frame 2 has 0 values")
    assert refuse(tmp_path, plain().rstrip() + " -").startswith(":20:41: frame 1, past the last channel: ")


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        (Limits(file_bytes=100), ": the file has 374 bytes, the limit is 100 (Limits.file_bytes)"),
        (Limits(joints=1), ":6: joint 'Knee' is one too many; the limit is 1 (Limits.joints)"),
        (Limits(joints=0), ":2: joint 'Hips' is one too many; the limit is 0 (Limits.joints)"),
        (Limits(depth=1), ":6: joint 'Knee' lies too deep; the limit is 1 (Limits.depth)"),
        (Limits(joint_channels=5), ":5: ROOT 'Hips' declares '6' channels, the limit is 5 (Limits.joint_channels)"),
        (Limits(channels=8), ":9: 9 channels up to here, the limit is 8 (Limits.channels)"),
        (Limits(frames=1), ":17: Frames: 2 claimed, the limit is 1 (Limits.frames)"),
        (
            Limits(joint_poses=3),
            ":17: Frames: 2 frames of 2 joints, the limit is 3 poses of a joint (Limits.joint_poses)",
        ),
        (Limits(line_bytes=20), ":4: the line is longer than 20 bytes (Limits.line_bytes)"),
        (Limits(name_bytes=3), ":2: the name 'Hips' has 4 bytes, the limit is 3 (Limits.name_bytes)"),
    ],
)
def test_limits_are_named(tmp_path: Path, limits: Limits, message: str) -> None:
    text = plain()
    if limits.line_bytes == 20:
        text = text.replace("  OFFSET 0.0 0.0 0.0\n", "  OFFSET 0.0 0.0     0.0\n")
    assert refuse(tmp_path, text, limits) == message


def test_end_sites_are_limited_too(tmp_path: Path) -> None:
    site = "    End Site\n    {\n      OFFSET 0.0 -3.0 0.5\n    }\n"
    assert refuse(tmp_path, plain().replace(site, site * 3), Limits(joints=2)) == (
        ":18: an End Site too many; the limit is 2 (Limits.joints)"
    )


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r", ""])
def test_a_line_of_just_the_limit_is_fine(tmp_path: Path, end: str) -> None:
    text = plain().rstrip().replace("\n", end or "\n") + end
    longest = max(map(len, text.splitlines()))
    path = tmp_path / "lines.bvh"
    path.write_bytes(text.encode())
    assert read(path, limits=Limits(line_bytes=longest)).n_frames == 2
    assert "line is longer" in refuse(tmp_path, text, Limits(line_bytes=longest - 1))


def test_a_long_line_among_the_rows(tmp_path: Path) -> None:
    text = plain() + "1" * 100
    assert refuse(tmp_path, text, Limits(line_bytes=80)) == (
        ":21: the line is longer than 80 bytes (Limits.line_bytes)"
    )


def test_more_frames_than_the_limit_are_refused_whatever_was_claimed(tmp_path: Path) -> None:
    text = plain().replace("Frames: 2", "Frames: 1")
    assert refuse(tmp_path, text, Limits(frames=1)) == ":17: Frames: more than 1 there (Limits.frames)"


@pytest.mark.parametrize("seconds", ["1e-7", "1e7", "1e-320", "0." + "0" * 400 + "1", "1e-00001", "1_0", "٠٫١"])
def test_frame_times_that_are_no_use(tmp_path: Path, seconds: str) -> None:
    assert refuse(tmp_path, plain().replace("0.033333", seconds)).startswith(":18: Frame Time: expected ")


@pytest.mark.parametrize(
    ("name", "n_frames", "message"),
    [
        (
            "04_cut_in_row",
            1,
            ":20: frame 1 has 7 values, .* The file ends here. Kept the whole frames before it: 1 of 2 ",
        ),
        ("04_cut_in_number", 1, ":20: frame 1 has 2 values, .* Kept the whole frames before it: 1 of 2 claimed."),
        ("05_1000_frames_claimed_3_there", 3, ":17: Frames: 1000 claimed, 3 there; kept the 3"),
        ("05_5_frames_claimed_3_there", 3, ":17: Frames: 5 claimed, 3 there; kept the 3"),
        ("06_two_billion_frames_claimed", 2, ":17: Frames: 2000000000 claimed, 2 there; kept the 2"),
        ("09_nan", 1, ":20: frame 1, joint 'Knee', Yrotation: .* Kept the whole frames before it: 1 of 2 claimed."),
        ("text_after_rows", 2, ":21: .* Kept the whole frames before it: 2 of 2 claimed."),
    ],
)
def test_repair_keeps_what_is_whole_and_says_so(name: str, n_frames: int, message: str) -> None:
    with pytest.warns(FormatWarning, match=message) as caught:
        motion = read(DATA / f"broken_{name}.bvh", repair=True)
    assert len(caught) == 1
    assert motion.n_frames == n_frames


@pytest.mark.parametrize("name", ["01_empty", "03_cut_in_hierarchy", "03_cut_before_rows", "04_short_row"])
def test_repair_needs_a_whole_frame(name: str) -> None:
    with pytest.raises(FormatError):
        read(DATA / f"broken_{name}.bvh", repair=True)


def test_joints_without_channels_cannot_blow_up_the_memory(tmp_path: Path) -> None:
    """Few bytes a frame, many joints: the frames times the joints are limited, not the file alone."""
    joints = "JOINT j\n{\nOFFSET 0 0 0\nCHANNELS 0\n}\n" * 4000
    text = "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 1 Xrotation\n" + joints + "}\n"
    text += "MOTION\nFrames: 20000\nFrame Time: 0.1\n" + "0\n" * 20_000
    assert refuse(tmp_path, text).endswith(
        "Frames: 20000 frames of 4001 joints, the limit is 67108864 poses of a joint (Limits.joint_poses)"
    )


def test_a_folder_is_not_a_motion(tmp_path: Path) -> None:
    (tmp_path / "folder.bvh").mkdir()
    with pytest.raises(FormatError, match="this is a folder, not a file"):
        read(tmp_path / "folder.bvh")


TWO_FRAMES = (
    "HIERARCHY\nROOT r\n{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n}\n"
    "MOTION\nFrames: 2\nFrame Time: 0.1\n"
)


@pytest.mark.parametrize(
    "end", ["\x1a", "\n\x1a", "\0" * 100, "\n" + "\0" * 7, "\r\n\x1a\r\n", "\x1a\0\0\n", "\n\n\x1a \x1a\n"]
)
def test_padding_after_the_last_frame_is_no_damage(tmp_path: Path, end: str) -> None:
    path = tmp_path / "padded.bvh"
    path.write_bytes(f"{TWO_FRAMES}1 2 3\n4 5 6.5{end}".encode())
    assert read(path).local_translations[:, 0].tolist() == [[1, 2, 3], [4, 5, 6.5]]


@pytest.mark.parametrize("rest", ["1 2 3\n4 5\x1a", "1 2 3\n\x1a4 5 6", "1 2 3\n\0\0\n4 5 6", "1 2 3\n4 5 6\x1a0"])
def test_padding_hides_no_damage(tmp_path: Path, rest: str) -> None:
    refuse(tmp_path, TWO_FRAMES + rest)


def test_a_file_of_zeros_alone_is_no_motion(tmp_path: Path) -> None:
    (tmp_path / "zeros.bvh").write_bytes(bytes(100))
    with pytest.raises(FormatError, match="expected HIERARCHY"):
        read(tmp_path / "zeros.bvh")


@pytest.mark.parametrize(
    ("rest", "frames", "said"),
    [
        ("1 0.0-7.5\n4 5 6\n", [[1, 0, -7.5], [4, 5, 6]], ":10: frame 0, .*run together.* in 1 frame"),
        ("1 2 3\n-4-5+6\n", [[1, 2, 3], [-4, -5, 6]], ":11: frame 1, .*run together.* in 1 frame"),
        ("1e-2-3 4\n1-2-3\n", [[0.01, -3, 4], [1, -2, -3]], ":10: frame 0, .*run together.* in 2 frames"),
        ("1-2\n3\n4 5 6\n", [[1, -2, 3], [4, 5, 6]], ":10: frame 0, .*run together.* in 1 frame"),
    ],
)
def test_repair_parts_numbers_that_run_together(
    tmp_path: Path, rest: str, frames: list[list[float]], said: str
) -> None:
    refuse(tmp_path, TWO_FRAMES + rest)
    (tmp_path / "glued.bvh").write_text(TWO_FRAMES + rest)
    with pytest.warns(FormatWarning, match=said) as caught:
        motion = read(tmp_path / "glued.bvh", repair=True)
    assert len(caught) == 1
    assert motion.local_translations[:, 0].tolist() == frames


@pytest.mark.parametrize("rest", ["1 2 3-4\n", "1-2\n3 4 5\n", "1-2\n"])
def test_numbers_that_would_be_too_many_or_too_few_are_not_parted(tmp_path: Path, rest: str) -> None:
    (tmp_path / "glued.bvh").write_text(f"{TWO_FRAMES}7 8 9\n{rest}")
    with pytest.warns(FormatWarning, match=r":11:\d: frame 1, .*run together|:11: frame 1, .*run together") as caught:
        motion = read(tmp_path / "glued.bvh", repair=True)
    assert len(caught) == 1
    assert motion.local_translations[:, 0].tolist() == [[7, 8, 9]]


def test_parted_numbers_keep_a_decimal_comma(tmp_path: Path) -> None:
    (tmp_path / "glued.bvh").write_text(TWO_FRAMES.replace("0.1", "0,1") + "1 0,5-7,25\n4 5 6\n")
    with pytest.warns(FormatWarning, match="run together"):
        motion = read(tmp_path / "glued.bvh", repair=True, decimal_comma=True)
    assert motion.local_translations[0, 0].tolist() == [1, 0.5, -7.25]
