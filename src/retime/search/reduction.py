"""The reduction of any warp to compression (§3.1).

The search only ever selects frames of an increasing sequence. What it is offered is the input unrolled along its
keytimes: upsampled, so that a step below `upsample` plays slower than life; backwards where a span runs backward;
one frame repeated where a span holds. One search then meets all keytimes at once.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import brief_repr
from retime.errors import InfeasibleWarpError, OptionError
from retime.search.keytimes import check_keytimes
from retime.warp.keytime import Keytime

# Frames of the unrolled input: days of motion, or a slow-down that no clip needs.
MOST_FRAMES = 10_000_000
# A span that plays slower than this on average is taken for a hold.
SLOWEST_SEARCHED = 1 / 32


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
    def held(self) -> BoolArray:
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


def reduce_to_compression(
    keytimes: Sequence[Keytime],
    input_end: float,
    *,
    rate: float,
    upsample: int | Sequence[int] = 1,
    crawling: Sequence[bool] = (),
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
    crawling : sequence of bool
        For each span whether it is to be taken for a hold although its mean speed is not that low: left out, none.

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
    if crawling:
        slow = [one or other for one, other in zip(slow, crawling, strict=True)]
    still = tuple(
        a == b or (crawls and abs(b - a) < n_steps) for (a, b), n_steps, crawls in zip(places, steps, slow, strict=True)
    )
    n_input = 1 + sum(
        n_steps if at_rest else abs(b - a) for (a, b), n_steps, at_rest in zip(places, steps, still, strict=True)
    )
    if n_input > MOST_FRAMES:
        # One number for all spans is what a person asked for.
        asked = isinstance(upsample, int | np.integer) and upsample > 1
        raise OptionError(
            f"so long an output needs a search through {n_input:.2g} frames; {MOST_FRAMES:.2g} is the most. "
            f"Ask for a shorter output or hold, for less slow-down, or for a rate below {rate:g} Hz"
            + (f" or an upsample below {upsample}" if asked else "")
        )
    frames = [0]
    unrolled = [np.array([places[0][0] / (rate * upsamples[0])])]
    for span, ((begin, end), n_steps, finer) in enumerate(zip(places, steps, upsamples, strict=True)):
        if n_steps < 1:
            raise InfeasibleWarpError(
                f"the keytimes at output times {ordered[span].output_time:g} s and "
                f"{ordered[span + 1].output_time:g} s are closer than one frame of the search, {1000 / rate:.0f} ms: "
                f"move them apart, or raise the rate above {rate:g} Hz",
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
    # A key between two spans of different upsampling is shown where the finer one has it.
    for i, (one, other) in enumerate(itertools.pairwise(upsamples), start=1):
        if one != other:
            grid = rate * max(one, other)
            input_times[frames[i]] = nearest_frame(ordered[i].input_time * grid) / grid
    input_times = np.clip(input_times, 0.0, input_end)
    return Reduction(ordered, tuple(positions), tuple(frames), input_times, still, rate, upsamples, free)


def nearest_frame(place: float) -> int:
    """Return the nearest frame, halves rounded up: rounded to even, two keytimes a period apart could meet in one."""
    return math.floor(place + 0.5 + 1e-6)
