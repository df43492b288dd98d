"""The path in step with a reference: against every path, the literal recurrence, and the same on every backend."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys

import numpy as np
import pytest

from retime.errors import InfeasibleWarpError
from retime.kernels import Backend, StepPairs, compiled, compiled_available
from retime.search.methods.align import aligned_path
from retime.search.path import FramePath
from retime.search.score import Model, build_model
from tests.reference import aligned as literal
from tests.reference import paths

RATE, TIME_SCALE = 30.0, 0.1


class Problem:
    """A random one: walks, numbers that tie, poses that stand still or are seen twice."""

    def __init__(self, seed: int, *, most_numbers: int = 40, most_output: int = 40, most_step: int = 12) -> None:
        rng = np.random.default_rng(seed)
        n_numbers = int(rng.integers(1, most_numbers + 1))
        n_output = int(rng.integers(3, most_output + 1))
        longest = int(rng.integers(1, most_step + 1))
        drawn = sorted({1, *rng.integers(1, longest + 1, longest).tolist()})
        ratio = float(rng.choice([1.5, 2, 3, np.inf]))
        self.pairs, self.following = StepPairs.of(drawn, ratio), paths.follows(drawn, ratio)
        # A length that some path has.
        path = [0, int(rng.choice(drawn))]
        while len(path) < n_output:
            path.append(path[-1] + int(rng.choice(self.following[path[-1] - path[-2]])))
        n_input = path[-1] + 1
        draw = [
            lambda n: rng.normal(size=(n, n_numbers)).cumsum(axis=0),
            lambda n: rng.integers(0, 2, (n, n_numbers)).astype(float),
            lambda n: np.zeros((n, n_numbers)),
            lambda n: np.repeat(rng.normal(size=(-(-n // 3), n_numbers)), 3, axis=0)[:n] + 1000,
        ][rng.integers(4)]
        self.poses, self.reference = draw(n_input), draw(n_output)
        if rng.random() < 0.3:
            # In step already, but for speed.
            self.reference = self.poses[path]
        self.prices = rng.choice([0.0, 0.5], (n_input, self.pairs.n_pairs))
        self.prices[rng.random(self.prices.shape) < rng.choice([0, 0.1])] = np.inf
        self.start, self.end = rng.choice([0.0, 0.25, np.inf], (2, self.pairs.n_steps), p=[0.6, 0.3, 0.1])
        places = sorted(rng.choice(np.arange(1, n_output - 1), int(rng.integers(0, 2)), replace=False).tolist())
        self.anchors = [(p, path[p]) for p in (0, *places, n_output - 1)]
        self.model: Model = build_model([self.reference], rate=RATE, time_scale=TIME_SCALE, n_neighbors=1)

    def solve(self, kernels: Backend | None = None, memory_limit: int = 1 << 27) -> FramePath | None:
        try:
            return aligned_path(
                self.poses,
                self.model,
                self.prices,
                steps=self.pairs,
                anchors=self.anchors,
                start_cost=self.start,
                end_cost=self.end,
                use=kernels,
                memory_limit=memory_limit,
            )
        except InfeasibleWarpError:
            return None

    def tables(self) -> dict[int, np.ndarray]:
        return literal.costs(self.poses, self.reference, self.prices, self.following, rate=RATE, time_scale=TIME_SCALE)

    @property
    def ends(self) -> tuple[dict[int, float], dict[int, float]]:
        return literal.by_step(self.start, self.following), literal.by_step(self.end, self.following)


@pytest.mark.parametrize("seed", range(40))
def test_no_path_there_is_costs_less(kernels: Backend, seed: int) -> None:
    problem = Problem(seed, most_numbers=3, most_output=6, most_step=4)
    n_input, n_output = len(problem.poses), len(problem.reference)
    tables, must = problem.tables(), dict(problem.anchors)
    totals = {
        path: literal.total(tables, path, *problem.ends)
        for path in literal.every_path(n_input, n_output, problem.following)
        if all(path[p] == j for p, j in must.items())
    }
    best = min(totals.values(), default=np.inf)
    assert literal.recurrence(tables, n_input, n_output, problem.following, must, *problem.ends) == best
    found = problem.solve(kernels)
    if best == np.inf:
        assert found is None
        return
    assert found is not None
    # Distances that are next to nothing cancel: what is left of their digits is that of the numbers.
    near = 1e-9 * max(1.0, float(np.abs(problem.poses).max()))
    assert found.total == pytest.approx(best, rel=1e-9, abs=near)
    assert totals[tuple(found.frames.tolist())] == pytest.approx(best, rel=1e-9, abs=near)
    ends = problem.start, problem.end
    taken = np.searchsorted(problem.pairs.steps, np.diff(found.frames))
    assert found.total == pytest.approx(ends[0][taken[0]] + found.scores.sum() + ends[1][taken[-1]], rel=1e-12)
    assert (found.optimal, found.lower_bound) == (True, found.total)


@pytest.mark.parametrize("seed", range(15))
def test_the_literal_recurrence_finds_the_same_total(kernels: Backend, seed: int) -> None:
    problem = Problem(1000 + seed, most_numbers=2, most_output=12, most_step=5)
    n_output = len(problem.reference)
    least = literal.recurrence(
        problem.tables(), len(problem.poses), n_output, problem.following, dict(problem.anchors), *problem.ends
    )
    found = problem.solve(kernels)
    if least == np.inf:
        assert found is None
        return
    assert found is not None
    near = 1e-9 * max(1.0, float(np.abs(problem.poses).max()))
    assert found.total == pytest.approx(least, rel=1e-9, abs=near)
    assert all(found.frames[p] == j for p, j in problem.anchors)
    steps = np.diff(found.frames)
    assert all(b in problem.following[a] for a, b in itertools.pairwise(steps.tolist()))


@pytest.mark.parametrize("seed", range(40))
def test_backends_blocks_and_bounded_memory_change_nothing(
    both: tuple[Backend, Backend], seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = Problem(2000 + seed)
    expected = problem.solve(both[0])
    # A trace of a few bytes is made again block by block; costs of one position at a time, or of three.
    answers = [problem.solve(both[0], memory_limit=0), problem.solve(both[1]), problem.solve(both[1], memory_limit=0)]
    size = problem.prices.size * 8
    for limit in (0, 3 * size, 3 * size - 1):
        monkeypatch.setattr(compiled, "_ALIGNED_COSTS", limit)
        answers += [problem.solve(both[0]), problem.solve(both[0], memory_limit=0)]
    for answer in answers:
        if expected is None:
            assert answer is None
        else:
            assert answer is not None
            assert (answer.total, answer.frames.tolist()) == (expected.total, expected.frames.tolist())


def test_what_a_path_was_taken_from_finds_it_again(kernels: Backend) -> None:
    rng = np.random.default_rng(5)
    poses = rng.normal(size=(200, 12)).cumsum(axis=0)
    steps = rng.choice([1, 2, 3], 90)
    path = np.concatenate([[0], np.cumsum(steps)])
    poses = poses[: path[-1] + 1]
    pairs = StepPairs.up_to(4)
    model = build_model([poses[path]], rate=30, time_scale=0.2, n_neighbors=1)
    found = aligned_path(
        poses,
        model,
        np.zeros((len(poses), pairs.n_pairs)),
        steps=pairs,
        anchors=[(0, 0), (90, int(path[-1]))],
        start_cost=np.zeros(4),
        end_cost=np.zeros(4),
        use=kernels,
    )
    assert found.frames.tolist() == path.tolist()
    assert found.total == 0.0


CHILD = """
import numpy as np
from retime.kernels import StepPairs
from retime.search.methods.align import aligned_path
from retime.search.score import build_model

