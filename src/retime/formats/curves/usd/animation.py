"""The animation of a USD scene as numbers at a rate, for the search. Runs in the child process (`usd.child`).

A clip is what the scene's clock spans, from startTimeCode to endTimeCode: of a skeletal animation the joints of its
skeleton, else the prims that move, else whatever attributes change.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Sdf, Usd, UsdGeom, UsdSkel

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.errors import FormatError
from retime.formats.curves.key_grid import grid_rate
from retime.formats.curves.usd.exchange import Message
from retime.formats.curves.usd.stage import Scene, naming
from retime.formats.made_frames import Sampling
from retime.formats.number_text import count_of
from retime.formats.read_options import Limits
from retime.motion import rotation
from retime.motion.channels import text_label
from retime.motion.rate import parse_rate

# An attribute of more numbers is a mesh, say, and nothing that a search should look at.
_MOST_NUMBERS = 256
_FASTEST_CLOCK = 240.0


@dataclass(frozen=True)
class Span:
    """What a scene's clock spans.

    Attributes
    ----------
    start, end : float
        Time codes.
    per_second : float
        Time codes a second.
    keys : float array
        Where samples lie, within.
    """

    start: float
    end: float
    per_second: float
    keys: FloatArray

    __repr__ = brief_repr

    def rate(self) -> Fraction:
        """Return the frames a second on which the samples lie."""
        steps = self.keys - self.start
        if self.per_second <= _FASTEST_CLOCK and np.abs(steps - np.rint(steps)).max(initial=0.0) < 1e-3:
            return parse_rate(self.per_second)
        return grid_rate([self.keys / self.per_second], self.start / self.per_second)


def sampled_attributes(stage: Any) -> list[tuple[Any, FloatArray]]:
    """Find the attributes of a scene that have time samples, two or more, or a spline, and where these lie (codes)."""
    found = []
    # A layer of nothing but overs is a scene too, whose prims are not defined.
    for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimAllPrimsPredicate)):
        for attribute in prim.GetAuthoredAttributes():
            times: Any = attribute.GetTimeSamples()
            if attribute.HasSpline():
                span = attribute.GetSpline().GetKnots().GetTimeSpan()
                times = [span.GetMin(), span.GetMax()]
            if len(times) > 1:
                found.append((attribute, np.array(times, dtype=np.float64)))
    return found


def span_of(scene: Scene) -> Span:
    """Find what a scene's clock spans: as it says, or from its first sample to its last; raise FormatError for none."""
    per_second = scene.codes_per_second
    if not 1e-6 < per_second < 1e9:
        raise FormatError(f"timeCodesPerSecond must be a number above 0, found {per_second:g}")
    attributes = sampled_attributes(scene.stage)
    if not attributes:
        raise FormatError("nothing in this scene has time samples: there is no animation")
    keys = np.unique(np.concatenate([times for _, times in attributes]))
    root = scene.layer
    start = float(root.startTimeCode) if root.HasStartTimeCode() else float(keys[0])
    end = float(root.endTimeCode) if root.HasEndTimeCode() else float(keys[-1])
    for what, code in (("startTimeCode", start), ("endTimeCode", end)):
        if not abs(code) / per_second <= 1e7:
            raise FormatError(f"{what} is {code:g}, which is no time that a clip can have")
    if end <= start:
        raise FormatError(f"the scene ends at time code {end:g}, and begins at {start:g}: that is no animation")
    return Span(start, end, per_second, keys[(keys >= start) & (keys <= end)])


@dataclass(frozen=True)
class Animation:
    """A skeletal animation, and the skeleton that it moves, where there is one."""

    path: str
    query: Any
    skeleton: Any


def skeletal_animations(stage: Any) -> list[Animation]:
    """Find the skeletal animations that change, each once, those that move joints first."""
    cache = UsdSkel.Cache()
    prims = [prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Root)]
    for prim in prims:
        cache.Populate(UsdSkel.Root(prim), Usd.PrimDefaultPredicate)
    found: dict[str, Animation] = {}
    for prim in stage.Traverse():
        if prim.IsA(UsdSkel.Skeleton):
            query = cache.GetSkelQuery(UsdSkel.Skeleton(prim))
            source = UsdSkel.BindingAPI(prim).GetInheritedAnimationSource()
            animation = query.GetAnimQuery() if query else None
            if animation and source and source.GetPath().pathString not in found:
                found[source.GetPath().pathString] = Animation(source.GetPath().pathString, animation, query)
    for prim in stage.Traverse():
        if prim.IsA(UsdSkel.Animation) and prim.GetPath().pathString not in found:
            animation = cache.GetAnimQuery(UsdSkel.Animation(prim))
            if animation:
                found[prim.GetPath().pathString] = Animation(prim.GetPath().pathString, animation, None)
    moving = [one for one in found.values() if one.query.JointTransformsMightBeTimeVarying()]
    return moving + [
        one for one in found.values() if one not in moving and one.query.BlendShapeWeightsMightBeTimeVarying()
    ]


