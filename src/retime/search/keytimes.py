"""Keytimes: which moment of the input is shown at which moment of the output, and whether any warp can do it."""

from __future__ import annotations

import contextlib
import itertools
import math
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction

import numpy as np

from retime.brief import kind_of
from retime.errors import InfeasibleWarpError, OptionError, RetimeWarning
from retime.limits import MOST_SECONDS
from retime.motion.any_motion import AnyMotion
from retime.motion.grammar import factor_hint, parse_length, parse_speed, parse_time, read_key
from retime.warp.keytime import Keytime, check_speed

# A length this many times shorter than the input may have been meant as a factor.
_HARDLY_MEANT = 8
# Seconds: nobody shows two frames so close together.
_CLOSEST = 1e-6


def refuse_single_frame(motion: AnyMotion) -> None:
    """Raise OptionError where a clip has one frame."""
    if motion.n_frames < 2:
        raise OptionError(f"{motion.name or 'the input'} has one frame: there is no timing to change", option="motion")


def as_keytimes(
    motion: AnyMotion, length: str | float | None, keys: Sequence[str | Sequence[float | str | None] | Keytime]
) -> tuple[Keytime, ...]:
    """Turn a length and keys as people write them into keytimes, ends included.

    Parameters
    ----------
    motion : Motion or Signal
        The input.
    length : str or float, optional
        Of the output (`retime.motion.grammar.parse_length`); ``"free"`` leaves it to the search. Left out: after
        the last key the input plays on at its own speed.
    keys : sequence of (input time, output time), (input time, output time, speed), str or Keytime
        Seconds, or text such as ``"120f"``; the speed is a tangent. A whole key as text is ``"IN=OUT@SPEED"``.

    Returns
    -------
    tuple of Keytime
        In output order. An infinite output time of the last one stands for a free length.

    Raises
    ------
    OptionError
        A time or length can't be read, or a key lies before the output's beginning or beyond its end.
    """
    rate = motion.rate
    refuse_single_frame(motion)
    pairs: list[Keytime] = []
    if isinstance(keys, str | Keytime | Mapping) or not isinstance(keys, Iterable):
        raise OptionError(
            f"keys are a sequence: keys=[(input time, output time)], one tuple a key; found {kind_of(keys)}",
            option="keys",
        )
    for key in keys:
        pairs.append(key if isinstance(key, Keytime) else _as_keytime(key, rate))
        if not 0.0 <= pairs[-1].output_time < math.inf:
            raise OptionError(
                f"a keytime stands at output time {pairs[-1].output_time:g} s; the output begins at time 0",
                option="keys",
                output_times=(pairs[-1].output_time,),
            )
    if all(key.output_time != 0.0 for key in pairs):
        pairs.append(Keytime(input_time=0.0, output_time=0.0))
    last = max(pairs)
    if length == "free":
        if abs(last.input_time - motion.end_time) < 1e-9:
            raise OptionError(
                f"the last keytime shows the clip's end at output time {last.output_time:g} s: nothing is left whose "
                "length could be free",
                option="length",
                output_times=(last.output_time,),
            )
        return (*_without_doubles(pairs), Keytime(input_time=motion.end_time, output_time=math.inf))
    if length is not None:
        end = float((parse_length(length, motion.n_frames, rate) - 1) / rate)
        if last.output_time > end + 1e-9:
            raise OptionError(
                f"a keytime stands at output time {last.output_time:g} s, beyond the output's last frame at {end:g} s",
                option="keys",
                output_times=(last.output_time,),
            )
    else:
        end = last.output_time + (motion.end_time - last.input_time)
    if end > last.output_time + 1e-9:
        pairs.append(Keytime(input_time=motion.end_time, output_time=end))
    return _without_doubles(pairs)


