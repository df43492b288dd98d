"""Make the sample clip: a figure that stands, walks, pauses, crouches, jumps with true ballistic flight, and does it again.

Run ``python tools/make_sample.py OUT.bvh``; the clip's phases go beside it, into ``OUT_phases.json``.

Nothing here is captured or drawn by hand frame by frame. The plan (`STEPS`, `JUMPS`) says when and where the feet
stand. From it follow, in this order:

1. the feet: each sole rolls over the heel, stands flat, rolls over the ball of the foot, and swings to its next place;
2. the height of the centre of mass: quintic pieces whose force never jumps, and exact parabolas in flight;
3. its path over the ground: a pendulum over the centre of pressure (see `pendulum`), one linear system for the whole
   clip, so that weight shifts before a step, braking, and leaning into a jump come out by themselves;
4. the trunk, head and arms: curves over the plan's times, counter-swings taken from the feet, and a little sway;
5. the legs and the root: in each frame the root is moved until the whole body's centre of mass is where step 2 and 3
   want it, while the legs reach for the feet.

Work is done at four times the clip's rate, in centimetres, degrees and seconds, Y up, walking along +Z; left is +X.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.formats.registry import write
from retime.motion import rotation
from retime.motion.kinematics import global_poses
from retime.motion.motion import Declaration, Motion
from retime.motion.rotation import FloatArray
from retime.motion.skeleton import EndSite, Skeleton

SHIPPED = Path(__file__).resolve().parents[1] / "src" / "retime" / "data" / "sample.bvh"

RATE = 60
FINE = 4  # working frames a frame of the clip
GRAVITY = 981.0
N_FRAMES = 816

# The body: 175 cm, segment lengths near the usual fractions of stature (Drillis and Contini). The rest pose stands upright
# with the arms hanging, so every joint is near zero most of the time and no channel comes close to the middle angle's
# right angle.
JOINTS: tuple[tuple[str, str, tuple[float, float, float]], ...] = (
    ("Hips", "", (0.0, 97.0, 0.0)),
    ("Spine", "Hips", (0.0, 8.0, -1.0)),
    ("Spine1", "Spine", (0.0, 12.0, -0.5)),
    ("Chest", "Spine1", (0.0, 12.0, 0.0)),
    ("Neck", "Chest", (0.0, 20.0, -0.5)),
    ("Head", "Neck", (0.0, 10.0, 1.5)),
    ("LeftShoulder", "Chest", (3.0, 15.5, 0.5)),
    ("LeftArm", "LeftShoulder", (15.0, -1.0, -1.0)),
    ("LeftForeArm", "LeftArm", (0.0, -29.0, 0.0)),
    ("LeftHand", "LeftForeArm", (0.0, -25.5, 0.0)),
    ("RightShoulder", "Chest", (-3.0, 15.5, 0.5)),
    ("RightArm", "RightShoulder", (-15.0, -1.0, -1.0)),
    ("RightForeArm", "RightArm", (0.0, -29.0, 0.0)),
    ("RightHand", "RightForeArm", (0.0, -25.5, 0.0)),
    ("LeftUpLeg", "Hips", (9.0, -5.0, 0.0)),
    ("LeftLeg", "LeftUpLeg", (0.0, -42.5, 0.0)),
    ("LeftFoot", "LeftLeg", (0.0, -41.5, 0.0)),
    ("LeftToeBase", "LeftFoot", (0.0, -6.0, 13.0)),
    ("RightUpLeg", "Hips", (-9.0, -5.0, 0.0)),
    ("RightLeg", "RightUpLeg", (0.0, -42.5, 0.0)),
    ("RightFoot", "RightLeg", (0.0, -41.5, 0.0)),
    ("RightToeBase", "RightFoot", (0.0, -6.0, 13.0)),
)
END_SITES: tuple[tuple[str, tuple[float, float, float]], ...] = (
    ("Head", (0.0, 16.0, 0.0)),
    ("LeftHand", (0.0, -18.0, 0.0)),
    ("RightHand", (0.0, -18.0, 0.0)),
    ("LeftToeBase", (0.0, -1.0, 6.5)),
    ("RightToeBase", (0.0, -1.0, 6.5)),
)
# Mass in percent of the body and the place of its centre in the joint's space: adjusted Zatsiorsky-Seluyanov parameters
# of men (de Leva 1996), centres at 41, 45, 58 and 46 % of thigh, shank, upper arm and forearm.
MASSES: tuple[tuple[str, float, tuple[float, float, float]], ...] = (
    ("Hips", 11.17, (0.0, 0.5, 0.0)),
    ("Spine1", 16.33, (0.0, 0.0, 1.5)),
    ("Chest", 15.96, (0.0, 8.5, 1.5)),
    ("Head", 6.94, (0.0, 3.0, 1.0)),
    *((f"{side}{joint}", mass, centre) for side in ("Left", "Right") for joint, mass, centre in (
        ("Arm", 2.71, (0.0, -16.7, 0.0)),
        ("ForeArm", 1.62, (0.0, -11.7, 0.0)),
        ("Hand", 0.61, (0.0, -6.8, 0.0)),
        ("UpLeg", 14.16, (0.0, -17.4, 0.0)),
        ("Leg", 4.33, (0.0, -18.5, 0.0)),
        ("Foot", 1.37, (0.0, -5.0, 5.6)),
    )),
)
ANKLE = 8.0
THIGH, SHANK = 42.5, 41.5
SOFT_KNEE = 8.0  # in quiet standing
RIDE_STIFFNESS = 0.08
HIP = np.array([9.0, -5.0, 0.0])
HEEL = np.array([0.0, -ANKLE, -5.5])
BALL = np.array([0.0, -6.0, 13.0])
SIDES = ("Left", "Right")
OUT = (1.0, -1.0)  # which way is outward

NAMES = tuple(name for name, _, _ in JOINTS)
SKELETON = Skeleton(
    NAMES,
    tuple(NAMES.index(parent) if parent else -1 for _, parent, _ in JOINTS),
    np.array([offset for _, _, offset in JOINTS]),
    tuple(EndSite(NAMES.index(parent), offset) for parent, offset in END_SITES),
)


# The plan -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Step:
    """One swing of one foot: when it leaves and meets the ground, and where."""

    side: int  # 0 left, 1 right
    lift: float
    strike: float
    x: float
    z: float
    yaw: float  # toes outward
    strike_pitch: float = 20.0  # toes up at contact
    lift_pitch: float = 57.0  # heel up at the end of the push
    roll: float = 0.42  # seconds from heel off to toe off
    clearance: float = 3.0


@dataclass(frozen=True)
class Jump:
    """One jump with both feet; `takeoff` and `touchdown` fall on frames."""

    dip: float
    bottom: float
    takeoff: float
    touchdown: float
    absorbed: float
    stand: float
    length: float
    depth: float  # how far the centre of mass sinks before it
    landing_depth: float
    arms: float  # how high they swing
    takeoff_knee: float = 30.0
    touchdown_knee: float = 38.0


START = ((8.0, 0.0, 7.0), (-8.5, -1.0, 8.0))  # x, z, toes outward, of each foot
STEPS = (
    Step(0, 0.95, 1.40, 5.5, 53.0, 5.0, 16.0, 38.0, 0.26),
    Step(1, 1.515, 1.96, -5.0, 115.5, 6.0),
    Step(0, 2.09, 2.51, 5.0, 180.0, 5.0),
    Step(1, 2.64, 3.08, -6.5, 237.0, 7.0, 17.0),
    Step(0, 3.22, 3.76, 9.0, 239.0, 7.0, 4.0, 45.0),
    Step(1, 8.12, 8.57, -5.5, 382.0, 6.0, 16.0, 38.0, 0.26),
    Step(0, 8.685, 9.13, 5.0, 446.0, 5.0),
    Step(1, 9.26, 9.69, -7.0, 504.0, 7.0, 18.0),
    Step(0, 9.83, 10.31, 9.0, 506.0, 6.0, 6.0, 50.0),
)
JUMPS = (
    Jump(5.25, 5.83, 365 / 60, 394 / 60, 6.757, 7.45, 88.0, 21.0, 21.0, 105.0),
    Jump(10.36, 10.88, 668 / 60, 702 / 60, 11.90, 12.70, 120.0, 24.0, 26.0, 130.0),
)


WALKS = (STEPS[:5], STEPS[5:])


# Curves -------------------------------------------------------------------------------------------------------------

TIMES = np.arange((N_FRAMES - 1) * FINE + 1) / (RATE * FINE)
Knot = tuple[float, ...]  # time, value, and as far as given: rate, acceleration


def quintic(knots: Sequence[Knot], times: FloatArray, order: int = 0) -> FloatArray:
    """Evaluate the curve, or a derivative, that takes value, rate and acceleration at each knot (0 where left out).

    Held flat outside.
    """
    table = np.array([tuple(knot) + (0.0,) * (4 - len(knot)) for knot in knots])
    place = np.clip(np.searchsorted(table[:, 0], times, side="right") - 1, 0, len(table) - 2)
    a, b = table[place], table[place + 1]
    span = b[:, 0] - a[:, 0]
    s = (times - a[:, 0]) / span
    inside = (s >= 0.0) & (s <= 1.0)
    s = np.clip(s, 0.0, 1.0)
    p0, v0, a0 = a[:, 1], a[:, 2] * span, a[:, 3] * span**2
    p1, v1, a1 = b[:, 1], b[:, 2] * span, b[:, 3] * span**2
    c = (
        p0,
        v0,
        a0 / 2,
        10 * (p1 - p0) - 6 * v0 - 4 * v1 - (3 * a0 - a1) / 2,
        -15 * (p1 - p0) + 8 * v0 + 7 * v1 + (3 * a0 - 2 * a1) / 2,
        6 * (p1 - p0) - 3 * (v0 + v1) - (a0 - a1) / 2,
    )
    result = np.zeros_like(s)
    for power in range(order, 6):
        factor = np.prod(np.arange(power, power - order, -1))
        result = result + c[power] * factor * s ** (power - order)
    return result / span**order if order == 0 else np.where(inside, result / span**order, 0.0)


def soften(values: FloatArray, seconds: float) -> FloatArray:
    """Blur along the first axis with a Gaussian; the ends are held."""
    reach = int(np.ceil(4 * seconds * RATE * FINE))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / (seconds * RATE * FINE)) ** 2)
    padded = np.pad(values, [(reach, reach)] + [(0, 0)] * (values.ndim - 1), mode="edge")
    columns = padded.reshape(len(padded), -1).T
    blurred = np.array([np.convolve(column, kernel / kernel.sum(), mode="valid") for column in columns])
    return blurred.T.reshape(values.shape)


def flow(keys: Sequence[tuple[float, float]], seconds: float = 0.03) -> FloatArray:
    """Pass near keys without overshooting any: monotone cubic pieces, a little blurred."""
    t, v = np.array(keys).T
    steps, slopes = np.diff(t), np.diff(v) / np.diff(t)
    rates = np.zeros(len(t))
    same = slopes[:-1] * slopes[1:] > 0
    w0, w1 = 2 * steps[1:] + steps[:-1], steps[1:] + 2 * steps[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        rates[1:-1] = np.where(same, (w0 + w1) / (w0 / slopes[:-1] + w1 / slopes[1:]), 0.0)
    place = np.clip(np.searchsorted(t, TIMES, side="right") - 1, 0, len(t) - 2)
    s = np.clip((TIMES - t[place]) / steps[place], 0.0, 1.0)
    h = steps[place]
    curve = (
        v[place] * (1 + 2 * s) * (1 - s) ** 2
        + rates[place] * h * s * (1 - s) ** 2
        + v[place + 1] * s**2 * (3 - 2 * s)
        + rates[place + 1] * h * s**2 * (s - 1)
    )
    return soften(curve, seconds)


def wander(seed: int) -> FloatArray:
    """Sway slowly between about -1 and 1, never quite repeating; another `seed`, another course."""
    phase = 2 * np.pi * np.modf(seed * np.array([0.618034, 0.754878, 0.569840]))[0]
    speed = 2 * np.pi * np.array([0.21, 0.37, 0.61]) * (1 + 0.13 * np.sin(3.0 * seed))
    return np.sin(TIMES[:, None] * speed + phase) @ np.array([0.5, 0.35, 0.2])


# The feet -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Foot:
    """One foot over the whole clip, at the working rate (undefined in flight)."""

    ankle: FloatArray  # (n, 3)
    pitch: FloatArray  # toes up
    yaw: FloatArray  # about the vertical axis
    toes: FloatArray  # bend of the toes, upward
    place: FloatArray  # where its ankle stands when flat, not a number in the swing, (n, 3)


def turned(yaw: FloatArray | float, pitch: FloatArray | float) -> FloatArray:
    """Return the rotation of a foot."""
    about_y = rotation.about_axis(1, np.radians(yaw))
    return rotation.multiply(about_y, rotation.about_axis(0, -np.radians(pitch)))


def standing_ankle(place: FloatArray, yaw: float, pitch: FloatArray) -> FloatArray:
    """Return where the ankle is when the sole at `place` has rolled over its heel (pitch > 0) or its ball (< 0)."""
    pitch = np.asarray(pitch, dtype=np.float64)
    pivot = np.where(pitch[..., None] > 0, HEEL, BALL)
    flat = rotation.rotate(turned(yaw, np.zeros_like(pitch)), pivot)
    return np.asarray(place + flat - rotation.rotate(turned(yaw, pitch), pivot))


def rolling(place: FloatArray, yaw: float, knot: Knot) -> FloatArray:
    """Return the ankle's position, velocity and acceleration, shape (3, 3), for a pitch knot."""
    _, pitch, rate, acceleration = knot
    h = 0.01
    before, here, after = standing_ankle(place, yaw, pitch + np.array([-h, 0.0, h]))
    first, second = (after - before) / (2 * h), (after - 2 * here + before) / h**2
    return np.array([here, first * rate, first * acceleration + second * rate**2])


