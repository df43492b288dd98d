"""A motion's accents: the moments that a beat would fall on. Feet that come down, and peaks of speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.motion.any_motion import AnyMotion
from retime.motion.contacts import contacts
from retime.motion.gaps import bridged
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.signal import Signal

# Seconds: what is closer together is one accent. And the window in which a peak of speed is one.
_TOGETHER, _AROUND = 0.12, 0.15
# Of the speed, smoothed over so many seconds, a peak rises above its surroundings by this share of the spread.
_SMOOTH, _RISE = 0.06, 0.5


@dataclass(frozen=True)
class Accent:
    """A moment of a motion that stands out.

    Attributes
    ----------
    time : float
        Seconds from the first frame.
    strength : float
        From 0 to 1, the strongest of its kind.
    kind : str
        "step" (a foot comes down), "peak" (of speed), or "step and peak".
    """

    time: float
    strength: float
    kind: str


def accents(motion: AnyMotion) -> list[Accent]:
    """Find the accents of a motion or a signal, in their order.

    Parameters
    ----------
    motion : Motion or Signal
        A signal has no feet: its peaks of speed alone are found, each channel measured by its spread.

    Returns
    -------
    list of Accent
        None closer together than 0.12 s; of such the stronger one stays.

    Examples
    --------
    >>> times = np.arange(0, 4, 1 / 30)
    >>> swing = Signal(("x",), np.sin(np.pi * times)[:, None], 30)
    >>> [round(accent.time, 1) for accent in accents(swing)]
    [1.0, 2.0, 3.0]
    """
    found = [Accent(time, strength, "peak") for time, strength in _peaks(_speed(motion), float(motion.rate))]
    if isinstance(motion, Motion):
        found += _steps(motion)
    found.sort(key=lambda accent: accent.time)
    kept: list[Accent] = []
    for accent in found:
        if kept and accent.time - kept[-1].time < _TOGETHER:
            both = kept[-1].kind != accent.kind and "and" not in kept[-1].kind
            # A foot's coming down is sharper than a peak of speed: it says when.
            first = min(kept[-1], accent, key=lambda one: ("step" not in one.kind, -one.strength))
            kind = "step and peak" if both else first.kind
            kept[-1] = Accent(first.time, max(kept[-1].strength, accent.strength), kind)
        else:
            kept.append(accent)
    return kept


def _speed(motion: AnyMotion) -> FloatArray:
    """Return how fast everything moves between frames, shape (n_frames - 1,)."""
    if isinstance(motion, Signal):
        values = bridged(motion.values, motion.names, motion.kinds) if motion.holes.any() else motion.values
        numbers = [place for place, kind in enumerate(motion.kinds) if kind.weighs]
        values = values[:, numbers]
        spread = values.std(axis=0)
        scaled = values / np.where(spread > 0, spread, 1.0)
        return np.asarray(np.sqrt((np.diff(scaled, axis=0) ** 2).mean(axis=1))) * float(motion.rate)
    places = global_poses(motion).positions
    return np.asarray(np.linalg.norm(np.diff(places, axis=0), axis=2).mean(axis=1)) * float(motion.rate)


def _peaks(speed: FloatArray, rate: float) -> list[tuple[float, float]]:
    """Find times and strengths of peaks; between frames a speed lies in their middle."""
    if len(speed) < 3 or speed.max() <= 0:
        return []
    width = max(1, round(_SMOOTH * rate)) | 1
    smooth = np.convolve(np.pad(speed, width // 2, mode="edge"), np.ones(width) / width, mode="valid")
    reach = max(1, round(_AROUND * rate))
    rises = []
    for frame in range(1, len(smooth) - 1):
        around = smooth[max(0, frame - reach) : frame + reach + 1]
        if smooth[frame] < around.max() or smooth[frame] <= smooth[frame - 1]:
            continue
        # As high as it stands above the lower of the valleys beside it.
        before = smooth[_last_above(smooth[:frame], smooth[frame]) : frame]
        after = smooth[frame : frame + _first_above(smooth[frame + 1 :], smooth[frame]) + 1]
        rises.append((frame, float(smooth[frame] - max(before.min(), after.min()))))
    least = _RISE * float(smooth.std())
    strong = [(frame, rise) for frame, rise in rises if rise >= least and rise > 1e-9 * float(speed.max())]
    most = max((rise for _, rise in strong), default=1.0)
    return [((frame + 0.5) / rate, rise / most) for frame, rise in strong]


def _last_above(values: FloatArray, level: float) -> int:
    """Return the place after the last value above a level; 0 where there is none."""
    above = np.flatnonzero(values > level)
    return int(above[-1]) + 1 if len(above) else 0


def _first_above(values: FloatArray, level: float) -> int:
    """Return the place of the first value above a level; their number where there is none."""
    above = np.flatnonzero(values > level)
    return int(above[0]) if len(above) else len(values)


def _steps(motion: Motion) -> list[Accent]:
    """Find when feet come down."""
    standing = contacts(motion).at_rest
    if not standing.size:
        return []
    begun = np.flatnonzero((standing[1:] & ~standing[:-1]).any(axis=1)) + 1
    return [Accent(float(frame / motion.rate), 0.8, "step") for frame in begun.tolist()]
