"""The three results, compared with the poses that were there: by the depsgraph, at warped times."""

from __future__ import annotations

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs bpy: make test-blender")
from rigs import draw_curve, empty, fcurves, link, poses, run, select, shown, swinging, timing, values, walker  # noqa: E402

CLOSE = {"KEYS": 1e-5, "NLA": 1e-5, "BAKE": 1e-4}
RESULTS = pytest.mark.parametrize("result", ["KEYS", "NLA", "BAKE"])


@RESULTS
def test_a_searched_walk_shows_the_poses_of_the_input_at_warped_times(scene, result):
    rig = walker()
    select(rig)
    settings = scene.retime
    settings.search_length, settings.result, settings.average = "75%", result, False
    assert run("preview") == {"FINISHED"}
    frames = np.arange(1, 91)
    wanted = poses([rig], shown(frames))
    assert run("retime") == {"FINISHED"}
    to, at = timing()
    assert (to[0], to[-1], at[0], at[-1]) == (1, 90, 1, 120)
    # It is no constant speed.
    assert np.ptp(np.diff(at) / np.diff(to)) > 0.2
    np.testing.assert_allclose(poses([rig], frames), wanted, atol=CLOSE[result])
    assert settings.summary.startswith("120 → 90 frames (3.75 s), 75%")


@RESULTS
def test_drawn_timing_with_a_hold_and_a_stretch(scene, result):
    rig = walker(n_frames=60)
    select(rig)
    scene.retime.result, scene.retime.average = result, False
    draw_curve([(1, 1), (20, 30), (30, 30), (60, 40), (80, 60)])
    frames = np.arange(-5, 95)
    wanted = poses([rig], shown(frames))
    assert run("use_curve") == {"FINISHED"}
    np.testing.assert_allclose(poses([rig], frames), wanted, atol=CLOSE[result])


@pytest.mark.parametrize("result", ["KEYS", "NLA"])
def test_between_whole_frames_too(scene, result):
    ball = swinging(empty())
    select(ball)
    scene.retime.result = result
    draw_curve([(1, 1), (20, 30), (45, 60)])
    frames = np.linspace(1, 45, 333)
    wanted = poses([ball], shown(frames))
    run("use_curve")
    # Blender itself takes a key for what is within a ten-thousandth of a frame, and keeps frames in single precision.
    np.testing.assert_allclose(poses([ball], frames), wanted, atol=4e-5)


def test_keys_kept_are_few(scene):
    rig = walker()
    select(rig)
    before = sum(len(curve.keyframe_points) for curve in fcurves(rig))
    draw_curve([(1, 1), (40, 70), (90, 120)])
    run("use_curve")
    after = sum(len(curve.keyframe_points) for curve in fcurves(rig))
    # One cut a curve.
    assert after == before + len(fcurves(rig))


def test_the_old_action_stays_with_a_fake_user(scene):
    rig = walker()
    old = rig.animation_data.action
    keys = [tuple(point.co) for curve in fcurves(rig) for point in curve.keyframe_points]
    select(rig)
    draw_curve([(1, 1), (90, 120)])
    run("use_curve")
    assert rig.animation_data.action != old
    assert old.use_fake_user
    assert (
        [tuple(point.co) for curve in fcurves(rig, old) for point in curve.keyframe_points] == keys
        if not hasattr(old, "layers")
        else old.frame_range[1] == 120
    )


def test_the_action_itself_where_asked_for(scene):
    rig = walker()
    old = rig.animation_data.action
    select(rig)
    scene.retime.new_action = False
    draw_curve([(1, 1), (90, 120)])
    run("use_curve")
    assert rig.animation_data.action == old
    assert old.frame_range[1] == pytest.approx(90, abs=1e-4)


def test_range_and_markers_follow(scene):
    rig = walker()
    select(rig)
    scene.frame_start, scene.frame_end = 1, 150
    scene.use_preview_range = True
    scene.frame_preview_start, scene.frame_preview_end = 30, 120
    for frame in (1, 60, 120, 140):
        scene.timeline_markers.new(str(frame), frame=frame)
    draw_curve([(1, 1), (31, 61), (91, 121)])
    run("use_curve")
    assert (scene.frame_start, scene.frame_end) == (1, 120)
    assert (scene.frame_preview_start, scene.frame_preview_end) == (16, 90)
    assert [marker.frame for marker in scene.timeline_markers] == [1, 30, 90, 110]


def test_markers_and_range_stay_where_asked_for(scene):
    rig = walker()
    select(rig)
    scene.frame_end = 150
    scene.timeline_markers.new("a", frame=60)
    scene.retime.move_markers = scene.retime.move_range = False
    draw_curve([(1, 1), (91, 121)])
    run("use_curve")
    assert (scene.frame_end, scene.timeline_markers[0].frame) == (150, 60)


def test_an_action_keeps_markers_and_a_range_of_its_own_in_step(scene):
    rig = walker()
    action = rig.animation_data.action
    action.use_frame_range, action.frame_start, action.frame_end = True, 1, 121
    action.pose_markers.new("contact").frame = 61
    select(rig)
    draw_curve([(1, 1), (31, 61), (91, 121)])
    run("use_curve")
    new = rig.animation_data.action
    assert (new.frame_start, new.frame_end, new.pose_markers[0].frame) == (1, 91, 31)
    assert (action.frame_end, action.pose_markers[0].frame) == (121, 61)


