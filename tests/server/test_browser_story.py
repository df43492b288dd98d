"""One continuous piece of work in a real browser: web/test/story.mjs does it, and takes a picture of each step."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import retime
from retime.project.file import read_project
from retime.project.solve import DocumentSolver
from tests.server.test_browser import drive, pytestmark, rooms  # noqa: F401


def test_open_limp_propagate_key_box_move_lock_export_kill_recover(rooms):  # noqa: F811
    folder = Path(rooms["folder"])
    clip = folder / "sample.bvh"
    retime.write(retime.sample(), clip)
    found = drive("story.mjs", 300, clip=str(clip), **rooms)

    # What the page exported is what the library makes of the project that it saved, before and after the kill.
    document = read_project(str(found["project"])).document
    solution = DocumentSolver().solve(document)
    other = folder / "by_hand.bvh"
    retime.write(retime.apply_warp(retime.read(clip), solution.warp, average=document.average), other)
    exported = Path(str(found["exported"])).read_bytes()
    assert exported == other.read_bytes()
    assert Path(str(found["again"])).read_bytes() == exported
    # The change that nobody had saved when the server was killed was there afterwards: 16 s long.
    longer = retime.read(str(found["longer"]))
    assert longer.n_frames == 16 * 60

    assert document.example is not None
    assert (document.example.start, document.example.end) == (2.0, 3.4)
    assert len(document.locks) == 1
    keys = sorted((key.output_time, key.input_time) for key in document.keys)
    np.testing.assert_allclose(
        keys, [(output, shown) for shown, output in found["keys"]], atol=0.0006
    )  # to the digits that a label has
    assert len(list(Path(rooms["shots"]).glob("story_*.png"))) == found["pictures"] == 10
