"""No search begins that its own estimate says won't fit; and no rate is taken that can't be."""

from __future__ import annotations

import time
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from retime.errors import OptionError, RetimeError, RetimeWarning
from retime.motion.signal import Signal
from retime.search.align import align
from retime.search.guided import guided_warp


def clip(seconds: float = 2.0, rate: Fraction | int = 30) -> Signal:
    t = np.arange(round(seconds * rate) + 1) / float(rate)
    return Signal(("x",), np.sin(3 * t**1.2)[:, None], Fraction(rate), name="walk")


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"length": "1000000s"}, "shorter output"),
        ({"keys": [(1.0, 100000.0)]}, r"shorter output.*|at most"),
        ({"keys": [(1.0, 1e99)]}, "no output is longer"),
        ({"keys": [(1.0, 1.7e308)]}, r"expected a time .*, found '1\.7e\+308'"),
        ({"keys": [(1.0, 5e-324)]}, "two keytimes stand at output time"),
        ({"rate": 100000}, "sees no more of a clip at 30 Hz than one at 240 Hz"),
        ({"keys": [(1.0, 1.0, 1e9)], "upsample": 8}, "speed"),
        ({"smoothness": 1e308}, r"from 0 to 1e\+06"),
        ({"influence": []}, "one or more rows"),
    ],
)
def test_what_would_take_for_ever_is_refused_at_once(asked: dict[str, Any], words: str) -> None:
    begun = time.process_time()
    with pytest.raises(RetimeError, match=words) as caught:
        guided_warp(clip(), **asked)
    assert time.process_time() - begun < 3
    assert "nan" not in str(caught.value)


@pytest.mark.parametrize(("speed", "length"), [((1e-9, 2.0), "80%"), ("0.000000001..2", "80%"), ((1e-300, 1.0), None)])
def test_limits_far_beyond_what_is_played_cost_nothing(speed: Any, length: str | None) -> None:
    begun = time.process_time()
    assert guided_warp(clip(), length=length, speed=speed).upsample <= 24
    assert time.process_time() - begun < 3


def test_a_limit_faster_than_any_step_is_refused() -> None:
    with pytest.raises(OptionError, match="can't play speeds from"):
        guided_warp(clip(), length="80%", speed=(0.25, 1.7e308))


def test_limits_are_moved_by_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    assert guided_warp(clip(), length="50%").n_output == 30
    monkeypatch.setenv("RETIME_MOST_MEMORY", "0.00001")
    with pytest.raises(OptionError, match=r"GB of memory; the limit is 1e-05 GB \(RETIME_MOST_MEMORY=GB"):
        guided_warp(clip(), length="50%")
    monkeypatch.setenv("RETIME_MOST_MEMORY", "none")
    monkeypatch.setenv("RETIME_MOST_SECONDS", "0.000001")
    with pytest.raises(OptionError, match=r"the limit is 1e-06 seconds \(RETIME_MOST_SECONDS=SECONDS"):
        guided_warp(clip(), length="50%")


def test_the_memory_of_keeping_in_step_is_estimated_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """A narrow clock and wide speed limits: 171 steps, and so 30,000 pairs of them, for each of 1,761 frames."""
    wave = np.sin(np.arange(177) / 9)[:, None]
    asked: dict[str, Any] = {"speed": (0.1, 17.1), "upsample": 10, "rate": 24}
    monkeypatch.setenv("RETIME_MOST_MEMORY", "0.5")
    with pytest.raises(OptionError, match=r"in step with 2\d frames of reference would take about 0\.\d+ GB of memory"):
        align(wave, wave[:29], **asked)
    assert align(wave, wave[:29], **(asked | {"upsample": 2, "speed": (0.5, 8)})).path.optimal


def test_a_loop_through_many_steps_counts_each_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RETIME_MOST_SECONDS", "3")
    asked: dict[str, Any] = {"length": "65%", "upsample": 24}
    assert guided_warp(clip(4.0), **{**asked, "upsample": 2}, loop=True).path.optimal
    with pytest.raises(OptionError, match="would take about"):
        guided_warp(clip(8.0), **asked, loop=True)


def test_times_in_milliseconds_are_warned_of_and_refused_before_anything_is_computed() -> None:
    motion = clip(300 * 33.333, Fraction(1000, 33333))
    begun = time.process_time()
    with (
        pytest.warns(RetimeWarning, match="walk has 0.03 frames a second.* in milliseconds"),
        pytest.raises(OptionError, match=r"would take about .* minutes|GB of memory"),
    ):
        guided_warp(motion, length="70%")
    assert time.process_time() - begun < 5
