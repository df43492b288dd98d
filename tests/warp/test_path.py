"""The path search: against every path there is, the paper's recurrence literally, and itself on each backend."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import Backend, backend, compiled_available
from retime.warp.path import SEARCHES, FramePath, check_feasible, path_scores, shortest_path
from tests.reference import paths as literal

KERNELS = [backend("numpy"), *([backend("compiled")] if compiled_available() else [])]


def random_scores(rng: np.random.Generator, n_input: int, max_skip: int) -> np.ndarray:
    """Scores of several tempers; sums of small halves and quarters are exact, so that equal totals are equal."""
    shape = (n_input, max_skip, max_skip)
    scores = [
        lambda: rng.random(shape),
        lambda: rng.integers(0, 3, shape) * 0.5,
        lambda: rng.integers(0, 5, shape) * 0.25,
        lambda: np.zeros(shape),
        lambda: np.ones(shape),
        lambda: np.broadcast_to(rng.integers(0, 2, (n_input, 1, 1)) * 1.0, shape).copy(),
    ][rng.integers(6)]()
    if rng.random() < 0.3:
        scores[rng.random(shape) < 0.25] = np.inf
    return np.asarray(scores)


def found_by(scores: np.ndarray, **options: object) -> tuple[tuple[int, ...], float] | None:
    try:
        path = shortest_path(scores, **options)  # type: ignore[arg-type]
    except InfeasibleWarpError:
        return None
    check(path, scores, options)
    return tuple(path.frames.tolist()), path.total


def check(path: FramePath, scores: np.ndarray, options: dict[str, object]) -> None:
    """What holds of every path: ends, steps, the objective recomputed, the bound."""
    steps = np.diff(path.frames)
    assert path.frames[0] == 0
    assert path.frames[-1] == len(scores) - 1
    assert ((steps >= 1) & (steps <= scores.shape[1])).all()
    assert np.array_equal(path.scores, path_scores(scores, path.frames))
    assert path.total == literal.total(scores, path.frames, options.get("start_cost"), options.get("end_cost"))  # type: ignore[arg-type]
    assert path.optimal
    assert path.lower_bound <= path.total
    assert path.lower_bound >= path.total - max(1e-9, abs(path.total)), "a bound that says nothing"


@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("seed", range(5))
def test_small_problems_equal_enumeration(kernels: Backend, search: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    feasible = 0
    for _ in range(60):
        n_input, max_skip = int(rng.integers(2, 10)), int(rng.integers(1, 5))
        scores = random_scores(rng, n_input, max_skip)
        n_output = int(rng.integers(2, n_input + 1))
        anchors = {}
        for _ in range(rng.integers(0, 3)):
            if n_output > 2:
                anchors[int(rng.integers(1, n_output - 1))] = int(rng.integers(1, n_input - 1))
        wanted = literal.best_path(scores, range(n_output, n_output + 1), anchors)
        feasible += wanted is not None
        for memory_limit in (1 << 30, 1):
            got = found_by(
                scores,
                n_output=n_output,
                anchors=list(anchors.items()),
                search=search,
                use=kernels,
                memory_limit=memory_limit,
            )
            assert got == wanted
    assert feasible > 20


@pytest.mark.parametrize("search", SEARCHES)
@pytest.mark.parametrize("seed", range(4))
def test_ranges_and_costs_at_the_ends_equal_enumeration(kernels: Backend, search: str, seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    feasible = 0
    for _ in range(60):
        n_input, max_skip = int(rng.integers(3, 10)), int(rng.integers(1, 5))
        scores = random_scores(rng, n_input, max_skip)
        least = int(rng.integers(2, n_input + 1))
        most = min(n_input, least + int(rng.integers(0, 4)))
        start_cost, end_cost = rng.integers(0, 3, max_skip) * 0.5, rng.integers(0, 3, max_skip) * 0.5
        start_cost[rng.random(max_skip) < 0.2] = np.inf
        end_cost[rng.random(max_skip) < 0.2] = np.inf
        anchors = {1: int(rng.integers(1, n_input - 1))} if least > 2 and rng.random() < 0.4 else {}
        wanted = literal.best_path(scores, range(least, most + 1), anchors, start_cost, end_cost)
        feasible += wanted is not None
        for memory_limit in (1 << 30, 1):
            got = found_by(
                scores,
                n_output=(least, most),
                anchors=list(anchors.items()),
                start_cost=start_cost,
                end_cost=end_cost,
                search=search,
                use=kernels,
                memory_limit=memory_limit,
            )
            assert got == wanted
    assert feasible > 20


@pytest.mark.parametrize("seed", range(4))
def test_free_length_equals_enumeration(kernels: Backend, seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    for _ in range(60):
        n_input, max_skip = int(rng.integers(2, 10)), int(rng.integers(1, 5))
        scores = random_scores(rng, n_input, max_skip)
        through = sorted({int(frame) for frame in rng.integers(0, n_input, rng.integers(0, 3))})
        costs = {
            "start_cost": rng.integers(0, 3, max_skip) * 0.5,
            "end_cost": rng.integers(0, 3, max_skip) * 0.5,
        }
        wanted = literal.best_free_path(scores, through, **costs)
        got = found_by(scores, n_output=None, anchors=[(0, frame) for frame in through], use=kernels, **costs)
        if wanted is None:
            assert got is None
        else:
            assert got is not None
            assert got[1] == wanted[0]
            assert got[0] in wanted[1]


@pytest.mark.parametrize("temper", ["noise", "exact_ties", "all_equal", "magnitudes", "slow", "forbidden"])
def test_longer_problems_equal_the_recurrence_on_every_backend_and_search(temper: str) -> None:
    rng = np.random.default_rng(sum(map(ord, temper)))
    for max_skip in (2, 4, 8, 16, 19):
        n_input = int(rng.integers(24, 40))
        shape = (n_input, max_skip, max_skip)
        scores = {
            "noise": lambda shape=shape: rng.random(shape),
            "exact_ties": lambda shape=shape: rng.integers(0, 3, shape) * 1.0,
            "all_equal": lambda shape=shape: np.full(shape, 0.25),
            "magnitudes": lambda shape=shape: 10.0 ** rng.uniform(-12, 12, shape),
            "slow": lambda shape=shape: 1 + 1e-9 * rng.random(shape),
            "forbidden": lambda shape=shape: np.where(rng.random(shape) < 0.3, np.inf, rng.random(shape)),
        }[temper]()
        fewest = -(-(n_input - 1) // max_skip) + 1
        for n_output in (fewest, (fewest + n_input) // 2, n_input - 1):
            middle = (n_output // 2, (n_input - 1) * (n_output // 2) // (n_output - 1))
            for anchors in ([], [middle]):
                wanted = literal.recurrence(scores, n_output, dict(anchors))
                for use in KERNELS:
                    # NumPy has the recurrence only.
                    for search in SEARCHES if use is KERNELS[-1] else ["layered"]:
                        for memory_limit in (1 << 30, 3000):
                            options = {
                                "n_output": n_output,
                                "anchors": anchors,
                                "search": search,
                                "use": use,
                                "memory_limit": memory_limit,
                            }
                            assert found_by(scores, **options) == wanted


def test_every_length_there_is(kernels: Backend) -> None:
    rng = np.random.default_rng(8)
    poses = np.cumsum(rng.random(40))
    # Smooth scores, as motions give: the cost of a triple grows with its acceleration.
    steps = np.arange(1, 6)
    scores = np.full((40, 5, 5), np.inf)
    for j in range(1, 39):
        for a in steps[steps <= j]:
            for b in steps[steps <= 39 - j]:
                scores[j, a - 1, b - 1] = abs(poses[j + b] - 2 * poses[j] + poses[j - a]) + 0.1 * abs(b - 2)
    for n_output in range(9, 41, 3):
        assert found_by(scores, n_output=n_output, use=kernels) == literal.recurrence(scores, n_output)
    with pytest.raises(InfeasibleWarpError):
        shortest_path(scores, n_output=8, use=kernels)
    with pytest.raises(InfeasibleWarpError):
        shortest_path(scores, n_output=41, use=kernels)


def test_two_frames(kernels: Backend) -> None:
    assert found_by(np.zeros((4, 3, 3)), n_output=2, use=kernels) == ((0, 3), 0.0)
    assert found_by(np.zeros((2, 3, 3)), n_output=2, use=kernels) == ((0, 1), 0.0)
    assert found_by(np.full((2, 1, 1), np.inf), n_output=2, use=kernels) == ((0, 1), 0.0)


def test_as_many_frames_as_the_input_is_the_identity(kernels: Backend) -> None:
    scores = np.random.default_rng(0).random((50, 4, 4))
    assert found_by(scores, n_output=50, use=kernels)[0] == tuple(range(50))  # type: ignore[index]


def test_ties_go_to_the_smaller_skip_read_from_the_end(kernels: Backend) -> None:
    # All paths tie. The last steps are as small as the length allows; what is left to skip, the first ones do.
    got = found_by(np.zeros((10, 4, 4)), n_output=5, use=kernels)
    assert got == ((0, 4, 7, 8, 9), 0.0)
    # Of several lengths, the shortest.
    got = found_by(np.zeros((10, 4, 4)), n_output=(4, 8), use=kernels)
    assert got == ((0, 4, 8, 9), 0.0)


def test_forbidden_triples_are_never_used(kernels: Backend) -> None:
    scores = np.zeros((7, 2, 2))
    scores[4, 1, 1] = np.inf
    scores[3] = np.inf
    # Frame 3 can't be shown, nor two long steps about frame 4.
    assert found_by(scores, n_output=5, use=kernels) == ((0, 2, 4, 5, 6), 0.0)
    scores[1:] = np.inf
    with pytest.raises(InfeasibleWarpError, match="every path"):
        shortest_path(scores, n_output=5, use=kernels)


@settings(max_examples=80)
@given(st.data())
def test_properties_of_every_path(data: st.DataObject) -> None:
    n_input = data.draw(st.integers(2, 60), label="n_input")
    max_skip = data.draw(st.integers(1, 9), label="max_skip")
    n_output = data.draw(st.integers(-(-(n_input - 1) // max_skip) + 1, n_input), label="n_output")
    scores = np.random.default_rng(data.draw(st.integers(0, 99))).random((n_input, max_skip, max_skip))
    anchors = []
    if n_output > 2:
        position = data.draw(st.integers(1, n_output - 2), label="position")
        low = max(position, n_input - 1 - max_skip * (n_output - 1 - position))
        high = min(max_skip * position, n_input - 1 - (n_output - 1 - position))
        anchors = [(position, data.draw(st.integers(low, high), label="frame"))]
    results = []
    for use in KERNELS:
        path = shortest_path(scores, n_output=n_output, anchors=anchors, use=use)
        check(path, scores, {})
        assert len(path.frames) == n_output
        for position, frame in anchors:
            assert path.frames[position] == frame
        results.append(path.frames.tolist())
    assert all(frames == results[0] for frames in results)


@settings(max_examples=150)
@given(st.integers(2, 400), st.integers(1, 12), st.integers(2, 500))
def test_infeasible_lengths_name_bounds_that_are_true(n_input: int, max_skip: int, n_output: int) -> None:
    def fits(n_output: int, n_input: int = n_input, max_skip: int = max_skip) -> bool:
        return refusal(n_output, n_input, max_skip) is None

    error = refusal(n_output, n_input, max_skip)
    if error is None:
        return
    assert (error.n_input, error.n_output, error.max_skip, error.span) == (n_input, n_output, max_skip, 0)
    low, high = error.min_output, error.max_output
    assert low is not None
    assert high is not None
    assert not low <= n_output <= high
    assert fits(low)
    assert fits(high)
    assert not fits(low - 1)
    assert not fits(high + 1)
    remedy = re.search(r"(max_skip >=|upsample .*by) (\d+)", str(error))
    assert remedy is not None
    enough = int(remedy[2])
    if n_output < low:
        assert fits(n_output, max_skip=enough)
        assert not fits(n_output, max_skip=enough - 1)
    else:
        assert fits(n_output, n_input=(n_input - 1) * enough + 1, max_skip=n_input * enough)
        assert not fits(n_output, n_input=(n_input - 1) * (enough - 1) + 1, max_skip=n_input * enough)


def refusal(n_output: int, n_input: int, max_skip: int) -> InfeasibleWarpError | None:
    try:
        check_feasible([(0, 0), (n_output - 1, n_input - 1)], max_skip)
    except InfeasibleWarpError as error:
        return error
    return None


def test_the_span_that_fails_is_named() -> None:
    with pytest.raises(InfeasibleWarpError, match="input frames 10–40 into 3 output frames") as caught:
        shortest_path(np.zeros((61, 8, 8)), n_output=23, anchors=[(10, 10), (12, 40)])
    assert (caught.value.span, caught.value.min_output, caught.value.max_output) == (1, 5, 31)


def test_a_range_with_only_its_longest_lengths_feasible(kernels: Backend) -> None:
    scores = np.random.default_rng(1).random((30, 3, 3))
    path = shortest_path(scores, n_output=(2, 11), use=kernels)
    assert len(path.frames) == 11
    with pytest.raises(InfeasibleWarpError):
        shortest_path(scores, n_output=(2, 10), use=kernels)


@pytest.mark.parametrize(
    "anchors",
    [
        pytest.param([(3, 0)], id="same_frame_twice"),
        pytest.param([(0, 3)], id="same_position_twice"),
        pytest.param([(2, 5), (4, 4)], id="backward"),
        pytest.param([(2, 5), (2, 6)], id="two_frames_at_one_position"),
        pytest.param([(3, 12)], id="frame_beyond_the_input"),
        pytest.param([(9, 5)], id="position_beyond_the_output"),
    ],
)
def test_anchors_that_contradict_each_other_are_refused(kernels: Backend, anchors: list[tuple[int, int]]) -> None:
    with pytest.raises(InfeasibleWarpError):
        shortest_path(np.zeros((10, 3, 3)), n_output=6, anchors=anchors, use=kernels)


@pytest.mark.parametrize("n_output", [1, 0, -3])
def test_fewer_than_two_frames_are_refused(kernels: Backend, n_output: int) -> None:
    with pytest.raises(InfeasibleWarpError):
        shortest_path(np.zeros((10, 3, 3)), n_output=n_output, use=kernels)


@pytest.mark.parametrize(
    ("scores", "says"),
    [
        pytest.param(np.zeros((5, 2)), "shape", id="flat"),
        pytest.param(np.zeros((5, 2, 3)), "shape", id="not_square"),
        pytest.param(np.zeros((5, 0, 0)), "shape", id="no_skip"),
        pytest.param(np.zeros((5, 256, 256)), "255", id="steps_beyond_a_byte"),
        pytest.param(np.full((5, 2, 2), np.nan), "nan", id="nan"),
    ],
)
def test_scores_of_the_wrong_shape_or_kind_are_refused(scores: np.ndarray, says: str) -> None:
    with pytest.raises(OptionError, match=says):
        shortest_path(scores, n_output=3)


def test_the_longest_step_that_fits_a_byte(kernels: Backend) -> None:
    assert found_by(np.zeros((511, 255, 255)), n_output=3, use=kernels) == ((0, 255, 510), 0.0)
