"""blend(): the mix of two warps against its definition."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import OptionError
from retime.warp.blend import blend
from retime.warp.curve import Warp
from tests.warp.drawn import drawn_warp, some_times


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_blend_mixes_at_every_time(seed: int, weight: float) -> None:
    rng = np.random.default_rng(seed)
    one, other = drawn_warp(rng, 6, forward=True), drawn_warp(rng, 9, forward=True)
    start, length = one.output_start, one.output_span
    stretched = start + (other.output_times - other.output_start) * (length / other.output_span)
    stretched[-1] = one.output_end
    other = Warp(stretched, other.input_times)
    mixed = blend(one, other, weight)
    assert mixed.monotone
    assert (mixed.output_start, mixed.output_end) == (one.output_start, one.output_end)
    for time in some_times(one, seed):
        wanted = (1 - weight) * float(one(time)) + weight * float(other(time))
        assert float(mixed(time)) == pytest.approx(wanted, rel=1e-12, abs=1e-9)


@pytest.mark.parametrize("weight", [0.0, 0.1, 0.3, 1 / 3, 0.7, 1.0])
def test_blend_keeps_what_both_agree_on_bit_for_bit(weight: float) -> None:
    rng = np.random.default_rng(1)
    shared = np.cumsum(rng.random(40))
    one, other = shared + 0, shared + 0
    other[1::2] += 0.01
    mixed = blend(Warp(np.arange(40.0), one), Warp(np.arange(40.0), other), weight)
    assert np.array_equal(mixed.input_times[::2], shared[::2])
    if weight in (0.0, 1.0):
        assert np.array_equal(mixed.input_times, other if weight else one)


def test_blend_of_ends_a_rounding_error_apart_keeps_the_first_ends() -> None:
    one = Warp([0.0, 1.0, 2.0], [0.0, 0.5, 2.0])
    other = Warp([1e-12, 1.0, 2.0 - 1e-12], [0.0, 1.5, 2.0])
    for a, b in ((one, other), (other, one)):
        mixed = blend(a, b, 0.25)
        assert np.array_equal(mixed.output_times, a.output_times)
        assert mixed.input_times[[0, -1]].tolist() == [0.0, 2.0]


@pytest.mark.parametrize("weight", [-0.1, 1.1, float("nan")])
def test_a_weight_beyond_0_to_1_is_refused(weight: float) -> None:
    warp = Warp([0, 1], [0, 1])
    with pytest.raises(OptionError, match="from 0 to 1"):
        blend(warp, warp, weight)


def test_warps_of_different_ranges_are_not_mixed() -> None:
    with pytest.raises(OptionError, match="same output range"):
        blend(Warp([0, 1], [0, 1]), Warp([0, 1.1], [0, 1]), 0.5)
