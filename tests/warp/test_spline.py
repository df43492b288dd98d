"""The baselines."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import InfeasibleWarpError
from retime.warp.curve import Keytime
from retime.warp.spline import linear_warp, spline_warp


def drawn_keys(seed: int, *, forward: bool) -> list[Keytime]:
    rng = np.random.default_rng(seed)
    n_keys = int(rng.integers(2, 8))
    output_times = np.cumsum(10.0 ** rng.uniform(-1.5, 0.5, n_keys)) - 1
    changes = 10.0 ** rng.uniform(-2, 1, n_keys)
    if not forward:
        changes *= rng.choice([-1, 0, 1, 1], n_keys)
    input_times = np.cumsum(changes)
    return [Keytime(o, i) for o, i in zip(output_times.tolist(), input_times.tolist(), strict=True)]


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.sampled_from([24000 / 1001, 30.0, 120.0]))
def test_both_meet_every_keytime_exactly_and_never_leave_its_neighbours(seed: int, forward: bool, rate: float) -> None:
    keys = drawn_keys(seed, forward=forward)
    shuffled = [keys[k] for k in np.random.default_rng(seed).permutation(len(keys))]
    for warp in (linear_warp(shuffled), spline_warp(shuffled, rate=rate)):
        assert warp.keytimes == tuple(keys)
        assert (warp.output_start, warp.output_end) == (keys[0].output_time, keys[-1].output_time)
        for key in keys:
            assert float(warp(key.output_time)) == key.input_time
        if forward:
            assert warp.monotone
            assert warp.smooth(0.2).monotone
        for before, after in itertools.pairwise(keys):
            inside = (warp.output_times >= before.output_time) & (warp.output_times <= after.output_time)
            moves = np.diff(warp.input_times[inside]) * np.sign(after.input_time - before.input_time)
            assert (moves >= 0).all()
            if before.input_time == after.input_time:
                assert (warp.input_times[inside] == before.input_time).all()


def test_linear_has_one_speed_a_span() -> None:
    warp = linear_warp([Keytime(0, 0), Keytime(1, 3), Keytime(3, 4)])
    assert warp.slopes.tolist() == [3.0, 0.5]
    assert warp.method == "linear"


def test_a_spline_through_two_keys_is_a_line() -> None:
    warp = spline_warp([Keytime(0, 1), Keytime(2, 5)], rate=30)
    np.testing.assert_allclose(warp.slopes, 2.0, rtol=1e-12)
    assert len(warp.output_times) == 61


def test_a_spline_changes_speed_without_a_jump() -> None:
    keys = [Keytime(0, 0), Keytime(1, 3), Keytime(3, 4), Keytime(4, 6)]
    jump = [np.abs(np.diff(spline_warp(keys, rate=rate).slopes)).max() for rate in (100.0, 200.0, 400.0)]
    assert jump[0] < 0.2
    # Halved with the distance of the knots: a corner would stay.
    assert jump[1] < 0.6 * jump[0]
    assert jump[2] < 0.6 * jump[1]


@pytest.mark.parametrize("make", [linear_warp, spline_warp])
def test_keytimes_that_make_no_warp_are_refused(make: object) -> None:
    with pytest.raises(InfeasibleWarpError, match="at least two"):
        make([Keytime(0, 0)])  # type: ignore[operator]
    with pytest.raises(InfeasibleWarpError, match="output time 1 s"):
        make([Keytime(0, 0), Keytime(1, 0), Keytime(1, 2)])  # type: ignore[operator]
