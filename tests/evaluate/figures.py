"""Small motions for the plots' tests: a stiff figure that jumps once, and a signal."""

from fractions import Fraction

import numpy as np

from retime.motion.motion import Motion
from retime.motion.rotation import identity
from retime.motion.signal import Signal
from retime.motion.skeleton import EndSite, Skeleton
from retime.warp.curve import Warp
from retime.warp.keytime import Keytime

RATE = 60
GRAVITY = 9.81
# Seconds in the air.
FLIGHT = 0.5

SKELETON = Skeleton(
    ("Hips", "LeftLeg", "LeftFoot", "RightLeg", "RightFoot", "Head"),
    (-1, 0, 1, 0, 3, 0),
    np.array([[0, 1, 0], [0.1, 0, 0], [0, -1, 0], [-0.1, 0, 0], [0, -1, 0], [0, 0.5, 0.0]]),
    (EndSite(5, (0.0, 0.2, 0.0)),),
)


def jumper(*, lead: float, rest: float, jump: bool = True, name: str = "jumper") -> Motion:
    """Stand for `lead` seconds, fly for `FLIGHT`, stand for `rest`; in metres, upright all the time."""
    time = np.arange(round((lead + FLIGHT + rest) * RATE) + 1) / RATE
    aloft = np.clip(time - lead, 0.0, FLIGHT) if jump else np.zeros_like(time)
    translations = np.repeat(SKELETON.offsets[None], len(time), axis=0)
    translations[:, 0, 1] += GRAVITY / 2 * aloft * (FLIGHT - aloft)
    return Motion(SKELETON, identity(len(time), 6), translations, Fraction(RATE), name=name, metres_per_unit=1.0)


def flight_of(motion: Motion, lead: float) -> tuple[float, float]:
    """Input times of the whole flight of a `jumper`, a frame wider than it is."""
    return lead - 1 / RATE, lead + FLIGHT + 1 / RATE


def keeping_flight(motion: Motion, share: float) -> Warp:
    """Shorten a `jumper` to a share of its length, with its flight at its own speed and the rest at one other speed."""
    rise = np.flatnonzero(motion.local_translations[:, 0, 1] > 1.0 + 1e-9)
    start, stop = (rise[0] - 2) / RATE, (rise[-1] + 2) / RATE
    start, stop = max(start, 0.0), min(stop, motion.end_time)
    flight = stop - start
    length = share * motion.end_time
    speed = (motion.end_time - flight) / (length - flight)
    end = Keytime(input_time=motion.end_time, output_time=length)
    return Warp(
        np.array([0.0, start / speed, start / speed + flight, length]),
        np.array([0.0, start, stop, motion.end_time]),
        (Keytime(input_time=0.0, output_time=0.0), end),
        method="guided",
    )


def ramp(n_channels: int = 2) -> Signal:
    """Channel c goes from 0 to 10 (c + 1) in 4 seconds."""
    time = np.arange(4 * RATE + 1) / (4 * RATE)
    return Signal(
        tuple(f"channel {c}" for c in range(n_channels)),
        np.stack([10.0 * (c + 1) * time for c in range(n_channels)], axis=1),
        Fraction(RATE),
        name="ramp",
    )
