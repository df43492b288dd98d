"""Cases that broke other tools, each with poses compared by the depsgraph, or refused by name."""

from __future__ import annotations

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs bpy: make test-blender")
from rigs import draw_curve, empty, fcurves, link, poses, run, select, shown, swinging, timing, values, walker  # noqa: E402

SLOTS = pytest.mark.skipif(bpy.app.version < (4, 4), reason="actions have slots since 4.4")
TURNS = ("QUATERNION", "AXIS_ANGLE", "XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")
PAIRS = [(1, 1), (20, 35), (30, 40), (50, 60)]
FRAMES = np.arange(-3, 60)


def check(objects, *, result="KEYS", pairs=PAIRS, frames=FRAMES, atol=1e-5, **settings):
    """Give objects a drawn timing, and compare their poses."""
    scene = bpy.context.scene
    select(*objects)
    scene.retime.result, scene.retime.average = result, False
    for name, value in settings.items():
        setattr(scene.retime, name, value)
    draw_curve(pairs)
    wanted = poses(objects, shown(frames))
    assert run("use_curve") == {"FINISHED"}
    np.testing.assert_allclose(poses(objects, frames), wanted, atol=atol)
    return scene.retime.summary


def strip_of(one, *, start=10, scale=1.0, first=None, last=None, repeat=1.0, reverse=False):
    """Push an object's action down into a strip."""
    animation = one.animation_data
    action, slot = animation.action, getattr(animation, "action_slot", None)
    strip = animation.nla_tracks.new().strips.new("strip", start, action)
    if slot is not None:
        strip.action_slot = slot
    animation.action = None
    strip.use_sync_length = False
    if first is not None:
        strip.action_frame_start, strip.action_frame_end = first, last
    strip.scale = scale
    strip.repeat = repeat
    strip.use_reverse = reverse
    return strip


@pytest.mark.parametrize("result", ["KEYS", "NLA", "BAKE"])
@pytest.mark.parametrize(
    ("start", "scale", "first", "last"), [(10, 1.0, None, None), (-4, 0.5, 7, 49), (3, 1.7, 1, 30)]
)
def test_strips_with_offset_and_scale(scene, result, start, scale, first, last):
    ball = swinging(empty())
    strip = strip_of(ball, start=start, scale=scale, first=first, last=last)
    before = strip.frame_start, strip.frame_end
    check([ball], result=result, atol=1e-4 if result == "BAKE" else 2e-5)
    strip = ball.animation_data.nla_tracks[0].strips[0]
    to, at = timing()
    ends = [
        np.interp(frame, np.r_[at[0] - 99, at, at[-1] + 99], np.r_[to[0] - 99, to, to[-1] + 99]) for frame in before
    ]
    np.testing.assert_allclose([strip.frame_start, strip.frame_end], ends, atol=1e-3)


@pytest.mark.parametrize("result", ["KEYS", "NLA"])
@pytest.mark.parametrize(("repeat", "reverse"), [(2.5, False), (1.0, True), (2.0, True)])
def test_strips_that_repeat_or_run_backward(scene, result, repeat, reverse):
    ball = swinging(empty(), frames=(1, 8, 16, 21))
    strip_of(ball, start=1, repeat=repeat, reverse=reverse)
    # Where a repetition begins anew the place jumps: there, half a frame is all.
    frames = FRAMES + 0.25
    words = check([ball], result=result, frames=frames, atol=2e-5)
    assert ("strip time was retimed" in words) == (result == "KEYS")


def test_strips_that_were_retimed_before_are_retimed_again(scene):
    ball = swinging(empty())
    check([ball], result="NLA")
    check([ball], result="NLA", pairs=[(1, 1), (15, 25), (45, 50)], frames=np.arange(-3, 55), atol=2e-5)


def test_blended_strips_with_influence_stay_in_step(scene):
    ball = swinging(empty())
    one = strip_of(ball, start=1)
    swinging(ball, seed=9)
    other = strip_of(ball, start=15)
    other.blend_type = "COMBINE"
    other.use_animated_influence = True
    curve = other.fcurves.find("influence")
    for frame, value in ((15, 0.0), (30, 1.0), (60, 0.3)):
        curve.keyframe_points.insert(frame, value)
    one.blend_out = 7.0
    check([ball], atol=3e-5)