def heel_rise(s: FloatArray, order: int = 0) -> FloatArray:
    """Return the terms s^3, s^4, s^5 of a heel's rise, or their derivatives, shape (n, 3): it leaves the ground without a jerk."""
    powers = np.array([3, 4, 5])
    factor = np.array([1, 1, 1]) if order == 0 else powers if order == 1 else powers * (powers - 1)
    return np.asarray(factor * s[:, None] ** (powers - order))


def first_roll(step: Step) -> FloatArray:
    """Return the coefficients of a plain heel rise: the planned angle at toe off, still rising."""
    rate = 3.9 * step.roll
    # Value 1, slope `rate`, no acceleration at s = 1.
    terms = np.array([[1.0, 1, 1], [3, 4, 5], [6, 12, 20]])
    return -step.lift_pitch * np.linalg.solve(terms, np.array([1.0, rate, 0.0]))


def push_off(step: Step, foot: Foot, hip: FloatArray, knees: FloatArray, roll: FloatArray) -> FloatArray:
    """Fit the heel's rise so that the leg behind bends its knee as planned: the heel comes up when the leg is fully out."""
    now = (step.lift - step.roll < TIMES) & (step.lift >= TIMES)
    place, yaw, reach = foot.place[now], float(foot.yaw[now][0]), leg_length(knees[now])
    if np.isnan(place[-1]).any():
        place = np.broadcast_to(place[0], place.shape)
    pitch = np.full(now.sum(), -15.0)
    for _ in range(12):
        def over(p: FloatArray) -> FloatArray:
            return np.sqrt(np.sum((standing_ankle(place, yaw, p) - hip[now]) ** 2, axis=-1)) - reach
        slope = (over(pitch + 0.05) - over(pitch - 0.05)) / 0.1
        pitch = np.clip(pitch - np.clip(over(pitch) / np.maximum(slope, 0.02), -15, 15), -80.0, 0.0)
    s = (TIMES[now] - step.lift + step.roll) / step.roll
    prior = first_roll(step)
    rows = np.concatenate([heel_rise(s), 6.0 * heel_rise(np.array([1.0])), 1.0 * heel_rise(np.array([1.0]), 1), 0.2 * heel_rise(np.array([1.0]), 2)])
    wanted = np.concatenate([pitch, rows[-3:] @ prior])
    return 0.5 * roll + 0.5 * np.linalg.lstsq(rows, wanted, rcond=None)[0]


