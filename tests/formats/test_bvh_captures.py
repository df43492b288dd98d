"""Real captures: their quirks load, and they come back from writing."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatWarning
from retime.formats import read, write
from retime.motion.motion import Motion


def load(path: Path) -> Motion:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        motion = read(path)
    assert isinstance(motion, Motion)
    return motion


@pytest.mark.parametrize(("name", "claimed", "there"), [("Boxing_Toes", 3069, 3070), ("bk_cut_single_01", 8800, 8960)])
def test_more_rows_than_claimed_are_kept(mocap: Path, name: str, claimed: int, there: int) -> None:
    with pytest.warns(FormatWarning, match=rf"Frames: {claimed} claimed, {there} there; kept all {there}"):
        motion = read(mocap / f"bvh-other/{name}.bvh")
    assert motion.n_frames == there


@pytest.mark.parametrize(
    ("name", "rate", "n_joints", "n_frames"),
    [
        ("bvh-other/dab", 30, 27, 339),
        ("bvh-other/makehuman_walk1", 24, 75, 14),
        ("bvh-other/test_freebvh", 30, 55, 69),
        ("bvh-other/test_mocapbank", 30, 19, 455),
        ("cmu-bvh/07_01", 120, 31, 317),
        ("cmu-bvh/49_02", 120, 31, 2086),
    ],
)
def test_a_capture_comes_back(mocap: Path, tmp_path: Path, name: str, rate: int, n_joints: int, n_frames: int) -> None:
    path = mocap / f"{name}.bvh"
    motion = load(path)
    assert (motion.rate, motion.skeleton.n_joints, motion.n_frames) == (rate, n_joints, n_frames)
    copy = tmp_path / "copy.bvh"
    write(motion, copy)
    again = load(copy)
    assert again.declaration == motion.declaration
    assert again.skeleton.names == motion.skeleton.names
    assert again.skeleton.parents == motion.skeleton.parents
    assert again.skeleton.end_sites == motion.skeleton.end_sites
    np.testing.assert_array_equal(again.skeleton.offsets, motion.skeleton.offsets)
    before, after = (np.array(p.read_bytes().split(b"Frame Time:")[1].split()[1:], dtype=float) for p in (path, copy))
    np.testing.assert_allclose(after, before, rtol=0, atol=1e-6)


def test_a_slower_capture_keeps_its_curves_continuous(mocap: Path, tmp_path: Path) -> None:
    """Sampled between its frames and written, a motion's angles stay within its own: no jumps by whole turns."""
    motion = load(mocap / "cmu-bvh/07_01.bvh")
    slower = motion.at(np.arange(2 * motion.n_frames - 1) / (2 * float(motion.rate)))
    write(slower, tmp_path / "slower.bvh")
    again = load(tmp_path / "slower.bvh")
    assert motion.declared_angles is not None
    assert again.declared_angles is not None
    middle = again.declared_angles[1::2]
    low = np.minimum(motion.declared_angles[:-1], motion.declared_angles[1:])
    high = np.maximum(motion.declared_angles[:-1], motion.declared_angles[1:])
    # The T-pose in front of the capture is far from its first frame: between the two, slerp and angles part ways.
    assert np.all((middle >= low - 0.02)[1:])
    assert np.all((middle <= high + 0.02)[1:])
