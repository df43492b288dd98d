"""Keytimes: made by names, the input first in tuples; the old order is warned of, and never taken for the new one."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import warnings
from fractions import Fraction

import numpy as np
import pytest

from retime import Keytime, OptionError, Warp, linear_warp
from retime.warp.keytime import keytime_of


def test_names_say_which_time_is_which_in_any_order() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        key = Keytime(input_time=2.0, output_time=1.5, speed=0.5)
        assert Keytime(speed=0.5, output_time=1.5, input_time=2.0) == key
    assert (key.input_time, key.output_time, key.speed) == (2.0, 1.5, 0.5)
    assert eval(repr(key)) == key
    assert eval(repr(key)).speed == 0.5


@pytest.mark.parametrize(
    ("args", "named"),
    [
        ((1.5, 2.0), {}),
        ((1.5, 2.0, 0.5), {}),
        ((1.5, 2.0), {"speed": 0.5}),
        ((1.5,), {"input_time": 2.0}),
    ],
)
def test_without_names_the_old_order_holds_and_is_warned_of(args, named) -> None:
    with pytest.warns(DeprecationWarning, match=r"input_time=\.\.\., output_time=\.\.\.") as caught:
        key = Keytime(*args, **named)
    assert (key.input_time, key.output_time) == (2.0, 1.5)
    assert key.speed == (args[2] if len(args) == 3 else named.get("speed"))
    # The warning points here, not into retime.
    assert caught[0].filename == __file__


@pytest.mark.parametrize(
    ("args", "named"),
    [
        ((), {}),
        ((), {"input_time": 1.0}),
        ((1.0,), {}),
        ((1.0, 2.0, 3.0, 4.0), {}),
        ((1.0,), {"output_time": 2.0}),
        ((), {"input_time": 1.0, "output_time": 2.0, "tangent": 1.0}),
    ],
)
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_what_is_missing_or_said_twice_is_refused(args, named) -> None:
    with pytest.raises(TypeError, match="expected Keytime"):
        Keytime(*args, **named)


@pytest.mark.parametrize("value", ["2s", None, True, 1j, [1.0], np.array([1.0, 2.0])])
def test_a_time_that_is_no_number_is_refused(value) -> None:
    for name in ("input_time", "output_time"):
        with pytest.raises(OptionError, match=f"the {name.replace('_', ' ')} of a keytime must be a number"):
            Keytime(**{"input_time": 1.0, "output_time": 1.0, name: value})
    if value is not None:
        with pytest.raises(OptionError, match="the speed of a keytime must be a number"):
            Keytime(input_time=1.0, output_time=1.0, speed=value)


@pytest.mark.parametrize("number", [np.float32(0.5), np.int64(2), Fraction(1, 2), 3])
def test_numbers_of_any_type_become_floats(number) -> None:
    key = Keytime(input_time=number, output_time=number, speed=number)
    assert [type(value) for value in dataclasses.astuple(key)] == [float] * 3
    assert key.input_time == float(number)


def test_keytimes_sort_by_output_time() -> None:
    late, early = Keytime(input_time=0.0, output_time=2.0), Keytime(input_time=5.0, output_time=1.0)
    assert sorted([late, early]) == [early, late]


def test_copies_and_changed_copies_keep_each_time_in_its_place() -> None:
    key = Keytime(input_time=2.0, output_time=1.5, speed=3.0)
    for same in (copy.deepcopy(key), pickle.loads(pickle.dumps(key)), dataclasses.replace(key)):
        assert repr(same) == repr(key)
    assert dataclasses.replace(key, output_time=9.0) == Keytime(input_time=2.0, output_time=9.0)


def test_a_pattern_without_names_is_refused_rather_than_swapped() -> None:
    def unpacked(key: Keytime) -> tuple[float, float]:
        match key:
            case Keytime(first, second):  # type: ignore[misc]
                return first, second
        raise AssertionError

    with pytest.raises(TypeError, match="positional"):
        unpacked(Keytime(input_time=2.0, output_time=1.5))


@pytest.mark.parametrize("pair", [(2.0, 1.5), [2.0, 1.5], np.array([2.0, 1.5]), (2, 1.5, None)])
def test_in_a_tuple_the_input_comes_first(pair) -> None:
    assert keytime_of(pair) == Keytime(input_time=2.0, output_time=1.5)
    warp = linear_warp([(0, 0), pair])
    assert (warp.output_end, float(warp(1.5))) == (1.5, 2.0)
    assert Warp([0.0, 1.5], [0.0, 2.0], [pair]).keytimes == (Keytime(input_time=2.0, output_time=1.5),)  # type: ignore[arg-type]


@pytest.mark.parametrize("wrong", ["ab", 3.0, (1.0,), (1, 2, 3, 4), None, {"input_time": 1.0}])
def test_what_is_no_keytime_is_refused(wrong) -> None:
    with pytest.raises(OptionError, match=r"expected a keytime: a tuple \(input time, output time\)"):
        linear_warp([(0, 0), wrong])
