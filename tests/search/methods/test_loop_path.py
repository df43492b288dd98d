"""The best loop: against every path of every first step, and in few searches."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from retime.errors import InfeasibleWarpError
from retime.kernels import StepPairs
from retime.search.methods.exact import PathTask
from retime.search.methods.loop import loop_path
from retime.search.path import FramePath
from tests.reference import paths


class Problem:
    """A random one: scores that tie or don't, forbidden triples and ends, keytimes inside, a length or a range."""

    def __init__(self, seed: int, *, most_input: int = 13, most_step: int = 6) -> None:
        rng = np.random.default_rng(seed)
        longest = int(rng.integers(1, most_step + 1))
        drawn = sorted({1, *rng.integers(1, longest + 1, longest).tolist()})
        ratio = float(rng.choice([1.5, 2, 3, np.inf]))
        self.steps, self.following = StepPairs.of(drawn, ratio), paths.follows(drawn, ratio)
        n_input = int(rng.integers(max(3, longest + 1), most_input + 1))
        self.scores = [
            rng.random((n_input, self.steps.n_pairs)),
            rng.integers(0, 3, (n_input, self.steps.n_pairs)) / 2,
            np.zeros((n_input, self.steps.n_pairs)),
        ][rng.integers(3)]
        self.scores[rng.random(self.scores.shape) < rng.choice([0, 0.1, 0.3])] = np.inf
        self.first, self.last, self.seam = rng.choice([0.0, 0.25, 0.5], (3, self.steps.n_steps))
        self.seam[rng.random(self.steps.n_steps) < 0.1] = np.inf
        self.allowed = rng.random((n_input, self.steps.longest)) < rng.choice([1.0, 0.9])
        least = int(rng.integers(3, n_input + 1))
        self.lengths = range(least, min(n_input, least + int(rng.choice([0, 0, 3]))) + 1)
        self.anchors: dict[int, int] = {}
        if rng.random() < 0.5 and least > 3:
            position = int(rng.integers(1, least - 1))
            self.anchors[position] = int(rng.integers(position, n_input - 1))
        self.n_searches = 0

    def task(self) -> PathTask:
        end = len(self.scores) - 1
        fixed = len(self.lengths) == 1
        last = [(self.lengths[0] - 1, end)] if fixed else []
        plan: Any = SimpleNamespace(
            allowed=self.allowed,
            anchors=((0, 0), *sorted(self.anchors.items()), *last),
            n_output=self.lengths[0] if fixed else (self.lengths[0], self.lengths[-1]),
        )

        class Counting(PathTask):
            def through(task, *args: Any, **options: Any) -> FramePath:
                self.n_searches += 1
                return super().through(*args, **options)

        return Counting(plan, self.scores, self.steps, self.first, self.last)

    def ends(self) -> tuple[np.ndarray, np.ndarray]:
        """What the first and the last step cost, the seam with it, for each length up to the longest."""
        start, end = np.full((2, self.steps.longest), np.inf)
        for place, step in enumerate(self.steps.steps.tolist()):
            if self.allowed[0, step - 1]:
                start[step - 1] = self.first[place]
            if step < len(self.scores) and self.allowed[len(self.scores) - 1 - step, step - 1]:
                end[step - 1] = self.last[place] + self.seam[place]
        return start, end


def test_it_is_the_best_of_every_path_of_every_first_step() -> None:
    closed = 0
    for seed in range(1500):
        problem = Problem(seed)
        table = paths.spread(problem.scores, problem.following)
        start, end = problem.ends()
        wanted = paths.best_loop(table, problem.lengths, problem.anchors, start, end, problem.following)
        try:
            found = loop_path(problem.task(), problem.seam)
        except InfeasibleWarpError:
            assert wanted is None, seed
            continue
        assert wanted is not None, seed
        closed += 1
        assert tuple(found.frames.tolist()) == wanted[0], seed
        assert found.total == pytest.approx(wanted[1], rel=1e-12, abs=1e-12), seed
        assert found.lower_bound <= found.total, seed
    # Most of them that have none would say little.
    assert closed > 400


@pytest.mark.parametrize("still", [False, True])
def test_many_first_steps_take_few_searches(still: bool) -> None:
    n_input, n_output = 400, 130
    steps = StepPairs.of(list(range(1, 25)), 2.0)
    problem = Problem(1)
    rng = np.random.default_rng(5)
    problem.steps, problem.lengths, problem.anchors = steps, range(n_output, n_output + 1), {60: 170}
    problem.scores = np.full((n_input, steps.n_pairs), 0.5) if still else rng.random((n_input, steps.n_pairs))
    problem.first, problem.last, problem.seam = np.zeros((3, steps.n_steps))
    problem.allowed = np.ones((n_input, steps.longest), dtype=bool)
    found = loop_path(problem.task(), problem.seam)
    assert problem.n_searches <= 12
    # Each first step on its own.
    task, totals = problem.task(), []
    for step in range(steps.n_steps):
        only = np.full(steps.n_steps, np.inf)
        only[step] = 0.0
        totals.append(task.through(start_cost=only, end_cost=only).total)
    assert found.total == min(totals)
