"""The path search: against every path there is, the paper's recurrence literally, and itself on each backend."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import Backend, backend, compiled_available
from retime.search.path import SEARCHES, FramePath, check_feasible, path_scores, shortest_path
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
        if seed % 2:
            scores -= 1.0
        wanted = literal.best_free_path(scores, through, **costs)
        got = found_by(scores, n_output=None, anchors=[(0, frame) for frame in through], use=kernels, **costs)
        assert got == wanted


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
    for length in ((4, 8), None):
        got = found_by(np.zeros((10, 4, 4)), n_output=length, use=kernels)
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
    remedy = re.search(r"(?:steps of up to |frames, or )(\d+)(?:\.| times as many of input\.)$", str(error))
    assert remedy is not None
    enough = int(remedy[1])
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


def test_ranges_shrink_to_what_the_anchors_allow(kernels: Backend) -> None:
    rng = np.random.default_rng(12)
    for _ in range(40):
        n_input, max_skip = int(rng.integers(5, 10)), int(rng.integers(1, 4))
        scores = rng.integers(0, 3, (n_input, max_skip, max_skip)) * 0.5
        anchor = (int(rng.integers(1, 6)), int(rng.integers(1, n_input)))
        wanted = literal.best_path(scores, range(2, 9), dict([anchor]))
        # Lengths that end before the anchor's position don't pass it.
        passing = [n for n in range(anchor[0] + 1, 9) if literal.best_path(scores, range(n, n + 1), dict([anchor]))]
        wanted = literal.best_path(scores, range(passing[0], 9), dict([anchor])) if passing else None
        for search in SEARCHES:
            assert found_by(scores, n_output=(2, 8), anchors=[anchor], use=kernels, search=search) == wanted


@pytest.mark.parametrize("length", [None, 6, (4, 9)])
@pytest.mark.parametrize("anchor", [(2, 10), (2, 1 << 40), (2, -1), (-1, 2), (-1, -1)])
def test_anchors_outside_the_problem_are_refused(
    kernels: Backend, anchor: tuple[int, int], length: int | tuple[int, int] | None
) -> None:
    with pytest.raises(InfeasibleWarpError, match=rf"position {anchor[0]} and input frame {anchor[1]} lies outside"):
        shortest_path(np.zeros((10, 3, 3)), n_output=length, anchors=[anchor], use=kernels)


def test_an_anchor_beyond_the_longest_length_is_named() -> None:
    with pytest.raises(InfeasibleWarpError, match="position 7 and input frame 8 lies beyond the last of 6"):
        shortest_path(np.zeros((10, 3, 3)), n_output=(4, 6), anchors=[(7, 8)])


@pytest.mark.parametrize("which", ["start_cost", "end_cost"])
@pytest.mark.parametrize("search", [*SEARCHES, "free"])
@pytest.mark.parametrize(
    ("costs", "says"),
    [
        pytest.param(np.zeros(2), r"shape \(3,\).*\(2,\)", id="too_short"),
        pytest.param(np.zeros(0), r"shape \(3,\).*\(0,\)", id="empty"),
        pytest.param(np.zeros(4), r"shape \(3,\).*\(4,\)", id="too_long"),
        pytest.param(np.zeros((3, 1)), r"shape \(3,\).*\(3, 1\)", id="column"),
        pytest.param(1.0, r"shape \(3,\).*\(\)", id="number"),
        pytest.param([0, np.nan, 0], "found nan for a step of 2", id="nan"),
        pytest.param([0, 0, -np.inf], "found -inf for a step of 3", id="minus_inf"),
        pytest.param(["a", "b", "c"], "real numbers", id="text"),
        pytest.param([0, 0, 1j], "real numbers", id="complex"),
        pytest.param([[0], [0, 0]], "array of numbers", id="ragged"),
    ],
)
def test_costs_at_the_ends_are_checked(kernels: Backend, which: str, search: str, costs: object, says: str) -> None:
    asked = {"search": search, "n_output": 4} if search != "free" else {}
    with pytest.raises(OptionError, match=f"{which}.*{says}"):
        shortest_path(np.zeros((7, 3, 3)), use=kernels, **{which: costs}, **asked)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        pytest.param({"n_output": (9, 5)}, "9, is more than the most, 5", id="least_above_most"),
        pytest.param({"n_output": 4.0}, "integer.*4.0", id="float"),
        pytest.param({"n_output": "4"}, "integer.*'4'", id="text"),
        pytest.param({"n_output": (4, 5, 6)}, r"least and the most.*\(4, 5, 6\)", id="three_lengths"),
        pytest.param({"n_output": (4, 5.5)}, "integer.*5.5", id="float_in_a_range"),
        pytest.param({"n_output": 4, "anchors": [(1, 2.5)]}, "integer.*2.5", id="float_anchor"),
        pytest.param({"n_output": 4, "anchors": [3]}, "anchor.*3", id="anchor_without_a_frame"),
        pytest.param({"n_output": 4, "memory_limit": -1}, "memory_limit.*-1", id="memory_below_zero"),
        pytest.param({"n_output": 4, "memory_limit": 1e9}, "memory_limit.*integer", id="memory_in_floats"),
        pytest.param({"n_output": 4, "search": "best"}, "priced, layered.*'best'", id="search"),
    ],
)
def test_options_of_the_wrong_kind_are_refused(asked: dict[str, object], says: str) -> None:
    with pytest.raises(OptionError, match=says):
        shortest_path(np.zeros((7, 3, 3)), **asked)  # type: ignore[arg-type]


@pytest.mark.parametrize("bad", [np.nan, -np.inf])
@pytest.mark.parametrize("length", [None, 5])
def test_scores_that_are_no_numbers_are_named(bad: float, length: int | None) -> None:
    scores = np.zeros((9, 2, 2))
    scores[4, 1, 0] = bad
    with pytest.raises(OptionError, match=f"found {bad} for frame 4 between a step of 2 and one of 1"):
        shortest_path(scores, n_output=length)


def test_scores_too_large_to_be_added_are_told_from_forbidden_ones(kernels: Backend) -> None:
    with pytest.raises(OptionError, match=r"too large.*1e\+308"):
        shortest_path(np.full((9, 2, 2), 1e308), n_output=7, use=kernels)


def test_integers_of_every_kind_will_do(kernels: Backend) -> None:
    scores = np.random.default_rng(3).random((12, 3, 3))
    wanted = found_by(scores, n_output=7, anchors=[(3, 5)], use=kernels)
    for kind in (np.int64, np.uint8, np.int16):
        assert found_by(scores, n_output=kind(7), anchors=[(kind(3), kind(5))], use=kernels) == wanted
        assert (
            found_by(scores, n_output=np.array([7, 7], kind), anchors=np.array([[3, 5]], kind), use=kernels) == wanted
        )
    assert found_by(scores, n_output=[7, 7], anchors=[(3, 5)], use=kernels) == wanted


@pytest.mark.parametrize("length", [None, 7, (5, 9)])
def test_arrays_of_every_kind_give_the_same_path(kernels: Backend, length: int | None) -> None:
    rng = np.random.default_rng(4)
    scores, costs = rng.integers(0, 2, (12, 3, 3)).astype(float), rng.integers(0, 2, 3).astype(float)
    frozen = scores.copy()
    frozen.flags.writeable = False
    wanted = found_by(scores, n_output=length, start_cost=costs, end_cost=costs, use=kernels)
    others = (
        scores.astype(bool), scores.astype(np.float32), scores.astype(np.int8), scores.astype(">f8"), frozen,
        np.asfortranarray(scores), np.repeat(scores, 2, axis=2)[:, :, ::2], scores[::-1].copy()[::-1],
    )  # fmt: skip
    for other in others:
        for cost in (costs, costs.astype(bool), costs.astype(np.float32), np.repeat(costs, 2)[::2], costs.tolist()):
            path = shortest_path(other, n_output=length, start_cost=cost, end_cost=cost, use=kernels)
            assert (tuple(path.frames.tolist()), path.total) == wanted


@pytest.mark.parametrize("search", [*SEARCHES, "free"])
def test_a_longest_step_beyond_the_input(kernels: Backend, search: str) -> None:
    rng = np.random.default_rng(5)
    for n_input in (2, 3, 4, 6):
        scores, costs = rng.random((n_input, 40, 40)), rng.random(40)
        lengths = range(2, n_input + 1)
        asked = {"search": search, "n_output": (2, n_input)} if search != "free" else {}
        got = found_by(scores, start_cost=costs, end_cost=costs, use=kernels, **asked)
        assert got == literal.best_path(scores, lengths, {}, costs, costs)


def test_a_single_input_frame(kernels: Backend) -> None:
    scores = np.zeros((1, 2, 2))
    for length in (None, 1, (1, 4)):
        assert shortest_path(scores, n_output=length, anchors=[(0, 0)], use=kernels).frames.tolist() == [0]
    for length in (2, 0, (2, 5)):
        with pytest.raises(InfeasibleWarpError, match="single input frame"):
            shortest_path(scores, n_output=length, use=kernels)
    with pytest.raises(InfeasibleWarpError, match="position 3"):
        shortest_path(scores, n_output=1, anchors=[(3, 0)], use=kernels)


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
        pytest.param(np.zeros((0, 2, 2)), "shape", id="no_frames"),
        pytest.param(np.zeros((5, 2, 2), dtype=complex), "real numbers", id="complex"),
        pytest.param(np.full((5, 2, 2), "x"), "real numbers", id="text"),
        pytest.param(np.zeros((5, 256, 256)), "255", id="steps_beyond_a_byte"),
        pytest.param(np.full((5, 2, 2), np.nan), "nan", id="nan"),
    ],
)
def test_scores_of_the_wrong_shape_or_kind_are_refused(scores: np.ndarray, says: str) -> None:
    with pytest.raises(OptionError, match=says):
        shortest_path(scores, n_output=3)


def test_the_longest_step_that_fits_a_byte(kernels: Backend) -> None:
    assert found_by(np.zeros((511, 255, 255)), n_output=3, use=kernels) == ((0, 255, 510), 0.0)


@pytest.mark.parametrize("seed", range(30))
def test_the_best_path_within_a_band_is_the_best_of_all_that_stay_there(kernels: Backend, seed: int) -> None:
    rng = np.random.default_rng(seed)
    n_input, n_output, max_skip = int(rng.integers(6, 12)), int(rng.integers(3, 7)), 3
    scores = rng.integers(0, 4, (n_input, max_skip, max_skip)) * 0.5
    middle = np.linspace(0, n_input - 1, n_output)
    slack = rng.integers(0, 4, n_output)
    band = np.stack([np.floor(middle) - slack, np.ceil(middle) + slack], axis=1).astype(int)
    inside = [
        path
        for path in literal.every_path(n_input, n_output, max_skip)
        if all(low <= frame <= high for frame, (low, high) in zip(path, band, strict=True))
    ]
    for memory_limit in (0, 1 << 20):
        if not inside:
            with pytest.raises(InfeasibleWarpError):
                shortest_path(scores, n_output=n_output, band=band, use=kernels, memory_limit=memory_limit)
            continue
        found = shortest_path(scores, n_output=n_output, band=band, use=kernels, memory_limit=memory_limit)
        best = min(inside, key=lambda path: (literal.total(scores, path), literal.rank(path)))
        assert tuple(found.frames) == best
        assert found.total == literal.total(scores, best)


def test_a_band_of_another_length_is_refused() -> None:
    with pytest.raises(OptionError, match="a band must have shape"):
        shortest_path(np.zeros((9, 3, 3)), n_output=5, band=np.zeros((4, 2)))
    with pytest.raises(OptionError, match="a band must have shape"):
        shortest_path(np.zeros((9, 3, 3)), n_output=(4, 5), band=np.zeros((4, 2)))
