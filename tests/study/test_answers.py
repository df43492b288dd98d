"""Known answers: warps by hand, and what the methods make of them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from retime.evaluate.metrics.flights import flight_spans
from retime.warp.curve import Warp
from study.answers.by_hand import example_of, from_log_speed, limp, part_of, slow_flights
from study.answers.methods import answer_all
from study.clips.library import Library, read_sample
from study.clips.walks import walking_spans
from study.defaults import DEFAULTS

SAMPLE = read_sample()


def test_a_part_of_a_warp_does_what_the_whole_does() -> None:
    whole = Warp([0.0, 1.0, 3.0, 4.0], [0.0, 2.0, 3.0, 4.0])
    part = part_of(whole, 1.0, 3.5)
    assert (part.input_times[0], part.input_times[-1]) == (0.0, 2.5)
    times = np.linspace(0.0, part.output_end, 50)
    assert part(times) == pytest.approx(whole(times + 0.5) - 1.0)


def test_a_log_speed_is_played_as_such() -> None:
    warp = from_log_speed(np.full(SAMPLE.n_frames, math.log(2.0)), SAMPLE)
    assert warp.output_span == pytest.approx(SAMPLE.end_time / 2)


def test_slowed_flights_play_at_half_speed_and_the_rest_as_it_was() -> None:
    warp = slow_flights(SAMPLE)
    spans = flight_spans(SAMPLE)
    assert len(spans) == 2
    for start, end in spans:
        inside = warp.inverse()(np.array([start + 0.02, end - 0.02]))
        assert (end - start - 0.04) / (inside[1] - inside[0]) == pytest.approx(0.5, rel=1e-3)
    assert warp.slopes[:30] == pytest.approx(np.ones(30))


def test_a_limp_hurries_one_step_and_lingers_over_the_next() -> None:
    warp = limp(SAMPLE)
    start, end = walking_spans(SAMPLE)[0]
    inside = warp.slopes[(warp.input_times[:-1] > start) & (warp.input_times[1:] < end)]
    assert inside.max() == pytest.approx(1.7, rel=0.02)
    assert inside.min() == pytest.approx(1 / 1.7, rel=0.02)


def test_an_example_is_the_stretch_with_the_answers_timing() -> None:
    truth = slow_flights(SAMPLE)
    start, end = flight_spans(SAMPLE)[0]
    stretch = example_of(SAMPLE, truth, start, end)
    assert stretch.end_time == pytest.approx(2 * (end - start), rel=0.02)


def test_the_sample_has_known_answers_that_the_method_finds() -> None:
    (found,) = answer_all(Library(Path("unused")), DEFAULTS, names=["sample, jump"])
    guided, aligned = found.attempt("guided, free"), found.attempt("aligned")
    assert guided is not None
    assert aligned is not None
    assert guided.inside.correlation > 0.85
    assert guided.inside.mean_error < found.attempts[0].inside.mean_error
    assert guided.inside.correlation > aligned.inside.correlation


def test_the_hands_speed_comes_nearer_than_being_guided_by_the_example() -> None:
    (found,) = answer_all(Library(Path("unused")), DEFAULTS, names=["sample, jump"])
    guided, imitated = found.attempt("guided, free"), found.attempt("imitate()")
    assert guided is not None
    assert imitated is not None
    assert imitated.inside.correlation > max(0.95, guided.inside.correlation)
    assert imitated.inside.length_ratio == pytest.approx(1.0, abs=0.02)
