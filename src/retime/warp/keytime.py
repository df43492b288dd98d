"""The keytime: which moment of the input is shown at which moment of the output."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from retime.brief import kind_of
from retime.checks import real
from retime.errors import OptionError


@dataclass(frozen=True, order=True, init=False, repr=False, match_args=False)
class Keytime:
    """At `output_time` the output shows the pose that the input has at `input_time`; both in seconds.

    Made by names. Where a keytime is written without them, as ``(input_time, output_time)`` or ``(input_time,
    output_time, speed)``, the input comes first, as in ``--key IN=OUT``; every call that takes keytimes takes such
    tuples too. Keytimes sort by output time.

    Parameters
    ----------
    input_time, output_time : float
        Seconds from the first frame of the input, of the output.
    speed : float, optional
        Playback speed there (a tangent), above 0; a backward span has it backward. Left out, whatever comes.

    Raises
    ------
    OptionError
        A time or a speed is no number.

    Warns
    -----
    DeprecationWarning
        Arguments without names are taken as retime 0.1 took them, the output time first. A later release will refuse
        them; none will take them the other way round.

    Examples
    --------
    >>> Keytime(input_time=2.0, output_time=1.5)
    Keytime(input_time=2.0, output_time=1.5)
    """

    # Keytimes are compared, and so sorted, by their fields in this order.
    output_time: float
    input_time: float
    speed: float | None = field(default=None, compare=False)

    if TYPE_CHECKING:

        def __init__(self, *, input_time: float, output_time: float, speed: float | None = None) -> None: ...

    else:

        def __init__(self, *output_first: float, **named: float | None) -> None:
            if output_first:
                warnings.warn(
                    "Keytime(output_time, input_time) without names is deprecated, for key tuples have the input "
                    "first: write Keytime(input_time=..., output_time=...), or a tuple (input_time, output_time)",
                    DeprecationWarning,
                    stacklevel=2,
                )
            order = ("output_time", "input_time", "speed")
            times = dict(zip(order, output_first, strict=False))
            wrong = [name for name in named if name not in order or name in times]
            missing = [name for name in ("input_time", "output_time") if name not in times and name not in named]
            if len(output_first) > len(order) or wrong or missing:
                raise TypeError(
                    "expected Keytime(input_time=..., output_time=...), and speed=... where it has a tangent"
                )
            times.update(named)
            for name in order:
                value = times.get(name)
                if value is not None or name != "speed":
                    value = real(value, f"the {name.replace('_', ' ')} of a keytime")
                object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        speed = "" if self.speed is None else f", speed={self.speed!r}"
        return f"Keytime(input_time={self.input_time!r}, output_time={self.output_time!r}{speed})"


KeytimeLike = Keytime | Sequence[float]
"""A keytime, or a tuple (input time, output time) or (input time, output time, speed)."""


def keytime_of(key: KeytimeLike) -> Keytime:
    """Take a keytime, or the numbers of one with the input time first.

    Raises
    ------
    OptionError
        Neither of them.

    Examples
    --------
    >>> keytime_of((2.0, 1.5))
    Keytime(input_time=2.0, output_time=1.5)
    """
    if isinstance(key, Keytime):
        return key
    if isinstance(key, str | bytes) or not isinstance(key, Sequence | np.ndarray) or len(key) not in (2, 3):
        raise OptionError(
            "expected a keytime: a tuple (input time, output time) in seconds, with a speed where it has a tangent; "
            f"found {kind_of(key)}",
            option="keys",
        )
    speed = key[2] if len(key) == 3 else None
    return Keytime(input_time=key[0], output_time=key[1], speed=speed)


def keytimes_of(keys: Sequence[KeytimeLike]) -> tuple[Keytime, ...]:
    """Take several of what `keytime_of` takes."""
    if isinstance(keys, str | bytes | Keytime) or not isinstance(keys, Iterable):
        raise OptionError(
            f"expected keytimes, as in [(0, 0), (2.0, 1.5)] with the input time first; found {kind_of(keys)}",
            option="keys",
        )
    return tuple(keytime_of(key) for key in keys)


def check_speed(key: Keytime) -> None:
    """Refuse a tangent that is no speed; raise OptionError."""
    if key.speed is not None and not (math.isfinite(key.speed) and key.speed > 0):
        raise OptionError(
            f"the speed of a keytime must be above 0, found {key.speed:g} at output time {key.output_time:g} s",
            option="keys",
            output_times=(key.output_time,),
        )