def walk_foot(side: int, rolls: dict[Step, FloatArray]) -> Foot:
    """Lay out one foot: stance, swing, stance ..., with a gap for each flight."""
    out = OUT[side]
    x, z, outward = START[side]
    place, yaw = np.array([x, ANKLE, z]), out * outward
    ankle, pitch, toes, yaws = np.empty((len(TIMES), 3)), np.zeros(len(TIMES)), np.zeros(len(TIMES)), np.empty(len(TIMES))
    events = sorted(
        [*(step for step in STEPS if step.side == side), *JUMPS],
        key=lambda event: event.lift if isinstance(event, Step) else event.takeoff,
    )
    places = np.full((len(TIMES), 3), np.nan)
    knots: list[Knot] = [(-1.0, 0.0)]
    began = -1.0
    # Each round fills from the last contact to the next.
    for event in events:
        if isinstance(event, Step):
            heel_off = event.lift - event.roll
            one = np.array([1.0])
            left: Knot = (event.lift, *(float((heel_rise(one, order) @ rolls[event])[0]) / event.roll**order for order in range(3)))
            met: Knot = (event.strike, event.strike_pitch, -150.0 if event.strike_pitch > 10 else -20.0, 0.0)
            flat = event.strike + (0.115 if event.strike_pitch > 10 else 0.13)
            end = event.strike
        else:
            heel_off = event.takeoff - 0.26 + 0.01 * side
            left = (event.takeoff, -52.0, -520.0, 0.0)
            met = (event.touchdown, -20.0, 330.0, 0.0)
            flat, end = event.touchdown + 0.11, event.touchdown
        knots += [(heel_off, 0.0), left]
        now = (began <= TIMES) & (left[0] > TIMES)
        pitch[now] = quintic(knots[:-1] if isinstance(event, Step) else knots, TIMES[now])
        if isinstance(event, Step):
            pitch[now] += heel_rise(np.maximum(0.0, (TIMES[now] - heel_off) / event.roll)) @ rolls[event]
        ankle[now] = standing_ankle(place, yaw, pitch[now])
        places[now] = place
        toes[now] = np.maximum(0.0, -pitch[now])
        yaws[now] = yaw
        next_place = np.array([event.x, ANKLE, event.z]) if isinstance(event, Step) else place + [0, 0, event.length]
        if isinstance(event, Jump):
            next_place = next_place + np.array([out * 0.7, 0.0, (1.5, -1.0)[side]])
        next_yaw = out * event.yaw if isinstance(event, Step) else yaw + out
        now = (left[0] <= TIMES) & (end > TIMES)
        times = TIMES[now]
        s = (times - left[0]) / (end - left[0])
        ends = rolling(place, yaw, left), rolling(next_place, next_yaw, met)
        if isinstance(event, Step):
            # The foot brakes late and hard; a gentle stop would have it wait for the body with a stiff leg.
            ends[1][2, 1:] += [300.0, -28.0 * (next_place[2] - place[2])]
        for axis in range(3):
            ankle[now, axis] = quintic(
                [(left[0], *ends[0][:, axis]), (end, *ends[1][:, axis])], times
            )
        if isinstance(event, Step):
            ankle[now, 1] += event.clearance * 150 * s**3 * (1 - s) ** 4
        pitch[now] = quintic([left, met], times)
        toes[now] = quintic([(left[0], -left[1], -left[2]), (left[0] + 0.7 * (end - left[0]), 4.0), (end, max(0.0, -met[1]))], times)
        yaws[now] = quintic([(left[0], yaw), (end, next_yaw)], times)
        place, yaw, began = next_place, next_yaw, end
        knots = [met, (flat, 0.0)]
    now = began <= TIMES
    pitch[now] = quintic([*knots, (TIMES[-1] + 1, 0.0)], TIMES[now])
    ankle[now], yaws[now] = standing_ankle(place, yaw, pitch[now]), yaw
    toes[now] = np.maximum(0.0, -pitch[now])
    places[now] = place
    return Foot(ankle, pitch, yaws, toes, places)


