"""What a person asks of the timing beyond keytimes: tangents, locks, speed limits, smoothness (difficult, says §5).

An edge of the search sees three frames, so it knows the step before and the step after its middle one. Every wish
here is a step that is allowed or not, or a price on two steps that differ: it costs the search no state, and the
result stays the exact optimum.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from retime.errors import InfeasibleWarpError, OptionError
from retime.kernels import FloatArray
from retime.warp.keytimes import Reduction

BoolArray = NDArray[np.bool_]

MAX_UPSAMPLE = 24
_CLOSE = 1e-6


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


def upsample_for(least: int, locks: Sequence[Lock], tangents: Sequence[float]) -> int:
    """Find the smallest upsampling that can play every fixed speed exactly.

    Parameters
    ----------
    least : int
        Upsampling that the keytimes ask for.
    locks : sequence of Lock
        A lock on speeds between 0 and 1 needs at least one step for them.
    tangents : sequence of float
        Speeds at keytimes.

    Raises
    ------
    OptionError
        No upsampling up to 24 plays them all; names one that it can't.
    """
    fixed = [lock.fastest for lock in locks if lock.fixed] + [abs(speed) for speed in tangents]
    ranges = [(lock.slowest, lock.fastest) for lock in locks if not lock.fixed]
    for upsample in range(least, MAX_UPSAMPLE + 1):
        if all(_steps(speed, speed, upsample) for speed in fixed) and all(
            _steps(slow, fast, upsample) for slow, fast in ranges
        ):
            return upsample
    for speed in fixed:
        if not any(_steps(speed, speed, upsample) for upsample in range(1, MAX_UPSAMPLE + 1)):
            raise OptionError(
                f"a speed of {speed:g} is not a fraction with a denominator up to {MAX_UPSAMPLE}: choose one near it"
            )
    raise OptionError(
        f"no upsampling up to {MAX_UPSAMPLE} plays all of the wanted speeds "
        f"{', '.join(f'{speed:g}' for speed in fixed)}: choose fractions with a common denominator"
    )


def _steps(slowest: float, fastest: float, upsample: int) -> range:
    """Return the steps whose speed lies in a range."""
    return range(
        max(1, math.ceil(slowest * upsample - _CLOSE)), math.floor(min(fastest * upsample, 255.0) + _CLOSE) + 1
    )


def allowed_steps(
    reduction: Reduction, max_skip: int, *, locks: Sequence[Lock] = (), slowest: float = 0.0, fastest: float = math.inf
) -> BoolArray:
    """Say which steps the search may take.

    A step may not pass a keytime. Held frames are not bound by speeds. A lock begins at its first frame, which the
    path must visit, and ends at the last one that its speeds can reach.

    Parameters
    ----------
    reduction : Reduction
        Its keytimes carry the tangents: the steps to and from such a keytime have its speed.
    max_skip : int
        Largest step.
    locks : sequence of Lock
        In input time.
    slowest, fastest : float
        Playback speeds for the whole clip.

    Returns
    -------
    bool array, shape (n_input, max_skip)
        ``allowed[j, b - 1]`` for the step from frame j to j + b.

    Raises
    ------
    OptionError
        A speed that no step has at this upsampling, or that `max_skip` forbids.
    """
    n_input, upsample = reduction.n_input, reduction.upsample
    frames = np.array(reduction.frames)
    steps = np.arange(1, max_skip + 1)
    following = frames[np.minimum(np.searchsorted(frames, np.arange(n_input), side="right"), len(frames) - 1)]
    allowed: BoolArray = np.arange(n_input)[:, None] + steps <= following[:, None]
    held = reduction.held
    general = np.isin(steps, list(_steps(slowest, fastest, upsample)))
    if not general.any():
        raise OptionError(
            f"no step plays between {slowest:g} and {fastest:g} times the speed with upsample={upsample} and "
            f"max_skip={max_skip}: raise them"
        )
    allowed &= general | held[:, None]

    for lock in locks:
        wanted = _steps(lock.slowest, lock.fastest, upsample)
        if len(wanted) == 0 or wanted[0] > max_skip:
            raise OptionError(
                f"a lock asks for speeds {lock.slowest:g} to {lock.fastest:g}, which upsample={upsample} and "
                f"max_skip={max_skip} can't play (steps of 1/{upsample} up to {max_skip / upsample:g})"
            )
        good = np.isin(steps, list(wanted))
        inside = (reduction.input_times >= lock.start - 1e-9) & (reduction.input_times <= lock.end + 1e-9) & ~held
        edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(np.int8), [0]])))
        for first, stop in edges.reshape(-1, 2):
            last = int(stop) - 1
            while last > first and not _composes(last - int(first), wanted):
                last -= 1
            if last <= first:
                continue
            start = np.arange(n_input)[:, None]
            stops = start + steps
            allowed &= ~((start < first) & (stops > first))
            allowed &= ~((start < last) & (stops > last) & (start >= first))
            allowed &= good | ~((start >= first) & (stops <= last))

    for key, frame in zip(reduction.keytimes, reduction.frames, strict=True):
        if key.speed is None:
            continue
        step = round(abs(key.speed) * upsample)
        if abs(abs(key.speed) * upsample - step) > _CLOSE or not 1 <= step <= max_skip:
            raise OptionError(
                f"the keytime at output time {key.output_time:g} s asks for speed {key.speed:g}, which "
                f"upsample={upsample} and max_skip={max_skip} can't play (steps of 1/{upsample} "
                f"up to {max_skip / upsample:g})"
            )
        other = steps != step
        if not held[frame]:
            allowed[frame, other] = False
        for b in steps[other & (steps <= frame)]:
            if not held[frame - b]:
                allowed[frame - b, b - 1] = False
    return allowed


def _composes(length: int, steps: range) -> bool:
    """Whether a length is a sum of steps from a range."""
    n_least = -(-length // steps[-1])
    return n_least * steps[0] <= length


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
    reduction: Reduction, allowed: BoolArray, max_skip: int, *, most: int | None = None, free: bool = False
) -> None:
    """Refuse keytimes between which no number of allowed steps fits; raise InfeasibleWarpError.

    Parameters
    ----------
    reduction : Reduction
        The spans.
    allowed : bool array, shape (n_input, max_skip)
        From `allowed_steps`.
    max_skip : int
        Named in the message.
    most : int, optional
        The most output frames, where the length is a range.
    free : bool
        The last span may have any length.
    """
    for span in range(len(reduction.keytimes) - 1):
        first, last = reduction.frames[span], reduction.frames[span + 1]
        least_steps, most_steps = _step_bounds(allowed[first:last], last - first)
        wanted = reduction.positions[span + 1] - reduction.positions[span]
        final = span == len(reduction.keytimes) - 2
        wanted_most = most - 1 - reduction.positions[span] if final and most is not None else wanted
        if least_steps is not None and ((free and final) or (wanted <= most_steps and wanted_most >= least_steps)):
            continue
        raise _infeasible(reduction, span, max_skip, least_steps, most_steps)


def _step_bounds(allowed: BoolArray, length: int) -> tuple[int | None, int]:
    """Least and most steps that cross a span of `length` frames; None where none do."""
    if bool(np.all(allowed[:, 0])):
        # No step of one is forbidden: the most is every frame, and greedy long steps give the least.
        full = np.all(allowed | (np.arange(length)[:, None] + np.arange(1, allowed.shape[1] + 1) > length))
        if full:
            return -(-length // allowed.shape[1]), length
    least = [math.inf] * (length + 1)
    most = [-math.inf] * (length + 1)
    least[0] = most[0] = 0
    for frame in range(length):
        if least[frame] == math.inf:
            continue
        for step in (np.flatnonzero(allowed[frame]) + 1).tolist():
            if frame + step <= length:
                least[frame + step] = min(least[frame + step], least[frame] + 1)
                most[frame + step] = max(most[frame + step], most[frame] + 1)
    return (None, 0) if least[length] == math.inf else (int(least[length]), int(most[length]))


def _infeasible(
    reduction: Reduction, span: int, max_skip: int, least_steps: int | None, most_steps: int
) -> InfeasibleWarpError:
    before, after = reduction.keytimes[span], reduction.keytimes[span + 1]
    n_input = reduction.frames[span + 1] - reduction.frames[span] + 1
    n_output = reduction.positions[span + 1] - reduction.positions[span] + 1
    where = (
        f"cannot fit input {before.input_time:.2f}–{after.input_time:.2f} s ({n_input} frames at the analysis rate) "
        f"into {n_output} output frames ({(n_output - 1) / reduction.rate:.2f} s)"
    )
    values = {"span": span, "n_input": n_input, "n_output": n_output, "max_skip": max_skip}
    if least_steps is None:
        return InfeasibleWarpError(f"{where}: the locks and tangents there leave no way through. Loosen one.", **values)
    least, most = least_steps + 1, most_steps + 1
    bound = f"max_skip={max_skip}, upsample={reduction.upsample} and what is locked allow {least} to {most}"
    if n_output < least:
        need = -(-(n_input - 1) // (n_output - 1))
        remedy = f"Use at least {least} frames ({least_steps / reduction.rate:.2f} s), or max_skip >= {need}."
    else:
        need = reduction.upsample * -(-(n_output - 1) // (n_input - 1))
        remedy = f"Use at most {most} frames ({most_steps / reduction.rate:.2f} s), or upsample >= {need}."
    return InfeasibleWarpError(f"{where}: {bound}. {remedy}", **values, min_output=least, max_output=most)


def add_smoothness(scores: FloatArray, weight: float, held: BoolArray) -> None:
    """Charge changes of speed: ``weight * median score * ln(b / a)²`` on every triple, in place.

    Held frames are not charged: stopping is a keytime's wish, not the search's.
    """
    if not (math.isfinite(weight) and weight >= 0):
        raise OptionError(f"the smoothness weight must be 0 or more, found {weight}")
    finite = scores[np.isfinite(scores)]
    if weight == 0 or not len(finite):
        return
    logs = np.log(np.arange(1, scores.shape[1] + 1))
    charge = weight * float(np.median(finite)) * (logs[None, :] - logs[:, None]) ** 2
    scores += np.where(held[:, None, None], 0.0, charge)


def neutral_weights(max_skip: int, upsample: int) -> FloatArray:
    """Weigh triples so that a free length treats both clocks alike: by the square root of the local speed.

    The plain sum charges every output frame, so short results are cheap; charging input time instead makes long ones
    cheap. Shape (max_skip, max_skip).
    """
    steps = np.arange(1, max_skip + 1)
    return np.asarray(np.sqrt((steps[:, None] + steps[None, :]) / (2 * upsample)))