FASTER_AND_SLOWER = pytest.mark.parametrize("pairs", [PAIRS, [(1, 1), (40, 20), (60, 30), (120, 60)]])
RESULTS = pytest.mark.parametrize("result", ["KEYS", "NLA", "BAKE"])


def lay(one, start, other=None, *, track=None):
    """Lay what an object plays, or another one, as a strip, and leave it its action."""
    played = (other or one).animation_data
    tracks = one.animation_data.nla_tracks
    strip = (track or tracks.new()).strips.new("strip", start, played.action)
    if hasattr(strip, "action_slot"):
        strip.action_slot = played.action_slot
    return strip


@RESULTS
@FASTER_AND_SLOWER
def test_strips_side_by_side_on_one_track(scene, result, pairs):
    """Where one gets longer Blender pushes the next along: none may lose its place."""
    ball = swinging(empty(), frames=range(1, 21, 4))
    track = ball.animation_data.nla_tracks.new()
    for start in (1, 18, 37):
        lay(ball, start, track=track)
    ball.animation_data.action = None
    check([ball], result=result, pairs=pairs, frames=np.arange(-3, 130), atol=1e-4 if result == "BAKE" else 1e-5)


@RESULTS
@FASTER_AND_SLOWER
def test_strips_that_blend_by_themselves(scene, result, pairs):
    ball, other = swinging(empty(), frames=range(1, 31, 4)), swinging(empty("other"), frames=range(1, 41, 5), seed=4)
    strips = [lay(ball, 1), lay(ball, 20, other)]
    for strip in strips:
        strip.use_auto_blend = True
    assert strips[1].blend_in > 5
    ball.animation_data.action = None
    check([ball], result=result, pairs=pairs, frames=np.arange(-3, 130), atol=1e-4 if result == "BAKE" else 1e-5)


@RESULTS
@pytest.mark.parametrize("extrapolation", ["HOLD", "HOLD_FORWARD", "NOTHING"])
@pytest.mark.parametrize("tracks", [0, 1])
def test_an_action_that_is_mixed_with_strips(scene, result, extrapolation, tracks):
    """Its influence, and what it is beyond its ends, count where there are strips, and not where there are none."""
    ball, other = swinging(empty(), frames=range(5, 33, 4)), swinging(empty("other"), frames=range(1, 50, 6), seed=4)
    if tracks:
        lay(ball, 1, other)
    animation = ball.animation_data
    animation.action_blend_type, animation.action_influence = "ADD", 0.4
    animation.action_extrapolation = extrapolation
    check([ball], result=result, atol=1e-4 if result == "BAKE" else 1e-5)


@SLOTS
def test_objects_that_share_an_action_by_slots_are_retimed_alone(scene):
    one, other = swinging(empty("one"), seed=1), swinging(empty("other"), seed=2)
    action = one.animation_data.action
    lone = fcurves(other)
    slot = action.slots.new("OBJECT", "other")
    bag = action.layers[0].strips[0].channelbag(slot, ensure=True)
    for curve in lone:
        copy = bag.fcurves.new(curve.data_path, index=curve.array_index)
        for point in curve.keyframe_points:
            copy.keyframe_points.insert(*point.co)
    other.animation_data.action = action
    other.animation_data.action_slot = slot
    still = poses([other], FRAMES)
    check([one])
    assert one.animation_data.action != action
    assert other.animation_data.action == action
    np.testing.assert_array_equal(poses([other], FRAMES), still)
    # The copy holds its own slot, and nobody else's.
    assert [slot.identifier for slot in one.animation_data.action.slots] == ["OBone"]


@SLOTS
@pytest.mark.parametrize("new_action", [True, False])
def test_both_of_a_shared_action(scene, new_action):
    one, other = swinging(empty("one"), seed=1), swinging(empty("other"), seed=2)
    action = one.animation_data.action
    slot = action.slots.new("OBJECT", "other")
    bag = action.layers[0].strips[0].channelbag(slot, ensure=True)
    for curve in fcurves(other):
        copy = bag.fcurves.new(curve.data_path, index=curve.array_index)
        for point in curve.keyframe_points:
            copy.keyframe_points.insert(*point.co)
    other.animation_data.action = action
    other.animation_data.action_slot = slot
    check([one, other], new_action=new_action)
    assert one.animation_data.action == other.animation_data.action
    assert (one.animation_data.action == action) != new_action


def share(one, other):
    """Have an object play what another plays."""
    one.animation_data_create().action = other.animation_data.action
    if hasattr(one.animation_data, "action_slot"):
        one.animation_data.action_slot = other.animation_data.action_slot


