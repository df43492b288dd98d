"""A jointed figure that is symmetric and walks evenly, and the same walk on skeletons made otherwise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.skeleton import Skeleton

# Name, parent, offset in metres. Y up, facing Z, so left is X.
_MIDDLE = [("Hips", "", (0, 0, 0)), ("Spine", "Hips", (0, 0.12, -0.02)), ("Chest", "Spine", (0, 0.25, 0.01))]
_MIDDLE += [("Neck", "Chest", (0, 0.2, 0)), ("Head", "Neck", (0, 0.1, 0.02))]
_LEFT = [
    ("UpLeg", "Hips", (0.1, -0.05, 0.01)),
    ("Leg", "UpLeg", (0.01, -0.42, 0.01)),
    ("Foot", "Leg", (0, -0.4, -0.02)),
]
_LEFT += [("Toe", "Foot", (0.02, -0.06, 0.14)), ("Shoulder", "Chest", (0.05, 0.15, 0.01))]
_LEFT += [("Arm", "Shoulder", (0.13, 0, 0)), ("ForeArm", "Arm", (0.28, 0, 0.01)), ("Hand", "ForeArm", (0.26, 0, 0))]

N_CYCLE = 40


def walker_skeleton() -> Skeleton:
    rows = list(_MIDDLE)
    for side, sign in (("Left", 1), ("Right", -1)):
        for name, parent, (x, y, z) in _LEFT:
            rows.append((side + name, parent if parent in ("Hips", "Chest") else side + parent, (sign * x, y, z)))
    names = tuple(name for name, _, _ in rows)
    parents = tuple(names.index(parent) if parent else -1 for _, parent, _ in rows)
    return Skeleton(names, parents, np.array([offset for _, _, offset in rows], dtype=float))


def walker(n_frames: int = 2 * N_CYCLE, heading: float = 0.0) -> Motion:
    """An even walk: what the left does, the right does half a cycle later, mirrored."""
    skeleton = walker_skeleton()
    phase = 2 * np.pi * np.arange(n_frames) / N_CYCLE
    q = rotation.identity(n_frames, skeleton.n_joints)

    def turn(name: str, order: str, *angles: np.ndarray | float) -> None:
        columns = [np.broadcast_to(angle, (n_frames,)) for angle in angles]
        q[:, skeleton.index(name)] = rotation.from_euler(order, np.stack(columns, axis=1))

    # Turns about Y and Z change sign in the mirror, those about X don't.
    turn("Spine", "YXZ", 0.1 * np.sin(phase), 0.05 + 0.02 * np.cos(2 * phase), 0.03 * np.sin(phase + 1))
    turn("Chest", "YXZ", -0.15 * np.sin(phase), 0.03, 0.02 * np.cos(phase))
    turn("Head", "YX", 0.05 * np.sin(phase), 0.1)
    for side, sign, at in (("Left", 1, phase), ("Right", -1, phase + np.pi)):
        turn(side + "UpLeg", "XYZ", -0.1 - 0.5 * np.sin(at), sign * 0.1, sign * 0.05 * np.cos(at))
        turn(side + "Leg", "X", 0.4 + 0.35 * np.cos(at))
        turn(side + "Foot", "XZ", -0.2 + 0.2 * np.sin(at + 1), sign * 0.1)
        turn(side + "Arm", "ZX", sign * -1.2, 0.4 * np.sin(at))
        turn(side + "ForeArm", "Y", sign * (-0.5 - 0.2 * np.sin(at)))
    sway = np.stack([0.02 * np.sin(phase), 0.9 + 0.02 * np.cos(2 * phase), 1.2 * np.arange(n_frames) / N_CYCLE], axis=1)
    about = rotation.about_axis(1, np.full(n_frames, heading))
    hips = rotation.from_euler("YXZ", np.stack([0.1 * np.sin(phase), 0.03 + 0 * phase, 0.04 * np.cos(phase)], axis=1))
    q[:, 0] = rotation.multiply(about, hips)
    translations = np.broadcast_to(skeleton.offsets, (n_frames, skeleton.n_joints, 3)).copy()
    translations[:, 0] = rotation.rotate(about, sway)
    return Motion(skeleton, q, translations, Fraction(30), name="walker", metres_per_unit=1.0)


def rebuilt(motion: Motion, names: Sequence[str], parents: Sequence[int], offsets: np.ndarray, **changes) -> Motion:
    return replace(motion, skeleton=Skeleton(tuple(names), tuple(parents), np.asarray(offsets)), **changes)


def scaled(motion: Motion, factor: float) -> Motion:
    """The same in a unit `factor` times as small."""
    skeleton = motion.skeleton
    return rebuilt(
        motion,
        skeleton.names,
        skeleton.parents,
        skeleton.offsets * factor,
        translations=motion.local_translations * factor,
        metres_per_unit=None if motion.metres_per_unit is None else motion.metres_per_unit / factor,
    )


def renamed(motion: Motion, names: Mapping[str, str]) -> Motion:
    skeleton = motion.skeleton
    again = tuple(names.get(name, name) for name in skeleton.names)
    return replace(motion, skeleton=replace(skeleton, names=again))


def permuted(motion: Motion, order: Sequence[int]) -> Motion:
    """The same joints in another order; end sites stay in theirs."""
    skeleton = motion.skeleton
    place = {joint: new for new, joint in enumerate(order)}
    again = Skeleton(
        tuple(skeleton.names[joint] for joint in order),
        tuple(place.get(skeleton.parents[joint], -1) for joint in order),
        skeleton.offsets[list(order)],
        tuple(replace(site, parent=place[site.parent]) for site in skeleton.end_sites),
    )
    return replace(
        motion,
        skeleton=again,
        rotations=motion.rotations[:, list(order)],
        translations=motion.local_translations[:, list(order)],
    )


def moved(motion: Motion, turn: np.ndarray, shift: np.ndarray) -> Motion:
    """The same elsewhere: everything turned about the origin, then shifted."""
    q, p = motion.rotations.copy(), motion.local_translations.copy()
    q[:, 0] = rotation.multiply(turn, q[:, 0])
    p[:, 0] = rotation.rotate(turn, p[:, 0]) + shift
    return replace(motion, rotations=q, translations=p)


def resting(motion: Motion, turns: Mapping[str, np.ndarray]) -> Motion:
    """The same movement on a skeleton that rests otherwise: each named joint's own axes turned, its children's too."""
    skeleton = motion.skeleton
    own = rotation.identity(skeleton.n_joints)
    for joint, name in enumerate(skeleton.names):
        own[joint] = turns.get(name, own[max(skeleton.parents[joint], 0)])
    before = [rotation.identity() if parent < 0 else own[parent] for parent in skeleton.parents]
    q, p = motion.rotations.copy(), motion.local_translations.copy()
    offsets = skeleton.offsets.copy()
    for joint in range(skeleton.n_joints):
        q[:, joint] = rotation.multiply(rotation.multiply(before[joint], q[:, joint]), rotation.conjugate(own[joint]))
        p[:, joint] = rotation.rotate(before[joint], p[:, joint])
        offsets[joint] = rotation.rotate(before[joint], offsets[joint])
    return rebuilt(motion, skeleton.names, skeleton.parents, offsets, rotations=q, translations=p)


def built(motion: Motion, factors: np.ndarray, height: float) -> Motion:
    """The same turns of the joints, in a body of other proportions; its root at `height` times the height."""
    skeleton = motion.skeleton
    p = motion.local_translations * factors[:, None]
    p[:, 0] = motion.local_translations[:, 0] * height
    return rebuilt(motion, skeleton.names, skeleton.parents, skeleton.offsets * factors[:, None], translations=p)
