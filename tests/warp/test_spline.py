"""The baselines."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retime.errors import InfeasibleWarpError, OptionError, RetimeWarning
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime
from retime.warp.spline import linear_warp, pchip_slopes, spline_warp


def drawn_keys(seed: int, *, forward: bool) -> list[Keytime]:
    rng = np.random.default_rng(seed)
    n_keys = int(rng.integers(2, 8))
    output_times = np.cumsum(10.0 ** rng.uniform(-1.5, 0.5, n_keys)) - 1
    changes = 10.0 ** rng.uniform(-2, 1, n_keys)
    if not forward:
        changes *= rng.choice([-1, 0, 1, 1], n_keys)
    input_times = np.cumsum(changes)
    return [
        Keytime(input_time=i, output_time=o) for o, i in zip(output_times.tolist(), input_times.tolist(), strict=True)
    ]


@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.booleans(), st.sampled_from([24000 / 1001, 30.0, 120.0]))
def test_both_meet_every_keytime_exactly_and_never_leave_its_neighbours(seed: int, forward: bool, rate: float) -> None:
    keys = drawn_keys(seed, forward=forward)
    shuffled = [keys[k] for k in np.random.default_rng(seed).permutation(len(keys))]
    for warp in (linear_warp(shuffled), spline_warp(shuffled, rate=rate)):
        assert warp.keytimes == tuple(keys)
        assert (warp.output_start, warp.output_end) == (keys[0].output_time, keys[-1].output_time)
        for key in keys:
            assert float(warp(key.output_time)) == key.input_time
        if forward:
            assert warp.monotone
            assert warp.smooth(0.2).monotone
        for before, after in itertools.pairwise(keys):
            inside = (warp.output_times >= before.output_time) & (warp.output_times <= after.output_time)
            moves = np.diff(warp.input_times[inside]) * np.sign(after.input_time - before.input_time)
            assert (moves >= 0).all()
            if before.input_time == after.input_time:
                assert (warp.input_times[inside] == before.input_time).all()


@settings(max_examples=100)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_without_tangents_it_is_scipys_pchip_to_the_bit(seed: int, forward: bool) -> None:
    from scipy.interpolate import PchipInterpolator

    keys = drawn_keys(seed, forward=forward)
    pchip = PchipInterpolator([key.output_time for key in keys], [key.input_time for key in keys])
    warp = spline_warp(keys, rate=60)
    inside = ~np.isin(warp.output_times, [key.output_time for key in keys])
    np.testing.assert_array_equal(warp.input_times[inside], pchip(warp.output_times[inside]))


@pytest.mark.parametrize(
    "input_times",
    [
        [0.0, 1.0],
        [1.0, 1.0],
        [0.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 1.0, 2.0],
        [0.0, 1.0, 0.0, 1.0],
        [0.0, 1e-300, 1.0, 1e9],
        [0.0, 5.0, 5.1, 5.1, 4.0, -100.0],
        [0.0, 0.01, -5.0],
        [0.0, 5e-324, 1.0],
    ],
    ids=str,
)
@pytest.mark.parametrize("widths", [1.0, 1e-3, 0.3])
def test_slopes_are_those_of_pchip(input_times: list[float], widths: float) -> None:
    from scipy.interpolate import PchipInterpolator

    output_times = np.cumsum(widths ** (1 + np.arange(len(input_times)) % 3))
    with np.errstate(over="ignore"):
        expected = PchipInterpolator(output_times, input_times)(output_times, 1)
    np.testing.assert_allclose(pchip_slopes(output_times, np.array(input_times)), expected, rtol=1e-12, atol=1e-12)


def test_linear_has_one_speed_a_span() -> None:
    warp = linear_warp(
        [
            Keytime(input_time=0, output_time=0),
            Keytime(input_time=3, output_time=1),
            Keytime(input_time=4, output_time=3),
        ]
    )
    assert warp.slopes.tolist() == [3.0, 0.5]
    assert warp.method == "linear"


def test_a_spline_through_two_keys_is_a_line() -> None:
    warp = spline_warp([Keytime(input_time=1, output_time=0), Keytime(input_time=5, output_time=2)], rate=30)
    np.testing.assert_allclose(warp.slopes, 2.0, rtol=1e-12)
    assert len(warp.output_times) == 61


def test_a_spline_changes_speed_without_a_jump() -> None:
    keys = [
        Keytime(input_time=0, output_time=0),
        Keytime(input_time=3, output_time=1),
        Keytime(input_time=4, output_time=3),
        Keytime(input_time=6, output_time=4),
    ]
    jump = [np.abs(np.diff(spline_warp(keys, rate=rate).slopes)).max() for rate in (100.0, 200.0, 400.0)]
    assert jump[0] < 0.2
    # Halved with the distance of the knots: a corner would stay.
    assert jump[1] < 0.6 * jump[0]
    assert jump[2] < 0.6 * jump[1]


@pytest.mark.parametrize("make", [linear_warp, spline_warp])
def test_keytimes_that_make_no_warp_are_refused(make: object) -> None:
    with pytest.raises(InfeasibleWarpError, match="at least two"):
        make([Keytime(input_time=0, output_time=0)])  # type: ignore[operator]
    with pytest.raises(InfeasibleWarpError, match="output time 1 s"):
        make(
            [
                Keytime(input_time=0, output_time=0),
                Keytime(input_time=0, output_time=1),
                Keytime(input_time=2, output_time=1),
            ]
        )  # type: ignore[operator]


# Tangents


def with_tangents(keys: list[Keytime], rng: np.random.Generator, most: float) -> list[Keytime]:
    """Give some keytimes a speed, at most so many times the slower mean speed beside them."""
    means = [abs((b.input_time - a.input_time) / (b.output_time - a.output_time)) for a, b in itertools.pairwise(keys)]
    chosen = []
    for i, key in enumerate(keys):
        beside = [mean for mean in means[max(0, i - 1) : i + 1] if mean]
        wanted = rng.random() < 0.7 and beside
        chosen.append(
            Keytime(
                input_time=key.input_time,
                output_time=key.output_time,
                speed=rng.uniform(0.01, most) * min(beside) if wanted else None,
            )
        )
    return chosen


def slopes_beside(warp: Warp, output_time: float) -> list[float]:
    """Speed of the piece before a knot and of the one after it; nan beyond the ends."""
    knot = int(np.flatnonzero(warp.output_times == output_time)[0])
    slopes = [np.nan, *warp.slopes.tolist(), np.nan]
    return slopes[knot : knot + 2]


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.booleans())
def test_tangents_are_obeyed_and_the_spline_never_turns(seed: int, forward: bool) -> None:
    rng = np.random.default_rng(seed)
    keys = with_tangents(drawn_keys(seed, forward=forward), rng, 2.99)
    warp = spline_warp(keys, rate=240.0)
    fine = spline_warp(keys, rate=20_000.0)
    for key in keys:
        assert float(warp(key.output_time)) == key.input_time
    for i, (before, after) in enumerate(itertools.pairwise(keys)):
        direction = np.sign(after.input_time - before.input_time)
        inside = (warp.output_times >= before.output_time) & (warp.output_times <= after.output_time)
        assert (np.diff(warp.input_times[inside]) * direction >= 0).all()
        for key, side in ((before, 1), (after, 0)):
            if key.speed is None or direction == 0:
                continue
            # The piece nearest to the key is short: what it plays at differs from the tangent by its length.
            mean = abs((after.input_time - before.input_time) / (after.output_time - before.output_time))
            share = 1 / 20_000 / (after.output_time - before.output_time)
            slope = slopes_beside(fine, key.output_time)[side]
            assert slope == pytest.approx(direction * key.speed, abs=20 * mean * share + 1e-6), (i, side)


def test_a_cubic_with_these_slopes_is_what_comes_out() -> None:
    from scipy.interpolate import CubicHermiteSpline

    keys = [
        Keytime(input_time=0, output_time=0, speed=0.5),
        Keytime(input_time=1.5, output_time=1, speed=2.0),
        Keytime(input_time=4.0, output_time=3, speed=1.0),
        Keytime(input_time=5.0, output_time=4, speed=2.5),
    ]
    warp = spline_warp(keys, rate=100)
    cubic = CubicHermiteSpline([0, 1, 3, 4], [0, 1.5, 4, 5], [0.5, 2.0, 1.0, 2.5])
    np.testing.assert_allclose(warp.input_times, cubic(warp.output_times), rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("keys", "obeyed"),
    [
        (
            [
                Keytime(input_time=0, output_time=0),
                Keytime(input_time=1, output_time=1, speed=3.0),
                Keytime(input_time=2, output_time=2),
            ],
            3.0,
        ),
        (
            [
                Keytime(input_time=0, output_time=0),
                Keytime(input_time=2, output_time=1, speed=4.0),
                Keytime(input_time=2.5, output_time=2),
            ],
            1.5,
        ),
        ([Keytime(input_time=0, output_time=0, speed=9.0), Keytime(input_time=2, output_time=1)], 6.0),
        (
            [
                Keytime(input_time=3, output_time=0),
                Keytime(input_time=2, output_time=1, speed=5.0),
                Keytime(input_time=0, output_time=2),
            ],
            -3.0,
        ),
    ],
    ids=["three_times_is_obeyed", "slower_side", "end", "backward"],
)
def test_a_tangent_beyond_three_times_the_mean_speed_is_limited_with_a_warning(
    keys: list[Keytime], obeyed: float
) -> None:
    (key,) = (key for key in keys if key.speed is not None)
    if abs(obeyed) == key.speed:
        warp = spline_warp(keys, rate=1e5)
    else:
        said = (
            rf"can't pass output time {key.output_time:g} s at speed {key.speed:g} .* passes at {abs(obeyed):g}, three"
        )
        with pytest.warns(RetimeWarning, match=said):
            warp = spline_warp(keys, rate=1e5)
    beside = [slope for slope in slopes_beside(warp, key.output_time) if not np.isnan(slope)]
    assert beside == pytest.approx([obeyed] * len(beside), rel=1e-3)
    assert (np.diff(warp.input_times) * np.sign(obeyed) >= 0).all()


def test_three_times_is_where_a_cubic_begins_to_turn_back() -> None:
    """The bound is not more careful than it must be: a cubic through the same key at 3.1 turns."""
    from scipy.interpolate import CubicHermiteSpline

    times = np.linspace(0, 1, 10_001)
    for slope, turns in ((3.0, False), (3.1, True)):
        cubic = CubicHermiteSpline([0, 1], [0, 1], [slope, slope])
        assert bool((np.diff(cubic(times)) < -1e-12).any()) == turns


def test_a_tangent_at_a_turn_holds_in_each_direction_and_a_hold_stays_at_rest() -> None:
    turn = spline_warp(
        [
            Keytime(input_time=0, output_time=0),
            Keytime(input_time=1, output_time=1, speed=0.8),
            Keytime(input_time=0, output_time=2),
        ],
        rate=1e4,
    )
    assert slopes_beside(turn, 1.0) == pytest.approx([0.8, -0.8], rel=1e-2)
    held = spline_warp(
        [
            Keytime(input_time=0, output_time=0),
            Keytime(input_time=1, output_time=1, speed=0.8),
            Keytime(input_time=1, output_time=2),
            Keytime(input_time=2, output_time=3),
        ],
        rate=1e4,
    )
    assert slopes_beside(held, 1.0) == pytest.approx([0.8, 0.0], rel=1e-2)
    assert (held(np.linspace(1, 2, 50)) == 1.0).all()


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf")])
def test_a_tangent_that_is_no_speed_is_refused(speed: float) -> None:
    with pytest.raises(OptionError, match="above 0"):
        spline_warp([Keytime(input_time=0, output_time=0), Keytime(input_time=1, output_time=1, speed=speed)])


def test_a_spline_of_more_knots_than_a_clip_has_frames_is_refused_before_any_is_made() -> None:
    with pytest.raises(OptionError, match=r"a spline over 1e\+06 s of output has 3e\+07 knots at 30 a second"):
        spline_warp([(0.0, 0.0), (1.0, 1e6)], rate=30)
