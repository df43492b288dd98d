"""Knots that differ by rounding alone are one."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from retime.warp.blend import blend
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime
from retime.warp.knots import add_times

NTSC = Fraction(24000, 1001)


def test_times_that_differ_by_rounding_make_no_knots() -> None:
    # At 23.976 Hz a frame's time and the same keytime differ in the last bit half of the time.
    frames = np.arange(300)
    as_frames = frames / float(NTSC)
    as_keys = np.array([float(frame / NTSC) for frame in frames.tolist()])
    assert (as_frames != as_keys).any()
    warp = Warp(
        as_keys,
        np.cumsum(1 + np.sin(frames / 9) / 2),
        tuple(Keytime(input_time=t, output_time=t) for t in as_keys[1:-1:7].tolist()),
    )
    for result in (
        warp.smooth(0.3, at=as_frames),
        warp.compose(Warp(as_frames[[0, 150, -1]], as_frames[[0, 150, -1]])),
        blend(warp, Warp(as_frames, warp.input_times), 0.5),
    ):
        assert np.diff(result.output_times).min() > 0.9 / float(NTSC)
        assert result.monotone


def test_add_times_keeps_the_old_ones() -> None:
    times = np.array([0.0, 1.0, 2.0])
    more = np.array([1 + 1e-12, 0.5, 0.5 + 1e-13, -1.0, 3.0, 2 - 1e-12])
    assert add_times(times, more).tolist() == [-1.0, 0.0, 0.5, 1.0, 2.0, 3.0]
    assert add_times(times, np.empty(0)).tolist() == times.tolist()
