"""A character's own mesh in FBX: where its points are, against a literal reading of clusters."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import retime
from retime.errors import FormatError
from retime.formats.curves.fbx.scene import parse_fbx
from retime.formats.read_options import Limits, ReadOptions
from retime.formats.registry import skin_of
from tests.formats.curves.fbx.files import LINEAR, Builder, node, track
from tests.formats.curves.gltf.test_skin import skinned_points

FBX = Path(__file__).resolve().parents[5] / "shared" / "mocap" / "fbx"
# A square, a triangle, and a face that is too small to be one.
FACES = [0, 1, 2, ~3, 4, 5, ~6, 1, ~2]


class SkinnedScene:
    """Three limbs in a chain, turned about one axis each, that a mesh of seven points follows."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self.scales = rng.uniform(0.5, 2.0, 3)
        self.offsets = rng.normal(size=(3, 3))
        self.angles = rng.uniform(-170, 170, (3, 2))
        self.points = rng.normal(size=(7, 3))
        self.geometric = rng.normal(size=3)
        self.matrices = np.repeat(np.eye(4)[None], 3, axis=0)
        self.matrices[:, :3] += 0.4 * rng.normal(size=(3, 3, 4))
        self.weights = rng.random((3, 7)) * (rng.random((3, 7)) < 0.6)
        # The last point follows nothing, all others at least one.
        self.weights[0] += 0.1
        self.weights[:, 6] = 0
        made = self.made = Builder()
        made.settings = [("UpAxis", ("I", 1)), ("TimeMode", ("I", 6)), ("UnitScaleFactor", ("D", 1.0))]
        corners = [node("Vertices", ("d", self.points.ravel())), node("PolygonVertexIndex", ("i", np.array(FACES)))]
        mesh = made.add("Geometry", "skin", "Geometry", "Mesh", inner=corners)
        body = made.model("body", 0, "Mesh", GeometricTranslation=self.geometric)
        made.link(mesh, body)
        limbs, parent = [], 0
        for offset, scale in zip(self.offsets, self.scales, strict=True):
            parent = made.model(f"limb {len(limbs)}", parent, Lcl_Translation=offset, Lcl_Scaling=np.full(3, scale))
            limbs.append(parent)
        skin = made.add("Deformer", "", "Deformer", "Skin")
        made.link(skin, mesh)
        self.clusters = []
        for limb, matrix, weights in zip(limbs, self.matrices, self.weights, strict=True):
            held = np.flatnonzero(weights)
            inner = [node("Indexes", ("i", held)), node("Weights", ("d", weights[held]))]
            inner.append(node("Transform", ("d", matrix.T.ravel())))
            cluster = made.add("Deformer", "", "SubDeformer", "Cluster", inner=inner)
            self.clusters.append(made.objects[-1])
            made.link(cluster, skin)
            made.link(limb, cluster)
        layer = made.layer(made.stack("take", 0.0, 1.0))
        for limb, angles in zip(limbs, self.angles, strict=True):
            made.animate(layer, limb, "Lcl Rotation", {"Z": track([0.0, 1.0], angles, LINEAR)})

    def literal(self, share: float) -> np.ndarray:
        """Where the points are at a share of the take: matrices of limbs multiplied out."""
        world, found = np.eye(4), np.zeros((7, 3))
        moved = np.concatenate([self.points + self.geometric, np.ones((7, 1))], axis=1)
        for limb in range(3):
            angle = np.radians((1 - share) * self.angles[limb, 0] + share * self.angles[limb, 1])
            local = np.eye(4)
            local[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
            local[:3, :3] *= self.scales[limb]
            local[:3, 3] = self.offsets[limb]
            world = world @ local
            found += self.weights[limb][:, None] * (moved @ (world @ self.matrices[limb]).T)[:, :3]
        return found[:6] / self.weights.sum(axis=0)[:6, None]


@pytest.mark.parametrize("seed", range(5))
def test_points_are_where_clusters_put_them(tmp_path, seed: int) -> None:
    scene = SkinnedScene(seed)
    path = tmp_path / "made.fbx"
    path.write_bytes(scene.made.binary(packed=bool(seed % 2)))
    skin, motion = skin_of(path, ReadOptions()), retime.read(path)
    assert skin is not None
    # The square is two triangles; the one with a point that follows nothing is left out.
    assert skin.triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    for frame in (0, 7, motion.n_frames - 1):
        expected = scene.literal(frame / (motion.n_frames - 1))
        np.testing.assert_allclose(skinned_points(skin, motion, frame)[:6], expected, atol=1e-4)


@pytest.mark.filterwarnings("ignore::retime.errors.FormatWarning")
@pytest.mark.parametrize("name", ["animation_with_skeleton.fbx", "maya_game_sausage_7500_binary_wiggle.fbx"])
def test_real_clusters_bring_the_mesh_to_one_place(name: str) -> None:
    """In real files each cluster's Transform is the mesh as its limb saw it when both were bound."""
    path = FBX / name
    if not path.is_file():
        pytest.skip(f"needs {path}")
    scene = parse_fbx(path, path.read_bytes(), Limits())
    clusters = [item for item in scene.items.values() if item.subtype == "Cluster"]
    bound = []
    for cluster in clusters:
        own, limb = (
            scene.file.array(cluster.record.child(part), "d").reshape(4, 4).T for part in ("Transform", "TransformLink")
        )
        bound.append(limb @ own)
    np.testing.assert_allclose(bound, np.broadcast_to(bound[0], (len(bound), 4, 4)), atol=1e-3 * np.abs(bound).max())
    skin, motion = skin_of(path, ReadOptions()), retime.read(path)
    assert skin is not None
    assert len(skin.joints) == len(clusters)
    points = skinned_points(skin, motion, 0)
    assert np.isfinite(points).all()


@pytest.mark.parametrize(
    ("part", "values", "says"),
    [
        ("Indexes", ("i", [0, 1, 2, 3, 4, 7]), "names a point that is none of 7"),
        ("Weights", ("d", [0.5]), "Weights must hold"),
        ("Transform", ("d", np.zeros(15)), "Transform must hold 16 numbers"),
        ("Transform", ("d", np.full(16, np.nan)), "beyond use"),
    ],
)
def test_a_damaged_cluster_is_refused(tmp_path, part: str, values: tuple, says: str) -> None:
    scene = SkinnedScene(3)
    cluster = scene.clusters[0][2]
    place = next(i for i, one in enumerate(cluster) if one[0] == part)
    cluster[place] = node(part, values)
    path = tmp_path / "damaged.fbx"
    path.write_bytes(scene.made.binary())
    with pytest.raises(FormatError, match=says):
        skin_of(path, ReadOptions())
    # The motion is what it was.
    assert retime.read(path).n_frames > 5
