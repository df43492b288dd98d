"""Keytimes: as people write them, reduced to compression (§3.1), and met exactly by the way back."""

from __future__ import annotations

import itertools
import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from retime.errors import InfeasibleWarpError, OptionError
from retime.motion.signal import Signal
from retime.search.keytimes import as_keytimes, check_keytimes
from retime.search.path_curve import bounded, knots_of_path
from retime.search.reduction import Reduction, reduce_to_compression
from retime.search.wishes.kept import speed_bounds
from retime.warp.keytime import Keytime, keytime_of
from tests.reference import keytimes as literal
from tests.warp.motions import wandering_signal


def pairs(keytimes: tuple[Keytime, ...]) -> list[tuple[float, float]]:
    """(input time, output time), as keys are written."""
    return [(key.input_time, key.output_time) for key in keytimes]


# As people write them


@pytest.fixture
def clip() -> Signal:
    """Three seconds: 91 frames at 30 Hz."""
    return wandering_signal(91, 30)


def test_the_ends_are_added(clip: Signal) -> None:
    assert pairs(as_keytimes(clip, None, [])) == [(0, 0), (3, 3)]
    assert pairs(as_keytimes(clip, "50%", [])) == [(0, 0), (3, 45 / 30)]
    assert pairs(as_keytimes(clip, "2s", [])) == [(0, 0), (3, 59 / 30)]
    assert pairs(as_keytimes(clip, "61f", [])) == [(0, 0), (3, 2)]
    assert pairs(as_keytimes(clip, 61 / 30, [])) == [(0, 0), (3, 2)]


def test_without_a_length_the_input_plays_on_at_its_own_speed(clip: Signal) -> None:
    assert pairs(as_keytimes(clip, None, [(1.0, 2.0)])) == [(0, 0), (1, 2), (3, 4)]
    assert pairs(as_keytimes(clip, None, [(2.0, 1.0), (0.5, 2.5)])) == [(0, 0), (2, 1), (0.5, 2.5), (3, 5)]


def test_a_key_at_the_end_of_the_input_ends_the_output(clip: Signal) -> None:
    assert pairs(as_keytimes(clip, None, [(3.0, 1.5)])) == [(0, 0), (3, 1.5)]
    assert pairs(as_keytimes(clip, "46f", [(3.0, 1.5)])) == [(0, 0), (3, 1.5)]


def test_a_key_before_the_given_end_leaves_the_end_where_it_is(clip: Signal) -> None:
    assert pairs(as_keytimes(clip, "61f", [(3.0, 1.5)])) == [(0, 0), (3, 1.5), (3, 2)]


def test_a_key_at_the_start_replaces_the_start(clip: Signal) -> None:
    assert pairs(as_keytimes(clip, None, [(1.0, 0.0)])) == [(1, 0), (3, 2)]
    assert pairs(as_keytimes(clip, "61f", [(1.0, 0.0)])) == [(1, 0), (3, 2)]
    assert pairs(as_keytimes(clip, None, [(0.0, 0.0)])) == [(0, 0), (3, 3)]


def test_a_key_at_the_given_end_replaces_the_end(clip: Signal) -> None:
    assert pairs(as_keytimes(clip, "61f", [(2.5, 2.0)])) == [(0, 0), (2.5, 2)]


def test_keys_in_any_order_and_twice(clip: Signal) -> None:
    assert pairs(as_keytimes(clip, None, [(2.0, 2.0), (1.0, 0.5), (2.0, 2.0)])) == [(0, 0), (1, 0.5), (2, 2), (3, 3)]


def test_keys_in_frames_and_on_the_clock(clip: Signal) -> None:
    assert pairs(as_keytimes(clip, None, [("30f", "45f"), ("0:02", "0:02.5")])) == [
        (0, 0),
        (1, 1.5),
        (2, 2.5),
        (3, 3.5),
    ]
    ntsc = wandering_signal(91, Fraction(24000, 1001))
    assert pairs(as_keytimes(ntsc, None, [("24f", "24f")]))[1] == (1.001, 1.001)


def test_a_free_length_has_no_end_in_time(clip: Signal) -> None:
    assert pairs(as_keytimes(clip, "free", [(1.0, 2.0)])) == [(0, 0), (1, 2), (3, math.inf)]


def test_a_tangent_goes_with_its_key(clip: Signal) -> None:
    assert [key.speed for key in as_keytimes(clip, None, [(1.0, 2.0, "1/2"), (2.0, 3.0, None)])] == [
        None,
        0.5,
        None,
        None,
    ]


