"""Commands notice a T-pose in front of a capture, and say how to leave it out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import retime
from tests.motion.test_first_frames import with_pose_in_front
from tests.motion.walkers import walker


def test_each_command_says_it_once_and_leaves_it_out(tmp_path: Path, run) -> None:
    path = tmp_path / "walk.bvh"
    retime.write(with_pose_in_front(replace(walker(90), name="")), path)
    commands = {
        "info": ("info", path),
        "warp": ("warp", path, "--length", "80%", "-o", "a.bvh", "--save", "a.json"),
        "linear": ("warp", path, "--length", "80%", "--method", "linear", "-o", "b.bvh"),
        "apply": ("apply", "a.json", path, "-o", "c.bvh"),
        "convert": ("convert", path, "d.bvh"),
        "imitate": ("imitate", path, "--example", "10:40", "--warp", "hand.json", "-o", "e.bvh"),
    }
    retime.Warp([0.0, 1.0], [0.0, 0.6]).save(tmp_path / "hand.json")
    for name, command in commands.items():
        assert run(*command).stderr.count("--drop-first 1 ") == 1, name
        force = ["--force"] if name != "info" else []
        assert "--drop-first" not in run(*command, "--drop-first", "1", *force).stderr
        assert "--drop-first" not in run(*command, "--frames", "1:", *force).stderr
    assert json.loads(run("info", path, "--json").stdout)["frames_before_capture"] == 1


def test_a_reference_has_an_option_of_its_own(tmp_path: Path, run) -> None:
    retime.write(with_pose_in_front(walker(90)), tmp_path / "posed.bvh")
    retime.write(walker(90), tmp_path / "walk.bvh")
    command = ("warp", "walk.bvh", "--length", "80%", "-q")
    assert "posed: the first frame" in (said := run(*command, "--reference", "posed.bvh").stderr)
    assert said.count("--reference-frames 1: ") == 1
    assert run(*command, "--reference", "posed.bvh", "--reference-frames", "1:").stderr == ""
