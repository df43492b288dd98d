"""Forward kinematics of BVH files against other programs: stored poses, and live on real captures."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatWarning
from retime.formats import read
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from tests.golden.make_golden_poses import DATA, FILES, POSES, make_poses, poses_by_bvhio, poses_by_pybvh

MOCAP = Path(__file__).resolve().parents[2] / "../shared/mocap"
CAPTURES = sorted(path for folder in ("bvh-other", "cmu-bvh") for path in (MOCAP / folder).glob("*.bvh"))
N_FRAMES = 9


def our_poses(path: Path) -> np.ndarray:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        motion = read(path)
    assert isinstance(motion, Motion)
    return global_poses(motion).positions


def tolerance(program: str, poses: np.ndarray) -> float:
    """How far two programs may differ: rounding, of double or of single precision along a chain of joints."""
    return float(np.abs(poses).max() + 1.0) * (1e-11 if program.startswith("pybvh") else 1e-6)


@pytest.mark.parametrize("name", FILES)
def test_stored_poses(name: str) -> None:
    entry = json.loads(POSES.read_text())[name]
    expected = np.array(entry["positions"])
    np.testing.assert_allclose(
        our_poses(DATA / f"{name}.bvh"), expected, rtol=0, atol=tolerance(entry["program"], expected)
    )


def test_stored_poses_are_what_the_programs_say() -> None:
    pytest.importorskip("pybvh")
    pytest.importorskip("bvhio")
    stored, made = json.loads(POSES.read_text()), make_poses()
    assert stored.keys() == made.keys()
    for name, entry in made.items():
        np.testing.assert_allclose(stored[name]["positions"], entry["positions"], atol=1e-6, err_msg=name)


def thin_out(path: Path, folder: Path) -> tuple[Path, np.ndarray]:
    """Copy a capture with a spread of its rows only, as bvhio takes seconds for each thousand; return which rows."""
    head, rows = path.read_bytes().split(b"Frame Time:")
    time, *rows = [row for row in rows.splitlines() if row.strip()]
    chosen = np.unique(np.linspace(0, len(rows) - 1, N_FRAMES).astype(int))
    head = head[: head.index(b"Frames:")] + b"Frames: %d\n" % len(chosen)
    copy = folder / path.name
    copy.write_bytes(head + b"Frame Time:" + time + b"\n" + b"".join(rows[i] + b"\n" for i in chosen))
    return copy, chosen


@pytest.mark.skipif(not CAPTURES, reason=f"needs the motion-capture files of {MOCAP}")
@pytest.mark.parametrize("path", CAPTURES, ids=lambda path: path.stem)
def test_captures(path: Path, tmp_path: Path) -> None:
    pytest.importorskip("pybvh")
    ours = our_poses(path)
    program, theirs = "pybvh", poses_by_pybvh(path)
    if theirs is None:
        # pybvh wants as many rows as are claimed.
        pytest.importorskip("bvhio")
        copy, chosen = thin_out(path, tmp_path)
        program, theirs, ours = "bvhio", poses_by_bvhio(copy, len(chosen)), ours[chosen]
    assert ours.shape == theirs.shape
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=tolerance(program, theirs))
