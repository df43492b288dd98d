"""Scenes whose animation is curves, on the command line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from retime.cli.main import main
from retime.data import SAMPLE
from retime.formats import read
from retime.formats.curves.gltf import format as gltf
from retime.formats.read_options import ReadOptions
from retime.motion.motion import Motion
from tests.formats.curves.gltf.scenes import Scene, sliding_scene
from tests.reference.gltf import Scene as Literal


def test_the_command_retimes_each_animation_by_a_warp_of_its_own(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    scene = Scene()
    scene.node(name="a")
    for name, n in (("walk", 90), ("run", 45)):
        times, places = scene.accessor(np.arange(n) / 30), np.cumsum(rng.normal(size=(n, 3)), axis=0)
        scene.animation(name, [(0, "translation", times, scene.accessor(places), "LINEAR")])
    path, out = tmp_path / "a.glb", tmp_path / "b.glb"
    path.write_bytes(scene.glb())
    run = CliRunner().invoke(main, ["warp", str(path), "--length", "50%", "-o", str(out)])
    assert run.exit_code == 0, run.output
    ends = [gltf.read(out, out.read_bytes(), ReadOptions(animation=name)).end_time for name in ("walk", "run")]
    np.testing.assert_allclose(ends, [44 / 30, 21 / 30], atol=1e-3)
    run = CliRunner().invoke(main, ["warp", str(path), "--length", "50%", "-o", str(out), "--force", "--json"])
    assert run.exit_code == 2
    assert "choose one of them (--animation)" in run.output
    one = ["warp", str(path), "--animation", "run", "--length", "50%", "-o", str(out), "--force", "--save"]
    run = CliRunner().invoke(main, [*one, str(tmp_path / "w.json")])
    assert run.exit_code == 0, run.output
    literal = Literal(out)
    last = [literal.accessor(a["samplers"][0]["input"])[-1][0] for a in literal.json["animations"]]
    np.testing.assert_allclose(last, [89 / 30, 21 / 30], atol=1e-3)
    # What was saved does the same by retime apply.
    again = tmp_path / "c.glb"
    apply = ["apply", str(tmp_path / "w.json"), str(path), "--animation", "run", "-o", str(again)]
    run = CliRunner().invoke(main, apply)
    assert run.exit_code == 0, run.output
    assert again.read_bytes() == out.read_bytes()


def test_frames_left_out_at_the_start_are_left_out_of_the_scene(tmp_path: Path) -> None:
    scene = sliding_scene()
    path, out = tmp_path / "a.glb", tmp_path / "b.glb"
    path.write_bytes(scene.glb())
    args = ["warp", str(path), "--method", "linear", "--frames", "20:50", "--length", "100%", "-o", str(out)]
    run = CliRunner().invoke(main, args)
    assert run.exit_code == 0, run.output
    literal = Literal(out)
    assert [literal.value(0, 0, time)[0] for time in (0.0, 0.5, 1.0)] == pytest.approx([20, 35, 50], abs=1e-4)


def test_more_tolerance_makes_fewer_keys_and_baking_one_on_every_frame(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    scene = Scene()
    scene.node(name="a")
    places = scene.accessor(np.cumsum(rng.normal(size=(60, 3)), axis=0))
    scene.animation("x", [(0, "translation", scene.accessor(np.arange(60) / 30), places, "LINEAR")])
    path = tmp_path / "a.glb"
    path.write_bytes(scene.glb())
    n_keys = {}
    for name, more in (("fine", ["--tolerance", "0"]), ("coarse", ["--tolerance", "0.05s"]), ("baked", ["--bake"])):
        out = tmp_path / f"{name}.glb"
        run = CliRunner().invoke(main, ["warp", str(path), "--length", "150%", "-o", str(out), *more])
        assert run.exit_code == 0, run.output
        literal = Literal(out)
        n_keys[name] = len(literal.accessor(literal.json["animations"][0]["samplers"][0]["input"]))
    assert 60 <= n_keys["coarse"] < n_keys["fine"]
    assert n_keys["baked"] == 90


def test_an_fbx_scene_makes_the_whole_trip(tmp_path: Path) -> None:
    def run(*args: str) -> str:
        found = CliRunner().invoke(main, [args[0], *map(str, args[1:])])
        assert found.exit_code == 0, found.output
        return found.output

    walk, short, baked = (str(tmp_path / name) for name in ("walk.fbx", "short.fbx", "baked.fbx"))
    run("convert", str(SAMPLE), walk)
    assert "a motion (fbx)" in run("info", walk)
    run("warp", walk, "--method", "linear", "--length", "50%", "-o", short, "--save", str(tmp_path / "w.json"))
    assert "its curves baked" in run("apply", str(tmp_path / "w.json"), walk, "--bake", "-o", baked)
    before, after, sampled = (read(path) for path in (SAMPLE, short, baked))
    assert isinstance(before, Motion)
    for clip in (after, sampled):
        assert isinstance(clip, Motion)
        assert clip.n_frames == pytest.approx(before.n_frames / 2, abs=1)
        assert clip.skeleton.names[0] == before.skeleton.names[0]
    assert isinstance(after, Motion)
    there = before.at(np.arange(after.n_frames) / 60 * before.end_time / after.end_time)
    np.testing.assert_allclose(after.local_translations[:, 0], there.local_translations[:, 0], atol=1e-3)