def test_a_clip_of_one_frame_has_no_timing_to_change() -> None:
    with pytest.raises(OptionError, match="one frame"):
        as_keytimes(wandering_signal(1, 30), "10f", [])


@pytest.mark.parametrize(
    ("length", "keys"),
    [
        pytest.param("31f", [(0.5, 2.0)], id="key_beyond_the_length"),
        pytest.param(None, [("half", 1.0)], id="no_time"),
        pytest.param(None, [(1.0, float("nan"))], id="nan"),
        pytest.param(None, [(1.0,)], id="one_number"),
        pytest.param(None, [(1.0, 2.0, 3.0, 4.0)], id="four_numbers"),
        pytest.param(None, [(None, 2.0)], id="no_input_time"),
        pytest.param(None, [(1.0, -0.5)], id="before_the_output_begins"),
        pytest.param("1f", [], id="one_frame"),
        pytest.param("0%", [], id="no_length"),
        pytest.param("half", [], id="not_a_length"),
        pytest.param(True, [], id="true"),
    ],
)
def test_what_can_not_be_read_is_refused(clip: Signal, length: object, keys: list[tuple[object, ...]]) -> None:
    with pytest.raises(OptionError):
        as_keytimes(clip, length, keys)  # type: ignore[arg-type]


# Which keytimes contradict


@pytest.mark.parametrize(
    ("keytimes", "says"),
    [
        pytest.param([(0, 0)], "at least two", id="one"),
        pytest.param([], "at least two", id="none"),
        pytest.param([(0, 0), (1, 1), (1, 2)], "two keytimes stand at output time 1 s", id="one_output_time_twice"),
        pytest.param([(0, 0), (1, 5.1)], "input time 5.1 s", id="beyond_the_input"),
        pytest.param([(0, -0.1), (1, 5)], "input time -0.1 s", id="before_the_input"),
        pytest.param([(0, 0), (1, math.nan)], "input time nan s", id="input_nan"),
        pytest.param([(0, 0), (math.nan, 1)], "nan", id="output_nan"),
        pytest.param([(-math.inf, 0), (1, 1)], "inf", id="output_minus_inf"),
        pytest.param([(0, 0), (1, math.inf)], "inf", id="input_inf"),
    ],
)
def test_keytimes_that_no_warp_meets_are_refused(keytimes: list[tuple[float, float]], says: str) -> None:
    with pytest.raises(InfeasibleWarpError, match=says):
        check_keytimes([Keytime(output_time=output, input_time=into) for output, into in keytimes], 5.0)


def test_keytimes_closer_than_an_analysis_frame_are_refused() -> None:
    keys = [
        Keytime(input_time=0, output_time=0),
        Keytime(input_time=1, output_time=1),
        Keytime(input_time=1 + 1 / 120, output_time=1 + 1 / 120),
        Keytime(input_time=2, output_time=2),
    ]
    with pytest.raises(InfeasibleWarpError, match="raise the rate") as caught:
        reduce_to_compression(keys, 2.0, rate=30)
    assert caught.value.span == 1
    assert reduce_to_compression(keys, 2.0, rate=120).positions == (0, 120, 121, 240)


@pytest.mark.parametrize("rate", [1.0, 8.0, 10.0, 24000 / 1001, 30.0, 120.0])
def test_keytimes_a_period_apart_are_never_too_close(rate: float) -> None:
    # Half-way between frames is where rounding could bring them together.
    for first in (0.5, 1.5, 2.5, 7.5):
        keys = [
            Keytime(input_time=0, output_time=0),
            *(Keytime(input_time=(first + k) / rate, output_time=(first + k) / rate) for k in range(4)),
            Keytime(input_time=99, output_time=99),
        ]
        positions = reduce_to_compression(keys, 99.0, rate=rate).positions
        assert np.diff(positions)[1:4].tolist() == [1, 1, 1]


@pytest.mark.parametrize("upsample", [0, -1])
def test_an_upsampling_below_one_is_refused(upsample: int) -> None:
    with pytest.raises(OptionError, match="upsample"):
        reduce_to_compression(
            [Keytime(input_time=0, output_time=0), Keytime(input_time=1, output_time=1)],
            1.0,
            rate=30,
            upsample=upsample,
        )


# Reduction to compression


