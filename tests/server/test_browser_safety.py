"""Work is never lost or stuck, in a real browser: web/test/safety.mjs drives it."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import numpy as np

import retime
from retime.project.file import read_project
from tests.server.test_browser import drive, pytestmark, rooms  # noqa: F401


def test_broken_files_two_tabs_failed_exports_dead_servers_and_long_searches(rooms):  # noqa: F811
    folder = Path(rooms["folder"])
    clip = folder / "sample.bvh"
    retime.write(retime.sample(), clip)
    # Played evenly it is there at once; its search takes minutes, if nobody stops it.
    values = np.random.default_rng(0).standard_normal((8000, 30)).cumsum(axis=0)
    retime.write(retime.Signal(tuple(f"c{i}" for i in range(30)), values, Fraction(30)), folder / "slow.csv")
    options = {"length": "150%", "upsample": 8, "max_skip": 40}
    slow = {"clips": [{"path": "slow.csv"}], "method": "linear", "options": options}
    (folder / "slow.retime").write_text(json.dumps({"format": "retime-project", "version": 3, "document": slow}))
    found = drive("safety.mjs", 240, clip=str(clip), slow=str(folder / "slow.retime"), **rooms)
    document = read_project(str(found["project"])).document
    assert (len(document.keys), document.options) == (2, {"length": "75%"})
