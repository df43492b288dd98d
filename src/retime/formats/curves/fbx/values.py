"""Properties of an FBX scene over time: curves evaluated, and layers put on top of one another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief_repr
from retime.formats.curves.fbx.curve import CONSTANT, NEXT
from retime.formats.curves.fbx.scene import CurveNode, FbxScene, Item, Layer
from retime.formats.curves.fbx.span import StackCurves, extended
from retime.motion import rotation

# Rotation orders as FBX numbers them, in the order of multiplication: XYZ there turns about X first.
ORDERS = ("ZYX", "YZX", "XZY", "ZXY", "YXZ", "XYZ")
ROTATION, SCALING = "Lcl Rotation", "Lcl Scaling"
_ADDITIVE, _OVERRIDE = 0, 1
# From here on a layer's weight counts as whole.
_ALL = 0.99999


@dataclass(eq=False)
class StackValues:
    """A stack whose properties can be asked for at some times.

    Attributes
    ----------
    scene : FbxScene
    times : float array, shape (n_frames,)
        Seconds.
    layers : list of Layer
        Those that are not muted.
    base : Layer
        The lowest layer, muted or not.
    shown : dict of int to float array, shape (n_frames,)
        What each curve has at the times, by its number in the file.
    by_target : dict of (int, str) to list of (Layer, CurveNode)
        What moves a property of an object, the lowest layer first.
    """

    scene: FbxScene
    times: FloatArray
    layers: list[Layer]
    base: Layer
    shown: dict[int, FloatArray]
    by_target: dict[tuple[int, str], list[tuple[Layer, CurveNode]]]

    __repr__ = brief_repr

    def vector(self, item: Item, name: str, missing: tuple[float, ...]) -> FloatArray:
        """Return a property over time, shape (n_frames, n); a turn in degrees."""
        n = len(missing)
        values = np.tile(self.scene.numbers(item, name, missing), (len(self.times), 1))
        for layer, node in self.by_target.get((item.id, name), ()):
            values = self._on_top(item, name, values, layer, self.node_values(node, n))
        return values

    def node_values(self, node: CurveNode, n: int) -> FloatArray:
        """Return what the curves of one node have, shape (n_frames, n)."""
        parts = parts_of(self.scene, node)
        columns = []
        for part in (f"d|{axis}" for axis in "XYZ") if n == 3 else parts[:1]:
            curve = node.curves.get(part)
            if curve is not None and curve.id in self.shown:
                columns.append(self.shown[curve.id])
            else:
                columns.append(np.full(len(self.times), self.scene.numbers(node.item, part, (0.0,))[0]))
        if len(columns) != n:
            columns = (columns or [np.zeros(len(self.times))])[:1] * n
        return np.stack(columns, axis=1)

    def _weight(self, layer: Layer) -> FloatArray:
        """Return a layer's weight over time, from 0 to 1."""
        weight = np.full(len(self.times), self.scene.numbers(layer.item, "Weight", (100.0,))[0])
        for _, node in self.by_target.get((layer.item.id, "Weight"), ()):
            weight = self.node_values(node, 1)[:, 0]
        weight = np.clip(weight / 100, 0.0, None)
        return np.where(weight > _ALL, 1.0, weight)

    def _on_top(self, item: Item, name: str, below: FloatArray, layer: Layer, value: FloatArray) -> FloatArray:
        """Put a layer's value on top of what lies below it, as ufbx does."""
        mode = self.scene.whole(layer.item, "BlendMode", _ADDITIVE)
        if layer is self.base or mode == _OVERRIDE:
            return value
        weight = self._weight(layer)[:, None]
        turned = name == ROTATION and self.scene.whole(layer.item, "RotationAccumulationMode", 0) == 0
        scaled = name == SCALING and self.scene.whole(layer.item, "ScaleAccumulationMode", 0) == 0
        if turned:
            order = rotation_order(self.scene, item)
            under, over = quaternions(order, below), quaternions(order, value)
            if mode == _ADDITIVE:
                start = np.broadcast_to(rotation.identity(), over.shape)
                mixed = rotation.multiply(under, rotation.slerp(start, over, weight[:, 0]))
            else:
                mixed = rotation.slerp(under, over, weight[:, 0])
            return degrees(order, mixed)
        if scaled:
            return _power(below, np.ones(1) if mode == _ADDITIVE else 1 - weight) * _power(value, weight)
        if mode == _ADDITIVE:
            return below + value * weight
        return below * (1 - weight) + value * weight