def test_objects_that_share_an_action_whole(scene):
    one, other = swinging(empty("one")), empty("other")
    share(other, one)
    still = poses([other], FRAMES)
    check([one])
    np.testing.assert_array_equal(poses([other], FRAMES), still)


def test_an_action_that_others_play_too_is_left_to_them(scene):
    """Even where the action itself is to be retimed: who is not selected keeps what they play, in strips too."""
    ball, other, striped, apart = swinging(empty()), empty("other"), empty("striped"), swinging(empty("apart"))
    action = ball.animation_data.action
    share(other, ball)
    share(striped, ball)
    strip_of(striped)
    frames = np.arange(-3, 90)
    before = poses([other, striped], frames)
    check([ball], new_action=False)
    np.testing.assert_array_equal(poses([other, striped], frames), before)
    assert ball.animation_data.action != action
    # What nobody else plays is retimed itself.
    alone = apart.animation_data.action
    check([apart], new_action=False)
    assert apart.animation_data.action == alone


@pytest.mark.parametrize("result", ["KEYS", "NLA", "BAKE"])
@pytest.mark.parametrize("with_strip", [False, True])
def test_an_nla_that_is_switched_off(scene, result, with_strip):
    """What it would play is not shown, and must not come to be."""
    ball = swinging(empty())
    animation = ball.animation_data
    if with_strip:
        played = swinging(empty("other"), seed=8).animation_data
        strip = animation.nla_tracks.new().strips.new("strip", 5, played.action)
        if hasattr(strip, "action_slot"):
            strip.action_slot = played.action_slot
        strip.blend_type = "ADD"
    animation.use_nla = False
    words = check([ball], result=result, atol=1e-4 if result == "BAKE" else 1e-5)
    assert ("its NLA was switched off" in words) == (result == "NLA" and with_strip)


def linked(tmp_path, name):
    """Save an animated object to a file and link it from there into an empty scene."""
    place = str(tmp_path / "library.blend")
    bpy.data.libraries.write(place, {bpy.data.objects[name]})
    bpy.ops.wm.read_homefile(use_empty=True)
    with bpy.data.libraries.load(place, link=True) as (_, into):
        into.objects = [name]
    return link(into.objects[0])


def test_linked_objects_are_refused_by_name(scene, tmp_path):
    walker()
    rig = linked(tmp_path, "walker")
    select(rig)
    with pytest.raises(RuntimeError, match=r"walker is linked from .*library\.blend: make a library override"):
        run("retime")
    assert bpy.context.scene.retime.fault_field == "selection"


def test_linked_data_of_an_object_is_refused_by_name(scene, tmp_path):
    """It can't be changed, and so would no longer be in step."""
    camera = link(bpy.data.objects.new("shot", bpy.data.cameras.new("lens")))
    for frame, lens in ((1, 35), (60, 50)):
        camera.data.lens = lens
        camera.data.keyframe_insert("lens", frame=frame)
    theirs = linked(tmp_path, "shot").data
    camera = swinging(link(bpy.data.objects.new("mine", theirs)))
    action = camera.animation_data.action
    select(camera)
    with pytest.raises(RuntimeError, match=r"lens, which moves mine, is linked from .*library\.blend: make a library"):
        run("retime")
    assert bpy.context.scene.retime.fault_field == "selection"
    assert camera.animation_data.action == action


@pytest.mark.parametrize("result", ["KEYS", "NLA", "BAKE"])
def test_overridden_objects_get_an_action_of_their_own(scene, tmp_path, result):
    walker(n_frames=60)
    rig = linked(tmp_path, "walker")
    override = rig.override_create(remap_local_usages=True)
    if override.name not in bpy.context.scene.collection.objects:
        link(override)
    assert override.animation_data.action.library is not None
    check([override], result=result, atol=1e-4 if result == "BAKE" else 1e-5)
    if result != "NLA":
        assert override.animation_data.action.library is None


def test_the_scenes_rate_with_its_base(scene):
    scene.render.fps, scene.render.fps_base = 30, 1.001
    rig = walker(n_frames=90)
    select(rig)
    scene.retime.search_length = "2s"
    run("retime")
    # Two seconds at 29.97 frames a second are 60 frames.
    assert scene.retime.summary.startswith("90 → 60 frames (2.00 s)")
    assert (scene.render.fps, scene.render.fps_base) == (30, pytest.approx(1.001))


