"""What the page exports of files that hold more than a clip: the same file, retimed in place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from retime.errors import OptionError, RetimeWarning
from retime.formats import read
from retime.motion.signal import Signal
from retime.project.document import ClipFile, Document
from retime.project.export import export_motion
from retime.project.solve import DocumentSolver
from tests.formats.body_files import body, npz
from tests.formats.c3d_files import Capture
from tests.formats.curves.gltf.scenes import sliding_scene
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


def test_a_capture_stays_one(tmp_path: Path) -> None:
    points = np.zeros((60, 1, 4))
    points[:, 0, 0] = np.arange(60)
    path, out = tmp_path / "a.c3d", tmp_path / "b.c3d"
    path.write_bytes(Capture(rate=30.0, points=points, analog=np.arange(60.0)[:, None], analog_labels=["Fz"]).build())
    clip = ClipFile(str(path), first_frame=21, last_frame=51, fps="60")
    solution = DocumentSolver().solve(Document((clip,), method="linear", options={"length": "200%"}))
    export_motion(solution, 0, out, overwrite=False)
    markers, force = read(out), read(out, array="analog")
    assert isinstance(markers, Signal)
    assert isinstance(force, Signal)
    assert (markers.first_frame, markers.n_frames, markers.rate) == (21, 62, 60)
    end = float(solution.warp.output_end)
    assert markers.at([0.0, end / 2, end]).values[:, 0] == pytest.approx([20, 35, 50], abs=1e-4)
    assert force.names == ("Fz",)
    assert force.values[-1, 0] * 2 == pytest.approx(50, abs=1e-4)


def test_a_body_stays_one(tmp_path: Path) -> None:
    members = body(n_frames=60)
    path, out = tmp_path / "a.npz", tmp_path / "b.npz"
    path.write_bytes(npz(members))
    clip = ClipFile(str(path), first_frame=20, last_frame=50)
    solution = DocumentSolver().solve(Document((clip,), method="linear", options={"length": "200%"}))
    export_motion(solution, 0, out, overwrite=False)
    with np.load(out) as archive:
        assert np.array_equal(archive["betas"], members["betas"])
        assert archive["poses"].shape == (62, 156)
        np.testing.assert_allclose(archive["trans"][[0, -1]], members["trans"][[20, 50]])


def test_a_scene_that_begins_elsewhere_is_written_as_another_format(tmp_path: Path) -> None:
    path = tmp_path / "a.glb"
    path.write_bytes(sliding_scene().glb())
    clip = ClipFile(str(path))
    document = Document((clip, ClipFile(str(path), role="follow", offset="0.2s")), method="linear")
    with pytest.warns(RetimeWarning, match="its nearest frame is held for 0.2 s at the start"):
        solution = DocumentSolver().solve(document)
    with pytest.raises(OptionError, match=r"a\.glb begins at another moment .* write another format"):
        export_motion(solution, 1, tmp_path / "b.glb", overwrite=False)
    export_motion(solution, 0, tmp_path / "b.glb", overwrite=False)
    first, other = solution.sources.clips
    np.testing.assert_allclose(other.at([0.5]).local_translations, first.at([0.3]).local_translations, atol=1e-6)
