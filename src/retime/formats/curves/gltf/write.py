"""A motion as a GLB or a .gltf: its joints as nodes of a plain skeleton, one animation, a key on every frame."""

from __future__ import annotations

import base64
import json
from typing import Any

import numpy as np
from numpy.typing import NDArray

from retime.errors import FormatError
from retime.formats.curves.gltf.file import FLOAT, build_glb
from retime.motion.motion import Motion

# A quarter turn about X, xyzw: it brings Z to where glTF has Y.
_Z_TO_Y = [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]


class _Chunk:
    """The buffer under construction, and its accessors."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, values: NDArray[np.float64], kind: str, *, limits: bool = False) -> int:
        rows = np.ascontiguousarray(values, dtype="<f4").reshape(len(values), -1)
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": rows.nbytes})
        self.data += rows.tobytes()
        item = {"bufferView": len(self.views) - 1, "componentType": FLOAT, "count": len(rows), "type": kind}
        if limits:
            item |= {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        self.accessors.append(item)
        return len(self.accessors) - 1


def glb_of(motion: Motion) -> bytes:
    """Make a GLB of a motion, as `scene_of` says; raise FormatError."""
    document, numbers = scene_of(motion)
    document["buffers"] = [{"byteLength": len(numbers)}]
    return build_glb(json.dumps(document, separators=(",", ":"), ensure_ascii=False), numbers, b"")


def gltf_of(motion: Motion) -> bytes:
    """Make a .gltf of a motion, its numbers in its text, as `scene_of` says; raise FormatError."""
    document, numbers = scene_of(motion)
    uri = "data:application/octet-stream;base64," + base64.b64encode(numbers).decode()
    document["buffers"] = [{"byteLength": len(numbers), "uri": uri}]
    return json.dumps(document, indent=1, ensure_ascii=False).encode()


def scene_of(motion: Motion) -> tuple[dict[str, Any], bytes]:
    """Make a scene of a motion: its JSON but for the buffer, and the buffer.

    Lengths are in metres, where the motion says how long its unit is; else they stay as they are. What has Z up is laid
    under a node that turns it. The skeleton is a skin without a mesh, so that programs take the joints for bones.

    Raises
    ------
    FormatError
        A number is beyond single precision.
    """
    skeleton, unit = motion.skeleton, motion.metres_per_unit or 1.0
    translations = motion.local_translations * unit
    offsets = skeleton.offsets * unit
    if max(float(np.abs(translations).max()), float(np.abs(offsets).max())) > 1e30:
        raise FormatError("a length is beyond what single precision, which glTF has, can hold")
    nodes: list[dict[str, Any]] = [
        {"name": name, "translation": offset.tolist()} for name, offset in zip(skeleton.names, offsets, strict=True)
    ]
    for joint, node in enumerate(nodes):
        children = list(skeleton.children(joint))
        if children:
            node["children"] = children
    for site in skeleton.end_sites:
        end = [float(part) * unit for part in site.offset]
        nodes.append({"name": f"{skeleton.names[site.parent]}_end", "translation": end})
        nodes[site.parent].setdefault("children", []).append(len(nodes) - 1)
    root = 0
    if motion.up == "z":
        nodes.append({"name": "Z_UP", "rotation": _Z_TO_Y, "children": [0]})
        root = len(nodes) - 1

    chunk = _Chunk()
    rest = np.zeros_like(offsets)
    for joint, parent in enumerate(skeleton.parents):
        rest[joint] = offsets[joint] + (rest[parent] if parent >= 0 else 0.0)
    # glTF lays matrices out column by column.
    inverse = np.tile(np.eye(4), (skeleton.n_joints, 1, 1))
    inverse[:, 3, :3] = -rest
    skin = {"joints": list(range(skeleton.n_joints)), "inverseBindMatrices": chunk.add(inverse, "MAT4"), "skeleton": 0}
    times = chunk.add(np.arange(motion.n_frames) / float(motion.rate), "SCALAR", limits=True)
    channels: list[dict[str, Any]] = []
    samplers: list[dict[str, Any]] = []

    def animate(joint: int, path: str, values: NDArray[np.float64], kind: str) -> None:
        channels.append({"sampler": len(samplers), "target": {"node": joint, "path": path}})
        samplers.append({"input": times, "output": chunk.add(values, kind), "interpolation": "LINEAR"})

    for joint in range(skeleton.n_joints):
        animate(joint, "rotation", np.roll(motion.rotations[:, joint], -1, axis=1), "VEC4")
        if (translations[:, joint] != offsets[joint]).any():
            animate(joint, "translation", translations[:, joint], "VEC3")
    document = {
        "asset": {"version": "2.0", "generator": "retime"},
        "scene": 0,
        "scenes": [{"nodes": [root]}],
        "nodes": nodes,
        "skins": [skin],
        "animations": [{"name": motion.name or "motion", "channels": channels, "samplers": samplers}],
        "accessors": chunk.accessors,
        "bufferViews": chunk.views,
    }
    return document, bytes(chunk.data)