@contextlib.contextmanager
def asking_for_a_share(motion: AnyMotion, length: str | float | None) -> Iterator[None]:
    """Ask, where a bare length such as 0.65 (seconds) leaves hardly anything of the input, whether 65 % was meant.

    Nobody who meant the seconds is stopped: an error gets the question added, and success a warning.

    Warns
    -----
    RetimeWarning
        The length is a bare number of seconds, so small that a share may have been meant.
    """
    hint = factor_hint(length)
    try:
        yield
    except InfeasibleWarpError as error:
        error.args = (f"{str(error).removesuffix('.')}{hint}.",) if hint else error.args
        raise
    if hint and length is not None:
        share = parse_length(length, motion.n_frames, motion.rate) / motion.n_frames
        if share * _HARDLY_MEANT < 1:
            warnings.warn(
                f"a length of {length} is {length} seconds, {share:.1%} of the input{hint}", RetimeWarning, stacklevel=4
            )


def _as_keytime(key: str | Sequence[float | str | None], rate: Fraction) -> Keytime:
    """Read one key as people write it."""
    if isinstance(key, str):
        input_time, output_time, *tangent = read_key(key).at(rate)
        return Keytime(input_time=input_time, output_time=output_time, speed=tangent[0] if tangent else None)
    if not isinstance(key, Sequence | np.ndarray) or len(key) not in (2, 3) or key[0] is None or key[1] is None:
        raise OptionError(
            f"a key is (input time, output time), with a speed where it has a tangent; found {key!r}", option="keys"
        )
    speed = key[2] if len(key) == 3 else None
    return Keytime(
        input_time=parse_time(key[0], rate),
        output_time=parse_time(key[1], rate),
        speed=None if speed is None else parse_speed(speed),
    )


def _without_doubles(keytimes: Sequence[Keytime]) -> tuple[Keytime, ...]:
    """Put keytimes in output order; of the same one twice keep the one with a tangent."""
    kept: dict[Keytime, Keytime] = {}
    for key in sorted(keytimes):
        other = kept.setdefault(key, key)
        if None not in (key.speed, other.speed) and key.speed != other.speed:
            raise OptionError(
                f"the keytime at output time {key.output_time:g} s has two speeds, {other.speed:g} and {key.speed:g}",
                option="keys",
                output_times=(key.output_time,),
            )
        if other.speed is None:
            kept[key] = key
    return tuple(kept.values())


def check_keytimes(keytimes: Sequence[Keytime], input_end: float) -> tuple[Keytime, ...]:
    """Put keytimes in output order; refuse any that no warp of this input can meet.

    Raises
    ------
    InfeasibleWarpError
        Fewer than two, two at one output time, or one outside the input.
    OptionError
        A tangent's speed is not above 0.
    """
    ordered = tuple(sorted(keytimes))
    if len(ordered) < 2:
        raise InfeasibleWarpError("a warp needs at least two keytimes, its ends")
    for span, (before, after) in enumerate(itertools.pairwise(ordered)):
        if not after.output_time - before.output_time >= _CLOSEST:
            raise InfeasibleWarpError(
                f"two keytimes stand at output time {after.output_time:g} s, or all but (input times "
                f"{before.input_time:g} s and {after.input_time:g} s): move or delete one",
                span=span,
                option="keys",
                output_times=(before.output_time, after.output_time),
            )
    for key in ordered:
        check_speed(key)
        if MOST_SECONDS < key.output_time < math.inf:
            raise OptionError(
                f"an output time of {key.output_time:g} s is asked for; no output is longer than {MOST_SECONDS:g} s",
                option="keys",
                output_times=(key.output_time,),
            )
        if not (key.output_time > -math.inf and -1e-9 <= key.input_time <= input_end + 1e-9):
            raise InfeasibleWarpError(
                f"the keytime at output time {key.output_time:g} s asks for input time {key.input_time:g} s, but the "
                f"input runs from 0 to {input_end:g} s",
                option="keys",
                output_times=(key.output_time,),
            )
    return ordered
