"""What values that are missing weigh in a search: nothing."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray
from retime.kernels import StepPairs
from retime.search.poses.references import PoseTracks
from retime.search.reduction import Reduction


def scores_without_gaps(tracks: PoseTracks, reduction: Reduction, scores: FloatArray) -> FloatArray:
    """Let frames of gaps weigh nothing: each of their steps scores what it does elsewhere, on average.

    A score of 0 would not be nothing: the path would stay where nothing is known, as that costs least.
    """
    if not tracks.has_gaps:
        return scores
    lost = tracks.missing_at(reduction.input_times)
    known = np.isfinite(scores) & ~lost[:, None]
    sums = np.where(known, scores, 0.0).sum(axis=0)
    usual = np.divide(sums, known.sum(axis=0), out=np.zeros_like(sums), where=known.any(axis=0))
    return np.where(lost[:, None] & np.isfinite(scores), usual, scores)


def content_without_gaps(tracks: PoseTracks, reduction: Reduction, steps: StepPairs, prices: FloatArray) -> FloatArray:
    """Let frames of gaps weigh nothing in the price on what is left out: such steps cost what they do elsewhere."""
    if not tracks.has_gaps:
        return prices
    before = np.concatenate([[0], np.cumsum(tracks.missing_at(reduction.input_times))])
    ends = np.minimum(np.arange(len(prices))[:, None] + steps.steps + 1, len(prices))
    lost = before[ends] > before[: len(prices), None]
    sums, known = np.where(lost, 0.0, prices).sum(axis=0), (~lost).sum(axis=0)
    return np.where(lost, np.divide(sums, known, out=np.zeros_like(sums), where=known > 0), prices)
