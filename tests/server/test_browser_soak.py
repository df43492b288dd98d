"""A few rounds of gestures in a real browser leave no nodes and no listeners behind; thousands are a command."""

from __future__ import annotations

from tests.fuzz.page_soak import grown, soak
from tests.server.test_browser import pytestmark  # noqa: F401


def test_rounds_of_gestures_leave_nothing_behind() -> None:
    # In the first two rounds everything is opened once.
    held = soak(40, 10)
    assert [one.number for one in held] == [0, 10, 20, 30, 40]
    shares = grown(held, settled=20)
    # A field keeps what was typed before, one node of text each time, so that Chromium can take it back.
    assert shares["nodes"] * held[2].nodes <= 10
    assert shares["listeners"] == 0
    assert held[-1].nodes > 1000
    assert held[-1].bytes > 1 << 20
