"""Local scores: against Eq. 2 in exact fractions, and bit for bit between backends."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache

import numpy as np
import pytest

from retime.errors import OptionError
from retime.kernels import Backend
from retime.search.path import path_scores
from retime.search.score import SCORES, build_model, matched_frames, triple_scores
from tests.reference.scores import scores as literal_scores

RATE, TIME_SCALE = 30.0, 0.1


def table_of(
    kind: str,
    kernels: Backend,
    y: np.ndarray,
    *references: np.ndarray,
    max_skip: int,
    n_neighbors: int = 3,
    rate: float = RATE,
    time_scale: float = TIME_SCALE,
    weights: tuple[float, ...] = (),
) -> np.ndarray:
    model = build_model(references, rate=rate, time_scale=time_scale, n_neighbors=n_neighbors, weights=weights)
    return triple_scores(y, model, max_skip=max_skip, n_neighbors=n_neighbors, score=kind, use=kernels)


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


# All data in one size, and all sizes with some data.
EXACT = [(data, *SIZES[0].values) for data in DATA if data != "every_magnitude"] + [
    (data, *size.values) for size in SIZES[1:] for data in ("noise", "constant", "ties", "duplicates")
]


@pytest.mark.parametrize(("data", "n_input", "n_reference", "n_numbers", "max_skip", "n_neighbors"), EXACT)
@pytest.mark.parametrize("kind", SCORES)
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
    table = table_of(kind, kernels, y, z, max_skip=max_skip, n_neighbors=n_neighbors)
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
        pytest.param(30, 30, 97, 3, 3, id="97_numbers"),
        pytest.param(40, 150, 3, 5, 3, id="more_reference_than_a_block"),
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
    for kind in SCORES:
        wanted = table_of(kind, in_numpy, y, z, max_skip=max_skip, n_neighbors=n_neighbors)
        for threads in ("1", "2"):
            monkeypatch.setenv("RETIME_THREADS", threads)
            table = table_of(kind, compiled, y, z, max_skip=max_skip, n_neighbors=n_neighbors)
            assert np.array_equal(table, wanted)


@pytest.mark.parametrize("time_scale", [0.0, 1 / 30, 2 / 3, 100.0])
@pytest.mark.parametrize("rate", [1.0, 24000 / 1001, 120.0])
def test_time_scale_and_rate_weigh_as_in_the_formula(
    both: tuple[Backend, Backend], time_scale: float, rate: float
) -> None:
    rng = np.random.default_rng(11)
    y, z = walk(rng, 9, 3), walk(rng, 9, 3)
    for kind in SCORES:
        compiled, in_numpy = (
            table_of(kind, kernels, y, z, max_skip=2, rate=rate, time_scale=time_scale) for kernels in both
        )
        wanted = literal_scores(kind, y, z, max_skip=2, rate=rate, time_scale=time_scale, n_neighbors=3)
        inside = np.isfinite(wanted)
        size = max(1.0, (rate * time_scale) ** 2)
        np.testing.assert_allclose(compiled[inside], wanted[inside], rtol=1e-12, atol=1e-13 * size)
        assert np.array_equal(compiled, in_numpy)


def test_more_frames_than_a_block_holds(both: tuple[Backend, Backend]) -> None:
    # Both backends work through long inputs in blocks; these sizes make three of them and two.
    rng = np.random.default_rng(5)
    y, z = walk(rng, 2600, 1), walk(rng, 4000, 1)
    for kind in SCORES:
        compiled, in_numpy = (table_of(kind, kernels, y, z, max_skip=1) for kernels in both)
        assert np.array_equal(compiled, in_numpy)
        part = table_of(kind, both[0], y[1000:1300], z, max_skip=1)
        assert np.array_equal(part[1:-1], compiled[1001:1299])


def test_conditional_takes_the_earlier_frame_of_two_equally_near_in_pose(kernels: Backend) -> None:
    # All three inner frames of the reference are 1 away from where the input rests; the first of them rests too.
    reference = np.array([[0.0], [0.0], [0.0], [2.0], [4.0]])
    resting = np.ones((3, 1))
    forward = table_of("conditional", kernels, resting, reference, max_skip=1, n_neighbors=1, time_scale=1 / RATE)
    assert forward[1, 0, 0] == 0.0
    backward = table_of(
        "conditional", kernels, resting, reference[::-1], max_skip=1, n_neighbors=1, time_scale=1 / RATE
    )
    assert backward[1, 0, 0] == 2.0


def test_unit_speed_costs_nothing_where_the_reference_is_the_input_itself(kernels: Backend) -> None:
    poses = walk(np.random.default_rng(2), 30, 5)
    table = table_of("joint", kernels, poses, poses, max_skip=3, n_neighbors=1)
    np.testing.assert_array_equal(table[1:-1, 0, 0], 0.0)
    assert (table[2:-2, 1, 1] > 0).all()


def test_triples_outside_the_input_are_forbidden(kernels: Backend) -> None:
    rng = np.random.default_rng(2)
    table = table_of("joint", kernels, walk(rng, 6, 2), walk(rng, 9, 2), max_skip=4)
    for j in range(6):
        for a in range(1, 5):
            for b in range(1, 5):
                assert np.isfinite(table[j, a - 1, b - 1]) == (j - a >= 0 and j + b <= 5)


@pytest.mark.parametrize("kind", SCORES)
@pytest.mark.parametrize("weights", [(1.0, 1.0), (2.0, 2.0), (1.0, 4.0), (0.5, 3.0, 0.5)])
def test_several_references_with_weights(both: tuple[Backend, Backend], kind: str, weights: tuple[float, ...]) -> None:
    rng = np.random.default_rng(len(weights))
    y = walk(rng, 9, 3)
    references = [walk(rng, 4 + 3 * i, 3) for i in range(len(weights))]
    compiled, in_numpy = (
        table_of(kind, kernels, y, *references, max_skip=2, n_neighbors=4, weights=weights) for kernels in both
    )
    assert np.array_equal(compiled, in_numpy)
    wanted = literal_scores(
        kind, y, *references, weights=weights, max_skip=2, rate=RATE, time_scale=TIME_SCALE, n_neighbors=4
    )
    inside = np.isfinite(wanted)
    np.testing.assert_allclose(compiled[inside], wanted[inside], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("kind", SCORES)
def test_matched_frames_are_those_that_gave_the_score(both: tuple[Backend, Backend], kind: str) -> None:
    rng = np.random.default_rng(4)
    y = walk(rng, 20, 3)
    model = build_model([walk(rng, 15, 3), walk(rng, 9, 3)], rate=RATE, time_scale=TIME_SCALE, weights=(1.0, 2.0))
    scores = triple_scores(y, model, max_skip=3, score=kind, use=both[0])
    path = np.array([0, 2, 3, 6, 7, 9, 12, 15, 16, 17, 19])
    rows, distances = matched_frames(y, path, model, score=kind)
    assert rows.shape == distances.shape == (9, 3)
    np.testing.assert_allclose(distances.mean(axis=1), path_scores(scores, path), rtol=1e-12)
    assert (np.diff(distances, axis=1) >= 0).all()


@pytest.mark.parametrize("n_neighbors", [1, 3, 7])
def test_references_too_short_for_the_neighbors_are_refused(n_neighbors: int) -> None:
    def model_of(*lengths: int) -> None:
        poses = [walk(np.random.default_rng(0), length, 2) for length in lengths]
        build_model(poses, rate=RATE, time_scale=TIME_SCALE, n_neighbors=n_neighbors)

    model_of(n_neighbors + 2)
    model_of(2, n_neighbors + 2)
    model_of(*[3] * n_neighbors)
    for lengths in ([n_neighbors + 1], [2] * 9, [1, n_neighbors + 1], [3] * (n_neighbors - 1) + [2]):
        with pytest.raises(OptionError, match=f"n_neighbors={n_neighbors} needs at least {n_neighbors + 2}"):
            model_of(*lengths)


def test_poses_of_different_numbers_are_refused(kernels: Backend) -> None:
    with pytest.raises(OptionError, match="same numbers"):
        table_of("joint", kernels, np.zeros((9, 2)), np.zeros((9, 3)), max_skip=2)
    with pytest.raises(OptionError, match="same numbers"):
        table_of("joint", kernels, np.zeros((9, 2)), np.zeros((9, 2)), np.zeros((9, 3)), max_skip=2)


@pytest.mark.parametrize(
    "options",
    [
        {"max_skip": 0},
        {"max_skip": -1},
        {"max_skip": 256},
        {"n_neighbors": 0},
        {"weights": (0.0,)},
        {"weights": (1.0, 1.0)},
        {"time_scale": -0.1},
        {"time_scale": float("nan")},
        {"time_scale": float("inf")},
    ],
    ids=str,
)
def test_options_without_meaning_are_refused(kernels: Backend, options: dict[str, float]) -> None:
    with pytest.raises(OptionError):
        table_of("joint", kernels, np.zeros((9, 2)), np.zeros((9, 2)), **{"max_skip": 2, **options})


def test_a_score_that_is_not_there_is_refused(kernels: Backend) -> None:
    with pytest.raises(OptionError, match="joint, conditional"):
        table_of("mean", kernels, np.zeros((9, 2)), np.zeros((9, 2)), max_skip=2)


@pytest.mark.parametrize("data", DATA)
@pytest.mark.parametrize(
    ("n_input", "n_reference", "n_numbers", "max_skip"),
    [(70, 200, 9, 2), (9, 1300, 2, 3)],
    ids=["some_blocks", "more_blocks_than_a_chunk"],
)
def test_a_reference_put_in_order_gives_the_same_bits(
    both: tuple[Backend, Backend],
    monkeypatch: pytest.MonkeyPatch,
    data: str,
    n_input: int,
    n_reference: int,
    n_numbers: int,
    max_skip: int,
) -> None:
    # Long references are sorted into blocks near one another, projected, and whole blocks rejected.
    from retime.kernels import compiled

    monkeypatch.setattr(compiled, "_LONG", 64)
    y, z = DATA[data](np.random.default_rng(5), n_input, n_reference, n_numbers)
    in_numpy = table_of("joint", both[1], y, z, max_skip=max_skip, n_neighbors=2)
    for lost in (0.0, 0.3):
        monkeypatch.setattr(compiled, "_LOST_VARIANCE", lost)
        assert np.array_equal(table_of("joint", both[0], y, z, max_skip=max_skip, n_neighbors=2), in_numpy)
    # The benchmark's yardstick meets every frame.
    monkeypatch.setattr(compiled, "_LONG", 10**9)
    assert np.array_equal(table_of("joint", both[0], y, z, max_skip=max_skip, n_neighbors=2), in_numpy)


@pytest.mark.parametrize("kind", SCORES)
def test_ties_in_pose_are_told_before_anything_is_subtracted(kernels: Backend, kind: str) -> None:
    # 3.5625 is as far from 2.75 as from 4.375; less the mean of these, rounded, it is nearer to 4.375.
    reference = np.array([[1.0625], [0.875], [2.75], [4.375], [0.3125], [1.1875], [0.1]])
    resting = np.full((3, 1), 3.5625)
    wanted = literal_scores(kind, resting, reference, max_skip=1, rate=RATE, time_scale=TIME_SCALE, n_neighbors=1)
    table = table_of(kind, kernels, resting, reference, max_skip=1, n_neighbors=1)
    np.testing.assert_allclose(table[1, 0, 0], wanted[1, 0, 0], rtol=1e-12)


# Poses that are all alike, each of them a candidate for every triple. Prints the megabytes that scoring them takes.
ALIKE = """
import resource, sys
import numpy as np
from retime.search.score import build_model, triple_scores

