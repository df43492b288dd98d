"""What people pass: each call with each type is accepted and means one thing, or is refused and says what to pass."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

from retime import Motion, OptionError, Signal, Skeleton
from retime.motion.contacts import Contacts, Foot

NTSC = Fraction(30000, 1001)
ONE = Skeleton(("root",), (-1,), np.zeros((1, 3)))
RATES = [
    (30, Fraction(30)),
    (30.0, Fraction(30)),
    (29.97, NTSC),
    (Fraction(30000, 1001), NTSC),
    (Fraction(1, 2), Fraction(1, 2)),
    ("30", Fraction(30)),
    ("29.97", NTSC),
    ("30000/1001", NTSC),
    (np.int64(30), Fraction(30)),
    (np.float32(29.97), NTSC),
    (np.float64(29.97), NTSC),
    (Decimal("29.97"), NTSC),
    (0, None),
    (-30, None),
    (Fraction(-30), None),
    (Fraction(0), None),
    (float("nan"), None),
    (float("inf"), None),
    ("fast", None),
    ("", None),
    (None, None),
    (True, None),
    (30j, None),
    ([30], None),
    (b"30", None),
]


def of_motion(rate):
    return Motion(ONE, np.tile([1.0, 0, 0, 0], (3, 1, 1)), rate=rate).rate


def of_signal(rate):
    return Signal(("x",), np.zeros((3, 1)), rate).rate


def of_contacts(rate):
    return Contacts((Foot(0),), np.zeros((3, 1), bool), rate).rate


def with_rate(rate):
    return Signal(("x",), np.zeros((1, 1))).with_rate(rate).rate


@pytest.mark.parametrize("call", [of_motion, of_signal, of_contacts, with_rate])
@pytest.mark.parametrize(("rate", "expected"), RATES, ids=[repr(rate) for rate, _ in RATES])
def test_rates(call, rate, expected) -> None:
    if expected is None:
        with pytest.raises(OptionError, match="expected a frame rate"):
            call(rate)
    else:
        found = call(rate)
        assert found == expected
        assert isinstance(found, Fraction)
