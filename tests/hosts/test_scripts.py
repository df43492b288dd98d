"""Scripts for programs that can't be run here, run against stand-ins that record what is done to them."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import types
from fractions import Fraction
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

from retime import export_curve
from retime.warp.curve import Warp

WARP = Warp([0.0, 1.0, 2.0, 3.0], [0.0, 2.0, 2.0, 1.0])


class Maya:
    """A scene: its unit, its animation curves, and what a script connects and sets."""

    def __init__(self, unit: str, curves: list[str]) -> None:
        self.unit, self.curves = unit, curves
        self.set: dict[str, object] = {}
        self.connected: list[tuple[str, str]] = []
        self.open = 0
        self.keys: list[float] = []

    def currentUnit(self, *, query: bool, time: bool) -> str:
        return self.unit

    def ls(self, name: str, *, type: str) -> list[str]:
        return [name] if name in self.curves else []

    def undoInfo(self, *, openChunk: bool = False, closeChunk: bool = False) -> None:
        self.open += openChunk - closeChunk

    def createNode(self, kind: str, *, name: str) -> str:
        assert kind == "animCurveTT"
        return f"{name}1"

    def setAttr(self, name: str, value: object) -> None:
        self.set[name] = value

    def connectAttr(self, source: str, target: str, *, force: bool) -> None:
        self.connected.append((source, target))

    def eval(self, text: str) -> None:
        match = re.fullmatch(r'setAttr -s (\d+) "retimeWarp1\.ktv\[0:(\d+)\]" (.*)', text)
        assert match is not None
        self.keys = [float(word) for word in match[3].split()]
        assert len(self.keys) == 2 * int(match[1]) == 2 * (int(match[2]) + 1)


def run_in(scene: Maya, script: Path) -> None:
    maya = types.ModuleType("maya")
    maya.cmds, maya.mel = scene, scene  # type: ignore[attr-defined]
    with mock.patch.dict(sys.modules, {"maya": maya}):
        exec(compile(script.read_text(), str(script), "exec"), {})


def test_maya_s_script_warps_the_named_curves_and_no_other(tmp_path) -> None:
    script = tmp_path / "a.py"
    export_curve(WARP, script, "maya", rate=25, start=101, item="hips_tx, ns:hips_ty")
    scene = Maya("pal", ["hips_tx", "ns:hips_ty", "head_tx"])
    run_in(scene, script)
    assert scene.keys == [101, 101, 126, 151, 151, 151, 176, 126]
    assert scene.set == {"retimeWarp1.tan": 2, "retimeWarp1.wgt": False}
    assert scene.connected == [("retimeWarp1.output", f"{name}.input") for name in ("hips_tx", "ns:hips_ty")]
    assert scene.open == 0
    with pytest.raises(RuntimeError, match="the scene counts film, this curve pal"):
        run_in(Maya("film", ["hips_tx"]), script)
    with pytest.raises(RuntimeError, match="no animation curve is called ns:hips_ty"):
        run_in(Maya("pal", ["hips_tx"]), script)


class Sequence:
    """A Level Sequence with a Time Warp track, and a channel that takes keys, or does not."""

    def __init__(self, *, keyed: bool) -> None:
        self.keys: list[tuple[float, float, str]] = []
        self.keyed = keyed

    def get_display_rate(self) -> Fraction:
        return Fraction(24)

    def get_tick_resolution(self) -> Fraction:
        return Fraction(24000)

    def find_tracks_by_type(self, kind: str) -> list[Sequence]:
        return [self]

    get_sections = lambda self: [self]  # noqa: E731

    def get_all_channels(self) -> list[object]:
        return [types.SimpleNamespace(), *([self.channel()] if self.keyed else [])]

    def channel(self) -> object:
        def add_key(frame: int, value: float, within: float) -> object:
            place = len(self.keys)
            self.keys.append((frame + within, value, ""))

            def linear(mode: str) -> None:
                self.keys[place] = (*self.keys[place][:2], mode)

            return types.SimpleNamespace(set_interpolation_mode=linear)

        return types.SimpleNamespace(add_key=add_key, get_keys=list, remove_key=None)


def test_unreal_s_script_keys_the_track_or_prints_the_keys(tmp_path, capsys) -> None:
    script = tmp_path / "a.py"
    export_curve(WARP, script, "unreal", rate=24)

    def run(sequence: Sequence | None) -> None:
        library = types.SimpleNamespace(get_current_level_sequence=lambda: sequence)
        unreal = types.ModuleType("unreal")
        unreal.LevelSequenceEditorBlueprintLibrary = library  # type: ignore[attr-defined]
        unreal.MovieSceneTimeWarpTrack = "track"  # type: ignore[attr-defined]
        unreal.FrameNumber = int  # type: ignore[attr-defined]
        unreal.RichCurveInterpMode = types.SimpleNamespace(RCIM_LINEAR="linear")  # type: ignore[attr-defined]
        with mock.patch.dict(sys.modules, {"unreal": unreal}):
            exec(compile(script.read_text(), str(script), "exec"), {})

    sequence = Sequence(keyed=True)
    run(sequence)
    # Values are ticks of the sequence, a thousand a frame here.
    assert sequence.keys == [(0, 0, "linear"), (24, 48000, "linear"), (48, 48000, "linear"), (72, 24000, "linear")]
    with pytest.raises(RuntimeError, match="no access to the keys"):
        run(Sequence(keyed=False))
    assert "frame 72 shows frame 24" in capsys.readouterr().out
    with pytest.raises(RuntimeError, match="open the Level Sequence first"):
        run(None)


_AFTER_EFFECTS = """
const script = require("fs").readFileSync(process.argv[1], "utf8");
const KeyframeInterpolationType = { LINEAR: "linear" };
class CompItem {}
// Time Remap has two keys of its own as soon as it is on, and never none.
let keys = [], undo = 0;
const remap = {
  get numKeys() { return keys.length; },
  keyTime: (i) => keys[i - 1].at,
  setValuesAtTimes(at, shows) {
    at.forEach((time, i) => {
      keys = keys.filter((key) => Math.abs(key.at - time) > 1e-9);
      keys.push({ at: time, shows: shows[i], kind: "bezier" });
    });
    keys.sort((a, b) => a.at - b.at);
  },
  removeKey(i) {
    if (keys.length === 1) throw new Error("a remapped layer has a key");
    keys.splice(i - 1, 1);
  },
  setInterpolationTypeAtKey: (i, before, after) => { keys[i - 1].kind = [before, after].join(); },
};
const layer = {
  canSetTimeRemapEnabled: true,
  startTime: 1,
  set timeRemapEnabled(on) { keys = [{ at: 1, shows: 0 }, { at: 11, shows: 10 }]; },
  property: (name) => { if (name !== "ADBE Time Remapping") throw new Error(name); return remap; },
};
const comp = Object.assign(new CompItem(), {
  selectedLayers: [], frameDuration: 0.04, layers: { byName: (name) => name === "Shot 12" ? layer : null },
});
const app = { project: { activeItem: comp }, beginUndoGroup() { undo++; }, endUndoGroup() { undo--; } };
new Function("app", "CompItem", "KeyframeInterpolationType", script)(app, CompItem, KeyframeInterpolationType);
console.log(JSON.stringify({ keys, undo, out: layer.outPoint }));
"""


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node")
def test_after_effects_script_leaves_the_layer_with_our_keys_alone(tmp_path) -> None:
    script = tmp_path / "a.jsx"
    export_curve(WARP, script, "after-effects", item="Shot 12")

    def run() -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            ["node", "-e", _AFTER_EFFECTS, str(script)], capture_output=True, text=True, timeout=60, check=False
        )

    done = json.loads(run().stdout)
    assert done["undo"] == 0
    assert [key["kind"] for key in done["keys"]] == ["linear,linear"] * 4
    np.testing.assert_allclose([key["at"] for key in done["keys"]], WARP.output_times + 1)
    np.testing.assert_allclose([key["shows"] for key in done["keys"]], WARP.input_times)
    assert done["out"] == pytest.approx(4.04)
    export_curve(WARP, script, "after-effects", item="Shot 13", overwrite=True)
    assert "There is no layer Shot 13." in run().stderr
    export_curve(WARP, script, "after-effects", overwrite=True)
    assert "Select the layer first." in run().stderr
