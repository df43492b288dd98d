"""Values that are missing: where they are, and how they are bridged."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from retime.arrays import BoolArray, FloatArray
from retime.motion.blending import blended
from retime.motion.channels import ChannelKind, quaternion_groups

Gaps = Literal["refuse", "keep"]


def holes_of(values: FloatArray) -> BoolArray:
    """Tell which values are missing."""
    return np.isnan(values)


def bridged(
    values: FloatArray, names: Sequence[str], kinds: Sequence[ChannelKind], longest: float = np.inf
) -> FloatArray:
    """Fill gaps from the values on both sides of them; at the ends hold the last value that is known.

    In between an angle goes the short way, a rotation turns evenly, a label is that of the nearer side, and no event
    happens. A channel with no value at all stays empty.

    Parameters
    ----------
    values : float array, shape (n_frames, n_channels)
        Not a number where there is none.
    names : sequence of str
        Of the channels.
    kinds : sequence of ChannelKind
        What each of them holds.
    longest : float
        Frames that a gap may have; longer ones stay.

    Returns
    -------
    float array, shape (n_frames, n_channels)

    Examples
    --------
    >>> from retime.motion.channels import LINEAR
    >>> bridged(np.array([[1.0], [np.nan], [np.nan], [4.0], [np.nan]]), ["x"], [LINEAR])[:, 0].tolist()
    [1.0, 2.0, 3.0, 4.0, 4.0]
    """
    values = values.copy()
    groups = quaternion_groups(names, kinds)
    together = {place for four in groups for place in four}
    for places in [*groups, *((place,) for place in range(len(names)) if place not in together)]:
        columns = list(places)
        missing = np.asarray(np.isnan(values[:, columns]).any(axis=1))
        known = np.flatnonzero(~missing)
        if not missing.any() or not len(known):
            continue
        own, their_names = [kinds[place] for place in columns], [names[place] for place in columns]
        kept = values[known][:, columns]
        for start, stop in gap_spans(missing):
            if stop - start > longest:
                continue
            right = int(np.searchsorted(known, start))
            left = max(right - 1, 0)
            right = min(right, len(known) - 1)
            span = max(int(known[right] - known[left]), 1)
            frames = np.arange(start, stop)
            share = np.clip((frames - known[left]) / span, 0.0, 1.0)
            whole = share == 1.0
            before = np.where(whole, right, left)
            at = (before, np.full(len(frames), right), np.where(whole, 0.0, share))
            if own[0].kind == "event":
                values[start:stop, columns] = 0.0
            else:
                values[start:stop, columns] = blended(kept, their_names, own, at)
    return values


def gap_spans(missing: BoolArray) -> list[tuple[int, int]]:
    """List gaps as first frame, and first frame after.

    Examples
    --------
    >>> gap_spans(np.array([True, False, True, True]))
    [(0, 1), (2, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], missing, [False]]).astype(np.int8)))
    return [(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]
