"""`retime apply` on video, pictures and sound."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from retime import Warp, read_warp, write_warp


def test_options_of_video_are_refused_without_video(run, clips, tmp_path) -> None:
    write_warp(Warp([0, 1], [0, 2]), tmp_path / "w.json")
    for option in (
        ("--shutter", "0.5"),
        ("--between", "flow"),
        ("--sound", "drop"),
        ("--output-rate", "25"),
        ("--no-deinterlace",),
    ):
        result = run("apply", "w.json", clips.csv, "-o", "o.csv", *option, code=2)
        assert f"{option[0]} would have no effect" in result.stderr


def test_a_video_does_not_become_a_table(run, clips, tmp_path) -> None:
    write_warp(Warp([0, 1], [0, 2]), tmp_path / "w.json")
    (tmp_path / "a.mp4").write_bytes(b"x")
    assert "is video, pictures or sound" in run("apply", "w.json", "a.mp4", "-o", "o.csv", code=1).stderr


@pytest.mark.parametrize(
    "option", [("--shutter", "2"), ("--offset", "3f"), ("--output-rate", "fast"), ("--quality", "64")]
)
def test_values_that_are_none_name_the_option(run, tmp_path, option) -> None:
    write_warp(Warp([0, 1], [0, 2]), tmp_path / "w.json")
    assert option[0] in run("apply", "w.json", "a.mp4", *option, code=2).stderr


@pytest.mark.extras
def test_a_video_gets_the_warp_of_a_motion(run, clips, tmp_path) -> None:
    pytest.importorskip("av", reason="needs the extra 'video'")
    pytest.importorskip("cv2", reason="needs the extra 'video'")
    pytest.importorskip("python_stretch", reason="needs the extra 'video'")
    from tests.media import clips as media

    run("warp", clips.bvh, "--length", "65%", "--save", "w.json", "-q")
    media.write_clip(tmp_path / "take.mkv", 121, samples=media.sound(4.0))
    result = run(
        "apply", "w.json", "take.mkv", clips.bvh, "--out-dir", ".", "--between", "nearest", "--offset", "0", "--codec",
        "ffv1", "--pixel-format", "yuv444p", "--quality", "10", "--sound", "resample", "--shutter", "0",
        "--output-rate", "50",
    )  # fmt: skip
    assert "take_retimed.mkv: 2.6" in result.stdout
    numbers, times, frames = media.read_frames(tmp_path / "take_retimed.mkv")
    warp = read_warp(tmp_path / "w.json")
    assert frames[0].format.name == "yuv444p"
    assert times[1] == pytest.approx(Fraction(1, 50), abs=1e-3)
    wanted = np.floor(warp(np.arange(len(numbers)) / 50) * 30 + 0.5 + 1e-6)
    assert numbers == np.clip(wanted, 0, 120).astype(int).tolist()
    assert (
        "--frames would have no effect on"
        in run("apply", "w.json", "take.mkv", "-o", "p.mkv", "--frames", "1:3", code=2).stderr
    )
