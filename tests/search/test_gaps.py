"""The search never sees a hole."""

from __future__ import annotations

import numpy as np
import pytest

from retime.errors import OptionError, RetimeWarning
from retime.motion.signal import Signal
from retime.search.align import align
from retime.search.guided import guided_warp
from retime.search.imitate import imitate
from retime.search.poses.spaces import PoseOptions
from retime.warp.curve import Warp

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
    short, long = slow.copy(), slow.copy()
    short[50:54] = np.nan
    long[50:60] = np.nan
    long[90:130, 1] = np.nan
    whole, found = (align(clip(MOVING), clip(values)).warp(T) for values in (slow, short))
    assert np.abs(whole - found).max() < 0.1
    # Of a longer one a person is told, whichever of the two has it.
    with pytest.warns(
        RetimeWarning, match=r"^slow misses values for 1\.7 s \(seconds 1\.67\.\.2\.00, 3\.00\.\.4\.33\)"
    ):
        found = align(clip(MOVING), clip(long, name="slow")).warp(T)
    assert np.abs(whole - found).max() < 0.4
    with pytest.warns(RetimeWarning, match="^moving misses values"):
        align(clip(long, name="moving"), clip(MOVING))


def test_what_does_not_weigh_may_be_missing() -> None:
    holes = np.column_stack([MOVING, MOVING[:, 0]])
    holes[50:100, 3] = np.nan
    clips = [
        Signal(("x", "y", "z", "note"), values, 30, gaps="keep", kinds={"note": "label"}) for values in (holes, holes)
    ]
    assert align(*clips).path.total == pytest.approx(0.0, abs=1e-9)


# Imitation: a swing of which one second is played at half its speed.
SWING = np.column_stack([np.sin(2 * np.pi * T), np.cos(2 * np.pi * T), 0.1 * T])
SLOW = Warp([0.0, 2.0], [0.0, 1.0])


@pytest.mark.parametrize("wild", [0.0, 50.0])
def test_the_moments_of_a_gap_are_not_looked_up_in_the_example(wild: float) -> None:
    holes = SWING.copy()
    holes[100:130, 0] = np.nan
    # Beside what is missing anything may stand, far enough inside that no low-pass carries it out.
    holes[112:118, 1] += wild * np.hanning(6)
    with pytest.warns(RetimeWarning, match=r"^values of the clip are missing \(input seconds 3\.30\.\.4\.33\)"):
        found = imitate(clip(holes, kinds={"z": "label"}), (0, 31), SLOW, low_pass=0)
    assert found.example is not None
    lost = np.isinf(found.example.distances)
    assert np.flatnonzero(lost).tolist() == list(range(99, 131))
    # There the speed goes on as beside it, and the result says that nothing is known of it.
    assert np.exp(found.example.log_speeds[95:135]) == pytest.approx(0.5, abs=0.02)
    assert found.example.share == pytest.approx(1 - lost.mean())
    assert [(round(start, 2), round(end, 2)) for start, end in found.example.unspoken] == [(3.3, 4.33)]


def test_frames_of_an_example_that_are_lost_say_nothing() -> None:
    holes = SWING.copy()
    # Half of the swing is missing where the hand was, and there again later.
    holes[16:31, 0] = np.nan
    with pytest.warns(RetimeWarning, match="the example"):
        found = imitate(clip(holes, kinds={"z": "label"}), (0, 31), SLOW, low_pass=0)
    assert found.example is not None
    speeds = np.exp(found.example.log_speeds)
    # What the rest of the example shows is known. In the middle of the other half the example's ends are the nearest,
    # and far away: the speed turns back to the clip's own.
    assert speeds[62:73] == pytest.approx(0.5, abs=0.02)
    assert found.example.distances[62:73].max() < 0.1
    assert speeds[81:84].min() > 0.65
    assert found.example.distances[81:84].min() > 0.9
    lost = SWING.copy()
    lost[:32] = np.nan
    with pytest.raises(OptionError, match="no frame of the example is without gaps"):
        imitate(clip(lost), (0, 31), SLOW, example_clip=clip(lost))
