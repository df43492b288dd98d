"""USD scenes on the command line: retimed in place, or shown by a layer over them."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import pytest
from click.testing import CliRunner

import retime
from retime.cli.exit_codes import EXIT_FILE
from retime.cli.main import main
from tests.formats.curves.usd.scenes import DrawnScene

ROOT = Path(__file__).resolve().parents[2]
needs_usd = pytest.mark.skipif(
    importlib.util.find_spec("pxr") is None, reason="usd-core is not installed (make extras)"
)


def run(*args: object) -> str:
    ended = CliRunner().invoke(main, [str(arg) for arg in args])
    assert ended.exit_code == 0, ended.output
    return ended.output


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    path = tmp_path / "a.usda"
    path.write_text(DrawnScene(5).text())
    return path


def test_the_extra_is_named_where_it_is_missing(scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    for args in (["info", scene], ["convert", scene, scene.with_suffix(".bvh")]):
        ended = CliRunner().invoke(main, [str(arg) for arg in args])
        assert ended.exit_code == EXIT_FILE
        assert "a USD file needs usd-core, which is not installed: pip install 'retime[usd]'" in ended.output


def test_a_layer_is_for_usd(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("x\n1\n2\n3\n")
    out = tmp_path / "b.csv"
    args = [
        "warp",
        tmp_path / "a.csv",
        "--fps",
        "30",
        "--method",
        "linear",
        "--length",
        "50%",
        "--layer",
        "over",
        "-o",
        out,
    ]
    ended = CliRunner().invoke(main, [str(arg) for arg in args])
    assert ended.exit_code == 2
    assert "--layer over shows a USD scene" in ended.output
    assert not out.exists()


@pytest.mark.extras
@needs_usd
def test_a_scene_is_shown_looked_at_and_retimed(scene: Path) -> None:
    assert "a motion (usd)" in run("info", scene)
    out, saved = scene.with_name("b.usda"), scene.with_name("w.json")
    run("warp", scene, "--animation", "/Body/Skel/Anim", "--length", "70%", "-o", out, "--save", saved)
    again = scene.with_name("c.usda")
    assert "its curves cut" in run("apply", saved, scene, "-o", again)
    assert again.read_bytes() == out.read_bytes()
    assert "its curves baked" in run("apply", saved, scene, "--bake", "-o", scene.with_name("d.usda"))


@pytest.mark.extras
@needs_usd
@pytest.mark.parametrize("kind", ["clips", "over"])
def test_a_layer_leaves_the_scene_as_it_is(scene: Path, kind: str) -> None:
    from pxr import Usd

    before = scene.read_bytes()
    out, saved = scene.with_name("b.usda"), scene.with_name("w.json")
    run("warp", scene, "--length", "70%", "--layer", kind, "-o", out, "--save", saved)
    run("apply", saved, scene, "--layer", kind, "--out-dir", scene.parent, "--suffix", "_layer")
    assert scene.with_name("a_layer.usda").read_bytes() == out.read_bytes()
    assert scene.read_bytes() == before
    stages = [Usd.Stage.Open(str(path)) for path in (scene, out)]
    lengths = [stage.GetEndTimeCode() - stage.GetStartTimeCode() for stage in stages]
    assert lengths[1] == pytest.approx(0.7 * lengths[0], abs=stages[0].GetTimeCodesPerSecond() / 30)


@pytest.mark.extras
@needs_usd
def test_files_elsewhere_are_read_when_asked_for(scene: Path) -> None:
    folder = scene.parent / "in"
    folder.mkdir()
    inner = folder / "b.usda"
    inner.write_text(DrawnScene(5).text().replace("(\n    ", "(\n    subLayers = [@../a.usda@]\n    ", 1))
    ended = CliRunner().invoke(main, ["info", str(inner)])
    assert ended.exit_code == EXIT_FILE
    assert "--allow-outside lets files elsewhere be read" in ended.output
    assert "a motion (usd)" in run("info", inner, "--allow-outside")
    out = folder / "c.usda"
    run("warp", inner, "--allow-outside", "--length", "70%", "--layer", "over", "-o", out)
    assert out.exists()


@pytest.mark.extras
@needs_usd
def test_the_commands_of_the_page_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = ROOT / "docs" / "usd.md"
    commands = [line[2:] for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("$ retime ")]
    assert len(commands) == 6
    monkeypatch.chdir(tmp_path)
    (tmp_path / "demo").mkdir()
    retime.write(retime.sample()[:90], tmp_path / "demo" / "sample.bvh")
    for command in commands:
        run(*command.split()[1:])
    assert {path.name for path in tmp_path.glob("*.usda")} == {
        f"{name}.usda" for name in ("walk", "shorter", "clips", "over", "baked")
    }


@needs_usd
@pytest.mark.extras
def test_each_layer_that_is_written_is_told(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "walk.usda").write_text(
        '#usda 1.0\nover "a" {\n  double xformOp:rotateY.timeSamples = { 0: 0, 10: 30, 24: 20, 48: 90 }\n'
        '  uniform token[] xformOpOrder = ["xformOp:rotateY"]\n}\n'
    )
    scene = tmp_path / "shot.usda"
    scene.write_text(
        "#usda 1.0\n(\n timeCodesPerSecond = 24\n startTimeCode = 0\n endTimeCode = 48\n"
        ' subLayers = [@lib/walk.usda@]\n)\ndef Xform "a" {}\n'
    )
    out, layer, save = tmp_path / "new.usda", tmp_path / "new.walk.usda", tmp_path / "w.json"
    args = ["warp", scene, "-o", out, "--length", "70%", "--method", "linear"]
    said = [line.split()[1] for line in run(*args, "--save", save).splitlines() if line.startswith("wrote")]
    assert said == [str(out), str(save), str(layer)]
    assert layer.exists()
    # A layer that is there as it would be written belongs to the output all the same.
    told = json.loads(run(*args, "--force", "--json"))
    assert (told["output"], told["beside"]) == (str(out), [str(layer)])
    other = tmp_path / "other.usda"
    assert run("apply", save, scene, "-o", other).strip().endswith(f"with {tmp_path / 'other.walk.usda'}")
