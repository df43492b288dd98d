"""The skins of an FBX scene: meshes whose points follow the joints of a clip that was read from it, by clusters."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from retime.arrays import FloatArray, doubles
from retime.formats.curves.fbx.file import Record
from retime.formats.curves.fbx.motion import Sampled, parent_of
from retime.formats.curves.fbx.scene import FbxScene, Item
from retime.formats.curves.fbx.values import SCALING, quaternions
from retime.motion import rotation
from retime.motion.skin import MOST_POINTS, Skin, is_usable

# Joints that a point follows at most; of more the heaviest are kept.
_MOST = 4


def read_skin(scene: FbxScene, sampled: Sampled) -> Skin | None:
    """Read all meshes that follow the nodes of a motion, as one; None where there is none.

    Materials and shapes are left out, and so are triangles with a corner that follows nothing.

    Raises
    ------
    FormatError
        A mesh or a cluster is damaged, or there are more points than can be drawn.
    """
    bones = _Bones(scene, sampled)
    points: list[FloatArray] = []
    triangles: list[NDArray[np.int64]] = []
    follows: list[NDArray[np.int64]] = []
    weights: list[FloatArray] = []
    n_points = 0
    for geometry in [item for item in scene.items.values() if item.kind == "Geometry" and item.subtype == "Mesh"]:
        skins = [item for item, _ in scene.within(geometry, "Deformer") if item.subtype == "Skin"]
        clusters = [one for skin in skins for one, _ in scene.within(skin, "Deformer") if one.subtype == "Cluster"]
        if not clusters:
            continue
        vertices, corners = _mesh(scene, geometry)
        if n_points + len(vertices) > MOST_POINTS:
            raise scene.file.error(f"its meshes have more than {MOST_POINTS} points", geometry.record)
        bound, share = _influences(scene, clusters, len(vertices), bones)
        held = share.sum(axis=1) > 0
        points.append(_placed(scene, geometry, vertices))
        triangles.append(corners[held[corners].all(axis=1)] + n_points)
        follows.append(bound)
        weights.append(share / np.where(held, share.sum(axis=1), 1.0)[:, None])
        n_points += len(vertices)
    if sum(map(len, triangles)) == 0:
        return None
    if not is_usable(*bones.matrices, *points):
        raise scene.file.error("its skin holds a number that is beyond use")
    return Skin(
        np.concatenate(points),
        np.concatenate(triangles).astype(np.int32),
        np.stack(bones.matrices),
        np.array(bones.joints, dtype=np.int32),
        np.concatenate(follows).astype(np.int32),
        np.concatenate(weights),
    )


class _Bones:
    """Bones, one for each cluster whose node is a joint."""

    def __init__(self, scene: FbxScene, sampled: Sampled) -> None:
        self._scene = scene
        self._scales = sampled.scales
        self._place = {node.id: joint for joint, node in enumerate(sampled.nodes) if node is not None}
        self.matrices: list[FloatArray] = []
        self.joints: list[int] = []

    def add(self, cluster: Item) -> int | None:
        """Return the bone of a cluster; None where its node is no joint."""
        scene = self._scene
        node = next((item for item, _ in scene.within(cluster, "Model")), None)
        joint = None if node is None else self._place.get(node.id)
        if node is None or joint is None:
            return None
        # From the mesh to the node as they stood when they were bound, written column by column.
        matrix = _array(scene, cluster, "Transform", 16).reshape(4, 4).T
        own = scene.numbers(node, SCALING, (1.0, 1.0, 1.0))
        # A joint turns and moves; what it scales is scaled beforehand, in the units that the motion has.
        with np.errstate(over="ignore", invalid="ignore"):
            # What is beyond use is refused in the end.
            self.matrices.append(((np.diag([*own, 1.0]) @ matrix) * self._scale_above(node, joint))[:3])
        self.joints.append(joint)
        return len(self.matrices) - 1

    def _scale_above(self, node: Item, joint: int) -> float:
        """How many units of the scene one unit is, in which a node's own is said; it may leave out its parent's."""
        above = parent_of(self._scene, node)
        scale = float(self._scales[joint])
        if above is None or self._scene.whole(node, "InheritType", 0) != _IGNORES_SCALE:
            return scale
        size = float(np.cbrt(np.abs(np.prod(self._scene.numbers(above, SCALING, (1.0, 1.0, 1.0))))))
        return scale / size if size else scale


_IGNORES_SCALE = 2


def _part(scene: FbxScene, item: Item, name: str) -> Record:
    record = item.record.child(name)
    if record is None:
        raise scene.file.error(f"{item.kind} {item.name!r} lacks its {name}", item.record)
    return record


def _array(scene: FbxScene, item: Item, name: str, size: int | None = None) -> FloatArray:
    found = doubles(scene.file.array(_part(scene, item, name), "dfil"))
    if not np.isfinite(found).all() or np.abs(found).max(initial=0) > 1e30:
        raise scene.file.error(f"{name} holds a number that is beyond use", item.record)
    if size is not None and len(found) != size:
        raise scene.file.error(f"{name} must hold {size} numbers, found {len(found)}", item.record)
    return found


def _mesh(scene: FbxScene, geometry: Item) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return the points (n, 3) and the triangles (m, 3) of a mesh, whose faces are cut into fans."""
    flat = _array(scene, geometry, "Vertices")
    if len(flat) % 3:
        raise scene.file.error("Vertices must hold three numbers for each point", geometry.record)
    points = flat.reshape(-1, 3)
    written = _array(scene, geometry, "PolygonVertexIndex").astype(np.int64)
    # The last corner of a face is written as its complement.
    last = written < 0
    corners = np.where(last, ~written, written)
    if corners.min(initial=0) < 0 or corners.max(initial=-1) >= len(points):
        raise scene.file.error(f"a face has a corner that is none of {len(points)} points", geometry.record)
    ends = np.flatnonzero(last)
    starts = np.concatenate([[0], ends[:-1] + 1]).astype(np.int64) if len(ends) else np.zeros(0, dtype=np.int64)
    sizes = np.maximum(ends - starts - 1, 0)
    face = np.repeat(np.arange(len(ends)), sizes)
    step = np.arange(len(face)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    first = starts[face]
    return points, np.stack([corners[first], corners[first + step + 1], corners[first + step + 2]], axis=1)


def _influences(
    scene: FbxScene, clusters: list[Item], n_points: int, bones: _Bones
) -> tuple[NDArray[np.int64], FloatArray]:
    """Return for each point the bones that it follows, the heaviest first, and how much, (n_points, 4) each."""
    of_point, of_bone, of_weight = [], [], []
    for cluster in clusters:
        if cluster.record.child("Indexes") is None:
            # It holds nothing.
            continue
        bone = bones.add(cluster)
        if bone is None:
            continue
        indexes = _array(scene, cluster, "Indexes").astype(np.int64)
        shares = _array(scene, cluster, "Weights", len(indexes))
        if indexes.min(initial=0) < 0 or indexes.max(initial=-1) >= n_points:
            raise scene.file.error(f"a cluster names a point that is none of {n_points}", cluster.record)
        of_point.append(indexes)
        of_bone.append(np.full(len(indexes), bone))
        of_weight.append(np.maximum(shares, 0.0))
    bound, share = np.zeros((n_points, _MOST), dtype=np.int64), np.zeros((n_points, _MOST))
    if of_point:
        point, bone_of, weight = np.concatenate(of_point), np.concatenate(of_bone), np.concatenate(of_weight)
        order = np.lexsort((bone_of, -weight, point))
        point, bone_of, weight = point[order], bone_of[order], weight[order]
        place = np.arange(len(point)) - np.searchsorted(point, point)
        kept = place < _MOST
        bound[point[kept], place[kept]] = bone_of[kept]
        share[point[kept], place[kept]] = weight[kept]
    return bound, share


def _placed(scene: FbxScene, geometry: Item, points: FloatArray) -> FloatArray:
    """Put a mesh's points where they are in its node: a node may hold its mesh moved, turned and scaled."""
    model = next((scene.items[id_] for id_, _ in scene.above.get(geometry.id, ()) if id_ in scene.items), None)
    if model is None or model.kind != "Model":
        return points
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = points * scene.numbers(model, "GeometricScaling", (1.0, 1.0, 1.0))
        turn = quaternions("ZYX", scene.numbers(model, "GeometricRotation", (0.0, 0.0, 0.0))[None])
        return rotation.rotate(turn, scaled) + scene.numbers(model, "GeometricTranslation", (0.0, 0.0, 0.0))