def names_of(scene: Scene) -> list[str]:
    """Name the skeletal animations; raise FormatError where nothing in the scene moves."""
    span_of(scene)
    return [one.path for one in skeletal_animations(scene.stage)]


def read(scene: Scene, wanted: str | None, rate: Fraction | None, limits: Limits) -> Message:
    """Sample a scene; its facts say whether a motion or a signal came of it.

    Parameters
    ----------
    scene : Scene
        Opened.
    wanted : str, optional
        The path of an animation or another prim, or of an attribute, or an animation's name or number.
    rate : Fraction, optional
        Frames a second.
    limits : Limits
        Of sizes.
    """
    span = span_of(scene)
    rate = rate or span.rate()
    seconds = (span.end - span.start) / span.per_second
    n_frames = int(np.ceil(float(rate) * seconds - 1e-3)) + 1
    if n_frames > limits.frames:
        raise FormatError(
            f"lasts {seconds:g} s, which is {n_frames} frames at {float(rate):g} Hz, the limit is {limits.frames} "
            "(Limits.frames): give a lower rate (--fps)"
        )
    keys = span.keys / span.per_second
    start, end = span.start / span.per_second, span.end / span.per_second
    sampling = Sampling(start, end, float(rate), n_frames, 1, len(keys), keys)
    _refuse_made(sampling, 1)
    doubt = sampling.doubt()
    codes: FloatArray = span.start + np.arange(n_frames) / float(rate) * span.per_second
    animations = skeletal_animations(scene.stage)
    chosen, path = _chosen(scene.stage, animations, wanted)
    facts: dict[str, Any] = {
        "rate": [rate.numerator, rate.denominator],
        "others": [one.path for one in animations],
        "missing": scene.missing,
        "doubts": [f"the scene {doubt}"] if doubt else [],
    }
    if chosen is not None:
        facts["name"] = chosen.path.rpartition("/")[2]
        facts["chosen"] = chosen.path
        if chosen.query.JointTransformsMightBeTimeVarying():
            _refuse_made(sampling, 16 * len(chosen.query.GetJointOrder()))
            return _motion(scene, facts, *_skeletal(chosen, codes, limits))
        return _weights(chosen, codes, facts, limits)
    facts["name"] = path.name if path else ""
    if not (path and path.IsPropertyPath()):
        prims = _moving_prims(scene.stage, path)
        if prims:
            _refuse_made(sampling, 16 * len(prims))
            return _motion(scene, facts, *_prims(prims, codes, limits))
    return _signal(scene, path, codes, facts, limits)


def _refuse_made(sampling: Sampling, n_channels: int) -> None:
    """Refuse so many frames of so many numbers that a time in the scene is wrong, more likely than not."""
    held = n_channels * len(sampling.keys)
    if problem := replace(sampling, n_channels=n_channels, n_numbers=held).problem():
        raise FormatError(f"the scene {problem}")


def _chosen(stage: Any, animations: list[Animation], wanted: str | None) -> tuple[Animation | None, Any]:
    """Find what is meant: an animation, or the path of another thing in the scene; neither is all of it."""
    if wanted is None:
        return (animations[0] if animations else None), None
    for one in animations:
        skeleton = one.skeleton.GetPrim().GetPath().pathString if one.skeleton else ""
        if wanted in (one.path, skeleton):
            return one, None
    named = [one for one in animations if one.path.rpartition("/")[2] == wanted]
    if len(named) == 1:
        return named[0], None
    number = count_of(wanted)
    if number is not None and number < len(animations):
        return animations[number], None
    if Sdf.Path.IsValidPathString(wanted):
        path = Sdf.Path(wanted)
        if path.IsAbsolutePath() and path != Sdf.Path.absoluteRootPath and stage.GetObjectAtPath(path):
            return None, path
    there = ", ".join(one.path for one in animations[:12]) or "no skeletal animations"
    raise FormatError(f"no animation is called {wanted[:100]!r}; there are {there}; a prim or attribute needs its path")