def test_forward_held_and_backward_spans_become_one_increasing_sequence() -> None:
    keys = [
        Keytime(input_time=0, output_time=0),
        Keytime(input_time=0.2, output_time=0.3),
        Keytime(input_time=0.2, output_time=0.6),
        Keytime(input_time=0.0, output_time=0.7),
        Keytime(input_time=0.4, output_time=1.0),
    ]
    reduction = reduce_to_compression(keys, 0.4, rate=10)
    frames = np.round(reduction.input_times * 10, 9)
    assert frames.tolist() == [0, 1, 2, 2, 2, 2, 1, 0, 1, 2, 3, 4]
    assert reduction.positions == (0, 3, 6, 7, 10)
    assert reduction.frames == (0, 2, 5, 7, 11)
    assert reduction.anchors == ((0, 0), (3, 2), (6, 5), (7, 7), (10, 11))
    assert reduction.n_input == 12
    assert reduction.n_output == 11
    doubled = reduce_to_compression(keys, 0.4, rate=10, upsample=2)
    frames = np.round(doubled.input_times * 20, 9)
    assert frames.tolist() == [0, 1, 2, 3, 4, 4, 4, 4, 3, 2, 1, 0, 1, 2, 3, 4, 5, 6, 7, 8]
    assert doubled.positions == reduction.positions


def test_the_end_off_the_grid_stays_inside_the_input() -> None:
    # 1.27 s are 12.7 frames at 10 Hz: thirteen steps, the last one cut.
    reduction = reduce_to_compression(
        [Keytime(input_time=0, output_time=0), Keytime(input_time=1.27, output_time=1.27)], 1.27, rate=10
    )
    assert reduction.n_input == reduction.n_output == 14
    assert reduction.input_times[-2:].tolist() == [1.2, 1.27]


def test_an_output_that_does_not_start_at_zero() -> None:
    reduction = reduce_to_compression(
        [Keytime(input_time=1.0, output_time=2.0), Keytime(input_time=2.0, output_time=3.0)], 5.0, rate=10
    )
    assert reduction.positions == (0, 10)
    np.testing.assert_allclose(reduction.input_times, np.arange(10, 21) / 10)


