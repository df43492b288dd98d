"""Motion whose flights are known: a jointed figure that stands, jumps, hops, runs and leaps by a plan.

Its centre of mass falls freely while nothing touches the ground, exactly so; its joints' mean does not, since light
limbs swing and tuck. Feet push off over the toes, and leave the ground when the plan says it.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.skeleton import Skeleton

GRAVITY = 9.81
# Metres, of a person of 1.7 m. The centre of mass when standing; from the ball of the foot to the ankle, ahead and up.
_STANDING = 0.95
_BALL_UP = 0.02
_ANKLE = (-0.14, 0.06)
# Joints above the hips: name, parent, place against the hips, share of the body's mass. Y up, facing Z.
_UPPER = (
    ("Hips", "", (0.0, 0.0, 0.0), 0.20),
    ("Spine", "Hips", (0.0, 0.15, 0.0), 0.15),
    ("Chest", "Spine", (0.0, 0.35, 0.0), 0.17),
    ("Head", "Chest", (0.0, 0.65, 0.0), 0.08),
    ("LeftArm", "Chest", (0.2, 0.45, 0.0), 0.027),
    ("RightArm", "Chest", (-0.2, 0.45, 0.0), 0.027),
)
_HAND_MASS, _KNEE_MASS, _FOOT_MASS, _TOE_MASS = 0.023, 0.13, 0.012, 0.008


@dataclass(frozen=True)
class Phase:
    """A piece of a plan.

    Attributes
    ----------
    seconds : float
        How long it lasts.
    on : str
        Which feet stand: "both", "left", "right"; "" is a flight.
    ground : float
        Height of what they stand on, metres, for a person of 1.7 m.
    """

    seconds: float
    on: str
    ground: float = 0.0


def jumps(*seconds: float, ground: Sequence[float] = ()) -> list[Phase]:
    """Jump from standing to standing with both feet, each flight so long; `ground` is where each lands."""
    plan = [Phase(1.0, "both")]
    for i, one in enumerate(seconds):
        plan += [Phase(one, ""), Phase(1.0, "both", ground[i] if ground else 0.0)]
    return plan


def hops(flight: float, n: int = 6) -> list[Phase]:
    """Hop on the left foot."""
    return [Phase(0.8, "left"), *[Phase(flight, ""), Phase(0.3, "left")] * n, Phase(0.6, "left")]


def run(stance: float, flight: float, n: int = 12) -> list[Phase]:
    """Run: one foot after the other."""
    return [phase for i in range(n) for phase in (Phase(stance, ("left", "right")[i % 2]), Phase(flight, ""))][:-1]


def run_and_leap(stance: float = 0.2, flight: float = 0.12, leap: float = 0.45) -> list[Phase]:
    """Run, leap, run on."""
    return [*run(stance, flight, 6), Phase(leap, ""), *run(stance, flight, 6)]


def _hermite(share: np.ndarray, seconds: float, start: float, speed: float, end: float, leaving: float) -> np.ndarray:
    s = share
    return np.asarray(
        (2 * s**3 - 3 * s**2 + 1) * start
        + (s**3 - 2 * s**2 + s) * seconds * speed
        + (3 * s**2 - 2 * s**3) * end
        + (s**3 - s**2) * seconds * leaving
    )


def _mass_height(plan: Sequence[Phase], times: np.ndarray, size: float) -> np.ndarray:
    """Height of the centre of mass: a parabola in each flight, smooth between them."""
    starts = np.concatenate([[0.0], np.cumsum([phase.seconds for phase in plan])])
    height = np.empty(len(times))
    rests = [size * (phase.ground + _STANDING) for phase in plan]
    flights = {i for i, phase in enumerate(plan) if not phase.on}
    # How fast it leaves the ground, and how fast it comes back.
    leave, come = {}, {}
    for i in flights:
        rise = (rests[i + 1] - rests[i - 1]) / plan[i].seconds
        leave[i], come[i] = rise + GRAVITY * plan[i].seconds / 2, rise - GRAVITY * plan[i].seconds / 2
    for i, phase in enumerate(plan):
        inside = (times >= starts[i]) & (times <= starts[i + 1] + 1e-9)
        t, total = times[inside] - starts[i], phase.seconds
        if i in flights:
            height[inside] = rests[i - 1] + leave[i] * t - GRAVITY / 2 * t * t
            continue
        speed, leaving = come.get(i - 1, 0.0), leave.get(i + 1, 0.0)
        # Nobody crouches for longer than half a second before a jump, or after it.
        part = min(0.5, total / 2) if total > 0.6 else total
        if part == total:
            height[inside] = _hermite(t / total, total, rests[i], speed, rests[i], leaving)
        else:
            landing = _hermite(np.minimum(t / part, 1), part, rests[i], speed, rests[i], 0.0)
            pushing = _hermite(np.maximum((t - total + part) / part, 0), part, rests[i], 0.0, rests[i], leaving)
            height[inside] = landing + pushing - rests[i]
    return height


def _stances(plan: Sequence[Phase], side: str) -> list[tuple[float, float, float]]:
    """When a foot stands, and how high: start, end, ground."""
    found: list[tuple[float, float, float]] = []
    end = 0.0
    for phase in plan:
        start, end = end, end + phase.seconds
        if phase.on in ("both", side):
            if found and start - found[-1][1] < 1e-9 and phase.ground == found[-1][2]:
                start = found.pop()[0]
            found.append((start, end, phase.ground))
    return found


def _foot(
    plan: Sequence[Phase], side: str, times: np.ndarray, speed: float, size: float, lift: float
) -> tuple[np.ndarray, np.ndarray]:
    """Path of the ball of a foot, metres ahead and up, and how far its heel is up (0 to 1)."""
    stances = _stances(plan, side)
    total = sum(phase.seconds for phase in plan)
    # Where it does not stand yet, or no more, it hangs beside the other leg.
    path = np.stack([speed * times - 0.1 * size, 0 * times + 0.3 * size], axis=1)
    heel = np.zeros(len(times))
    for start, end, ground in stances:
        inside = (times >= start) & (times <= end)
        path[inside] = [speed * (start + end) / 2, size * (ground + _BALL_UP)]
        if end < total:
            heel[inside] = np.clip(1 - (end - times[inside]) / 0.12, 0, 1) ** 2
    for (a0, begin, from_ground), (stop, b1, to_ground) in itertools.pairwise(stances):
        inside = (times > begin) & (times < stop)
        t, seconds = times[inside] - begin, stop - begin
        s = t / seconds if seconds > 0 else t
        there = s * s * (3 - 2 * s)
        # In a jump with both feet, or a hop, it goes with the body, and tucks; in a run it swings.
        jumps = any(not phase.on and abs(phase.seconds - seconds) < 1e-9 for phase in plan)
        arc = GRAVITY / 2 * t * (seconds - t) if jumps else 0.0
        # A foot has been lifted by its heel before it leaves, and comes down before it stands: neither is from rest.
        lifted = lift * (np.sin(np.pi * s) ** 2 / 2 + 2 * s * (1 - s))
        up = size * (from_ground + (to_ground - from_ground) * there + _BALL_UP + lifted) + arc
        first, last = speed * (a0 + begin) / 2, speed * (stop + b1) / 2
        path[inside] = np.stack([first + (last - first) * there, up], axis=1)
        heel[inside] = np.maximum(1 - s * 2, 0) ** 2
    return path, heel


def leaper(
    plan: Sequence[Phase],
    *,
    rate: float = 120,
    size: float = 1.0,
    unit: float = 1.0,
    speed: float = 0.0,
    lift: float = 0.12,
    arms: float = 0.0,
    noise: float = 0.001,
    up: str = "y",
    toes: bool = True,
    slope: float = 0.0,
    seed: int = 0,
) -> tuple[Motion, np.ndarray]:
    """Make a figure that does what a plan says.

    Parameters
    ----------
    plan : sequence of Phase
        Between two flights there is ground, and at both ends.
    rate : float
        Frames a second.
    size : float
        1 is a person of 1.7 m.
    unit : float
        Metres.
    speed : float
        Metres a second, forward.
    lift : float
        Metres that feet are drawn up, beyond where the body takes them.
    arms : float
        Metres that hands swing up and down, once a second.
    noise : float
        Standard deviation of each coordinate of a joint, metres.
    up : str
        "y" or "z".
    toes : bool
        Whether feet have a joint at the ball.
    slope : float
        Metres that the ground rises a metre forward.
    seed : int
        Of the noise.

    Returns
    -------
    Motion
        Joints in global places, without rotations.
    bool array, shape (n_frames,)
        Whether it is in flight: between take-off and landing, both left out.
    """
    rng = np.random.default_rng(seed)
    total = sum(phase.seconds for phase in plan)
    times = np.arange(int(total * rate) + 1) / rate
    starts = np.concatenate([[0.0], np.cumsum([phase.seconds for phase in plan])])
    aloft = np.zeros(len(times), dtype=bool)
    for i, phase in enumerate(plan):
        if not phase.on:
            aloft |= (times > starts[i] + 1e-9) & (times < starts[i + 1] - 1e-9)
    mass = np.stack([0 * times, _mass_height(plan, times, size), speed * times], axis=1)
    names, parents = [row[0] for row in _UPPER], [row[1] for row in _UPPER]
    places = [np.broadcast_to(np.array(row[2]) * size, mass.shape) for row in _UPPER]
    weights = [row[3] for row in _UPPER]
    swing = size * arms * np.sin(2 * np.pi * times)
    for side, sign in (("Left", 1), ("Right", -1)):
        names.append(f"{side}Hand")
        parents.append(f"{side}Arm")
        places.append(np.stack([0 * times + 0.25 * sign * size, 0.0 * size + swing, 0 * times + 0.1 * size], axis=1))
        weights.append(_HAND_MASS)
    feet, knees = [], []
    for side, sign in (("left", 1), ("right", -1)):
        path, heel = _foot(plan, side, times, speed, size, lift)
        across = 0 * times + 0.1 * sign * size
        ball = np.stack([across, path[:, 1], path[:, 0]], axis=1)
        angle = np.radians(55) * heel
        ahead, above = (part * size for part in _ANKLE)
        ankle = ball + np.stack(
            [
                0 * times,
                above * np.cos(angle) - ahead * np.sin(angle),
                ahead * np.cos(angle) + above * np.sin(angle),
            ],
            axis=1,
        )
        feet.append((ankle, ball))
        knees.append(ankle / 2 + [0.05 * sign * size, 0.02 * size, 0.08 * size])
    # Where the hips are follows from where all of it together is.
    known = sum(w * p for w, p in zip(weights, places, strict=True)) + sum(_KNEE_MASS * knee for knee in knees)
    known = known + sum(_FOOT_MASS * ankle + _TOE_MASS * ball for ankle, ball in feet)
    share = sum(weights) + _KNEE_MASS
    everything = sum(weights) + 2 * (_KNEE_MASS + _FOOT_MASS + _TOE_MASS)
    hips = (mass * everything - known) / share
    columns = [hips + place for place in places]
    for side, knee, (ankle, ball) in zip(("Left", "Right"), knees, feet, strict=True):
        rows = [(f"{side}Leg", "Hips", knee + hips / 2), (f"{side}Foot", f"{side}Leg", ankle)]
        rows += [(f"{side}Toe", f"{side}Foot", ball)] if toes else []
        for name, parent, column in rows:
            names.append(name)
            parents.append(parent)
            columns.append(column)
    positions = np.stack(columns, axis=1)
    positions[:, :, 1] += slope * positions[:, :, 2]
    positions = (positions + rng.normal(0, noise, positions.shape)) / unit
    if up == "z":
        positions = np.stack([positions[..., 0], -positions[..., 2], positions[..., 1]], axis=-1)
    above_joints = [names.index(parent) if parent else -1 for parent in parents]
    local = positions.copy()
    for joint, parent in enumerate(above_joints):
        if parent >= 0:
            local[:, joint] = positions[:, joint] - positions[:, parent]
    skeleton = Skeleton(tuple(names), tuple(above_joints), local.mean(axis=0))
    turns = rotation.identity(len(times), len(names))
    motion = Motion(
        skeleton,
        turns,
        local,
        Fraction(rate).limit_denominator(1001),
        name="leaper",
        metres_per_unit=unit,
        up="z" if up == "z" else "y",
    )
    return motion, aloft