rng = np.random.default_rng(11)
for n_numbers, pairs in ((7, StepPairs.up_to(8)), (93, StepPairs.of([1, 2, 3, 4, 6, 9], 2.05))):
    poses, reference = (rng.normal(size=(n, n_numbers)).cumsum(axis=0) for n in (180, 110))
    found = aligned_path(
        poses,
        build_model([reference], rate=30, time_scale=0.2, n_neighbors=1),
        np.zeros((180, pairs.n_pairs)),
        steps=pairs,
        anchors=[(0, 0), (109, 179)],
        start_cost=np.zeros(pairs.n_steps),
        end_cost=np.zeros(pairs.n_steps),
    )
    print(found.total.hex(), found.lower_bound.hex(), *found.frames)
"""


def test_every_level_gives_the_same_bits() -> None:
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    settings = [
        {"RETIME_THREADS": "1"},
        {"RETIME_THREADS": "2"},
        {"RETIME_SIMD": "avx2"},
        {"RETIME_SIMD": "plain"},
        {"RETIME_BACKEND": "numpy"},
    ]
    answers = {
        subprocess.run(
            [sys.executable, "-c", CHILD], env=os.environ | setting, capture_output=True, text=True, check=True
        ).stdout
        for setting in settings
    }
    assert len(answers) == 1
