"""Influence: between the guided warp and the spline, by a number or by a curve over output time (§5)."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from retime.motion.signal import Signal
from retime.search.guided import guided_warp
from retime.search.promises import broken_promises
from retime.search.session import GuidedWarp, Session
from retime.warp.blend import blend
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime
from retime.warp.spline import spline_warp

RATE = 60
# Name of the problem -> its keys: forward, with a tangent, with a hold and a backward span.
PROBLEMS: dict[str, list[tuple[float, ...]]] = {
    "one": [(1.2, 0.7)],
    "tangent": [(1.2, 0.9, 0.5), (2.0, 1.4)],
    "mixed": [(1.5, 1.2), (1.5, 1.5), (0.8, 2.0)],
}


@cache
def session() -> Session:
    rng = np.random.default_rng(2)
    t = np.arange(3 * RATE + 1)[:, None] / RATE
    values = np.sin(t * rng.uniform(1, 4, 3) + rng.uniform(0, 6, 3)) + 0.4 * t * rng.uniform(-1, 1, 3)
    return Session(Signal(("x", "y", "z"), values, Fraction(RATE), name="curve"))


@cache
def ends(problem: str) -> tuple[GuidedWarp, Warp]:
    """The guided warp alone, and the spline through the same keytimes.

    Beside a tangent that is straight for a moment, so that its speed is there to the last digit.
    """
    result = session().solve(keys=PROBLEMS[problem], length="95%" if problem != "mixed" else None)
    spline = spline_warp(result.reduction.keytimes, rate=float(RATE))
    if problem == "tangent":
        straight = mixed(problem, 0.0)
        times = np.linspace(0, spline.output_end, 997)
        np.testing.assert_allclose(straight(times), spline(times), rtol=0, atol=2e-3)
        spline = straight
    return result, spline


def mixed(problem: str, influence: object) -> Warp:
    length = "95%" if problem != "mixed" else None
    return session().solve(keys=PROBLEMS[problem], length=length, influence=influence).warp  # type: ignore[arg-type]


def goes_one_way(warp: Warp) -> bool:
    """Between two keytimes it never turns, and it rests in a hold."""
    for before, after in itertools.pairwise(warp.keytimes):
        inside = (warp.output_times >= before.output_time) & (warp.output_times <= after.output_time)
        moves = np.diff(warp.input_times[inside])
        direction = np.sign(after.input_time - before.input_time)
        if not ((moves * direction >= 0).all() if direction else (moves == 0).all()):
            return False
    return True


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize("as_curve", [False, True], ids=["number", "curve"])
def test_influence_0_is_the_spline_and_1_the_guided_warp_bit_for_bit(problem: str, as_curve: bool) -> None:
    result, spline = ends(problem)
    for share, wanted in ((0.0, spline), (1.0, result.warp)):
        warp = mixed(problem, [(0.0, share), (1.0, share)] if as_curve else share)
        # A curve has the knots of both; where two are a rounding error apart they are one, and its last bit may differ.
        last_bit = 4e-16 if as_curve else 0.0
        np.testing.assert_allclose(warp(wanted.output_times), wanted.input_times, rtol=last_bit, atol=0)
        # Between the knots, too: those that the other one brings lie on the line.
        times = np.linspace(0, wanted.output_end, 997)
        np.testing.assert_allclose(warp(times), wanted(times), rtol=0, atol=1e-12)
        assert (warp.method, warp.keytimes) == ("guided", result.reduction.keytimes)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_half_is_the_mean_of_both_at_every_time(problem: str) -> None:
    result, spline = ends(problem)
    times = np.linspace(0, spline.output_end, 997)
    np.testing.assert_allclose(mixed(problem, 0.5)(times), (spline(times) + result.warp(times)) / 2, atol=1e-12)


@pytest.mark.parametrize("influence", [0.0, 0.3, 0.5, [(0.0, 0.0), (1.0, 1.0), (1.2, 0.1)]])
def test_a_tangent_stays_whatever_the_influence(influence: object) -> None:
    keys = session().solve(keys=PROBLEMS["tangent"], length="95%").reduction.keytimes
    assert broken_promises(mixed("tangent", influence), keys) == ()


CURVES = st.lists(
    st.tuples(st.floats(0, 3), st.sampled_from([0.0, 0.05, 0.5, 1.0]) | st.floats(0, 1)), min_size=1, max_size=7
)


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(list(PROBLEMS)), CURVES)
def test_any_curve_gives_a_warp_that_meets_its_keys_and_never_turns(
    problem: str, rows: list[tuple[float, float]]
) -> None:
    curve = sorted(dict(rows).items())
    result, spline = ends(problem)
    warp = mixed(problem, curve)
    for key in result.reduction.keytimes:
        assert float(warp(key.output_time)) == key.input_time
    assert goes_one_way(warp)
    # Nowhere beyond the two that are mixed.
    low, high = np.sort([spline(warp.output_times), result.warp(warp.output_times)], axis=0)
    assert (warp.input_times >= low - 1e-12).all()
    assert (warp.input_times <= high + 1e-12).all()


@pytest.mark.parametrize("problem", ["one", "tangent"])
def test_a_curve_that_changes_slowly_is_taken_as_it_is(problem: str) -> None:
    result, spline = ends(problem)
    curve = [(0.0, 0.3), (result.warp.output_end, 0.6)]
    times = mixed(problem, curve).output_times
    share = np.interp(times, *np.transpose(curve))
    wanted = (1 - share) * spline(times) + share * result.warp(times)
    assert (np.diff(wanted) > 0).all()
    np.testing.assert_allclose(mixed(problem, curve).input_times, wanted, rtol=0, atol=1e-12)


# Two warps that are far apart in the middle; a weight that changes quickly there would turn the mix back.
EARLY = Warp(
    [0.0, 1.0, 4.0, 5.0, 9.0, 10.0],
    [0.0, 4.0, 4.6, 5.0, 6.0, 10.0],
    (
        Keytime(input_time=0, output_time=0),
        Keytime(input_time=5, output_time=5),
        Keytime(input_time=10, output_time=10),
    ),
)
LATE = Warp([0.0, 1.0, 4.0, 5.0, 9.0, 10.0], [0.0, 0.2, 1.0, 5.0, 9.5, 10.0], EARLY.keytimes)


def by_hand(scale: float, share: Callable[[np.ndarray], np.ndarray], times: np.ndarray) -> np.ndarray:
    """The mix with the changes of its weight scaled about their mean over the knots."""
    weight = share(times)
    middle = weight.mean()
    return EARLY(times) + (middle + scale * (weight - middle)) * (LATE(times) - EARLY(times))


@pytest.mark.parametrize("jump", [0.02, 0.2, 0.5])
def test_a_curve_that_would_turn_back_is_flattened_as_little_as_will_do(jump: float) -> None:
    curve = np.array([[2.0, 0.0], [2.0 + jump, 1.0]])
    warp = blend(EARLY, LATE, curve)
    assert warp.monotone
    assert float(warp(5.0)) == 5.0

    first = warp.output_times <= 5.0
    times = warp.output_times[first]
    plain = by_hand(1.0, lambda t: np.interp(t, *curve.T), times)
    assert (np.diff(plain) < 0).any()
    # Of all scales tried, the largest that does not turn back.
    kept = [
        s for s in np.linspace(0, 1, 4001) if (np.diff(by_hand(s, lambda t: np.interp(t, *curve.T), times)) >= 0).all()
    ]
    assert 0 < max(kept) < 1
    found = by_hand(max(kept), lambda t: np.interp(t, *curve.T), times)
    np.testing.assert_allclose(warp.input_times[first], found, rtol=0, atol=2e-3)
    # After the key the weight is 1 and nothing needs to give way: there it is the second one.
    np.testing.assert_array_equal(warp.input_times[~first], LATE(warp.output_times[~first]))


def test_a_curve_is_flattened_in_a_backward_span_too() -> None:
    back = [
        Warp(
            w.output_times,
            10.0 - w.input_times,
            tuple(Keytime(input_time=10.0 - k.input_time, output_time=k.output_time) for k in w.keytimes),
        )
        for w in (EARLY, LATE)
    ]
    curve = [(2.0, 0.0), (2.1, 1.0)]
    warp = blend(*back, curve)
    assert (np.diff(warp.input_times) <= 0).all()
    forward = blend(EARLY, LATE, curve)
    np.testing.assert_allclose(10.0 - warp.input_times, forward.input_times, rtol=0, atol=1e-9)


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_mixes_of_monotone_warps_by_any_curve_are_monotone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.linspace(0, 6, 25)
    steps = 10.0 ** rng.uniform(-3, 1, (2, 24))
    one, other = (np.concatenate([[0], np.cumsum(row / row.sum() * 5)]) for row in steps)
    assume(np.diff(one).min() > 1e-9)
    assume(np.diff(other).min() > 1e-9)
    curve = np.column_stack([np.sort(rng.choice(np.linspace(0, 6, 301), 9, replace=False)), rng.random(9).round()])
    mix = blend(Warp(times, one), Warp(times, other), curve)
    assert (np.diff(mix.input_times) >= 0).all()
    assert mix.input_times[[0, -1]].tolist() == pytest.approx([0.0, 5.0], abs=1e-12)


def test_a_free_length_and_a_loop_can_be_mixed() -> None:
    free = guided_warp(session().motion, length="free", influence=[(0.0, 0.0), (1.0, 1.0)], keys=[(1.0, 1.0)]).warp
    assert goes_one_way(free)
    assert float(free(1.0)) == 1.0
    loop = session().solve(length="80%", loop=True, influence=0.5).warp
    assert loop.slopes[0] == pytest.approx(loop.slopes[-1], rel=1e-9)
