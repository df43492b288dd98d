"""Local scores: against Eq. 2 in exact fractions, and bit for bit between backends."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest

from retime.errors import OptionError
from retime.kernels import Backend
from retime.warp import score
from retime.warp.features import difference_scales, timing_features
from tests.reference.scores import scores as literal_scores

RATE, TIME_SCALE = 30.0, 0.1


def joint(
    kernels: Backend, y: np.ndarray, z: np.ndarray, max_skip: int, n_neighbors: int = 3, **options: float
) -> np.ndarray:
    settings = {"rate": RATE, "time_scale": TIME_SCALE, **options}
    return score.triple_scores(y, z, max_skip=max_skip, n_neighbors=n_neighbors, use=kernels, **settings)


def conditional(
    kernels: Backend, y: np.ndarray, z: np.ndarray, max_skip: int, n_neighbors: int = 3, **options: float
) -> np.ndarray:
    settings = {"rate": RATE, "time_scale": TIME_SCALE, **options}
    features = timing_features(z, **settings)
    return kernels.conditional_scores(y, features, max_skip, *difference_scales(**settings), n_neighbors)


def walk(rng: np.random.Generator, n_frames: int, n_numbers: int) -> np.ndarray:
    return np.cumsum(rng.standard_normal((n_frames, n_numbers)), axis=0)


# What each says of (rng, n_input, n_reference, n_numbers): input poses, reference poses.
DATA = {
    "noise": lambda rng, n, r, d: (rng.standard_normal((n, d)), rng.standard_normal((r, d))),
    "walks": lambda rng, n, r, d: (walk(rng, n, d), walk(rng, r, d)),
    "itself": lambda rng, n, r, d: (walk(np.random.default_rng(n), n, d), walk(np.random.default_rng(n), r, d)),
    "constant": lambda rng, n, r, d: (np.full((n, d), 0.1), np.full((r, d), 0.1)),
    "zeros": lambda rng, n, r, d: (np.zeros((n, d)), np.zeros((r, d))),
    "constant_reference": lambda rng, n, r, d: (walk(rng, n, d), np.full((r, d), 0.7)),
    "constant_input": lambda rng, n, r, d: (np.full((n, d), 0.7), walk(rng, r, d)),
    "ties": lambda rng, n, r, d: (rng.integers(0, 2, (n, d)) * 1.0, rng.integers(0, 2, (r, d)) * 1.0),
    "duplicates": lambda rng, n, r, d: (
        np.repeat(walk(rng, n, d), 3, axis=0)[:n],
        np.repeat(walk(rng, r, d), 3, axis=0)[:r],
    ),
    "periodic": lambda rng, n, r, d: (
        np.tile(walk(rng, 5, d), (n // 5 + 1, 1))[:n],
        np.tile(walk(np.random.default_rng(5), 5, d), (r // 5 + 1, 1))[:r],
    ),
    "far_from_zero": lambda rng, n, r, d: (walk(rng, n, d) + 1e6, walk(rng, r, d) + 1e6),
    "tiny": lambda rng, n, r, d: (walk(rng, n, d) * 1e-12, walk(rng, r, d) * 1e-12),
    "huge": lambda rng, n, r, d: (walk(rng, n, d) * 1e12, walk(rng, r, d) * 1e12),
    "tiny_input_huge_reference": lambda rng, n, r, d: (walk(rng, n, d) * 1e-12, walk(rng, r, d) * 1e12),
    "huge_input_tiny_reference": lambda rng, n, r, d: (walk(rng, n, d) * 1e12, walk(rng, r, d) * 1e-12),
    # Which poses are nearest is decided below the rounding of doubles here: for comparing backends only.
    "every_magnitude": lambda rng, n, r, d: (
        rng.standard_normal((n, d)) * 10.0 ** rng.integers(-12, 13, (n, 1)),
        rng.standard_normal((r, d)) * 10.0 ** rng.integers(-12, 13, (r, 1)),
    ),
}

# n_input, n_reference, n_numbers, max_skip, n_neighbors
SIZES = [
    pytest.param(12, 9, 2, 3, 3, id="small"),
    pytest.param(3, 5, 1, 2, 3, id="three_frames_shortest_reference"),
    pytest.param(6, 3, 3, 2, 1, id="one_neighbor_one_reference_feature"),
    pytest.param(4, 8, 2, 9, 2, id="max_skip_beyond_the_input"),
    pytest.param(7, 12, 8, 2, 10, id="every_feature_a_neighbor"),
]


@cache
def exact_scores(
    kind: str, data: str, n_input: int, n_reference: int, n_numbers: int, max_skip: int, n_neighbors: int
) -> np.ndarray:
    y, z = DATA[data](np.random.default_rng(7), n_input, n_reference, n_numbers)
    return literal_scores(kind, y, z, max_skip=max_skip, rate=RATE, time_scale=TIME_SCALE, n_neighbors=n_neighbors)


@pytest.mark.parametrize("data", [name for name in DATA if name != "every_magnitude"])
@pytest.mark.parametrize(("n_input", "n_reference", "n_numbers", "max_skip", "n_neighbors"), SIZES)
@pytest.mark.parametrize("kind", ["joint", "conditional"])
def test_scores_equal_eq_2(
    kernels: Backend,
    kind: str,
    data: str,
    n_input: int,
    n_reference: int,
    n_numbers: int,
    max_skip: int,
    n_neighbors: int,
) -> None:
    y, z = DATA[data](np.random.default_rng(7), n_input, n_reference, n_numbers)
    table = {"joint": joint, "conditional": conditional}[kind](kernels, y, z, max_skip, n_neighbors)
    wanted = exact_scores(kind, data, n_input, n_reference, n_numbers, max_skip, n_neighbors)
    assert table.shape == (n_input, max_skip, max_skip)
    inside = np.isfinite(wanted)
    assert np.array_equal(np.isfinite(table), inside)
    # Beside the score itself, doubles round the poses that it is a difference of, and their second differences.
    size = max(np.abs(y).max(), np.abs(z).max()) * (TIME_SCALE * RATE) ** 2
    np.testing.assert_allclose(table[inside], wanted[inside], rtol=1e-12, atol=1e-14 * size)


@pytest.mark.parametrize("data", DATA)
@pytest.mark.parametrize(
    ("n_input", "n_reference", "n_numbers", "max_skip", "n_neighbors"),
    [
        *SIZES,
        pytest.param(40, 30, 97, 3, 3, id="97_numbers"),
        pytest.param(60, 200, 3, 8, 3, id="more_reference_than_a_block"),
        pytest.param(1, 9, 2, 3, 3, id="one_frame"),
        pytest.param(2, 9, 2, 3, 3, id="two_frames"),
    ],
)
def test_every_backend_and_thread_count_gives_the_same_bits(
    both: tuple[Backend, Backend],
    monkeypatch: pytest.MonkeyPatch,
    data: str,
    n_input: int,
    n_reference: int,
    n_numbers: int,
    max_skip: int,
    n_neighbors: int,
) -> None:
    compiled, in_numpy = both
    y, z = DATA[data](np.random.default_rng(3), n_input, n_reference, n_numbers)
    for scores_of in (joint, conditional):
        wanted = scores_of(in_numpy, y, z, max_skip, n_neighbors)
        for threads in ("1", "2", "5"):
            monkeypatch.setenv("RETIME_THREADS", threads)
            assert np.array_equal(scores_of(compiled, y, z, max_skip, n_neighbors), wanted)


@pytest.mark.parametrize("time_scale", [0.0, 1 / 30, 2 / 3, 100.0])
@pytest.mark.parametrize("rate", [1.0, 24000 / 1001, 120.0])
def test_time_scale_and_rate_weigh_as_in_the_formula(
    both: tuple[Backend, Backend], time_scale: float, rate: float
) -> None:
    rng = np.random.default_rng(11)
    y, z = walk(rng, 9, 3), walk(rng, 9, 3)
    for kind, scores_of in (("joint", joint), ("conditional", conditional)):
        compiled, in_numpy = (scores_of(kernels, y, z, 2, rate=rate, time_scale=time_scale) for kernels in both)
        wanted = literal_scores(kind, y, z, max_skip=2, rate=rate, time_scale=time_scale, n_neighbors=3)
        inside = np.isfinite(wanted)
        size = max(1.0, (rate * time_scale) ** 2)
        np.testing.assert_allclose(compiled[inside], wanted[inside], rtol=1e-12, atol=1e-13 * size)
        assert np.array_equal(compiled, in_numpy)


def test_more_frames_than_a_block_holds(both: tuple[Backend, Backend]) -> None:
    # Both backends work through long inputs in blocks; these sizes make three of them and two.
    rng = np.random.default_rng(5)
    y, z = walk(rng, 2600, 1), walk(rng, 4000, 1)
    for scores_of in (joint, conditional):
        compiled, in_numpy = (scores_of(kernels, y, z, 1) for kernels in both)
        assert np.array_equal(compiled, in_numpy)
        part = scores_of(both[0], y[1000:1300], z, 1)
        assert np.array_equal(part[1:-1], compiled[1001:1299])


def test_conditional_takes_the_earlier_frame_of_two_equally_near_in_pose(kernels: Backend) -> None:
    # All three inner frames of the reference are 1 away from where the input rests; the first of them rests too.
    reference = np.array([[0.0], [0.0], [0.0], [2.0], [4.0]])
    table = conditional(kernels, np.ones((3, 1)), reference, 1, 1, time_scale=1 / RATE)
    assert table[1, 0, 0] == 0.0
    backwards = conditional(kernels, np.ones((3, 1)), reference[::-1], 1, 1, time_scale=1 / RATE)
    assert backwards[1, 0, 0] == 2.0


def test_unit_speed_costs_nothing_where_the_reference_is_the_input_itself(kernels: Backend) -> None:
    poses = walk(np.random.default_rng(2), 30, 5)
    table = joint(kernels, poses, poses, 3, 1)
    np.testing.assert_array_equal(table[1:-1, 0, 0], 0.0)
    assert (table[2:-2, 1, 1] > 0).all()


def test_triples_outside_the_input_are_forbidden(kernels: Backend) -> None:
    table = joint(kernels, walk(np.random.default_rng(2), 6, 2), walk(np.random.default_rng(3), 9, 2), 4)
    for j in range(6):
        for a in range(1, 5):
            for b in range(1, 5):
                assert np.isfinite(table[j, a - 1, b - 1]) == (j - a >= 0 and j + b <= 5)


@pytest.mark.parametrize("n_neighbors", [1, 3, 7])
def test_a_reference_too_short_for_the_neighbors_is_refused(kernels: Backend, n_neighbors: int) -> None:
    poses = walk(np.random.default_rng(0), n_neighbors + 1, 2)
    enough = walk(np.random.default_rng(0), n_neighbors + 2, 2)
    with pytest.raises(OptionError, match=re.escape(f"n_neighbors={n_neighbors} needs at least {n_neighbors + 2}")):
        joint(kernels, enough, poses, 2, n_neighbors)
    assert np.isfinite(joint(kernels, enough, enough, 2, n_neighbors)[1, 0, 0])


def test_poses_of_different_numbers_are_refused(kernels: Backend) -> None:
    with pytest.raises(OptionError, match="same numbers"):
        joint(kernels, np.zeros((9, 2)), np.zeros((9, 3)), 2)


@pytest.mark.parametrize("options", [{"max_skip": 0}, {"max_skip": -1}, {"n_neighbors": 0}])
def test_limits_below_one_are_refused(kernels: Backend, options: dict[str, int]) -> None:
    with pytest.raises(OptionError, match="at least 1"):
        joint(kernels, np.zeros((9, 2)), np.zeros((9, 2)), **{"max_skip": 2, **options})


@pytest.mark.parametrize("time_scale", [-0.1, float("nan"), float("inf")])
def test_a_time_scale_that_is_no_time_is_refused(kernels: Backend, time_scale: float) -> None:
    with pytest.raises(OptionError, match="time scale"):
        joint(kernels, np.zeros((9, 2)), np.zeros((9, 2)), 2, time_scale=time_scale)
