"""`--up`: files whose vertical axis is Z, and what is said about them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import retime
from retime.motion import rotation
from retime.motion.kinematics import seems_z_up
from retime.motion.motion import Motion


def turned_to_z_up(motion: Motion) -> Motion:
    """Tip a Y-up motion over, as a program that has Z up would write it: (x, y, z) becomes (x, -z, y)."""
    about_x = rotation.about_axis(0, np.pi / 2)
    rotations, translations = motion.rotations.copy(), motion.local_translations.copy()
    rotations[:, 0] = rotation.multiply(about_x, rotations[:, 0])
    translations[:, 0] = translations[:, 0][:, [0, 2, 1]] * [1, -1, 1]
    return replace(motion, rotations=rotations, translations=translations, declared_angles=None)


@pytest.fixture
def both(tmp_path: Path) -> tuple[Path, Path]:
    clip = retime.sample().frames(300, 480)
    retime.write(clip, tmp_path / "y.bvh")
    retime.write(turned_to_z_up(clip), tmp_path / "z.bvh")
    return tmp_path / "y.bvh", tmp_path / "z.bvh"


def test_a_z_up_file_is_retimed_as_its_y_up_twin(run, both, tmp_path) -> None:
    y, z = both
    plain = json.loads(run("warp", y, "--length", "70%", "-o", "y_out.bvh", "--json").stdout)
    result = run("warp", z, "--length", "70%", "--up", "z", "-o", "z_out.bvh", "--json")
    told = json.loads(result.stdout)
    assert result.stderr == ""
    assert told["path"] == plain["path"]
    assert told["total"] == pytest.approx(plain["total"], rel=1e-5)
    assert told["slip"]["output_mm"] == pytest.approx(plain["slip"]["output_mm"], abs=0.01)
    # It is written with Z up, as it was read.
    upright, again = retime.read(tmp_path / "y_out.bvh"), retime.read(tmp_path / "z_out.bvh")
    expected = turned_to_z_up(upright)
    np.testing.assert_allclose(again.local_translations, expected.local_translations, atol=2e-4)
    apart = np.abs(np.sum(again.rotations * expected.rotations, axis=-1))
    assert apart.min() > 1 - 1e-6


def test_references_and_other_clips_are_z_up_too(run, both, tmp_path) -> None:
    y, z = both
    plain = json.loads(
        run("warp", y, "--reference", y, "--reference-frames", "0:60", "--length", "70%", "--json").stdout
    )
    options = ("--reference-frames", "0:60", "--length", "70%", "--json", "--up", "Z", "--also", f"{z}=other.bvh")
    told = json.loads(run("warp", z, "--reference", z, *options).stdout)
    assert told["path"] == plain["path"]
    run("warp", y, "--length", "70%", "--save", "warp.json", "-q")
    run("apply", "warp.json", z, "-o", "applied.bvh", "--up", "z", "-q")
    assert retime.read(tmp_path / "other.bvh").n_frames == retime.read(tmp_path / "applied.bvh").n_frames


def test_a_figure_that_stands_along_z_gets_a_hint(run, both) -> None:
    y, z = both
    result = run("warp", z, "--length", "70%")
    assert "stands along Z" in result.stderr
    assert "--up z" in result.stderr
    assert run("warp", z, "--length", "70%", "--up", "y").stderr == ""
    assert run("warp", y, "--length", "70%").stderr == ""
    assert "up        y, but the figure stands along z: try --up z" in run("info", z).stdout
    document = json.loads(run("info", z, "--up", "z", "--json").stdout)
    assert (document["up"], document["seems_z_up"]) == ("z", False)
    # Its flight is found once the axis is known.
    assert document["flights"] == json.loads(run("info", y, "--json").stdout)["flights"] != []
    assert run("info", z, "--up", "x", code=2).stderr.startswith("error: Invalid value for '--up'")


def test_a_signal_has_no_axis(run, clips) -> None:
    plain, told = (
        json.loads(run("warp", clips.csv, "--length", "80%", "--json", *up).stdout) for up in ((), ("--up", "z"))
    )
    assert plain["path"] == told["path"]


def test_a_motion_knows_its_axis_through_everything(both) -> None:
    clip = retime.read(both[1], up="z")
    assert isinstance(clip, Motion)
    assert retime.apply_warp(clip.frames(3, 63), retime.Warp([0, 1], [0, 59 / 60])).up == "z"
    assert clip.at([0.5]).up == "z"
    assert not seems_z_up(clip)
    with pytest.raises(retime.InvalidMotionError, match="vertical axis"):
        replace(clip, up="x")
    with pytest.raises(retime.OptionError, match="up must be one of y, z"):
        retime.read(both[1], up="Z")
