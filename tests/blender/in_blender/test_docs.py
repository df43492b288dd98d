"""docs/blender.md, followed word by word."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs bpy: make test-blender")
from rigs import fcurves, poses, run, select, shown, timing  # noqa: E402

ROOT = Path(__file__).resolve().parents[3]
PAGE = (ROOT / "docs" / "blender.md").read_text(encoding="utf-8")
# What `retime demo` leaves as demo/sample.bvh.
CLIP = ROOT / "src" / "retime" / "data" / "sample.bvh"


@pytest.fixture
def imported(scene):
    """Import the motion as the page says."""
    bpy.ops.preferences.addon_enable(module="io_anim_bvh")
    bpy.ops.import_anim.bvh(filepath=str(CLIP), global_scale=0.01, update_scene_fps=True, update_scene_duration=True)
    select(bpy.context.object)
    return bpy.context.object


def test_a_walk_is_retimed_and_the_panel_says_what_the_page_says(scene, imported):
    scene.retime.search_length = re.search(r"Type `(.+?)` into \*Length\*", PAGE)[1]
    old, end = imported.animation_data.action, scene.frame_end
    assert run("retime") == {"FINISHED"}
    quoted = re.search(r"The panel says what was done:\n\n((?:    .+\n)+)", PAGE)[1]
    assert scene.retime.summary.split("\n") == [line.strip() for line in quoted.splitlines()]
    # Blender's importer lets the scene end one frame after the last key.
    assert (end, scene.frame_end) == (817, 531)
    assert old.use_fake_user
    assert [curve.data_path for curve in fcurves(scene)] == ['["retime_curve"]']


@pytest.mark.parametrize("result", ["KEYS", "NLA", "BAKE"])
def test_poses_of_the_walk(scene, imported, result):
    scene.retime.search_length, scene.retime.result, scene.retime.average = "65%", result, False
    run("preview")
    frames = np.arange(1, 531, 3)
    wanted = poses([imported], shown(frames))
    run("retime")
    assert timing()[0][-1] == 530
    # A walk of several metres; single precision has seven digits.
    np.testing.assert_allclose(poses([imported], frames), wanted, atol=1e-4 if result == "BAKE" else 1e-5)


def test_what_is_called_by_name_on_the_page_is_there(scene):
    labels = {described.name for described in scene.retime.bl_rna.properties}
    labels |= {getattr(bpy.ops.retime, name).get_rna_type().name for name in dir(bpy.ops.retime)}
    labels |= {item.name for item in scene.retime.bl_rna.properties["result"].enum_items}
    labels |= {panel.bl_label for panel in bpy.types.Panel.__subclasses__() if panel.__name__.startswith("RETIME_PT")}
    named = (
        "Range, Length, Keytimes and Locks, To Moved Markers, Influence, Smoothness, Keep jumps, Evenness, Like, "
        "Synchronise, More, Keys Kept, Tolerance, Keys on Whole Frames, NLA Strip, Baked, Propagate, Before, Preview, "
        "Use the Curve, Open in the Editor, Take the Timing Back, Retime"
    )
    for name in named.split(", "):
        assert name in labels, name
        assert f"*{name}*" in PAGE, name
