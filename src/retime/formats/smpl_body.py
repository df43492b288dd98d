"""The joints of SMPL bodies, and a stated approximate skeleton.

Files of such bodies hold no lengths of bones: those come from a model that has a licence of its own. What the search
looks at needs some, and little depends on them; these are rounded lengths of an adult of about 1.7 m, measured nowhere,
the same on both sides. Rest pose: arms out, X to the left, Y up, Z forward, in metres.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.motion.skeleton import EndSite, Skeleton

# Name, parent, offset from it: of the left side and the middle. The right side mirrors the left one.
_MIDDLE_AND_LEFT = (
    ("pelvis", "", (0.0, 0.0, 0.0)),
    ("left_hip", "pelvis", (0.07, -0.09, -0.01)),
    ("right_hip", "pelvis", (-0.07, -0.09, -0.01)),
    ("spine1", "pelvis", (0.0, 0.11, -0.02)),
    ("left_knee", "left_hip", (0.03, -0.39, 0.0)),
    ("right_knee", "right_hip", (-0.03, -0.39, 0.0)),
    ("spine2", "spine1", (0.0, 0.13, 0.0)),
    ("left_ankle", "left_knee", (-0.01, -0.41, -0.03)),
    ("right_ankle", "right_knee", (0.01, -0.41, -0.03)),
    ("spine3", "spine2", (0.0, 0.06, 0.02)),
    ("left_foot", "left_ankle", (0.03, -0.06, 0.12)),
    ("right_foot", "right_ankle", (-0.03, -0.06, 0.12)),
    ("neck", "spine3", (0.0, 0.21, -0.03)),
    ("left_collar", "spine3", (0.08, 0.12, -0.02)),
    ("right_collar", "spine3", (-0.08, 0.12, -0.02)),
    ("head", "neck", (0.0, 0.08, 0.05)),
    ("left_shoulder", "left_collar", (0.1, 0.03, -0.01)),
    ("right_shoulder", "right_collar", (-0.1, 0.03, -0.01)),
    ("left_elbow", "left_shoulder", (0.26, -0.01, -0.02)),
    ("right_elbow", "right_shoulder", (-0.26, -0.01, -0.02)),
    ("left_wrist", "left_elbow", (0.25, 0.01, 0.0)),
    ("right_wrist", "right_elbow", (-0.25, 0.01, 0.0)),
)
_HANDS = (("left_hand", "left_wrist", (0.08, -0.01, -0.01)), ("right_hand", "right_wrist", (-0.08, -0.01, -0.01)))
_FACE = (
    ("jaw", "head", (0.0, -0.01, 0.02)),
    ("left_eye_smplhf", "head", (0.03, 0.06, 0.06)),
    ("right_eye_smplhf", "head", (-0.03, 0.06, 0.06)),
)
# First joint of a finger from the wrist, and from each joint to the next one, on the left side.
_FINGERS = {
    "index": ((0.1, -0.005, 0.025), (0.03, 0.0, 0.0)),
    "middle": ((0.105, 0.0, 0.0), (0.03, 0.0, 0.0)),
    "pinky": ((0.08, -0.015, -0.045), (0.02, 0.0, -0.005)),
    "ring": ((0.095, -0.005, -0.025), (0.03, 0.0, -0.005)),
    "thumb": ((0.03, -0.015, 0.03), (0.025, -0.005, 0.025)),
}
_ENDS = {
    "head": (0.0, 0.17, 0.0),
    "left_foot": (0.0, 0.0, 0.07),
    "right_foot": (0.0, 0.0, 0.07),
    "left_hand": (0.08, 0.0, 0.0),
    "right_hand": (-0.08, 0.0, 0.0),
}


@dataclass(frozen=True)
class Body:
    """A kind of body.

    Attributes
    ----------
    title : str
        What it is called.
    skeleton : Skeleton
        Its joints, as they follow one another in ``poses``.
    """

    title: str
    skeleton: Skeleton


def _fingers(side: str) -> list[tuple[str, str, tuple[float, float, float]]]:
    sign = 1.0 if side == "left" else -1.0
    found = []
    for finger, (first, step) in _FINGERS.items():
        parent = f"{side}_wrist"
        for number, (x, y, z) in enumerate((first, step, step), start=1):
            name = f"{side}_{finger}{number}"
            found.append((name, parent, (sign * x, y, z)))
            parent = name
    return found


def _body(title: str, *more: tuple[str, str, tuple[float, float, float]]) -> Body:
    joints = (*_MIDDLE_AND_LEFT, *more)
    names = [name for name, _, _ in joints]
    parents = [names.index(parent) if parent else -1 for _, parent, _ in joints]
    ends = {**_ENDS}
    for name in names:
        if name.endswith("3") and "spine" not in name:
            x, y, z = _FINGERS[name.split("_")[1][:-1]][1]
            ends[name] = (x if name.startswith("left") else -x, y, z)
    leaves = set(range(len(names))) - set(parents)
    sites = [EndSite(place, ends[name]) for place, name in enumerate(names) if place in leaves and name in ends]
    if "jaw" in names:
        sites.append(EndSite(names.index("head"), _ENDS["head"]))
    offsets = np.array([offset for _, _, offset in joints])
    return Body(title, Skeleton(tuple(names), tuple(parents), offsets, tuple(sites)))


BODIES = {
    body.skeleton.n_joints: body
    for body in (
        _body("SMPL without hands"),
        _body("SMPL", *_HANDS),
        _body("SMPL+H", *_fingers("left"), *_fingers("right")),
        _body("SMPL-X", *_FACE, *_fingers("left"), *_fingers("right")),
    )
}
"""Kinds of bodies by how many joints they have: 22, 24, 52 and 55."""
