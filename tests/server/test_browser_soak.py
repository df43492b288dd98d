"""A few rounds of gestures in a real browser leave no values, nodes or listeners behind; thousands are a command."""

from __future__ import annotations

import pytest

from tests.fuzz.page_soak import Held, grown, soak
from tests.server.test_browser import pytestmark  # noqa: F401


def test_rounds_of_gestures_leave_nothing_behind() -> None:
    # In the first two rounds everything is opened once.
    held = soak(40, 10)
    assert [one.number for one in held] == [0, 10, 20, 30, 40]
    shares = grown(held, settled=20)
    assert shares["nodes"] * held[2].nodes <= 8
    assert shares["listeners"] <= 0
    # Some dozens come with what browser and driver do for the first time; ten kept of each gesture would be this.
    assert shares["values"] * held[2].values <= 200
    assert held[-1].nodes > 1000
    assert held[-1].bytes > 1 << 20
    assert held[-1].values > 5000


def test_what_grows_is_told_and_what_was_typed_is_left_out() -> None:
    def look(number: int, nodes: int, listeners: int = 10, size: int = 100, values: int = 1000) -> Held:
        return Held(number, size, nodes, listeners, values)

    level = [look(0, 50), look(100, 200), look(200, 210), look(300, 220)]
    assert grown(level) == {"values": 0.0, "nodes": 0.0, "listeners": 0.0, "bytes": 0.0}
    grows = [look(100, 200), look(200, 230, 11), look(300, 220, 10, 150, 1010)]
    assert grown(grows) == pytest.approx({"values": 0.01, "nodes": 0.1, "listeners": 0.1, "bytes": 0.5})
    # What can be taken back is a thousand times at most.
    for nodes, share in ((1200, 0.0), (1300, 0.5)):
        assert grown([look(100, 200), look(30_100, nodes)])["nodes"] == pytest.approx(share)
