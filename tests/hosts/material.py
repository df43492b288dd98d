"""Warps to export, drawn by a seed: forward ones, and ones that hold and run backward."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from retime.hosts.registry import Host
from retime.hosts.shot import Shot
from retime.warp.curve import Warp

RATES = [Fraction(24), Fraction(24000, 1001), Fraction(25), Fraction(30), Fraction(60)]
ITEMS = {"usd-clips": "walk.usd</World/Char>"}


def drawn_warp(seed: int, *, forward: bool) -> Warp:
    """Draw one; its input begins at 0, its output at 0."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 40))
    widths = rng.uniform(0.02, 0.6, n)
    speeds = rng.uniform(0.2, 4.0, n)
    if not forward:
        speeds = np.where(rng.random(n) < 0.3, 0.0, speeds) * np.where(rng.random(n) < 0.3, -1.0, 1.0)
        # One of each at least.
        speeds[:2] = 0.0, -1.0
    inputs = np.concatenate([[0.0], np.cumsum(speeds * widths)])
    return Warp(np.concatenate([[0.0], np.cumsum(widths)]), inputs - inputs.min())


def suits(host: Host, warp: Warp) -> bool:
    """Whether a host can play a warp."""
    return bool(warp.monotone) or (host.holds and host.backward)


def most_error(host: Host, rate: Fraction, tolerance: float) -> float:
    """Return how many seconds a curve may be off: what it is thinned out by, and the whole frame that is shown."""
    off = 0.0 if host.every_frame else tolerance
    if host.name == "frames" or host.picks == "nearest":
        off += 0.5 / float(rate)
    return off + 1.0 / float(rate) if host.picks == "last" else off


def frame_times(warp: Warp, rate: Fraction) -> np.ndarray:
    """Return the times of the output's whole frames."""
    shot = Shot(rate)
    return (shot.first_frame(warp) + np.arange(shot.count_frames(warp))) / float(rate)
