"""How evenly walks are hurried or slowed."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.evaluate.metrics import Spans
from retime.evaluate.metrics.spans import seconds_shown
from retime.motion.body import body_joint
from retime.motion.contacts import contacts
from retime.motion.flights import flights
from retime.motion.joint_names import body_parts
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion
from retime.warp.curve import Warp


@dataclass(frozen=True)
class WalkedStep:
    """A step of a walk: from when one foot lands to when the other one does.

    Attributes
    ----------
    start, end : float
        Input times, seconds.
    side : str
        The foot that lands first: "left" or "right".
    """

    start: float
    end: float
    side: str


def walked_steps(
    motion: Motion, *, shortest: float = 0.25, longest: float = 1.2, slowest: float = 0.3, fewest: int = 3
) -> tuple[WalkedStep, ...]:
    """Find the steps of walks: the feet land in turn, the body gets ahead, and nothing flies.

    Parameters
    ----------
    motion : Motion
        Its skeleton's names say which joints are the feet; without such names it has no steps.
    shortest, longest : float
        Seconds that a walker's step takes.
    slowest : float
        Metres a second that the root gets ahead over the ground in a step.
    fewest : int
        Steps that follow one another, at least.
    """
    rate = float(motion.rate)
    standing = contacts(motion)
    parts = body_parts(motion.skeleton.names)
    landings: list[tuple[int, str]] = []
    for side in ("left", "right"):
        columns = [i for i, foot in enumerate(standing.feet) if (part := parts[foot.joint]) and part.side == side]
        stands = np.any(standing.at_rest[:, columns], axis=1)
        # A foot that stands in the first frame has landed some time before.
        landings += [(int(frame) + 1, side) for frame in np.flatnonzero(~stands[:-1] & stands[1:])]
    landings.sort()
    ground = global_poses(motion).positions[:, body_joint(motion)][:, [0, 2]] * metres_per_unit(motion)
    aloft = flights(motion)
    steps = []
    for (first, side), (last, other) in itertools.pairwise(landings):
        seconds = (last - first) / rate
        if side == other or not shortest <= seconds <= longest:
            continue
        ahead = float(np.linalg.norm(ground[last] - ground[first])) / seconds
        if ahead >= slowest and not any(begin < last and first < end for begin, end in aloft):
            steps.append(WalkedStep(first / rate, last / rate, side))
    # One or two may be a shift of weight, or dancing.
    chains: list[list[WalkedStep]] = []
    for step in steps:
        if chains and chains[-1][-1].end == step.start:
            chains[-1].append(step)
        else:
            chains.append([step])
    return tuple(step for chain in chains if len(chain) >= fewest for step in chain)


def walking_spans(steps: Sequence[WalkedStep]) -> tuple[tuple[float, float], ...]:
    """Join steps that follow one another: input times of unbroken walks, seconds."""
    spans: list[tuple[float, float]] = []
    for step in steps:
        if spans and spans[-1][1] == step.start:
            spans[-1] = (spans[-1][0], step.end)
        else:
            spans.append((step.start, step.end))
    return tuple(spans)


@dataclass(frozen=True)
class WalkSpeeds:
    """How a warp plays walks; shares and seconds are those of the input, so that what is rushed counts in full.

    Attributes
    ----------
    low, high : float
        The 5th and the 95th percentile of speed.
    longest_fast, longest_slow : float
        Seconds of the longest unbroken stretch that plays faster than 1.6 times, and slower than 0.6 times.
    """

    low: float
    high: float
    longest_fast: float
    longest_slow: float


def walk_speeds(warp: Warp, spans: Spans, *, fast: float = 1.6, slow: float = 0.6) -> WalkSpeeds | None:
    """Measure at which speeds a warp plays walks; None where there are none, or it never shows them.

    Parameters
    ----------
    warp : Warp
        A walk that is held counts for nothing while it is held.
    spans : sequence of (float, float)
        Walks, input times, apart.
    fast, slow : float
        Speeds beyond which a stretch is counted.

    Examples
    --------
    Of ten seconds of walking the last one is played in half a second.

    >>> walk_speeds(Warp([0.0, 9.0, 9.5], [0.0, 9.0, 10.0]), [(0.0, 10.0)])
    WalkSpeeds(low=1.0, high=2.0, longest_fast=1.0, longest_slow=0.0)
    """
    low = np.minimum(warp.input_times[:-1], warp.input_times[1:])
    high = np.maximum(warp.input_times[:-1], warp.input_times[1:])
    speeds = np.abs(warp.slopes)
    shown: list[FloatArray] = []
    longest = {"fast": 0.0, "slow": 0.0}
    for start, end in spans:
        seconds = np.maximum(np.minimum(high, end) - np.maximum(low, start), 0.0)
        inside = seconds > 0
        shown.append(np.stack([speeds[inside], seconds[inside]]))
        for name, beyond in (("fast", speeds > fast), ("slow", speeds < slow)):
            # Pieces of the warp that follow one another; one that holds, or shows something else, ends a stretch.
            run = 0.0
            for counts, part in zip(beyond & inside, seconds, strict=True):
                run = run + float(part) if counts else 0.0
                longest[name] = max(longest[name], run)
    if not shown or not (pieces := np.concatenate(shown, axis=1)).size:
        return None
    order = np.argsort(pieces[0], kind="stable")
    share = np.cumsum(pieces[1, order]) / pieces[1].sum()
    found = [float(pieces[0, order][min(np.searchsorted(share, q - 1e-9), len(order) - 1)]) for q in (0.05, 0.95)]
    return WalkSpeeds(found[0], found[1], longest["fast"], longest["slow"])


def step_spread(warp: Warp, steps: Sequence[WalkedStep]) -> float | None:
    """How unevenly steps are hurried: the standard deviation of each one's duration in the output over its own.

    Parameters
    ----------
    warp : Warp
        Shows the steps once.
    steps : sequence of WalkedStep
        Of the input.

    Returns
    -------
    float or None
        0 where every step takes the same share of its time; None where there are fewer than two.
    """
    if len(steps) < 2:
        return None
    ratios = [seconds_shown(warp, [(step.start, step.end)]) / (step.end - step.start) for step in steps]
    return float(np.std(ratios))
