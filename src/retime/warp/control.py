"""What a person asks of the timing beyond keytimes: tangents, locks, speed limits, smoothness (difficult, says §5).

An edge of the search sees three frames, so it knows the step before and the step after its middle one. Every wish
here is a step that is allowed or not, or a price on two steps that differ: it costs the search no state, and the
result stays the exact optimum.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from retime.checks import real
from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import FloatArray, IntArray
from retime.warp.curve import Keytime
from retime.warp.keytimes import Reduction, nearest_frame

BoolArray = NDArray[np.bool_]
# Whether all keytimes can be met, given an upsampling (of all spans or of each) and max_skip.
Fits = Callable[[int | tuple[int, ...], int], bool]

MAX_UPSAMPLE = 24
# The kernels keep a step in a byte.
MAX_STEP = 255
_CLOSE = 1e-6
# How far a step may be from a fixed speed that it stands for.
_NEAR = 0.03


@dataclass(frozen=True)
class Lock:
    """A span of the input that plays at a given speed, or inside a range of speeds.

    A lock from 0 to 1 keeps every frame: the span may be slowed down but not cut.

    Attributes
    ----------
    start, end : float
        Input times, seconds.
    slowest, fastest : float
        Playback speeds; equal ones fix the speed.

    Raises
    ------
    OptionError
        The span is empty, or the speeds are no range of speeds above 0.
    """

    start: float
    end: float
    slowest: float = 1.0
    fastest: float = 1.0

    def __post_init__(self) -> None:
        for name in ("start", "end", "slowest", "fastest"):
            object.__setattr__(self, name, real(getattr(self, name), f"the {name} of a lock"))
        if not (math.isfinite(self.start) and math.isfinite(self.end) and self.start < self.end):
            raise OptionError(f"a lock needs a span of the input; {self.start:g} s to {self.end:g} s is none")
        if not (0 <= self.slowest <= self.fastest and 0 < self.fastest < math.inf):
            raise OptionError(
                f"a lock needs speeds above 0, the slowest first; found {self.slowest:g} to {self.fastest:g}"
            )

    @property
    def fixed(self) -> bool:
        """Whether only one speed is allowed."""
        return self.slowest == self.fastest

    def __str__(self) -> str:
        speeds = f"{self.slowest:g}" if self.fixed else f"{self.slowest:g} to {self.fastest:g}"
        return f"{self.start:g}–{self.end:g} s at {speeds}"


def upsample_for(
    least: int,
    locks: Sequence[Lock],
    tangents: Sequence[float],
    slowest: float = 0.0,
    fastest: float = math.inf,
) -> int:
    """Find the smallest upsampling that can play every wished speed.

    A fixed speed needs a step within 3 % of it: `retime.warp.keytimes.knots_of_path` makes it exact. A range needs a
    step inside it. The limits of the whole clip need steps within 5 % of them, where less than 24 and steps of 64 can
    give that.

    Parameters
    ----------
    least : int
        Upsampling that the keytimes ask for.
    locks : sequence of Lock
        Spans at given speeds.
    tangents : sequence of float
        Speeds at keytimes.
    slowest, fastest : float
        Playback speeds for the whole clip.

    Raises
    ------
    OptionError
        No upsampling plays them all; names one that can't be played.
    """
    fixed = [lock.fastest for lock in locks if lock.fixed] + [abs(speed) for speed in tangents]
    ranges = [(lock.slowest, lock.fastest) for lock in locks if not lock.fixed] + [(slowest, fastest)]

    def plays(upsample: int) -> bool:
        return all(_fixed_step(speed, upsample) for speed in fixed) and all(_steps(*pair, upsample) for pair in ranges)

    def near_limits(upsample: int) -> bool:
        steps = _steps(slowest, fastest, upsample)
        low = slowest == 0 or steps[0] <= 1.05 * slowest * upsample
        return low and (fastest == math.inf or 0.95 * fastest * upsample <= steps[-1] <= 64)

    # A long result asks for more than 24 by itself.
    most = MAX_UPSAMPLE if least <= MAX_UPSAMPLE // 2 else 2 * least
    able = [upsample for upsample in range(least, most + 1) if plays(upsample)]
    for upsample in able:
        if near_limits(upsample):
            return upsample
    if able:
        return able[0]
    for speed in fixed:
        if not any(_fixed_step(speed, upsample) for upsample in range(1, MAX_UPSAMPLE + 1)):
            raise OptionError(f"a speed of {speed:g} is beyond what can be played, 1/{MAX_UPSAMPLE} to {MAX_STEP}")
    for low, high in ranges:
        if not any(_steps(low, high, upsample) for upsample in range(1, MAX_UPSAMPLE + 1)):
            raise OptionError(f"no step plays between {low:g} and {high:g} times the speed: widen that range")
    wanted = [*(f"{speed:g}" for speed in fixed), *(f"{low:g} to {high:g}" for low, high in ranges if high < math.inf)]
    raise OptionError(
        f"no upsampling from {least} to {most} plays all of the wanted speeds {', '.join(wanted)}: choose "
        "fractions with a common denominator"
    )


def _fixed_step(speed: float, upsample: int, most: int = MAX_STEP) -> int | None:
    """Return the step nearest to a fixed speed, if it is near enough."""
    step = max(1, round(speed * upsample))
    return step if step <= most and abs(step - speed * upsample) <= _NEAR * speed * upsample else None


def _steps(slowest: float, fastest: float, upsample: int, most: int = MAX_STEP) -> range:
    """Return the steps whose speed lies in a range."""
    return range(
        max(1, math.ceil(slowest * upsample - _CLOSE)),
        math.floor(min(fastest * upsample, float(most)) + _CLOSE) + 1,
    )


def _lock_steps(lock: Lock, upsample: int, max_skip: int) -> range:
    """Return the steps that a lock allows."""
    if not lock.fixed:
        return _steps(lock.slowest, lock.fastest, upsample, max_skip)
    step = _fixed_step(lock.fastest, upsample, max_skip)
    return range(0) if step is None else range(step, step + 1)


@dataclass(frozen=True)
class LockedSpan:
    """Where a lock binds the unrolled input.

    Attributes
    ----------
    first, last : int
        Unrolled frames that the path must visit.
    steps : range
        The steps that it may take between them.
    speed : float, optional
        Where the lock fixes it.
    """

    first: int
    last: int
    steps: range
    speed: float | None = None


def locked_spans(
    reduction: Reduction, max_skip: int, input_end: float, locks: Sequence[Lock]
) -> tuple[LockedSpan, ...]:
    """Find the unrolled frames that locks bind.

    A lock begins at the unrolled frame nearest to its start, and ends after the whole number of steps that brings it
    nearest to its end. It binds every span between keytimes that shows some of it, forward or backward, each on its
    own: a keytime inside a lock is kept, and the lock goes on from there.

    Parameters
    ----------
    reduction : Reduction
        The spans.
    max_skip : int
        Largest step.
    input_end : float
        Time of the last input frame, seconds.
    locks : sequence of Lock
        In input time.

    Returns
    -------
    tuple of LockedSpan
        In the order in which they are shown.

    Raises
    ------
    OptionError
        A lock that leaves the clip, holds a hold, binds nothing, or has a speed that no step plays.
    """
    for i, lock in enumerate(locks):
        _check_lock(lock, i, reduction, max_skip, input_end)
    bound: list[LockedSpan] = []
    places: list[list[int]] = [[] for _ in locks]
    for span in range(len(reduction.keytimes) - 1):
        shown = [(*place, i) for i, lock in enumerate(locks) if (place := _place_in_span(reduction, span, lock))]
        for first, last, i in sorted(shown):
            steps = _lock_steps(locks[i], reduction.upsamples[span], max_skip)
            # Rounding up to whole steps must not run into the lock that follows.
            room = min((other for other, *_ in shown if other >= last), default=reduction.frames[span + 1]) - first
            lengths = [length for length in range(room + 1) if _composes(length, steps)]
            nearest = min(lengths, key=lambda length: (abs(first + length - last), -length))
            places[i].append(nearest)
            if nearest:
                bound.append(LockedSpan(first, first + nearest, steps, locks[i].fastest if locks[i].fixed else None))
    for i, (lock, lengths) in enumerate(zip(locks, places, strict=True)):
        if not any(lengths):
            why = (
                f"is shorter than one step at that speed (at {reduction.rate:g} Hz)" if lengths else "is nowhere shown"
            )
            raise OptionError(f"the lock {lock} {why}", option="locks", item=i)
    return tuple(bound)


def _check_lock(lock: Lock, place: int, reduction: Reduction, max_skip: int, input_end: float) -> None:
    """Refuse a lock (`place` of them) that contradicts the clip, a hold between keytimes, or the steps there are."""
    near = 1 / reduction.rate
    if lock.start < -near or lock.end > input_end + near:
        raise OptionError(
            f"the lock {lock} leaves the clip, which runs from 0 to {input_end:g} s", option="locks", item=place
        )
    for before, after in itertools.pairwise(reduction.keytimes):
        if before.input_time == after.input_time and lock.start + 1e-9 < before.input_time < lock.end - 1e-9:
            raise OptionError(
                f"the lock {lock} holds the hold at input time {before.input_time:g} s: end one lock there, and begin "
                "another",
                option="locks",
                item=place,
            )
    for span, upsample in enumerate(reduction.upsamples):
        if _place_in_span(reduction, span, lock) and not _lock_steps(lock, upsample, max_skip):
            raise OptionError(
                f"the lock {lock} asks for speeds that upsample={upsample} and max_skip={max_skip} can't play "
                f"({_playable(upsample, max_skip)})",
                option="locks",
                item=place,
            )


def _playable(upsample: int, max_skip: int) -> str:
    least = "1" if upsample == 1 else f"1/{upsample}"
    return f"they play multiples of {least} up to {max_skip / upsample:g}"


def _place_in_span(reduction: Reduction, span: int, lock: Lock) -> tuple[int, int] | None:
    """Unrolled frames nearest to a lock's ends, where a moving span shows some of it."""
    before, after = reduction.keytimes[span].input_time, reduction.keytimes[span + 1].input_time
    low, high = max(lock.start, min(before, after)), min(lock.end, max(before, after))
    begin, stop = reduction.frames[span], reduction.frames[span + 1]
    if high - low <= 1e-9 or reduction.held[begin]:
        return None
    grid = reduction.rate * reduction.upsamples[span]
    origin = nearest_frame(before * grid)
    ends = sorted(begin + abs(nearest_frame(time * grid) - origin) for time in (low, high))
    first, last = (min(max(frame, begin), stop) for frame in ends)
    return None if first == stop else (first, last)


