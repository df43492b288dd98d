"""Which frames an example is made of."""

from __future__ import annotations

import numpy as np
import pytest

from retime.search.example.cover import cover_of

RATE = 30.0


def circle(n_frames: int, period: int) -> np.ndarray:
    phase = 2 * np.pi * np.arange(n_frames) / period
    return np.stack([np.cos(phase), np.sin(phase)], axis=1)


# Of a circle of radius 1 two points lie apart by the square root of 2 in the median.
MEDIAN = 2**0.5


@pytest.mark.parametrize("period", [24, 40])
def test_a_whole_cycle_is_enough(period: int) -> None:
    cover = cover_of(circle(200, period), 50, 50 + period, rate=RATE, median=MEDIAN)
    assert (cover.closed, cover.period) == (True, None)
    assert cover.frames.tolist() == list(range(50, 51 + period))


@pytest.mark.parametrize(("first", "last"), [(80, 100), (0, 20), (179, 199)])
def test_a_part_of_a_cycle_is_joined_by_the_rest_of_it(first: int, last: int) -> None:
    cover = cover_of(circle(200, 40), first, last, rate=RATE, median=MEDIAN)
    assert (cover.closed, cover.period) == (False, 40)
    assert len(cover.frames) == 41
    assert set(range(first, last + 1)) <= set(cover.frames.tolist())


def test_in_the_middle_of_a_clip_the_rest_lies_on_both_sides() -> None:
    cover = cover_of(circle(200, 40), 80, 100, rate=RATE, median=MEDIAN)
    assert (cover.frames[0], cover.frames[-1]) == (70, 110)


def test_what_comes_back_elsewhere_in_the_clip_does_not_matter() -> None:
    # The period is the example's own: a walk of another pace, before and after it, has no say.
    walks = np.concatenate([circle(90, 30), circle(160, 40), circle(90, 30)])
    assert cover_of(walks, 150, 170, rate=RATE, median=MEDIAN).period == 40


def test_what_never_comes_back_is_told_from_half_a_second_around_it() -> None:
    line = np.arange(200.0)[:, None]
    cover = cover_of(line, 80, 100, rate=RATE, median=30.0)
    assert cover.period is None
    assert (cover.frames[0], cover.frames[-1]) == (65, 115)
    # Beside the ends of the clip there is less of it.
    assert cover_of(line, 5, 20, rate=RATE, median=20.0).frames[0] == 0


def test_a_pause_is_no_cycle() -> None:
    # Its ends meet, but it is too short to be one; and nothing is to be told apart from it.
    cover = cover_of(np.zeros((60, 2)), 20, 30, rate=RATE, median=0.0)
    assert not cover.closed
