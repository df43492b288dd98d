"""variants(): different, the same again, and all of them warps that keep what is asked."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest

import retime
from retime import GuidedWarp, Lock, OptionError, Reference, Signal, variants
from retime.search.variants import APART, drawn_references, how_far_apart


def curve(n_frames: int, seed: int = 0) -> Signal:
    rng = np.random.default_rng(seed)
    t = np.arange(n_frames)[:, None] / 30
    return Signal(("x", "y"), np.sin(t * rng.uniform(1, 4, 2) + rng.uniform(0, 6, 2)) + 0.2 * t, Fraction(30))


def same(one: GuidedWarp, other: GuidedWarp) -> bool:
    return one.warp == other.warp and one.path.frames.tolist() == other.path.frames.tolist()


@pytest.mark.parametrize("n", [1, 2, 8, 15])
@pytest.mark.parametrize("lengths", [(0.8, 1.2), (0.5, 0.6), (1.0, 1.0)])
def test_no_two_are_alike_and_all_keep_to_the_lengths(n: int, lengths: tuple[float, float]) -> None:
    clip = curve(150)
    takes = variants(clip, n, lengths=lengths, seed=n)
    assert len(takes) == n
    for take in takes:
        frames = take.apply().n_frames
        assert lengths[0] * 150 - 1 <= frames <= lengths[1] * 150 + 1
        assert take.path.optimal
        assert (np.diff(take.warp.input_times) > 0).all()
        assert (float(take.warp.input_times[0]), float(take.warp.input_times[-1])) == (0.0, clip.end_time)
    for one, other in itertools.combinations(takes, 2):
        assert how_far_apart(one.warp, other.warp) >= APART * clip.duration
    # Spread over the range, one in each part of it.
    shares = sorted((take.apply().n_frames / 150 - lengths[0]) / max(lengths[1] - lengths[0], 1e-9) for take in takes)
    if lengths == (0.8, 1.2):
        assert all(i / n - 0.03 <= share <= (i + 1) / n + 0.03 for i, share in enumerate(shares))


def test_a_seed_gives_the_same_again_and_another_does_not() -> None:
    clip = retime.sample().frames(60, 400)
    first, again, other = (variants(clip, 3, seed=seed) for seed in (4, 4, 5))
    assert all(itertools.starmap(same, zip(first, again, strict=True)))
    assert not any(same(one, two) for one, two in itertools.product(first, other))


def test_what_is_drawn_differs_from_one_to_the_next() -> None:
    takes = variants(retime.sample().frames(0, 500), 6)
    asked = [take.plan.request for take in takes]
    assert len({one.keytimes[1].input_time for one in asked}) == 6
    assert len({one.evenness for one in asked}) == 6
    assert 0 < sum(bool(one.wishes.locks) for one in asked) < 6


def test_locks_limits_and_references_hold_in_all() -> None:
    clip = curve(200)
    takes = variants(clip, 4, locks=[Lock(1.0, 2.0)], speed="1/2..2", reference=Reference(curve(90, 3)))
    for take in takes:
        inside = (take.warp.input_times[:-1] >= 1.0 - 1e-9) & (take.warp.input_times[1:] <= 2.0 + 1e-9)
        assert np.allclose(take.warp.slopes[inside], 1.0)
        assert take.warp.slopes.min() >= 0.5 - 1e-9
        assert take.warp.slopes.max() <= 2 + 1e-9
        assert take.n_reference == 90


@pytest.mark.parametrize("n", [1, 4, 7])
def test_each_imitates_one_of_the_references_where_they_are_drawn(n: int) -> None:
    clip = curve(150)
    # Of three lengths, so that the count of frames tells which one it was.
    several = [Reference(curve(n_frames, n_frames)) for n_frames in (60, 75, 90)]
    takes = variants(clip, n, seed=3, reference=several, draw_references=True)
    order = drawn_references(n, 3, 3)
    assert [take.n_reference for take in takes] == [(60, 75, 90)[place] for place in order]
    counts = [order.count(place) for place in range(3)]
    assert max(counts) - min(counts) <= 1
    # All else is drawn as it is without.
    together = variants(clip, n, seed=3, reference=several)
    assert [take.n_reference for take in together] == [225] * n
    assert [take.plan.request.keytimes for take in takes] == [take.plan.request.keytimes for take in together]
    alone = variants(clip, n, seed=3, reference=several[order[0]])
    assert same(takes[0], alone[0])


def test_other_seeds_draw_other_references() -> None:
    orders = {drawn_references(6, 3, seed) for seed in range(20)}
    assert len(orders) > 10
    assert drawn_references(3, 0, 1) == ()
    with pytest.raises(OptionError, match="to draw references"):
        variants(curve(100), 2, draw_references=True)


# A lock from end to end leaves keytimes drawn inside it no room: that is said, until there are none left to draw.
@pytest.mark.filterwarnings("ignore:not quite kept")
@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"n": 0}, "at least one variant"),
        ({"seed": -1}, "seed of 0 or more"),
        ({"lengths": (1.2, 0.8)}, "the shortest first"),
        ({"lengths": "80%"}, "as shares"),
        ({"lengths": (1.0, 1.0), "locks": [Lock(0.0, 3.9)]}, "ask for fewer"),
        ({"length": "50%"}, "no option 'length'"),
        ({"keys": [(1, 2)]}, "no option 'keys'"),
    ],
)
def test_what_can_not_be_drawn_is_refused(given: dict, message: str) -> None:
    with pytest.raises(OptionError, match=message):
        variants(curve(120), **given)