def test_keys_between_frames(scene):
    ball = swinging(empty(), frames=[1.3, 7.77, 8.01, 22.5, 40.25, 60.6])
    check([ball], pairs=[(1, 1), (20, 35), (30, 40), (51, 61)])


def test_muted_and_locked_curves_stay_so_and_stay_in_step(scene):
    ball = swinging(empty())
    curves = fcurves(ball)
    curves[0].mute, curves[1].lock, curves[2].hide = True, True, True
    check([ball])
    curves = fcurves(ball)
    assert (curves[0].mute, curves[1].lock, curves[2].hide) == (True, True, True)
    # A muted curve plays again when it is no longer muted: with the new timing.
    assert curves[0].range()[1] == pytest.approx(45, abs=1e-3)


@pytest.mark.parametrize("result", ["KEYS", "BAKE"])
def test_quaternions_that_flip_their_sign(scene, result):
    rig = walker(n_frames=60, step=1)
    for curve in fcurves(rig):
        if "quaternion" in curve.data_path:
            for i, point in enumerate(curve.keyframe_points):
                point.co.y *= -1 if i % 3 == 0 else 1
                point.interpolation = "CONSTANT"
            curve.update()
    # Whole input frames: between two of them a flip has no pose of its own.
    frames = np.arange(1, 31)
    select(rig)
    scene.retime.result, scene.retime.average = result, False
    draw_curve([(1, 1), (30, 59)])
    wanted = poses([rig], shown(frames))
    run("use_curve")
    np.testing.assert_allclose(poses([rig], frames), wanted, atol=1e-4 if result == "BAKE" else 1e-5)
    if result == "BAKE":
        # Baked keys agree, so that what lies between is the short way.
        rows = np.array(
            [[curve.evaluate(frame) for frame in frames] for curve in fcurves(rig) if "thigh.L" in curve.data_path]
        )
        assert (np.abs(np.diff(rows, axis=1)).max(axis=1) < 0.5).all()


@pytest.mark.parametrize("average", [False, True])
@pytest.mark.parametrize("flipped", [5, 8, 13])
def test_quaternions_that_flip_within_the_range_agree_with_what_comes_after(scene, flipped, average):
    ball = empty()
    ball.rotation_mode = "QUATERNION"
    for i, frame in enumerate(range(1, 61, 3)):
        turned = np.array([math.cos(0.05 * i), math.sin(0.05 * i), 0, 0])
        ball.rotation_quaternion = -turned if i >= flipped else turned
        ball.keyframe_insert("rotation_quaternion", frame=frame)
    # Beside the flip, where the motion as it was has no pose of its own.
    frames = np.array([frame for frame in np.arange(-3, 50, 0.5) if not 13 < frame < 22.01])
    select(ball)
    scene.retime.result, scene.retime.average = "BAKE", average
    draw_curve([(13, 13), (22, 31)])
    steady = [frame for frame in frames if not 3 * flipped - 2 <= shown(frame) <= 3 * flipped + 1]
    wanted = poses([ball], shown(steady))
    run("use_curve")
    np.testing.assert_allclose(poses([ball], steady), wanted, atol=1e-4)


@pytest.mark.parametrize("mode", TURNS)
@pytest.mark.parametrize("result", ["KEYS", "BAKE"])
def test_every_way_to_hold_a_turn(scene, result, mode):
    rig = walker(n_frames=60, mode=mode)
    check([rig], result=result, atol=1e-4 if result == "BAKE" else 1e-5)


@pytest.mark.parametrize("mode", TURNS)
def test_averaged_turns_in_every_way_to_hold_them(scene, mode):
    """Averaging is one of turns, however they are held: bones in all modes get the same poses."""
    rigs = [walker(name, n_frames=120, mode=one, step=1) for name, one in (("plain", "QUATERNION"), ("held", mode))]
    select(*rigs)
    scene.retime.result, scene.retime.average = "BAKE", True
    draw_curve([(1, 1), (40, 120)])
    run("use_curve")
    frames = np.arange(1, 41)
    plain, held = (poses([rig], frames) for rig in rigs)
    np.testing.assert_allclose(held, plain, atol=2e-4)


