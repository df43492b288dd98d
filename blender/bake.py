"""A key on every frame: values of many curves with new timing, averaged where they are sped up. bpy is not needed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from retime.arrays import BoolArray, FloatArray
from retime.brief import brief_repr
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.skeleton import Skeleton
from retime.warp.apply import apply_warp
from retime.warp.averaging import window_frames
from retime.warp.cutting import CurveSegments

from .timing import Timing

CurveName = tuple[str, int]
"""Data path and index of an F-curve."""

# Blender evaluates curves in single precision: smaller steps than this share of a curve's height are no jump.
_ROUNDING = 1e-6

ROTATIONS = {"QUATERNION": ("rotation_quaternion", 4), "AXIS_ANGLE": ("rotation_axis_angle", 4)}


@dataclass(frozen=True, eq=False)
class Channels:
    """Where a bone, or an object itself, keeps its place and its turn.

    Attributes
    ----------
    prefix : str
        Of the data paths: ``pose.bones["hips"].``, or nothing for an object.
    name : str
        Of the bone.
    parent : int
        The place of its parent in the list, -1 for none.
    rest : float array, shape (4, 4)
        At rest in its parent's space.
    mode : str
        ``QUATERNION``, ``AXIS_ANGLE``, or an order of Euler angles such as ``XYZ``.
    place, turn : float array, shape (3,) and (3,) or (4,)
        What holds where nothing is animated.
    """

    prefix: str
    name: str
    parent: int
    rest: FloatArray
    mode: str
    place: FloatArray
    turn: FloatArray

    __repr__ = brief_repr

    @property
    def turn_path(self) -> str:
        """Data path of its rotation."""
        return self.prefix + ROTATIONS.get(self.mode, ("rotation_euler", 3))[0]

    @property
    def n_turns(self) -> int:
        """Numbers that its rotation has."""
        return ROTATIONS.get(self.mode, ("rotation_euler", 3))[1]


def quaternions_of(mode: str, numbers: FloatArray) -> FloatArray:
    """Turn what Blender holds for a rotation into quaternions; shapes (..., 3 or 4) and (..., 4).

    Blender's order XYZ turns about X first: the product is Z Y X. The angles stand by their axes in any order.
    """
    numbers = np.asarray(numbers, dtype=np.float64)
    if mode == "QUATERNION":
        length = np.linalg.norm(numbers, axis=-1, keepdims=True)
        return np.where(length > 0, numbers / np.where(length > 0, length, 1.0), [1.0, 0.0, 0.0, 0.0])
    if mode == "AXIS_ANGLE":
        axis = numbers[..., 1:]
        length = np.linalg.norm(axis, axis=-1, keepdims=True)
        axis = np.where(length > 0, axis / np.where(length > 0, length, 1.0), [0.0, 1.0, 0.0])
        return rotation.from_rotation_vectors(axis * numbers[..., :1])
    order = mode[::-1]
    return rotation.from_euler(order, numbers[..., _axes(order)])


def numbers_of(mode: str, quaternions: FloatArray, near: FloatArray) -> FloatArray:
    """Turn quaternions into what Blender holds, as near as can be to other such numbers (those of the same frames)."""
    if mode == "QUATERNION":
        return np.where((quaternions * near).sum(axis=-1, keepdims=True) < 0, -quaternions, quaternions)
    if mode == "AXIS_ANGLE":
        old = quaternions_of(mode, near)
        q = np.where((quaternions * old).sum(axis=-1, keepdims=True) < 0, -quaternions, quaternions)
        sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
        angle = 2 * np.arctan2(sine, q[..., :1])
        axis = np.where(sine > 1e-12, q[..., 1:] / np.where(sine > 1e-12, sine, 1.0), near[..., 1:])
        # An axis may be turned round with its angle.
        flipped = (axis * near[..., 1:]).sum(axis=-1, keepdims=True) < 0
        axis, angle = np.where(flipped, -axis, axis), np.where(flipped, -angle, angle)
        angle += 2 * np.pi * np.round((near[..., :1] - angle) / (2 * np.pi))
        return np.concatenate([angle, axis], axis=-1)
    order = mode[::-1]
    angles = rotation.to_euler(order, quaternions, near=near[..., _axes(order)])
    return angles[..., np.argsort(_axes(order))]


def _axes(order: str) -> list[int]:
    return ["XYZ".index(axis) for axis in order]


def agreeing(quaternions: FloatArray) -> FloatArray:
    """Flip signs so that neighbouring quaternions (n, 4) lie on one side: both signs mean one turn."""
    steps = np.sign((quaternions[1:] * quaternions[:-1]).sum(axis=1))
    signs = np.cumprod(np.concatenate([[1.0], np.where(steps < 0, -1.0, 1.0)]))
    return quaternions * signs[:, None]


def baked(
    curves: Mapping[CurveName, CurveSegments],
    chains: Sequence[Channels],
    timing: Timing,
    *,
    average: bool,
    discrete: frozenset[CurveName] = frozenset(),
    metres_per_unit: float = 1.0,
) -> dict[CurveName, FloatArray]:
    """Give curves new timing, frame by frame.

    Parameters
    ----------
    curves : mapping from name to CurveSegments
        In the scene's frames.
    chains : sequence of Channels
        The bones (all of an armature, parents first) whose turns are averaged as turns, and whose feet are exempt.
    timing : Timing
        The new timing.
    average : bool
        Average where the motion is sped up, so that sway does not become jitter; but nothing across a jump.
    discrete : frozenset
        Curves that have no values between: never averaged.
    metres_per_unit : float
        The scene's unit.

    Returns
    -------
    dict from name to float array, shape (n_frames,)
        Values at the whole output frames of the range.
    """
    frames = timing.frames()
    at = timing.warp(frames)
    plain = {name: curve(at)[:, 0] for name, curve in curves.items()}
    for chain in chains:
        path = chain.turn_path
        names = [(path, i) for i in range(4)]
        if chain.mode == "QUATERNION" and all(name in plain for name in names):
            fours = agreeing(np.stack([plain[name] for name in names], axis=1))
            plain.update({name: fours[:, i] for i, name in enumerate(names)})
    if not average or float(timing.warp.slopes.max()) <= 1.0 + 1e-9:
        return plain
    inputs = np.arange(timing.start, np.floor(timing.input_end + 1e-6) + 1)
    sampled = {name: curve(inputs)[:, 0] for name, curve in curves.items()}
    warp = timing.in_seconds()
    out = dict(plain)
    in_figure = _of_figure(chains, sampled)
    others = [name for name in curves if name not in in_figure and name not in discrete]
    if others:
        columns = np.stack([sampled[name] for name in others], axis=1)
        averaged = apply_warp(columns, warp, rate=timing.rate)
        out.update({name: _fit(averaged[:, i], len(frames)) for i, name in enumerate(others)})
    if in_figure:
        out.update(_averaged_figure(chains, sampled, plain, timing, in_figure, metres_per_unit))
    _keep_jumps(out, plain, curves, chains, timing)
    return out


def _keep_jumps(
    out: dict[CurveName, FloatArray],
    plain: Mapping[CurveName, FloatArray],
    curves: Mapping[CurveName, CurveSegments],
    chains: Sequence[Channels],
    timing: Timing,
) -> None:
    """Average nothing across a jump: what was keyed to jump is meant to, and nothing was ever between its two sides."""
    frames = timing.frames()
    widths = window_frames(timing.in_seconds(), timing.rate, (frames - timing.start) / timing.rate)
    # The mean of a window takes the input's frames on both sides of its ends.
    reach = (widths - 1.0) / 2 + 1.0
    centre = timing.warp(frames)
    held: dict[CurveName, BoolArray] = {}
    for name, curve in curves.items():
        jumps = _jumps(curve)
        if len(jumps):
            held[name] = np.searchsorted(jumps, centre - reach, "right") < np.searchsorted(
                jumps, centre + reach, "left"
            )
    for chain in chains:
        # A turn is averaged as one.
        turn = [name for name in _turn(chain) if name in curves]
        ones = [held[name] for name in turn if name in held]
        for name in turn if ones else ():
            held[name] = np.asarray(np.any(ones, axis=0))
    for name, near in held.items():
        out[name] = np.where(near, plain[name], out[name])


def _jumps(curve: CurveSegments) -> FloatArray:
    """Return the frames at which a curve jumps, in order."""
    if not len(curve):
        return np.zeros(0)
    after = np.append(curve.values[1:, 0, 0], curve.end_value[0])
    high = np.abs(curve.values[:, 3, 0] - after)
    return np.asarray(curve.times[high > _ROUNDING * np.abs(curve.values).max(), 3])


def _turn(chain: Channels) -> list[CurveName]:
    return [(chain.turn_path, i) for i in range(chain.n_turns)]


def _of_figure(chains: Sequence[Channels], sampled: Mapping[CurveName, FloatArray]) -> set[CurveName]:
    """Name the curves that are a place, or all of a turn: a turn of which only a part is animated stays numbers."""
    found: set[CurveName] = set()
    for chain in chains:
        turn = _turn(chain)
        found |= {(chain.prefix + "location", i) for i in range(3)} & sampled.keys()
        if all(name in sampled for name in turn):
            found |= set(turn)
    return found


def _averaged_figure(
    chains: Sequence[Channels],
    sampled: Mapping[CurveName, FloatArray],
    plain: Mapping[CurveName, FloatArray],
    timing: Timing,
    names: set[CurveName],
    metres_per_unit: float,
) -> dict[CurveName, FloatArray]:
    n_input, n_output = len(next(iter(sampled.values()))), len(timing.frames())
    rotations = np.zeros((n_input, len(chains) + 1, 4))
    rotations[:, 0, 0] = 1.0
    translations = np.zeros((n_input, len(chains) + 1, 3))
    rest_turns = rotation.from_matrix(np.stack([_turn_of(chain.rest) for chain in chains]))
    for joint, chain in enumerate(chains, start=1):
        place = _columns(sampled, chain.prefix + "location", chain.place, n_input)
        turn = _columns(sampled, chain.turn_path, chain.turn, n_input)
        rotations[:, joint] = rotation.multiply(rest_turns[joint - 1], quaternions_of(chain.mode, turn))
        translations[:, joint] = chain.rest[:3, 3] + place @ _turn_of(chain.rest).T
    skeleton = Skeleton(
        ("", *(chain.name for chain in chains)),
        (-1, *(chain.parent + 1 for chain in chains)),
        np.concatenate([np.zeros((1, 3)), [chain.rest[:3, 3] for chain in chains]]),
    )
    motion = Motion(
        skeleton, rotations, translations, timing.rate, "the figure", metres_per_unit=metres_per_unit, up="z"
    )
    shown = apply_warp(motion, timing.in_seconds())
    out: dict[CurveName, FloatArray] = {}
    for joint, chain in enumerate(chains, start=1):
        path = chain.prefix + "location"
        place = (shown.local_translations[:, joint] - chain.rest[:3, 3]) @ _turn_of(chain.rest)
        out.update({(path, i): _fit(place[:, i], n_output) for i in range(3) if (path, i) in names})
        if (chain.turn_path, 0) not in names:
            continue
        near = _columns(plain, chain.turn_path, chain.turn, n_output)
        turn = rotation.multiply(rotation.conjugate(rest_turns[joint - 1]), shown.rotations[:, joint])
        numbers = numbers_of(chain.mode, _fit(turn, n_output), near)
        out.update({(chain.turn_path, i): numbers[:, i] for i in range(chain.n_turns)})
    return out


def _turn_of(matrix: FloatArray) -> FloatArray:
    return np.asarray(matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0))


def _columns(values: Mapping[CurveName, FloatArray], path: str, held: FloatArray, n: int) -> FloatArray:
    return np.stack([values.get((path, i), np.full(n, float(one))) for i, one in enumerate(held)], axis=1)


def _fit(values: FloatArray, n: int) -> FloatArray:
    """Give as many frames as the range has: a range that ends between two frames shows one fewer."""
    if len(values) >= n:
        return values[:n]
    return np.concatenate([values, np.repeat(values[-1:], n - len(values), axis=0)])
