"""The centre of mass: its height, and its path over the ground."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from retime.arrays import FloatArray
from retime.motion import rotation
from retime.motion.kinematics import GlobalPoses, global_poses
from retime.motion.motion import Motion
from sample_clip.body import MASSES, NAMES, OUTWARD, SKELETON, WHOLE
from sample_clip.curves import AFTER, Knot, flow, quintic, soften, wander
from sample_clip.plan import FINE, GRAVITY, JUMPS, LANDING, RATE, SOFT_KNEE, START, TIMES, WALKS


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


def motion_of(root: FloatArray, angles: dict[str, FloatArray]) -> Motion:
    """Assemble a motion at the working rate."""
    local = rotation.from_euler("ZYX", np.radians(np.stack([angles[name] for name in NAMES], axis=1)))
    translations = np.array(np.broadcast_to(SKELETON.offsets, (len(root), len(NAMES), 3)))
    translations[:, 0] = root
    return Motion(SKELETON, local, translations, rate=Fraction(RATE * FINE))