def test_a_rig_with_root_and_control_bones(scene):
    """What deforms nothing is not looked at, wherever it goes."""
    found = []
    for wild in (False, True):
        rig = walker("wild" if wild else "calm")
        if wild:
            for frame in range(1, 121, 3):
                bone = rig.pose.bones["look_at"]
                bone.location = (5 * math.sin(frame), 3 * math.cos(frame * frame), 0)
                bone.keyframe_insert("location", frame=frame)
        select(rig)
        scene.retime.search_length = "75%"
        run("preview")
        found.append(timing())
    np.testing.assert_allclose(found[0], found[1], atol=1e-4)


def test_the_root_bone_may_be_named_and_must_be_there(scene):
    rig = walker()
    select(rig)
    scene.retime.search_length, scene.retime.root = "75%", "hips"
    assert run("preview") == {"FINISHED"}
    scene.retime.root = "hip"
    with pytest.raises(RuntimeError, match="hip"):
        run("preview")
    assert scene.retime.fault_field == "root"


@pytest.mark.parametrize("result", ["KEYS", "NLA", "BAKE"])
def test_objects_without_an_armature_are_searched_too(scene, result):
    ball = empty("ball")
    for i, frame in enumerate((1, 13, 25, 49, 73, 80, 96)):
        ball.location = (i, 0, 2 * (i % 2))
        ball.keyframe_insert("location", frame=frame)
    select(ball)
    scene.retime.search_length, scene.retime.result, scene.retime.average = "75%", result, False
    run("preview")
    frames = np.arange(1, 73)
    wanted = poses([ball], shown(frames))
    run("retime")
    assert timing()[0][-1] == 72
    np.testing.assert_allclose(poses([ball], frames), wanted, atol=1e-4 if result == "BAKE" else 1e-5)


@pytest.mark.parametrize("result", ["KEYS", "NLA", "BAKE"])
def test_curves_of_one_key(scene, result):
    ball = swinging(empty())
    ball.scale = (2, 3, 4)
    ball.keyframe_insert("scale", frame=25)
    check([ball], result=result, atol=1e-4 if result == "BAKE" else 1e-5)
    ball.scale = (1, 1, 1)
    assert values(ball, "scale", [5, 50]).tolist() == [[2, 3, 4]] * 2


@pytest.mark.parametrize(
    ("before", "after", "counts"),
    [
        ("REPEAT", "REPEAT", (0, 0)),
        ("REPEAT_OFFSET", "REPEAT_OFFSET", (0, 0)),
        ("MIRROR", "MIRROR", (0, 0)),
        ("NONE", "REPEAT_OFFSET", (0, 2)),
        ("REPEAT", "NONE", (1, 0)),
    ],
)
@pytest.mark.parametrize("result", ["KEYS", "NLA", "BAKE"])
def test_cycles(scene, result, before, after, counts):
    ball = swinging(empty(), frames=(11, 15, 22, 27))
    for curve in fcurves(ball):
        modifier = curve.modifiers.new("CYCLES")
        modifier.mode_before, modifier.mode_after = before, after
        modifier.cycles_before, modifier.cycles_after = counts
    scene.frame_start, scene.frame_end = 1, 80
    # Where a repetition does not meet itself, its value jumps at a frame: look beside it.
    frames = np.arange(1, 60) + 0.3
    if result == "BAKE":
        # Between its frames a baked curve goes straight. Beside a jump it is within a frame of it.
        to, at = np.array(PAIRS).T
        whole = np.arange(1, 50)
        apart = np.abs((np.interp(whole, to, at) - 11 + 8) % 16 - 8) > 0.01
        frames = whole[apart]
    words = check([ball], result=result, frames=frames, atol=4e-5 if result != "BAKE" else 1e-4)
    if result != "NLA":
        assert "the cycles of location were written out as keys" in words
        assert not any(len(curve.modifiers) for curve in fcurves(ball))


def test_curves_that_go_straight_on(scene):
    ball = swinging(empty(), frames=(11, 20, 35))
    for curve in fcurves(ball):
        curve.extrapolation = "LINEAR"
    fcurves(ball)[0].keyframe_points[-1].interpolation = "LINEAR"
    check([ball])


@pytest.mark.parametrize("ease", ["SINE", "QUAD", "CUBIC", "EXPO", "CIRC", "BACK", "BOUNCE", "ELASTIC"])
def test_eased_keys(scene, ease):
    ball = swinging(empty())
    for curve in fcurves(ball):
        for point in curve.keyframe_points:
            point.interpolation = ease
    check([ball], atol=4e-4 if ease in ("BOUNCE", "ELASTIC") else 1e-4)


