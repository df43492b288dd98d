"""Baselines: silence cut out, splines keyed by hand, and timing carried over by alignment."""

from __future__ import annotations

import numpy as np
import pytest

from retime.errors import InfeasibleWarpError
from retime.evaluate.metrics.flights import flight_spans, flight_timing
from retime.evaluate.metrics.known_answer import match_warps
from retime.warp.curve import Warp
from study.answers.by_hand import slow_flights
from study.baselines.aligned import align, align_warp
from study.baselines.cut import cut_idle
from study.baselines.keyed import keyed_spline, spans_to_keep, spline_through
from study.clips.library import read_sample
from tests.evaluate.figures import jumper

SAMPLE = read_sample()


def test_cutting_keeps_what_moves() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    warp = cut_idle(motion, motion.n_frames - 40)
    ((start, end),) = flight_spans(motion)
    assert flight_timing(warp, [(start, end)]).n_kept == flight_timing(warp, [(start, end)]).n_frames
    assert (warp.input_times[0], warp.input_times[-1]) == (0.0, motion.end_time)
    assert warp.output_span == pytest.approx((motion.n_frames - 41) / 60)
    with pytest.raises(InfeasibleWarpError, match="asked for 1000"):
        cut_idle(motion, 1000)


def test_a_keyed_spline_keeps_the_duration_of_what_it_is_keyed_for() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    keep = spans_to_keep(motion, [(1.1, 1.4)])
    warp = keyed_spline(motion, keep, 1.8)
    back = warp.inverse()
    assert float(back(keep[0][1]) - back(keep[0][0])) == pytest.approx(0.5)
    assert warp.output_end == pytest.approx(1.8)
    with pytest.raises(InfeasibleWarpError, match="to be kept"):
        keyed_spline(motion, keep, 0.4)


def test_a_keyed_spline_may_play_what_it_is_keyed_for_at_another_speed() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    warp = keyed_spline(motion, [(1.0, 1.5)], 3.0, speed=0.5)
    back = warp.inverse()
    assert float(back(1.5) - back(1.0)) == pytest.approx(1.0)
    assert warp.output_end == pytest.approx(3.0)


def test_a_spline_through_a_known_answer_meets_it_where_it_is_keyed() -> None:
    truth = slow_flights(SAMPLE)
    warp = spline_through(truth, [0.0, 3.0, 6.0, 99.0], rate=60.0)
    assert [key.input_time for key in warp.keytimes] == [0.0, 3.0, 6.0, SAMPLE.end_time]
    assert warp.inverse()(6.0) == pytest.approx(float(truth.inverse()(6.0)), abs=1e-6)
    assert warp.output_end == pytest.approx(truth.output_end)


def test_stretches_that_meet_are_one() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    assert spans_to_keep(motion, [(0.05, 0.5), (0.65, 0.9)], margin=0.1) == ((0.0, pytest.approx(1.0)),)


def every_path(n: int, m: int) -> list[list[tuple[int, int]]]:
    """List all alignments of n frames with m by walking all of them."""
    found: list[list[tuple[int, int]]] = []
    walks = [[(0, 0)]]
    while walks:
        walk = walks.pop()
        i, j = walk[-1]
        if (i, j) == (n - 1, m - 1):
            found.append(walk)
        for a, b in ((1, 0), (0, 1), (1, 1)):
            if i + a < n and j + b < m:
                walks.append([*walk, (i + a, j + b)])
    return found


@pytest.mark.parametrize("seed", range(6))
def test_an_alignment_is_the_best_of_all(seed: int) -> None:
    generator = np.random.default_rng(seed)
    here, there = generator.normal(size=(5, 2)), generator.normal(size=(4, 2))

    def cost(path: list[tuple[int, int]]) -> float:
        return sum(float(np.linalg.norm(here[i] - there[j])) for i, j in path)

    best = min(map(cost, every_path(5, 4)))
    assert cost([(int(i), int(j)) for i, j in align(here, there)]) == pytest.approx(best)


def test_an_alignment_may_begin_and_end_anywhere_in_the_other() -> None:
    there = np.array([[9.0], [1.0], [2.0], [9.0]])
    assert align(np.array([[1.0], [2.0]]), there, anywhere=True).tolist() == [[0, 1], [1, 2]]


def test_aligned_with_itself_a_motion_keeps_its_timing() -> None:
    found = align_warp(SAMPLE, SAMPLE)
    assert match_warps(found, Warp([0.0, SAMPLE.end_time], [0.0, SAMPLE.end_time])).largest_error < 1.0
