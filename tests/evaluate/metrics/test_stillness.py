"""Where a figure stands still, and how much it moves."""

from __future__ import annotations

import numpy as np
import pytest

from retime.evaluate.metrics.spans import seconds_shown
from retime.evaluate.metrics.stillness import activity, idle_spans
from retime.warp.curve import Warp
from tests.evaluate.metrics.motions import along


def test_standing_still_is_found_and_shown_for_as_long_as_the_warp_says() -> None:
    walk = np.concatenate([np.zeros(60), np.arange(1, 61) / 60 * 1.4, np.full(90, 1.4)])
    spans = idle_spans(along(0, walk))
    # Speeds are taken over a thirtieth of a second to either side.
    assert np.ravel(spans) == pytest.approx([0.0, 59 / 60, 2.0, 209 / 60], abs=1 / 30 + 1e-9)
    assert seconds_shown(Warp([0.0, 3.5 / 2], [0.0, 3.5]), spans) == pytest.approx(1.25, abs=0.05)


def test_a_short_stop_is_no_idling() -> None:
    walk = np.concatenate([np.arange(60) / 60, np.full(8, 1.0), 1.0 + np.arange(60) / 60])
    assert idle_spans(along(0, walk)) == ()


def test_activity_is_the_speed_of_the_root() -> None:
    assert activity(along(0, np.arange(120) / 60 * 2.0)) == pytest.approx(np.full(120, 2.0))
