"""Where moments of the input are shown."""

from __future__ import annotations

import numpy as np
import pytest

from retime.errors import OptionError
from retime.warp.curve import Warp
from retime.warp.moments import output_moments


@pytest.mark.parametrize("seed", range(20))
def test_each_moment_is_shown_first_there(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 9))
    warp = Warp(np.cumsum(rng.uniform(0.1, 1, count)), rng.uniform(0, 5, count).round(1))
    times = rng.uniform(warp.input_times.min(), warp.input_times.max(), 30)
    shown = output_moments(warp, times)
    np.testing.assert_allclose(warp(shown), times, atol=1e-9)
    # No earlier time shows it: until then the warp stays on one side of it.
    for moment, time in zip(shown, times, strict=True):
        before = warp(np.linspace(warp.output_start, moment, 400)[:-1])
        assert (before > time - 1e-9).all() or (before < time + 1e-9).all()


def test_what_lies_outside_goes_along() -> None:
    half = Warp([1.0, 2.0], [0.0, 2.0])
    np.testing.assert_allclose(output_moments(half, [[-1.0, 3.0], [0.0, 1.0]]), [[0.0, 3.0], [1.0, 1.5]])
    # The last input time is none of the ends: the nearest time stands for it.
    there_and_back = Warp([0.0, 1.0, 2.0], [1.0, 2.0, 0.5])
    assert output_moments(there_and_back, [5.0, 0.0]).tolist() == [1.0, 2.0]
    with pytest.raises(OptionError):
        output_moments(half, ["a"])


def test_a_hold_shows_it_at_once() -> None:
    assert output_moments(Warp([0.0, 1.0, 3.0, 4.0], [0.0, 1.0, 1.0, 2.0]), [1.0]).tolist() == [1.0]
