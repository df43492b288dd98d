"""Values that are missing: where they are, and how they are bridged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from retime.arrays import BoolArray, FloatArray
from retime.brief import kind_of
from retime.errors import OptionError
from retime.motion.blending import blended
from retime.motion.channels import ChannelKind, quaternion_groups
from retime.motion.grammar import parse_number

Gaps = Literal["refuse", "keep"]


# Longer gaps are no loss of a few frames: what happened in them can't be told from their ends.
_USUAL_BRIDGE = 1.0


@dataclass(frozen=True)
class GapPolicy:
    """What a reader does about values that are missing.

    Attributes
    ----------
    bridge : float
        Seconds: gaps up to this long are bridged (`bridged`), longer ones stay holes. 0 bridges none.

    Examples
    --------
    >>> GapPolicy.parse("bridge").bridge, GapPolicy.parse("bridge:0.25").bridge, GapPolicy.parse("keep").bridge
    (1.0, 0.25, 0.0)
    """

    bridge: float = 0.0

    @classmethod
    def parse(cls, text: str) -> GapPolicy:
        """Read ``bridge``, ``bridge:SECONDS`` or ``keep``; raise OptionError where it is none of these."""
        if not isinstance(text, str):
            raise OptionError(f"gaps are 'bridge', 'bridge:SECONDS' or 'keep'; found {kind_of(text)}")
        word, sign, seconds = text.strip().lower().partition(":")
        if word == "keep" and not sign:
            return cls(0.0)
        if word != "bridge":
            raise OptionError(f"gaps are 'bridge', 'bridge:SECONDS' or 'keep'; found {text!r}")
        return cls(parse_number(seconds, above=True, unit="s") if sign else _USUAL_BRIDGE)


def gaps_text(missing: BoolArray, names: Sequence[str], first_frame: int = 0) -> str:
    """Say where values are missing, channel by channel: their frames, as ``21:26``, both included.

    Examples
    --------
    >>> gaps_text(np.array([[False, True], [False, True], [True, False]]), ["x", "y"])
    'x frames 2:2; y frames 0:1'
    """
    said: dict[str, list[str]] = {}
    for place, name in enumerate(names):
        spans = gap_spans(missing[:, place])
        if spans:
            shown = ", ".join(f"{first_frame + start}:{first_frame + stop - 1}" for start, stop in spans[:4])
            more = f" and {len(spans) - 4} more" if len(spans) > 4 else ""
            said.setdefault(f"{shown}{more}", []).append(name)
    parts = [f"{_some(of)} frames {where}" for where, of in said.items()]
    return "; ".join(parts[:6]) + (f"; and {len(parts) - 6} more channels" if len(parts) > 6 else "")


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:6]) + (f" and {len(names) - 6} more" if len(names) > 6 else "")


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
