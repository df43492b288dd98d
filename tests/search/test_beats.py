"""Accents matched with beats: by hand, and against all ways to match."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from retime.errors import OptionError
from retime.motion.accents import Accent
from retime.search.beats import MOST_SPEED, Beat, match_beats


def accents(*times: float) -> list[Accent]:
    return [Accent(time, 1.0, "step") for time in times]


def value(pairs, accents, beats, input_end, output_end) -> float:
    """Add up, literally, what a way to match is worth."""
    places = [(0.0, 0.0), *((accents[i].time, beats[j].time) for i, j in pairs)]
    if output_end is not None:
        places.append((input_end, output_end))
    total = sum(accents[i].strength * beats[j].strength for i, j in pairs)
    for (a0, b0), (a1, b1) in itertools.pairwise(places):
        if b1 <= b0 or not 1 / MOST_SPEED <= (a1 - a0) / (b1 - b0) <= MOST_SPEED:
            return -math.inf
        total -= 2.0 * (a1 - a0) * math.log((a1 - a0) / (b1 - b0)) ** 2
    return total


@pytest.mark.parametrize("seed", range(25))
@pytest.mark.parametrize("known", [True, False])
def test_no_way_to_match_is_better(seed, known) -> None:
    chance = np.random.default_rng(seed)
    n, m = (int(k) for k in chance.integers(1, 6, 2))
    given = [Accent(float(t), float(chance.uniform(0.1, 1)), "peak") for t in np.cumsum(chance.uniform(0.1, 0.8, n))]
    beats = [Beat(float(t), float(chance.uniform(0.1, 1))) for t in np.cumsum(chance.uniform(0.1, 0.8, m))]
    input_end = given[-1].time + 0.4
    output_end = beats[-1].time + float(chance.uniform(0.1, 0.8)) if known else None
    found = match_beats(given, beats, input_end=input_end, output_end=output_end)
    pairs = [(given.index(match.accent), beats.index(match.beat)) for match in found]
    worth = value(pairs, given, beats, input_end, output_end)
    best = max(
        value(list(zip(rows, columns, strict=True)), given, beats, input_end, output_end)
        for k in range(min(n, m) + 1)
        for rows in itertools.combinations(range(n), k)
        for columns in itertools.combinations(range(m), k)
    )
    if math.isinf(best):
        assert found == []
    else:
        assert worth == pytest.approx(best)


def test_a_dance_is_set_to_another_tempo() -> None:
    # 120 steps a minute, to a song of 100 beats a minute.
    steps = accents(*(0.5 * k for k in range(1, 9)))
    song = [Beat(0.6 * k) for k in range(1, 12)]
    found = match_beats(steps, song, input_end=4.4)
    assert [(match.accent.time, round(match.beat.time, 6)) for match in found] == [
        (0.5 * k, round(0.6 * k, 6)) for k in range(1, 9)
    ]


def test_what_would_be_too_fast_is_not_matched() -> None:
    assert match_beats(accents(5.0), [Beat(1.0)], input_end=6.0) == []
    assert match_beats([], [Beat(1.0)], input_end=6.0) == []
    assert match_beats(accents(1.0), [Beat(-1.0), Beat(0.0)], input_end=6.0) == []


def test_times_that_do_not_increase_are_refused() -> None:
    with pytest.raises(OptionError, match="times of beats must increase"):
        match_beats(accents(1.0), [Beat(1.0), Beat(1.0)], input_end=2.0)
    with pytest.raises(OptionError, match="5000 accents"):
        match_beats(accents(*range(5000)), [Beat(1.0)], input_end=2.0)
