"""`retime info`: what a clip holds, and how retime is built."""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime import Motion, Skeleton, write
from retime.cli import info
from retime.kernels import BACKENDS, compiled_available
from tests.cli.figures import figure
from tests.motion.walkers import renamed


def test_a_motion(run, clips) -> None:
    rows = dict(line.split(maxsplit=1) for line in run("info", clips.bvh).stdout.splitlines())
    assert rows == {
        "clip": f"{clips.bvh}, a motion (bvh)",
        "frames": "241, numbered 0:240",
        "rate": "60 Hz",
        "length": "4.017 s",
        "channels": "21",
        "up": "y",
        "root": "Hips",
        "unit": "not known (flights take a size from the skeleton)",
        "joints": "6, and 3 end sites: Hips, Chest, LeftLeg, LeftFoot, RightLeg, RightFoot",
        "flights": "1: frames 107:133 (1.78-2.22 s)",
        "feet": "2, by name: LeftFoot, RightFoot",
        "mirror": "2 pairs by name: LeftLeg/RightLeg, LeftFoot/RightFoot",
        "parts": "5 of 6 joints known by name; other names match only their like: Chest",
    }


def test_a_motion_as_json(run, clips) -> None:
    document = json.loads(run("info", clips.bvh, "--json", "--drop-first", "8", "--fps", "29.97").stdout)
    assert document.pop("seconds") == pytest.approx(233 * 1.001 / 30)
    assert document.pop("rate") == pytest.approx(29.97, abs=1e-4)
    assert document == {
        "path": str(clips.bvh),
        "format": "bvh",
        "holds": "motion",
        "name": "jump",
        "frames": 233,
        "first_frame": 8,
        "exact_rate": "30000/1001",
        "channels": 21,
        "joints": ["Hips", "Chest", "LeftLeg", "LeftFoot", "RightLeg", "RightFoot"],
        "parents": [-1, 0, 0, 2, 0, 4],
        "end_sites": 3,
        "metres_per_unit": None,
        "up": "y",
        "root": "Hips",
        "seems_z_up": False,
        "frames_before_capture": 0,
        # Half as fast, nothing falls as freely as it should.
        "flights": [],
        "feet": ["LeftFoot", "RightFoot"],
        "feet_found_by": "name",
        "facts": {},
        "mirror_pairs": [["LeftLeg", "RightLeg"], ["LeftFoot", "RightFoot"]],
        "parts": ["hips", None, "left thigh", "left foot", "right thigh", "right foot"],
    }


def test_what_other_names_change_is_said(run, tmp_path) -> None:
    motion = figure()
    said = {"Hips": "a", "Chest": "b", "LeftLeg": "c", "LeftFoot": "d", "RightLeg": "e", "RightFoot": "f"}
    write(renamed(motion, said), tmp_path / "letters.bvh")
    rows = dict(line.split(maxsplit=1) for line in run("info", "letters.bvh").stdout.splitlines())
    # The figure's legs are lowest all the time; its shins end there.
    assert rows["feet"] == "2, by how they move, for no joint is called a foot: end of d, end of f"
    assert rows["mirror"] == "none: no two joints are called left and right"
    assert rows["parts"] == "0 of 6 joints known by name; other names match only their like: a, b, c, d and 2 more"
    document = json.loads(run("info", "letters.bvh", "--json").stdout)
    assert (document["feet"], document["feet_found_by"]) == (["end of d", "end of f"], "motion")
    assert (document["mirror_pairs"], document["parts"]) == ([], [None] * 6)


def test_a_figure_without_feet_says_so(run, tmp_path) -> None:
    ball = Motion(Skeleton(("ball",), (-1,), np.zeros((1, 3))), np.tile([1.0, 0, 0, 0], (30, 1, 1)))
    write(ball, tmp_path / "ball.bvh")
    assert "feet      none: no joint is called a foot, and no limb is often lowest\n" in run("info", "ball.bvh").stdout
    assert json.loads(run("info", "ball.bvh", "--json").stdout)["feet_found_by"] is None


def test_a_signal(run, clips) -> None:
    assert "2: pan, tilt" in run("info", clips.csv).stdout
    document = json.loads(run("info", clips.csv, "--json", "--frames", "10:19").stdout)
    assert (document["holds"], document["frames"], document["first_frame"]) == ("signal", 10, 10)
    assert document["channel_names"] == ["pan", "tilt"]


