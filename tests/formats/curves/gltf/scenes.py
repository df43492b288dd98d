"""glTF scenes made by the tests: every interpolation, odd accessors, shared ones, and bytes that must stay."""

from __future__ import annotations

import base64
import json
import struct

import numpy as np

COMPONENTS = {"f4": 5126, "i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123}
TYPES = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class Scene:
    """A scene under construction: numbers go in by `accessor`, and come out as a GLB or a .gltf with a data URI."""

    def __init__(self) -> None:
        self.json: dict = {
            "asset": {"version": "2.0", "generator": "a test"},
            "nodes": [],
            "accessors": [],
            "bufferViews": [],
            "animations": [],
            "extras": {"kept": [1e0, "ü"]},
        }
        self.chunk = bytearray()

    def view(self, data: bytes, **more) -> int:
        self.chunk += b"\0" * (-len(self.chunk) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.chunk), "byteLength": len(data), **more})
        self.chunk += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, values, kind: str = "f4", **more) -> int:
        values = np.asarray(values, dtype=np.float64)
        rows = values.reshape(len(values), -1)
        stored = rows
        if kind != "f4":
            stored = np.rint(rows * np.iinfo(kind).max) if more.get("normalized") else np.rint(rows)
        data = stored.astype("<" + kind)
        item = {
            "bufferView": self.view(data.tobytes()),
            "componentType": COMPONENTS[kind],
            "count": len(rows),
            "type": TYPES[rows.shape[1]],
            **more,
        }
        if rows.shape[1] == 1 and kind == "f4":
            item |= {"min": [float(data.min())], "max": [float(data.max())]}
        self.json["accessors"].append(item)
        return len(self.json["accessors"]) - 1

    def node(self, **more) -> int:
        self.json["nodes"].append(more)
        return len(self.json["nodes"]) - 1

    def animation(self, name: str, tracks: list[tuple[int, str, int, int, str]]) -> None:
        """Add an animation of (node, path, times accessor, values accessor, interpolation)."""
        self.json["animations"].append(
            {
                "name": name,
                "channels": [
                    {"sampler": i, "target": {"node": node, "path": path}} for i, (node, path, *_) in enumerate(tracks)
                ],
                "samplers": [{"input": t, "output": v, "interpolation": kind} for _, _, t, v, kind in tracks],
            }
        )

    def glb(self) -> bytes:
        chunk = bytes(self.chunk) + b"\0" * (-len(self.chunk) % 4)
        text = json.dumps({**self.json, "buffers": [{"byteLength": len(self.chunk)}]}, ensure_ascii=False).encode()
        text += b" " * (-len(text) % 4)
        body = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(chunk), 0x004E4942) + chunk
        return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body

    def gltf(self) -> bytes:
        uri = "data:application/octet-stream;base64," + base64.b64encode(bytes(self.chunk)).decode()
        return json.dumps({**self.json, "buffers": [{"uri": uri, "byteLength": len(self.chunk)}]}, indent=1).encode()


def sliding_scene() -> Scene:
    """A node that slides along X by a unit a frame, for two seconds at 30 Hz."""
    scene = Scene()
    scene.node(name="a")
    places = np.stack([np.arange(61.0), np.zeros(61), np.zeros(61)], axis=1)
    times = scene.accessor(np.arange(61) / 30)
    scene.animation("x", [(0, "translation", times, scene.accessor(places), "LINEAR")])
    return scene


def unit_rows(rng: np.random.Generator, n: int) -> np.ndarray:
    rows = rng.normal(size=(n, 4))
    return rows / np.linalg.norm(rows, axis=1)[:, None]


def drawn_scene(seed: int, start: float = 0.0) -> Scene:
    """Three nodes in a chain, moved by every interpolation, beside bytes of a mesh that must not change."""
    rng = np.random.default_rng(seed)
    scene = Scene()
    mesh = scene.accessor(rng.normal(size=(7, 3)))
    scene.json["meshes"] = [{"primitives": [{"attributes": {"POSITION": mesh}}]}]
    for index in range(3):
        scene.node(name=f"bone {index}", **({"children": [index + 1]} if index < 2 else {"mesh": 0}))
    scene.json["scenes"] = [{"nodes": [0]}]

    def times(n: int) -> np.ndarray:
        return start + np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 0.6, n - 1))])

    shared, other = scene.accessor(times(6)), scene.accessor(times(4))
    tracks = [
        (0, "translation", shared, scene.accessor(rng.normal(size=(6, 3))), "LINEAR"),
        (0, "rotation", shared, scene.accessor(unit_rows(rng, 6)), "LINEAR"),
        (1, "rotation", other, scene.accessor(rng.normal(size=(12, 4))), "CUBICSPLINE"),
        (1, "translation", other, scene.accessor(rng.normal(size=(12, 3))), "CUBICSPLINE"),
        (2, "rotation", other, scene.accessor(unit_rows(rng, 4), "i2", normalized=True), "LINEAR"),
        (2, "scale", shared, scene.accessor(rng.uniform(1, 2, (6, 3))), "STEP"),
    ]
    scene.animation("take", tracks)
    scene.accessor(rng.normal(size=(5, 3)))  # What nothing uses may be used by what this reader does not know.
    return scene


def skinned_scene(seed: int, n_keys: int = 5) -> Scene:
    """Make a figure under a scaled and turned node; a joint that no key moves, and a mesh of two primitives."""
    rng = np.random.default_rng(seed)
    scene = Scene()

    def turned(**more) -> int:
        q = unit_rows(rng, 1)[0]
        return scene.node(rotation=[*map(float, np.roll(q, -1))], translation=[*map(float, rng.normal(size=3))], **more)

    scale = float(rng.uniform(0.01, 3))
    tip = turned(name="tip")
    lower = turned(name="lower", children=[tip], scale=[float(rng.uniform(0.5, 2))] * 3)
    upper = turned(name="upper", children=[lower])
    turned(name="above", children=[upper], scale=[scale] * 3)
    times = scene.accessor(np.arange(n_keys) / 30)
    tracks = [
        (node, "rotation", times, scene.accessor(np.roll(unit_rows(rng, n_keys), -1, axis=1)), "STEP")
        for node in (upper, lower)
    ]
    tracks.append((upper, "translation", times, scene.accessor(rng.normal(size=(n_keys, 3))), "LINEAR"))
    scene.animation("moves", tracks)
    members = [int(node) for node in rng.permutation([tip, lower, upper])]
    inverses = np.repeat(np.eye(4)[None], 3, axis=0)
    inverses[:, :3] += 0.3 * rng.normal(size=(3, 3, 4))
    scene.json["skins"] = [
        {"joints": members, "inverseBindMatrices": scene.accessor(inverses.transpose(0, 2, 1).reshape(3, 16))}
    ]
    primitives = []
    for n_points, indexed in ((7, True), (6, False)):
        weights = rng.random((n_points, 4)) * (rng.random((n_points, 4)) < 0.6)
        weights[:, 0] += 0.1
        weights /= weights.sum(axis=1, keepdims=True)
        attributes = {
            "POSITION": scene.accessor(rng.normal(size=(n_points, 3))),
            "JOINTS_0": scene.accessor(rng.integers(0, 3, (n_points, 4)), "u1"),
            "WEIGHTS_0": scene.accessor(weights),
        }
        indices = {"indices": scene.accessor(rng.integers(0, n_points, 9), "u2")} if indexed else {}
        primitives.append({"attributes": attributes, **indices})
    scene.json["meshes"] = [{"primitives": primitives}]
    scene.node(mesh=0, skin=0)
    return scene
