"""Frames in front of a capture are noticed, and nothing else is taken for one."""

from __future__ import annotations

import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import retime
from retime.errors import RetimeWarning
from retime.formats.registry import read
from retime.motion import rotation
from retime.motion.first_frames import frames_before_capture, hint_at_first_frames
from retime.motion.motion import Motion
from tests.motion.walkers import walker


def with_pose_in_front(motion: Motion, count: int = 1, share: float = 1.0) -> Motion:
    """Put `count` frames in front in which all joints are turned back, by a share, to where the skeleton rests."""
    rest = rotation.identity(1, motion.skeleton.n_joints)
    front = rotation.slerp(motion.rotations[:1], rest, np.full((1, 1), share)).repeat(count, axis=0)
    return replace(
        motion,
        rotations=np.concatenate([front, motion.rotations]),
        translations=np.concatenate([motion.local_translations[:1].repeat(count, axis=0), motion.local_translations]),
        declared_angles=None,
    )


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("rate", [12, 30, 120, 240])
def test_a_pose_in_front_is_counted(count: int, rate: int) -> None:
    walk = walker(200)
    motion = with_pose_in_front(replace(walk, rate=Fraction(rate)), count)
    assert frames_before_capture(motion) == count
    assert frames_before_capture(motion.frames(count, motion.n_frames)) == 0
    # More of them are a movement of their own.
    assert frames_before_capture(with_pose_in_front(walk, 4)) == 0


def test_with_names_options_and_places_it_is_told() -> None:
    motion = replace(with_pose_in_front(walker(60), 2), first_frame=1, name="walk")
    with pytest.warns(RetimeWarning, match=r"walk: the first 2 frames are probably no part .*a T-pose.*") as told:
        hint_at_first_frames(motion)
    text = str(told[0].message)
    assert "Leave them out: --drop-first 2 (in Python clip[2:]; in the editor use frames from 3)" in text
    with pytest.warns(RetimeWarning, match=r"--reference-frames 3: "):
        hint_at_first_frames(motion, reference=True)
    with pytest.warns(RetimeWarning, match="--drop-first 2"):
        retime.guided_warp(motion, length="90%")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        retime.guided_warp(motion[2:], length="90%")
        hint_at_first_frames(retime.Signal(("a",), [[0.0], [90.0], [90.0], [90.0], [90.0]]))


@given(st.integers(0, 2**32 - 1), st.floats(0, 40), st.integers(1, 6), st.integers(1, 12))
def test_a_motion_as_wild_all_through_has_none(seed: int, degrees: float, n_joints: int, n_frames: int) -> None:
    rng = np.random.default_rng(seed)
    skeleton = retime.Skeleton(
        tuple(f"j{i}" for i in range(n_joints)), tuple(range(-1, n_joints - 1)), np.zeros((n_joints, 3))
    )
    # Every step turns every joint by the same angle, about one axis or another.
    steps = rotation.about_axis(0, np.full(n_frames, np.radians(degrees)) * rng.choice([-1, 1], n_frames))
    q = [rotation.identity(n_joints)]
    for step in steps:
        q.append(rotation.multiply(q[-1], step))
    assert frames_before_capture(Motion(skeleton, np.array(q))) == 0


def test_one_joint_that_turns_over_is_none() -> None:
    motion = walker(60)
    q = motion.rotations.copy()
    q[0, 5] = rotation.multiply(q[0, 5], rotation.about_axis(0, np.array(np.pi)))
    assert frames_before_capture(replace(motion, rotations=q)) == 0


@pytest.mark.parametrize("n_frames", [1, 2, 3])
def test_a_few_frames_tell_nothing(n_frames: int) -> None:
    assert frames_before_capture(with_pose_in_front(walker(3)).frames(0, n_frames)) == 0


def test_captures_that_have_one(mocap: Path) -> None:
    counts = {}
    for path in sorted((mocap / "cmu-bvh").glob("*.bvh")):
        motion = read(path)
        assert isinstance(motion, Motion)
        counts[path.stem] = frames_before_capture(motion)
        assert frames_before_capture(motion.frames(counts[path.stem], motion.n_frames)) == 0, path
    # All of this conversion have, and one has two.
    assert counts == dict.fromkeys(counts, 1) | {"07_12": 2}
    assert len(counts) > 20


def test_and_captures_that_have_none(mocap: Path) -> None:
    paths = [*(mocap / "bvh-other").glob("*.bvh"), *(mocap / "cmu-asfamc").glob("*.amc")]
    assert len(paths) > 5
    for path in paths:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RetimeWarning)
            motion = read(path)
        assert isinstance(motion, Motion)
        assert frames_before_capture(motion) == 0, path
