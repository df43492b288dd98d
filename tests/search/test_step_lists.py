"""Scores and paths of any list of steps: against enumeration, the literal twins, and the same among all steps."""

from __future__ import annotations

import numpy as np
import pytest

from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import Backend, StepPairs, backend, compiled, compiled_available
from retime.search.path import SEARCHES, FramePath, path_scores, shortest_path
from retime.search.score import SCORES, Model, build_model, triple_scores
from tests.reference import paths as literal
from tests.reference.scores import scores as literal_scores

FINE = StepPairs.of([1, 2, 3, 4, 5, 6, 8, 12, 16, 32], 2.05)


def random_steps(rng: np.random.Generator, longest: int) -> tuple[StepPairs, literal.Follows]:
    """Draw steps, often from 1 on, and how much neighbours may differ."""
    drawn = set(rng.integers(1, longest + 1, rng.integers(1, longest + 1)).tolist())
    steps = sorted(drawn | ({1} if rng.random() < 0.7 else set()))
    ratio = float(rng.choice([1, 1.5, 2, 2.05, 3, np.inf]))
    return StepPairs.of(steps, ratio), literal.follows(steps, ratio)


def random_scores(rng: np.random.Generator, n_input: int, pairs: StepPairs) -> np.ndarray:
    """Scores of several tempers; sums of small halves are exact, so that equal totals are equal."""
    shape = (n_input, pairs.n_pairs)
    scores = [
        lambda: rng.random(shape),
        lambda: rng.integers(0, 3, shape) * 0.5,
        lambda: rng.integers(-2, 3, shape) * 0.25,
        lambda: np.zeros(shape),
        lambda: np.ones(shape),
    ][rng.integers(5)]()
    if rng.random() < 0.3:
        scores[rng.random(shape) < 0.2] = np.inf
    if rng.random() < 0.3:
        # As a lock does: a stretch in which only some steps go on.
        first, last = sorted(rng.integers(0, n_input, 2).tolist())
        barred = rng.random(pairs.n_steps) < 0.4
        scores[first:last, barred[pairs.after]] = np.inf
    return np.asarray(scores)


def end_costs(rng: np.random.Generator, pairs: StepPairs) -> np.ndarray:
    costs = rng.integers(0, 3, (2, pairs.n_steps)) * 0.5
    costs[rng.random(costs.shape) < 0.15] = np.inf
    return costs


def by_length(costs: np.ndarray, pairs: StepPairs) -> np.ndarray:
    """Costs of all steps: those that are not in the list are forbidden."""
    table = np.full(pairs.longest, np.inf)
    table[pairs.steps - 1] = costs
    return table


def found_by(scores: np.ndarray, pairs: StepPairs, **asked: object) -> tuple[tuple[int, ...], float] | None:
    try:
        path = shortest_path(scores, steps=pairs, **asked)  # type: ignore[arg-type]
    except InfeasibleWarpError:
        return None
    check(path, scores, pairs)
    return tuple(path.frames.tolist()), path.total


def check(path: FramePath, scores: np.ndarray, pairs: StepPairs) -> None:
    taken = np.diff(path.frames)
    assert np.isin(taken, pairs.steps).all()
    assert (pairs.pair_of(taken[:-1], taken[1:]) >= 0).all()
    assert np.array_equal(path.scores, path_scores(scores, path.frames, pairs))
    assert path.optimal
    assert path.lower_bound <= path.total


