"""Beats as keytimes: which accent of a motion falls on which beat."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from retime.errors import OptionError
from retime.motion.accents import Accent
from retime.warp.keytime import Keytime

# Between two keys the motion is played no faster than this and no slower than one over it.
MOST_SPEED = 3.0
# What a second of input that is played at e times its speed costs, in matches of full strength.
_HURRY = 2.0
# Accents and beats that a search looks at; of more there would be no end.
_MOST = 4000


@dataclass(frozen=True)
class Beat:
    """A moment that something should fall on.

    Attributes
    ----------
    time : float
        Seconds of the output.
    strength : float
        From 0 to 1.
    name : str
        What it is called, where it is.
    """

    time: float
    strength: float = 1.0
    name: str = ""


@dataclass(frozen=True)
class Match:
    """A beat and the accent that falls on it."""

    beat: Beat
    accent: Accent

    @property
    def key(self) -> Keytime:
        """The keytime."""
        return Keytime(input_time=self.accent.time, output_time=self.beat.time)


def match_beats(
    accents: Sequence[Accent], beats: Sequence[Beat], *, input_end: float, output_end: float | None = None
) -> list[Match]:
    """Choose which accent falls on which beat, in their order.

    What is matched counts by the strengths of both; what is played faster or slower than life between two matches costs
    by the square of its logarithm and by how long it lasts. Nothing is played more than three times as fast as life,
    or as slow. Of all ways to match the best one is found.

    Parameters
    ----------
    accents : sequence of Accent
        Of the motion, in their order.
    beats : sequence of Beat
        In their order; those before 0 and past the output's end can't be met.
    input_end : float
        Seconds: of the motion's last frame.
    output_end : float, optional
        Seconds: of the output's last frame. Left out, what comes after the last match keeps its own speed.

    Returns
    -------
    list of Match
        In their order; none where nothing fits.

    Raises
    ------
    OptionError
        Too many accents or beats, or times out of order.

    Examples
    --------
    >>> steps = [Accent(0.5 * k, 1.0, "step") for k in range(1, 5)]
    >>> found = match_beats(steps, [Beat(0.6 * k) for k in range(1, 5)], input_end=2.5)
    >>> [(match.accent.time, round(match.beat.time, 1)) for match in found]
    [(0.5, 0.6), (1.0, 1.2), (1.5, 1.8), (2.0, 2.4)]
    """
    for what, times in (("accents", [one.time for one in accents]), ("beats", [one.time for one in beats])):
        if len(times) > _MOST:
            raise OptionError(f"{len(times)} {what}; {_MOST} are the most")
        if any(b <= a for a, b in itertools.pairwise(times)):
            raise OptionError(f"the times of {what} must increase")
    a = np.array([one.time for one in accents])
    b = np.array([one.time for one in beats])
    gains = np.outer([one.strength for one in accents], [one.strength for one in beats])
    # Row by row: the best that ends in a match, from the start (input time 0 at output time 0) or another match.
    best = np.full((len(a), len(b)), -np.inf)
    came = np.full((len(a), len(b), 2), -1, dtype=np.int64)
    for i in range(len(a)):
        for j in range(len(b)):
            if not (0 < a[i] < input_end and b[j] > 0):
                continue
            best[i, j] = gains[i, j] - _cost(a[i], b[j])
            # Only matches from which the way here can be played.
            first = np.searchsorted(a, a[i] - MOST_SPEED * b[j])
            low = np.searchsorted(b, b[j] - MOST_SPEED * a[i])
            if i == first or j == low:
                continue
            costs = _costs(a[i] - a[first:i, None], b[j] - b[None, low:j])
            totals = best[first:i, low:j] - costs
            at = np.unravel_index(int(np.argmax(totals)), totals.shape)
            if totals[at] + gains[i, j] > best[i, j]:
                best[i, j] = totals[at] + gains[i, j]
                came[i, j] = first + at[0], low + at[1]
    ends = best.copy()
    if output_end is not None:
        ends -= _costs(input_end - a[:, None], output_end - b[None, :])
    nothing = 0.0 if output_end is None else -_cost(input_end, output_end)
    if not ends.size or not ends.max() > nothing:
        return []
    at = np.unravel_index(int(np.argmax(ends)), ends.shape)
    i, j = int(at[0]), int(at[1])
    found: list[Match] = []
    while i >= 0:
        found.append(Match(beats[j], accents[i]))
        i, j = (int(number) for number in came[i, j])
    return found[::-1]


def _cost(length: float, shown: float) -> float:
    """Return what it costs to play a stretch of input in a stretch of output; inf where that is too fast or slow."""
    if shown <= 0 or not 1 / MOST_SPEED <= length / shown <= MOST_SPEED:
        return math.inf
    return _HURRY * length * math.log(length / shown) ** 2


def _costs(lengths: np.ndarray, shown: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore"):
        speeds = lengths / shown
        costs = _HURRY * lengths * np.log(speeds) ** 2
    return np.where((shown > 0) & (speeds >= 1 / MOST_SPEED) & (speeds <= MOST_SPEED), costs, np.inf)
