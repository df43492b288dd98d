"""Motions whose joints don't stand as a file's braces would have them: every writer finds each joint by its parents."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatWarning
from retime.formats.registry import read, write
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from tests.motion.walkers import permuted, renamed, walker
from tests.warp.rigs import orders


def ways(motion: Motion) -> list[tuple[str, ...]]:
    """The names from the root to each joint."""
    found: list[tuple[str, ...]] = []
    for name, parent in zip(motion.skeleton.names, motion.skeleton.parents, strict=True):
        found.append((*(found[parent] if parent >= 0 else ()), name))
    return found


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("ending", [".bvh", ".amc"])
def test_a_motion_in_any_order_of_joints_comes_back(tmp_path: Path, ending: str, seed: int) -> None:
    motion = permuted(walker(12), orders(walker(1).skeleton, seed))
    write(motion, tmp_path / f"walk{ending}")
    again = read(tmp_path / f"walk{ending}")
    assert isinstance(again, Motion)
    here, there = global_poses(motion).positions, global_poses(again).positions
    np.testing.assert_allclose(there[:, 0], here[:, 0], rtol=0, atol=1e-6)
    # An ASF has helpers beside the joints, and calls its root so.
    assert set(motion.skeleton.names[1:]) <= set(again.skeleton.names)
    for joint, name in enumerate(motion.skeleton.names[1:], start=1):
        np.testing.assert_allclose(there[:, again.skeleton.index(name)], here[:, joint], rtol=0, atol=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_names_that_repeat_are_told_apart_by_their_parents(tmp_path: Path, seed: int) -> None:
    # Each limb's joints are called alike, whatever limb it is.
    alike = {
        side + name: other
        for side in ("Left", "Right")
        for name, other in {"Leg": "mid", "ForeArm": "mid", "Foot": "end", "Hand": "end"}.items()
    }
    motion = permuted(renamed(walker(12), alike), orders(walker(1).skeleton, seed))
    write(motion, tmp_path / "walk.bvh")
    again = read(tmp_path / "walk.bvh")
    assert isinstance(again, Motion)
    here, there = global_poses(motion).positions, global_poses(again).positions
    assert sorted(ways(again)) == sorted(ways(motion))
    for joint, way in enumerate(ways(motion)):
        np.testing.assert_allclose(there[:, ways(again).index(way)], here[:, joint], rtol=0, atol=1e-6)
    with warnings.catch_warnings():
        # An ASF can't hold a name twice, which is said.
        warnings.simplefilter("ignore", FormatWarning)
        write(motion, tmp_path / "walk.amc")
        again = read(tmp_path / "walk.amc")
    assert isinstance(again, Motion)
    places = global_poses(again).positions
    for joint in range(motion.skeleton.n_joints):
        nearest = np.abs(places - here[:, joint : joint + 1]).max(axis=(0, 2)).min()
        assert nearest < 1e-6
