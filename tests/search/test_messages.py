"""What the search says when it can't: in speeds, frames and seconds, and with remedies that work."""

from __future__ import annotations

import re
from fractions import Fraction

import numpy as np
import pytest

from retime.errors import InfeasibleWarpError, OptionError
from retime.motion.signal import Signal
from retime.search.session import Session

# 8 s and a frame.
CLIP = Signal(("x",), np.sin((np.arange(241) / 30) ** 1.5)[:, None], Fraction(30))
# The search's own words. A message may use the first two of someone who did.
OWN_WORDS = r"max_skip|upsampl|analysis rate|unrolled"

REFUSED: dict[str, dict[str, object]] = {
    "too short for the speed limit": {"length": "20f", "speed": "..2"},
    "too long for the speed limit": {"length": "300%", "speed": "1/2.."},
    "keys too close for the speed limit": {"keys": [(2, 2), (6, 2.3)], "speed": "1/4..4"},
    "keys closer than a frame": {"keys": [(1, 1), (1.2, 1.001)]},
    "keys against a lock": {"keys": [(2, 2), (4, 3)], "locks": ["2..4=1"]},
    "a lock against a tangent": {"keys": [(2, 2, 2.0), (2.1, 2.05)], "locks": ["1.9..2.05=1"]},
    "a lock against the speed limit": {"locks": ["1..1.5=5"], "speed": "..3"},
    "a tangent against the speed limit": {"keys": [(2, 2, 5.0)], "speed": "..3"},
    "speeds too near each other": {"speed": "0.601..0.602"},
    "speeds too high": {"speed": "300"},
    "speeds too far apart": {"speed": "1/24..16"},
    "a lock too fast": {"locks": ["1..1.5=300"]},
    "a lock shorter than a frame": {"locks": ["1..1.02=8"]},
    "a free length too long": {"length": "free", "min_length": "100s"},
    "a free length before its key": {"length": "free", "max_length": "4s", "keys": [(2, 5)]},
    "weeks": {"length": "10000000s"},
}


def refusal(**options: object) -> str:
    with pytest.raises((InfeasibleWarpError, OptionError)) as caught:
        Session(CLIP).solve(**options)  # type: ignore[arg-type]
    return str(caught.value)


@pytest.mark.parametrize("options", REFUSED.values(), ids=REFUSED)
def test_the_search_keeps_its_own_words_to_itself(options: dict[str, object]) -> None:
    assert not re.search(OWN_WORDS, refusal(**options))


def test_whoever_names_a_limit_is_told_of_it_and_of_no_other() -> None:
    assert refusal(length="20f", max_skip=8) == (
        "cannot fit input 0.00–8.00 s into 20f (0.667 s): speeds up to 8 (max_skip=8) allow no less than 31f "
        "(1.033 s). Use a length of at least 31f (1.033 s), or max_skip >= 13."
    )
    assert refusal(length="300%", upsample=1) == (
        "cannot fit input 0.00–8.00 s into 723f (24.100 s): speeds down to 1 (upsample=1) allow no more than 241f "
        "(8.033 s). Use a length of at most 241f (8.033 s), or upsample >= 4."
    )
    assert refusal(keys=[(2, 2), (6, 2.3)], max_skip=4) == (
        "cannot fit input 2.00–6.00 s into 0.3 s: speeds up to 4 (max_skip=4) allow no less than 1 s. "
        "Put these keytimes at least 1 s apart, or max_skip >= 14."
    )
    said = refusal(keys=[(2, 2, 5.0)], max_skip=3)
    assert said.endswith("asks for speed 5, which can't be played: with max_skip=3 speeds are multiples of 1, up to 3")


def test_what_the_limits_allow_can_be_had_and_no_more() -> None:
    session = Session(CLIP)
    for options, bound, beyond in (
        ({"speed": "..2"}, "20f", -1),
        ({"speed": "1/2.."}, "723f", 1),
        ({"max_skip": 8}, "20f", -1),
    ):
        said = refusal(length=bound, **options)
        allowed = int(re.search(r"allow no (?:less|more) than (\d+)f", said)[1])  # type: ignore[index]
        assert session.solve(length=f"{allowed}f", **options).n_output == allowed
        refusal(length=f"{allowed + beyond}f", **options)
    for options, limit in (({"max_skip": 13}, 13), ({"speed": "..13"}, 13)):
        assert session.solve(length="20f", **options).max_skip == limit


@pytest.mark.parametrize(
    ("named", "remedy"), [({}, r"\(speed='(1/\d+\.\.)'\)$"), ({"upsample": 1}, r"\(upsample=(\d+)\)$")]
)
def test_a_bound_on_a_free_length_says_what_would_reach_it(named: dict[str, int], remedy: str) -> None:
    wanted = {"length": "free", "min_length": "100s", "keys": [(4, 10)]}
    said = refusal(**wanted, **named)
    (better,) = re.findall(remedy, said)
    options = {"upsample": int(better)} if named else {"speed": better}
    result = Session(CLIP).solve(**wanted, **options)  # type: ignore[arg-type]
    assert result.warp.output_end >= 100 - 1e-9 - 1 / 30


def test_speeds_too_far_apart_are_told_how_fast_they_may_be() -> None:
    (fastest,) = re.findall(r"Ask for speeds up to ([\d.]+),", refusal(speed="1/24..16"))
    # At that the whole clip would need more scores than are held.
    warp = Session(CLIP.frames(0, 60)).solve(speed=f"1/24..{fastest}").warp
    assert warp.slopes.max() <= float(fastest) + 1e-9
