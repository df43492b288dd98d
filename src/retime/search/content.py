"""What a step does not show: a price on leaping over poses, in feature units.

The plain sum pays for what is shown, not for what is left out: it may leap over a whole hop in two or three steps. Here
a step pays for how far the poses between its ends lie from the line between them, and for how they accelerate.
"""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.kernels import StepPairs
from retime.progress import look
from retime.search.reduction import Reduction


def content_prices(
    poses: FloatArray, reduction: Reduction, steps: StepPairs, *, weight: float, time_scale: float, itself: bool
) -> FloatArray:
    """Return what each step costs where it begins, shape (n_input, n_steps); in feature units.

    A step from frame j to j + b, at an upsampling of U, costs::

        w max(0, b - U) / ((b - 1) U) * sum over j < l < j + b of | [p e_l, q τ² ÿ_l] |

    e_l is how far pose l lies from the line between the poses that are shown. Rushing through stillness costs nothing.
    Steps up to unit speed leave nothing out.

    Parameters
    ----------
    poses : float array, shape (n_input, n_numbers)
        Of the unrolled input.
    reduction : Reduction
        The spans.
    steps : StepPairs
        The steps.
    weight : float
        w.
    time_scale : float
        τ, seconds.
    itself : bool
        The input moves like itself. Moving like another it is not charged for its own accelerations, which are the very
        speeds that may have to change; the distance from the line weighs twice as much.
    """
    n_input, longest = len(poses), steps.longest
    upsample_at = reduction.upsample_at
    p = (time_scale * reduction.rate) ** 2 / 9 * (1.0 if itself else 2.0)
    # Squared distances of poses up to the longest step apart: apart[k, j] = |y_(j+k) - y_j|².
    apart = np.zeros((longest + 1, n_input))
    for k in range(1, min(longest, n_input - 1) + 1):
        change = poses[k:] - poses[:-k]
        apart[k, :-k] = np.einsum("fn,fn->f", change, change)
    bent = _accelerations(poses, upsample_at) * (time_scale * reduction.rate) ** 2 if itself else np.zeros(n_input)
    prices = np.zeros((n_input, steps.n_steps))
    for place, step in enumerate(steps.steps.tolist()):
        if step < 2 or step >= n_input:
            continue
        look()
        here = np.arange(n_input - step)
        share = np.maximum(0, step - upsample_at[here]) / ((step - 1) * upsample_at[here])
        total = np.zeros(len(here))
        for inner in range(1, step):
            t = inner / step
            # Stewart's theorem: the distance of a point from one that divides a side.
            off = (1 - t) * apart[inner, here] + t * apart[step - inner, here + inner] - t * (1 - t) * apart[step, here]
            total += np.sqrt(p * p * np.maximum(off, 0.0) + bent[here + inner] ** 2)
        prices[here, place] = weight * share * total
    prices[reduction.held] = 0.0
    return prices


def _accelerations(poses: FloatArray, upsample_at: IntArray) -> FloatArray:
    """Lengths of the second differences over an analysis period to either side, shape (n_input,); 0 near the ends."""
    found = np.zeros(len(poses))
    for upsample in set(upsample_at.tolist()):
        inner = np.arange(upsample, len(poses) - upsample)
        inner = inner[upsample_at[inner] == upsample]
        second = poses[inner + upsample] - 2 * poses[inner] + poses[inner - upsample]
        found[inner] = np.sqrt(np.einsum("fn,fn->f", second, second))
    return found
