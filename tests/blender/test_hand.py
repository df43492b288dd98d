"""A hand's timing, read from keys before and after."""

from __future__ import annotations

import numpy as np
import pytest

from blender.hand import hand_timing, keyed_timing
from retime.errors import OptionError


def keys(*frames, values=None):
    frames = np.array(frames, dtype=float)
    return frames, np.sin(frames) if values is None else np.array(values)


def moved(before, to):
    frames, values = before
    return np.array([to.get(frame, frame) for frame in frames.tolist()], dtype=float), values


def test_the_stretch_is_what_has_another_length_and_the_rest_was_only_pushed_along():
    before = {("a", 0): keys(1, 11, 21, 31, 41), ("a", 1): keys(1, 21, 41)}
    # From 11 to 31 at half the speed; what follows came later.
    to = {21: 31, 31: 51, 41: 61}
    found = hand_timing(before, {name: moved(curve, to) for name, curve in before.items()})
    assert (found.start, found.end) == (11, 31)
    assert found.warp.output_times.tolist() == [11, 31, 51]
    assert found.warp.input_times.tolist() == [11, 21, 31]


def test_curves_that_were_changed_otherwise_say_nothing():
    before = {"moved": keys(1, 10, 20, 30), "redrawn": keys(1, 10, 20, 30), "cut": keys(1, 10, 20)}
    after = {
        "moved": moved(before["moved"], {20: 25, 30: 35}),
        "redrawn": keys(1, 5, 6, 7, values=[9, 9, 9, 9]),
        "cut": keys(1, 10),
        "new": keys(3, 4),
    }
    found = hand_timing(before, after)
    assert (found.start, found.end) == (10, 20)
    assert found.warp.output_times.tolist() == [10, 25]


@pytest.mark.parametrize(
    ("after", "said"),
    [
        ({}, "no keys were moved"),
        ({20: 20.001}, "no keys were moved"),
        ({20: 5}, "keys must stay in order"),
    ],
)
def test_what_is_no_timing_is_refused(after, said):
    before = {"a": keys(1, 10, 20, 30)}
    with pytest.raises(OptionError, match=said):
        hand_timing(before, {"a": moved(before["a"], after)})


def test_keys_of_one_frame_that_went_to_two_are_named():
    before = {"a": keys(1, 10, 20), "b": keys(1, 10, 20)}
    after = {"a": moved(before["a"], {10: 12}), "b": moved(before["b"], {10: 15})}
    with pytest.raises(OptionError, match=r"frame 10 were moved to frames 12 to 15") as caught:
        hand_timing(before, after)
    assert caught.value.option == "before"


def test_keytimes_in_a_range_say_it_too():
    found = keyed_timing([(90, 70), (10, 10), (30, 50), (20, 40), (99, 80)], 10, 30)
    assert (found.start, found.end) == (10, 30)
    assert found.warp.output_times.tolist() == [10, 40, 50]
    with pytest.raises(OptionError, match="there are 1 keytimes"):
        keyed_timing([(10, 10), (50, 40)], 5, 30)
