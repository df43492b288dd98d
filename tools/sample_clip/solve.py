"""The figure as a whole: the root is moved until the centre of mass is where it should be."""

from __future__ import annotations

import numpy as np

from retime.arrays import FloatArray
from retime.motion import rotation
from retime.motion.motion import Motion
from sample_clip.body import THIGH, UPPER, WHOLE, leg_length
from sample_clip.feet import lay_foot, planned_push_off, push_off
from sample_clip.flight import flight_legs, keep_turning
from sample_clip.legs import pose_leg, reach_for
from sample_clip.mass_centre import (
    knee_plan,
    leaps,
    mass_centre,
    motion_of,
    pendulum,
    pressure,
    splined,
    standing_height,
    upper_mass,
)
from sample_clip.plan import FINE, JUMPS, RATE, TIMES, WALKS
from sample_clip.upper_body import carriage, read_gait

ROUNDS = 16


def solve() -> tuple[Motion, dict[str, FloatArray]]:
    """Go round until heights, paths, heels and legs agree; return the motion at the working rate, and its angles."""
    up = standing_height()
    ends = [(up + 6.0, up - 3.0) for _ in JUMPS]  # heights at take-off and touchdown
    ride = np.full(len(TIMES), up)  # height where no jump has the say
    push_offs = {step: planned_push_off(step) for walk in WALKS for step in walk}
    centre = pressure()
    knees, matter = knee_plan()
    keen = np.stack([matter, np.zeros_like(matter)], axis=1)
    above = np.zeros((len(TIMES), 3))  # the root, from the centre of mass
    for i in range(ROUNDS):
        feet = (lay_foot(0, push_offs), lay_foot(1, push_offs))
        leap, leap_acceleration, say = leaps(ends, ride)
        rest = (1 - say) * (ride - leap)
        y = leap + rest
        y_acceleration = leap_acceleration + np.where(say < 1, np.gradient(np.gradient(rest, TIMES), TIMES), 0.0)
        ground = pendulum(centre, y, y_acceleration)
        mass = np.stack([ground[:, 0], y, ground[:, 1]], axis=-1)
        angles = carriage(read_gait(feet, centre, ground))
        hips = rotation.from_euler("ZYX", np.radians(angles["Hips"]))
        upper = upper_mass(angles)
        # Few steps do while all else still moves; in the end the feet must not slip.
        for _ in range(4 if i < ROUNDS - 1 else 12):
            root = mass + above
            legs = [reach_for(side, feet[side], root, hips) for side in (0, 1)]
            total = upper + UPPER * root + legs[0].mass + legs[1].mass
            above = above + mass - total / WHOLE
        down = np.stack([leg.down for leg in legs], axis=1)
        fitted, keen = settle(leap, say, y, down, np.stack([leg.knee for leg in legs], axis=1), (knees, matter, keen))
        ride = ride + 0.7 * (fitted - ride)
        for step, last in push_offs.items():
            hip = feet[step.side].ankle - down[:, step.side] + (ride - y)[:, None] * [0.0, 1.0, 0.0]
            push_offs[step] = push_off(step, feet[step.side], hip, knees[:, step.side], last)
        ends = [
            (
                off + lift_to(down[round(jump.takeoff * RATE * FINE)], jump.takeoff_knee),
                on + lift_to(down[round(jump.touchdown * RATE * FINE)], jump.touchdown_knee),
            )
            for jump, (off, on) in zip(JUMPS, ends, strict=True)
        ]
    for side in (0, 1):
        pose_leg(side, legs[side], feet[side], hips, angles)
    flight_legs(angles)
    keep_turning(angles)
    # What the flights changed, and the last of the rounding, goes into the root.
    root = mass - mass_centre(motion_of(np.zeros((len(TIMES), 3)), angles))
    return motion_of(root, angles), angles


def lift_to(down: FloatArray, knee: FloatArray | float) -> float:
    """Return how far the hips must rise for knees to bend as wanted, on the mean of both legs; `down` is (2, 3)."""
    return float(np.mean(np.sqrt(leg_length(knee) ** 2 - down[:, 0] ** 2 - down[:, 2] ** 2) + down[:, 1]))


def settle(
    leap: FloatArray,
    say: FloatArray,
    y: FloatArray,
    down: FloatArray,
    bend: FloatArray,
    knees: tuple[FloatArray, FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Fit the height of the centre of mass at which the knees bend as planned; return it, and how each leg was heeded.

    A leg counts by how fast its knee would bend if the hips sank, squared: a straight one is the most sensitive. One
    that gets too straight counts always, planned or not. Half of the last round's weights is kept, so that the rounds
    settle.
    """
    plan, matter, last = knees
    bend = np.maximum(bend, 5.0)
    sensitivity = 1.0 / (THIGH * np.sin(np.radians(bend) / 2)) ** 2
    tight = np.clip((13.0 - bend) / 8.0, 0.0, 1.0)
    keen = (last + np.stack([matter, tight], axis=1) * sensitivity[:, None]) / 2
    length = leg_length(np.stack([plan, np.full_like(plan, 13.0)], axis=1))
    level = np.sqrt(np.maximum(length**2 - (down[..., 0] ** 2 + down[..., 2] ** 2)[:, None], 1.0)) + down[:, None, :, 1]
    total = keen.sum(axis=(1, 2))
    jumping = say > 0
    asked = np.where(jumping, leap, y + (keen * level).sum(axis=(1, 2)) / total)
    return splined(asked, np.where(jumping, 0.05, total), 0.08), keen
