"""A motion's accents, where they are known."""

from __future__ import annotations

import numpy as np
import pytest

from retime import sample
from retime.motion.accents import accents
from retime.motion.contacts import contacts
from retime.motion.signal import Signal


def test_peaks_of_speed_are_where_a_swing_passes_its_middle() -> None:
    times = np.arange(0, 6, 1 / 60)
    for frequency in (0.5, 1.0, 1.5):
        swing = Signal(("x", "still"), np.stack([np.sin(2 * np.pi * frequency * times), 0 * times], axis=1), 60)
        found = [accent.time for accent in accents(swing)]
        wanted = np.arange(1, int(12 * frequency)) / (2 * frequency)
        assert found == pytest.approx(wanted, abs=0.02)


def test_steps_are_where_feet_come_down() -> None:
    clip = sample()
    standing = contacts(clip).at_rest
    begun = np.flatnonzero((standing[1:] & ~standing[:-1]).any(axis=1)) + 1
    steps = [accent.time for accent in accents(clip) if "step" in accent.kind]
    for time in begun / float(clip.rate):
        assert min(abs(time - step) for step in steps) < 0.12
    times = [accent.time for accent in accents(clip)]
    assert np.diff(times).min() >= 0.1
    assert all(0 <= accent.strength <= 1 for accent in accents(clip))


@pytest.mark.parametrize("values", [np.zeros((50, 1)), np.ones((2, 1)), np.linspace(0, 1, 40)[:, None]])
def test_what_has_no_peak_has_no_accent(values) -> None:
    assert accents(Signal(("x",), values, 30)) == []
