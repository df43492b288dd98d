"""Small made-up motions and signals for the tests of this folder."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skeleton import EndSite, Skeleton

SKELETON = Skeleton(
    ("hips", "chest", "arm", "leg"),
    (-1, 0, 1, 0),
    np.array([[0.0, 1.0, 0.0], [0.0, 0.5, 0.0], [0.3, 0.1, 0.0], [0.1, -0.2, 0.0]]),
    (EndSite(2, (0.6, 0.0, 0.0)), EndSite(3, (0.0, -0.8, 0.0))),
)


def wandering_motion(n_frames: int, rate: Fraction | int = 30, seed: int = 0, *, pace: float = 1.0) -> Motion:
    """Smooth, and nowhere the same twice: every joint turns about a wandering axis, the root walks."""
    rng = np.random.default_rng(seed)
    times = np.arange(n_frames)[:, None, None] / float(rate) * pace
    waves = [np.sin(times * rng.uniform(0.5, 3, (4, 3)) + rng.uniform(0, 6, (4, 3))) for _ in range(2)]
    q = rotation.from_euler("ZYX", 0.6 * (waves[0] + waves[1]))
    translations = np.broadcast_to(SKELETON.offsets, (n_frames, 4, 3)).copy()
    translations[:, 0] += 0.3 * waves[0][:, 1] + times[:, 0] * np.array([0.4, 0.0, 1.1])
    return Motion(SKELETON, q, translations, Fraction(rate), name="wanderer", first_frame=1)


def wandering_signal(n_frames: int, rate: Fraction | int = 30, seed: int = 0) -> Signal:
    motion = wandering_motion(n_frames, rate, seed)
    return Signal(("x", "y", "z"), motion.local_translations[:, 0].copy(), Fraction(rate), name="wanderer")
