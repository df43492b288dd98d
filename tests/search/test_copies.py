"""Frames of a reference that are the same as others: left out, and never missed."""

from __future__ import annotations

import time

import numpy as np
import pytest

from retime.errors import RetimeWarning
from retime.kernels import Backend
from retime.motion.signal import Signal
from retime.search.score import (
    SCORES,
    Model,
    _maybe_repeated,
    build_model,
    matched_frames,
    triple_scores,
    without_copies,
)
from retime.search.session import Session


def with_pauses(rng: np.random.Generator, n_frames: int, n_numbers: int, pauses: int) -> np.ndarray:
    """Return poses that stand still now and then, some of them where they stood before."""
    places = rng.standard_normal((3, n_numbers))
    poses = rng.standard_normal((n_frames, n_numbers))
    for _ in range(pauses):
        start, length = rng.integers(0, n_frames), rng.integers(4, 12)
        poses[start : start + length] = places[rng.integers(0, 3)]
    return poses


@pytest.mark.parametrize("kind", SCORES)
@pytest.mark.parametrize("n_neighbors", [1, 3, 7])
def test_scores_and_matches_are_those_of_all_frames(kernels: Backend, kind: str, n_neighbors: int) -> None:
    rng = np.random.default_rng(n_neighbors)
    for weights in ((1.0, 1.0), (1.0, 2.0)):
        references = [with_pauses(rng, 40, 3, 6), with_pauses(rng, 30, 3, 6)]
        model = build_model(references, rate=30, time_scale=0.2, n_neighbors=n_neighbors, weights=weights)
        fewer = without_copies(model, n_neighbors)
        assert len(fewer.features) < len(model.features)
        poses = np.concatenate([with_pauses(rng, 20, 3, 3), references[0][:15]])
        tables, found = [], []
        for one in (model, fewer):
            tables.append(triple_scores(poses, one, max_skip=3, n_neighbors=n_neighbors, score=kind, use=kernels))
            path = np.array([0, 2, 3, 6, 7, 9, 12, 20, 21, 24])
            if max(np.diff(path)) > 3:
                path = np.array([0, 2, 3, 6, 7, 9, 12, 15, 18, 20, 21, 24])
            rows, distances = matched_frames(poses, path, one, n_neighbors=n_neighbors, score=kind)
            found.append((one.reference[rows], one.frame[rows], distances))
        np.testing.assert_array_equal(tables[0], tables[1])
        for of_all, of_fewer in zip(*found, strict=True):
            np.testing.assert_array_equal(of_all, of_fewer)


def test_each_row_stays_as_often_as_it_is_asked_for() -> None:
    poses = np.repeat([[0.0], [1.0], [3.0]], [9, 1, 9], axis=0)
    model = build_model([poses], rate=30, time_scale=0.2, n_neighbors=2)
    fewer = without_copies(model, 2)

    def counts(one: Model) -> list[int]:
        return sorted(np.unique(one.features, axis=0, return_counts=True)[1].tolist())

    assert max(counts(model)) == 7
    assert counts(fewer) == sorted(min(2, count) for count in counts(model))
    # The earliest ones, in their order.
    assert fewer.frame[:2].tolist() == [1, 2]
    assert np.all(np.diff(fewer.frame) > 0)


@pytest.mark.parametrize("seed", range(5))
def test_frames_that_repeat_are_those_whose_bits_do(seed: int) -> None:
    rng = np.random.default_rng(seed)
    references = [with_pauses(rng, 3000, 3, 6), with_pauses(rng, 40, 3, 3)]
    # A zero of another sign is another frame.
    references[0][5:9] = 0.0
    references[0][20:24] = -0.0
    model = build_model(references, rate=30, time_scale=0.2, weights=(1.0, 1.0 + seed % 2))
    rows = [b"".join(part[i].tobytes() for part in (model.poses, model.features, model.weights)) for i in range(3036)]
    expected = [rows.count(row) > 1 for row in rows]
    assert 0 < sum(expected) < len(rows)
    assert _maybe_repeated(model).tolist() == expected


def test_nothing_is_copied_where_all_frames_differ() -> None:
    model = build_model([np.arange(20.0)[:, None] ** 2 * np.sqrt(2)], rate=30, time_scale=0.2)
    assert without_copies(model, 3) is model


@pytest.mark.parametrize("length", ["65%", "150%"])
def test_standing_still_is_no_slower_than_moving(length: str) -> None:
    rng = np.random.default_rng(1)
    moving = rng.standard_normal((1800, 60)).cumsum(axis=0)
    seconds = {}
    names = tuple(f"c{i}" for i in range(60))
    with pytest.warns(RetimeWarning, match="still: nothing changes"):
        still = Session(Signal(names, np.zeros_like(moving) + moving[0], 30, name="still"))
    for name, session in (("moving", Session(Signal(names, moving, 30))), ("still", still)):
        begun = time.process_time()
        assert session.solve(length=length).path.optimal
        seconds[name] = time.process_time() - begun
    # Quadratic it was 20 to 100 times as long; labels of a path among equal ones take their time.
    assert seconds["still"] < 3 * seconds["moving"] + 0.5
