"""A signal's channels as numbers to compare: each kind so that distances are what they should be.

A linear channel is itself. An angle becomes its cosine and sine, so that the way from 179 to -179 degrees is 2 degrees.
A rotation becomes the products of its quaternion's parts, which don't change with its sign. For small differences both
distances are the angle between the two: of an angle in its own unit, of a rotation in radians. Labels, events, clocks
and likelihoods are left out.

``NAME.x``, ``NAME.y`` and ``NAME.z`` are a point, whose axes are one length: scaled each by its own spread, an axis
along which nothing moves would count by its noise. Points with one unit, as the markers of a capture, are alike among
themselves, and one that only trembles counts little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from retime.arrays import FloatArray
from retime.errors import OptionError
from retime.motion.blending import unit_length
from retime.motion.channels import FULL_TURN, ChannelKind, quaternion_groups
from retime.motion.signal import Signal
from retime.search.poses.spaces import PoseOptions, chosen_places

# The parts of a quaternion by twos. Two different ones stand for two places of the square of products.
_FIRST, _SECOND = np.triu_indices(4)
_TWICE = np.where(_FIRST == _SECOND, 1.0, np.sqrt(2.0))


@dataclass(frozen=True)
class Part:
    """What becomes numbers together: one channel, or the four of a rotation.

    Attributes
    ----------
    columns : tuple of int
        The channels.
    kind : ChannelKind
        What they hold.
    """

    columns: tuple[int, ...]
    kind: ChannelKind


def weighing_parts(signal: Signal, options: PoseOptions) -> list[Part]:
    """Choose the channels that count, a rotation as a whole where any of its columns is chosen.

    Raises
    ------
    OptionError
        A name is not there or is of a channel that can't weigh; nothing counts; one rotation has two weights.
    """
    names, kinds = signal.names, signal.kinds
    chosen = chosen_places(names, range(len(names)), options, signal.name)
    for place in chosen:
        named = names[place] in (options.joints or ()) or options.weights.get(names[place], 0) > 0
        if named and not kinds[place].weighs:
            raise OptionError(
                f"{names[place]!r} is {kinds[place]}, which the search doesn't look at; to compare its numbers, say "
                "that it is linear (--channel NAME=linear)"
            )
    groups = {place: four for four in quaternion_groups(names, kinds) for place in four}
    # In the order of the channels, each rotation once.
    parts = dict.fromkeys(groups.get(place, (place,)) for place in chosen if kinds[place].weighs)
    if not parts:
        raise OptionError(
            f"nothing of {signal.name or 'the signal'} weighs in a search: its channels are "
            + ", ".join(f"{name} {kind}" for name, kind in list(zip(names, kinds, strict=True))[:6])
        )
    return [Part(columns, kinds[columns[0]]) for columns in parts]


def signal_scales(signals: Sequence[Signal], options: PoseOptions) -> FloatArray:
    """Find what to divide each channel by, from all frames of the references, whose channels are in one order.

    Returns
    -------
    float array, shape (n_channels,)
        A standard deviation, in the channel's own unit; of a rotation, for each of its columns, radians; of a point,
        for each of its axes, how far it is from its mean place, and that of points with one unit for all of them.
    """
    first = signals[0]
    # Row by row in memory: else sums, to the last bit, depend on how the arrays were made.
    together = np.ascontiguousarray(np.concatenate([signal.values for signal in signals]))
    # Scaled to 1 first: the squares of large numbers would overflow.
    largest = np.abs(together).max(axis=0)
    unit = np.where(largest > 0, largest, 1.0)
    spread = np.std(together / unit, axis=0) * unit
    for part in _all_parts(first):
        if part.kind.kind in ("angle", "quaternion"):
            round_about = np.concatenate([_numbers(signal, part.columns) for signal in signals])
            around = float(np.sqrt(np.var(round_about, axis=0).sum()))
            turn = FULL_TURN.get(part.kind.unit, FULL_TURN["rad"])
            spread[list(part.columns)] = around * turn / FULL_TURN["rad"]
            unit[list(part.columns)] = turn
    for points in points_alike(first.names, first.kinds):
        columns = list(chain(*points))
        unit[columns] = unit[columns].max()
        spread[columns] = np.sqrt(np.square(spread[columns] / unit[columns]).sum() / len(points)) * unit[columns]
    # A constant such as 0.1 has a standard deviation above 0, by rounding alone.
    scales = np.where(options.scale_signals & (spread / unit > 1e-12), spread, 1.0)
    for part in _all_parts(first):
        given = [options.scales[first.names[place]] for place in part.columns if first.names[place] in options.scales]
        if given:
            scales[list(part.columns)] = _one(given, part, first.names, "scale")
    return scales


def points_alike(names: Sequence[str], kinds: Sequence[ChannelKind]) -> list[list[tuple[int, ...]]]:
    """Find points among channels, and which of them share a scale.

    Parameters
    ----------
    names : sequence of str
        Of the channels.
    kinds : sequence of ChannelKind
        What they hold. Two or three linear ones of one unit whose names end in .x, .y and .z are a point.

    Returns
    -------
    list of list of tuple of int
        The channels of each point; in one list those of one unit. Where nobody says the unit each is by itself, for
        it may be a force as well as a place.

    Examples
    --------
    >>> points_alike(["a.x", "b.x", "a.y", "b.y", "c.x"], [ChannelKind(unit="mm")] * 5)
    [[(0, 2), (1, 3)]]
    """
    axes: dict[tuple[str, str], dict[str, int]] = {}
    for place, (name, kind) in enumerate(zip(names, kinds, strict=True)):
        stem, dot, axis = name.rpartition(".")
        if dot and stem and axis in ("x", "y", "z") and kind.kind == "linear" and kind.weighs:
            axes.setdefault((stem, kind.unit), {}).setdefault(axis, place)
    found: dict[tuple[str, str], list[tuple[int, ...]]] = {}
    for (stem, unit), places in axes.items():
        if len(places) > 1:
            found.setdefault(("" if unit else stem, unit), []).append(tuple(places[axis] for axis in sorted(places)))
    return list(found.values())


def signal_vectors(signal: Signal, options: PoseOptions, scales: FloatArray) -> FloatArray:
    """Choose, weight and scale a signal's channels; shape (n_frames, n_numbers)."""
    columns = []
    for part in weighing_parts(signal, options):
        names = [signal.names[place] for place in part.columns]
        given = [options.weights[name] for name in names if name in options.weights]
        factor = _one(given, part, signal.names, "weight") if given else 1.0
        scale = scales[part.columns[0]]
        if part.kind.kind == "angle":
            # Scales are in the channel's own unit; the circle is one of radians.
            scale = scale * FULL_TURN["rad"] / FULL_TURN[part.kind.unit]
        columns.append(_numbers(signal, part.columns) / scale * factor)
    return np.concatenate(columns, axis=1)