def _power(base: FloatArray, exponent: FloatArray) -> FloatArray:
    """Raise scales to shares of themselves; what is mirrored stays so."""
    raised = np.where(base < 0, -1.0, 1.0) * np.abs(base) ** np.clip(exponent, 1e-300, 1.0)
    return np.where(exponent <= 0, 1.0, np.where(exponent >= 1, base, raised))


def parts_of(scene: FbxScene, node: CurveNode) -> list[str]:
    """Name the parts of a curve node: those that it gives a value, and those that have a curve."""
    said = [name for name in scene.properties(node.item) if name.startswith("d|")]
    return list(dict.fromkeys([*said, *node.curves]))


def rotation_order(scene: FbxScene, item: Item) -> str:
    """Return the order in which a node's turns are multiplied."""
    number = scene.whole(item, "RotationOrder", 0)
    return ORDERS[number] if 0 <= number < len(ORDERS) else ORDERS[0]


def quaternions(order: str, angles: FloatArray) -> FloatArray:
    """Return rotations (n, 4) of angles about X, Y and Z in degrees (n, 3)."""
    places = ["XYZ".index(axis) for axis in order]
    return rotation.from_euler(order, rotation.radians(angles[:, places]))


def degrees(order: str, turned: FloatArray, near: FloatArray | None = None) -> FloatArray:
    """Return angles about X, Y and Z in degrees (n, 3) of rotations (n, 4), close to given ones."""
    places = ["XYZ".index(axis) for axis in order]
    found = rotation.to_euler(order, turned, near=None if near is None else np.radians(near[:, places]))
    angles = np.empty_like(found)
    angles[:, places] = np.degrees(found)
    return angles


def quaternion_doubt(scene: FbxScene, stacks: list[StackCurves]) -> str:
    """Say which nodes have rotations that some programs interpolate as quaternions; "" where none has."""
    found = {
        item.name
        for curves in stacks
        for layer in curves.stack.layers
        for node in layer.nodes
        for item, name in node.targets
        if name == ROTATION and node.curves and scene.whole(item, "QuaternionInterpolate", 0)
    }
    if not found:
        return ""
    some = ", ".join(sorted(found)[:3]) + (" ..." if len(found) > 3 else "")
    return f"rotations of {len(found)} nodes ({some}) ask to be interpolated as quaternions, which few programs do"


def stack_values(scene: FbxScene, curves: StackCurves, times: FloatArray) -> tuple[StackValues, list[str]]:
    """Evaluate all curves of a stack at some times.

    Returns
    -------
    values : StackValues
    doubts : list of str
        What programs read in more than one way, or is not followed.
    """
    old, _ = extended(scene, curves, float(times[0]), float(times[-1]))
    shown = {record.item.id: old.batch.curve(index)(times)[:, 0] for index, record in enumerate(curves.records)}
    keys = curves.keys
    to_next = np.flatnonzero((keys.flags & CONSTANT != 0) & (keys.flags & NEXT != 0))
    for key in to_next.tolist():
        # The next key's value shows behind such a key, not at it.
        record = curves.records[int(np.searchsorted(keys.starts, key, side="right")) - 1]
        shown[record.item.id][times == keys.ticks[key] / scene.ticks] = keys.values[key]
    layers = curves.stack.layers
    muted = [layer for layer in layers if scene.whole(layer.item, "Mute", 0)]
    used = [layer for layer in layers if layer not in muted]
    doubts = []
    if muted:
        doubts.append(f"muted layers are not shown: {', '.join(layer.item.name for layer in muted)}")
    if any(scene.whole(layer.item, "Solo", 0) for layer in layers):
        doubts.append("a layer is marked solo; all layers are shown")
    for layer in used[1:]:
        if (
            scene.whole(layer.item, "BlendMode", 0) == _OVERRIDE
            and scene.numbers(layer.item, "Weight", (100.0,))[0] < 99
        ):
            doubts.append(f"layer {layer.item.name!r} overrides those below it with a weight, which is not followed")
    doubt = quaternion_doubt(scene, [curves])
    if doubt:
        doubts.append(doubt)
    by_target: dict[tuple[int, str], list[tuple[Layer, CurveNode]]] = {}
    for layer in used:
        for node in layer.nodes:
            for item, name in node.targets:
                by_target.setdefault((item.id, name), []).append((layer, node))
    return StackValues(scene, times, used, layers[0], shown, by_target), doubts