# The centre of mass -------------------------------------------------------------------------------------------------


def mass_centre(motion: Motion) -> FloatArray:
    """Return the whole body's centre of mass, shape (n, 3)."""
    poses = global_poses(motion)
    total = np.zeros((motion.n_frames, 3))
    for name, mass, centre in MASSES:
        joint = NAMES.index(name)
        total += mass * (poses.positions[:, joint] + rotation.rotate(poses.rotations[:, joint], np.array(centre)))
    return total / sum(mass for _, mass, _ in MASSES)


def standing_height() -> float:
    """Return the centre of mass's height in quiet standing: the rest pose, knees a little soft."""
    rest = Motion(SKELETON, rotation.identity(1, len(NAMES)))
    return float(mass_centre(rest)[0, 1]) - 0.3


def leaps(ends: Sequence[tuple[float, float]], ride: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the height that the jumps ask of the centre of mass, its acceleration, and where they have the say (0 to 1).

    Dip, push, parabola, landing: quintic pieces that share rate and acceleration at their joints, so that the force on the
    ground never jumps and is 0 at take-off and touchdown.
    """
    up = standing_height()
    knots: list[Knot] = [(-1.0, up)]
    say = np.zeros(len(TIMES))
    for jump, (off, down) in zip(JUMPS, ends, strict=True):
        t = jump.touchdown - jump.takeoff
        speed = (down - off) / t + GRAVITY * t / 2
        knots += [
            (jump.dip, float(np.interp(jump.dip, TIMES, ride))),
            (jump.bottom, up - jump.depth, 0.0, 900.0),
            (jump.takeoff, off, speed, -GRAVITY),
            (jump.touchdown, down, speed - GRAVITY * t, -GRAVITY),
            (jump.absorbed, up - jump.landing_depth, 0.0, 800.0),
            (jump.stand, float(np.interp(jump.stand, TIMES, ride))),
        ]
        say += quintic(
            [(jump.dip, 0.0), (jump.dip + 0.35, 1.0), (jump.stand - 0.4, 1.0), (jump.stand, 0.0)], TIMES
        )
    return quintic(knots, TIMES), quintic(knots, TIMES, order=2), say


def knee_plan() -> tuple[FloatArray, FloatArray]:
    """Return how far each knee should bend while walking and standing, and how much that matters, both (n, 2).

    The normal pattern of gait: nearly straight at contact, a soft give under the load, straight again as the body passes
    over, bending before the foot leaves. The swing is left to the foot's path.
    """
    plan, matter = np.empty((len(TIMES), 2)), np.empty((len(TIMES), 2))
    for side in (0, 1):
        bend: list[tuple[float, float]] = [(-1.0, SOFT_KNEE)]
        weight: list[tuple[float, float]] = [(-1.0, 1.0)]
        for walk in WALKS:
            for i, step in enumerate(walk):
                if step.side == 1 - side:
                    continue
                first, last = i < 2, i >= len(walk) - 2
                bend += [(step.lift - (0.3 if first else 0.16), 10.0 if first else 15.0), (step.lift, 36.0)]
                weight += [(step.lift - 0.27, 1.0), (step.lift - 0.16, 0.02)]
                closing = step is walk[-1]
                landing = 14.0 if closing else 22.0 if i == 0 else 8.0
                bend += [(step.strike - 0.08, landing + 4.0), (step.strike, landing),
                         (step.strike + 0.12, 16.0 if closing else 24.0 if i == 0 else 18.0), (step.strike + 0.34, 10.0 if last else 13.0)]
                weight += [(step.strike - 0.13, 0.02), (step.strike - 0.05, 1.0)]
                if last:
                    bend.append((step.strike + 0.7, SOFT_KNEE))
        plan[:, side] = flow([*bend, (99.0, SOFT_KNEE)], 0.02)
        matter[:, side] = flow([*weight, (99.0, 1.0)], 0.02)
    return plan, matter


def splined(values: FloatArray, weights: FloatArray, stiffness: float) -> FloatArray:
    """Fit a cubic spline (knots a thirtieth of a second apart) to weighted values, its bending held down."""
    spacing = RATE * FINE // 30
    s = np.arange(len(TIMES)) / spacing
    columns = np.arange(-1, int(s[-1]) + 3)
    x = np.abs(s[:, None] - columns)
    basis = np.where(x < 1, 2 / 3 - x**2 + x**3 / 2, np.where(x < 2, (2 - x) ** 3 / 6, 0.0))
    bending = np.diff(np.eye(len(columns)), 2, axis=0)
    normal = (basis.T * weights) @ basis + stiffness * bending.T @ bending
    return np.asarray(basis @ np.linalg.solve(normal, basis.T @ (weights * values)))


def pressure() -> FloatArray:
    """Return the centre of pressure on the ground, shape (n, 2), x and z: under the foot that stands, between the two where both do."""
    places = [np.array([x, z]) for x, z, _ in START]
    keys: list[tuple[float, float, float]] = []

    def between(t: float, forward: float, share: float = 0.5) -> None:
        x, z = (1 - share) * places[0] + share * places[1]
        keys.append((t, float(x), float(z) + forward))

    def under(t: float, side: int, forward: float) -> None:
        keys.append((t, float(places[side][0]) - 0.5 * OUT[side], float(places[side][1]) + forward))

    between(0.0, 4.5)
    for walk, jump in zip(WALKS, JUMPS, strict=True):
        first = walk[0]
        between(first.lift - 0.42, 4.5)
        # Before the first step the pressure goes back and towards the foot that will swing.
        between(first.lift - 0.27, 1.0, 0.5 + (0.22 if first.side else -0.22))
        for i, step in enumerate(walk):
            under(step.lift, 1 - step.side, 5.5 if i else 3.0)
            under(step.strike, 1 - step.side, (17.0 if i else 13.0) if i < len(walk) - 1 else 8.0)
            places[step.side] = np.array([step.x, step.z])
        settle = walk[-1].strike + (0.25 if jump.dip > walk[-1].strike else 0.1)
        between(settle, 4.5)
        if jump.dip - settle > 1.0:
            # The pause: rest on the right leg, then on both again.
            between(settle + 0.35, 4.0, 0.68)
            between(jump.dip - 0.35, 5.0, 0.60)
        between(max(jump.dip, settle + 0.05), 4.5)
        between(jump.bottom - 0.05, 1.0)
        between(jump.takeoff - 0.12, 12.0)
        between(jump.takeoff, 16.0)
        for side in (0, 1):
            places[side] = places[side] + np.array([OUT[side] * 0.7, jump.length + (1.5, -1.0)[side]])
        between(jump.touchdown, 14.0)
        between(jump.touchdown + 0.1, 7.0)
        between(jump.absorbed, 5.0, 0.47)
        between(jump.stand, 4.0, 0.47)
    between(float(TIMES[-1]), 4.5, 0.52)
    t, x, z = np.array(keys).T
    course = soften(np.stack([np.interp(TIMES, t, x), np.interp(TIMES, t, z)], axis=-1), 0.03)
    sway = np.stack([0.7 * wander(1), 0.8 * wander(2)], axis=-1)
    return course + sway


def pendulum(centre: FloatArray, y: FloatArray, y_acceleration: FloatArray) -> FloatArray:
    """Solve the path over the ground of a mass at height `y` that is pushed from the centre of pressure.

    The force points from the pressure p through the mass at x: ``x'' y = (y'' + g) (x - p)``. In flight y'' = -g, so x''
    = 0 by itself. An initial value would topple; so both ends are tied to p and the whole clip is one tridiagonal system.
    """
    h = 1 / (RATE * FINE)
    stiffness = h * h * (y_acceleration + GRAVITY) / y
    stiffness[np.abs(y_acceleration + GRAVITY) < 1e-6] = 0.0
    n = len(y)
    # Forward elimination of x[i-1] - (2 + k) x[i] + x[i+1] = -k p[i], then back substitution.
    ratio, known = np.zeros(n), np.zeros((n, 2))
    known[0] = centre[0]
    for i in range(1, n - 1):
        pivot = 2 + stiffness[i] - ratio[i - 1]
        ratio[i] = 1 / pivot
        known[i] = (stiffness[i] * centre[i] + known[i - 1]) / pivot
    x = np.empty((n, 2))
    x[-1] = centre[-1]
    for i in range(n - 2, -1, -1):
        x[i] = known[i] + ratio[i] * x[i + 1]
    return x


# Trunk, head and arms -----------------------------------------------------------------------------------------------


def over_jumps(*keys: tuple[str, float, float], rest: float = 0.0, scaled: bool = False) -> list[tuple[float, float]]:
    """Lay keys (event, seconds after it, value) over both jumps, with `rest` outside; `scaled` by how high the arms swing."""
    result = [(-1.0, rest)]
    for jump in JUMPS:
        for event, after, value in keys:
            if event == "middle":
                t = (jump.takeoff + jump.touchdown) / 2
            else:
                t = getattr(jump, event)
            result.append((t + after, value * (jump.arms / 110 if scaled and value > 0 else 1.0)))
    return [*result, (float(TIMES[-1]) + 1, rest)]


def shared(angles: dict[str, FloatArray], axis: int, total: FloatArray, shares: dict[str, float]) -> None:
    """Spread an angle over a chain of joints; `axis` 0 is Z, 1 is Y, 2 is X."""
    for name, share in shares.items():
        angles[name][:, axis] += share * total


TRUNK = {"Spine": 0.4, "Spine1": 0.35, "Chest": 0.25}
NECK = {"Neck": 0.45, "Head": 0.55}


def carriage(feet: tuple[Foot, Foot], centre: FloatArray, mass: FloatArray) -> dict[str, FloatArray]:
    """Return the Euler angles (Z, Y, X) of every joint above the legs, and of the root."""
    angles = {name: np.zeros((len(TIMES), 3)) for name in NAMES}
    # Stride: 1 with the left foot a full step ahead, -1 with the right. In flight the feet are level.
    apart = feet[0].ankle[:, 2] - feet[1].ankle[:, 2]
    stride = soften(apart / 65, 0.045)
    late = np.roll(stride, int(0.045 * RATE * FINE))
    late[: int(0.045 * RATE * FINE)] = stride[0]
    speed = np.gradient(mass[:, 1], TIMES) / 120
    push = soften(np.gradient(speed, TIMES), 0.08)
    in_air = np.zeros(len(TIMES), dtype=bool)
    for jump in JUMPS:
        in_air |= (jump.dip < TIMES) & (jump.stand > TIMES)
    walking = soften(np.where(in_air, 0.0, np.clip(speed, 0.0, 1.0)), 0.1)
    # Which leg carries: 1 the right, -1 the left.
    left, right = feet[0].ankle[:, 0], feet[1].ankle[:, 0]
    carries = soften(np.clip(2 * (centre[:, 0] - left) / (right - left) - 1, -1.2, 1.2), 0.05)
    quiet = 1 - walking

    pelvis_pitch = flow(over_jumps(
        ("dip", 0, 0), ("bottom", 0, 33), ("takeoff", -0.02, 2), ("middle", 0, 3), ("touchdown", 0, 8),
        ("absorbed", 0.02, 24), ("stand", 0, 0), rest=0.0))
    trunk_pitch = flow(over_jumps(
        ("dip", 0, 1), ("bottom", -0.02, 57), ("takeoff", 0, 8), ("middle", 0, 12), ("touchdown", 0, 20),
        ("absorbed", 0.05, 38), ("stand", 0.05, 1), rest=1.0))
    gaze_pitch = flow(over_jumps(
        ("dip", 0, 4), ("bottom", -0.1, 14), ("takeoff", 0.02, -4), ("middle", 0, 10), ("touchdown", 0, 16),
        ("absorbed", 0.05, 15), ("stand", 0.1, 3), rest=3.0), 0.05)
    pelvis_pitch += 2.0 * walking + 0.6 * wander(3) * quiet
    trunk_pitch += 1.0 + 2.5 * walking + np.where(in_air, 0.0, 1.5 * push) + 0.5 * wander(4)
    trunk_pitch = soften(trunk_pitch, 0.03)
    gaze_pitch += 1.2 * wander(5) + 3.0 * walking

    pelvis_yaw = -5.5 * stride + 1.0 * wander(6) * quiet
    chest_yaw = 5.0 * late + 1.2 * wander(7) * quiet
    pause = STEPS[4].strike
    look = flow([
        (-1, 0), (0.0, 2), (0.7, -3), (1.3, 0), (pause - 0.1, 0), (pause + 0.35, 30), (pause + 0.62, 32), (pause + 1.05, -26),
        (pause + 1.25, -27), (JUMPS[0].dip + 0.1, 0), (JUMPS[0].stand - 0.2, 0), (JUMPS[0].stand + 0.25, -14), (8.3, -1), (12.2, 0),
        (12.75, 12), (13.2, 14), (14.6, 2)], 0.05)
    chest_yaw += 0.16 * soften(look, 0.1)
    head_yaw = look + 0.3 * chest_yaw + 1.5 * wander(8)

    # The hip of the swinging leg drops; a resting one drops more slowly and further.
    pelvis_roll = carries * (-3.8 * walking - 2.6 * quiet)
    chest_roll = -carries * (1.6 * walking) + carries * 0.9 * quiet + 0.4 * wander(9)
    head_roll = 0.4 * chest_roll + 1.0 * wander(10)

    angles["Hips"][:] = np.stack([pelvis_roll, pelvis_yaw, pelvis_pitch], axis=-1)
    for axis, lower, upper, top in ((0, pelvis_roll, chest_roll, head_roll), (1, pelvis_yaw, chest_yaw, head_yaw),
                                    (2, pelvis_pitch, trunk_pitch, gaze_pitch)):
        shared(angles, axis, upper - lower, TRUNK)
        shared(angles, axis, top - upper, NECK)
    breath = np.sin(2 * np.pi * 0.28 * TIMES + 0.6)
    angles["Chest"][:, 2] -= 0.7 * breath
    angles["Neck"][:, 2] += 0.7 * breath

    for side, name in enumerate(SIDES):
        out, lag = OUT[side], 0.012 * (1 - 2 * side)
        swing = late * (1 if side else -1)  # forward with the other foot
        reach = flow(over_jumps(
            ("dip", 0.0, 0), ("bottom", -0.18 + lag, -52), ("bottom", -0.03 + lag, -38), ("takeoff", 0.02 + lag, 95),
            ("middle", -0.06, 110), ("touchdown", lag, 62), ("absorbed", 0.04 + lag, 56), ("stand", -0.15 + lag, -5),
            ("stand", 0.25, 0), scaled=True), 0.035)
        bend = flow(over_jumps(
            ("dip", 0.0, 0), ("bottom", -0.12 + lag, 6), ("bottom", 0.08 + lag, 30), ("takeoff", -0.03 + lag, 52), ("middle", 0, 32),
            ("touchdown", lag, 26), ("absorbed", 0.02, 42), ("stand", -0.1, 6), ("stand", 0.25, 0)), 0.035)
        spread = flow(over_jumps(
            ("dip", 0, 0), ("bottom", -0.1, 7), ("takeoff", 0, 4), ("middle", 0, 14), ("touchdown", 0, 16), ("absorbed", 0.05, 14),
            ("stand", 0, 0)), 0.05)
        flex = reach + (17.0 + 2 * side) * swing * np.clip(walking * 1.3, 0, 1) - 2.0 * walking + 1.2 * wander(11 + side)
        elbow = 13 + 2 * side + bend + walking * (8 + 9 * swing) + 1.5 * wander(13 + side)
        raised = np.clip(reach / 90, 0.0, 1.2)
        # The shoulder girdle goes along with an arm that rises or swings.
        angles[f"{name}Shoulder"][:, 0] = out * (0.12 * np.maximum(reach, 0) + 0.8 * breath)
        angles[f"{name}Shoulder"][:, 1] = -out * (0.10 * flex)
        angles[f"{name}Arm"][:] = np.stack([
            out * (7.5 + spread + 0.7 * wander(15 + side)), -out * (14 - 24 * raised), -flex], axis=-1)
        angles[f"{name}ForeArm"][:, 2] = -elbow
        angles[f"{name}ForeArm"][:, 1] = -out * (7 + 0.04 * bend)
        angles[f"{name}Hand"][:, 2] = -6 - 0.15 * elbow + 2 * wander(17 + side)
        angles[f"{name}Hand"][:, 0] = -out * 3.0
    return angles


# Legs and root ------------------------------------------------------------------------------------------------------


def legs(feet: tuple[Foot, Foot], root: FloatArray, hips: FloatArray, angles: dict[str, FloatArray]) -> FloatArray:
    """Reach for the ankles from where the root is: fill in the angles of both legs; return hip to ankle, (n, 2, 3)."""
    reaches = np.empty((len(TIMES), 2, 3))
    for side, name in enumerate(SIDES):
        foot = feet[side]
        hip = root + rotation.rotate(hips, HIP * [OUT[side], 1, 1])
        down = foot.ankle - hip
        reach = np.sqrt(np.sum(down**2, axis=-1))
        reaches[:, side] = down
        reach = np.minimum(reach, THIGH + SHANK - 1e-9)
        down = down / np.sqrt(np.sum(down**2, axis=-1, keepdims=True))
        knee = np.pi - np.arccos(np.clip((THIGH**2 + SHANK**2 - reach**2) / (2 * THIGH * SHANK), -1, 1))
        at_hip = np.arccos(np.clip((THIGH**2 + reach**2 - SHANK**2) / (2 * THIGH * reach), -1, 1))
        # The knee points where the toes point, a little less outward.
        ahead = np.radians(0.8 * foot.yaw)
        forward = np.stack([np.sin(ahead), np.zeros_like(ahead), np.cos(ahead)], axis=-1)
        across = np.cross(-down, forward)
        across /= np.sqrt(np.sum(across**2, axis=-1, keepdims=True))
        front = np.cross(across, -down)
        up = -(np.cos(at_hip)[:, None] * down + np.sin(at_hip)[:, None] * front)
        thigh = from_axes(across, up, np.cross(across, up))
        shank = rotation.multiply(thigh, rotation.about_axis(0, knee))
        sole = turned(foot.yaw, foot.pitch)
        angles[f"{name}UpLeg"] = euler(rotation.multiply(rotation.conjugate(hips), thigh))
        angles[f"{name}Leg"][:, 2] = np.degrees(knee)
        angles[f"{name}Foot"] = euler(rotation.multiply(rotation.conjugate(shank), sole))
        angles[f"{name}ToeBase"][:, 2] = -foot.toes
    return reaches


def leg_length(knee: FloatArray | float) -> FloatArray:
    """Return the distance from hip to ankle at a knee angle."""
    return np.asarray(np.sqrt(THIGH**2 + SHANK**2 + 2 * THIGH * SHANK * np.cos(np.radians(knee))))


def from_axes(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """Return the rotations whose axes are x, y, z; none turns by as much as half a turn here."""
    w = 0.5 * np.sqrt(np.maximum(1 + x[:, 0] + y[:, 1] + z[:, 2], 1e-12))
    return rotation.normalize(
        np.stack([w, (y[:, 2] - z[:, 1]) / (4 * w), (z[:, 0] - x[:, 2]) / (4 * w), (x[:, 1] - y[:, 0]) / (4 * w)], axis=-1)
    )


def euler(q: FloatArray) -> FloatArray:
    """Return angles (Z, Y, X) in degrees."""
    return np.degrees(rotation.to_euler("ZYX", q))


def motion_of(root: FloatArray, angles: dict[str, FloatArray]) -> Motion:
    """Assemble a motion at the working rate."""
    local = rotation.from_euler("ZYX", np.radians(np.stack([angles[name] for name in NAMES], axis=1)))
    translations = np.array(np.broadcast_to(SKELETON.offsets, (len(root), len(NAMES), 3)))
    translations[:, 0] = root
    return Motion(SKELETON, local, translations, rate=Fraction(RATE * FINE))


def flight_legs(angles: dict[str, FloatArray]) -> None:
    """Carry the legs through each flight: straighten, tuck a little, reach for the ground.

    Angles and their rates are taken over from the pushing leg and handed to the landing one.
    """
    h = 1 / (RATE * FINE)
    tuck = {"Leg": 46.0, "UpLeg": -36.0, "Foot": 12.0, "ToeBase": -6.0}
    for jump in JUMPS:
        first, last = round(jump.takeoff / h), round(jump.touchdown / h)
        t = jump.touchdown - jump.takeoff
        for side, name in enumerate(SIDES):
            knee = angles[f"{name}Leg"][:, 2]
            rates = {
                joint: (
                    (3 * c[first] - 4 * c[first - 1] + c[first - 2]) / (2 * h),
                    (-3 * c[last] + 4 * c[last + 1] - c[last + 2]) / (2 * h),
                )
                for joint, c in ((joint, angles[f"{name}{joint}"]) for joint in tuck)
            }
            # The legs go on unfolding, and begin to give before they land, as long as the knee needs to stop in time.
            off = -2 * (knee[first] - 8.0) / rates["Leg"][0][2]
            on = 2 * (knee[last] - 16.0) / rates["Leg"][1][2]
            for joint, middle in tuck.items():
                before, after = rates[joint]
                for axis in range(3):
                    c = angles[f"{name}{joint}"][:, axis]
                    knots: list[Knot] = [(0.0, c[first], before[axis], -before[axis] / off)]
                    if axis == 2:
                        knots.append(((0.5 + 0.02 * side) * t, middle + 3 * side))
                    knots.append((t, c[last], after[axis], after[axis] / on))
                    c[first : last + 1] = quintic(knots, TIMES[first : last + 1] - jump.takeoff)


def spin(angles: dict[str, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Return angular momentum and moment of inertia about the centre of mass and the X axis, per unit of mass.

    Segments count as points at their centres.
    """
    motion = motion_of(np.zeros((len(TIMES), 3)), angles)
    poses = global_poses(motion)
    middle = mass_centre(motion)
    momentum, inertia = np.zeros((2, len(TIMES)))
    for name, mass, centre in MASSES:
        joint = NAMES.index(name)
        arm = poses.positions[:, joint] + rotation.rotate(poses.rotations[:, joint], np.array(centre)) - middle
        velocity = np.gradient(arm, TIMES, axis=0)
        momentum += mass / 100 * (arm[:, 1] * velocity[:, 2] - arm[:, 2] * velocity[:, 1])
        inertia += mass / 100 * (arm[:, 1] ** 2 + arm[:, 2] ** 2)
    return momentum, inertia


def keep_turning(angles: dict[str, FloatArray]) -> None:
    """Turn the whole body in flight so that its angular momentum about the side axis stays put: legs forward, trunk forward.

    The turn starts and ends at rest, where feet are on the ground; between, the momentum is the one value that makes it end
    at 0.
    """
    momentum, inertia = spin(angles)
    for jump in JUMPS:
        window = quintic(
            [(jump.takeoff, 0.0), (jump.takeoff + 0.06, 1.0), (jump.touchdown - 0.06, 1.0), (jump.touchdown, 0.0)], TIMES
        )
        share = window / inertia
        level = (share * momentum).sum() / share.sum()
        rate = share * (level - momentum)
        turn = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2)]) / (RATE * FINE)
        angles["Hips"][:, 2] += np.degrees(turn)


