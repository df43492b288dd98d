"""The skins of a glTF scene: meshes that follow the joints of a clip that was read from it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from retime.arrays import FloatArray
from retime.formats.curves.gltf.animation import Animation
from retime.formats.curves.gltf.file import GltfFile
from retime.formats.curves.gltf.scene import Node, joint_nodes, read_nodes
from retime.formats.read_options import Limits
from retime.motion import rotation
from retime.motion.skin import MOST_POINTS, Skin, is_usable

_TRIANGLES = 4


def read_skin(file: GltfFile, animation: Animation, limits: Limits) -> Skin | None:
    """Read all meshes that follow the nodes which an animation moves, as one; None where there is none.

    Materials, morph targets and a point's influences beyond four are left out.

    Raises
    ------
    FormatError
        A mesh or a skin is damaged, compressed, or has more points than can be drawn.
    """
    nodes = read_nodes(file, limits)
    joints = joint_nodes(nodes, animation)
    if not joints:
        return None
    bones = _Bones(nodes, joints)
    with np.errstate(over="ignore", invalid="ignore"):
        # What is beyond use is refused below.
        parts = [
            part
            for item in file.items("nodes")
            if "mesh" in item and "skin" in item
            for part in _meshes(file, item, bones)
        ]
    if not parts:
        return None
    if not is_usable(*bones.matrices, *(part[0] for part in parts)):
        raise file.error("its skin holds a number that is beyond use")
    starts = np.cumsum([0, *(len(points) for points, *_ in parts[:-1])])
    if starts[-1] + len(parts[-1][0]) > MOST_POINTS:
        raise file.error(f"its meshes have more than {MOST_POINTS} points")
    points, triangles, follows, weights = (
        np.concatenate([part[i] + (start if i == 1 else 0) for part, start in zip(parts, starts, strict=True)])
        for i in range(4)
    )
    return Skin(
        points,
        triangles.astype(np.int32),
        np.stack(bones.matrices),
        np.array(bones.joints, dtype=np.int32),
        follows.astype(np.int32),
        weights,
    )


class _Bones:
    """Bones, each made once: a node that follows a joint, and how a mesh lies in it."""

    def __init__(self, nodes: list[Node], joints: list[int]) -> None:
        self._nodes = nodes
        self._place = {node: joint for joint, node in enumerate(joints)}
        self.matrices: list[FloatArray] = []
        self.joints: list[int] = []

    def add(self, node: int, inverse: FloatArray) -> int:
        """Return the bone of a node for a mesh that is brought into it by a matrix."""
        matrix = inverse
        # What no key moves is carried by the nearest node above it that one does.
        while node >= 0 and node not in self._place:
            matrix = _matrix(self._nodes[node]) @ matrix
            node = self._nodes[node].parent
        if node < 0 and -1 not in self._place:
            # What hangs elsewhere in the scene goes along with the root, as it stands beside it at rest.
            node = next(one for one, joint in self._place.items() if joint == 0)
            own = _matrix(self._nodes[node])
            matrix = (np.linalg.pinv(own) if is_usable(own) else np.full((4, 4), np.nan)) @ matrix
        joint = self._place[node]
        if node >= 0:
            # A joint turns and moves; what it scales is scaled beforehand, in the units that the motion has.
            matrix = np.diag([*self._nodes[node].scale, 1.0]) @ matrix * _scale_above(self._nodes, node)
        self.matrices.append(matrix[:3])
        self.joints.append(joint)
        return len(self.matrices) - 1


def _matrix(node: Node) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, :3] = rotation.to_matrix(node.rotation) * node.scale
    matrix[:3, 3] = node.translation
    return matrix


def _scale_above(nodes: list[Node], node: int) -> float:
    """How many units of the scene one unit of a node's parent is, as `sample_animation` counts it."""
    scale = 1.0
    while nodes[node].parent >= 0:
        node = nodes[node].parent
        scale *= float(np.cbrt(np.abs(np.prod(nodes[node].scale))))
    return scale


_Part = tuple[FloatArray, NDArray[np.int64], NDArray[np.int64], FloatArray]


def _meshes(file: GltfFile, item: dict[str, Any], bones: _Bones) -> list[_Part]:
    """Read the triangles of one node's mesh, with what their corners follow."""
    skin, mesh = file.item("skins", item["skin"]), file.item("meshes", item["mesh"])
    members, primitives = skin.get("joints"), mesh.get("primitives")
    if not isinstance(members, list) or not isinstance(primitives, list):
        raise file.error("a skin needs a list of joints, and a mesh one of primitives")
    for member in members:
        file.item("nodes", member)
    inverses = np.repeat(np.eye(4)[None], len(members), axis=0)
    if "inverseBindMatrices" in skin:
        # Written column by column.
        found = file.accessor(skin["inverseBindMatrices"])
        if found.shape[1:] != (16,) or len(found) < len(members):
            raise file.error(f"a skin of {len(members)} joints needs as many matrices")
        inverses = found[: len(members)].reshape(-1, 4, 4).transpose(0, 2, 1)
    own = np.array([bones.add(node, inverse) for node, inverse in zip(members, inverses, strict=True)], dtype=np.int64)
    return [part for one in primitives if (part := _primitive(file, one, own)) is not None]


def _primitive(file: GltfFile, primitive: object, own: NDArray[np.int64]) -> _Part | None:
    attributes = primitive.get("attributes") if isinstance(primitive, dict) else None
    if not isinstance(primitive, dict) or not isinstance(attributes, dict):
        raise file.error("a primitive needs its attributes")
    names = ("POSITION", "JOINTS_0", "WEIGHTS_0")
    if primitive.get("mode", _TRIANGLES) != _TRIANGLES or any(name not in attributes for name in names):
        return None
    points, follows, weights = (file.accessor(attributes[name]) for name in names)
    n_points = len(points)
    if points.shape[1] != 3 or follows.shape != (n_points, 4) or weights.shape != (n_points, 4):
        raise file.error("the points of a mesh, their joints and their weights do not belong together")
    if n_points > MOST_POINTS:
        raise file.error(f"a mesh has more than {MOST_POINTS} points")
    # What has no weight may name any joint.
    weights = np.maximum(weights, 0.0)
    members = np.where(weights > 0, follows, 0).astype(np.int64)
    total = weights.sum(axis=1)
    if len(own) == 0 or members.min(initial=0) < 0 or members.max(initial=0) >= len(own) or not (total > 0).all():
        raise file.error("a point of a mesh follows no joint of its skin")
    corners = file.accessor(primitive["indices"]).ravel() if "indices" in primitive else np.arange(n_points)
    corners = corners[: len(corners) // 3 * 3].astype(np.int64)
    if corners.min(initial=0) < 0 or corners.max(initial=0) >= n_points:
        raise file.error(f"a triangle has a corner that is none of {n_points} points")
    return points, corners.reshape(-1, 3), own[members], weights / total[:, None]