def allowed_steps(
    reduction: Reduction,
    max_skip: int,
    *,
    locked: Sequence[LockedSpan] = (),
    slowest: float = 0.0,
    fastest: float = math.inf,
) -> BoolArray:
    """Say which steps the search may take.

    A step may not pass a keytime, nor an end of a locked span. Held frames are not bound by speeds.

    Parameters
    ----------
    reduction : Reduction
        Its keytimes carry the tangents: the steps to and from such a keytime have its speed.
    max_skip : int
        Largest step.
    locked : sequence of LockedSpan
        From `locked_spans`.
    slowest, fastest : float
        Playback speeds for the whole clip.

    Returns
    -------
    bool array, shape (n_input, max_skip)
        ``allowed[j, b - 1]`` for the step from frame j to j + b.

    Raises
    ------
    OptionError
        A speed that no step has at this upsampling, or that `max_skip` or the speed limits forbid.
    """
    n_input = reduction.n_input
    frames = np.array(reduction.frames)
    steps = np.arange(1, max_skip + 1)
    start = np.arange(n_input)[:, None]
    stops = start + steps
    following = frames[np.minimum(np.searchsorted(frames, np.arange(n_input), side="right"), len(frames) - 1)]
    allowed: BoolArray = stops <= following[:, None]
    held, upsample_at = reduction.held, reduction.upsample_at
    for first, last, still, upsample in _spans(reduction):
        general = np.isin(steps, list(_steps(slowest, fastest, upsample, max_skip)))
        if not general.any():
            raise OptionError(
                f"no step plays between {slowest:g} and {fastest:g} times the speed with upsample={upsample} and "
                f"max_skip={max_skip} ({_playable(upsample, max_skip)}): raise them",
                option="speed",
            )
        if not still:
            allowed[first:last] &= general

    for span in locked:
        first, last = span.first, span.last
        allowed &= ~((start < first) & (stops > first))
        allowed &= ~((start < last) & (stops > last))
        allowed &= np.isin(steps, list(span.steps)) | ~((start >= first) & (stops <= last))

    for key, frame in zip(reduction.keytimes, reduction.frames, strict=True):
        if key.speed is None:
            continue
        moving = [place for place in (frame - 1, frame) if 0 <= place < n_input - 1 and not held[place]]
        for place in moving:
            other = steps != _tangent_step(key, int(upsample_at[place]), max_skip, slowest, fastest)
            if place == frame:
                allowed[frame, other] = False
            else:
                earlier = steps[other & (steps <= frame)]
                allowed[frame - earlier, earlier - 1] = False
        if not moving:
            raise OptionError(
                f"the keytime at output time {key.output_time:g} s asks for speed {key.speed:g}, but the pose is held "
                "before and after it",
                option="keys",
                output_times=(key.output_time,),
            )
    return allowed