def solve() -> tuple[Motion, dict[str, FloatArray], FloatArray]:
    """Put it all together; return the motion at the working rate, the angles, and the path of the centre of mass.

    The height of the centre of mass bends to the legs: it sinks where a leg would have to be longer than it is, and each
    jump's take-off and touchdown heights are those that give the knees their planned angles.
    """
    rolls = {step: first_roll(step) for step in STEPS}
    centre = pressure()
    up = standing_height()
    ends = [(up + 5.0, up) for _ in JUMPS]
    knees, matter = knee_plan()
    lengths = leg_length(knees)
    keen = matter.copy()
    ride = np.full(len(TIMES), up)
    air = np.zeros(len(TIMES), dtype=bool)
    for jump in JUMPS:
        air[round(jump.takeoff * RATE * FINE) + 1 : round(jump.touchdown * RATE * FINE)] = True
    for _ in range(16):
        feet = (walk_foot(0, rolls), walk_foot(1, rolls))
        leap, leap_acceleration, say = leaps(ends, ride)
        bob = (1 - say) * (ride - leap)
        y = leap + bob
        y_acceleration = leap_acceleration + np.where(say < 1, np.gradient(np.gradient(bob, TIMES), TIMES), 0.0)
        ground = pendulum(centre, y, y_acceleration)
        mass = np.stack([ground[:, 0], y, ground[:, 1]], axis=-1)
        angles = carriage(feet, centre, ground)
        hips = rotation.from_euler("ZYX", np.radians(angles["Hips"]))
        root = mass + [0.0, 4.0, 0.0]
        for _ in range(12):
            down = legs(feet, root, hips, angles)
            root = root + mass - mass_centre(motion_of(root, angles))
        # The height at which each knee would bend as planned.
        level = np.sqrt(np.maximum(lengths**2 - down[:, :, 0] ** 2 - down[:, :, 2] ** 2, 1.0)) + down[:, :, 1]
        # A leg is heeded by how fast its knee bends when the hip sinks, squared; a stretched one always.
        bend = np.stack([np.maximum(angles[f"{name}Leg"][:, 2], 5.0) for name in SIDES], axis=-1)
        tight = np.clip((13.0 - bend) / 5.0, 0.0, 1.0)
        keen = 0.5 * keen + 0.5 * np.maximum(matter, tight) / (THIGH * np.sin(np.radians(bend) / 2)) ** 2
        weights = np.where((say > 0)[:, None], 0.0, keen)
        total = weights.sum(axis=1)
        asked = np.where(say > 0, leap, y + (weights * level).sum(axis=1) / np.maximum(total, 1e-12))
        ride = splined(asked, np.where(say > 0, 0.05, total), RIDE_STIFFNESS)
        for step in STEPS:
            side = step.side
            hip = feet[side].ankle - down[:, side]
            hip[:, 1] += ride - y
            rolls[step] = push_off(step, feet[side], hip, knees[:, side], rolls[step])
        for k, jump in enumerate(JUMPS):
            moved = []
            for t, knee in ((jump.takeoff, jump.takeoff_knee), (jump.touchdown, jump.touchdown_knee)):
                d = down[round(t * RATE * FINE)]
                high = np.sqrt(leg_length(knee) ** 2 - d[:, 0] ** 2 - d[:, 2] ** 2) + d[:, 1]
                moved.append(float(np.mean(high)))
            ends[k] = (ends[k][0] + moved[0], ends[k][1] + moved[1])
    spare = THIGH + SHANK - np.sqrt(np.sum(down**2, axis=-1))
    print("ends", np.round(np.array(ends) - up, 2).tolist(), "least spare", spare[~air].min(), TIMES[~air][spare[~air].min(1).argmin()], "moved", moved)
    flight_legs(angles)
    keep_turning(angles)
    root = root + mass - mass_centre(motion_of(root, angles))
    return motion_of(root, angles), angles, mass


