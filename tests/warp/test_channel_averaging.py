"""Averages of channels that are no lengths."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp

FAST = Warp([0.0, 1.0], [0.0, 3.9])


@given(st.integers(0, 10_000))
def test_an_angle_is_averaged_as_if_it_were_counted_on(seed: int) -> None:
    turn = np.cumsum(np.random.default_rng(seed).uniform(-60, 60, 40))
    told = apply_warp(Signal(("yaw",), ((turn + 180) % 360 - 180)[:, None], 10, kinds=["angle"]), FAST).values
    counted = apply_warp(Signal(("yaw",), turn[:, None], 10, kinds=["linear"]), FAST).values
    np.testing.assert_allclose((told - counted + 180) % 360 - 180, 0, atol=1e-9)
    assert np.abs(told).max() <= 180


@given(st.integers(0, 10_000))
def test_an_averaged_rotation_is_one_whatever_signs_it_came_with(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turn = np.cumsum(rng.uniform(-0.3, 0.3, 40))
    q = np.stack([np.cos(turn / 2), 0 * turn, np.sin(turn / 2), 0 * turn], axis=1)
    names = ("qw", "qx", "qy", "qz")
    found = [apply_warp(Signal(names, q * signs, 10), FAST).values for signs in (1.0, rng.choice([-1.0, 1.0], (40, 1)))]
    np.testing.assert_allclose(np.linalg.norm(found[0], axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(np.abs(np.einsum("fc,fc->f", *found)), 1, atol=1e-12)
    # About one axis the mean of small turns is the mean angle, nearly.
    angles = apply_warp(Signal(("a",), turn[:, None], 10, kinds=["linear"]), FAST).values[:, 0]
    away = 2 * np.arctan2(found[0][:, 2], found[0][:, 0]) - angles
    assert np.abs((away + np.pi) % (2 * np.pi) - np.pi).max() < 0.05


def test_labels_and_clocks_are_not_averaged() -> None:
    rng = np.random.default_rng(6)
    values = np.column_stack([rng.integers(0, 2, 40) * 7, np.arange(40) * 33.0])
    signal = Signal(("action_id", "timestamp"), values, 10, kinds=["label", "time:ms"])
    assert np.array_equal(apply_warp(signal, FAST).values, apply_warp(signal, FAST, average=False).values)
    assert set(apply_warp(signal, FAST).values[:, 0]) <= {0, 7}


def test_no_mean_holds_what_was_never_there() -> None:
    # On one side of the gap all is 0, on the other 100, which a bridge would join; angles and rotations alike.
    values = np.zeros((60, 7))
    values[30:, 0] = 100.0
    values[30:, 1] = 90.0
    values[:, 2], values[30:, 2:6] = 1.0, [0.0, 1.0, 0.0, 0.0]
    values[30:, 6] = 100.0
    values[27:33, :6] = np.nan
    kinds = ["linear", "angle:deg", *["quaternion"] * 4, "linear"]
    signal = Signal([f"c{i}" for i in range(7)], values, 30, kinds=kinds, gaps="keep")
    found = apply_warp(signal, Warp([0.0, 59 / 90], [0.0, 59 / 30])).values
    known = ~np.isnan(found[:, 0])
    assert 0 < known.sum() < len(found)
    for column, side in ((0, 100.0), (1, 90.0), (2, 1.0), (3, 1.0)):
        assert set(np.round(found[known, column], 9)) == {0.0, side}
    # A channel without the gap is averaged across the step.
    assert len(set(np.round(found[:, 6], 6))) > 2


def test_a_gap_grows_no_wider_by_averaging() -> None:
    values = np.column_stack([np.arange(40.0), np.arange(40.0)])
    values[10:20, 0] = np.nan
    signal = Signal(("x", "y"), values, 10, gaps="keep")
    found, plain = (apply_warp(signal, FAST, average=average).values for average in (True, False))
    assert np.array_equal(np.isnan(found), np.isnan(plain))
    assert 0 < np.isnan(found[:, 0]).sum() < len(found)
    known = ~np.isnan(found[:, 0])
    np.testing.assert_allclose(found[known, 0], found[known, 1], atol=1e-9)