def test_snapped_keys_stand_on_whole_frames_and_their_error_is_said(scene):
    rig = walker()
    select(rig)
    scene.retime.snap = True
    draw_curve([(1, 1), (40, 70), (90, 120)])
    frames = np.arange(1, 91)
    wanted = poses([rig], shown(frames))
    run("use_curve")
    times = np.array([point.co[0] for curve in fcurves(rig) for point in curve.keyframe_points])
    assert (times == np.rint(times)).all()
    off = np.abs(poses([rig], frames) - wanted).max()
    # Keys move by half a frame at most, which is most of an input frame where the motion is sped up.
    assert 1e-4 < off < 0.3
    said = [line for line in scene.retime.summary.split("\n") if line.startswith("on whole frames rotation_quaternion")]
    assert len(said) == 1
    assert 1e-4 < float(said[0].split()[-3]) < 0.1


def test_averaging_calms_what_is_sped_up_and_leaves_the_ends(scene):
    ball = empty()
    for frame in range(1, 122):
        ball.location = (0.1 * frame, 0.3 * (frame % 2), 0)
        ball.keyframe_insert("location", frame=frame)
    select(ball)
    scene.retime.result = "BAKE"
    draw_curve([(1, 1), (31, 121)])
    ends = poses([ball], [1, 121])
    run("use_curve")
    frames = np.arange(1, 32)
    now = poses([ball], frames)
    assert np.ptp(now[5:-5, 0, 1, 3]) < 0.15
    np.testing.assert_allclose(now[5:-5, 0, 0, 3], 0.1 * shown(frames)[5:-5], atol=0.02)
    np.testing.assert_allclose(now[[0, -1]], ends, atol=1e-5)


def test_one_step_of_undo_brings_everything_back(scene):
    rig = walker()
    select(rig)
    scene.frame_end = 120
    scene.retime.search_length = "75%"
    old = poses([rig], np.arange(1, 121, 7))
    bpy.ops.ed.undo_push(message="before")
    run("retime")
    new = poses([bpy.data.objects["walker"]], np.arange(1, 91, 7))
    assert bpy.context.scene.frame_end == 90
    bpy.ops.ed.undo()
    rig, scene = bpy.data.objects["walker"], bpy.context.scene
    assert (scene.frame_end, rig.animation_data.action.name) == (120, "walkerAction")
    assert scene.retime.summary == ""
    np.testing.assert_array_equal(poses([rig], np.arange(1, 121, 7)), old)
    bpy.ops.ed.redo()
    rig, scene = bpy.data.objects["walker"], bpy.context.scene
    assert scene.frame_end == 90
    np.testing.assert_array_equal(poses([rig], np.arange(1, 91, 7)), new)


def test_a_group_gets_one_timing(scene):
    first, second = walker("one", seed=1), walker("two", seed=2, extra_bones=False)
    prop = swinging(empty(), frames=range(1, 121, 9))
    camera = link(bpy.data.objects.new("camera", bpy.data.cameras.new("camera")))
    swinging(camera, frames=range(1, 121, 13), seed=8)
    for frame, lens in ((1, 35), (60, 80), (120, 50)):
        camera.data.lens = lens
        camera.data.keyframe_insert("lens", frame=frame)
    mesh = link(bpy.data.objects.new("face", bpy.data.meshes.new("face")))
    mesh.data.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    mesh.shape_key_add(name="Basis")
    smile = mesh.shape_key_add(name="smile")
    for frame, value in ((1, 0), (50, 1), (120, 0.2)):
        smile.value = value
        smile.keyframe_insert("value", frame=frame)
    prop["weight"] = 0.0
    for frame, value in ((1, 0.0), (70, 3.0), (120, 1.0)):
        prop["weight"] = value
        prop.keyframe_insert('["weight"]', frame=frame)
    held = first.pose.bones["head"].constraints.new("COPY_LOCATION")
    held.target = prop
    for frame, value in ((1, 0.0), (40, 1.0), (120, 0.0)):
        held.influence = value
        held.keyframe_insert("influence", frame=frame)
    group = [first, second, prop, camera, mesh]
    select(*group)
    scene.retime.search_length = "80%"
    assert run("preview") == {"FINISHED"}, scene.retime.fault
    frames = np.arange(1, 97)
    at = shown(frames)
    wanted = poses(group, at)
    lens, smiles, weights = (
        values(camera.data, "lens", at),
        values(mesh.data.shape_keys, 'key_blocks["smile"].value', at),
        values(prop, '["weight"]', at),
    )
    run("retime")
    np.testing.assert_allclose(poses(group, frames), wanted, atol=1e-5)
    np.testing.assert_allclose(values(camera.data, "lens", frames), lens, atol=1e-4)
    np.testing.assert_allclose(values(mesh.data.shape_keys, 'key_blocks["smile"].value', frames), smiles, atol=1e-5)
    np.testing.assert_allclose(values(prop, '["weight"]', frames), weights, atol=1e-5)
