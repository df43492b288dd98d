"""How a scene may store the numbers of its curves, and what else than nodes they may move."""

from __future__ import annotations

import json
import struct
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

from retime.errors import RetimeWarning
from retime.formats import read
from retime.formats.curves.gltf.animation import read_animation
from retime.formats.curves.gltf.file import parse_gltf
from retime.formats.in_place import retime_file
from retime.formats.read_options import Limits, ReadOptions
from retime.formats.registry import facts_of
from retime.motion.motion import Motion
from retime.warp.curve import Warp
from tests.formats.curves.gltf.scenes import Scene, sliding_scene
from tests.reference.gltf import Scene as Literal

# Faster, still, backward.
WARP = Warp([0.0, 0.5, 0.75, 1.5], [0.0, 1.5, 1.5, 0.0])
MOMENTS = [0.0, 0.1, 0.25, 0.49, 0.6, 0.9, 1.3, 1.5]


def retimed(scene: Scene, folder: Path, *, binary: bool = True) -> tuple[Path, Path]:
    suffix = ".glb" if binary else ".gltf"
    old, new = folder / f"old{suffix}", folder / f"new{suffix}"
    old.write_bytes(scene.glb() if binary else scene.gltf())
    retime_file(old, new, WARP, tolerance=1e-9)
    return old, new


def json_of(path: Path) -> dict:
    data = path.read_bytes()
    return json.loads(data[20 : 20 + struct.unpack_from("<I", data, 12)[0]] if data[:4] == b"glTF" else data)


def sparse(scene: Scene, values: np.ndarray, places: list[int], *, base: np.ndarray | None, kind: str = "u2") -> int:
    """Add an accessor whose values at some places stand elsewhere; without a base the others are 0."""
    item = {
        "componentType": 5126,
        "count": len(values),
        "type": {1: "SCALAR", 3: "VEC3", 4: "VEC4"}[values.shape[1]],
        "sparse": {
            "count": len(places),
            "indices": {
                "bufferView": scene.view(np.array(places).astype("<" + kind).tobytes()),
                "componentType": {"u1": 5121, "u2": 5123, "u4": 5125}[kind],
            },
            "values": {"bufferView": scene.view(values[places].astype("<f4").tobytes())},
        },
    }
    if base is not None:
        item["bufferView"] = scene.view(base.astype("<f4").tobytes())
    scene.json["accessors"].append(item)
    return len(scene.json["accessors"]) - 1


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize(("kind", "with_base"), [("u1", True), ("u2", False), ("u4", True), ("u4", False)])
def test_sparse_values(tmp_path: Path, kind: str, with_base: bool, binary: bool) -> None:
    rng = np.random.default_rng(3)
    values = np.zeros((7, 3))
    base = rng.normal(size=(7, 3)) if with_base else None
    if base is not None:
        values[:] = base
    places = [1, 4, 6]
    values[places] = rng.normal(size=(3, 3))
    scene = Scene()
    scene.node(name="a")
    times = scene.accessor(np.arange(7) / 4)
    output = sparse(scene, values, places, base=base, kind=kind)
    scene.animation("x", [(0, "translation", times, output, "LINEAR")])
    old, new = retimed(scene, tmp_path, binary=binary)
    motion = read(old)
    assert isinstance(motion, Motion)
    np.testing.assert_allclose(motion.at(np.arange(7) / 4).local_translations[:, 0], values, atol=1e-6)
    literal = Literal(new)
    for moment in MOMENTS:
        time = float(WARP(moment))
        expected = [np.interp(time, np.arange(7) / 4, values[:, axis]) for axis in range(3)]
        assert literal.value(0, 0, moment) == pytest.approx(expected, abs=1e-5)
    # What is written is an accessor like others, and the old one is gone.
    assert all("sparse" not in item for item in json_of(new)["accessors"])


