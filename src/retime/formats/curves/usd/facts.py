"""What a USD scene holds beside the clip that is read, for `retime info`. Runs in the child process (`usd.child`)."""

from __future__ import annotations

from pathlib import Path

from pxr import Usd, UsdGeom, UsdSkel

from retime.formats.curves.usd.animation import sampled_attributes, skeletal_animations
from retime.formats.curves.usd.layers import layers_of, prims_with_clips, told
from retime.formats.curves.usd.stage import Scene

_SHOWN = 8


def facts_of(scene: Scene) -> dict[str, str]:
    """Say what a scene is stored as, of which layers, on which clock, and what in it moves."""
    stage, root = scene.stage, scene.layer
    layers = layers_of(scene)
    found = {"stored": _stored(scene)}
    found["layers"] = _listed([told(layer, scene) for layer in layers])
    if scene.missing:
        found["missing"] = _listed(scene.missing)
    clock = f"{scene.codes_per_second:g} time codes a second"
    if root.HasStartTimeCode() or root.HasEndTimeCode():
        ends = (
            f"{root.startTimeCode:g}" if root.HasStartTimeCode() else "?",
            f"{root.endTimeCode:g}" if root.HasEndTimeCode() else "?",
        )
        clock += f", from {ends[0]} to {ends[1]}"
    found["clock"] = clock
    prims = list(Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()))
    unit = float(UsdGeom.GetStageMetersPerUnit(stage))
    said = "" if root.pseudoRoot.HasInfo("metersPerUnit") else " (not said)"
    kinds = [("skeletons", UsdSkel.Skeleton), ("meshes", UsdGeom.Mesh), ("cameras", UsdGeom.Camera)]
    counts = [f"{len(prims)} prims", *(f"{sum(prim.IsA(one) for prim in prims)} {name}" for name, one in kinds)]
    axis = str(UsdGeom.GetStageUpAxis(stage))
    found["scene"] = f"{', '.join(counts)}; up axis {axis}, {unit:g} m a unit{said}"
    animations = []
    for one in skeletal_animations(stage):
        n_joints, n_shapes = len(one.query.GetJointOrder()), len(one.query.GetBlendShapeOrder())
        parts = []
        if n_joints:
            parts.append(f"{n_joints} joints, {len(one.query.GetJointTransformTimeSamples())} samples")
        if n_shapes:
            parts.append(f"{n_shapes} blend shapes, {len(one.query.GetBlendShapeWeightTimeSamples())} samples")
        animations.append(f"{one.path} ({'; '.join(parts)})")
    found["animations"] = _listed(animations)
    sampled = sampled_attributes(stage)
    moving = list(dict.fromkeys(attribute.GetPrim().GetPath().pathString for attribute, _ in sampled))
    n_splines = sum(attribute.HasSpline() for attribute, _ in sampled)
    n_samples = sum(len(times) for attribute, times in sampled if not attribute.HasSpline())
    more = f", {n_splines} splines" if n_splines else ""
    found["animated"] = f"{_listed(moving)}; {len(sampled)} attributes, {n_samples} samples{more}"
    clips = [str(path) for layer in layers for path in prims_with_clips(layer)]
    if clips:
        found["value clips"] = _listed(clips)
    return found


def _stored(scene: Scene) -> str:
    kind = "text" if scene.text.startswith(b"#usda") else "crate"
    if not scene.package:
        return kind
    return f"package of {len(scene.package)} files, the first is {Path(next(iter(scene.package))).name} ({kind})"


def _listed(names: list[str]) -> str:
    """Count names, and say the first of them."""
    if not names:
        return "none"
    return f"{len(names)}: {', '.join(names[:_SHOWN])}" + (" ..." if len(names) > _SHOWN else "")
