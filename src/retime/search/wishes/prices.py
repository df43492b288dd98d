"""Prices on steps, added to the scores of triples: smoothness, and the weight of a free length."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from retime.arrays import FloatArray
from retime.errors import OptionError
from retime.kernels import StepPairs
from retime.search.reduction import Reduction
from retime.search.wishes.allowed import span_ranges

# Rows that are worked on at once: what they need stays near the processor.
_ROWS = 1024


def add_after(scores: FloatArray, prices: FloatArray, steps: StepPairs) -> None:
    """Charge each triple the price of its second step, in place.

    Parameters
    ----------
    scores : float array, shape (n_input, n_pairs)
        Of the triples.
    prices : float array, shape (n_input, n_steps)
        What each step costs where it begins.
    steps : StepPairs
        The steps.
    """
    for first in range(0, len(scores), _ROWS):
        some = scores[first : first + _ROWS]
        some += np.take(prices[first : first + _ROWS], steps.after, axis=1)


def among_every(scores: FloatArray, steps: StepPairs, every: StepPairs) -> FloatArray:
    """Put scores of pairs of steps among those of all pairs, shape (n_input, n_pairs); the others are infinite."""
    n_pairs = scores.shape[1]
    places = np.full(every.n_pairs, n_pairs)
    places[every.pair_of(steps.steps[steps.before], steps.steps[steps.after])] = np.arange(n_pairs)
    out = np.empty((len(scores), every.n_pairs))
    # One more column, for those that there are not.
    some = np.full((_ROWS, n_pairs + 1), np.inf)
    for first in range(0, len(scores), _ROWS):
        n = min(_ROWS, len(scores) - first)
        some[:n, :n_pairs] = scores[first : first + n]
        # Places lie inside by their making; to say so saves a buffer.
        np.take(some[:n], places, axis=1, out=out[first : first + n], mode="clip")
    return out


def add_smoothness(
    scores: FloatArray, weight: float, reduction: Reduction, steps: StepPairs, *, unit: float | None = None
) -> None:
    """Charge changes of speed: ``weight * median score * ln(b / a)²`` on every triple, in place.

    a and b are the speeds before and after its middle frame.

    Into a hold, in it and out of it nothing is charged: stopping is a keytime's wish, not the search's. The median is
    that of all triples, before any is forbidden: a lock does not change what smoothness costs elsewhere. Or it is
    `unit`, where scores depend on more than the triple.
    """
    if not (math.isfinite(weight) and weight >= 0):
        raise OptionError(f"the smoothness weight must be 0 or more, found {weight}", option="smoothness")
    if weight == 0:
        return
    if unit is None:
        finite = scores[np.isfinite(scores)]
        if not len(finite):
            return
        unit = float(np.median(finite))
    of_steps = np.log(steps.steps)
    logs = of_steps[steps.after] - of_steps[steps.before]
    price = weight * unit
    for first, last, before, after in _middles(reduction):
        if not (reduction.still[before] or reduction.still[after]):
            finer = math.log(reduction.upsamples[before] / reduction.upsamples[after])
            scores[first:last] += price * (logs + finer) ** 2


def weigh_neutral(scores: FloatArray, reduction: Reduction, steps: StepPairs) -> None:
    """Weigh triples so that a free length treats both clocks alike: by the square root of the local speed, in place.

    The plain sum charges every output frame, so short results are cheap; charging input time instead makes long ones
    cheap.
    """
    for first, last, before, after in _middles(reduction):
        scores[first:last] *= neutral_weights(steps, reduction.upsamples[before], reduction.upsamples[after])


def end_prices(
    scores: FloatArray, reduction: Reduction, steps: StepPairs, weight: float
) -> tuple[FloatArray, FloatArray]:
    """Return what the first and the last step cost: ``weight * median score * ln²`` of their speeds, (n_steps,) each.

    An end that holds costs nothing.
    """
    finite = scores[np.isfinite(scores)]
    price = weight * float(np.median(finite)) if len(finite) else 0.0
    logs = np.log(steps.steps)
    return tuple(  # type: ignore[return-value]
        np.zeros(steps.n_steps) if still else price * (logs - math.log(upsample)) ** 2
        for still, upsample in zip(
            (reduction.still[0], reduction.still[-1]), (reduction.upsamples[0], reduction.upsamples[-1]), strict=True
        )
    )


def neutral_weights(steps: StepPairs, before: int, after: int) -> FloatArray:
    """Return the square roots of the mean speeds of pairs of steps, shape (n_pairs,); given their upsamplings."""
    return np.asarray(np.sqrt((steps.steps[steps.before] / before + steps.steps[steps.after] / after) / 2))


def _middles(reduction: Reduction) -> Iterator[tuple[int, int, int, int]]:
    """Yield ranges of unrolled frames, with the spans of the steps before and after a frame in each."""
    yield 0, 1, 0, 0
    n_spans = len(reduction.upsamples)
    for span, (first, last, _, _) in enumerate(span_ranges(reduction)):
        yield first + 1, last, span, span
        yield last, last + 1, span, min(span + 1, n_spans - 1)
