"""Make the sample clip: a figure that stands, walks, pauses, crouches and jumps with true ballistic flight, twice.

``python tools/make_sample.py OUT.bvh`` writes the clip, and beside it its phases, ``OUT_phases.json``; without a name,
the files that retime ships.

Nothing here is captured, or posed by hand frame by frame. The plan (`WALKS`, `JUMPS`) says when and where the feet
stand. From it follow:

1. the feet: a sole rolls over its heel, stands flat, rolls over its ball, and swings to its next place;
2. the height of the centre of mass: in a jump, pieces whose force never leaps, and an exact parabola in flight;
   elsewhere the height at which the knees bend as knees do in walking;
3. its path over the ground: a pendulum over the centre of pressure (`pendulum`), one linear system for the whole clip,
   so that the shift of weight before a step, braking, and the lean into a jump come out by themselves;
4. trunk, head and arms: curves over the plan's times, swings that answer the feet, a little sway and breath;
5. the root: moved in each frame until the whole body's centre of mass is where 2 and 3 want it, the legs reaching for
   the feet; in flight the legs tuck, and the body turns so that its angular momentum stays put.

1 to 5 depend on each other, so `solve` goes round a few times. Work is done at four times the clip's rate, in
centimetres, degrees and seconds; Y is up, the figure faces +Z, left is +X. Feet pitch with the toes up, the trunk
pitches forward.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.arrays import FloatArray
from retime.formats.registry import write
from retime.motion import rotation
from retime.motion.kinematics import GlobalPoses, global_poses
from retime.motion.motion import Declaration, Motion
from retime.motion.skeleton import EndSite, Skeleton

SHIPPED = Path(__file__).resolve().parents[1] / "src" / "retime" / "data" / "sample.bvh"

RATE = 60
FINE = 4  # working frames a frame of the clip
ROUNDS = 16
GRAVITY = 981.0
N_FRAMES = 816

# The body: 175 cm, segment lengths near the usual fractions of stature (Drillis and Contini). The rest pose stands
# upright with the arms hanging: joints are near zero most of the time, and Y, the middle angle, far from 90 degrees.
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
    *(
        (f"{side}{joint}", mass, centre)
        for side in ("Left", "Right")
        for joint, mass, centre in (
            ("Arm", 2.71, (0.0, -16.7, 0.0)),
            ("ForeArm", 1.62, (0.0, -11.7, 0.0)),
            ("Hand", 0.61, (0.0, -6.8, 0.0)),
            ("UpLeg", 14.16, (0.0, -17.4, 0.0)),
            ("Leg", 4.33, (0.0, -18.5, 0.0)),
            ("Foot", 1.37, (0.0, -5.0, 5.6)),
        )
    ),
)
WHOLE = sum(mass for _, mass, _ in MASSES)
# What the legs and soles reach with; places from the ankle, in the foot's space.
ANKLE = 8.0
THIGH, SHANK = 42.5, 41.5
HIP = np.array([9.0, -5.0, 0.0])
HEEL = np.array([0.0, -ANKLE, -5.5])
BALL = np.array([0.0, -6.0, 13.0])
SIDES = ("Left", "Right")
OUTWARD = (1.0, -1.0)  # along X

UPPER = sum(mass for name, mass, _ in MASSES if not name.endswith(("Leg", "Foot")))
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


# Curves -------------------------------------------------------------------------------------------------------------

TIMES = np.arange((N_FRAMES - 1) * FINE + 1) / (RATE * FINE)
Knot = tuple[float, ...]  # time, value, and as far as given: rate, acceleration
AFTER: Knot = (float(TIMES[-1]) + 1.0, 0.0)


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
    return np.asarray(np.sin(TIMES[:, None] * speed + phase) @ np.array([0.5, 0.35, 0.2]))


# The feet -----------------------------------------------------------------------------------------------------------


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


# The centre of mass -------------------------------------------------------------------------------------------------


def sum_of(poses: GlobalPoses, masses: Sequence[tuple[str, float, tuple[float, float, float]]]) -> FloatArray:
    """Return the sum of mass times place of some segments, shape (n, 3)."""
    total = np.zeros((len(poses.positions), 3))
    for name, mass, centre in masses:
        joint = NAMES.index(name)
        total += mass * (poses.positions[:, joint] + rotation.rotate(poses.rotations[:, joint], np.array(centre)))
    return total


def mass_centre(motion: Motion) -> FloatArray:
    """Return the whole body's centre of mass, shape (n, 3)."""
    return sum_of(global_poses(motion), MASSES) / WHOLE


