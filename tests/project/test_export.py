"""What the page exports of a scene whose animation is curves: the scene, its keys retimed."""

from __future__ import annotations

from pathlib import Path

import pytest

from retime.project.document import ClipFile, Document
from retime.project.export import export_motion
from retime.project.solve import DocumentSolver
from tests.formats.curves.scenes import sliding_scene
from tests.reference.gltf import Scene as Literal


def test_a_scene_stays_one(tmp_path: Path) -> None:
    scene = sliding_scene()
    path, out = tmp_path / "a.glb", tmp_path / "b.glb"
    path.write_bytes(scene.glb())
    document = Document(
        (ClipFile(str(path), first_frame=20, last_frame=50),), method="linear", options={"length": "200%"}
    )
    solution = DocumentSolver().solve(document)
    export_motion(solution, 0, out, overwrite=False)
    literal = Literal(out)
    assert literal.json["nodes"] == scene.json["nodes"]
    end = float(solution.warp.output_end)
    assert [literal.value(0, 0, t)[0] for t in (0.0, end / 2, end)] == pytest.approx([20, 35, 50], abs=1e-4)
