"""Figures of merit, on a jump whose figures are known."""

from __future__ import annotations

import math
from typing import Any

import pytest

from retime.evaluate.metrics.stillness import idle_spans
from retime.motion.motion import Motion
from study.baselines.steady import at_one_speed, untouched
from study.evaluations.versions import VersionMaker
from study.figures.registry import FIGURES
from study.figures.shown import Subject
from tests.evaluate.figures import jumper
from tests.motion.strides import strides


def linear(motion: Motion, speed: float) -> dict[str, Any]:
    """Measure a motion at one speed."""
    warp = at_one_speed(motion, motion.end_time / speed)
    return VersionMaker(Subject(motion, motion)).version("linear", "", warp).figures


JUMP = jumper(lead=1.0, rest=1.0)


def test_figures_are_those_of_the_warp_that_is_seen() -> None:
    figures = linear(JUMP, 1.25)
    assert list(figures) == [figure.name for figure in FIGURES]
    assert (figures["seconds"], figures["fastest"]) == pytest.approx((121 / 60, 1.25))
    assert (figures["flight_slowest"], figures["flight_fastest"]) == pytest.approx((1.25, 1.25))
    assert (figures["flight_frames_kept"], figures["keytimes_missed"]) == (0, 0.0)
    assert figures["gravity"] == pytest.approx(1.25**2, rel=0.05)
    assert figures["idle"] == pytest.approx(sum(end - start for start, end in idle_spans(JUMP)) / 1.25)


def test_a_flight_is_counted_on_the_path_and_its_speed_on_the_warp() -> None:
    show = VersionMaker(Subject(JUMP, JUMP))
    seen, path = at_one_speed(JUMP, 2.0), untouched(JUMP)
    figures = show.version("guided", "", seen, path=path).figures
    assert figures["flight_frames_kept"] == figures["flight_frames"] > 10
    assert figures["flight_slowest"] == pytest.approx(1.25)


def test_a_flight_of_too_few_frames_is_lost() -> None:
    assert linear(JUMP, 20.0)["gravity"] == math.inf


def test_what_does_not_apply_is_none() -> None:
    still = jumper(lead=1.0, rest=0.5, jump=False)
    show = VersionMaker(Subject(still, still, truth=untouched(still)))
    figures = show.version("linear", "", at_one_speed(still, 1.0)).figures
    none = {"flight_frames", "flight_frames_kept", "flight_slowest", "flight_fastest", "flights_leapt", "gravity"}
    none |= {"walk_low", "walk_high", "walk_fast", "walk_slow", "steps_spread", "speeds", "speeds_distance", "contrast"}
    assert {name for name, value in figures.items() if value is None} == none | {
        "speeds",
        "speeds_distance",
        "contrast",
    }
    assert figures["closeness"].length_ratio == pytest.approx(0.5)
    of_a_motion = {name for name, value in show.other("reference", "", still).figures.items() if value is not None}
    assert of_a_motion == {"seconds", "jerk", "distance"}


def test_walks_are_measured_by_the_warp_that_is_seen_and_what_is_skipped_by_the_path() -> None:
    walk, _ = strides(0.6)
    even = linear(walk, 2.0)
    assert (even["walk_low"], even["walk_high"], even["steps_spread"]) == pytest.approx((2.0, 2.0, 0.0))
    assert even["walk_fast"] > 2
    assert even["walk_slow"] == 0
    assert 0.1 < even["skipped"] < 20
    show = VersionMaker(Subject(walk, walk))
    assert show.version("guided", "", at_one_speed(walk, 2.0), path=untouched(walk)).figures["skipped"] == 0


def test_the_answer_is_not_compared_with_itself() -> None:
    truth = at_one_speed(JUMP, 2.0)
    show = VersionMaker(Subject(JUMP, JUMP, truth=truth))
    assert show.version("by hand", "", truth).figures["closeness"] is None
    assert show.version("as it was", "", untouched(JUMP)).figures["closeness"].length_ratio == pytest.approx(1.25)