def _all_parts(signal: Signal) -> list[Part]:
    groups = {place: four for four in quaternion_groups(signal.names, signal.kinds) for place in four}
    parts = dict.fromkeys(groups.get(place, (place,)) for place in range(len(signal.names)))
    return [Part(columns, signal.kinds[columns[0]]) for columns in parts]


def _numbers(signal: Signal, columns: tuple[int, ...]) -> FloatArray:
    """Return the numbers to compare of one part, unscaled: a column, a place on the unit circle, or products."""
    kind = signal.kinds[columns[0]]
    values = signal.values[:, list(columns)]
    if kind.kind == "angle":
        radians = values * (FULL_TURN["rad"] / FULL_TURN[kind.unit])
        return np.concatenate([np.cos(radians), np.sin(radians)], axis=1)
    if kind.kind == "quaternion":
        turned = unit_length(values)
        return np.asarray(np.sqrt(2.0) * _TWICE * turned[:, _FIRST] * turned[:, _SECOND])
    return values


def _one(given: Sequence[float], part: Part, names: Sequence[str], what: str) -> float:
    """Return what is given for the columns of one rotation, which must agree."""
    if len(set(given)) > 1:
        raise OptionError(
            f"{', '.join(names[place] for place in part.columns)} are one rotation, and have one {what}; found "
            f"{', '.join(f'{number:g}' for number in given)}"
        )
    return given[0]
