from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import retime
from retime.errors import OptionError
from retime.motion.signal import Signal
from retime.warp.resampling import resample
from tests.motion.strategies import RATES
from tests.warp.motions import wandering_motion


def clock(n_frames: int, rate: Fraction) -> Signal:
    """Make a signal that says its own time, in units of its period."""
    return Signal(("x",), np.arange(float(n_frames))[:, None], rate)


@given(st.integers(1, 400), st.sampled_from(RATES), st.sampled_from(RATES))
def test_every_moment_stays_where_it_was(n_frames: int, old: Fraction, new: Fraction) -> None:
    found = resample(clock(n_frames, old), new)
    assert found.rate == new
    expected = [k * old / new for k in range(10_000) if k * old / new <= n_frames - 1][: found.n_frames + 1]
    assert found.n_frames == math.floor(Fraction(n_frames - 1) * new / old) + 1
    assert len(expected) == min(found.n_frames, 10_000)
    np.testing.assert_allclose(found.values[:10_000, 0], list(map(float, expected)), atol=1e-8)
    shared = [k for k, place in enumerate(expected) if place.denominator == 1]
    assert [found.values[k, 0] for k in shared] == [float(expected[k]) for k in shared]


def test_a_film_of_the_sample_ends_when_the_sample_does() -> None:
    sample = retime.sample()
    film = resample(sample, 24)
    assert (sample.n_frames, sample.rate, film.n_frames) == (816, 60, 327)
    assert film.end_time == sample.end_time
    np.testing.assert_array_equal(film.rotations[2::2], sample.rotations[5::5][: len(film.rotations[2::2])])


def test_there_and_back_gives_the_frames_that_were_there() -> None:
    motion = wandering_motion(31, 5)
    back = resample(resample(motion, motion.rate * 4), motion.rate)
    assert np.array_equal(back.rotations, motion.rotations)
    assert np.array_equal(back.local_translations, motion.local_translations)
    assert resample(motion) is motion
    assert resample(motion, str(motion.rate)) is motion


def test_frames_keep_their_numbers_in_time() -> None:
    assert resample(Signal(("x",), np.zeros((50, 1)), 60, first_frame=120), 24).first_frame == 48


@pytest.mark.parametrize("on", [2, 3, 7])
def test_poses_are_held(on: int) -> None:
    motion = wandering_motion(31, 6)
    shown = resample(motion, on=on)
    assert (shown.n_frames, shown.rate) == (motion.n_frames, motion.rate)
    for frame in range(31):
        assert np.array_equal(shown.rotations[frame], motion.rotations[frame - frame % on])
        assert np.array_equal(shown.local_translations[frame], motion.local_translations[frame - frame % on])


def test_events_happen_once_though_poses_are_held() -> None:
    values = np.column_stack([np.arange(6.0), [0, 0, 1, 0, 0, 1], np.arange(6.0) * 40])
    shown = resample(Signal(("x", "e", "t"), values, 25, kinds=["linear", "event", "time:ms"]), on=2)
    assert shown.values.T.tolist() == [[0, 0, 2, 2, 4, 4], [0, 0, 1, 0, 0, 1], [0, 40, 80, 120, 160, 200]]


@pytest.mark.parametrize("on", [0, 1001, 1.5, "2"])
def test_what_is_no_number_of_frames_is_refused(on) -> None:
    with pytest.raises(OptionError, match="a pose is held"):
        resample(clock(3, Fraction(30)), on=on)


def test_what_is_no_clip_is_refused() -> None:
    with pytest.raises(OptionError, match="expected resample"):
        resample(np.zeros(3), 24)
    with pytest.raises(OptionError, match="rate"):
        resample(clock(3, Fraction(30)), 0)


def test_a_clip_whose_own_rate_is_wrong_makes_no_millions_of_frames() -> None:
    """A frame time of an hour, which was a number of something else, made 3 million frames of 30."""
    slow = clock(30, Fraction(1, 3600))
    words = (
        r"3132001 frames, and take 0\.0251 GB, where the input has 30 frames; 262144 .* Is 0\.000278 Hz, the clip's own"
    )
    with pytest.raises(OptionError, match=words):
        resample(slow, 30)
    assert resample(slow, 1).n_frames == 29 * 3600 + 1
    # A long clip that is refined a thousand times is one that somebody meant.
    assert resample(clock(1001, Fraction(1)), 1000).n_frames == 1_000_001