def test_sparse_times(tmp_path: Path) -> None:
    scene = Scene()
    scene.node(name="a")
    exact = np.array([[0.0], [0.5], [1.0], [1.5]])
    times = sparse(scene, exact, [1, 2, 3], base=None)
    scene.json["accessors"][times] |= {"min": [0.0], "max": [1.5]}
    scene.animation("x", [(0, "translation", times, scene.accessor(np.eye(4)[:, :3]), "LINEAR")])
    _, new = retimed(scene, tmp_path)
    assert Literal(new).value(0, 0, 1 / 6) == pytest.approx([0, 1, 0], abs=1e-5)
    sampler = json_of(new)["animations"][0]["samplers"][0]
    written = [row[0] for row in Literal(new).accessor(sampler["input"])]
    item = json_of(new)["accessors"][sampler["input"]]
    assert (item["min"], item["max"]) == ([min(written)], [max(written)])


@pytest.mark.parametrize(("kind", "step"), [("u1", 1 / 255), ("u2", 1 / 65535), ("i2", 1 / 32767)])
@pytest.mark.parametrize("path", ["weights", "rotation"])
def test_normalised_values(tmp_path: Path, kind: str, step: float, path: str) -> None:
    rng = np.random.default_rng(5)
    scene = Scene()
    scene.node(name="a")
    times = scene.accessor(np.arange(4) / 2)
    values = rng.uniform(0, 1, (4, 4))
    if path == "rotation":
        values /= np.linalg.norm(values, axis=1)[:, None]
        output = scene.accessor(values, kind, normalized=True)
    else:
        output = scene.accessor(values.reshape(-1, 1), kind, normalized=True)
    scene.animation("x", [(0, path, times, output, "LINEAR")])
    old, new = retimed(scene, tmp_path)
    before, after = Literal(old), Literal(new)
    for moment in MOMENTS:
        expected, found = before.value(0, 0, float(WARP(moment))), after.value(0, 0, moment)
        if path == "rotation":
            # In few bits its length is not quite 1.
            expected, found = (np.divide(one, np.linalg.norm(one)).tolist() for one in (expected, found))
        # What was stored in few bits is as it was; what lies between is kept in more.
        assert found == pytest.approx(expected, abs=1e-5)
    assert before.value(0, 0, 0.5) == pytest.approx(values[1].tolist(), abs=step)


