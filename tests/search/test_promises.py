"""What a warp was asked to keep: the check itself, and what searches do where it is hard."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from retime.errors import InfeasibleWarpError, OptionError, RetimeWarning
from retime.motion.signal import Signal
from retime.search.guided import guided_warp
from retime.search.promises import broken_promises
from retime.search.result import GuidedWarp
from retime.search.wishes.locks import Lock
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime

KEYS = [Keytime(input_time=0.0, output_time=0.0), Keytime(input_time=4.0, output_time=4.0)]
MIDDLE = Keytime(input_time=2.0, output_time=2.0)
EVEN = Warp([0.0, 4.0], [0.0, 4.0])


def clip(seconds: float, rate: int = 30) -> Signal:
    t = np.arange(round(seconds * rate) + 1) / rate
    return Signal(("x", "y"), np.stack([np.sin(t**1.4), 2 * np.cos(1.7 * t)], axis=1), Fraction(rate), name="clip")


# The check


def kinds(warp: Warp, keys: list[Keytime] = KEYS, **asked: Any) -> list[str]:
    return [one.kind for one in broken_promises(warp, keys, **asked)]


def test_what_is_kept_is_not_complained_of() -> None:
    warp = Warp([0.0, 1.0, 2.5, 4.0], [0.0, 0.5, 2.0, 4.0])
    keys = [KEYS[0], Keytime(input_time=2.0, output_time=2.5), KEYS[1]]
    locks = [Lock(0.5, 2.0), Lock(0.0, 0.5, 0.5, 0.5), Lock(1.0, 3.9, 1.0, 1.34)]
    assert kinds(warp, keys, locks=locks, slowest=0.5, fastest=4 / 3) == []


@pytest.mark.parametrize(
    ("warp", "asked", "kind"),
    [
        (Warp([0.0, 2.0, 4.0], [0.0, 2.1, 4.0]), {"keys": [KEYS[0], MIDDLE, KEYS[1]]}, "key"),
        (Warp([0.0, 3.9], [0.0, 4.0]), {}, "length"),
        (Warp([0.0, 2.0, 4.0], [0.0, 1.0, 4.0]), {"locks": [Lock(0.2, 0.8)]}, "lock"),
        (Warp([0.0, 2.0, 4.0], [0.0, 1.0, 4.0]), {"locks": [Lock(0.2, 1.001, 0.4, 0.6)]}, "lock"),
        (Warp([0.0, 2.0, 4.0], [0.0, 1.0, 4.0]), {"slowest": 0.51}, "limit"),
        (Warp([0.0, 2.0, 4.0], [0.0, 1.0, 4.0]), {"fastest": 1.49}, "limit"),
        (EVEN, {"keys": [KEYS[0], Keytime(input_time=4.0, output_time=4.0, speed=1.01)]}, "tangent"),
        (Warp([0.0, 2.0, 4.0], [0.0, 1.0, 4.0]), {"loop": True}, "seam"),
        (Warp([0.0, 2.0, 3.0, 4.0], [0.0, 2.0, 1.5, 4.0]), {}, "direction"),
    ],
)  # fmt: skip
def test_each_kind_is_found(warp: Warp, asked: dict[str, Any], kind: str) -> None:
    assert kind in kinds(warp, **asked)


def test_a_hold_has_no_speed_and_backward_spans_have_theirs() -> None:
    keys = [
        Keytime(input_time=0.0, output_time=0.0),
        Keytime(input_time=2.0, output_time=2.0),
        Keytime(input_time=2.0, output_time=3.0),
        Keytime(input_time=0.0, output_time=5.0),
    ]
    warp = Warp([0.0, 2.0, 3.0, 5.0], [0.0, 2.0, 2.0, 0.0])
    assert kinds(warp, keys, slowest=0.9, fastest=1.1, locks=[Lock(0.5, 1.5)]) == []
    assert kinds(warp, keys, locks=[Lock(0.5, 1.5, 2.0, 2.0)]) == ["lock"]


def test_the_worst_place_is_named() -> None:
    (broken,) = broken_promises(Warp([0.0, 1.0, 2.0, 4.0], [0.0, 1.1, 2.5, 4.0]), KEYS, locks=[Lock(0.0, 2.0)])
    assert (broken.start, broken.end) == pytest.approx((1.0, 1 + 0.9 / 1.4))
    assert broken.found == pytest.approx(1.4)
    assert broken.off == pytest.approx(0.4)
    assert "the lock 0–2 s at 1: it plays at 1.4" in str(broken)


# What was missed, or hard


def keeps(result: GuidedWarp) -> bool:
    wishes = result.plan.request.wishes
    return not result.given_up and not broken_promises(
        result.warp,
        result.reduction.keytimes,
        locks=wishes.locks,
        slowest=wishes.slowest,
        fastest=wishes.fastest,
        loop=result.loop,
    )


def test_a_lock_with_a_keytime_in_it() -> None:
    t = np.arange(118) / 30
    motion = Signal(("a",), np.sin(t * 4)[:, None], Fraction(30))
    result = guided_warp(motion, keys=[(2.8, 3.3)], locks=[Lock(1.24, 3.47, 2, 2)])
    assert keeps(result)
    inside = (result.warp.input_times[:-1] >= 1.24) & (result.warp.input_times[1:] <= 3.47)
    np.testing.assert_allclose(result.warp.slopes[inside], 2.0, rtol=1e-7)


@pytest.mark.parametrize("seed", range(40))
def test_random_locks_keys_and_limits(seed: int) -> None:
    rng = np.random.default_rng(seed)
    motion = clip(4.0, int(rng.choice([24, 30, 120])))
    asked: dict[str, Any] = {"length": f"{rng.integers(70, 140)}%"}
    place = float(rng.uniform(0.5, 3.5))
    if rng.random() < 0.7:
        asked["keys"] = [(place, place * float(rng.uniform(0.7, 1.3)), 1.0)[: 2 + rng.integers(2)]]
    start = float(rng.uniform(0, 3))
    asked["locks"] = [Lock(start, start + float(rng.uniform(0.3, 1.0)), *sorted(rng.choice([0.5, 0.8, 1.0, 1.5], 2)))]
    if rng.random() < 0.5:
        asked["speed"] = (0.4, 2.5)
    if rng.random() < 0.6:
        asked["influence"] = [0.0, 0.5, [(0.0, 0.0), (1.0, 1.0), (2.0, 0.3)]][rng.integers(3)]
    try:
        result = guided_warp(motion, **asked)
    except (InfeasibleWarpError, OptionError):
        return
    assert keeps(result)


@pytest.mark.parametrize("length", ["100%", "1500%", "2000%", "10000%"])
def test_a_lock_holds_at_any_length(length: str) -> None:
    result = guided_warp(clip(13.6), keys=[(7.2, 4.71)], locks=[Lock(5.64, 9.15)], length=length)
    assert keeps(result)
    # What it is not asked for crawls.
    assert result.warp.count_frames(30) == round(409 * float(length[:-1]) / 100)


def test_a_lock_that_leaves_no_way_is_refused_with_one_that_works() -> None:
    asked: dict[str, Any] = {"keys": [(7.2, 4.71)], "locks": [Lock(5.64, 9.15)]}
    with pytest.raises(InfeasibleWarpError, match=r"no less than ([\d.]+) s. Put .* apart") as caught:
        guided_warp(clip(13.6), length="40%", **asked)
    apart = re.search(r"at least ([\d.]+) s apart", str(caught.value))
    assert apart
    length = 4.71 + float(apart[1])
    assert keeps(guided_warp(clip(13.6), length=f"{math.ceil(length * 30) + 1}f", **asked))


def test_a_limit_that_a_crawl_can_not_keep_is_refused() -> None:
    with pytest.raises(InfeasibleWarpError, match="the speed limits allow no more than"):
        guided_warp(clip(4.0), length="20000%", speed=(0.5, 2.0))


@pytest.mark.parametrize("influence", [0.0, 0.5, 0.8, [(0.0, 1.0), (1.0, 0.0), (1.3, 1.0)]])
def test_influence_breaks_nothing(influence: Any) -> None:
    asked: dict[str, Any] = {
        "length": "85%",
        "keys": [(2.0, 1.6, 0.75)],
        "locks": [Lock(0.3, 1.2), Lock(2.4, 3.0, 0.5, 1.0)],
        "speed": (0.25, 3.0),
    }
    result = guided_warp(clip(4.0), influence=influence, **asked)
    assert keeps(result)
    # And it is a mix: elsewhere it differs from the guided warp.
    whole = guided_warp(clip(4.0), **asked)
    times = np.linspace(0, whole.warp.output_end, 400)
    assert np.abs(result.warp(times) - whole.warp(times)).max() > 1e-3


def test_what_leaves_no_room_by_a_rounding_is_said() -> None:
    # 2.97 s of it are locked between two keytimes that are a frame farther apart.
    motion = clip(4.0)
    asked: dict[str, Any] = {"keys": [(0.5, 0.5), (3.47, 3.48)], "locks": [Lock(0.0, 4.0)], "length": "100%"}
    with pytest.warns(RetimeWarning, match="not quite kept .* the lock 0–4 s at 1: all speeds there") as said:
        result = guided_warp(motion, **asked)
    assert [str(one.message).removeprefix("not quite kept ") for one in said] == list(result.given_up)
    assert [re.search(r"are [\d.]+% \w+", words)[0] for words in result.given_up] == [  # type: ignore[index]
        "are 0.34% below",
        "are 1.92% above",
    ]
    off = broken_promises(result.warp, result.reduction.keytimes, locks=asked["locks"])
    assert max(one.off for one in off) < 0.02
    with pytest.raises(InfeasibleWarpError, match="locks allow no more than"):
        guided_warp(motion, **{**asked, "keys": [(0.5, 0.5), (3.47, 3.6)]})


@pytest.mark.parametrize("n_frames", [5, 6, 8])
def test_a_short_loop_with_a_key_in_its_first_step_meets_at_its_seam(n_frames: int) -> None:
    values = np.sin(np.linspace(0, 2 * math.pi, n_frames))[:, None]
    motion = Signal(("x",), values, Fraction(30))
    found = 0
    for key in [(0.02, 0.035), (0.035, 0.034), (0.034, 0.05)]:
        try:
            result = guided_warp(motion, keys=[key], loop=True, n_neighbors=1)
        except (InfeasibleWarpError, OptionError):
            continue
        slopes = result.warp.slopes
        assert slopes[0] == pytest.approx(slopes[-1], rel=1e-6)
        found += 1
    assert found
