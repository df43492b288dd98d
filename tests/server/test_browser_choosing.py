"""Keytimes chosen together, in a real browser: web/test/choosing.mjs drives it."""

from __future__ import annotations

from pathlib import Path

import retime
from tests.server.test_browser import drive, pytestmark, rooms  # noqa: F401


def test_keys_are_chosen_moved_scaled_copied_listed_and_deleted_together(rooms):  # noqa: F811
    clip = Path(rooms["folder"]) / "sample.bvh"
    retime.write(retime.sample(), clip)
    found = drive("choosing.mjs", 240, clip=str(clip), **rooms)
    assert len(found["keys"]) == 3
