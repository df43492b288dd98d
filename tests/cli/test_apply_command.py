"""`retime apply`: a saved warp on the clip it came from, and on others."""

from __future__ import annotations

import gzip
import shutil

import numpy as np
import pytest

from retime import Warp, read, write, write_warp
from tests.cli.figures import curve, figure


@pytest.fixture
def half(tmp_path):
    """Save a warp that plays four seconds in two."""
    write_warp(Warp([0.0, 2.0], [0.0, 4.0]), tmp_path / "half.json")
    return "half.json"


def test_a_saved_warp_gives_the_same_file_as_the_search_did(run, clips, tmp_path) -> None:
    options = ("--frames", "20:200", "--fps", "50")
    run("warp", clips.bvh, *options, "--length", "65%", "-o", "searched.bvh", "--save", "warp.json")
    run("apply", "warp.json", clips.bvh, *options, "-o", "applied.bvh")
    assert (tmp_path / "searched.bvh").read_bytes() == (tmp_path / "applied.bvh").read_bytes()


def test_several_clips_go_to_a_folder(run, clips, tmp_path, half) -> None:
    write(curve("other"), tmp_path / "other.npz")
    (tmp_path / "out").mkdir()
    result = run("apply", half, clips.bvh, clips.csv, "other.npz", "--out-dir", "out")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "camera_retimed.csv",
        "jump_retimed.bvh",
        "other_retimed.npz",
    ]
    assert read(tmp_path / "out/jump_retimed.bvh").n_frames == 121
    assert read(tmp_path / "out/camera_retimed.csv").n_frames == 61
    first, *_, third = result.stdout.splitlines()
    assert first == f"out/jump_retimed.bvh: 121 frames, 2.02 s, from {clips.bvh}: 241 frames, 4.02 s"
    assert third.startswith("out/other_retimed.npz: 61 frames")
    # The camera lasts half as long as the warp reaches.
    assert result.stderr.count("warning: ") == 2


def test_without_a_place_it_goes_beside_the_clip(run, clips, tmp_path, half) -> None:
    shutil.copy(clips.bvh, tmp_path / "jump.bvh")
    run("apply", half, "jump.bvh")
    run("apply", half, "jump.bvh", "--suffix", ".fast")
    assert (tmp_path / "jump_retimed.bvh").read_bytes() == (tmp_path / "jump.fast.bvh").read_bytes()
    assert "is the input" in run("apply", half, "jump.bvh", "--suffix", "", "--force", code=2).stderr
    assert "slash" in run("apply", half, "jump.bvh", "--suffix", "/x", code=2).stderr


def test_frames_and_rate_choose_what_is_retimed(run, clips, tmp_path, half) -> None:
    run("apply", half, clips.bvh, "-o", "cut.bvh", "--drop-first", "1", "--frames", "1:120", "--fps", "30", "-q")
    cut = read(tmp_path / "cut.bvh")
    assert (cut.n_frames, cut.rate) == (61, 30)


def test_no_average_takes_poses_straight_from_the_input(run, clips, tmp_path, half) -> None:
    run("apply", half, clips.bvh, "-o", "straight.bvh", "--no-average")
    run("apply", half, clips.bvh, "-o", "average.bvh")
    motion, straight = read(clips.bvh), read(tmp_path / "straight.bvh")
    np.testing.assert_allclose(straight.local_translations, motion.local_translations[::2], atol=1e-5)
    assert np.abs(read(tmp_path / "average.bvh").rotations - straight.rotations).max() > 1e-3


def test_quiet_and_force(run, clips, tmp_path, half) -> None:
    assert run("apply", half, clips.bvh, "-o", "out.bvh", "-q").output == ""
    assert "out.bvh: exists already" in run("apply", half, clips.bvh, "-o", "out.bvh", code=1).stderr
    run("apply", half, clips.bvh, "-o", "out.bvh", "--force")


