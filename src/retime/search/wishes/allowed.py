"""Which steps the search may take: what keytimes, locks, tangents and speed limits leave.

A wish of this kind costs the search no state: an edge sees three frames, so it knows the steps on both sides.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from retime.arrays import BoolArray, FloatArray
from retime.errors import OptionError
from retime.kernels import StepPairs
from retime.search.reduction import Reduction
from retime.search.wishes.locks import LockedSpan
from retime.search.wishes.steps import NOTHING_NAMED, Named, fixed_step, playable, steps_between
from retime.warp.keytime import Keytime


def allowed_steps(
    reduction: Reduction,
    max_skip: int,
    *,
    steps: StepPairs | None = None,
    locked: Sequence[LockedSpan] = (),
    slowest: float = 0.0,
    fastest: float = math.inf,
    named: Named = NOTHING_NAMED,
) -> BoolArray:
    """Say which steps the search may take.

    A step may not pass a keytime, nor an end of a locked span. Held frames are not bound by speeds.

    Parameters
    ----------
    reduction : Reduction
        Its keytimes carry the tangents: the steps to and from such a keytime have its speed.
    max_skip : int
        Largest step.
    steps : StepPairs, optional
        The steps that there are; left out, all up to `max_skip`.
    locked : sequence of LockedSpan
        From `locked_spans`.
    slowest, fastest : float
        Playback speeds for the whole clip.
    named : Named
        What messages may call by name.

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
    on_grid = np.ones(max_skip, dtype=bool) if steps is None else np.isin(np.arange(1, max_skip + 1), steps.steps)
    lengths = np.arange(1, max_skip + 1)
    start = np.arange(n_input)[:, None]
    stops = start + lengths
    following = frames[np.minimum(np.searchsorted(frames, np.arange(n_input), side="right"), len(frames) - 1)]
    allowed: BoolArray = stops <= following[:, None]
    held, upsample_at = reduction.held, reduction.upsample_at
    for first, last, still, upsample in span_ranges(reduction):
        general = on_grid & np.isin(lengths, list(steps_between(slowest, fastest, upsample, max_skip)))
        if not general.any():
            raise OptionError(
                f"no speed from {slowest:g} to {fastest:g} can be played: {playable(upsample, max_skip, named)}. "
                f"{' or '.join(['Widen the limits', *(f'raise {name}' for name in named.names)])}",
                option="speed",
            )
        if not still:
            allowed[first:last] &= general

    for span in locked:
        first, last = span.first, span.last
        allowed &= ~((start < first) & (stops > first))
        allowed &= ~((start < last) & (stops > last))
        allowed &= np.isin(lengths, list(span.steps)) | ~((start >= first) & (stops <= last))

    for key, frame in zip(reduction.keytimes, reduction.frames, strict=True):
        if key.speed is None:
            continue
        moving = [place for place in (frame - 1, frame) if 0 <= place < n_input - 1 and not held[place]]
        for place in moving:
            other = lengths != _tangent_step(key, int(upsample_at[place]), max_skip, slowest, fastest, named)
            if place == frame:
                allowed[frame, other] = False
            else:
                earlier = lengths[other & (lengths <= frame)]
                allowed[frame - earlier, earlier - 1] = False
        if not moving:
            raise OptionError(
                f"the keytime at output time {key.output_time:g} s asks for speed {key.speed:g}, but the pose is held "
                "before and after it",
                option="keys",
                output_times=(key.output_time,),
            )
    return allowed


def span_ranges(reduction: Reduction) -> Iterator[tuple[int, int, bool, int]]:
    """First and last unrolled frame of each span, whether it is still, and its upsampling."""
    return zip(reduction.frames[:-1], reduction.frames[1:], reduction.still, reduction.upsamples, strict=True)


def _tangent_step(key: Keytime, upsample: int, max_skip: int, slowest: float, fastest: float, named: Named) -> int:
    """Return the step that plays a tangent."""
    assert key.speed is not None
    asks = f"the keytime at output time {key.output_time:g} s asks for speed {key.speed:g}, which"
    if not slowest - 1e-9 <= abs(key.speed) <= fastest + 1e-9:
        raise OptionError(
            f"{asks} the speed limits {slowest:g} to {fastest:g} forbid", option="keys", output_times=(key.output_time,)
        )
    step = fixed_step(abs(key.speed), upsample, max_skip)
    if step is None:
        raise OptionError(
            f"{asks} can't be played: {playable(upsample, max_skip, named)}",
            option="keys",
            output_times=(key.output_time,),
        )
    return step


def forbid(costs: FloatArray, allowed: BoolArray, steps: StepPairs) -> None:
    """Make every triple that uses a forbidden step infinite, in place; `costs` has the shape (n_input, n_pairs)."""
    for place, length in enumerate(steps.steps.tolist()):
        into = np.zeros(len(allowed), dtype=bool)
        into[length:] = ~allowed[: max(0, len(allowed) - length), length - 1]
        rows = np.flatnonzero(into)
        columns = np.flatnonzero(steps.before == place)
        costs[rows[:, None], columns] = np.inf
        rows = np.flatnonzero(~allowed[:, length - 1])
        columns = np.flatnonzero(steps.after == place)
        costs[rows[:, None], columns] = np.inf


def end_costs(allowed: BoolArray, steps: StepPairs) -> tuple[FloatArray, FloatArray]:
    """Return what the first and the last step cost: 0, or inf where forbidden; each of shape (n_steps,)."""
    n_input, lengths = len(allowed), steps.steps
    last = np.zeros(steps.n_steps, dtype=bool)
    fits = lengths <= n_input - 1
    last[fits] = allowed[n_input - 1 - lengths[fits], lengths[fits] - 1]
    return np.where(allowed[0, lengths - 1], 0.0, np.inf), np.where(last, 0.0, np.inf)