def test_switches_have_no_values_between(scene):
    ball = swinging(empty())
    for frame, hidden in ((1, False), (25, True), (44, False)):
        ball.hide_render = hidden
        ball.keyframe_insert("hide_render", frame=frame)
    for curve in fcurves(ball):
        for point in curve.keyframe_points:
            point.interpolation = "BEZIER"
    draw_curve(PAIRS)
    wanted = values(ball, "hide_render", shown(np.arange(1, 51)))
    check([ball])
    assert values(ball, "hide_render", np.arange(1, 51)).tolist() == wanted.tolist()


@pytest.mark.parametrize("result", ["KEYS", "NLA", "BAKE"])
def test_switches_that_stand_in_rows(scene, result):
    ball = swinging(empty())
    for frame, locked in ((1, (False, True, False)), (25, (True, False, False)), (44, (False, True, True))):
        ball.lock_location = locked
        ball.keyframe_insert("lock_location", frame=frame)
    for curve in fcurves(ball):
        for point in curve.keyframe_points:
            point.interpolation = "BEZIER"
    frames = np.arange(1, 51)
    draw_curve(PAIRS)
    wanted = [values(ball, "lock_location", shown(frames), axis).tolist() for axis in range(3)]
    check([ball], result=result, atol=1e-4)
    assert [values(ball, "lock_location", frames, axis).tolist() for axis in range(3)] == wanted


def test_averaging_leaves_jumps_as_they_are(scene):
    """Poses that are held, and a setting that is switched: nothing between two of them was ever there."""
    rig = walker(n_frames=60, step=6)
    rig["held"] = 0.0
    for frame, value in ((1, 0.0), (26, 1.0), (44, 0.0)):
        rig["held"] = value
        rig.keyframe_insert('["held"]', frame=frame)
    for curve in fcurves(rig):
        for point in curve.keyframe_points:
            point.interpolation = "CONSTANT"
    select(rig)
    scene.retime.result, scene.retime.average = "BAKE", True
    draw_curve([(1, 1), (27, 60)])
    frames = np.arange(1, 28)
    wanted, held = poses([rig], shown(frames)), values(rig, '["held"]', shown(frames))
    run("use_curve")
    np.testing.assert_allclose(poses([rig], frames), wanted, atol=1e-4)
    assert values(rig, '["held"]', frames).tolist() == held.tolist()


def test_sampled_curves(scene):
    ball = swinging(empty())
    for curve in fcurves(ball):
        curve.convert_to_samples(1, 60)
    check([ball], atol=2e-5)


def test_grease_pencils_are_refused_by_name(scene):
    # What was new in 4.3 stood beside the old kind until 5.0 gave it its name.
    made = (
        bpy.data.grease_pencils if bpy.app.version < (4, 3) or bpy.app.version >= (5, 0) else bpy.data.grease_pencils_v3
    )
    drawing = link(bpy.data.objects.new("sketch", made.new("sketch")))
    select(walker(), drawing)
    drawing.select_set(True)
    with pytest.raises(RuntimeError, match="sketch is a grease pencil"):
        run("retime")
    assert scene.retime.fault_field == "selection"


def test_drivers_and_modifiers_in_frame_time_are_named_and_kept(scene):
    ball = swinging(empty())
    driver = ball.driver_add("scale", 0)
    driver.driver.expression = "1 + frame / 100"
    noise = fcurves(ball)[1].modifiers.new("NOISE")
    noise.strength = 0.0
    limits = fcurves(ball)[2].modifiers.new("LIMITS")
    limits.use_max_y, limits.max_y = True, 0.5
    words = check([ball], frames=np.arange(1, 1))
    assert "prop: the driver of scale goes by the scene's frames" in words
    assert "prop: the Noise modifier of location goes by the scene's frames" in words
    assert "Limits" not in words
    assert [one.type for curve in fcurves(ball) for one in curve.modifiers] == ["NOISE", "LIMITS"]
    assert ball.animation_data.drivers[0].driver.expression == "1 + frame / 100"


