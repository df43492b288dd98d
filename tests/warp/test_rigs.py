"""Skeletons as files have them: joints in any order, in any tree, with feet anywhere."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from retime.motion.contacts import Contacts, Foot
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion
from retime.motion.skeleton import Skeleton
from retime.warp.apply import apply_warp, retimed_slip
from retime.warp.curve import Warp, output_frame_times
from tests.reference import contacts as literal
from tests.reference.averaging import averaged_pose
from tests.warp.motions import wandering_motion
from tests.warp.rigs import contacts_of, moving_rigs, warps_of


def assert_is_the_definition(result: Motion, motion: Motion, warp: Warp, standing: Contacts | None, **how) -> None:
    times = output_frame_times(warp, float(motion.rate))
    assert result.n_frames == len(times)
    found = global_poses(result).rotations
    for frame, time in enumerate(times.tolist()):
        turns, translations = averaged_pose(motion, warp, time, standing, **how)
        wanted = Rotation.concatenate(turns)
        apart = (Rotation.from_quat(found[frame], scalar_first=True).inv() * wanted).magnitude()
        assert apart.max() < 1e-7
        np.testing.assert_allclose(result.local_translations[frame], translations, rtol=0, atol=1e-9)


# Name, parent. Feet are not the last joints, as in rigs with toe tips or twist bones.
RIG = {"Hips": "", "Spine": "Hips", "Hand": "Spine", "Leg": "Hips", "Foot": "Leg", "Toe": "Foot", "Tip": "Toe"}


@pytest.mark.parametrize(
    "order",
    [
        pytest.param("Hips Leg Foot Toe Tip Spine Hand", id="leg_first"),
        pytest.param("Hips Spine Hand Leg Foot Toe Tip", id="spine_first"),
        pytest.param("Hips Spine Leg Hand Foot Toe Tip", id="mixed"),
        pytest.param("Hips Leg Foot Spine Toe Tip Hand", id="spine_between_feet"),
    ],
)
def test_joints_below_a_foot_may_come_before_or_after_the_rest(order: str) -> None:
    names = order.split()
    parents = tuple(names.index(RIG[name]) if RIG[name] else -1 for name in names)
    rng = np.random.default_rng(3)
    turns = np.concatenate([wandering_motion(30, 30, seed).rotations for seed in (1, 2)], axis=1)
    skeleton = Skeleton(tuple(names), parents, rng.normal(0, 0.3, (7, 3)))
    motion = Motion(skeleton, turns[:, :7])
    # The heel leaves the ground before the toes do.
    at_rest = np.repeat([[True, True], [False, True], [False, False], [True, True]], (8, 5, 9, 8), axis=0)
    standing = Contacts((Foot(names.index("Foot")), Foot(names.index("Toe"))), at_rest, motion.rate)
    warp = Warp([0.0, 0.3, 0.5], [0.0, 0.6, motion.end_time])
    assert_is_the_definition(apply_warp(motion, warp, contacts=standing), motion, warp, standing)


@settings(max_examples=150)
@given(st.data())
def test_any_rig_is_averaged_as_defined(data: st.DataObject) -> None:
    motion = data.draw(moving_rigs())
    warp, standing = data.draw(warps_of(motion)), data.draw(contacts_of(motion))
    result = apply_warp(motion, warp, contacts=standing)
    assert_is_the_definition(result, motion, warp, standing)


@settings(max_examples=50)
@given(st.data())
def test_any_rig_is_averaged_as_in_the_paper(data: st.DataObject) -> None:
    motion = data.draw(moving_rigs())
    warp = data.draw(warps_of(motion))
    result = apply_warp(motion, warp, contacts=None, keep_root_path=False)
    assert_is_the_definition(result, motion, warp, None, keep_root_path=False)


@settings(max_examples=150)
@given(st.data())
def test_the_slip_of_any_rig_is_measured_as_defined(data: st.DataObject) -> None:
    motion = data.draw(moving_rigs())
    warp, standing = data.draw(warps_of(motion)), data.draw(contacts_of(motion))
    report = retimed_slip(motion, warp, contacts=standing)
    scale = metres_per_unit(motion)
    # A billionth of a frame beside a frame is that frame.
    places = np.round(warp(output_frame_times(warp, float(motion.rate))) * float(motion.rate), 9)
    outputs = (
        (report.unaveraged, apply_warp(motion, warp, average=False)),
        (report.plain, apply_warp(motion, warp, contacts=None, keep_root_path=False)),
        (report.contact_aware, apply_warp(motion, warp, contacts=standing)),
    )
    for foot, (point, column) in enumerate(zip(standing.feet, standing.at_rest.T.tolist(), strict=True)):
        wanted = [(first, last) for _, first, last in literal.shown(column, places.tolist())]
        for found, output in outputs:
            here = [i for i, span in enumerate(found.contacts) if span.foot == foot]
            assert [(found.contacts[i].first_frame, found.contacts[i].last_frame) for i in here] == wanted
            for i, (first, last) in zip(here, wanted, strict=True):
                slid = literal.slip(output, (point.joint, point.end_site), scale, first, last)
                assert found.millimetres[i] == pytest.approx(slid, abs=1e-6)
