"""What a signal shows between its frames, by the kinds of its channels (`retime.motion.channels`)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from retime.arrays import FloatArray, IntArray
from retime.motion import rotation
from retime.motion.channels import FULL_TURN, ChannelKind, quaternion_groups

Places = tuple[IntArray, IntArray, FloatArray]


def blended(
    values: FloatArray,
    names: Sequence[str],
    kinds: Sequence[ChannelKind],
    places: Places,
) -> FloatArray:
    """Show channels at places between frames.

    Parameters
    ----------
    values : float array, shape (n_frames, n_channels)
        The channels; a hole is not a number.
    names : sequence of str
        Of the channels.
    kinds : sequence of ChannelKind
        What each of them holds.
    places : tuple of int array, int array, float array, each of shape (n,)
        Frames before and after, and the share of the way between them (`retime.frames.frame_positions`).

    Returns
    -------
    float array, shape (n, n_channels)
        On a frame its own values, bit for bit (a quaternion's sign may turn, so that neighbours agree). Beside a hole
        there is a hole.
    """
    before, after, share = places
    # On a frame the next one has no say, not even by being a hole.
    after = np.where(share == 0, before, after)
    start = values[before]
    step = values[after] - start
    for column, kind in enumerate(kinds):
        if kind.kind == "angle":
            step[:, column] = short_way(step[:, column], FULL_TURN[kind.unit])
    shown = np.asarray(start + share[:, None] * step)
    # -0 + 0 is 0.
    shown[share == 0] = start[share == 0]
    for column, kind in enumerate(kinds):
        if kind.kind == "angle":
            shown[:, column] = within_turn(shown[:, column], values[:, column], FULL_TURN[kind.unit])
        elif kind.kind == "label":
            shown[:, column] = values[np.where(share < 0.5, before, after), column]
        elif kind.kind == "event":
            shown[:, column] = _events(values[:, column], before + share)
    for four in quaternion_groups(names, kinds):
        columns = list(four)
        shown[:, columns] = _turned(values[:, columns], before, after, share)
    return shown


def short_way(difference: FloatArray, turn: float) -> FloatArray:
    """Take whole turns off differences of angles, so that none is longer than half a turn."""
    return np.asarray(difference - turn * np.round(difference / turn))


def within_turn(angles: FloatArray, given: FloatArray, turn: float) -> FloatArray:
    """Bring angles into the turn that the given ones keep to: from -half to half, or from 0 to a whole one.

    Given angles that keep to neither are counted on and on, and so are these.
    """
    known = given[np.isfinite(given)]
    if not len(known):
        return angles
    for low in (-turn / 2, 0.0):
        slack = 1e-9 * turn
        if known.min() >= low - slack and known.max() <= low + turn + slack:
            outside = (angles < low - slack) | (angles > low + turn + slack)
            return np.where(outside, angles - turn * np.floor((angles - low) / turn), angles)
    return angles


def one_side(rotations: FloatArray) -> FloatArray:
    """Flip quaternions (n_frames, 4) so that each lies on the side of the one before; holes are passed over."""
    known = np.flatnonzero(np.isfinite(rotations).all(axis=1))
    if len(known) < 2:
        return rotations
    turns = np.einsum("fc,fc->f", rotations[known[1:]], rotations[known[:-1]]) < 0
    if not turns.any():
        return rotations
    signs = np.ones(len(rotations))
    signs[known[1:]] = np.where(np.cumsum(turns) % 2 == 1, -1.0, 1.0)
    return np.asarray(rotations * signs[:, None])


def _turned(rotations: FloatArray, before: IntArray, after: IntArray, share: FloatArray) -> FloatArray:
    shown = rotations[before]
    between = np.flatnonzero(share)
    if len(between):
        ends = [unit_length(rotations[frames[between]]) for frames in (before, after)]
        shown[between] = rotation.slerp(ends[0], ends[1], share[between])
    return one_side(shown)


def unit_length(rotations: FloatArray) -> FloatArray:
    """Scale quaternions (n, 4) to unit length; holes stay holes."""
    return np.asarray(rotations / np.linalg.norm(rotations, axis=1, keepdims=True))


def _events(values: FloatArray, places: FloatArray) -> FloatArray:
    """Show each event once: at the output frame nearest in time to it, also where its own frame is not shown.

    An output frame stands for the input between the middles to its neighbours. In a hold its first frame has the event.
    """
    shown = np.zeros(len(places))
    happening = np.flatnonzero(np.nan_to_num(values) != 0)
    if not len(happening):
        return shown
    middles = (places[1:] + places[:-1]) / 2
    starts = np.concatenate([[places[0] - 0.5], middles])
    ends = np.concatenate([middles, [places[-1] + 0.5]])
    if len(places) > 1 and places[-1] < places[-2]:
        ends[-1] = places[-1] - 0.5
    if len(places) > 1 and places[1] < places[0]:
        starts[0] = places[0] + 0.5
    low, high = np.minimum(starts, ends), np.maximum(starts, ends)
    forward = ends >= starts
    # The first event after the start, forward; backward the first one not before the end.
    first = np.where(
        forward, np.searchsorted(happening, low, side="right"), np.searchsorted(happening, low, side="left")
    )
    found = happening[np.minimum(first, len(happening) - 1)]
    inside = (first < len(happening)) & np.where(forward, found <= high, found < high)
    # An output frame of no width stands for nothing.
    inside &= high > low
    shown[inside] = values[found[inside]]
    return shown