def upper_mass(angles: dict[str, FloatArray]) -> FloatArray:
    """Return the sum of mass times place, from the root, of all that is not legs, shape (n, 3)."""
    poses = global_poses(motion_of(np.zeros((len(TIMES), 3)), angles))
    return sum_of(poses, [row for row in MASSES if not row[0].endswith(("Leg", "Foot"))])


def standing_height() -> float:
    """Return the centre of mass's height in quiet standing: the rest pose, knees a little soft."""
    rest = Motion(SKELETON, rotation.identity(1, len(NAMES)))
    return float(mass_centre(rest)[0, 1]) - 0.3


def leaps(ends: Sequence[tuple[float, float]], ride: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the height that jumps ask of the centre of mass, its acceleration, and where they have the say, 0 to 1.

    Dip, push, parabola, landing: quintic pieces that share rate and acceleration at their joints, so that the force on
    the ground never leaps, and is 0 at take-off and touchdown.
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
        say += quintic([(jump.dip, 0.0), (jump.dip + 0.35, 1.0), (jump.stand - 0.4, 1.0), (jump.stand, 0.0)], TIMES)
    return quintic(knots, TIMES), quintic(knots, TIMES, order=2), say


def knee_plan() -> tuple[FloatArray, FloatArray]:
    """Return how far each knee should bend while standing and walking, and how much that matters, both (n, 2).

    The pattern of gait: nearly straight at contact, a give under the load, straighter as the body passes over, bending
    before the foot leaves. What the leg behind does is left to its heel (`push_off`), the swing to the foot's path.
    """
    plan, matter = np.empty((len(TIMES), 2)), np.empty((len(TIMES), 2))
    for side in (0, 1):
        bend: list[tuple[float, float]] = [(-1.0, SOFT_KNEE)]
        weight: list[tuple[float, float]] = [(-1.0, 1.0)]
        for walk in WALKS:
            for i, step in enumerate(walk):
                if step.side != side:
                    continue
                from_rest, to_rest = i < 2, i >= len(walk) - 2
                contact, loaded = step.landing_knee
                bend += [(step.lift - (0.3 if from_rest else 0.16), 10.0 if from_rest else 15.0), (step.lift, 36.0)]
                bend += [(step.strike - 0.08, contact + 4.0), (step.strike, contact), (step.strike + 0.12, loaded)]
                bend += [(step.strike + 0.34, 10.0 if to_rest else 13.0)]
                if to_rest:
                    bend.append((step.strike + 0.7, SOFT_KNEE))
                weight += [(step.lift - 0.27, 1.0), (step.lift - 0.16, 0.02)]
                weight += [(step.strike - 0.13, 0.02), (step.strike - 0.05, 1.0)]
        plan[:, side] = flow([*bend, (AFTER[0], SOFT_KNEE)], 0.02)
        matter[:, side] = flow([*weight, (AFTER[0], 1.0)], 0.02)
    return plan, matter


def solve_banded(bands: FloatArray, known: FloatArray) -> FloatArray:
    """Solve a symmetric positive definite system; ``bands[d, i]`` is the entry at row i, column i + d."""
    rows, values = bands.T.tolist(), known.tolist()
    n, width = len(rows), len(bands)
    for i, row in enumerate(rows):
        for d in range(1, min(width, n - i)):
            factor = row[d] / row[0]
            for e in range(d, width):
                rows[i + d][e - d] -= factor * row[e]
            values[i + d] -= factor * values[i]
    for i in range(n - 1, -1, -1):
        values[i] /= rows[i][0]
        values[i] -= sum(rows[i][d] / rows[i][0] * values[i + d] for d in range(1, min(width, n - i)))
    return np.array(values)


def splined(values: FloatArray, weights: FloatArray, stiffness: float) -> FloatArray:
    """Fit a cubic spline (knots a thirtieth of a second apart) to weighted values, its bending held down."""
    s = np.arange(len(TIMES)) * 30 / (RATE * FINE)
    k = s.astype(np.intp)
    u = s - k
    # The four uniform cubic B-splines that are not zero at a time.
    basis = np.stack([(1 - u) ** 3, 3 * u**3 - 6 * u**2 + 4, 3 * (u + u**2 - u**3) + 1, u**3]) / 6
    n = int(k[-1]) + 4
    bands, known = np.zeros((4, n)), np.zeros(n)
    for a in range(4):
        known += np.bincount(k + a, weights * values * basis[a], n)
        for b in range(a, 4):
            bands[b - a] += np.bincount(k + a, weights * basis[a] * basis[b], n)
    # Each second difference (1, -2, 1), squared.
    for band, at, product in ((0, 0, 1), (0, 1, 4), (0, 2, 1), (1, 0, -2), (1, 1, -2), (2, 0, 1)):
        bands[band, at : n - 2 + at] += stiffness * product
    fitted = solve_banded(bands, known)
    return np.asarray(np.sum([basis[a] * fitted[k + a] for a in range(4)], axis=0))


def pressure() -> FloatArray:
    """Return the centre of pressure on the ground, x and z, (n, 2): under the foot that stands, or between both."""
    places = [np.array([x, z]) for x, z, _ in START]
    keys: list[tuple[float, float, float]] = []

    def between(t: float, forward: float, share: float = 0.5) -> None:
        x, z = (1 - share) * places[0] + share * places[1]
        keys.append((t, float(x), float(z) + forward))

    def under(t: float, side: int, forward: float) -> None:
        keys.append((t, float(places[side][0]) - 0.5 * OUTWARD[side], float(places[side][1]) + forward))

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
        still = walk[-1].strike + 0.25
        if still < jump.dip - 1.0:
            between(still, 4.5)
            # The pause: rest on the right leg, then on both again.
            between(still + 0.35, 4.0, 0.68)
            between(jump.dip - 0.35, 5.0, 0.60)
        between(max(jump.dip, still), 4.5)
        between(jump.bottom - 0.05, 1.0)
        between(jump.takeoff - 0.12, 12.0)
        between(jump.takeoff, 16.0)
        for side in (0, 1):
            places[side] = places[side] + [LANDING[side][0], jump.length + LANDING[side][1]]
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

    The force points from the pressure p through the mass at x: ``x'' y = (y'' + g) (x - p)``. In flight y'' = -g, and
    x'' = 0 by itself. Solved from a start it would topple; so both ends are tied to p, in one tridiagonal system.
    """
    # Second differences: -x[i-1] + (2 + k) x[i] - x[i+1] = k p[i].
    k = (y_acceleration + GRAVITY) / y / (RATE * FINE) ** 2
    k[np.abs(y_acceleration + GRAVITY) < 1e-6] = 0.0
    k = k[1:-1]
    bands = np.stack([2.0 + k, np.full_like(k, -1.0)])
    x = centre.copy()
    for axis in (0, 1):
        known = k * centre[1:-1, axis]
        known[0] += centre[0, axis]
        known[-1] += centre[-1, axis]
        x[1:-1, axis] = solve_banded(bands, known)
    return x


# Trunk, head and arms -----------------------------------------------------------------------------------------------


def over_jumps(*keys: tuple[str, float, float], rest: float = 0.0, scaled: bool = False) -> list[tuple[float, float]]:
    """Lay keys (event, seconds after it, value) over both jumps, `rest` outside; `scaled`: by how high the arms go."""
    result = [(-1.0, rest)]
    for jump in JUMPS:
        for event, after, value in keys:
            t = getattr(jump, event) + after
            result.append((t, value * (jump.arms / 110 if scaled and value > 0 else 1.0)))
    return [*result, (AFTER[0], rest)]


def shared(angles: dict[str, FloatArray], axis: int, total: FloatArray, shares: dict[str, float]) -> None:
    """Spread an angle over a chain of joints; `axis` 0 is Z, 1 is Y, 2 is X."""
    for name, share in shares.items():
        angles[name][:, axis] += share * total


TRUNK = {"Spine": 0.4, "Spine1": 0.35, "Chest": 0.25}
NECK = {"Neck": 0.45, "Head": 0.55}


@dataclass(frozen=True)
class Gait:
    """What trunk and arms answer, over the whole clip."""

    stride: FloatArray  # 1 with the left foot a full step ahead, -1 with the right
    late: FloatArray  # the same, as the upper body follows it
    walking: FloatArray  # 1 at full speed, 0 at rest and in a jump
    push: FloatArray  # forward acceleration, outside of jumps
    carries: FloatArray  # 1 where the right leg bears all, -1 the left
    breath: FloatArray


def read_gait(feet: tuple[Foot, Foot], centre: FloatArray, ground: FloatArray) -> Gait:
    """Read off the feet, the centre of pressure and the path of the centre of mass how the figure walks."""
    stride = soften((feet[0].ankle[:, 2] - feet[1].ankle[:, 2]) / 65, 0.045)
    lag = int(0.045 * RATE * FINE)
    late = np.concatenate([np.full(lag, stride[0]), stride[:-lag]])
    jumping = np.zeros(len(TIMES), dtype=bool)
    for jump in JUMPS:
        jumping |= (jump.dip < TIMES) & (jump.stand > TIMES)
    speed = np.gradient(ground[:, 1], TIMES) / 120
    push = np.where(jumping, 0.0, soften(np.gradient(speed, TIMES), 0.08))
    walking = soften(np.where(jumping, 0.0, np.clip(speed, 0.0, 1.0)), 0.1)
    left, right = feet[0].ankle[:, 0], feet[1].ankle[:, 0]
    carries = soften(np.clip(2 * (centre[:, 0] - left) / (right - left) - 1, -1.2, 1.2), 0.05)
    return Gait(stride, late, walking, push, carries, np.sin(2 * np.pi * 0.28 * TIMES + 0.6))


def carriage(gait: Gait) -> dict[str, FloatArray]:
    """Return the Euler angles (Z, Y, X) of the root and of every joint above the legs; the legs' are 0."""
    angles = {name: np.zeros((len(TIMES), 3)) for name in NAMES}
    hold_trunk(gait, angles)
    for side in (0, 1):
        swing_arm(side, gait, angles)
    return angles


def hold_trunk(gait: Gait, angles: dict[str, FloatArray]) -> None:
    """Fill in pelvis, spine, neck and head: each level's turn in the world, spread over the joints below it."""
    walking, quiet, carries = gait.walking, 1 - gait.walking, gait.carries
    pelvis_pitch = flow(
        over_jumps(
            ("dip", 0, 0),
            ("bottom", 0, 33),
            ("takeoff", -0.02, 2),
            ("middle", 0, 3),
            ("touchdown", 0, 8),
            ("absorbed", 0.02, 24),
            ("stand", 0, 0),
            rest=0.0,
        )
    )
    trunk_pitch = flow(
        over_jumps(
            ("dip", 0, 1),
            ("bottom", -0.02, 57),
            ("takeoff", 0, 8),
            ("middle", 0, 12),
            ("touchdown", 0, 20),
            ("absorbed", 0.05, 38),
            ("stand", 0.05, 1),
            rest=1.0,
        )
    )
    gaze_pitch = flow(
        over_jumps(
            ("dip", 0, 4),
            ("bottom", -0.1, 14),
            ("takeoff", 0.02, -4),
            ("middle", 0, 10),
            ("touchdown", 0, 16),
            ("absorbed", 0.05, 15),
            ("stand", 0.1, 3),
            rest=3.0,
        ),
        0.05,
    )
    pelvis_pitch += 2.0 * walking + 0.6 * wander(3) * quiet
    trunk_pitch += 1.0 + 2.5 * walking + 1.5 * gait.push + 0.5 * wander(4)
    trunk_pitch = soften(trunk_pitch, 0.03)
    gaze_pitch += 1.2 * wander(5) + 3.0 * walking

    pelvis_yaw = -5.5 * gait.stride + 1.0 * wander(6) * quiet
    chest_yaw = 5.0 * gait.late + 1.2 * wander(7) * quiet
    pause, resume = WALKS[0][-1].strike, WALKS[1][0].lift
    first, second = JUMPS
    look = flow(
        [
            *((-1.0, 0.0), (0.0, 2.0), (0.7, -3.0), (1.3, 0.0), (pause - 0.1, 0.0), (pause + 0.35, 30.0)),
            *((pause + 0.62, 32.0), (pause + 1.05, -26.0), (pause + 1.25, -27.0), (first.dip + 0.1, 0.0)),
            *(
                (first.stand - 0.2, 0.0),
                (first.stand + 0.25, -14.0),
                (resume + 0.2, -1.0),
                (second.touchdown + 0.5, 0.0),
            ),
            *((second.stand + 0.05, 12.0), (second.stand + 0.5, 14.0), (AFTER[0], 2.0)),
        ],
        0.05,
    )
    chest_yaw += 0.16 * soften(look, 0.1)
    head_yaw = look + 0.3 * chest_yaw + 1.5 * wander(8)

    # The hip of the swinging leg drops; a resting one drops more slowly and further.
    pelvis_roll = carries * (-3.8 * walking - 2.6 * quiet)
    chest_roll = -carries * (1.6 * walking) + carries * 0.9 * quiet + 0.4 * wander(9)
    head_roll = 0.4 * chest_roll + 1.0 * wander(10)

    angles["Hips"][:] = np.stack([pelvis_roll, pelvis_yaw, pelvis_pitch], axis=-1)
    for axis, lower, upper, top in (
        (0, pelvis_roll, chest_roll, head_roll),
        (1, pelvis_yaw, chest_yaw, head_yaw),
        (2, pelvis_pitch, trunk_pitch, gaze_pitch),
    ):
        shared(angles, axis, upper - lower, TRUNK)
        shared(angles, axis, top - upper, NECK)
    angles["Chest"][:, 2] -= 0.7 * gait.breath
    angles["Neck"][:, 2] += 0.7 * gait.breath


def swing_arm(side: int, gait: Gait, angles: dict[str, FloatArray]) -> None:
    """Fill in an arm, with its shoulder: it swings with the other leg, and helps in a jump."""
    name, out, walking = SIDES[side], OUTWARD[side], gait.walking
    lag = 0.012 * (1 - 2 * side)
    swing = gait.late * (1 if side else -1)  # forward with the other foot
    reach = flow(
        over_jumps(
            ("dip", 0.0, 0),
            ("bottom", -0.18 + lag, -52),
            ("bottom", -0.03 + lag, -38),
            ("takeoff", 0.02 + lag, 95),
            ("middle", -0.06, 110),
            ("touchdown", lag, 62),
            ("absorbed", 0.04 + lag, 56),
            ("stand", -0.15 + lag, -5),
            ("stand", 0.25, 0),
            scaled=True,
        ),
        0.035,
    )
    bend = flow(
        over_jumps(
            ("dip", 0.0, 0),
            ("bottom", -0.12 + lag, 6),
            ("bottom", 0.08 + lag, 30),
            ("takeoff", -0.03 + lag, 52),
            ("middle", 0, 32),
            ("touchdown", lag, 26),
            ("absorbed", 0.02, 42),
            ("stand", -0.1, 6),
            ("stand", 0.25, 0),
        ),
        0.035,
    )
    spread = flow(
        over_jumps(
            ("dip", 0, 0),
            ("bottom", -0.1, 7),
            ("takeoff", 0, 4),
            ("middle", 0, 14),
            ("touchdown", 0, 16),
            ("absorbed", 0.05, 14),
            ("stand", 0, 0),
        ),
        0.05,
    )
    flex = reach + (17.0 + 2 * side) * swing * np.clip(walking * 1.3, 0, 1) - 2.0 * walking + 1.2 * wander(11 + side)
    elbow = 13 + 2 * side + bend + walking * (8 + 9 * swing) + 1.5 * wander(13 + side)
    raised = np.clip(reach / 90, 0.0, 1.2)
    # The shoulder girdle goes along with an arm that rises or swings.
    angles[f"{name}Shoulder"][:, 0] = out * (0.12 * np.maximum(reach, 0) + 0.8 * gait.breath)
    angles[f"{name}Shoulder"][:, 1] = -out * (0.10 * flex)
    angles[f"{name}Arm"][:] = np.stack(
        [
            out * ((7.5 + spread) * (1 - 0.8 * raised) - 0.12 * np.maximum(reach, 0) + 0.7 * wander(15 + side)),
            -out * (14 - 36 * raised),
            -flex,
        ],
        axis=-1,
    )
    angles[f"{name}ForeArm"][:, 2] = -elbow
    angles[f"{name}ForeArm"][:, 1] = -out * (7 + 0.04 * bend) * (1 - 0.8 * raised)
    angles[f"{name}Hand"][:, 2] = -6 - 0.15 * elbow + 2 * wander(17 + side)
    angles[f"{name}Hand"][:, 0] = -out * 3.0


# Legs and root ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Leg:
    """One leg reaching from its hip to its ankle, over the whole clip."""

    down: FloatArray  # hip to ankle, (n, 3)
    knee: FloatArray  # its bend
    thigh: FloatArray  # rotation, (n, 4)
    shank: FloatArray
    sole: FloatArray
    mass: FloatArray  # sum of mass times place, (n, 3)


def reach_for(side: int, foot: Foot, root: FloatArray, hips: FloatArray) -> Leg:
    """Bend a leg so that it joins the pelvis to the ankle; a leg that is too short points at it, straight."""
    hip = root + rotation.rotate(hips, HIP * [OUTWARD[side], 1, 1])
    down = foot.ankle - hip
    distance = np.sqrt(np.sum(down**2, axis=-1))
    toward = down / distance[:, None]
    length = np.minimum(distance, THIGH + SHANK - 1e-9)
    knee = np.pi - np.arccos(np.clip((THIGH**2 + SHANK**2 - length**2) / (2 * THIGH * SHANK), -1, 1))
    at_hip = np.arccos(np.clip((THIGH**2 + length**2 - SHANK**2) / (2 * THIGH * length), -1, 1))
    # The knee points where the toes point, a little less outward.
    ahead = np.radians(0.8 * foot.yaw)
    forward = np.stack([np.sin(ahead), np.zeros_like(ahead), np.cos(ahead)], axis=-1)
    across = np.cross(-toward, forward)
    across /= np.sqrt(np.sum(across**2, axis=-1, keepdims=True))
    front = np.cross(across, -toward)
    up = -(np.cos(at_hip)[:, None] * toward + np.sin(at_hip)[:, None] * front)
    thigh = from_axes(across, up, np.cross(across, up))
    shank = rotation.multiply(thigh, rotation.about_axis(0, knee))
    sole = turned(foot.yaw, foot.pitch)
    origin = {"UpLeg": hip, "Leg": hip - THIGH * up, "Foot": foot.ankle}
    turn = {"UpLeg": thigh, "Leg": shank, "Foot": sole}
    mass = np.zeros_like(hip)
    for name, weight, centre in MASSES:
        joint = name.removeprefix(SIDES[side])
        if name != joint and joint in origin:
            mass += weight * (origin[joint] + rotation.rotate(turn[joint], np.array(centre)))
    return Leg(down, np.degrees(knee), thigh, shank, sole, mass)


def pose_leg(side: int, leg: Leg, foot: Foot, hips: FloatArray, angles: dict[str, FloatArray]) -> None:
    """Fill in the angles of a leg."""
    name = SIDES[side]
    angles[f"{name}UpLeg"] = euler(rotation.multiply(rotation.conjugate(hips), leg.thigh))
    angles[f"{name}Leg"][:, 2] = leg.knee
    angles[f"{name}Foot"] = euler(rotation.multiply(rotation.conjugate(leg.shank), leg.sole))
    angles[f"{name}ToeBase"][:, 2] = -foot.toes


def leg_length(knee: FloatArray | float) -> FloatArray:
    """Return the distance from hip to ankle at a knee angle."""
    return np.asarray(np.sqrt(THIGH**2 + SHANK**2 + 2 * THIGH * SHANK * np.cos(np.radians(knee))))


def from_axes(x: FloatArray, y: FloatArray, z: FloatArray) -> FloatArray:
    """Return the rotations whose axes are x, y, z; none turns by as much as half a turn here."""
    w = 0.5 * np.sqrt(np.maximum(1 + x[:, 0] + y[:, 1] + z[:, 2], 1e-12))
    return rotation.normalize(
        np.stack(
            [w, (y[:, 2] - z[:, 1]) / (4 * w), (z[:, 0] - x[:, 2]) / (4 * w), (x[:, 1] - y[:, 0]) / (4 * w)], axis=-1
        )
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
    """Turn the body in flight so that its angular momentum about the side axis stays put: legs forward, trunk forward.

    The turn starts and ends at rest, where feet are on the ground; the momentum is the one that makes it end at 0.
    """
    momentum, inertia = spin(angles)
    for jump in JUMPS:
        window = quintic(
            [(jump.takeoff, 0.0), (jump.takeoff + 0.06, 1.0), (jump.touchdown - 0.06, 1.0), (jump.touchdown, 0.0)],
            TIMES,
        )
        share = window / inertia
        level = (share * momentum).sum() / share.sum()
        rate = share * (level - momentum)
        turn = np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2)]) / (RATE * FINE)
        angles["Hips"][:, 2] += np.degrees(turn)


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
    fine, angles = solve()
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
