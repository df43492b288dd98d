"""Hands on one stretch, and the measure of what comes back: on the sample, and on warps whose recovery is known."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from retime.warp.curve import Warp
from retime.warp.spline import linear_warp
from study.answers.by_hand import from_log_speed
from study.clips.library import Library, read_sample
from study.clips.walks import cycles
from study.propagation.cases import KINDS, Case, _jump, _rest, _steps, _strides, halves, limp, strengthen
from study.propagation.measure import LENGTHS, WAYS, Propagated, propagate_all, recovery
from study.tables.propagation import propagation_table

SAMPLE = read_sample()


@pytest.fixture(scope="module")
def stride() -> Case:
    return next(_strides("a stride", SAMPLE, 1.7))


def _weaker(case: Case, share: float) -> Warp:
    """The answer, with its log-speeds times a share."""
    logs = np.log(np.append(case.truth.slopes, case.truth.slopes[-1]))
    return from_log_speed(share * logs, case.motion)


def test_recovery_is_the_share_of_the_answer_that_is_there(stride: Case) -> None:
    assert recovery(stride.truth, stride) == pytest.approx(1.0)
    assert recovery(_weaker(stride, 0.5), stride) == pytest.approx(0.5, abs=0.03)
    assert recovery(_weaker(stride, -1.0), stride) == pytest.approx(-1.0, abs=0.06)
    end = SAMPLE.end_time
    # One speed for all says nothing of left and right, however slow it is.
    assert recovery(linear_warp([(0, 0), (end, 2 * end)]), stride) == pytest.approx(0.0, abs=1e-9)


def test_what_the_hand_did_itself_does_not_count(stride: Case) -> None:
    # A warp that is right within the example and nowhere else.
    times = stride.example_times
    assert times is not None
    seconds = np.arange(SAMPLE.n_frames) / float(SAMPLE.rate)
    logs = np.log(np.append(stride.truth.slopes, stride.truth.slopes[-1]))
    inside = (seconds >= times[0]) & (seconds < times[1])
    assert recovery(from_log_speed(np.where(inside, logs, 0.0), SAMPLE), stride) == pytest.approx(0.0, abs=0.03)
    # For another clip all of it counts.
    elsewhere = replace(stride, example_clip=replace(SAMPLE, name="another"))
    assert elsewhere.example_times is None
    assert recovery(from_log_speed(np.where(inside, logs, 0.0), SAMPLE), elsewhere) > 0.1


def test_one_step_leaves_the_other_foot_alone() -> None:
    case = next(_steps("one step", SAMPLE))
    assert case.truth.slopes.min() == pytest.approx(1.0)
    assert case.truth.slopes.max() == pytest.approx(1.7, rel=0.01)
    first, last = case.example
    step = next(a for a, b in cycles(SAMPLE) if a.side == "left")
    assert first / float(SAMPLE.rate) == pytest.approx(step.time, abs=0.01)
    assert case.hand.input_times[-1] == pytest.approx((last - first) / float(SAMPLE.rate))


def test_a_limp_goes_one_way_for_each_foot() -> None:
    warp = limp(SAMPLE, strength=1.5, both=True)
    for start, end, side in halves(SAMPLE):
        middle = (start + end) / 2
        if 0 < middle < SAMPLE.end_time:
            speed = float(warp.speed(np.interp(middle, warp.input_times, warp.output_times)))
            assert math.log(speed) == pytest.approx(math.log(1.5) * (1 if side == "left" else -1), abs=0.03)


def test_blows_are_strengthened_between_bounds() -> None:
    arms = {"LeftHand": "LeftWrist", "RightHand": "RightWrist"}
    skeleton = replace(SAMPLE.skeleton, names=tuple(arms.get(name, name) for name in SAMPLE.skeleton.names))
    warp = strengthen(replace(SAMPLE, skeleton=skeleton))
    assert warp.slopes.min() >= 0.6 - 1e-9
    assert warp.slopes.max() <= 1.8 + 1e-9
    assert warp.slopes.max() > 1.3


def test_the_rest_lies_between_stretches() -> None:
    assert _rest(((1.0, 2.0), (3.0, 4.0)), SAMPLE, 0.25) == ((0.0, 0.75), (2.25, 2.75), (4.25, SAMPLE.end_time))


def test_a_jumps_example_is_one_flight_with_what_is_around_it() -> None:
    case = _jump("jumps", SAMPLE, None)
    assert case.hand.slopes.min() == pytest.approx(0.5, rel=0.02)
    assert len(case.changed) == 2


def test_the_hands_speed_brings_the_samples_limp_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(KINDS, "a stride", lambda clips, kind: _strides(kind, clips["sample"], 1.7))
    found = list(propagate_all(Library(Path("unused")), kinds=("a stride",)))
    assert {(one.way, one.length) for one in found} == {(way, length) for way in WAYS for length in LENGTHS}
    for one in found:
        if one.way == "the hand's speed":
            assert one.recovery > 0.85
            assert one.length_ratio == pytest.approx(1.0, abs=0.1 if one.length == "free" else 0.001)
            assert one.share is not None
    table = propagation_table(found)
    assert [row[2] for row in table.rows] == list(WAYS)
    assert table.marked == frozenset({2})


def test_the_table_tells_the_mean_and_the_worst() -> None:
    found = [
        Propagated("kind", "clip", "0..1", way, length, value, ratio, 0.5 if way == "the hand's speed" else None)
        for way in WAYS
        for length in LENGTHS
        for value, ratio in ((0.8, 0.9), (1.0, 1.1), (math.nan, 1.0))
    ]
    table = propagation_table(found)
    assert table.rows[0] == ("kind", "3", "the paper's", "0.90 (0.80)", "0.90 (0.80)", "0.90–1.10", "–")
    assert table.rows[2][-1] == "50 %"
