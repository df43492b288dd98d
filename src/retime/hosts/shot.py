"""What a host needs to know beside the warp, and how its numbers become times."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from retime.arrays import FloatArray
from retime.errors import FormatError, OptionError
from retime.limits import LEAST_GAP, MOST_SECONDS
from retime.warp.curve import Warp

MOST_KEYS = 1_000_000
"""Of a curve: no host takes more, and a file of as many is read in seconds."""

_DECIMALS = 12


@dataclass(frozen=True)
class Shot:
    """Where a curve stands.

    Attributes
    ----------
    rate : Fraction, optional
        Frames a second, of the input and of the output.
    start : int
        The number of the frame at time 0, of the input and of the output.
    item : str
        The node, layer or clip that it is for; empty where nobody said.
    tolerance : float
        Seconds that a line may be off, where a rounded curve is read.
    said : tuple of str
        The options that somebody gave of how frames are counted: where a file counts seconds they have no effect.
    """

    rate: Fraction | None = None
    start: int = 0
    item: str = ""
    tolerance: float = 0.001
    said: tuple[str, ...] = ()

    @property
    def exact_rate(self) -> Fraction:
        """The rate, where there must be one.

        Raises
        ------
        OptionError
            Nobody said it.
        """
        if self.rate is None:
            raise OptionError("this curve counts frames, and does not say how many a second: name their rate (--rate)")
        return self.rate

    def frames(self, times: FloatArray) -> FloatArray:
        """Return the frame numbers of times."""
        rate = self.exact_rate
        return self.start + times * rate.numerator / rate.denominator

    def times(self, frames: FloatArray) -> FloatArray:
        """Return the times of frame numbers."""
        rate = self.exact_rate
        return (frames - self.start) * rate.denominator / rate.numerator

    def first_frame(self, warp: Warp) -> int:
        """Return the whole frame, counted from time 0, at which the output begins."""
        return round(warp.output_start * self.exact_rate)

    def count_frames(self, warp: Warp) -> int:
        """Count the output's frames; raise OptionError where a host could not hold as many."""
        n = warp.count_frames(self.exact_rate)
        if n > MOST_KEYS:
            raise OptionError(
                f"the output has {n} frames, and a curve at most {MOST_KEYS} keys; take a lower rate (--rate)"
            )
        return n

    def on_frames(self, warp: Warp) -> Warp:
        """Return the warp with a knot at each whole output frame, and no other."""
        rate = self.exact_rate
        numbers = self.first_frame(warp) + np.arange(max(2, self.count_frames(warp)))
        times = numbers * rate.denominator / rate.numerator
        return Warp(times, warp(times))


def plain(number: float) -> str:
    """Write a number as every program reads it: digits, a point, no exponent.

    Examples
    --------
    >>> plain(3.0), plain(-0.0), plain(1 / 3)
    ('3', '0', '0.333333333333')
    """
    text = f"{number:.{_DECIMALS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def plain_rows(warp_values: FloatArray) -> list[str]:
    """Write numbers, each by `plain`."""
    return [plain(value) for value in warp_values.tolist()]


Place = dict[str, Any]
"""Where a key stands: what FormatError takes (line, column or byte)."""


def warp_of(
    output_times: Sequence[float] | FloatArray,
    input_times: Sequence[float] | FloatArray,
    *,
    place: Callable[[int], Place] = lambda key: {},
    begins: Place | None = None,
    name: str = "",
) -> Warp:
    """Make a warp of the keys of a file.

    Parameters
    ----------
    output_times, input_times : float arrays
        Seconds.
    place : callable
        Tells where a key, counted from 0, stands.
    begins : dict, optional
        Where the curve itself stands.
    name : str
        Of the warp.

    Raises
    ------
    FormatError
        Fewer than two keys, times that don't increase, or that no clip has.
    """
    outputs, inputs = np.asarray(output_times, dtype=np.float64), np.asarray(input_times, dtype=np.float64)
    if len(outputs) < 2:
        raise FormatError(f"a retime curve needs two or more keys, found {len(outputs)}", **(begins or {}))
    if len(outputs) > MOST_KEYS:
        raise FormatError(f"the curve has {len(outputs)} keys, the limit is {MOST_KEYS}")
    # Written so that nan is refused too.
    far = np.flatnonzero(~((np.abs(outputs) <= MOST_SECONDS) & (np.abs(inputs) <= MOST_SECONDS)))
    if len(far):
        key = int(far[0])
        raise FormatError(
            f"key {key}: no clip has a time of {outputs[key]:g} or {inputs[key]:g} s; the limit is {MOST_SECONDS:g} s",
            **place(key),
        )
    stuck = np.flatnonzero(np.diff(outputs) < LEAST_GAP)
    if len(stuck):
        key = int(stuck[0]) + 1
        raise FormatError(
            f"output times must increase: key {key} is at {outputs[key]:g} s, after one at {outputs[key - 1]:g} s; "
            "each moment of the output shows one of the input: sort the keys, and keep one of those at the same time",
            **place(key),
        )
    return Warp(outputs, inputs, name=name)
