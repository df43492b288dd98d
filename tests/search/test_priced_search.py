"""The priced search against the layered recurrence: two thousand problems, random and degenerate."""

from __future__ import annotations

import numpy as np
import pytest

from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import StepPairs, backend, compiled_available
from retime.search.path import FramePath, shortest_path

N_PROBLEMS = 300


def _scores(rng: np.random.Generator, temper: str, n_input: int, max_skip: int) -> np.ndarray:
    scores = rng.random((n_input, max_skip, max_skip))
    if temper == "ties":
        return np.round(scores * 3)
    if temper == "all equal":
        return np.ones_like(scores)
    if temper == "all zero":
        return np.zeros_like(scores)
    if temper == "forbidden":
        scores[rng.random(scores.shape) < 0.2] = np.inf
    if temper == "periodic":
        return np.ascontiguousarray(np.tile(scores[:4], (n_input // 4 + 1, 1, 1))[:n_input])
    if temper == "signed":
        return scores - 0.5
    if temper == "nearly equal":
        return 0.1 + 1e-12 * scores
    if temper == "duplicates":
        return np.ascontiguousarray(np.repeat(scores, 3, axis=0)[:n_input])
    return scores


def _found(scores: np.ndarray, search: str, **asked: object) -> FramePath | None:
    try:
        return shortest_path(scores, search=search, use=backend("compiled"), **asked)  # type: ignore[arg-type]
    except (InfeasibleWarpError, OptionError):
        # Or the sum of its scores is too large for a number.
        return None


@pytest.mark.parametrize(
    "temper",
    ["random", "ties", "all equal", "all zero", "forbidden", "periodic", "duplicates", "signed", "nearly equal"],
)
def test_priced_and_layered_agree_to_the_last_bit(temper: str) -> None:
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    rng = np.random.default_rng(len(temper))
    n_found = 0
    for _ in range(N_PROBLEMS):
        n_input, max_skip = int(rng.integers(3, 60)), int(rng.choice([1, 2, 3, 4, 5, 7, 8, 10, 16, 21]))
        scores = _scores(rng, temper, n_input, max_skip)
        least = -(-(n_input - 1) // max_skip) + 1
        # The shortest and the longest lengths too, and a keytime wherever it falls.
        n_output = int(rng.choice([least, n_input, rng.integers(least, n_input + 1)]))
        anchors = [(int(rng.integers(1, n_output)), int(rng.integers(1, n_input))) for _ in range(rng.integers(0, 4))]
        asked: dict[str, object] = {"n_output": n_output, "anchors": anchors}
        if rng.random() < 0.3:
            asked["n_output"] = (max(2, n_output - int(rng.integers(0, 9))), n_output)
        if rng.random() < 0.3:
            asked["start_cost"], asked["end_cost"] = np.where(rng.random((2, max_skip)) < 0.2, np.inf, rng.random())
        priced, layered = _found(scores, "priced", **asked), _found(scores, "layered", **asked)
        assert (priced is None) == (layered is None)
        if priced is None or layered is None:
            continue
        n_found += 1
        assert priced.total == layered.total
        assert priced.frames.tolist() == layered.frames.tolist()
        assert priced.optimal
        assert priced.lower_bound <= priced.total
    assert n_found > N_PROBLEMS // 8


@pytest.mark.parametrize("score", [0.0, 0.1, 3.0, -0.1, 1e-300, np.inf, 1e308])
@pytest.mark.parametrize("spoilt", [False, True])
def test_where_all_scores_are_one_nothing_is_searched(score: float, spoilt: bool) -> None:
    """The same path as the recurrence finds, to the last tie: with limits, keytimes and ranges of lengths too."""
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    rng = np.random.default_rng(int(abs(score) * 10) if abs(score) < 100 else 7)
    n_found = n_priced = 0
    for _ in range(N_PROBLEMS):
        n_input = int(rng.integers(2, 60))
        steps = sorted(rng.choice(np.arange(1, 10), size=int(rng.integers(1, 6)), replace=False).tolist())
        if rng.random() < 0.8:
            steps = list(range(steps[0], steps[-1] + 1))
        pairs = StepPairs.of(steps, ratio=2.0 if rng.random() < 0.2 else np.inf)
        scores = np.full((n_input, pairs.n_pairs), score)
        # What leaves the clip may be anything: it is infinite, as scores are made.
        beyond = (np.arange(n_input)[:, None] < pairs.steps[pairs.before]) | (
            np.arange(n_input)[::-1, None] < pairs.steps[pairs.after]
        )
        scores[beyond] = np.inf
        if spoilt and not beyond.all():
            scores.flat[rng.choice(np.flatnonzero(~beyond))] = rng.choice([score + 1e-9, 7.0, np.inf])
        most = (n_input - 1) // steps[0] + 1
        n_output = int(rng.integers(min(2, most), most + 1))
        anchors = [
            (int(rng.integers(1, n_output + 1)), int(rng.integers(1, n_input))) for _ in range(rng.integers(0, 3))
        ]
        asked: dict[str, object] = {"steps": pairs, "n_output": n_output, "anchors": anchors}
        if rng.random() < 0.3:
            asked["n_output"] = (max(2, n_output - int(rng.integers(0, 9))), max(2, n_output))
        if rng.random() < 0.3:
            asked["start_cost"] = np.full(len(steps), rng.choice([0.1, -2.0, np.inf]))
            asked["end_cost"] = np.full(len(steps), 0.7)
        priced, layered = _found(scores, "priced", **asked), _found(scores, "layered", **asked)
        assert (priced is None) == (layered is None)
        if priced is None or layered is None:
            continue
        n_found += 1
        n_priced += "priced" in priced.search
        assert priced.total == layered.total
        assert priced.frames.tolist() == layered.frames.tolist()
        assert priced.lower_bound <= priced.total
    # Few paths have a finite sum of the largest scores.
    assert n_found > N_PROBLEMS // 8 or score > 1e300
    assert n_priced >= n_found // 2 or spoilt


def test_the_longest_take_in_which_nothing_moves_has_its_path_at_once() -> None:
    """An hour at 120 Hz: the recurrence would look at a hundred million positions, ten times over."""
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    n_input, n_output = 108_000, 60_000
    found = shortest_path(np.zeros((n_input, 4, 4)), n_output=n_output, use=backend("compiled"))
    assert found.search == "priced"
    steps = np.diff(found.frames)
    # As small as can be at the end, the longest in front.
    assert np.all(np.diff(steps) <= 0)
    assert steps.sum() == n_input - 1
    assert np.count_nonzero((steps > 1) & (steps < 4)) <= 1


def _like_motion(rng: np.random.Generator, n_input: int, max_skip: int) -> np.ndarray:
    """Scores with stretches that want a speed of their own: whole stretches switch at one price."""
    wanted = np.repeat(rng.uniform(1, max_skip, n_input // 40 + 1), 40)[:n_input, None, None]
    steps = np.arange(1, max_skip + 1)
    unsteady = np.abs(steps[:, None] - steps[None, :])
    return np.asarray(
        (steps[:, None] - wanted) ** 2 + 0.3 * unsteady + 0.01 * rng.random((n_input, max_skip, max_skip))
    )


@pytest.mark.parametrize(("n_input", "max_skip"), [(1500, 8), (2600, 4), (1300, 10)])
def test_long_takes_with_and_without_keytimes(n_input: int, max_skip: int) -> None:
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    rng = np.random.default_rng(n_input)
    scores = _like_motion(rng, n_input, max_skip)
    for share in (0.4, 0.7):
        n_output = round(share * n_input)
        thirds = [(n_output // 3, n_input // 4), (2 * n_output // 3, n_input // 2)]
        # Ranges too, where they bind: below and above the length that would be found without.
        free = len(shortest_path(scores).frames)
        beyond = ((free + 90, n_input), (2, free - 90)) if share == 0.4 else ()
        problems: list[dict[str, object]] = [{"n_output": n_output}, {"n_output": n_output, "anchors": thirds}]
        for asked in [*problems, *({"n_output": lengths} for lengths in beyond)]:
            priced, layered = _found(scores, "priced", **asked), _found(scores, "layered", **asked)
            assert priced is not None
            assert layered is not None
            assert priced.search == "priced"
            assert priced.total == layered.total
            assert priced.frames.tolist() == layered.frames.tolist()
            # The bound was found without the path, and is worth something.
            assert priced.total * (1 - 5e-3) < priced.lower_bound <= priced.total


def test_a_search_that_would_need_too_many_labels_falls_back() -> None:
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    scores = np.ones((400, 8, 8))
    # All but one alike: where all are, nothing is searched.
    scores[200] = 2.0
    short_of_memory = shortest_path(scores, n_output=200, use=backend("compiled"), memory_limit=1000)
    assert short_of_memory.search == "layered"
    assert short_of_memory.frames.tolist() == shortest_path(scores, n_output=200).frames.tolist()
