"""Numbers as files hold them, made doubles."""

from __future__ import annotations

import numpy as np
import pytest

from retime.arrays import doubles


@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize(("size", "signalling"), [(4, 0x7F800001), (8, 0x7FF0000000000001)])
def test_a_signalling_nan_is_a_plain_one(order: str, size: int, signalling: int) -> None:
    """NumPy warns of it, which a user or a test may have made an error, long after the file was read."""
    bits = np.array([signalling, 1 << (8 * size - 1), 1], dtype=f"{order}u{size}")
    held = bits.view(f"{order}f{size}")
    made = doubles(held)
    with np.errstate(invalid="raise"):
        assert np.isnan(made - 1.0).tolist() == [True, False, False]
    # A zero keeps its sign, and the smallest number there is its value.
    assert np.signbit(made).tolist() == [False, True, False]
    assert made[2] == float(held[2]) > 0


def test_whole_numbers_and_halves_are_the_same_numbers() -> None:
    assert doubles(np.array([0, 255], dtype=np.uint8)).tolist() == [0.0, 255.0]
    assert doubles(np.array([1.5, -0.25], dtype=np.float16)).tolist() == [1.5, -0.25]
    assert doubles(np.array([-(2**40)])).dtype == np.float64