def _spans(reduction: Reduction) -> Iterator[tuple[int, int, bool, int]]:
    """First and last unrolled frame of each span, whether it is still, and its upsampling."""
    return zip(reduction.frames[:-1], reduction.frames[1:], reduction.still, reduction.upsamples, strict=True)


def _tangent_step(key: Keytime, upsample: int, max_skip: int, slowest: float, fastest: float) -> int:
    """Return the step that plays a tangent."""
    assert key.speed is not None
    asks = f"the keytime at output time {key.output_time:g} s asks for speed {key.speed:g}, which"
    if not slowest - 1e-9 <= abs(key.speed) <= fastest + 1e-9:
        raise OptionError(
            f"{asks} the speed limits {slowest:g} to {fastest:g} forbid", option="keys", output_times=(key.output_time,)
        )
    step = _fixed_step(abs(key.speed), upsample, max_skip)
    if step is None:
        raise OptionError(
            f"{asks} upsample={upsample} and max_skip={max_skip} can't play ({_playable(upsample, max_skip)})",
            option="keys",
            output_times=(key.output_time,),
        )
    return step


def _composes(length: int, steps: range) -> bool:
    """Whether a length is a sum of steps from a range."""
    n_least = -(-length // steps[-1])
    return n_least * steps[0] <= length


def kept_speeds(
    reduction: Reduction,
    path: IntArray,
    *,
    locked: Sequence[LockedSpan] = (),
    slowest: float = 0.0,
    fastest: float = math.inf,
    loop: bool = False,
) -> FloatArray:
    """Say which steps of a path must keep their speed when it is put on its keytimes, and what speed that is.

    Steps inside a lock at a fixed speed and beside a tangent get that speed. Those at the end of a range stay as they
    are, and so do the first and the last of a loop.

    Parameters
    ----------
    reduction : Reduction
        Not free.
    path : int array, shape (n_output,)
        Unrolled frames.
    locked, slowest, fastest
        As in `allowed_steps`.
    loop : bool
        First and last speed agree.

    Returns
    -------
    float array, shape (n_output - 1,)
        Speeds without the sign of a backward span; nan for steps that may give.
    """
    before, after = path[:-1], path[1:]
    steps = after - before
    speeds = np.full(len(steps), np.nan)
    upsample_at = reduction.upsample_at[before]
    bound = np.zeros(len(steps), dtype=bool)
    for upsample in set(reduction.upsamples):
        limits = _steps(slowest, fastest, upsample)
        at_limit = ((steps == limits[0]) & (slowest > 0)) | ((steps == limits[-1]) & (fastest < math.inf))
        bound |= (upsample_at == upsample) & at_limit
    if loop:
        bound[[0, -1]] = True
    for span in locked:
        inside = (before >= span.first) & (after <= span.last)
        bound |= inside & ((steps == span.steps[0]) | (steps == span.steps[-1]))
    speeds[bound] = steps[bound] / upsample_at[bound]
    for span in locked:
        if span.speed is not None:
            speeds[(before >= span.first) & (after <= span.last)] = span.speed
    for key, frame in zip(reduction.keytimes, reduction.frames, strict=True):
        if key.speed is not None:
            speeds[(before == frame) | (after == frame)] = abs(key.speed)
    speeds[reduction.held[before]] = np.nan
    return speeds


def speed_bounds(
    reduction: Reduction,
    path: IntArray,
    max_skip: int,
    *,
    locked: Sequence[LockedSpan] = (),
    slowest: float = 0.0,
    fastest: float = math.inf,
    loop: bool = False,
) -> tuple[FloatArray, FloatArray]:
    """Say how slowly and how fast each step of a path may play when it is put on its keytimes.

    Parameters
    ----------
    reduction : Reduction
        Not free.
    path : int array, shape (n_output,)
        Unrolled frames.
    max_skip : int
        Largest step.
    locked, slowest, fastest
        As in `allowed_steps`.
    loop : bool
        First and last speed agree.

    Returns
    -------
    low, high : float arrays, shape (n_output - 1,)
        Speeds without the sign of a backward span: from 1 / upsample to max_skip / upsample, and inside the limits and
        the ranges of locks. Both are the speed itself where that is fixed: by a lock, by a tangent, at a loop's ends.
        Held steps have none: 0 and infinity.
    """
    before, after = path[:-1], path[1:]
    upsample_at = reduction.upsample_at[before].astype(np.float64)
    low, high = np.maximum(1 / upsample_at, slowest), np.minimum(max_skip / upsample_at, fastest)
    for span in locked:
        inside = (before >= span.first) & (after <= span.last)
        low[inside] = np.maximum(low, span.steps[0] / upsample_at)[inside]
        high[inside] = np.minimum(high, span.steps[-1] / upsample_at)[inside]
        if span.speed is not None:
            low[inside] = high[inside] = span.speed
    if loop:
        low[[0, -1]] = high[[0, -1]] = ((after - before) / upsample_at)[[0, -1]]
    for key, frame in zip(reduction.keytimes, reduction.frames, strict=True):
        if key.speed is not None:
            beside = (before == frame) | (after == frame)
            low[beside] = high[beside] = abs(key.speed)
    held = reduction.held[before]
    low[held], high[held] = 0.0, np.inf
    return low, high


def kept_positions(reduction: Reduction, path: IntArray, locked: Sequence[LockedSpan]) -> IntArray:
    """List the places in a path between which it must stay straight: ends of locks, neighbours of tangents."""
    kept = np.isin(path, [frame for span in locked for frame in (span.first, span.last)])
    for key, position in zip(reduction.keytimes, reduction.positions, strict=True):
        if key.speed is not None:
            kept[max(position - 1, 0) : position + 2] = True
    return np.flatnonzero(kept)


def forbid(scores: FloatArray, allowed: BoolArray) -> None:
    """Make every triple that uses a forbidden step infinite, in place."""
    max_skip = scores.shape[1]
    for step in range(1, max_skip + 1):
        scores[step:, step - 1][~allowed[:-step, step - 1]] = np.inf
    scores.transpose(0, 2, 1)[~allowed] = np.inf


def end_costs(allowed: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Return what the first and the last step cost: 0, or inf where forbidden; each of shape (max_skip,)."""
    n_input, max_skip = allowed.shape
    steps = np.arange(1, max_skip + 1)
    last = np.zeros(max_skip, dtype=bool)
    fits = steps <= n_input - 1
    last[fits] = allowed[n_input - 1 - steps[fits], steps[fits] - 1]
    return np.where(allowed[0], 0.0, np.inf), np.where(last, 0.0, np.inf)


def check_counts(
    reduction: Reduction,
    allowed: BoolArray,
    *,
    n_output: tuple[int, int] | None = None,
    wishes: str = "",
    fits: Fits | None = None,
    last_frame: float = 0.0,
) -> None:
    """Refuse keytimes between which no number of allowed steps fits.

    Parameters
    ----------
    reduction : Reduction
        The spans.
    allowed : bool array, shape (n_input, max_skip)
        From `allowed_steps`.
    n_output : (int, int), optional
        The least and the most output frames, where the length is free.
    wishes : str
        What besides `max_skip` and the upsampling forbids steps, for the message.
    fits : function of (upsample, max_skip), optional
        Whether all keytimes could be met with these: only a remedy that works is offered.
    last_frame : float
        How long the last output frame is shown, seconds: lengths count it, and are offered in frames so long.

    Raises
    ------
    InfeasibleWarpError
        Names the span, what fits there, and what would make it feasible.
    """
    for span in range(len(reduction.keytimes) - 1):
        first, last = reduction.frames[span], reduction.frames[span + 1]
        least = most = reduction.positions[span + 1] - reduction.positions[span]
        if n_output is not None and span == len(reduction.keytimes) - 2:
            least, most = (count - 1 - reduction.positions[span] for count in n_output)
        possible = _StepCounts(allowed[first:last], last - first)
        if not possible.any_between(least, most):
            raise _infeasible(reduction, span, allowed.shape[1], (least, most), possible, wishes, fits, last_frame)


def steps_fit(allowed: BoolArray, n_steps: int) -> bool:
    """Whether so many allowed steps lead from the first frame of `allowed` to the one after its last."""
    return _StepCounts(allowed, len(allowed)).any_between(n_steps, n_steps)


class _StepCounts:
    """The numbers of steps that cross a span."""

    def __init__(self, allowed: BoolArray, length: int) -> None:
        max_skip = allowed.shape[1]
        inside = np.arange(length)[:, None] + np.arange(1, max_skip + 1) <= length
        if bool(np.all(allowed | ~inside)):
            # Nothing but max_skip: every number between the least and one step a frame.
            least = -(-length // max_skip)
            self._bits = (1 << (length + 1)) - (1 << least)
            return
        # Bit n of a frame: n steps can lead there. Shifting all numbers at once keeps long spans quick.
        ahead = [0] * (max_skip + 1)
        ahead[0] = 1
        for frame in range(length):
            bits = ahead.pop(0) << 1
            ahead.append(0)
            if bits:
                for step in np.flatnonzero(allowed[frame] & inside[frame]).tolist():
                    ahead[step] |= bits
        self._bits = ahead[0]

    def any_between(self, least: int, most: int) -> bool:
        return least <= most and bool(self._bits >> max(least, 0) & ((1 << (most - max(least, 0) + 1)) - 1))

    @property
    def least(self) -> int | None:
        return (self._bits & -self._bits).bit_length() - 1 if self._bits else None

    @property
    def most(self) -> int:
        return int(self._bits.bit_length()) - 1

    def below(self, count: int) -> int | None:
        bits = self._bits & ((1 << max(count, 0)) - 1)
        return bits.bit_length() - 1 if bits else None

    def above(self, count: int) -> int | None:
        bits = self._bits >> (count + 1)
        return count + (bits & -bits).bit_length() if bits else None


class _Values(TypedDict):
    span: int
    n_input: int
    n_output: int
    max_skip: int
    output_times: tuple[float, ...]


def _infeasible(
    reduction: Reduction,
    span: int,
    max_skip: int,
    wanted: tuple[int, int],
    possible: _StepCounts,
    wishes: str,
    fits: Fits | None,
    last_frame: float,
) -> InfeasibleWarpError:
    before, after = reduction.keytimes[span], reduction.keytimes[span + 1]
    length, upsample, rate = (
        reduction.frames[span + 1] - reduction.frames[span],
        reduction.upsamples[span],
        reduction.rate,
    )

    # Where there is no keytime between the ends, the length is what can be changed; it counts the last frame.
    whole = len(reduction.keytimes) == 2 and last_frame > 0

    def asked(steps: int, rounded: Callable[[float], int]) -> str:
        if not whole:
            return f"{rounded(round(1000 * steps / rate, 6)) / 1000:g} s"
        n_frames = rounded(round(steps / (rate * last_frame), 6)) + 1
        return f"{n_frames}f ({n_frames * last_frame:.3f} s)"

    least, most = wanted
    seconds = most / rate if reduction.free else after.output_time - before.output_time
    seconds += last_frame if whole else 0.0
    into = f"{most + 1} output frames" if least == most else f"{least + 1} to {most + 1} output frames"
    where = (
        f"cannot fit input {before.input_time:.2f}–{after.input_time:.2f} s ({length + 1} frames at the analysis rate) "
        f"into {into} ({seconds:.2f} s)"
    )
    values: _Values = {
        "span": span,
        "n_input": length + 1,
        "n_output": most + 1,
        "max_skip": max_skip,
        "output_times": (before.output_time, after.output_time),
    }
    limits = " and ".join([f"max_skip={max_skip}, upsample={upsample}", *([wishes] if wishes else [])])
    if possible.least is None:
        return InfeasibleWarpError(f"{where}: {limits} leave no way through. Loosen one.", **values)
    fewer, more = possible.below(least), possible.above(most)
    if fewer is None:
        assert more is not None
        remedy = f"at least {asked(more, math.ceil)}"
        # A span may hold too few frames for any path of that length, or its steps may be too short.
        finer = False
    elif more is None:
        remedy = f"at most {asked(fewer, math.floor)}"
        finer = True
    else:
        remedy = f"{asked(fewer, round)} or {asked(more, round)}"
        finer = False
    option = None if fits is None else _better_limits(upsample, max_skip, (least, most), length, finer, fits)
    use = f"Use a length of {remedy}" if whole else f"Put these keytimes {remedy} apart"
    offered = [use, *([option] if option else []), *([f"loosen {wishes}"] if wishes else [])]
    return InfeasibleWarpError(
        f"{where}: {limits} allow {possible.least + 1} to {possible.most + 1}. {', or '.join(offered)}.",
        **values,
        min_output=possible.least + 1,
        max_output=possible.most + 1,
    )


def _better_limits(
    upsample: int, max_skip: int, wanted: tuple[int, int], length: int, finer: bool, fits: Fits
) -> str | None:
    """Find a longer step, or a finer upsampling, with which all keytimes can be met."""
    if finer:
        need = upsample * -(-wanted[0] // length)
        for better in range(max(need, upsample + 1), 2 * need + 4):
            for skip in (max_skip, min(MAX_STEP, -(-max_skip * better // upsample))):
                if fits(better, skip):
                    return f"upsample >= {better}" + (f" with max_skip={skip}" if skip != max_skip else "")
        return None
    enough = least_max_skip(upsample, max_skip, fits)
    return None if enough is None else f"max_skip >= {enough}"


def least_max_skip(upsample: int | tuple[int, ...], max_skip: int, fits: Fits) -> int | None:
    """Return the least `max_skip` above the given one with which all keytimes can be met; None where there is none."""
    low, high = max_skip, MAX_STEP
    if max_skip >= MAX_STEP or not fits(upsample, high):
        return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if fits(upsample, middle) else (middle, high)
    return high


def add_smoothness(scores: FloatArray, weight: float, reduction: Reduction) -> None:
    """Charge changes of speed: ``weight * median score * ln(b / a)²`` on every triple, in place.

    a and b are the speeds before and after its middle frame.

    Into a hold, in it and out of it nothing is charged: stopping is a keytime's wish, not the search's. The median is
    that of all triples, before any is forbidden: a lock does not change what smoothness costs elsewhere.
    """
    if not (math.isfinite(weight) and weight >= 0):
        raise OptionError(f"the smoothness weight must be 0 or more, found {weight}", option="smoothness")
    finite = scores[np.isfinite(scores)]
    if weight == 0 or not len(finite):
        return
    logs = np.log(np.arange(1, scores.shape[1] + 1))
    price = weight * float(np.median(finite))
    for first, last, before, after in _middles(reduction):
        if not (reduction.still[before] or reduction.still[after]):
            finer = math.log(reduction.upsamples[before] / reduction.upsamples[after])
            scores[first:last] += price * (logs[None, :] - logs[:, None] + finer) ** 2


def weigh_neutral(scores: FloatArray, reduction: Reduction) -> None:
    """Weigh triples so that a free length treats both clocks alike: by the square root of the local speed, in place.

    The plain sum charges every output frame, so short results are cheap; charging input time instead makes long ones
    cheap.
    """
    for first, last, before, after in _middles(reduction):
        scores[first:last] *= neutral_weights(scores.shape[1], reduction.upsamples[before], reduction.upsamples[after])


def neutral_weights(max_skip: int, before: int, after: int) -> FloatArray:
    """Return the square roots of the mean speeds of two steps, shape (max_skip, max_skip); given their upsamplings."""
    steps = np.arange(1, max_skip + 1)
    return np.asarray(np.sqrt((steps[:, None] / before + steps[None, :] / after) / 2))


def _middles(reduction: Reduction) -> Iterator[tuple[int, int, int, int]]:
    """Yield ranges of unrolled frames, with the spans of the steps before and after a frame in each."""
    yield 0, 1, 0, 0
    n_spans = len(reduction.upsamples)
    for span, (first, last, _, _) in enumerate(_spans(reduction)):
        yield first + 1, last, span, span
        yield last, last + 1, span, min(span + 1, n_spans - 1)