@st.composite
def keytime_lists(draw: st.DrawFn) -> tuple[list[Keytime], float, float, int]:
    """Keytimes with forward, held and backward spans of speeds from 1/6 to 6; input_end, rate, upsample."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    rate = draw(st.sampled_from([10.0, 24000 / 1001, 30.0]))
    n_spans = draw(st.integers(1, 4))
    input_end = 20.0
    output_time, input_time = rng.uniform(-1, 1), rng.uniform(0, input_end)
    keys = [Keytime(input_time=input_time, output_time=output_time)]
    for _ in range(n_spans):
        # Long enough that rounding to analysis frames can't make a span infeasible.
        length = rng.uniform(0.5, 2.0)
        change = length * 6.0 ** rng.uniform(-1, 1) if rng.random() < 0.8 else 0.0
        if input_time + change > input_end or (input_time - change >= 0 and rng.random() < 0.5):
            change = -change
        if not 0 <= input_time + change <= input_end:
            change = 0.0
        output_time, input_time = output_time + length, input_time + change
        keys.append(Keytime(input_time=input_time, output_time=output_time))
    return keys, input_end, rate, 12


@settings(max_examples=60)
@given(keytime_lists())
def test_every_reduction(drawn: tuple[list[Keytime], float, float, int]) -> None:
    keys, input_end, rate, upsample = drawn
    reduction = reduce_to_compression(keys, input_end, rate=rate, upsample=upsample)
    assert reduction.positions[0] == reduction.frames[0] == 0
    assert reduction.frames[-1] == reduction.n_input - 1
    grid = 1 / (rate * upsample)
    for key, position, frame in zip(reduction.keytimes, reduction.positions, reduction.frames, strict=True):
        assert abs(position / rate - (key.output_time - keys[0].output_time)) <= 0.5 / rate + 1e-6
        assert abs(reduction.input_times[frame] - key.input_time) <= 0.5 * grid + 1e-6
    for span, (before, after) in enumerate(itertools.pairwise(reduction.keytimes)):
        first, last = reduction.frames[span], reduction.frames[span + 1]
        steps = np.diff(reduction.input_times[first : last + 1])
        if before.input_time == after.input_time:
            assert (steps == 0).all()
            assert last - first == reduction.positions[span + 1] - reduction.positions[span]
        else:
            assert (np.sign(steps) == np.sign(after.input_time - before.input_time)).all()
            assert (np.abs(steps) <= grid * (1 + 1e-9)).all()
    held = np.append(np.diff(reduction.input_times) == 0, False)
    assert np.array_equal(reduction.held, held)


def some_path(reduction: Reduction, seed: int) -> np.ndarray:
    """Any path through the keytimes."""
    rng = np.random.default_rng(seed)
    path = [0]
    for (p0, j0), (p1, j1) in itertools.pairwise(reduction.anchors):
        between = j0 + 1 + rng.choice(j1 - j0 - 1, p1 - p0 - 1, replace=False)
        path += [*sorted(between.tolist()), j1]
    return np.array(path)


@settings(max_examples=60)
@given(keytime_lists(), st.integers(0, 9))
def test_the_way_back_meets_every_keytime(drawn: tuple[list[Keytime], float, float, int], seed: int) -> None:
    keys, input_end, rate, _ = drawn
    reduction = reduce_to_compression(keys, input_end, rate=rate, upsample=7)
    path = some_path(reduction, seed)
    warp = knots_of_path(reduction, path)
    assert len(warp.output_times) == reduction.n_output
    assert (np.diff(warp.output_times) > 0).all()
    assert warp.keytimes == tuple(keys)
    for position, key in zip(reduction.positions, keys, strict=True):
        assert (warp.output_times[position], warp.input_times[position]) == (key.output_time, key.input_time)
        assert float(warp(key.output_time)) == key.input_time
        assert float(warp.smooth(0.3)(key.output_time)) == key.input_time
    for span, (before, after) in enumerate(itertools.pairwise(keys)):
        inside = slice(reduction.positions[span], reduction.positions[span + 1] + 1)
        moves = np.diff(warp.input_times[inside])
        assert (np.sign(moves) == np.sign(after.input_time - before.input_time)).all()
    if all(before.input_time < after.input_time for before, after in itertools.pairwise(keys)):
        assert warp.monotone
        assert warp.smooth(0.3).monotone


@settings(max_examples=150)
@given(keytime_lists(), st.integers(0, 9), st.sampled_from([(0.0, math.inf), (0.3, math.inf), (0.0, 2.5)]))
def test_no_step_is_driven_beyond_its_bounds(
    drawn: tuple[list[Keytime], float, float, int], seed: int, limits: tuple[float, float]
) -> None:
    keys, input_end, rate, upsample = drawn
    reduction = reduce_to_compression(keys, input_end, rate=rate, upsample=upsample)
    path = some_path(reduction, seed)
    max_skip = int(np.diff(path).max())
    bounds = speed_bounds(reduction, path, max_skip, slowest=limits[0], fastest=limits[1])
    warp = knots_of_path(reduction, path, bounds=bounds)
    smooth = warp.smooth(0.3, at=np.arange(warp.output_start, warp.output_end, 1 / 97))
    for span, (before, after) in enumerate(itertools.pairwise(keys)):
        inside = slice(reduction.positions[span], reduction.positions[span + 1])
        speeds = np.abs(warp.slopes[inside])
        mean = abs(after.input_time - before.input_time) / (after.output_time - before.output_time)
        if reduction.still[span]:
            np.testing.assert_allclose(speeds, mean, atol=1e-9)
            continue
        slowest = min(max(limits[0], 1 / upsample), mean)
        fastest = max(min(limits[1], max_skip / upsample), mean)
        assert slowest * (1 - 1e-9) <= speeds.min()
        assert speeds.max() <= fastest * (1 + 1e-9)
        between = (smooth.output_times[:-1] >= before.output_time) & (smooth.output_times[1:] <= after.output_time)
        assert (np.abs(smooth.slopes[between]) <= fastest * (1 + 1e-6)).all()
        assert (np.abs(smooth.slopes[between]) >= slowest * (1 - 1e-6)).all()
        assert (warp(before.output_time), warp(after.output_time)) == (before.input_time, after.input_time)


@settings(max_examples=100)
@given(st.integers(0, 2**32 - 1))
def test_what_a_step_at_its_bound_can_not_take_the_others_do(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 12))
    spacing, speeds = rng.uniform(0.5, 2.0, n), rng.uniform(0.2, 5.0, n)
    low, high = np.minimum(rng.uniform(0.1, 3.0, n), speeds), np.maximum(rng.uniform(0.1, 6.0, n), speeds)
    choice = rng.random(n) < 0.7
    moved = spacing * speeds
    share = rng.uniform(-0.2, 1.2)
    least, most = (float((spacing * np.where(choice, bound, speeds)).sum()) for bound in (low, high))
    change = least + share * (most - least)
    scaled = np.where(choice, moved * (1 + (change - moved.sum()) / max(moved[choice].sum(), 1e-9)), moved)
    assume((scaled[choice] > 0).all())
    # Bounds that leave no room at all are met by any share of it.
    assume(not choice.any() or most - least > 1e-6)
    found = bounded(spacing, scaled, change, choice, low, high)
    if not choice.any():
        assert found is not None
        np.testing.assert_array_equal(found, scaled)
    elif not 0 <= share <= 1:
        assert found is None
    else:
        assert found is not None
        np.testing.assert_allclose(found, literal.bounded(spacing, scaled, change, choice, low, high), rtol=1e-9)
        assert found.sum() == pytest.approx(change, rel=1e-12)
        np.testing.assert_array_equal(found[~choice], scaled[~choice])


def test_steps_at_max_skip_stay_there_and_unit_speed_too() -> None:
    # Six steps of 4, and four that play at 1 and 2: the output is a third of a period shorter than its ten steps.
    keys = [Keytime(input_time=0, output_time=0), Keytime(input_time=3.0, output_time=0.967)]
    reduction = reduce_to_compression(keys, 3.0, rate=10)
    path = np.array([0, 4, 8, 12, 13, 14, 16, 18, 22, 26, 30])
    bounds = speed_bounds(reduction, path, 4)
    assert knots_of_path(reduction, path).slopes.max() > 4.1
    warp = knots_of_path(reduction, path, bounds=bounds)
    assert warp.slopes.max() == pytest.approx(4.0, abs=1e-12)
    np.testing.assert_allclose(warp.slopes[3:5], 1.0, rtol=0, atol=1e-12)
    # All of it at the fastest there is, in a hair less time than that takes: the mean is the bound.
    keys = [Keytime(input_time=0, output_time=0), Keytime(input_time=4.0, output_time=0.99)]
    close = reduce_to_compression(keys, 4.0, rate=10)
    path = np.arange(0, 41, 4)
    warp = knots_of_path(close, path, bounds=speed_bounds(close, path, 4))
    np.testing.assert_allclose(warp.slopes, 4.0 / 0.99, rtol=1e-12)


def test_unit_speed_stays_unit_speed_where_other_steps_can_take_the_rest() -> None:
    # 12.7 input frames shown in 9.6 periods: the ends lie off the grid.
    keys = [Keytime(input_time=0, output_time=0), Keytime(input_time=1.27, output_time=0.96)]
    reduction = reduce_to_compression(keys, 1.27, rate=10)
    path = np.array([0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 13])
    warp = knots_of_path(reduction, path)
    np.testing.assert_allclose(warp.slopes[:6], 1.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.diff(warp.output_times)[:6], 0.1, rtol=0, atol=1e-15)
    assert (warp.slopes[6:9] > 1.5).all()
    assert warp.slopes[9] == pytest.approx(1.0, abs=1e-12)


def test_where_all_steps_play_at_unit_speed_all_share_the_rest() -> None:
    keys = [Keytime(input_time=0, output_time=0), Keytime(input_time=1.01, output_time=1.04)]
    reduction = reduce_to_compression(keys, 2.0, rate=10)
    warp = knots_of_path(reduction, np.arange(11))
    np.testing.assert_allclose(warp.slopes, 1.01 / 1.04, rtol=1e-12)


@pytest.mark.parametrize("rate", [10.0, 24000 / 1001, 30.0, 120.0])
@pytest.mark.parametrize("input_end", [1.0, 1.27, 3.3333, 100 * 1001 / 24000])
@pytest.mark.parametrize("upsample", [1, 4])
def test_as_long_as_the_input_can_be_the_identity(rate: float, input_end: float, upsample: int) -> None:
    reduction = reduce_to_compression(
        [keytime_of((0, 0)), keytime_of((input_end, input_end))],
        input_end,
        rate=rate,
        upsample=upsample,
    )
    n_steps = reduction.n_output - 1
    path = np.minimum(np.arange(n_steps + 1) * upsample, reduction.n_input - 1)
    path[-1] = reduction.n_input - 1
    warp = knots_of_path(reduction, path)
    assert warp.output_end == input_end
    if n_steps * upsample == reduction.n_input - 1:
        np.testing.assert_allclose(warp.input_times, warp.output_times, rtol=0, atol=1e-12)
