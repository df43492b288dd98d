"""Keytimes, spans, and the reduction of any warp to compression (§3.1).

The search only ever selects frames of an increasing sequence. What it is offered is the input unrolled along its
keytimes: upsampled, so that a step below `upsample` plays slower than life; backwards where a span runs backward;
one frame repeated where a span holds. One search then meets all keytimes at once.
"""

from __future__ import annotations

import contextlib
import itertools
import math
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from retime.brief import brief_repr, kind_of
from retime.errors import InfeasibleWarpError, OptionError, RetimeWarning
from retime.kernels import FloatArray, IntArray
from retime.motion.grammar import factor_hint, parse_length, parse_speed, parse_time, read_key
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.curve import Keytime, Warp, check_speed

# Of the unrolled input: weeks of motion, or a slow-down that no clip needs.
MOST_FRAMES = 50_000_000
# Mean playback speed of a span.
SLOWEST_SEARCHED = 1 / 32
# A length this many times shorter than the input may have been meant as a factor.
_HARDLY_MEANT = 8


@dataclass(frozen=True, eq=False)
class Reduction:
    """A warp's search, reduced to selecting frames.

    Attributes
    ----------
    keytimes : tuple of Keytime
        In output order, ends included.
    positions : tuple of int
        Each keytime's output frame, at the analysis rate.
    frames : tuple of int
        Each keytime's place in the unrolled input.
    input_times : float array, shape (n_input,)
        Input time of every unrolled frame, seconds.
    still : tuple of bool
        For each span whether it holds, or moves too slowly to search: it is offered one frame a step.
    rate : float
        Analysis rate, Hz.
    upsamples : tuple of int
        For each span its unrolled frames per analysis period: a step of that many is unit speed.
    free : bool
        The length is the search's to find: the last keytime's output time is infinite, its position a placeholder.
    """

    keytimes: tuple[Keytime, ...]
    positions: tuple[int, ...]
    frames: tuple[int, ...]
    input_times: FloatArray
    still: tuple[bool, ...]
    rate: float
    upsamples: tuple[int, ...]
    free: bool = False

    __repr__ = brief_repr

    @property
    def n_input(self) -> int:
        """Frames offered to the search."""
        return len(self.input_times)

    @property
    def n_output(self) -> int:
        """Frames to select."""
        return self.positions[-1] + 1

    @property
    def anchors(self) -> tuple[tuple[int, int], ...]:
        """Pairs (output position, unrolled frame) that the path must pass."""
        return tuple(zip(self.positions, self.frames, strict=True))

    @property
    def held(self) -> NDArray[np.bool_]:
        """Whether the step that leaves an unrolled frame is in a still span, shape (n_input,)."""
        held = np.zeros(self.n_input, dtype=bool)
        for span, still in enumerate(self.still):
            held[self.frames[span] : self.frames[span + 1]] = still
        return held

    @property
    def upsample_at(self) -> IntArray:
        """Upsampling of the step that leaves an unrolled frame, shape (n_input,); the last one repeats."""
        lengths = np.diff(self.frames)
        lengths[-1] += 1
        return np.repeat(np.array(self.upsamples, dtype=np.int64), lengths)

    @property
    def upsample(self) -> int:
        """The finest upsampling of any span."""
        return max(self.upsamples)

    def with_path(
        self, path: IntArray, output_rate: float, *, least_end: float = 0.0, most_end: float = math.inf
    ) -> Reduction:
        """Give a free reduction the length that its search found, to the nearest frame at `output_rate`.

        The output ends between `least_end` and `most_end`, seconds.
        """
        start, before, after = self.positions[-2], self.keytimes[-2], self.keytimes[-1]
        n_steps = len(path) - 1 - start
        # The last span's end moved to an analysis frame; at the span's mean speed the rest takes this long.
        offered = float(path[-1] - path[start]) / (self.rate * self.upsamples[-1])
        rest = (abs(after.input_time - before.input_time) - offered) * (n_steps / self.rate) / offered
        wanted = before.output_time + n_steps / self.rate + rest
        wanted = min(max(wanted, least_end), most_end)
        end = max(round(wanted * output_rate), math.floor(before.output_time * output_rate) + 1) / output_rate
        keytimes = (*self.keytimes[:-1], replace(after, output_time=end))
        return replace(self, keytimes=keytimes, positions=(*self.positions[:-1], len(path) - 1), free=False)


