"""What a step costs that does not play as the hand did."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray
from retime.kernels import StepPairs
from retime.search.example.reading import ExampleReading
from retime.search.reduction import Reduction
from retime.search.wishes.tempo import Tempo

# What is idle is priced too, or the search could leave it out.
_LEAST_ACTIVITY = 0.1


def hand_prices(reading: ExampleReading, tempo: Tempo, reduction: Reduction, steps: StepPairs) -> FloatArray:
    """Return what each step costs where it begins, shape (n_input, n_steps).

    The step from frame j to j + b plays at the speed v = b / upsample, and costs::

        r A v (ln v - u)²

    u is the logarithm of the wanted speed and A the activity, at least 0.1, both averaged over frames j ... j + b; r
    is the clip's scale. The factor v makes it a price on *input* time: a stretch costs the same whether few frames of
    output leap over it or many crawl through it, so with a free length each moment gets its wanted speed, and with a
    given one all share alike in what is too much. A hold costs nothing: stopping is a keytime's wish.
    """
    n_input = reduction.n_input
    wanted = _sums(reading.log_speeds_at(reduction.input_times))
    activity = _sums(np.maximum(tempo.activity_at(reduction.input_times), _LEAST_ACTIVITY))
    prices = np.zeros((n_input, steps.n_steps))
    for place, step in enumerate(steps.steps.tolist()):
        if step >= n_input:
            continue
        speeds = step / reduction.upsample_at[: n_input - step]
        mean = (wanted[step + 1 :] - wanted[: n_input - step]) / (step + 1)
        moving = (activity[step + 1 :] - activity[: n_input - step]) / (step + 1)
        prices[: n_input - step, place] = moving * speeds * (np.log(speeds) - mean) ** 2
    # Where nothing moves at all, the price is all that there is to go by.
    prices *= tempo.scale or 1.0
    prices[reduction.held] = 0.0
    return prices


def _sums(values: FloatArray) -> FloatArray:
    """Add up the first 0, 1, ... values, shape (n + 1,)."""
    return np.concatenate([[0.0], np.cumsum(values)])
