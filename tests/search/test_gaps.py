"""The search never sees a hole."""

from __future__ import annotations

import numpy as np
import pytest

from retime.errors import OptionError
from retime.motion.signal import Signal
from retime.search.align import align
from retime.search.guided import guided_warp
from retime.search.poses.spaces import PoseOptions

T = np.arange(240) / 30
MOVING = np.column_stack([np.sin(1.7 * T), np.cos(2.3 * T), np.sin(0.9 * T + 1) * T])


def clip(values: np.ndarray, **changes) -> Signal:
    return Signal(("x", "y", "z"), values, 30, gaps="keep", **changes)


@pytest.mark.parametrize(
    ("length", "search", "prices"),
    [
        ("70%", "priced", {}),
        ("free", "priced", {}),
        ("80%", "heuristic", {}),
        ("70%", "priced", {"own_timing": 0.5}),
        ("70%", "priced", {"content": 4.0}),
    ],
)
def test_nothing_of_a_frame_with_a_hole_weighs(length: str, search: str, prices: dict[str, float]) -> None:
    holes = MOVING.copy()
    holes[60:90, 0] = np.nan
    others = holes.copy()
    # Far enough inside that no step from outside reaches it.
    others[72:78, 1] += 50 * np.hanning(6)
    options = {
        "length": length,
        "low_pass": 0,
        "search": search,
        "max_skip": 4,
        "upsample": 1,
        **prices,
    }
    unscaled = PoseOptions(scale_signals=False)
    found, again = (guided_warp(clip(values), features=unscaled, **options) for values in (holes, others))
    assert found.path.frames.tolist() == again.path.frames.tolist()
    assert found.path.total == pytest.approx(again.path.total, rel=1e-12)
    assert np.isfinite(found.path.total)
    # Without the hole it would weigh.
    there = MOVING.copy()
    there[72:78, 1] = others[72:78, 1]
    assert guided_warp(clip(there), features=unscaled, **options).path.frames.tolist() != found.path.frames.tolist()


def test_no_frame_of_a_gap_is_dwelt_on() -> None:
    holes = MOVING.copy()
    holes[60:90] = np.nan
    warp = guided_warp(clip(holes), length="130%").warp
    inside = warp.inverse()(90 / 30) - warp.inverse()(60 / 30)
    # A gap is slowed like the rest, not stretched because it costs nothing.
    assert 0.6 < inside < 2.0
    shown = guided_warp(clip(holes), length="130%").apply()
    assert np.isnan(shown.values).any(axis=1).sum() == pytest.approx(inside * 30, abs=3)


def test_frames_of_a_reference_that_are_lost_are_matched_by_none() -> None:
    holes = MOVING.copy()
    holes[100:140, 2] = np.nan
    found = guided_warp(clip(MOVING), reference=clip(holes), length="80%")
    assert not np.isin(found.model.frame, np.arange(99, 141)).any()
    assert len(found.model.frame) > 100
    lost = np.full_like(MOVING, np.nan)
    lost[:2] = MOVING[:2]
    lost[-2:] = MOVING[-2:]
    with pytest.raises(OptionError, match="too few frames of the reference are without gaps"):
        guided_warp(clip(MOVING), reference=clip(lost), length="80%")


def test_a_channel_that_is_empty_is_refused() -> None:
    lost = MOVING.copy()
    lost[:, 1] = np.nan
    with pytest.raises(OptionError, match="channel 'y' of the signal has no value at all"):
        guided_warp(clip(lost), length="80%")
    # Who leaves it out needs none of it.
    told = clip(lost, kinds={"y": "label"})
    assert np.isfinite(guided_warp(told, length="80%").path.total)


def test_two_clips_keep_step_across_gaps() -> None:
    slow = np.column_stack([np.interp(T * 0.8, T, column) for column in MOVING.T])
    holes = slow.copy()
    holes[50:60] = np.nan
    whole, found = (align(clip(MOVING), clip(values)).warp(T) for values in (slow, holes))
    assert np.abs(whole - found).max() < 0.2