def refuse_single_frame(motion: Motion | Signal) -> None:
    """Raise OptionError where a clip has one frame."""
    if motion.n_frames < 2:
        raise OptionError(f"{motion.name or 'the input'} has one frame: there is no timing to change", option="motion")


def as_keytimes(
    motion: Motion | Signal, length: str | float | None, keys: Sequence[str | Sequence[float | str | None] | Keytime]
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
def asking_for_a_share(motion: Motion | Signal, length: str | float | None) -> Iterator[None]:
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
        if not after.output_time > before.output_time:
            raise InfeasibleWarpError(
                f"two keytimes stand at output time {after.output_time:g} s (input times {before.input_time:g} s and "
                f"{after.input_time:g} s): move or delete one",
                span=span,
                option="keys",
                output_times=(before.output_time, after.output_time),
            )
    for key in ordered:
        check_speed(key)
        if not (key.output_time > -math.inf and -1e-9 <= key.input_time <= input_end + 1e-9):
            raise InfeasibleWarpError(
                f"the keytime at output time {key.output_time:g} s asks for input time {key.input_time:g} s, but the "
                f"input runs from 0 to {input_end:g} s",
                option="keys",
                output_times=(key.output_time,),
            )
    return ordered


def reduce_to_compression(
    keytimes: Sequence[Keytime], input_end: float, *, rate: float, upsample: int | Sequence[int] = 1
) -> Reduction:
    """Unroll the input along its keytimes at the analysis rate (§3.1).

    Keytimes are moved to the nearest frame of the search, by at most half an analysis period; `knots_of_path` puts
    them back. A span that plays below 1/32 on average is taken for a hold, and moves evenly: nothing in it is worth a
    search, and steps so fine would slow the search for all the rest.

    Parameters
    ----------
    keytimes : sequence of Keytime
        Ends included. Equal input times hold, decreasing ones run backward. An infinite output time of the last one
        leaves the length free.
    input_end : float
        Time of the last input frame, seconds.
    rate : float
        Analysis rate, Hz.
    upsample : int or sequence of int
        Unrolled frames per analysis period, of all spans or of each.

    Raises
    ------
    InfeasibleWarpError
        The keytimes contradict each other, or stand closer than an analysis period.
    OptionError
        `upsample` below 1, or more frames than anyone can wait for.
    """
    ordered = check_keytimes(keytimes, input_end)
    n_spans = len(ordered) - 1
    upsamples = (upsample,) * n_spans if isinstance(upsample, int | np.integer) else tuple(upsample)
    if min(upsamples) < 1:
        raise OptionError(f"upsample must be at least 1, found {min(upsamples)}", option="upsample")
    if len(upsamples) != n_spans:
        raise OptionError(f"found {len(upsamples)} upsamplings for {n_spans} spans between keytimes")
    start = ordered[0].output_time
    free = math.isinf(ordered[-1].output_time)
    positions = [nearest_frame((key.output_time - start) * rate) for key in ordered if key.output_time < math.inf]
    if free:
        positions.append(positions[-1] + 1)
    places = [
        (nearest_frame(before.input_time * rate * finer), nearest_frame(after.input_time * rate * finer))
        for (before, after), finer in zip(itertools.pairwise(ordered), upsamples, strict=True)
    ]
    steps = [after - before for before, after in itertools.pairwise(positions)]
    slow = [
        abs(after.input_time - before.input_time) < SLOWEST_SEARCHED * (after.output_time - before.output_time)
        for before, after in itertools.pairwise(ordered)
    ]
    still = tuple(
        a == b or (crawls and abs(b - a) < n_steps) for (a, b), n_steps, crawls in zip(places, steps, slow, strict=True)
    )
    n_input = 1 + sum(
        n_steps if at_rest else abs(b - a) for (a, b), n_steps, at_rest in zip(places, steps, still, strict=True)
    )
    if n_input > MOST_FRAMES:
        raise OptionError(
            f"the keytimes with upsample={max(upsamples)} at {rate:g} Hz need {n_input:.2g} frames of input; "
            f"{MOST_FRAMES:.2g} is the most. Ask for less slow-down or a shorter hold, or lower the rate or upsample"
        )
    frames = [0]
    unrolled = [np.array([places[0][0] / (rate * upsamples[0])])]
    for span, ((begin, end), n_steps, finer) in enumerate(zip(places, steps, upsamples, strict=True)):
        if n_steps < 1:
            raise InfeasibleWarpError(
                f"the keytimes at output times {ordered[span].output_time:g} s and "
                f"{ordered[span + 1].output_time:g} s are closer than one frame at the analysis rate of {rate:g} Hz: "
                "move them apart, or raise the rate",
                span=span,
                option="keys",
                output_times=(ordered[span].output_time, ordered[span + 1].output_time),
            )
        change, grid = end - begin, rate * finer
        if still[span]:
            ends = (ordered[span].input_time, ordered[span + 1].input_time)
            unrolled.append(np.linspace(*ends, n_steps + 1)[1:] if change else np.full(n_steps, begin / grid))
        else:
            unrolled.append((begin + np.sign(change) * np.arange(1, abs(change) + 1)) / grid)
        frames.append(frames[-1] + len(unrolled[-1]))
    input_times = np.concatenate(unrolled)
    # A key between spans that are offered in other steps is shown where the finer one has it.
    for i, (one, other) in enumerate(itertools.pairwise(upsamples), start=1):
        if one != other:
            grid = rate * max(one, other)
            input_times[frames[i]] = nearest_frame(ordered[i].input_time * grid) / grid
    input_times = np.clip(input_times, 0.0, input_end)
    return Reduction(ordered, tuple(positions), tuple(frames), input_times, still, rate, upsamples, free)


def nearest_frame(place: float) -> int:
    """Round halves up: to even, as `round` does, two keytimes a period apart could meet in one frame."""
    return math.floor(place + 0.5 + 1e-6)


def knots_of_path(
    reduction: Reduction,
    path: IntArray,
    *,
    speeds: FloatArray | None = None,
    bounds: tuple[FloatArray, FloatArray] | None = None,
) -> Warp:
    """Turn a frame path into the polyline through its frames, meeting every keytime exactly.

    Ends and keytimes rarely fall on analysis frames, and a wished speed rarely on a whole step. In each span the rest,
    at most one period, goes to the steps that do not play at unit speed anyway, so that what the search kept at unit
    speed stays there; where there are too few of those, to all that need not keep their speed; at last to all. None
    is driven beyond its bounds by that: what it can't take, the others do.

    Parameters
    ----------
    reduction : Reduction
        Not free.
    path : int array, shape (n_output,)
        Unrolled frames.
    speeds : float array, shape (n_output - 1,), optional
        Playback speeds that steps must have, without sign; nan where they may give
        (`retime.warp.control.kept_speeds`).
    bounds : (float array, float array), each of shape (n_output - 1,), optional
        The slowest and the fastest that each step may play, without sign (`retime.warp.control.speed_bounds`); equal
        where the speed is fixed. Where the mean speed of a span lies beyond them, because its keytimes are a fraction
        of a frame too close for its steps, that mean is the bound.
    """
    output_times: list[FloatArray] = [np.array([reduction.keytimes[0].output_time])]
    input_times: list[FloatArray] = [np.array([reduction.keytimes[0].input_time])]
    period = 1.0 / reduction.rate
    for span in range(len(reduction.keytimes) - 1):
        before, after = reduction.keytimes[span], reduction.keytimes[span + 1]
        first, last = reduction.positions[span], reduction.positions[span + 1]
        steps = np.diff(path[first : last + 1]).astype(np.float64)
        kept = np.full(len(steps), np.nan) if speeds is None else speeds[first:last]
        loose = np.isnan(kept)
        change, length = after.input_time - before.input_time, after.output_time - before.output_time
        held = reduction.still[span]
        moved = steps * (0.0 if held else period / reduction.upsamples[span])
        spacing = np.where(loose, period, moved / np.where(loose, 1.0, kept))
        if held:
            moved = np.full(len(steps), abs(change) / len(steps))
        low, high = np.zeros(len(steps)), np.full(len(steps), np.inf)
        yielding = loose
        if bounds is not None and not held:
            low, high = bounds[0][first:last], bounds[1][first:last]
            # A step that is kept because it stands at the end of a range may move into it; a fixed speed has no range.
            yielding = loose | (low < high)
            mean = abs(change) / length
            low, high = np.minimum(low, mean), np.maximum(high, mean)
        choices = (loose & (steps != reduction.upsamples[span]), loose, yielding)
        spacing, moved = _stretched(spacing, moved, length, abs(change), choices, low, high)
        output_times.append(before.output_time + np.cumsum(spacing))
        input_times.append(before.input_time + math.copysign(1.0, change) * np.cumsum(moved))
        output_times[-1][-1], input_times[-1][-1] = after.output_time, after.input_time
    return Warp(np.concatenate(output_times), np.concatenate(input_times), reduction.keytimes, method="guided")


def _stretched(
    spacing: FloatArray,
    moved: FloatArray,
    output: float,
    change: float,
    choices: Sequence[NDArray[np.bool_]],
    low: FloatArray,
    high: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Change the steps so that they add up to given lengths of output and input.

    Of the first two choices the first one changes that need not change by more than a quarter; else the second, by as
    much as three quarters; else the third, by as much as it takes. One that can't do it between the bounds won't do.
    Where none can, the first two try without the slowest bounds, and then without any, for speeds that are fixed come
    before bounds. Where not even that will do, all steps change.
    """
    usual = [(choices[0], 0.25), (choices[1], 0.25), (choices[1], 0.75)]
    zero, beyond = np.zeros_like(low), np.full_like(high, np.inf)
    attempts = [(*one, low, high) for one in (*usual, (choices[2], 0.999))]
    attempts += [(*one, zero, limit) for limit in (high, beyond) for one in usual]
    for choice, most, slowest, fastest in attempts:
        pieces = [
            (lengths, total - lengths.sum(), lengths[choice].sum())
            for lengths, total in ((spacing, output), (moved, change))
        ]
        if all(abs(rest) <= most * loose for _, rest, loose in pieces):
            first, second = (
                np.where(choice, lengths * (1 + (rest / loose if loose else 0.0)), lengths)
                for lengths, rest, loose in pieces
            )
            bounded = _bounded(first, second, change, choice, slowest, fastest)
            if bounded is not None:
                return first, bounded
    spacing, moved = spacing * (output / spacing.sum()), moved * (change / moved.sum() if change else 0.0)
    # Steps with narrow bounds of their own may leave too little to the others: the widest bounds serve all.
    every = np.ones(len(spacing), dtype=bool)
    bounded = _bounded(spacing, moved, change, every, np.full_like(low, low.min()), np.full_like(high, high.max()))
    return spacing, moved if bounded is None else bounded


def _bounded(
    spacing: FloatArray, moved: FloatArray, change: float, choice: NDArray[np.bool_], low: FloatArray, high: FloatArray
) -> FloatArray | None:
    """Scale the speeds of chosen steps by one factor, each stopping at its bounds: the moves then add up to `change`.

    None where even all of them at their bounds don't add up to it. Moves that add up and lie between their bounds come
    back as they are.
    """
    least, most = low[choice] * spacing[choice], high[choice] * spacing[choice]
    some = moved[choice]
    if not (some > 0).all() or bool(((some >= least) & (some <= most)).all()):
        return moved
    wanted = change - moved[~choice].sum()
    near = 1e-12 * change
    if not least.sum() - near <= wanted <= most.sum() + near:
        return None
    # The sum grows with the factor, straight between the factors at which a step meets a bound.
    corners = np.unique(np.concatenate([least / some, most / some]))

    def total(factor: float) -> float:
        return float(np.clip(factor * some, least, most).sum())

    first, last = 0, len(corners) - 1
    while last - first > 1:
        middle = (first + last) // 2
        first, last = (middle, last) if total(corners[middle]) <= wanted else (first, middle)
    a, b = float(corners[first]), float(corners[last])
    rise = total(b) - total(a)
    factor = a + (b - a) * (wanted - total(a)) / rise if rise > 0 else a
    result = moved.copy()
    result[choice] = np.clip(factor * some, least, most)
    return result
