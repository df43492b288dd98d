"""The feet: a sole rolls over its heel, stands flat, rolls over its ball, and swings to its next place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.motion import rotation
from sample_clip.body import ANKLE, BALL, HEEL, OUTWARD, leg_length
from sample_clip.curves import AFTER, Knot, quintic
from sample_clip.plan import JUMPS, LANDING, START, TIMES, WALKS, Step


@dataclass(frozen=True)
class Foot:
    """One foot over the whole clip, at the working rate. Its flights are only sketched."""

    ankle: FloatArray  # (n, 3)
    pitch: FloatArray
    yaw: FloatArray
    toes: FloatArray  # how far they bend up
    place: FloatArray  # where the ankle was when the sole last stood flat, or will be, (n, 3)


@dataclass(frozen=True)
class Swing:
    """One foot off the ground: its pitch before and after, and where it goes."""

    heel_off: float
    leave: Knot
    meet: Knot
    flat: float
    place: FloatArray
    yaw: float
    clearance: float
    brake: float


def swings(side: int, push_offs: dict[Step, Knot]) -> list[Swing]:
    """List all that one foot does off the ground; `push_offs` has pitch, its rate and acceleration at each toe off."""
    out = OUTWARD[side]
    x, z, toes_out = START[side]
    result = []
    for walk, jump in zip(WALKS, JUMPS, strict=True):
        for step in walk:
            if step.side != side:
                continue
            heel_first = step.strike_pitch > 10
            result.append(
                Swing(
                    step.lift - step.roll,
                    (step.lift, *push_offs[step]),
                    (step.strike, step.strike_pitch, -150.0 if heel_first else -20.0),
                    step.strike + (0.115 if heel_first else 0.13),
                    np.array([step.x, ANKLE, step.z]),
                    out * step.yaw,
                    clearance=3.0,
                    # It brakes late and hard: a gentle stop would have it wait for the body on a stiff leg.
                    brake=-28.0 * (step.z - z),
                )
            )
            x, z, toes_out = step.x, step.z, step.yaw
        x, z, toes_out = x + LANDING[side][0], z + jump.length + LANDING[side][1], toes_out + LANDING[side][2]
        result.append(
            Swing(
                jump.takeoff - 0.26 + 0.01 * side,
                (jump.takeoff, -52.0, -520.0),
                (jump.touchdown, -20.0, 330.0),
                jump.touchdown + 0.11,
                np.array([x, ANKLE, z]),
                out * toes_out,
                clearance=0.0,
                brake=0.0,
            )
        )
    return result


def turned(yaw: FloatArray | float, pitch: FloatArray | float) -> FloatArray:
    """Return the rotation of a foot."""
    about_y = rotation.about_axis(1, np.radians(yaw))
    return rotation.multiply(about_y, rotation.about_axis(0, -np.radians(pitch)))


def planted_ankle(place: FloatArray, yaw: FloatArray | float, pitch: FloatArray) -> FloatArray:
    """Return where the ankle is when the sole at `place` has rolled over its heel (pitch > 0) or its ball (< 0)."""
    pivot = np.where(pitch[..., None] > 0, HEEL, BALL)
    flat = rotation.rotate(turned(yaw, np.zeros_like(pitch)), pivot)
    return np.asarray(place + flat - rotation.rotate(turned(yaw, pitch), pivot))


def rolling(place: FloatArray, yaw: float, knot: Knot) -> FloatArray:
    """Return the ankle's position, velocity and acceleration at a knot of a planted foot's pitch, shape (3, 3)."""
    _, pitch, rate, acceleration = (*knot, 0.0)[:4]
    h = 0.01
    before, here, after = planted_ankle(place, yaw, pitch + np.array([-h, 0.0, h]))
    first, second = (after - before) / (2 * h), (after - 2 * here + before) / h**2
    return np.array([here, first * rate, first * acceleration + second * rate**2])


def lay_foot(side: int, push_offs: dict[Step, Knot]) -> Foot:
    """Lay out one foot: it stands, swings, stands ..."""
    x, z, toes_out = START[side]
    here, facing = np.array([x, ANKLE, z]), OUTWARD[side] * toes_out
    pitch_knots: list[Knot] = [(-1.0, 0.0)]
    yaw_knots: list[Knot] = [(-1.0, facing)]
    place = np.broadcast_to(here, (len(TIMES), 3)).copy()
    plan = swings(side, push_offs)
    for swing in plan:
        pitch_knots += [(swing.heel_off, 0.0), swing.leave, swing.meet, (swing.flat, 0.0)]
        yaw_knots += [(swing.leave[0], facing), (swing.meet[0], swing.yaw)]
        place[swing.meet[0] <= TIMES] = swing.place
        facing = swing.yaw
    pitch, yaw = quintic([*pitch_knots, AFTER], TIMES), quintic([*yaw_knots, (AFTER[0], facing)], TIMES)
    ankle, toes = planted_ankle(place, yaw, pitch), np.maximum(0.0, -pitch)
    facing = OUTWARD[side] * toes_out
    for swing in plan:
        (lift, leave_pitch, leave_rate, *_), (strike, meet_pitch, *_) = swing.leave, swing.meet
        now = (lift <= TIMES) & (strike > TIMES)
        s = (TIMES[now] - lift) / (strike - lift)
        leave, meet = rolling(here, facing, swing.leave), rolling(swing.place, swing.yaw, swing.meet)
        if swing.clearance:
            meet[2, 1:] += [300.0, swing.brake]
        for axis in range(3):
            ankle[now, axis] = quintic([(lift, *leave[:, axis]), (strike, *meet[:, axis])], TIMES[now])
        ankle[now, 1] += swing.clearance * 150 * s**3 * (1 - s) ** 4
        relaxed = (lift + 0.7 * (strike - lift), 4.0)
        toes[now] = quintic([(lift, -leave_pitch, -leave_rate), relaxed, (strike, max(0.0, -meet_pitch))], TIMES[now])
        here, facing = swing.place, swing.yaw
    return Foot(ankle, pitch, yaw, toes, place)


def planned_push_off(step: Step) -> Knot:
    """Return pitch, rate and acceleration of a plain toe off: the planned pitch, the heel still rising."""
    return (step.lift_pitch, 3.9 * step.lift_pitch, 0.0)


def push_off(step: Step, foot: Foot, hip: FloatArray, knee: FloatArray, last: Knot) -> Knot:
    """Fit the toe off so that the leg behind bends its knee as planned: the heel rises as the leg runs out of length.

    Moves half way from the `last` answer, and not far from the planned one.
    """
    now = (step.lift - step.roll < TIMES) & (step.lift > TIMES)
    place, yaw, hip, length = foot.place[now], foot.yaw[now], hip[now], leg_length(knee[now])

    def excess(pitch: FloatArray) -> FloatArray:
        return np.asarray(np.sqrt(np.sum((planted_ankle(place, yaw, pitch) - hip) ** 2, axis=-1)) - length)

    pitch = np.full(len(length), -15.0)
    for _ in range(8):
        slope = (excess(pitch + 0.05) - excess(pitch - 0.05)) / 0.1
        pitch = np.clip(pitch - np.clip(excess(pitch) / np.maximum(slope, 0.02), -15, 15), -80.0, 0.0)
    start = (step.lift - step.roll, 0.0)
    terms = [quintic([start, (step.lift, *row)], TIMES[now]) for row in np.eye(3)]
    firmness = np.array([6.0, step.roll, 0.2 * step.roll**2])
    rows = np.concatenate([np.stack(terms, axis=-1), np.diag(firmness)])
    wanted = np.concatenate([pitch, firmness * planned_push_off(step)])
    return tuple((np.array(last) + np.linalg.lstsq(rows, wanted, rcond=None)[0]) / 2)
