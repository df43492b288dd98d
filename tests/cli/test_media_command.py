"""`retime apply` and `retime warp` on video, pictures and sound."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import click
import numpy as np
import pytest

from retime import Warp, read_warp, write_warp
from retime.cli import apply, imitate, warp


def test_options_of_video_are_refused_without_video(run, clips, tmp_path) -> None:
    write_warp(Warp([0, 1], [0, 2]), tmp_path / "w.json")
    for option in (
        ("--shutter", "0.5"),
        ("--between", "flow"),
        ("--sound", "drop"),
        ("--output-rate", "25"),
        ("--no-deinterlace",),
    ):
        for command in (
            ("apply", "w.json", clips.csv),
            ("warp", clips.csv),
            ("imitate", clips.csv, "--example", "1:5", "--warp", "w.json"),
        ):
            result = run(*command, "-o", "o.csv", *option, code=2)
            assert f"{option[0]} would have no effect" in result.stderr
    # Footage that is only looked at is not written.
    refused = run("warp", "take.mp4", "--save", "v.json", "--sound", "drop", code=2)
    assert "--sound would have no effect" in refused.stderr


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
    timing = read_warp(tmp_path / "w.json")
    assert frames[0].format.name == "yuv444p"
    assert times[1] == pytest.approx(Fraction(1, 50), abs=1e-3)
    wanted = np.floor(timing(np.arange(len(numbers)) / 50) * 30 + 0.5 + 1e-6)
    assert numbers == np.clip(wanted, 0, 120).astype(int).tolist()
    assert (
        "--frames would have no effect on"
        in run("apply", "w.json", "take.mkv", "-o", "p.mkv", "--frames", "1:3", code=2).stderr
    )


def options_of(command: click.Command) -> dict[str, dict[str, Any]]:
    return {
        option.name: option.to_info_dict()
        for option in command.params
        if getattr(option, "section", "") == "Video and sound" and option.name is not None
    }


def test_what_finds_a_warp_has_the_options_of_what_applies_one() -> None:
    applied = options_of(apply.command)
    # Where footage begins is known of what was looked at, and of what stands beside it.
    assert "offset" in applied
    for command in (warp.command, imitate.command):
        assert options_of(command) == {name: option for name, option in applied.items() if name != "offset"}


@pytest.mark.extras
def test_a_video_gets_its_own_warp_as_apply_would_give_it(run, tmp_path) -> None:
    pytest.importorskip("av", reason="needs the extra 'video'")
    pytest.importorskip("cv2", reason="needs the extra 'video'")
    pytest.importorskip("python_stretch", reason="needs the extra 'video'")
    from tests.media import clips as media

    media.write_clip(tmp_path / "take.mkv", 61, samples=media.sound(2.0))
    how = (
        "--between",
        "nearest",
        "--codec",
        "ffv1",
        "--pixel-format",
        "yuv444p",
        "--sound",
        "drop",
        "--output-rate",
        "25",
    )
    run(
        "warp", "take.mkv", "--length", "70%", "-o", "a.mkv", "--save", "w.json", "-q", *how,
    )  # fmt: skip
    run("apply", "w.json", "take.mkv", "-o", "b.mkv", "-q", *how)
    found, again = (media.read_frames(tmp_path / name) for name in ("a.mkv", "b.mkv"))
    assert found[:2] == again[:2]
    assert found[2][0].format.name == "yuv444p"
    assert found[1][1] == pytest.approx(Fraction(1, 25), abs=1e-3)
    # Where only some frames are looked at, those are written.
    run("warp", "take.mkv", "--frames", "10:50", "-o", "c.mkv", "--length", "100%", "-q", *how[:6])
    assert media.read_frames(tmp_path / "c.mkv")[0] == list(range(10, 51))
