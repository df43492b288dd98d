"""The plan of the sample: when and where the feet stand, and when the figure jumps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

RATE = 60
FINE = 4  # working frames a frame of the clip
GRAVITY = 981.0
N_FRAMES = 816


@dataclass(frozen=True, eq=False)
class Step:
    """One swing of one foot: when it leaves and meets the ground, and where (its ankle, when the sole is flat)."""

    side: int  # 0 left, 1 right
    lift: float
    strike: float
    x: float
    z: float
    yaw: float  # toes outward
    strike_pitch: float = 20.0
    lift_pitch: float = -57.0  # about; `push_off` finds what the leg needs
    roll: float = 0.42  # seconds from heel off to toe off
    landing_knee: tuple[float, float] = (8.0, 18.0)  # at contact, and when it has taken the load


@dataclass(frozen=True)
class Jump:
    """One jump from both feet; take-off and touchdown fall on frames."""

    dip: float
    bottom: float
    takeoff: float  # the last frame on the ground
    touchdown: float  # the first
    absorbed: float
    stand: float
    length: float
    depth: float  # how far the centre of mass sinks before it
    landing_depth: float
    arms: float  # how high they swing
    takeoff_knee: float = 30.0
    touchdown_knee: float = 38.0

    @property
    def middle(self) -> float:
        """Time half way through the flight."""
        return (self.takeoff + self.touchdown) / 2


START = ((8.0, 0.0, 7.0), (-8.5, -1.0, 8.0))  # x, z and toes outward of each foot
WALKS = (
    (
        Step(0, 0.95, 1.40, 5.5, 53.0, 5.0, strike_pitch=16.0, lift_pitch=-38.0, roll=0.26, landing_knee=(22.0, 24.0)),
        Step(1, 1.515, 1.96, -5.0, 115.5, 6.0),
        Step(0, 2.09, 2.51, 5.0, 180.0, 5.0),
        Step(1, 2.64, 3.08, -6.5, 237.0, 7.0, strike_pitch=17.0),
        Step(0, 3.22, 3.76, 9.0, 239.0, 7.0, strike_pitch=4.0, lift_pitch=-45.0, landing_knee=(14.0, 16.0)),
    ),
    (
        Step(
            1, 8.12, 8.57, -5.5, 382.0, 6.0, strike_pitch=16.0, lift_pitch=-38.0, roll=0.26, landing_knee=(22.0, 24.0)
        ),
        Step(0, 8.685, 9.13, 5.0, 446.0, 5.0),
        Step(1, 9.26, 9.69, -7.0, 504.0, 7.0, strike_pitch=18.0),
        Step(0, 9.83, 10.31, 9.0, 506.0, 6.0, strike_pitch=6.0, lift_pitch=-50.0, landing_knee=(14.0, 16.0)),
    ),
)

# Each jump follows a walk.
JUMPS = (
    Jump(
        dip=5.25,
        bottom=5.83,
        takeoff=365 / RATE,
        touchdown=394 / RATE,
        absorbed=6.757,
        stand=7.45,
        length=88.0,
        depth=21.0,
        landing_depth=21.0,
        arms=105.0,
    ),
    Jump(
        dip=10.36,
        bottom=10.88,
        takeoff=668 / RATE,
        touchdown=702 / RATE,
        absorbed=11.90,
        stand=12.70,
        length=120.0,
        depth=24.0,
        landing_depth=26.0,
        arms=130.0,
    ),
)

# A jump's feet land a little apart from where a perfect one would put them: x, z, toes outward.
LANDING = ((0.7, 1.5, 1.0), (-0.7, -1.0, 1.0))
SOFT_KNEE = 8.0  # in quiet standing
TIMES = np.arange((N_FRAMES - 1) * FINE + 1) / (RATE * FINE)
