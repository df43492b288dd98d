from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from retime.errors import InvalidMotionError, OptionError
from retime.motion.signal import Signal
from tests.motion.strategies import RATES


def camera(n_frames: int = 4, **changes) -> Signal:
    parts = {
        "names": ("pan", "zoom"),
        "values": np.arange(2.0 * n_frames).reshape(n_frames, 2) ** 2,
        "rate": Fraction(10),
        **changes,
    }
    return Signal(**parts)


def test_counts_and_duration() -> None:
    assert (camera().n_frames, camera().duration, camera(1).duration) == (4, 0.4, 0.1)
    assert (camera().end_time, camera(1).end_time) == (0.3, 0.0)


def test_values_cannot_be_written() -> None:
    with pytest.raises(ValueError, match="read-only"):
        camera().values[0, 0] = 1.0


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"values": np.zeros((0, 2))}, r"2 named channels\), found \(0, 2\)"),
        ({"values": np.zeros((4, 3))}, r"2 named channels\), found \(4, 3\)"),
        ({"values": np.zeros(4)}, r"found \(4,\)"),
        ({"names": (), "values": np.zeros((4, 0))}, r"0 named channels\), found \(4, 0\)"),
        ({"values": np.array([[0, 0], [0, np.nan]])}, "channel 'zoom' at frame 1 is not finite: nan"),
        ({"values": np.array([[0, 0], [-np.inf, 0]])}, "channel 'pan' at frame 1 is not finite: -inf"),
    ],
)
def test_what_no_signal_holds_is_refused(changes, message: str) -> None:
    with pytest.raises(InvalidMotionError, match=message):
        camera(**changes)


def test_frames_are_cut_with_their_numbers() -> None:
    cut = camera(first_frame=1).frames(1, 3)
    assert (cut.n_frames, cut.first_frame, cut.names) == (2, 2, ("pan", "zoom"))
    assert np.array_equal(cut.values, camera().values[1:3])


@pytest.mark.parametrize(("start", "stop"), [(-1, 2), (0, 5), (2, 2), (3, 1)])
def test_a_range_outside_is_refused(start: int, stop: int) -> None:
    with pytest.raises(OptionError, match=f"frames {start} to {stop - 1} .* frames 0 to 3"):
        camera().frames(start, stop)


def test_another_rate_plays_the_same_frames() -> None:
    assert camera().with_rate(Fraction(5)).duration == 2 * camera().duration


@given(st.sampled_from(RATES), st.integers(1, 50))
def test_own_frames_come_back_bit_for_bit(rate: Fraction, n_frames: int) -> None:
    signal = camera(n_frames, rate=rate)
    assert np.array_equal(signal.at(np.arange(n_frames) / float(rate)).values, signal.values)


@given(st.lists(st.floats(-1, 2), min_size=1, max_size=8))
def test_sampling_is_linear_and_held_at_the_ends(times: list[float]) -> None:
    signal = camera(4)
    for channel in range(2):
        expected = np.interp(times, np.arange(4) / 10, signal.values[:, channel])
        np.testing.assert_allclose(signal.at(times).values[:, channel], expected, atol=1e-6)


def test_what_is_not_time_is_kept() -> None:
    sampled = camera(name="crane", time_column="t", first_frame=5).at([0.0])
    assert (sampled.name, sampled.time_column, sampled.first_frame) == ("crane", "t", 0)


def test_a_hole_is_drawn_as_one() -> None:
    values = np.arange(20.0)[:, None]
    values[8:11] = np.nan
    whole, parted = (Signal(("x",), one, 10, gaps="keep")._repr_html_() for one in (np.arange(20.0)[:, None], values))
    assert parted.count("<polyline") + parted.count("<path") == whole.count("<polyline") + whole.count("<path") + 1
    assert "nan" not in parted.lower()
