"""What of a warp's output shows some stretches of the input."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from retime.evaluate.metrics.spans import output_intervals
from retime.warp.curve import Warp

times = st.integers(0, 12).map(lambda n: n / 4)


@given(
    st.lists(times, min_size=2, max_size=8),
    times,
    times,
    st.lists(st.floats(0, 1), min_size=1, max_size=20),
)
def test_an_output_time_is_in_an_interval_where_its_input_time_is_between(
    inputs: list[float], a: float, b: float, shares: list[float]
) -> None:
    low, high = min(a, b), max(a, b)
    warp = Warp(np.arange(float(len(inputs))), np.array(inputs))
    intervals = output_intervals(warp, low, high)
    for earlier, later in itertools.pairwise(intervals):
        assert earlier[1] < later[0]
    for share in shares:
        output_time = share * warp.output_end
        input_time = float(warp(output_time))
        inside = any(start <= output_time <= stop for start, stop in intervals)
        if min(abs(input_time - low), abs(input_time - high)) > 1e-6:
            assert inside == (low < input_time < high)


def test_a_warp_that_comes_back_shows_a_flight_twice() -> None:
    there_and_back = Warp(np.array([0.0, 4.0, 8.0]), np.array([0.0, 4.0, 0.0]))
    assert output_intervals(there_and_back, 1.0, 2.0) == ((1.0, 2.0), (6.0, 7.0))


def test_a_hold_inside_a_flight_belongs_to_it_and_one_outside_does_not() -> None:
    warp = Warp(np.array([0.0, 1.0, 3.0, 4.0]), np.array([0.0, 1.0, 1.0, 2.0]))
    assert output_intervals(warp, 0.5, 1.5) == ((0.5, 3.5),)
    assert output_intervals(warp, 1.25, 1.5) == ((3.25, 3.5),)