unit = 1 << 20 if sys.platform == "darwin" else 1 << 10
poses = np.full((int(sys.argv[2]), 90), 0.1)
model = build_model([poses], rate=30, time_scale=0.1)
triple_scores(poses[:9], model, max_skip=1, score=sys.argv[1])
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
triple_scores(poses, model, max_skip=1, score=sys.argv[1])
print((resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / unit)
assert "numpy.ma" not in sys.modules
"""


@pytest.mark.parametrize(("kind", "n_frames"), [("joint", 400), ("conditional", 700)])
def test_memory_is_bounded_where_every_frame_is_as_near_as_the_nearest(
    kernels: Backend, kind: str, n_frames: int
) -> None:
    pytest.importorskip("resource", reason="no count of memory here")
    name = kernels.__name__.rpartition(".")[2].removesuffix("_backend")  # type: ignore[attr-defined]
    done = subprocess.run(
        [sys.executable, "-c", ALIKE, kind, str(n_frames)],
        env=os.environ | {"RETIME_BACKEND": name},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    # All pairs of features at once would be 350 MB, and several times that while they are measured.
    assert float(done.stdout) < 200


@pytest.mark.parametrize("wanted", ["99999999999", "9" * 5000, "256", "007"])
def test_any_number_of_threads_can_be_asked_for(
    both: tuple[Backend, Backend], monkeypatch: pytest.MonkeyPatch, wanted: str
) -> None:
    y = walk(np.random.default_rng(1), 40, 2)
    for kind in SCORES:
        monkeypatch.setenv("RETIME_THREADS", "1")
        alone = table_of(kind, both[0], y, y, max_skip=2)
        monkeypatch.setenv("RETIME_THREADS", wanted)
        assert np.array_equal(table_of(kind, both[0], y, y, max_skip=2), alone)


@pytest.mark.parametrize(
    ("wanted", "n_threads"), [("1", 1), ("007", 7), ("99999999999", 256), ("9" * 5000, 256), ("0", None), ("two", None)]
)
def test_threads_come_from_the_environment(
    both: tuple[Backend, Backend], monkeypatch: pytest.MonkeyPatch, wanted: str, n_threads: int | None
) -> None:
    from retime.kernels import compiled

    monkeypatch.delenv("RETIME_THREADS", raising=False)
    default = compiled.n_threads()
    assert default >= 1
    monkeypatch.setenv("RETIME_THREADS", wanted)
    assert compiled.n_threads() == (n_threads or default)