def test_a_known_unit_and_a_film_rate(run, tmp_path) -> None:
    write(replace(figure(), metres_per_unit=0.01, rate=Fraction(24000, 1001)), tmp_path / "film.amc")
    text = run("info", "film.amc", "--fps", "23.976").stdout
    assert "23.976 Hz (24000/1001)" in text
    assert " m\n" in text


def test_names_can_not_steer_the_terminal(run, tmp_path) -> None:
    motion = figure()
    names = ("Hips\x1b[31m", *motion.skeleton.names[1:])
    write(replace(motion, skeleton=replace(motion.skeleton, names=names)), tmp_path / "red.bvh")
    result = run("info", "red.bvh")
    assert "\x1b" not in result.stdout
    assert r"Hips\x1b[31m" in result.stdout


def test_a_clip_of_hardly_a_frame_a_second_is_said(run, command, tmp_path) -> None:
    """A frame time of an hour is told before a search is asked for, and makes no millions of frames of 30."""
    path = tmp_path / "slow.npz"
    np.savez(path, values=np.arange(60.0).reshape(30, 2), fps=np.array(1 / 3600))
    assert "slow has 0.000278 frames a second, and so is 108000 s long" in run("info", path).stderr
    refused = command("convert", path, tmp_path / "fast.npz", "--rate", "30")
    assert refused.returncode == 2
    assert "3132001 frames" in refused.stderr
    assert "0.000278 Hz, the clip's own rate" in refused.stderr
    assert not (tmp_path / "fast.npz").exists()
    assert "frames a second, and so" not in run("info", path, "--fps", "1").stderr


def test_build_says_which_backend_is_in_use(run) -> None:
    document = json.loads(run("info", "--build", "--json").stdout)
    assert document["backend"] in BACKENDS
    assert document["compiled_available"] == compiled_available()
    assert document["packages"]["numpy"] == np.__version__
    text = run("info", "--build").stdout
    assert ["backend", document["backend"]] in [line.split() for line in text.splitlines()]


def test_build_says_which_extras_are_missing(run, monkeypatch) -> None:
    monkeypatch.setitem(info.EXTRAS, "plot", "no_such_package_here")
    assert "not installed: pip install 'retime[plot]'" in run("info", "--build").stdout
    assert json.loads(run("info", "--build", "--json").stdout)["extras"]["plot"] is None


def test_every_extra_is_known() -> None:
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text("utf-8"))["project"]
    for extra, requirements in project["optional-dependencies"].items():
        assert any(line.startswith(info.EXTRAS[extra]) for line in requirements)


def test_a_backend_that_can_not_be_had_is_an_error(command) -> None:
    import os

    done = command("info", "--build", env={**os.environ, "RETIME_BACKEND": "abacus"})
    assert (done.returncode, done.stderr) == (2, "error: the backend must be one of compiled, numpy; found 'abacus'\n")


@pytest.mark.parametrize("arguments", [[], ["--build", "clip.bvh"]])
def test_it_wants_a_clip_or_build(run, arguments) -> None:
    assert "give a CLIP" in run("info", *arguments, code=2).stderr


@pytest.mark.extras
def test_a_video(run, tmp_path) -> None:
    pytest.importorskip("av", reason="needs the extra 'video'")
    pytest.importorskip("cv2", reason="needs the extra 'video'")
    from tests.media import clips as media

    media.write_clip(tmp_path / "take.mkv", 60, samples=media.sound(2.0))
    rows = dict(line.split(maxsplit=1) for line in run("info", "take.mkv", "--fps", "25").stdout.splitlines())
    assert rows == {
        "clip": "take.mkv, video (matroska)",
        "length": "2.400 s",
        "video": "ffv1, 96x64, yuv420p, 8 bits",
        "frames": "60, numbered 0:59",
        "rate": "25 Hz",
        "audio": "pcm_s16le, 48000 Hz, 2 channels, 2.000 s",
    }
    document = json.loads(run("info", "take.mkv", "--json").stdout)
    assert (document["holds"], document["frames"], document["exact_rate"]) == ("video", 60, "30")
    assert [stream["type"] for stream in document["streams"]] == ["video", "audio"]
    media.write_sound(tmp_path / "take.wav", media.sound(2.0))
    assert "take.wav, sound (wav)" in run("info", "take.wav").stdout
    (tmp_path / "take.mp4").write_bytes(b"#EXTM3U\nother.mp4\n")
    assert "playlist" in run("info", "take.mp4", code=1).stderr