@pytest.mark.parametrize(
    ("expression", "named"),
    [
        ("1 + frame / 100", True),
        ("bpy.context.scene.frame_current", True),
        ("frames * 2", False),
        ("now + 1", True),
        ("frame + 1 if 0 else height", False),
    ],
)
def test_drivers_by_frame_are_told_from_others(scene, expression, named):
    ball = swinging(empty())
    inner = ball.driver_add("scale", 0).driver
    given = {"frames": "location[0]", "now": "frame_current", "height": "location[2]"}
    # A variable of this name hides the frame.
    given |= {"frame": "location[1]"} if "height" in expression else {}
    for name, path in given.items():
        if name not in expression:
            continue
        variable = inner.variables.new()
        variable.name = name
        target = variable.targets[0]
        target.id_type = "SCENE" if name == "now" else "OBJECT"
        target.id = scene if name == "now" else ball
        target.data_path = path
    inner.expression = expression
    words = check([ball], frames=np.arange(1, 1))
    assert ("the driver of scale goes by the scene's frames" in words) == named


def test_what_else_goes_by_frames_or_is_lent_is_named(scene):
    mesh = bpy.data.meshes.new("box")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    box = swinging(link(bpy.data.objects.new("box", mesh)))
    timed, plain = (bpy.data.node_groups.new(name, "GeometryNodeTree") for name in ("timed", "plain"))
    timed.nodes.new("GeometryNodeInputSceneTime")
    outer = bpy.data.node_groups.new("outer", "GeometryNodeTree")
    for group in (plain, timed):
        outer.nodes.new("GeometryNodeGroup").node_tree = group
    for group in (plain, timed, outer):
        # Else Blender says for each frame that there is none.
        group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        group.nodes.new("NodeGroupOutput")
        box.modifiers.new(f"by {group.name}", "NODES").node_group = group
    box.modifiers.new("grown", "BUILD")
    box.constraints.new("FOLLOW_TRACK").name = "tracked"
    paint = bpy.data.materials.new("paint")
    mesh.materials.append(paint)
    paint.keyframe_insert("diffuse_color", frame=3)
    before = [point.co.x for curve in fcurves(paint) for point in curve.keyframe_points]
    words = check([box], frames=np.arange(1, 1)).split("\n")
    for name in ("by timed", "by outer", "grown", "tracked"):
        assert f"box: {name} runs in the scene's own frames" in words
    assert not any("plain" in line for line in words)
    assert "box: keys of the material paint keep their timing, as other objects may use these too" in words
    assert [point.co.x for curve in fcurves(paint) for point in curve.keyframe_points] == before


def test_who_has_the_same_data_and_is_not_selected_is_named(scene):
    lens = bpy.data.cameras.new("lens")
    one, other = (link(bpy.data.objects.new(name, lens)) for name in ("one", "other"))
    mesh = bpy.data.meshes.new("face")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    face, twin = (link(bpy.data.objects.new(name, mesh)) for name in ("face", "twin"))
    face.shape_key_add(name="Basis")
    smile = face.shape_key_add(name="smile")
    for frame, value in ((1, 0.0), (60, 1.0)):
        lens.lens, smile.value = 35 + 20 * value, value
        lens.keyframe_insert("lens", frame=frame)
        smile.keyframe_insert("value", frame=frame)
    nothing = np.arange(1, 1)
    assert "which gets" not in check([one, other, face, twin], frames=nothing)
    words = check([one, face], frames=nothing)
    assert "lens is the data of other too, which gets the same timing" in words
    assert f"{mesh.shape_keys.name} is the data of twin too, which gets the same timing" in words
    assert "data of one" not in words
    assert "data of face" not in words


def test_nothing_selected_and_nothing_that_moves_are_refused(scene):
    with pytest.raises(RuntimeError, match="select what moves"):
        run("retime")
    still = empty("still")
    select(still)
    with pytest.raises(RuntimeError, match="nothing that is selected has keys"):
        run("retime")


def test_an_action_without_curves_is_nothing_that_moves(scene):
    still = empty("still")
    still.animation_data_create().action = bpy.data.actions.new("nothing")
    select(still)
    with pytest.raises(RuntimeError, match="nothing that is selected has keys"):
        run("retime")
    ball = swinging(empty())
    check([ball, still])


def test_in_pose_mode_what_is_posed_is_retimed(scene):
    rig = walker(n_frames=60)
    select(rig)
    draw_curve(PAIRS)
    wanted = poses([rig], shown(FRAMES))
    bpy.ops.object.mode_set(mode="POSE")
    rig.select_set(False)
    run("use_curve")
    assert rig.mode == "POSE"
    np.testing.assert_allclose(poses([rig], FRAMES), wanted, atol=1e-5)