def phases() -> list[dict[str, str | int]]:
    """Return what happens from which frame to which, both included; in flight both feet are off the ground."""
    starts: list[tuple[str, float]] = [("stand", 0.0)]
    for walk, jump in zip(WALKS, JUMPS, strict=True):
        starts.append(("walk", walk[0].lift - walk[0].roll))
        if jump.dip - walk[-1].strike > 0.3:
            starts.append(("pause", walk[-1].strike + 0.15))
        # Take-off is the last frame on the ground, touchdown the first.
        starts += [("crouch", jump.dip), ("push", jump.bottom), ("flight", jump.takeoff + 1 / RATE)]
        starts += [("land", jump.touchdown), ("pause" if jump is not JUMPS[-1] else "stand", jump.stand)]
    first = [round(t * RATE) for _, t in starts]
    last = [frame - 1 for frame in first[1:]] + [N_FRAMES - 1]
    return [
        {"name": name, "first_frame": a, "last_frame": b} for (name, _), a, b in zip(starts, first, last, strict=True)
    ]


def main(argv: Sequence[str]) -> None:
    """Write the clip and its phases."""
    path = Path(argv[0]) if argv else SHIPPED
    fine, angles, _ = solve()
    rotations = ("Zrotation", "Yrotation", "Xrotation")
    moves = ("Xposition", "Yposition", "Zposition")
    clip = Motion(
        SKELETON,
        fine.rotations[::FINE],
        fine.local_translations[::FINE],
        rate=Fraction(RATE),
        name="sample",
        declaration=Declaration("bvh", ((*moves, *rotations), *[rotations] * (len(NAMES) - 1))),
        declared_angles=np.radians(np.stack([angles[name][::FINE] for name in NAMES], axis=1)),
    )
    write(clip, path, overwrite=True)
    lines = ",\n".join(f"  {json.dumps(phase)}" for phase in phases())
    path.with_name(f"{path.stem}_phases.json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
