from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from retime.motion.channels import FULL_TURN, ChannelKind
from retime.motion.signal import Signal
from tests.reference import channels as literal

PLAIN = ["linear", "angle:deg", "angle:rad", "label", "time:ms"]


@given(st.integers(0, 10_000), st.lists(st.sampled_from(PLAIN), min_size=1, max_size=5), st.integers(1, 12))
def test_every_kind_is_shown_as_one_would_say_it(seed: int, kinds: list[str], n_frames: int) -> None:
    rng = np.random.default_rng(seed)
    given_kinds = [ChannelKind.parse(kind) for kind in kinds]
    turns = np.array([FULL_TURN.get(kind.unit, 10.0) for kind in given_kinds])
    values = rng.uniform(-2, 2, (n_frames, len(kinds))) * turns * rng.choice([0.1, 1.0])
    signal = Signal([f"c{i}" for i in range(len(kinds))], values, 10, kinds=given_kinds)
    places = np.concatenate([rng.uniform(-1, n_frames, 9), rng.integers(0, n_frames, 3)])
    found = signal.at(places / 10).values
    for column, kind in enumerate(given_kinds):
        expected = np.array([literal.shown(values[:, column].tolist(), kind, place) for place in places])
        away = found[:, column] - expected
        if kind.kind == "angle":
            away -= turns[column] * np.round(away / turns[column])
        np.testing.assert_allclose(away, 0, atol=1e-7)
    whole = signal.at(np.arange(n_frames) / 10)
    assert np.array_equal(whole.values, values)
    assert whole.kinds == signal.kinds


@pytest.mark.parametrize(("low", "high"), [(-180, 180), (0, 360)])
def test_angles_keep_to_the_turn_that_they_came_in(low: float, high: float) -> None:
    yaw = (np.arange(200) * 7.3 - low) % 360 + low
    shown = Signal(("yaw",), yaw[:, None], 10).at(np.linspace(0, 19.9, 777)).values[:, 0]
    assert shown.min() >= low
    assert shown.max() <= high
    steps = np.abs((np.diff(shown) + 180) % 360 - 180)
    assert steps.max() <= 7.3 + 1e-9


def test_angles_counted_on_and_on_stay_so() -> None:
    shown = Signal(("yaw",), [[700.0], [730.0]], 1, kinds=["angle"]).at([0.5])
    assert shown.values.tolist() == [[715.0]]


@given(st.integers(0, 10_000))
def test_rotations_turn_evenly_whatever_their_signs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(8, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    order = rng.permutation(5)
    names = np.array(["qw", "qx", "qy", "qz", "px"])[order]
    values = np.column_stack([q, np.arange(8.0)])[:, order]
    places = np.sort(np.concatenate([rng.uniform(0, 7, 20), np.arange(8)]))
    shown = Signal(tuple(names), values, 10).at(places / 10)
    back = shown.values[:, np.argsort(order)]
    found, before = back[:, :4], np.floor(places).astype(int)
    for one, place, start in zip(found, places, before, strict=True):
        expected = literal.turned(q[start].tolist(), q[min(start + 1, 7)].tolist(), place - start)
        assert abs(np.dot(one, expected)) == pytest.approx(1, abs=1e-9)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1, atol=1e-9)
    assert np.all(np.einsum("fc,fc->f", found[1:], found[:-1]) >= 0)
    np.testing.assert_allclose(back[:, 4], places, atol=1e-9)


@given(st.integers(0, 10_000))
def test_each_event_is_shown_once(seed: int) -> None:
    rng = np.random.default_rng(seed)
    column = np.zeros(30)
    column[rng.choice(30, 3, replace=False)] = [1, 2, 3]
    n_output = int(rng.integers(2, 90))
    # No output frame is as near to an event as its neighbour.
    places = np.sort(rng.uniform(0, 29, n_output))
    signal = Signal(("events",), column[:, None], 10, kinds=["event"])
    found = signal.at(places / 10).values[:, 0]
    assert found.tolist() == literal.events_forward(column.tolist(), places.tolist())
    again = signal.at(places[::-1] / 10).values[::-1, 0]
    assert set(np.flatnonzero(again)) == set(np.flatnonzero(found))


def test_a_hold_has_an_event_once() -> None:
    signal = Signal(("e",), np.eye(5)[2][:, None], 1, kinds=["event"])
    assert signal.at([1, 2, 2, 2, 3]).values[:, 0].tolist() == [0, 1, 0, 0, 0]
    assert signal.at([0, 4]).values[:, 0].tolist() == [1, 0]
    assert signal.at([2]).values[:, 0].tolist() == [1]
