"""What is asked of a search, as people write it, in numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from retime.brief import kind_of
from retime.checks import real
from retime.errors import OptionError
from retime.motion.any_motion import AnyMotion
from retime.motion.grammar import parse_length, parse_speed, parse_speeds, parse_time, read_lock
from retime.search.keytimes import as_keytimes, check_keytimes
from retime.search.methods.loop import check_loop
from retime.search.plan import Request
from retime.search.wishes.asked import Wishes
from retime.search.wishes.locks import Lock


def read_request(
    motion: AnyMotion,
    keys: Sequence[str | Sequence[float | str | None]],
    locks: Sequence[Lock | str],
    chosen: dict[str, Any],
    *,
    itself: bool,
    evenness: float,
    keep_flights: float,
) -> Request:
    """Read what is asked of one search.

    Parameters
    ----------
    motion : Motion or Signal
        The input; of several clips the first, whose frames are counted.
    keys, locks
        As `retime.guided_warp` has them.
    chosen : dict of str to values
        The options of the stage "solve" in `retime.search.options`.
    itself : bool
        Whether the input is its own reference.
    evenness, keep_flights : float
        Weights of the price on tempo, as chosen for these clips.

    Raises
    ------
    OptionError
        Something can't be read, or can't be kept beside the rest.
    """
    slowest, fastest = _speeds(chosen["speed"])
    if not 0 <= slowest <= fastest or fastest == 0:
        raise OptionError(
            f"speed limits must be above 0, the slowest first; found {slowest:g} to {fastest:g}", option="speed"
        )
    keytimes = check_keytimes(as_keytimes(motion, chosen["length"], keys), motion.end_time)
    bounds = _length_bounds(motion, chosen["min_length"], chosen["max_length"])
    request = Request(
        keytimes=keytimes,
        wishes=Wishes(
            motion.end_time,
            _read_locks(locks, motion.rate),
            tuple(key.speed for key in keytimes if key.speed is not None),
            slowest,
            fastest,
        ),
        motion_rate=motion.rate,
        length_bounds=bounds,
        loop=chosen["loop"],
        upsample=chosen["upsample"],
        max_skip=chosen["max_skip"],
        evenness=evenness,
        keep_flights=keep_flights,
        # Who says how long a step may be means the frames that there are.
        natural=itself and chosen["max_skip"] is None and (evenness > 0 or keep_flights > 0),
    )
    if not request.free and not (chosen["min_length"] is None and chosen["max_length"] is None):
        raise OptionError("bounds on the length need a free length (length='free')", option="length")
    if request.loop:
        check_loop(keytimes, chosen["search"])
    return request


def _length_bounds(motion: AnyMotion, least: str | float | None, most: str | float | None) -> tuple[int, int | None]:
    """Bounds on a free length, in frames of the motion."""
    low, high = (_bound(motion, "min_length", least), _bound(motion, "max_length", most))
    if low is not None and high is not None and low > high:
        raise OptionError(f"the least length, {least}, is more than the most, {most}", option="max_length")
    return low or 2, high


def _bound(motion: AnyMotion, option: str, text: str | float | None) -> int | None:
    if text is None:
        return None
    try:
        return parse_length(text, motion.n_frames, motion.rate)
    except OptionError as error:
        raise OptionError(str(error), option=option) from None


def _speeds(speed: str | Sequence[float | str] | None) -> tuple[float, float]:
    """Read the slowest and the fastest speed; 0 and inf where none is given."""
    if speed is None:
        return 0.0, math.inf
    if isinstance(speed, str):
        return parse_speeds(speed)
    if not isinstance(speed, Sequence | np.ndarray) or len(speed) != 2:
        raise OptionError(
            f"speed is (slowest, fastest), or a text such as '1/2..4'; found {kind_of(speed)}", option="speed"
        )
    low, high = (parse_speed(one) if isinstance(one, str) else real(one, "a speed", option="speed") for one in speed)
    return low, high


def read_flights(flights: Sequence[Sequence[float | str]], motion: AnyMotion) -> list[tuple[float, float]]:
    """Read flights, as two times each."""
    found = []
    for flight in flights:
        if isinstance(flight, str) or len(flight) != 2:
            raise OptionError(f"a flight is (start, end), in input time; found {flight!r}", option="flights")
        start, end = (parse_time(time, motion.rate) for time in flight)
        if not 0 <= start < end <= motion.duration:
            raise OptionError(
                f"a flight from {start:g} to {end:g} s is no stretch of the clip, which ends at {motion.end_time:g} s",
                option="flights",
            )
        found.append((start, end))
    return found


def _read_locks(locks: Sequence[Lock | str], rate: Fraction) -> tuple[Lock, ...]:
    """Read locks where they are text; refuse what is none."""
    if (
        isinstance(locks, Lock | str)
        or not isinstance(locks, Sequence)
        or not all(isinstance(one, Lock | str) for one in locks)
    ):
        raise OptionError(
            f"locks are a sequence of Lock, as in locks=[Lock(6.12, 6.52)]; found {kind_of(locks)}", option="locks"
        )
    return tuple(_lock(lock, i, rate) for i, lock in enumerate(locks))


def _lock(lock: Lock | str, item: int, rate: Fraction) -> Lock:
    """Read a lock where it is text."""
    if not isinstance(lock, str):
        return lock
    try:
        return Lock(*read_lock(lock).at(rate))
    except OptionError as error:
        raise OptionError(str(error), option="locks", item=item) from None
