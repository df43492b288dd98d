"""Warp: evaluation, inverse and composition against their definitions; equality; files."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings

from retime.errors import FormatError, InfeasibleWarpError, OptionError, OutputExistsError
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime
from tests.reference import curve as literal
from tests.warp.drawn import some_times, warps


@settings(max_examples=40)
@given(warps(forward=False))
def test_evaluate_and_speed(warp: Warp) -> None:
    o, i = warp.output_times.tolist(), warp.input_times.tolist()
    for time in some_times(warp):
        assert float(warp(time)) == pytest.approx(literal.evaluate(o, i, time), rel=1e-12, abs=1e-12)
        assert float(warp.speed(time)) == pytest.approx(literal.speed(o, i, min(max(time, o[0]), o[-1])), rel=1e-12)
    assert warp(warp.output_times).tolist() == i
    assert warp(warp.output_times.reshape(-1, 1)).shape == (len(o), 1)


@settings(max_examples=40)
@given(warps())
def test_inverse_undoes_the_warp(warp: Warp) -> None:
    inverse = warp.inverse()
    o, i = warp.output_times.tolist(), warp.input_times.tolist()
    for time in np.linspace(i[0], i[-1], 5):
        assert float(inverse(time)) == pytest.approx(literal.inverse_at(o, i, time), abs=1e-9)
    assert inverse(warp.input_times).tolist() == o
    again = inverse.inverse()
    assert np.array_equal(again.output_times, warp.output_times)
    assert np.array_equal(again.input_times, warp.input_times)
    assert again.keytimes == warp.keytimes


@pytest.mark.parametrize("input_times", [[0.0, 1.0, 1.0], [0.0, 1.0, 0.5], [1.0, 0.0, -1.0]])
def test_a_warp_that_holds_or_turns_back_has_no_inverse(input_times: list[float]) -> None:
    warp = Warp([0.0, 1.0, 2.0], input_times)
    assert not warp.monotone
    with pytest.raises(InfeasibleWarpError, match="no inverse"):
        warp.inverse()


@settings(max_examples=40)
@given(warps(forward=False), warps(forward=False))
def test_compose_applies_the_first_then_the_other(warp: Warp, first: Warp) -> None:
    both = warp.compose(first)
    assert both.output_start == first.output_start
    assert both.output_end == first.output_end
    for time in [*some_times(both), *first.output_times]:
        inner = literal.evaluate(first.output_times.tolist(), first.input_times.tolist(), time)
        wanted = literal.evaluate(warp.output_times.tolist(), warp.input_times.tolist(), inner)
        assert float(both(time)) == pytest.approx(wanted, rel=1e-9, abs=1e-9)
    assert both(first.output_times).tolist() == warp(first(first.output_times)).tolist()


@settings(max_examples=40)
@given(warps())
def test_compose_with_the_inverse_is_the_identity(warp: Warp) -> None:
    same = warp.inverse().compose(warp)
    np.testing.assert_allclose(same(warp.output_times), warp.output_times, rtol=0, atol=1e-12)
    # Every corner of one is a corner of the other: the result has no knots a rounding error apart.
    assert len(same.output_times) == len(warp.output_times)
    assert np.diff(same.output_times).min() > 1e-9


@pytest.mark.parametrize(
    ("output_times", "input_times", "says"),
    [
        pytest.param([0.0], [0.0], "two or more", id="one_knot"),
        pytest.param([0.0, 1.0], [0.0], "two or more", id="lengths_differ"),
        pytest.param([[0.0, 1.0]], [[0.0, 1.0]], "two or more", id="two_dimensions"),
        pytest.param([0.0, 0.0], [0.0, 1.0], "knot 1", id="same_time_twice"),
        pytest.param([0.0, 2.0, 1.0], [0.0, 1.0, 2.0], "knot 2", id="times_decrease"),
        pytest.param([0.0, np.nan], [0.0, 1.0], "knot 1 .* not finite", id="nan_output"),
        pytest.param([0.0, 1.0], [0.0, np.inf], "knot 1 .* not finite", id="inf_input"),
        pytest.param([-1e308, 1.5e308, 1.4e308], [0.0, 1.0, 2.0], "knot 2", id="differences_overflow"),
    ],
)
def test_numbers_that_make_no_warp_are_refused(output_times: object, input_times: object, says: str) -> None:
    with pytest.raises(OptionError, match=says):
        Warp(output_times, input_times)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "key", [Keytime(input_time=0.0, output_time=float("nan")), Keytime(input_time=float("inf"), output_time=0.0)]
)
def test_keytimes_that_are_not_finite_are_refused(key: Keytime) -> None:
    with pytest.raises(OptionError, match="keytime"):
        Warp([0, 1], [0, 1], (key,))


def test_a_warp_can_not_be_changed_from_outside() -> None:
    output_times = np.array([0.0, 1.0])
    warp = Warp(output_times, [0.0, 1.0])
    output_times[0] = 5.0
    assert warp.output_start == 0.0
    with pytest.raises(ValueError, match="read-only"):
        warp.input_times[0] = 1.0


@settings(max_examples=40)
@given(warps(forward=False, keys=3))
def test_equal_warps_are_equal_and_hash_alike(warp: Warp) -> None:
    again = Warp.from_json(warp.to_json())
    assert again == warp
    assert hash(again) == hash(warp)
    assert {warp: "found"}[again] == "found"


def test_zeros_of_either_sign_are_equal() -> None:
    a, b = Warp([0.0, 1.0], [0.0, 1.0]), Warp([-0.0, 1.0], [-0.0, 1.0])
    assert a == b
    assert hash(a) == hash(b)


def test_whatever_differs_makes_warps_different() -> None:
    key = Keytime(input_time=2.0, output_time=1.0)
    warp = Warp([0.0, 1.0, 2.0], [0.0, 2.0, 3.0], (key,), "guided", "walk")
    others = [
        replace(warp, output_times=[0.0, 1.0, 2.5]),
        replace(warp, input_times=[0.0, 2.0, 3.5]),
        replace(warp, output_times=[0.0, 2.0], input_times=[0.0, 3.0]),
        replace(warp, keytimes=()),
        replace(warp, keytimes=(replace(key, speed=1.0),)),
        replace(warp, method="linear"),
        replace(warp, name="run"),
    ]
    assert [other == warp for other in others] == [False] * len(others)
    assert len({warp, *others}) == len(others) + 1
    assert warp != "a warp"


def test_a_saved_warp_is_loaded_equal_and_not_written_over(tmp_path) -> None:
    warp = Warp([0.0, 1.0], [0.0, 2.0], [(2.0, 1.0, 2.0)], "linear", "walk")
    warp.save(tmp_path / "walk.json")
    assert Warp.load(tmp_path / "walk.json") == warp
    assert Warp.load(str(tmp_path / "walk.json")) == warp
    with pytest.raises(OutputExistsError):
        warp.save(tmp_path / "walk.json")
    replace(warp, name="run").save(tmp_path / "walk.json", overwrite=True)
    assert Warp.load(tmp_path / "walk.json").name == "run"
    with pytest.raises(FormatError, match=r"walk\.json: the file has \d+ bytes, the limit is 5"):
        Warp.load(tmp_path / "walk.json", most_bytes=5)
    (tmp_path / "none.json").write_text("[\n1,")
    with pytest.raises(FormatError, match=r"none\.json:2:3: not JSON"):
        Warp.load(tmp_path / "none.json")


def test_the_span_of_the_output_is_no_length_of_a_clip() -> None:
    warp = Warp([1.0, 1.0 + 479 / 60], [0.0, 4.0])
    assert warp.output_span == pytest.approx(479 / 60)
    assert (warp.count_frames(60), warp.count_frames(Fraction(30000, 1001))) == (480, 240)
    assert Warp([0.0, 1e-3], [0.0, 1.0]).count_frames(30) == 1
    with pytest.warns(DeprecationWarning, match=r"output_span"):
        assert warp.output_duration == warp.output_span
