"""Frames and rows that a warp shows, against their literal definition."""

from __future__ import annotations

import warnings
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import OptionError, RetimeWarning
from retime.warp.curve import Warp
from tests.reference import curve as literal
from tests.warp.drawn import warps


@settings(max_examples=40)
@given(warps(forward=False), st.integers(1, 40), st.sampled_from([1, 7.5, Fraction(30000, 1001), 120]))
def test_frames_and_rows_are_those_of_the_literal_definition(warp: Warp, n_frames: int, rate: Fraction | float) -> None:
    rng = np.random.default_rng(n_frames)
    rows = rng.normal(size=(n_frames, 2, 3))
    labels = rng.integers(0, 5, n_frames)
    o, i = warp.output_times.tolist(), warp.input_times.tolist()
    n_output = max(1, round(warp.output_span * float(rate)) + 1)
    times = [min(o[0] + k / float(rate), o[-1]) for k in range(n_output)]
    times[-1] = o[-1] if n_output > 1 else o[0]
    places = [min(max(literal.evaluate(o, i, time) * float(rate), 0.0), n_frames - 1.0) for time in times]
    with warnings.catch_warnings():
        # The drawn warps care for no clip's ends.
        warnings.simplefilter("ignore", RetimeWarning)
        found = warp.to_frame_indices(rate, n_frames)
        shown = warp.resample(rows, rate)
        named = warp.resample(labels, rate, method="nearest")
    assert len(found) == len(shown) == len(named) == n_output
    for k, place in enumerate(places):
        assert abs(found[k] - place) <= 0.5 + 1e-6
        assert named[k] == labels[found[k]]
        low = min(int(place), n_frames - 1)
        high = min(low + 1, n_frames - 1)
        expected = rows[low] + (place - low) * (rows[high] - rows[low])
        np.testing.assert_allclose(shown[k], expected, atol=1e-6)


def test_the_identity_gives_back_the_same_rows_bit_for_bit() -> None:
    rows = np.random.default_rng(0).normal(size=(100, 3))
    whole = Warp([0.0, 99 / 30], [0.0, 99 / 30])
    assert np.array_equal(whole.resample(rows, 30), rows)
    assert whole.to_frame_indices(30, 100).tolist() == list(range(100))


def test_what_is_resampled_keeps_its_type_or_becomes_floats() -> None:
    half = Warp([0.0, 2.0], [0.0, 1.0])
    assert half.resample([0, 1], 1).tolist() == [0.0, 0.5, 1.0]
    assert half.resample([0, 1j], 1).tolist() == [0, 0.5j, 1j]
    assert half.resample(np.array([1, 2], np.uint8), 1, method="nearest").dtype == np.uint8
    assert half.resample(np.array([200, 0], np.uint8), 1).tolist() == [200.0, 100.0, 0.0]
    assert half.resample([True, False], 1, method="nearest").tolist() == [True, False, False]


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda w: w.resample(["a", "b"], 1), "method='nearest'"),
        (lambda w: w.resample([True, False], 1), "method='nearest'"),
        (lambda w: w.resample([1.0, 2.0], 1, method="cubic"), "one of linear, nearest; found 'cubic'"),
        (lambda w: w.resample(3.0, 1), "a row for each frame"),
        (lambda w: w.resample([], 1), "input frames must be 1 or more"),
        (lambda w: w.resample([1.0, 2.0], 0), "above 0"),
        (lambda w: w.resample([1.0, 2.0], "30"), "above 0, found the text '30'"),
        (lambda w: w.resample([1.0, 2.0], float("nan")), "above 0"),
        (lambda w: w.to_frame_indices(30, 2.5), "input frames must be 1 or more"),
        (lambda w: w.to_frame_indices(30, True), "input frames must be 1 or more"),
    ],
)
def test_arrays_that_can_not_be_shown_are_refused(call, says: str) -> None:
    with pytest.raises(OptionError, match=says):
        call(Warp([0.0, 1.0], [0.0, 1.0]))


def test_an_array_of_another_length_is_warned_of() -> None:
    warp = Warp([0.0, 1.0], [0.0, 1.0])
    with pytest.warns(RetimeWarning, match="reaches input times 0 to 1 s") as caught:
        assert warp.to_frame_indices(10, 6).tolist() == [0, 1, 2, 3, 4, 5, 5, 5, 5, 5, 5]
    assert caught[0].filename == __file__
    with pytest.warns(RetimeWarning, match="is left out"):
        warp.resample(np.zeros(30), 10)
