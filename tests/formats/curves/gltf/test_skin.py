"""A character's own mesh: where its points are, against a literal reading of the glTF rules."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import retime
from retime.errors import FormatError
from retime.formats.curves.gltf.animation import read_animation
from retime.formats.curves.gltf.file import parse_gltf
from retime.formats.read_options import Limits, ReadOptions
from retime.formats.registry import skin_of
from retime.motion import rotation
from retime.motion.kinematics import global_poses
from tests.formats.curves.gltf.scenes import skinned_scene

GLTF = Path(__file__).resolve().parents[5] / "shared" / "mocap" / "gltf"


def literal_points(path: Path, time: float) -> np.ndarray:
    """Where glTF puts the points of all skinned meshes: each matrix multiplied out, node by node."""
    file = parse_gltf(path, path.read_bytes(), Limits())
    animation = read_animation(file, 0)
    nodes = file.items("nodes")
    parts = [
        {
            "translation": np.array(node.get("translation", [0.0] * 3)),
            "rotation": np.array(node.get("rotation", [0.0, 0, 0, 1])),
            "scale": np.array(node.get("scale", [1.0] * 3)),
        }
        for node in nodes
    ]
    for channel in animation.channels:
        if channel.path in parts[0]:
            parts[channel.node][channel.path] = animation.samplers[channel.sampler].curve(
                np.array([animation.start + time])
            )[0]
    parents = {child: i for i, node in enumerate(nodes) for child in node.get("children", [])}

    def world(i: int) -> np.ndarray:
        matrix = np.eye(4)
        if "matrix" in nodes[i]:
            matrix = np.array(nodes[i]["matrix"]).reshape(4, 4).T
        else:
            turn = rotation.to_matrix(rotation.normalize(np.roll(parts[i]["rotation"], 1)))
            matrix[:3, :3] = turn * parts[i]["scale"]
            matrix[:3, 3] = parts[i]["translation"]
        return world(parents[i]) @ matrix if i in parents else matrix

    found = []
    for node in nodes:
        if "mesh" not in node or "skin" not in node:
            continue
        skin = file.item("skins", node["skin"])
        inverses = file.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
        matrices = np.stack([world(joint) @ inverses[k] for k, joint in enumerate(skin["joints"])])
        for primitive in file.item("meshes", node["mesh"])["primitives"]:
            attributes = primitive["attributes"]
            points = file.accessor(attributes["POSITION"])
            follows = file.accessor(attributes["JOINTS_0"]).astype(int)
            weights = file.accessor(attributes["WEIGHTS_0"])
            weights = weights / weights.sum(axis=1, keepdims=True)
            homogeneous = np.concatenate([points, np.ones((len(points), 1))], axis=1)
            moved = np.einsum("pkij,pj->pki", matrices[follows], homogeneous)[..., :3]
            found.append((weights[..., None] * moved).sum(axis=1))
    return np.concatenate(found)


def skinned_points(skin, motion, frame: int) -> np.ndarray:
    """Where a skin puts them, as `Skin` says."""
    poses = global_poses(motion)
    local = np.einsum("pkij,pj->pki", skin.bones[skin.follows][..., :3], skin.points) + skin.bones[skin.follows][..., 3]
    joints = skin.joints[skin.follows]
    turned = np.einsum("pkij,pkj->pki", rotation.to_matrix(poses.rotations[frame][joints]), local)
    return ((turned + poses.positions[frame][joints]) * skin.weights[..., None]).sum(axis=1)


@pytest.mark.parametrize("seed", range(6))
def test_points_are_where_gltf_puts_them(tmp_path, seed: int) -> None:
    path = tmp_path / "made.glb"
    path.write_bytes(skinned_scene(seed).glb())
    skin, motion = skin_of(path, ReadOptions()), retime.read(path)
    assert skin is not None
    assert (len(skin.points), len(skin.triangles)) == (13, 5)
    for frame in (0, 3):
        expected = literal_points(path, frame / float(motion.rate))
        size = max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(skinned_points(skin, motion, frame), expected, atol=1e-5 * size)


@pytest.mark.filterwarnings("ignore:.* animations .*:retime.errors.FormatWarning")
@pytest.mark.parametrize("name", ["Fox.glb", "CesiumMan.glb"])
def test_points_of_real_characters_are_where_gltf_puts_them(name: str) -> None:
    path = GLTF / name
    if not path.is_file():
        pytest.skip(f"needs {path}")
    skin, motion = skin_of(path, ReadOptions()), retime.read(path)
    assert skin is not None
    for frame in (0, motion.n_frames // 2):
        expected = literal_points(path, frame / float(motion.rate))
        height = np.ptp(expected, axis=0).max()
        np.testing.assert_allclose(skinned_points(skin, motion, frame), expected, atol=2e-3 * height)


@pytest.mark.parametrize("seed", range(4))
def test_a_skin_of_a_body_alone_leaves_out_what_follows_other_joints(tmp_path, seed: int) -> None:
    path = tmp_path / "made.glb"
    path.write_bytes(skinned_scene(seed).glb())
    skin = skin_of(path, ReadOptions())
    everything = skin.kept(list(range(1 + skin.joints.max())))
    np.testing.assert_array_equal(everything.joints, skin.joints)
    np.testing.assert_array_equal(everything.triangles, skin.triangles)
    for joint in sorted(set(skin.joints.tolist())):
        expected = [
            triangle
            for triangle in skin.triangles.tolist()
            if all(
                weight == 0 or skin.joints[bone] == joint
                for point in triangle
                for bone, weight in zip(skin.follows[point], skin.weights[point], strict=True)
            )
        ]
        kept = skin.kept([joint])
        assert ([] if kept is None else kept.triangles.tolist()) == expected
        assert kept is None or set(kept.joints.tolist()) == {0}
    assert skin.kept([]) is None


@pytest.mark.parametrize(
    ("damage", "says"),
    [
        (lambda json: json["skins"][0]["joints"].append(99), "expected the index of one of"),
        (lambda json: json["skins"][0].pop("inverseBindMatrices") and json["skins"][0].update(joints=[]), "follows no"),
        (lambda json: json["skins"][0].update(inverseBindMatrices=0), "needs as many matrices"),
        (lambda json: json["meshes"][0]["primitives"][0]["attributes"].update(JOINTS_0=0), "do not belong together"),
        (lambda json: json["meshes"][0].update(primitives={}), "one of primitives"),
        (lambda json: json["meshes"][0]["primitives"][0].pop("attributes"), "needs its attributes"),
        (lambda json: json["accessors"][-2].pop("bufferView"), "names no bufferView"),
    ],
)
def test_a_damaged_skin_is_refused(tmp_path, damage, says: str) -> None:
    scene = skinned_scene(2)
    damage(scene.json)
    path = tmp_path / "damaged.glb"
    path.write_bytes(scene.glb())
    with pytest.raises(FormatError, match=says):
        skin_of(path, ReadOptions())
    # The motion is what it was.
    assert retime.read(path).n_frames == 5


def test_what_has_no_skin_has_none(tmp_path) -> None:
    scene = skinned_scene(3)
    scene.json["nodes"][-1].pop("skin")
    path = tmp_path / "rigid.glb"
    path.write_bytes(scene.glb())
    assert skin_of(path, ReadOptions()) is None
    retime.write(retime.sample().frames(0, 20), tmp_path / "walk.bvh")
    assert skin_of(tmp_path / "walk.bvh", ReadOptions()) is None


@pytest.mark.parametrize("place", ["scale", "translation"])
def test_numbers_beyond_use_are_refused_without_a_word_from_numpy(tmp_path, place: str) -> None:
    scene = skinned_scene(2)
    for node in scene.json["nodes"]:
        if node.get("name") in ("tip", "lower"):
            node[place] = [1e300, 1e300, 1e300]
    path = tmp_path / "huge.glb"
    path.write_bytes(scene.glb())
    with pytest.raises(FormatError, match="beyond use"):
        skin_of(path, ReadOptions())
