"""Whether a warp does what its keytimes say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from retime.warp.curve import Warp
from retime.warp.keytime import Keytime


@dataclass(frozen=True)
class KeytimeMatch:
    """Whether a warp does what its keytimes say.

    Attributes
    ----------
    n_keytimes : int
        How many there are, ends included.
    largest_error : float
        Seconds of input by which the worst one is missed.
    """

    n_keytimes: int
    largest_error: float


def match_keytimes(warp: Warp, keytimes: Sequence[Keytime]) -> KeytimeMatch:
    """Measure how far a warp misses keytimes; an output that is too short or too long misses its last."""
    errors = [abs(float(warp(key.output_time)) - key.input_time) for key in keytimes]
    errors += [abs(warp.output_end - max(key.output_time for key in keytimes))] if keytimes else []
    return KeytimeMatch(len(keytimes), max(errors, default=0.0))