def test_a_rig_that_constraints_move_is_seen_as_it_moves(scene):
    """Bones that no key moves, but targets: their poses are found, and follow."""
    rig = walker(extra_bones=False)
    target = swinging(empty("target"), frames=range(1, 121, 10))
    for side in "LR":
        held = rig.pose.bones[f"arm.{side}"].constraints.new("DAMPED_TRACK")
        held.target = target
    select(rig, target)
    scene.retime.search_length = "75%"
    run("preview")
    frames = np.arange(1, 91)
    wanted = poses([rig, target], shown(frames))
    run("retime")
    np.testing.assert_allclose(poses([rig, target], frames), wanted, atol=1e-5)


def searched(rig):
    """Return which frame the search shows at each output frame."""
    scene = bpy.context.scene
    select(rig)
    scene.retime.search_length = "75%"
    assert run("preview") == {"FINISHED"}
    return shown(np.arange(1, 91))


@pytest.mark.parametrize("how", ["by a key", "by a key in a strip", "by a driver", "at rest"])
def test_what_is_not_shown_is_searched_all_the_same(scene, how):
    rig = walker()
    wanted = searched(rig)
    if how.startswith("by a key"):
        for frame, hidden in ((1, False), (30, True), (80, False)):
            rig.hide_viewport = hidden
            rig.keyframe_insert("hide_viewport", frame=frame)
        scene.frame_set(1)
        if "strip" in how:
            strip_of(rig, start=1)
    elif how == "by a driver":
        rig.driver_add("hide_viewport").driver.expression = "frame > 20"
    else:
        rig.data.pose_position = "REST"
    np.testing.assert_allclose(searched(rig), wanted, atol=1e-4)
    # It is as it was, and hidden when it was.
    assert (rig.data.pose_position == "REST") == (how == "at rest")
    if how.startswith("by a key"):
        assert values(rig, "hide_viewport", [10, 50, 90]).tolist() == [False, True, False]
    elif how == "by a driver":
        assert not rig.animation_data.drivers[0].mute


def test_a_reference_that_is_hidden_is_looked_at(scene):
    rig, other = walker(), walker("other", seed=5, n_frames=90)
    scene.retime.reference_kind, scene.retime.reference_object = "OBJECT", other
    wanted = searched(rig)
    other.hide_viewport = True
    np.testing.assert_array_equal(searched(rig), wanted)
    assert other.hide_viewport


def test_edit_mode_is_to_be_left_first(scene):
    rig, other = walker(), walker("other", n_frames=40)
    for edited, field in ((rig, "selection"), (other, "reference")):
        select(edited)
        bpy.ops.object.mode_set(mode="EDIT")
        if field == "reference":
            rig.select_set(True)
            other.select_set(False)
            scene.retime.reference_kind, scene.retime.reference_object = "OBJECT", other
        with pytest.raises(RuntimeError, match=f"{edited.name} is in edit mode"):
            run("retime")
        assert scene.retime.fault_field == field
        bpy.ops.object.mode_set(mode="OBJECT")


@pytest.mark.parametrize("what", ["bone", "object"])
@pytest.mark.parametrize("result", ["KEYS", "BAKE"])
def test_what_is_scaled_to_nothing_for_a_while(scene, what, result):
    rig = walker()
    holder = rig.pose.bones["spine"] if what == "bone" else rig
    for frame, scale in ((1, 1), (40, 0), (60, 0), (80, 1)):
        holder.scale = (scale, scale, scale)
        holder.keyframe_insert("scale", frame=frame)
    select(rig)
    scene.retime.search_length, scene.retime.result = "75%", result
    run("preview")
    frames = np.arange(1, 91)
    scene.retime.average = False
    wanted = poses([rig], shown(frames))
    assert run("retime") == {"FINISHED"}
    np.testing.assert_allclose(poses([rig], frames), wanted, atol=1e-4 if result == "BAKE" else 1e-5)


def test_an_armature_without_bones_is_an_object_like_another(scene):
    rig = link(bpy.data.objects.new("none", bpy.data.armatures.new("none")))
    check([swinging(rig)])
    scene.retime.search_length = "75%"
    assert run("retime") == {"FINISHED"}


def test_frames_below_zero_and_far_from_it(scene):
    for start in (-200, 20000):
        ball = swinging(empty(), frames=range(start, start + 60, 7))
        check(
            [ball],
            pairs=[(start, start), (start + 20, start + 35), (start + 40, start + 56)],
            frames=np.arange(start - 3, start + 50),
            atol=1e-5 if start < 0 else 1e-2,
        )