def _decomposed(matrices: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Split matrices (row vectors, as USD has it) into translations, rotations (wxyz) and scales.

    Where a scale is 0, or the matrix mirrors, no rotation says it all: axes of no length become those at rest, and one
    axis is turned over.
    """
    translations = matrices[..., 3, :3]
    axes = matrices[..., :3, :3].copy()
    scales = np.linalg.norm(axes, axis=-1)
    flat = (scales < 1e-9).any(axis=-1)
    axes[flat] = np.eye(3)
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    mirrored = np.linalg.det(axes) < 0
    axes[mirrored, 0] *= -1
    # The nearest rotation, where axes are not at right angles.
    slanted = np.abs(axes @ np.swapaxes(axes, -1, -2) - np.eye(3)).max(axis=(-1, -2)) > 1e-6
    if slanted.any():
        left, _, right = np.linalg.svd(axes[slanted])
        nearest = left @ right
        nearest[np.linalg.det(nearest) < 0] = np.eye(3)
        axes[slanted] = nearest
    return translations, rotation.from_matrix(np.swapaxes(axes, -1, -2)), scales


@dataclass(frozen=True)
class _Joints:
    """What moves: names, parents, and local matrices at rest and at each frame."""

    names: list[str]
    parents: list[int]
    rest: FloatArray
    frames: FloatArray
    ends: list[int]

    __repr__ = brief_repr


def _skeletal(chosen: Animation, codes: FloatArray, limits: Limits) -> tuple[_Joints]:
    if chosen.skeleton is None:
        order = [str(name) for name in chosen.query.GetJointOrder()]
        topology = UsdSkel.Topology(chosen.query.GetJointOrder())

        def local(code: float) -> Any:
            return chosen.query.ComputeJointLocalTransforms(code)

        rest = None
        root = None
        prim = chosen.query.GetPrim()
        ends: list[int] = []
    else:
        order = [str(name) for name in chosen.skeleton.GetJointOrder()]
        topology = chosen.skeleton.GetTopology()
        prim = chosen.skeleton.GetPrim()
        skeleton = UsdSkel.Skeleton(prim)
        named = skeleton.GetJointNamesAttr().Get()
        rest = skeleton.GetRestTransformsAttr().Get()
        rest = None if rest is None or len(rest) != len(order) else np.array(rest, dtype=np.float64)
        marked = prim.GetCustomDataByKey("retime:endSites")
        ends = [int(one) for one in marked] if marked is not None else []

        def local(code: float) -> Any:
            return chosen.skeleton.ComputeJointLocalTransforms(code)

        def root(code: float) -> Any:
            return UsdGeom.XformCache(code).GetLocalToWorldTransform(prim)

    _check_size(len(order), len(codes), limits)
    right, why = topology.Validate() if order else (False, "it has no joints")
    if not right:
        raise FormatError(f"the joints of {prim.GetPath()} are no skeleton: {str(why)[:200]}")
    parents = [topology.GetParent(joint) for joint in range(len(order))]
    short = [name.rpartition("/")[2] for name in order]
    if chosen.skeleton is not None and named is not None and len(named) == len(order):
        short = [str(name) for name in named]
    frames = np.empty((len(codes), len(order), 4, 4))
    for frame, code in enumerate(codes):
        matrices = local(float(code))
        if matrices is None or len(matrices) != len(order):
            raise FormatError(f"the animation {chosen.path} doesn't fit the joints of {prim.GetPath()}")
        frames[frame] = np.array(matrices, dtype=np.float64)
    if rest is None:
        rest = frames[0]
    above = np.tile(np.eye(4), (len(codes), 1, 1))
    if root is not None:
        for frame, code in enumerate(codes):
            above[frame] = np.array(root(float(code)), dtype=np.float64)
    ends = [one for one in ends if 0 <= one < len(order) and one not in parents and parents[one] >= 0]
    if parents.count(-1) == 1 and np.abs(above - np.eye(4)).max() < 1e-12:
        return (_Joints(short, parents, rest, frames, ends),)
    return (
        _Joints(
            [prim.GetName(), *short],
            [-1, *(parent + 1 for parent in parents)],
            np.concatenate([above[:1], rest]),
            np.concatenate([above[:, None], frames], axis=1),
            [one + 1 for one in ends],
        ),
    )


def joint_places(animation: Animation, message: Message) -> list[int]:
    """Find the joints of an animation among those of the motion that `read` made of it; ends are none.

    Returns
    -------
    list of int
        In the animation's own order.
    """
    moved = [str(name) for name in animation.query.GetJointOrder()]
    order = moved if animation.skeleton is None else [str(name) for name in animation.skeleton.GetJointOrder()]
    # A joint may stand before them for the skeleton's place.
    above = len(message.facts["names"]) - len(order)
    kept = [joint for joint in range(len(message.facts["names"])) if joint not in message.facts["ends"]]
    place = {order[joint - above]: number for number, joint in enumerate(kept) if joint >= above}
    return [place[name] for name in moved if name in place]


def _check_size(n_joints: int, n_frames: int, limits: Limits) -> None:
    if n_joints > limits.joints:
        raise FormatError(f"{n_joints} joints, the limit is {limits.joints} (Limits.joints)")
    if n_joints * n_frames > limits.joint_poses:
        raise FormatError(
            f"{n_frames} frames of {n_joints} joints, the limit is {limits.joint_poses} joint poses "
            "(Limits.joint_poses): give a lower rate (--fps)"
        )


def _moving_prims(stage: Any, path: Any) -> list[Any]:
    """Find the prims whose own transformation changes, at or below a path."""
    return [
        prim
        for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies())
        if prim.IsA(UsdGeom.Xformable)
        and (path is None or prim.GetPath().HasPrefix(path))
        and UsdGeom.Xformable(prim).TransformMightBeTimeVarying()
    ]


def _prims(moving: list[Any], codes: FloatArray, limits: Limits) -> tuple[_Joints]:
    wanted: dict[Any, Any] = {}
    for prim in moving:
        above = []
        while prim and not prim.IsPseudoRoot() and prim.GetPath() not in wanted:
            above.append(prim)
            prim = prim.GetParent()
        for one in above[::-1]:
            wanted[one.GetPath()] = one
    joints = [prim for _, prim in sorted(wanted.items()) if prim.IsA(UsdGeom.Xformable)]
    _check_size(len(joints) + 1, len(codes), limits)
    place = {prim.GetPath(): joint for joint, prim in enumerate(joints)}
    parents = []
    frames = np.empty((len(codes), len(joints), 4, 4))
    for joint, prim in enumerate(joints):
        above_it = prim.GetParent()
        while above_it and above_it.GetPath() not in place and not above_it.IsPseudoRoot():
            above_it = above_it.GetParent()
        xform = UsdGeom.Xformable(prim)
        alone = xform.GetResetXformStack() or not above_it or above_it.IsPseudoRoot()
        parents.append(-1 if alone else place[above_it.GetPath()])
        for frame, code in enumerate(codes):
            frames[frame, joint] = np.array(xform.GetLocalTransformation(float(code)), dtype=np.float64)
    short = [prim.GetName() for prim in joints]
    names = [
        name if short.count(name) == 1 else prim.GetPath().pathString for name, prim in zip(short, joints, strict=True)
    ]
    if parents.count(-1) > 1:
        names, parents = ["scene", *names], [-1, *(parent + 1 for parent in parents)]
        frames = np.concatenate([np.tile(np.eye(4), (len(codes), 1, 1, 1)), frames], axis=1)
    return (_Joints(names, parents, frames[0], frames, []),)


def _motion(scene: Scene, facts: dict[str, Any], joints: _Joints) -> Message:
    if not np.isfinite(joints.frames).all() or not np.isfinite(joints.rest).all():
        raise FormatError("a transformation holds a number that is not finite")
    if max(np.abs(joints.frames).max(), np.abs(joints.rest).max()) > 1e30:
        raise FormatError("a transformation holds a number beyond any place")
    translations, rotations, _ = _decomposed(joints.frames)
    offsets, _, rest_scales = _decomposed(joints.rest)
    # How long one unit of each joint's parent is in the scene's: translations are given in the scene's.
    scales = np.ones(len(joints.names))
    for joint, parent in enumerate(joints.parents):
        if parent >= 0:
            scales[joint] = scales[parent] * np.cbrt(np.prod(rest_scales[parent]))
    root = scene.layer.pseudoRoot
    unit = float(UsdGeom.GetStageMetersPerUnit(scene.stage)) if root.HasInfo("metersPerUnit") else None
    if unit is not None and not np.isfinite(unit):
        raise FormatError(f"metersPerUnit is {unit:g}, which is no length")
    facts |= {
        "kind": "motion",
        "names": joints.names,
        "parents": joints.parents,
        "ends": joints.ends,
        "up": "z" if str(UsdGeom.GetStageUpAxis(scene.stage)) == "Z" else "y",
        "unit": unit,
    }
    return Message(
        facts,
        {
            "rotations": rotations,
            "translations": translations * scales[:, None],
            "offsets": offsets * scales[:, None],
            "scales": scales,
        },
    )


def _weights(chosen: Animation, codes: FloatArray, facts: dict[str, Any], limits: Limits) -> Message:
    names = [str(name) for name in chosen.query.GetBlendShapeOrder()]
    if not names or len(names) > limits.channels:
        raise FormatError(f"{chosen.path} has {len(names)} blend shapes, the limit is {limits.channels}")
    rows = []
    for code in codes:
        row = chosen.query.ComputeBlendShapeWeights(float(code))
        if row is None or len(row) != len(names):
            raise FormatError(f"{chosen.path} has {len(names)} blend shapes, and another number of weights")
        rows.append(np.array(row, dtype=np.float64))
    return _columns(names, np.stack(rows), {}, [], facts)


def _signal(scene: Scene, path: Any, codes: FloatArray, facts: dict[str, Any], limits: Limits) -> Message:
    """Make columns of what changes: numbers as numbers, truths and whole numbers and words as labels."""
    names: list[str] = []
    columns: list[NDArray[np.float64]] = []
    kinds: dict[int, str] = {}
    left_out: list[str] = []
    for attribute, _ in sampled_attributes(scene.stage):
        where = attribute.GetPath()
        if path is not None and not where.HasPrefix(path):
            continue
        with naming(where, attribute.GetTypeName()):
            values = [attribute.Get(float(code)) for code in codes]
        found = _numbers(values)
        if found is None:
            left_out.append(where.pathString)
            continue
        rows, kind = found
        title = where.pathString.lstrip("/")
        for part in range(rows.shape[1]):
            if kind:
                kinds[len(names)] = kind
            names.append(title if rows.shape[1] == 1 else f"{title}.{part}")
            columns.append(rows[:, part])
        if len(names) > limits.channels:
            raise FormatError(f"more than {limits.channels} numbers change (Limits.channels)")
    if not columns:
        raise FormatError(
            "what changes in this scene is no motion and no table of numbers"
            + (f": {', '.join(left_out[:8])}" if left_out else "")
        )
    return _columns(names, np.stack(columns, axis=1), kinds, left_out, facts)


def _columns(
    names: list[str], values: FloatArray, kinds: dict[int, str], left_out: list[str], facts: dict[str, Any]
) -> Message:
    if not np.isfinite(values).all() or np.abs(values).max() > 1e30:
        raise FormatError("a value is not finite, or beyond any place or weight")
    facts |= {"kind": "signal", "names": names, "left_out": left_out}
    facts["kinds"] = [[place, kind] for place, kind in kinds.items()]
    return Message(facts, {"values": values})


def _numbers(values: list[Any]) -> tuple[FloatArray, str] | None:
    """Make numbers of an attribute's values, a row each; None where they are none, or differ in shape."""
    first = values[0]
    if any(value is None or type(value) is not type(first) for value in values):
        return None
    if isinstance(first, str):
        codes, kind = text_label([str(value) or "-" for value in values])
        return codes[:, None], str(kind)
    make = as_row(first)
    if make is None:
        return None
    rows = [make(value) for value in values]
    if len(rows[0]) > _MOST_NUMBERS or any(len(row) != len(rows[0]) for row in rows):
        return None
    return np.stack(rows), "label" if isinstance(first, bool | int) else ""


def as_row(value: Any) -> Callable[[Any], NDArray[np.float64]] | None:
    """Return what makes one row of numbers of such a value; None where that can't be done."""
    if isinstance(value, bool | int | float):
        return lambda one: np.array([one], dtype=np.float64)
    if hasattr(value, "GetImaginary"):
        return lambda one: np.array([*one.GetImaginary(), one.GetReal()], dtype=np.float64)
    try:
        numbers = np.array(value)
    except (TypeError, ValueError):
        return None
    if numbers.dtype.kind not in "fiub" or numbers.ndim == 0:
        return None
    return lambda one: np.array(one, dtype=np.float64).ravel()