def test_one_accessor_of_times_serves_several_animations(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    scene = Scene()
    scene.node(name="a")
    scene.node(name="b")
    times = scene.accessor(np.arange(5) / 2)
    outputs = [scene.accessor(rng.normal(size=(5, 3))) for _ in range(3)]
    scene.animation("one", [(0, "translation", times, outputs[0], "LINEAR"), (1, "scale", times, outputs[1], "STEP")])
    scene.animation("two", [(0, "translation", times, outputs[2], "LINEAR")])
    old, both = retimed(scene, tmp_path)
    alone = tmp_path / "alone.glb"
    retime_file(old, alone, WARP, animation="two", tolerance=1e-9)
    before = Literal(old)
    for moment in MOMENTS:
        time = float(WARP(moment))
        for animation, channel in ((0, 0), (0, 1), (1, 0)):
            if channel and moment in (0.25, 0.5):
                continue
            assert Literal(both).value(animation, channel, moment) == pytest.approx(
                before.value(animation, channel, time), abs=1e-5
            )
            expected = time if animation else moment
            assert Literal(alone).value(animation, channel, moment) == pytest.approx(
                before.value(animation, channel, expected), abs=1e-5
            )


def test_pointers_are_carried_along_and_retimed(tmp_path: Path) -> None:
    """KHR_animation_pointer: a colour, a lens, a light and a node's turn, beside a node's place."""
    scene = sliding_scene()
    scene.json["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}, "name": "paint"}]
    scene.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]
    scene.json["extensionsUsed"] = ["KHR_animation_pointer"]
    times = scene.accessor(np.arange(4) / 2)
    colours = np.array([[1, 0, 0, 1], [0, 1, 0, 1], [0, 0, 1, 1], [1, 1, 1, 0.5]], dtype=np.float64)
    turns = np.array([[0, 0, np.sin(a / 2), np.cos(a / 2)] for a in (0.0, 1.0, 2.5, 3.0)])
    tracks = {
        "/materials/0/pbrMetallicRoughness/baseColorFactor": (scene.accessor(colours), "LINEAR"),
        "/cameras/0/perspective/yfov": (scene.accessor(np.arange(12.0).reshape(12, 1) / 10), "CUBICSPLINE"),
        "/nodes/0/rotation": (scene.accessor(turns), "LINEAR"),
    }
    animation = scene.json["animations"][0]
    for pointer, (output, kind) in tracks.items():
        extension = {"KHR_animation_pointer": {"pointer": pointer, "extras": {"ours": True}}}
        target = {"path": "pointer", "extensions": extension}
        animation["channels"].append({"sampler": len(animation["samplers"]), "target": target})
        animation["samplers"].append({"input": times, "output": output, "interpolation": kind})
    old, new = retimed(scene, tmp_path)
    assert json_of(new)["animations"][0]["channels"] == animation["channels"]
    for name in ("materials", "cameras", "nodes", "extensionsUsed", "extras"):
        assert json_of(new)[name] == scene.json[name]
    before, after = Literal(old), Literal(new)
    for moment in MOMENTS:
        time = float(WARP(moment))
        for channel in (0, 1, 2):
            expected = before.value(0, channel, time)
            assert after.value(0, channel, moment) == pytest.approx(expected, abs=2e-4), (channel, moment)
        # A pointer to a rotation turns evenly, as a rotation does: by the angle about Z.
        angle = np.interp(time, np.arange(4) / 2, (0.0, 1.0, 2.5, 3.0))
        curve = read_animation(parse_gltf(new, new.read_bytes(), Limits()), 0).samplers[3].curve
        shown = curve(np.array([moment]))[0]
        assert shown == pytest.approx([0, 0, np.sin(angle / 2), np.cos(angle / 2)], abs=1e-4)
    # For the search the node is what moves.
    motion = read(new)
    assert isinstance(motion, Motion)
    assert motion.skeleton.names == ("a",)


@pytest.mark.parametrize("bake", [False, True])
def test_a_text_scene_keeps_its_numbers_in_its_text(tmp_path: Path, bake: bool) -> None:
    scene = sliding_scene()
    old, new = tmp_path / "old.gltf", tmp_path / "new.gltf"
    old.write_bytes(scene.gltf())
    with pytest.warns(RetimeWarning, match="the rest of it is left out") if bake else nullcontext():
        retime_file(old, new, WARP, bake=bake)
    # One file, and no other beside it; numbers in its text, as they were.
    assert sorted(path.name for path in tmp_path.iterdir()) == ["new.gltf", "old.gltf"]
    assert all(one["uri"].startswith("data:") for one in json_of(new)["buffers"])
    before, after = Literal(old), Literal(new)
    for moment in (0.0, 0.3, 0.6, 0.9, 1.2, 1.5):
        slack = 1.5 if bake else 1e-3
        assert after.value(0, 0, moment) == pytest.approx(before.value(0, 0, float(WARP(moment))), abs=slack)


def test_what_a_scene_tells(tmp_path: Path) -> None:
    scene = sliding_scene()
    times = scene.accessor(np.arange(4) / 2)
    scene.animation("turn", [(0, "scale", times, scene.accessor(np.ones((4, 3))), "STEP")])
    path = tmp_path / "a.glb"
    path.write_bytes(scene.glb())
    assert facts_of(path, ReadOptions()) == {
        "animations": "2: x (2.000 s, 61 keys, LINEAR: translation), turn (1.500 s, 4 keys, STEP: scale)",
        "scene": "1 nodes, 0 meshes, 0 skins, 0 cameras",
    }
