"""Keytimes chosen together, units, markers and the work area, in a real browser: scripts of web/test drive it."""

from __future__ import annotations

from pathlib import Path

import pytest

import retime
from retime.project.document import WorkArea
from retime.project.file import read_project
from tests.formats.curves.gltf.scenes import skinned_scene
from tests.server.test_browser import drive, pytestmark, rooms  # noqa: F401


def test_keys_are_chosen_moved_scaled_copied_listed_and_deleted_together(rooms):  # noqa: F811
    clip = Path(rooms["folder"]) / "sample.bvh"
    retime.write(retime.sample(), clip)
    found = drive("choosing.mjs", 240, clip=str(clip), **rooms)
    assert len(found["keys"]) == 3


def test_times_are_typed_dragged_marked_looped_and_trimmed(rooms):  # noqa: F811
    clip = Path(rooms["folder"]) / "sample.bvh"
    retime.write(retime.sample(), clip)
    found = drive("units.mjs", 240, clip=str(clip), **rooms)
    document = read_project(Path(str(found["project"]))).document
    assert document.clips[0].first_frame == 60
    (key,) = document.keys
    assert key.input_time == pytest.approx(float(str(found["pose"])) - 1, abs=1e-3)
    assert document.work_area == WorkArea(1.0, pytest.approx(76 / 60))
    beat, pose = sorted(document.markers, key=lambda marker: marker.on, reverse=True)
    assert (beat.name, beat.on, beat.time) == ("beat", "output", 2.0123)
    assert (pose.name, pose.on) == ("", "input")


def test_the_stage_and_the_timeline_show_what_is_looked_at(rooms):  # noqa: F811
    folder = Path(rooms["folder"])
    retime.write(retime.sample(), folder / "sample.bvh")
    retime.write(retime.sample().frames(60, 400), folder / "other.bvh")
    (folder / "skinned.glb").write_bytes(skinned_scene(4, 60).glb())
    found = drive("seeing.mjs", 300, clip=str(folder / "sample.bvh"), other="other.bvh", mesh="skinned.glb", **rooms)
    assert int(str(found["map"])) >= 240