def test_nothing_is_written_where_one_output_is_taken(run, clips, tmp_path, half) -> None:
    write(figure(), tmp_path / "first.bvh")
    (tmp_path / "jump_retimed.bvh").write_text("mine")
    result = run("apply", half, "first.bvh", clips.bvh, "--out-dir", ".", code=1)
    assert (
        result.stderr
        == "error: jump_retimed.bvh: exists already; choose another place or allow overwriting (--force)\n"
    )
    assert not (tmp_path / "first_retimed.bvh").exists()
    assert (tmp_path / "jump_retimed.bvh").read_text() == "mine"


def test_a_broken_clip_is_reported_and_the_others_are_done(run, clips, tmp_path, half) -> None:
    (tmp_path / "cut.bvh").write_bytes(clips.bvh.read_bytes()[:300])
    (tmp_path / "empty.csv").write_text("")
    result = run("apply", half, "cut.bvh", clips.bvh, "missing.bvh", "empty.csv", clips.csv, "--out-dir", ".", code=1)
    assert sorted(path.name for path in tmp_path.glob("*_retimed.*")) == ["camera_retimed.csv", "jump_retimed.bvh"]
    assert len(result.stdout.splitlines()) == 2
    errors = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    for line, said in zip(errors, ("cut.bvh:", "missing.bvh: No such file", "empty.csv", "3 of 5 clips"), strict=True):
        assert said in line


def test_failures_of_one_kind_end_with_its_code(run, clips, tmp_path, half) -> None:
    write(curve("short"), tmp_path / "short.npz")
    # Frames that no clip has are a wrong option, not a broken file.
    assert (
        "2 of 2" in run("apply", half, clips.csv, "short.npz", "--out-dir", ".", "--frames", "900:990", code=2).stderr
    )
    result = run("apply", half, clips.bvh, "short.npz", "--out-dir", ".", "--frames", "100:200", code=2)
    assert "1 of 2 clips failed" in result.stderr
    assert (tmp_path / "jump_retimed.bvh").exists()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["{bvh}", "{csv}", "-o", "x.bvh"], "there are 2 clips"),
        (["{bvh}", "-o", "x.bvh", "--out-dir", "."], "give one of them"),
        (["{bvh}", "{bvh}", "--out-dir", "."], "twice"),
        (["{bvh}", "{copy}", "--out-dir", "."], "name the same file"),
        ([], "CLIP"),
    ],
)
def test_contradictions_are_refused(run, clips, tmp_path, half, arguments, says) -> None:
    (tmp_path / "copy").mkdir()
    copy = shutil.copy(clips.bvh, tmp_path / "copy" / "jump.bvh")
    named = [text.format(bvh=clips.bvh, csv=clips.csv, copy=copy) for text in arguments]
    assert says in run("apply", half, *named, code=2).stderr


def test_a_motion_does_not_fit_a_table(run, clips, half) -> None:
    assert "holds a signal, not a motion" in run("apply", half, clips.bvh, "-o", "x.csv", code=1).stderr


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "not JSON"),
        ("{}", "expected a warp"),
        ('{"format": "retime-warp", "version": 99}', "99"),
        (None, "No such file"),
    ],
)
def test_a_broken_warp_is_refused_by_name(run, clips, tmp_path, text, says) -> None:
    if text is not None:
        (tmp_path / "warp.json").write_text(text)
    result = run("apply", "warp.json", clips.bvh, "-o", "x.bvh", code=1)
    assert result.stderr.startswith("error: warp.json")
    assert says in result.stderr


def test_what_was_compressed_is_written_plain(run, clips, tmp_path, half) -> None:
    (tmp_path / "jump.bvh.gz").write_bytes(gzip.compress(clips.bvh.read_bytes()))
    run("apply", half, "jump.bvh.gz")
    run("apply", half, clips.bvh, "-o", "plain.bvh")
    assert (tmp_path / "jump_retimed.bvh").read_bytes() == (tmp_path / "plain.bvh").read_bytes()
    says = run("apply", half, "jump.bvh.gz", "-o", "out.bvh.gz", code=1).stderr
    assert "write out.bvh, then compress it (gzip out.bvh)" in says
    assert not (tmp_path / "out.bvh.gz").exists()
