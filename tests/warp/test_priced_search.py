"""The priced search against the layered recurrence: two thousand problems, random and degenerate."""

from __future__ import annotations

import numpy as np
import pytest

from retime.errors import InfeasibleWarpError
from retime.kernels import backend, compiled_available
from retime.warp.path import FramePath, shortest_path

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
    if temper == "duplicates":
        return np.ascontiguousarray(np.repeat(scores, 3, axis=0)[:n_input])
    return scores


def _found(scores: np.ndarray, search: str, **asked: object) -> FramePath | None:
    try:
        return shortest_path(scores, search=search, use=backend("compiled"), **asked)  # type: ignore[arg-type]
    except InfeasibleWarpError:
        return None


@pytest.mark.parametrize("temper", ["random", "ties", "all equal", "all zero", "forbidden", "periodic", "duplicates"])
def test_priced_and_layered_agree_to_the_last_bit(temper: str) -> None:
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    rng = np.random.default_rng(len(temper))
    n_found = 0
    for _ in range(N_PROBLEMS):
        n_input, max_skip = int(rng.integers(3, 60)), int(rng.choice([1, 2, 3, 4, 5, 8, 16]))
        scores = _scores(rng, temper, n_input, max_skip)
        least = -(-(n_input - 1) // max_skip) + 1
        # The shortest and the longest lengths too, and a keytime wherever it falls.
        n_output = int(rng.choice([least, n_input, rng.integers(least, n_input + 1)]))
        anchors = [(int(rng.integers(1, n_output)), int(rng.integers(1, n_input))) for _ in range(rng.integers(0, 4))]
        asked = {"n_output": n_output, "anchors": anchors}
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


def test_a_search_that_would_need_too_many_labels_falls_back() -> None:
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    scores = np.ones((400, 8, 8))
    short_of_memory = shortest_path(scores, n_output=200, use=backend("compiled"), memory_limit=1000)
    assert short_of_memory.search == "layered"
    assert short_of_memory.frames.tolist() == shortest_path(scores, n_output=200).frames.tolist()