@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("seed", range(6))
def test_paths_equal_enumeration(kernels: Backend, search: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    feasible = 0
    for _ in range(60):
        pairs, following = random_steps(rng, int(rng.integers(1, 7)))
        n_input = int(rng.integers(3, 11))
        scores = random_scores(rng, n_input, pairs)
        least = int(rng.integers(2, n_input + 1))
        most = min(n_input, least + int(rng.integers(0, 3)))
        start, end = end_costs(rng, pairs)
        anchors = {}
        for _ in range(rng.integers(0, 3)):
            if least > 2:
                anchors[int(rng.integers(1, least - 1))] = int(rng.integers(1, n_input - 1))
        wanted = literal.best_path(
            literal.spread(scores, following),
            range(least, most + 1),
            anchors,
            by_length(start, pairs),
            by_length(end, pairs),
            following,
        )
        feasible += wanted is not None
        for memory_limit in (1 << 30, 1):
            got = found_by(
                scores,
                pairs,
                n_output=(least, most),
                anchors=list(anchors.items()),
                start_cost=start,
                end_cost=end,
                search=search,
                use=kernels,
                memory_limit=memory_limit,
            )
            assert got == wanted
    assert feasible > 10


@pytest.mark.parametrize("seed", range(4))
def test_free_lengths_equal_enumeration(kernels: Backend, seed: int) -> None:
    rng = np.random.default_rng(50 + seed)
    feasible = 0
    for _ in range(60):
        pairs, following = random_steps(rng, int(rng.integers(1, 7)))
        n_input = int(rng.integers(2, 11))
        scores = random_scores(rng, n_input, pairs)
        start, end = end_costs(rng, pairs)
        through = sorted({int(frame) for frame in rng.integers(0, n_input, rng.integers(0, 3))})
        wanted = literal.best_free_path(
            literal.spread(scores, following), through, by_length(start, pairs), by_length(end, pairs), following
        )
        feasible += wanted is not None
        anchors = [(0, frame) for frame in through]
        got = found_by(scores, pairs, anchors=anchors, start_cost=start, end_cost=end, use=kernels)
        assert got == wanted
    assert feasible > 15


@pytest.mark.parametrize("seed", range(5))
def test_longer_paths_equal_the_recurrence(kernels: Backend, seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    for _ in range(12):
        pairs, following = random_steps(rng, int(rng.integers(2, 20)))
        if rng.random() < 0.3:
            pairs, following = FINE, literal.follows(FINE.steps.tolist(), 2.05)
        n_input = int(rng.integers(20, 90))
        scores = random_scores(rng, n_input, pairs)
        n_output = int(rng.integers(-(-(n_input - 1) // pairs.longest) + 1, n_input + 1))
        anchors = {n_output // 2: n_input // 2} if n_output > 4 and rng.random() < 0.5 else {}
        wanted = (
            literal.recurrence(literal.spread(scores, following), n_output, anchors, following)
            if n_output > 2
            else literal.best_path(literal.spread(scores, following), range(2, 3), {}, following=following)
        )
        for search in SEARCHES:
            got = found_by(scores, pairs, n_output=n_output, anchors=list(anchors.items()), search=search, use=kernels)
            assert got == (None if wanted is None or wanted[1] == np.inf else wanted)


@pytest.mark.parametrize("ratio", [2.05, np.inf])
def test_long_takes_agree_between_searches_and_with_all_steps(ratio: float) -> None:
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    rng = np.random.default_rng(7)
    pairs, following = StepPairs.of(FINE.steps, ratio), literal.follows(FINE.steps.tolist(), ratio)
    n_input = 1500
    wanted_step = np.repeat(rng.uniform(0, 2.5, n_input // 50 + 1), 50)[:n_input, None]
    logs = np.log(pairs.steps[pairs.after])
    scores = (logs - wanted_step) ** 2 + 0.01 * rng.random((n_input, pairs.n_pairs))
    spread = literal.spread(scores, following)
    only_listed = np.where(np.isin(np.arange(1, 33), pairs.steps), 0.0, np.inf)
    for n_output in (120, 400, 1000):
        for anchors in ([], [(n_output // 3, n_input // 2)]):
            priced, layered = (
                shortest_path(
                    scores, steps=pairs, n_output=n_output, anchors=anchors, search=search, use=backend("compiled")
                )
                for search in SEARCHES
            )
            assert priced.search == "priced"
            assert (priced.total, priced.frames.tolist()) == (layered.total, layered.frames.tolist())
            assert priced.total - 5e-3 * abs(priced.total) < priced.lower_bound <= priced.total
            dense = shortest_path(
                spread, n_output=n_output, anchors=anchors, start_cost=only_listed, end_cost=only_listed
            )
            assert (priced.total, priced.frames.tolist()) == (dense.total, dense.frames.tolist())


def test_all_steps_given_as_a_list_are_the_default(kernels: Backend) -> None:
    rng = np.random.default_rng(3)
    scores = rng.random((40, 5, 5))
    square = shortest_path(scores, n_output=20, use=kernels)
    listed = shortest_path(scores.reshape(40, -1), steps=StepPairs.up_to(5), n_output=20, use=kernels)
    assert (square.total, square.frames.tolist()) == (listed.total, listed.frames.tolist())


def model_and_poses(
    rng: np.random.Generator, n_input: int, n_reference: int, n_numbers: int
) -> tuple[Model, np.ndarray]:
    reference = np.cumsum(rng.standard_normal((n_reference, n_numbers)), axis=0)
    poses = np.cumsum(rng.standard_normal((n_input, n_numbers)), axis=0)
    poses[n_input // 3 : n_input // 2] = poses[n_input // 3]
    return build_model([reference], rate=30.0, time_scale=0.2), poses


@pytest.mark.parametrize("kind", SCORES)
@pytest.mark.parametrize("seed", range(6))
def test_scores_equal_eq_2(kernels: Backend, kind: str, seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    pairs, following = random_steps(rng, int(rng.integers(1, 8)))
    y, z = rng.standard_normal((11, 2)), rng.standard_normal((9, 2))
    model = build_model([z], rate=30.0, time_scale=0.1)
    table = triple_scores(y, model, steps=pairs, score=kind, use=kernels)
    wanted = literal_scores(kind, y, z, following=following, rate=30.0, time_scale=0.1, n_neighbors=3)
    assert table.shape == wanted.shape
    inside = np.isfinite(wanted)
    assert np.array_equal(np.isfinite(table), inside)
    np.testing.assert_allclose(table[inside], wanted[inside], rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("kind", SCORES)
@pytest.mark.parametrize("seed", range(6))
def test_scores_of_a_list_are_those_of_all_steps_to_the_last_bit(
    both: tuple[Backend, Backend], monkeypatch: pytest.MonkeyPatch, kind: str, seed: int
) -> None:
    in_cpp, in_numpy = both
    rng = np.random.default_rng(300 + seed)
    pairs = FINE if seed % 3 == 0 else random_steps(rng, 20)[0]
    n_input = int(rng.choice([1, 2, 30, 90, 150]))
    model, poses = model_and_poses(rng, n_input, int(rng.integers(8, 200)), int(rng.integers(1, 40)))
    every = triple_scores(poses, model, max_skip=pairs.longest, score=kind, use=in_cpp)
    wanted = every[:, pairs.steps[pairs.before] - 1, pairs.steps[pairs.after] - 1]
    assert np.array_equal(triple_scores(poses, model, steps=pairs, score=kind, use=in_numpy), wanted)
    for threads in ("1", "2"):
        monkeypatch.setenv("RETIME_THREADS", threads)
        assert np.array_equal(triple_scores(poses, model, steps=pairs, score=kind, use=in_cpp), wanted)


@pytest.mark.parametrize("pairs", [FINE, StepPairs.of([2, 3, 5, 9, 14, 20], 3), StepPairs.of([7])])
def test_bounds_change_no_score(pairs: StepPairs, monkeypatch: pytest.MonkeyPatch) -> None:
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    monkeypatch.setattr(compiled, "_MANY", 1)
    # The reference is longer than any chunk of it, and the input than a tile.
    model, poses = model_and_poses(np.random.default_rng(17), 200, 4500, 9)
    by_bounds = triple_scores(poses, model, steps=pairs, use=backend("compiled"))
    monkeypatch.setattr(compiled, "_MANY", 1 << 60)
    assert np.array_equal(by_bounds, triple_scores(poses, model, steps=pairs, use=backend("compiled")))


def test_weights_and_references_work_with_a_list(kernels: Backend) -> None:
    rng = np.random.default_rng(23)
    references = [rng.standard_normal((n, 4)) for n in (12, 20)]
    model = build_model(references, rate=30.0, time_scale=0.2, weights=[1.0, 3.0])
    poses = rng.standard_normal((25, 4))
    pairs = StepPairs.of([1, 2, 4, 7], 2)
    for kind in SCORES:
        every = triple_scores(poses, model, max_skip=7, score=kind, use=kernels)
        wanted = every[:, pairs.steps[pairs.before] - 1, pairs.steps[pairs.after] - 1]
        assert np.array_equal(triple_scores(poses, model, steps=pairs, score=kind, use=kernels), wanted)


def test_scores_of_another_shape_are_refused() -> None:
    with pytest.raises(OptionError, match=r"shape \(n_input >= 1, 44\), one for each pair of steps; found \(9, 100\)"):
        shortest_path(np.ones((9, 100)), steps=FINE, n_output=3)
    with pytest.raises(OptionError, match=r"start_cost must have shape \(10,\), one cost for each step; found \(32,\)"):
        shortest_path(np.ones((9, 44)), steps=FINE, n_output=3, start_cost=np.zeros(32))
    scores = np.ones((9, 44))
    scores[4, 43] = np.nan
    with pytest.raises(OptionError, match="frame 4 between a step of 32 and one of 32"):
        shortest_path(scores, steps=FINE, n_output=3)


def test_lengths_that_no_steps_add_up_to_are_refused() -> None:
    even = StepPairs.of([2, 4])
    with pytest.raises(InfeasibleWarpError, match="steps of 2 to 4 allow 4 to 6"):
        shortest_path(np.ones((11, 4)), steps=even, n_output=7)
    # Within these numbers, but the frames are an odd number apart.
    with pytest.raises(InfeasibleWarpError):
        shortest_path(np.ones((12, 4)), steps=even, n_output=5)
    assert shortest_path(np.ones((11, 4)), steps=even, n_output=6).frames.tolist() == [0, 2, 4, 6, 8, 10]


def test_scores_need_steps_or_a_longest_one() -> None:
    model, poses = model_and_poses(np.random.default_rng(1), 9, 9, 2)
    for asked in ({}, {"max_skip": 2, "steps": FINE}):
        with pytest.raises(OptionError, match="either max_skip or steps"):
            triple_scores(poses, model, **asked)
