"""Loops, free lengths and the heuristic of a session, against every path there is."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest

from retime.motion.signal import Signal
from retime.search.score import triple_scores
from retime.search.session import Session
from retime.search.wishes.locks import Lock

MAX_SKIP = 3


def _cycle(n_frames: int, seed: int) -> Signal:
    """Make a closed curve with an uneven pace."""
    rng = np.random.default_rng(seed)
    angle = np.linspace(0, 2 * np.pi, n_frames) + 0.2 * np.sin(np.linspace(0, 2 * np.pi, n_frames) * rng.integers(1, 4))
    return Signal(("x", "y"), np.stack([np.cos(angle), np.sin(angle) + 0.1 * np.cos(3 * angle)], axis=1), Fraction(30))


def _steps(n_input: int, n_output: int) -> list[tuple[int, ...]]:
    choices = itertools.product(range(1, MAX_SKIP + 1), repeat=n_output - 1)
    return [steps for steps in choices if sum(steps) == n_input - 1]


def _total(scores: np.ndarray, steps: tuple[int, ...]) -> float:
    frames = np.cumsum([0, *steps])
    return float(sum(scores[j, a - 1, b - 1] for j, a, b in zip(frames[1:-1], steps[:-1], steps[1:], strict=True)))


@pytest.mark.parametrize("seed", range(4))
def test_a_loop_is_the_best_path_whose_first_and_last_step_agree_with_the_seam_scored(seed: int) -> None:
    clip = _cycle(13, seed)
    session = Session(clip, low_pass=0, n_neighbors=2)
    result = session.solve(length="8f", loop=True, max_skip=MAX_SKIP, upsample=1)
    poses = result.input_poses
    model = result.model
    scores = triple_scores(poses, model, max_skip=MAX_SKIP, n_neighbors=2)

    def seam(step: int) -> float:
        # The frame before the end, the end (which is the beginning), and the frame after the beginning.
        three = np.stack([poses[-1 - step], poses[0], poses[step]])
        return float(triple_scores(three, model, max_skip=1, n_neighbors=2)[1, 0, 0])

    closed = [steps for steps in _steps(13, 8) if steps[0] == steps[-1]]
    best = min(_total(scores, steps) + seam(steps[0]) for steps in closed)
    assert result.total == pytest.approx(best, rel=1e-12)
    taken = np.diff(result.path.frames)
    assert taken[0] == taken[-1]


@pytest.mark.parametrize("weight", ["sum", "neutral"])
def test_a_free_length_is_the_best_of_all_lengths(weight: str) -> None:
    clip = _cycle(10, 7)
    session = Session(clip, reference=_cycle(17, 8), low_pass=0, n_neighbors=2)
    result = session.solve(length="free", free_weight=weight, max_skip=MAX_SKIP, upsample=1)
    scores = triple_scores(result.input_poses, result.model, max_skip=MAX_SKIP, n_neighbors=2)
    if weight == "neutral":
        mean_steps = (np.arange(1, 4)[:, None] + np.arange(1, 4)[None, :]) / 2
        scores = scores * np.sqrt(mean_steps)
    best = min(_total(scores, steps) for n_output in range(4, 11) for steps in _steps(10, n_output))
    assert result.total == pytest.approx(best, rel=1e-12)


def test_the_heuristic_reports_what_it_gives_away() -> None:
    clip = _cycle(200, 3)
    session = Session(clip, low_pass=0)
    exact, heuristic = (session.solve(length="120f", search=search) for search in ("priced", "heuristic"))
    assert exact.excess is None
    assert heuristic.excess is not None
    assert heuristic.total >= exact.total
    assert heuristic.excess == pytest.approx((heuristic.total - exact.total) / exact.total, abs=1e-12)


def test_a_band_gives_away_less_than_keytimes_and_all_of_it_nothing() -> None:
    excess: dict[int | None, list[float]] = {None: [], 1: [], 3: [], 1000: []}
    for seed in range(4):
        session = Session(_cycle(240, seed), low_pass=0)
        for slack, found in excess.items():
            session.slack = slack
            result = session.solve(length="150f", search="heuristic", max_skip=6, upsample=1)
            assert result.excess is not None
            found.append(result.excess)
    assert all(excess[3][i] <= excess[1][i] + 1e-12 for i in range(4))
    assert all(excess[1][i] <= excess[None][i] + 1e-12 for i in range(4))
    assert sum(excess[3]) < sum(excess[None])
    assert max(excess[1000]) == pytest.approx(0.0, abs=1e-12)


def test_a_band_that_locks_leave_no_path_in_is_widened() -> None:
    clip = _cycle(200, 3)
    session = Session(clip, low_pass=0)
    session.slack = 0
    lock = Lock(1.0, 3.0, 0.5, 0.5)
    result = session.solve(length="200f", search="heuristic", locks=[lock])
    inside = (result.staircase.input_times[:-1] >= 1.0 - 1e-9) & (result.staircase.input_times[1:] <= 3.0 + 1e-9)
    assert np.allclose(result.staircase.slopes[inside], 0.5)
