"""A motion as a new USD layer: a skeleton and its animation, without a mesh. Runs in the child (`usd.child`)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdSkel, Vt

from retime.errors import FormatError
from retime.formats.curves.usd.exchange import Message
from retime.formats.curves.usd.layer_files import layer_bytes


def written(asked: Message, work: Path, *, text: bool) -> bytes:
    """Make a layer of a motion.

    Parameters
    ----------
    asked : Message
        Facts: names, parents, ends ([joint, [x, y, z]]), rate (a pair), up, unit, name. Arrays: rotations (wxyz),
        translations, offsets, as a `Motion` has them.
    work : Path
        A folder of this process's own.
    text : bool
        Text, or crate.
    """
    facts = asked.facts
    offsets = [[float(number) for number in row] for row in asked.arrays["offsets"]]
    translations, rotations = asked.arrays["translations"], asked.arrays["rotations"]
    if max(float(np.abs(translations).max()), float(np.abs(asked.arrays["offsets"]).max())) > 1e30:
        raise FormatError("a length is beyond what single precision, which UsdSkel has, can hold")
    parents = list(facts["parents"])
    names = list(facts["names"])
    n_moving = len(names)
    for joint, offset in facts["ends"]:
        parents.append(joint)
        names.append(f"{names[joint]}_end")
        offsets.append(offset)
    tokens = _tokens(names, parents)
    numerator, denominator = facts["rate"]
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    UsdGeom.SetStageUpAxis(stage, facts["up"].upper())
    if facts["unit"] is not None:
        UsdGeom.SetStageMetersPerUnit(stage, facts["unit"])
    stage.SetTimeCodesPerSecond(numerator / denominator)
    stage.SetFramesPerSecond(numerator / denominator)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(len(translations) - 1)
    name = Tf.MakeValidIdentifier(facts["name"] or "motion")
    root = UsdSkel.Root.Define(stage, f"/{name}")
    stage.SetDefaultPrim(root.GetPrim())
    skeleton = UsdSkel.Skeleton.Define(stage, root.GetPath().AppendChild("Skeleton"))
    animation = UsdSkel.Animation.Define(stage, skeleton.GetPath().AppendChild("Animation"))
    UsdSkel.BindingAPI.Apply(root.GetPrim())
    UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    rest = [Gf.Matrix4d(1).SetTranslate(Gf.Vec3d(*row)) for row in offsets]
    bind: list[Any] = []
    for matrix, parent in zip(rest, parents, strict=True):
        bind.append(matrix * bind[parent] if parent >= 0 else matrix)
    skeleton.CreateJointsAttr(Vt.TokenArray(tokens))
    skeleton.CreateJointNamesAttr(Vt.TokenArray(names))
    skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray(rest))
    skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray(bind))
    if len(names) > n_moving:
        skeleton.GetPrim().SetCustomDataByKey("retime:endSites", Vt.IntArray(range(n_moving, len(names))))
    animation.CreateJointsAttr(Vt.TokenArray(tokens[:n_moving]))
    moved = animation.CreateTranslationsAttr().GetPath()
    turned = animation.CreateRotationsAttr().GetPath()
    animation.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1, 1, 1)] * n_moving))
    places = np.ascontiguousarray(translations, dtype=np.float32)
    # UsdSkel's quaternions lie in memory with the real part last.
    turns = np.ascontiguousarray(np.roll(rotations, -1, axis=2), dtype=np.float32)
    for frame in range(len(places)):
        layer.SetTimeSample(moved, float(frame), Vt.Vec3fArray.FromNumpy(places[frame]))
        layer.SetTimeSample(turned, float(frame), Vt.QuatfArray.FromNumpy(turns[frame]))
    return layer_bytes(layer, work, text=text)


def _tokens(names: list[str], parents: list[int]) -> list[str]:
    """Name joints by paths of names that USD takes, no two alike."""
    tokens: list[str] = []
    taken: set[str] = set()
    for name, parent in zip(names, parents, strict=True):
        plain = Tf.MakeValidIdentifier(name)
        token = plain if parent < 0 else f"{tokens[parent]}/{plain}"
        number, first = 1, token
        while token in taken:
            number += 1
            token = f"{first}_{number}"
        taken.add(token)
        tokens.append(token)
    return tokens
