"""The panel's buttons and fields, pressed and filled in as a person does."""

from __future__ import annotations

import os
import stat
import sys
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

bpy = pytest.importorskip("bpy", reason="needs bpy: make test-blender")
from rigs import draw_curve, empty, fcurves, poses, run, select, shown, swinging, timing, walker  # noqa: E402

PACKAGE = "bl_ext.user_default.retime"


def module(name):
    """Return a module of the installed extension."""
    return sys.modules[f"{PACKAGE}.{name}"]


class Layout:
    """Stands for Blender's layout: what is drawn is written down."""

    def __init__(self, drawn=None):
        self.drawn = [] if drawn is None else drawn

    def row(self, **given):
        return Layout(self.drawn)

    column = box = row

    def prop(self, holder, name, **given):
        # Blender refuses a property that is not there.
        assert name in holder.bl_rna.properties
        self.drawn.append(("prop", name))

    def label(self, text="", **given):
        self.drawn.append(("label", text))

    def operator(self, name, **given):
        group, _, button = name.partition(".")
        assert button in dir(getattr(bpy.ops, group))
        self.drawn.append(("operator", name))
        return type("Given", (), {})()

    def separator(self, **given):
        pass


def drawn(scene):
    """Draw all of the panel; return fields and words in order."""
    layout = Layout()
    panels = module("panels")
    for draw in (panels.draw_main, panels.draw_keytimes, panels.draw_reference, panels.draw_hand, panels.draw_more):
        draw(layout, bpy.context)
    return layout.drawn


def words(scene):
    return " ".join(text for kind, text in drawn(scene) if kind == "label")


def test_every_option_of_the_search_has_its_field_once(scene):
    from retime.search.options import OPTIONS

    scene.retime.search_length = "free"
    fields = [name for kind, name in drawn(scene) if kind == "prop"]
    for option in OPTIONS:
        assert fields.count(f"search_{option.name}") == 1
        described = scene.retime.bl_rna.properties[f"search_{option.name}"]
        assert described.name == option.label
        assert option.hint in described.description


def test_options_that_were_not_touched_are_not_given(scene):
    assert scene.retime.given() == {}
    scene.retime.search_length = "75%"
    scene.retime.search_smoothness = 0.5
    scene.retime.search_evenness = 2.0
    scene.retime.search_features = "heading"
    scene.retime.search_loop = True
    # A number that has a switch counts when that is on.
    assert scene.retime.given() == {"length": "75%", "smoothness": 0.5, "features": "heading", "loop": True}
    scene.retime.use_evenness = True
    assert scene.retime.given()["evenness"] == 2.0


@pytest.mark.parametrize("space", ["VIEW_3D", "DOPESHEET_EDITOR", "GRAPH_EDITOR"])
def test_the_panel_stands_in_the_side_bars(scene, space):
    mine = [
        panel
        for panel in bpy.types.Panel.__subclasses__()
        if panel.__name__.startswith("RETIME_PT") and panel.bl_space_type == space
    ]
    assert [panel.bl_label for panel in mine] == ["Retime", "Keytimes and Locks", "Like", "By Hand", "More"]
    assert all((panel.bl_region_type, panel.bl_category) == ("UI", "Retime") for panel in mine)


def test_every_button_and_field_says_what_it_does(scene):
    for name in dir(bpy.ops.retime):
        assert len(getattr(bpy.ops.retime, name).get_rna_type().description) > 20, name
    for name, described in scene.retime.bl_rna.properties.items():
        if not described.is_hidden and name not in ("rna_type", "name", "keys", "locks"):
            assert described.description, name


@pytest.mark.parametrize(
    ("name", "value", "field"),
    [
        ("search_length", "soon", "length"),
        ("search_length", "1f", "length"),
        ("search_speed", "fast", "speed"),
        ("search_rate", "often", "rate"),
    ],
)
def test_an_error_stands_beside_its_field(scene, name, value, field):
    rig = walker()
    select(rig)
    setattr(scene.retime, name, value)
    action = rig.animation_data.action
    with pytest.raises(RuntimeError):
        run("retime")
    assert scene.retime.fault_field == field
    assert rig.animation_data.action == action
    everything = drawn(scene)
    at = everything.index(("prop", name))
    below = everything[at + 1][1]
    assert everything[at + 1][0] == "label"
    assert scene.retime.fault.startswith(below)
    # It goes with what was at fault.
    setattr(scene.retime, name, "")
    run("retime")
    assert scene.retime.fault == ""


def test_a_keytime_at_fault_is_the_one_that_is_marked(scene):
    rig = walker()
    select(rig)
    for frame, to, speed in ((30, 20, ""), (60, 45, "quick"), (90, 80, "")):
        key = scene.retime.keys.add()
        key.frame, key.to, key.speed = frame, to, speed
    with pytest.raises(RuntimeError, match="quick"):
        run("retime")
    assert (scene.retime.fault_field, scene.retime.fault_item) == ("keys", 1)
    assert "quick" in words(scene)
    scene.retime.keys[1].speed = ""
    # Two keytimes at one output frame.
    scene.retime.keys[2].to = 45
    with pytest.raises(RuntimeError):
        run("retime")
    assert (scene.retime.fault_field, scene.retime.fault_item) in {("keys", 1), ("keys", 2)}
    scene.retime.keys[2].to = 80
    assert run("retime") == {"FINISHED"}
    to, at = timing()
    for frame, wanted in ((30, 20), (60, 45), (90, 80)):
        assert np.interp(wanted, to, at) == pytest.approx(frame, abs=1e-4)


def test_keytimes_from_markers_that_are_then_moved(scene):
    rig = walker()
    select(rig)
    marks = [scene.timeline_markers.new(name, frame=frame) for name, frame in (("a", 40), ("b", 80))]
    for mark in marks:
        mark.select = False
    run("keytimes_from_markers")
    run("keytimes_from_markers")
    assert [(key.frame, key.to) for key in scene.retime.keys] == [(40, 40), (80, 80)]
    marks[0].frame, marks[1].frame = 30, 75
    run("keytimes_to_markers")
    assert [(key.frame, key.to) for key in scene.retime.keys] == [(40, 30), (80, 75)]
    run("remove_keytime", index=0)
    assert [(key.frame, key.to) for key in scene.retime.keys] == [(80, 75)]
    run("remove_keytime", index=-1)
    assert len(scene.retime.keys) == 0


def test_keytimes_and_a_lock_from_selected_keys(scene):
    rig = walker()
    select(rig)
    for curve in fcurves(rig):
        for point in curve.keyframe_points:
            point.select_control_point = point.co.x in (21, 61)
    run("keytimes_from_keys")
    assert [key.frame for key in scene.retime.keys] == [21, 61]
    run("remove_keytime", index=-1)
    run("add_lock")
    assert [(lock.start, lock.end) for lock in scene.retime.locks] == [(21, 61)]
    scene.retime.search_length = "75%"
    run("retime")
    to, at = timing()
    inside = np.interp(np.arange(21, 62), at, to)
    np.testing.assert_allclose(np.diff(inside), 1.0, atol=0.02)
    run("remove_lock", index=0)
    scene.use_preview_range = True
    scene.frame_preview_start, scene.frame_preview_end = 10, 20
    run("add_lock")
    assert [(lock.start, lock.end) for lock in scene.retime.locks] == [(10, 20)]
    scene.retime.locks[0].speeds = "sometimes"
    with pytest.raises(RuntimeError):
        run("retime")
    assert (scene.retime.fault_field, scene.retime.fault_item) == ("locks", 0)


@pytest.mark.parametrize("how", ["scaled", "repeated", "backward", "strip time", "tweaked"])
def test_keytimes_from_keys_that_a_strip_plays(scene, how):
    """They are frames of the scene: where the pose of the key is seen."""
    ball = swinging(empty())
    for curve in fcurves(ball):
        for point in curve.keyframe_points:
            point.select_control_point = point.co.x == 19
    pose = poses([ball], [19])[0]
    animation = ball.animation_data
    slot = getattr(animation, "action_slot", None)
    strip = animation.nla_tracks.new().strips.new("strip", 10, animation.action)
    if slot is not None:
        strip.action_slot = slot
    animation.action = None
    wanted = 28
    if how == "scaled":
        strip.scale, wanted = 2.0, 10 + 2 * 18
    elif how == "repeated":
        strip.repeat = 2.0
    elif how == "backward":
        strip.use_reverse, wanted = True, 10 + 55 - 19
    elif how == "strip time":
        strip.use_animated_time = True
        curve = strip.fcurves.find("strip_time")
        for frame, value in ((10, 1), (30, 10), (50, 28)):
            curve.keyframe_points.insert(frame, value).interpolation = "LINEAR"
        wanted = 40
    else:
        animation.nla_tracks[0].strips[0].select = True
        animation.nla_tracks.active = animation.nla_tracks[0]
        animation.use_tweak_mode = True
        assert animation.action is not None
    select(ball)
    run("keytimes_from_keys")
    assert [key.frame for key in scene.retime.keys] == [pytest.approx(wanted, abs=1e-3)]
    animation.use_tweak_mode = False
    np.testing.assert_allclose(poses([ball], [wanted])[0], pose, atol=1e-4)
    run("add_lock")


def test_buttons_without_anything_to_take_say_so(scene):
    select(walker())
    for name, said in (
        ("keytimes_from_markers", "no timeline markers"),
        ("keytimes_to_markers", "no keytime was made of a marker"),
        ("keytimes_from_keys", None),
        ("use_curve", "there is no curve"),
        ("take_from_editor", "open the clip in the editor first"),
        ("synchronise", "choose with what"),
        ("propagate", "two or more say how a stretch was retimed"),
    ):
        if said is None:
            for curve in fcurves(bpy.context.object):
                for point in curve.keyframe_points:
                    point.select_control_point = False
            said = "no key of what is selected"
        with pytest.raises(RuntimeError, match=said):
            run(name)


def test_a_preview_changes_nothing_but_its_curve(scene):
    rig = walker()
    select(rig)
    scene.retime.search_length = "75%"
    action = rig.animation_data.action
    before = poses([rig], np.arange(1, 121, 11))
    run("preview")
    assert rig.animation_data.action == action
    np.testing.assert_array_equal(poses([rig], np.arange(1, 121, 11)), before)
    curve = fcurves(scene)[0]
    assert curve.data_path == '["retime_curve"]'
    assert all(point.interpolation == "LINEAR" for point in curve.keyframe_points)
    assert "speed" in scene.retime.summary


def test_what_was_previewed_is_what_the_curve_then_gives(scene):
    rig = walker()
    select(rig)
    scene.retime.search_length = "75%"
    run("preview")
    frames = np.arange(1, 91)
    wanted = poses([rig], shown(frames))
    scene.retime.tolerance = 0
    run("use_curve")
    np.testing.assert_allclose(poses([rig], frames), wanted, atol=1e-5)


def test_a_curve_with_bends_is_followed(scene):
    ball = swinging(empty())
    select(ball)
    draw_curve([(1, 1), (20, 40), (50, 55)])
    for point in fcurves(scene)[0].keyframe_points:
        point.interpolation = "BEZIER"
    scene.retime.tolerance = 0.0
    frames = np.arange(1, 51)
    at = np.array([fcurves(scene)[0].evaluate(frame) for frame in frames])
    wanted = poses([ball], at)
    run("use_curve")
    np.testing.assert_allclose(poses([ball], frames), wanted, atol=1e-5)


@pytest.mark.parametrize("kind", ["RANGE", "ACTION", "OBJECT", "FILE"])
def test_references(scene, kind, tmp_path):
    rig = walker()
    settings = scene.retime
    settings.search_length = "free"
    settings.reference_kind = kind
    if kind == "RANGE":
        settings.reference_start, settings.reference_end = 30, 80
    elif kind == "OBJECT":
        settings.reference_object = walker("other", seed=5, n_frames=90)
    elif kind == "ACTION":
        other = walker("other", seed=5, n_frames=90)
        settings.reference_action = other.animation_data.action
    else:
        other = walker("other", seed=5, n_frames=90)
        select(other)
        settings.reference_file = str(tmp_path / "other.bvh")
        bpy.ops.preferences.addon_enable(module="io_anim_bvh")
        bpy.ops.export_anim.bvh(filepath=settings.reference_file, frame_start=1, frame_end=90)
    select(rig)
    action, nla = rig.animation_data.action, rig.animation_data.use_nla
    assert run("preview") == {"FINISHED"}
    assert rig.animation_data.action == action
    assert rig.animation_data.use_nla == nla
    assert not [one for one in bpy.data.scenes if one.name.startswith("retime")]
    assert (np.diff(timing()[1]) > 0).all()


@pytest.mark.parametrize("kind", ["ACTION", "OBJECT", "FILE"])
def test_references_that_are_missing_are_asked_for(scene, kind):
    select(walker())
    scene.retime.reference_kind = kind
    with pytest.raises(RuntimeError, match=r"^Error: choose the"):
        run("retime")
    assert scene.retime.fault_field == "reference"
    scene.retime.reference_file = "/nowhere/at.bvh"
    if kind == "FILE":
        with pytest.raises(RuntimeError, match="nowhere"):
            run("retime")
        assert scene.retime.fault_field == "reference"


def test_an_action_that_moves_nothing_here_is_no_reference(scene):
    rig = walker()
    other = swinging(empty("ball"), path="scale")
    bone = walker("other").animation_data.action
    for curve in fcurves(bpy.data.objects["other"]):
        curve.data_path = curve.data_path.replace('bones["', 'bones["its ')
    select(rig)
    scene.retime.reference_kind = "ACTION"
    scene.retime.reference_action = bone
    action = rig.animation_data.action
    with pytest.raises(RuntimeError, match="otherAction moves nothing of walker: choose one that was made for it"):
        run("retime")
    assert scene.retime.fault_field == "reference"
    assert rig.animation_data.action == action
    # What moves the whole figure moves something of it.
    scene.retime.reference_action = other.animation_data.action
    assert run("preview") == {"FINISHED"}


def test_synchronise_keeps_step_with_another_object(scene):
    """A walk and the same walk with other timing, which is known: it is found again."""
    leader, follower = walker("leader"), walker("follower")
    select(leader)
    draw_curve([(1, 1), (30, 50), (70, 80), (100, 120)])
    known = shown(np.arange(1, 101))
    run("use_curve")
    select(follower)
    scene.retime.reference_kind, scene.retime.reference_object = "OBJECT", leader
    assert run("synchronise") == {"FINISHED"}
    to, at = timing()
    assert (to[0], to[-1]) == (1, 100)
    off = np.abs(np.interp(np.arange(1, 101), to, at) - known)
    assert np.median(off) < 1.0
    assert off.max() < 6


def swings(name="swings", n=8):
    """Make a figure that swings its arm n times, 24 frames each, on straight keys."""
    rig = walker(name, n_frames=2, extra_bones=False)
    rig.animation_data_clear()
    from rigs import turn

    for frame in range(1, 24 * n + 2, 3):
        for bone, shift in (("arm.L", 0.0), ("arm.R", 1.3), ("spine", 2.0)):
            turn(rig.pose.bones[bone], (0.8 * np.sin(2 * np.pi * (frame - 1) / 24 + shift), 0, 0), frame)
    return rig


@pytest.mark.parametrize("by", ["keytimes", "action"])
def test_propagate_carries_a_hands_timing_over(scene, by):
    rig = swings()
    select(rig)
    if by == "keytimes":
        scene.retime.example_start, scene.retime.example_end = 25, 49
        for frame, to in ((25, 25), (49, 73)):
            key = scene.retime.keys.add()
            key.frame, key.to = frame, to
    else:
        before = rig.animation_data.action
        rig.animation_data.action = before.copy()
        if hasattr(rig.animation_data, "action_slot"):
            rig.animation_data.action_slot = rig.animation_data.action.slots[0]
        for curve in fcurves(rig):
            for point in curve.keyframe_points:
                x = point.co.x
                point.co.x = x + min(max(0.0, x - 25), 24)
            curve.update()
        scene.retime.before = before
    assert run("propagate") == {"FINISHED"}
    to, at = timing()
    # All of it is half as fast now.
    assert to[-1] - to[0] == pytest.approx(2 * 24 * 8, rel=0.05)
    assert np.median(np.diff(at) / np.diff(to)) == pytest.approx(0.5, abs=0.05)
    last = max(curve.range()[1] for curve in fcurves(rig))
    assert last == pytest.approx(to[-1], abs=0.5)


def test_the_search_runs_beside_blender_and_stops(scene):
    """What the modal operator does, without a window: a thread that searches, and Esc."""
    rig = walker(n_frames=600, step=2)
    select(rig)
    scene.retime.search_length = "75%"
    job_module = module("job")
    job = job_module.prepare(bpy.data, scene, [rig], scene.retime, "RETIME")
    thread = threading.Thread(target=job.search)
    job.stop()
    begun = time.monotonic()
    thread.start()
    thread.join(20)
    assert not thread.is_alive()
    assert time.monotonic() - begun < 5
    with pytest.raises(job_module.Stopped):
        job.answered()
    # The next one is not stopped, and says how far it is.
    job = job_module.prepare(bpy.data, scene, [rig], scene.retime, "RETIME")
    thread = threading.Thread(target=job.search)
    thread.start()
    thread.join(60)
    assert 0 < job.share <= 1
    job.finish(bpy.data, scene)
    assert timing()[0][-1] == 450


class Window:
    """What a modal operator asks of Blender's window, written down."""

    def __init__(self, context):
        self.scene, self.objects_in_mode, self.mode = context.scene, [], "OBJECT"
        self.selected_objects, self.object = list(context.selected_objects), context.object
        self.window = self.window_manager = self.workspace = self
        self.timers, self.told, self.handlers, self.shares = [], [], [], []

    def event_timer_add(self, seconds, window):
        self.timers.append(seconds)
        return seconds

    def event_timer_remove(self, timer):
        self.timers.remove(timer)

    def progress_begin(self, low, high):
        self.shares = [low]

    def progress_update(self, share):
        self.shares.append(share)

    def progress_end(self):
        self.shares = []

    def modal_handler_add(self, operator):
        self.handlers.append(operator)

    def status_text_set(self, text):
        self.told.append(text)


@pytest.fixture
def pressed(scene, monkeypatch):
    """Give a function that presses Retime in a window."""
    rig = walker()
    operators = module("operators")
    monkeypatch.setattr(operators, "bpy", SimpleNamespace(app=SimpleNamespace(background=False), data=bpy.data))

    def press():
        select(rig)
        scene.retime.search_length = "75%"
        operator = operators._Searching()
        operator.report = lambda kinds, text: said.append(text)
        window, said = Window(bpy.context), []
        assert operator.invoke(window, None) == {"RUNNING_MODAL"}
        return operator, window, said

    return press


def events(operator, window, kind="TIMER"):
    """Send events until the operator is done."""
    until = time.monotonic() + 60
    while (result := operator.modal(window, SimpleNamespace(type=kind))) == {"RUNNING_MODAL"}:
        assert time.monotonic() < until
        time.sleep(0.005)
    return result


def test_with_a_window_the_search_tells_how_far_it_is(scene, pressed):
    operator, window, said = pressed()
    assert events(operator, window) == {"FINISHED"}
    assert (window.timers, window.shares, window.told[-1]) == ([], [], None)
    assert timing()[0][-1] == 90
    assert said == [scene.retime.summary.split("\n")[0]]


@pytest.fixture
def endless(scene, monkeypatch):
    """Have searches go on until somebody stops them."""

    def search(asked, tell):
        while True:
            tell(0.5)
            time.sleep(0.001)

    monkeypatch.setattr(module("job"), "answer", search)


def test_esc_in_a_window_changes_nothing(scene, endless, pressed):
    operator, window, said = pressed()
    action = bpy.context.object.animation_data.action
    assert events(operator, window, "ESC") == {"CANCELLED"}
    assert said == ["Stopped; nothing was changed"]
    assert (window.timers, window.shares, window.told[-1]) == ([], [], None)
    assert bpy.context.object.animation_data.action == action
    assert scene.animation_data is None


def test_a_window_that_is_closed_ends_the_search(scene, endless, pressed):
    operator, window, _ = pressed()
    operator.cancel(window)
    operator._thread.join(60)
    assert not operator._thread.is_alive()
    assert window.timers == []
    with pytest.raises(module("job").Stopped):
        operator._job.answered()


def test_the_editor_gets_the_clip_and_gives_its_timing_back(scene, tmp_path):
    rig = walker()
    select(rig)
    scene.retime.search_length = "75%"
    key = scene.retime.keys.add()
    key.frame, key.to = 61, 41
    if os.name == "nt":
        pytest.skip("a script stands for the command")
    # A command that writes down what it is called with.
    command = tmp_path / "retime"
    command.write_text(f'#!/bin/sh\necho "$@" > {tmp_path}/called\n', encoding="utf-8")
    command.chmod(command.stat().st_mode | stat.S_IEXEC)
    bpy.context.preferences.addons[PACKAGE].preferences.command = str(command)
    assert run("open_editor") == {"FINISHED"}
    until = time.monotonic() + 20
    while not (tmp_path / "called").is_file() or not (tmp_path / "called").read_text():
        assert time.monotonic() < until
        time.sleep(0.05)
    assert (tmp_path / "called").read_text().split() == ["edit", "--project", scene.retime.project]

    from retime.project.file import read_project

    document = read_project(scene.retime.project).document
    assert document.options == {"length": "75%"}
    assert document.clips[0].up == "z"
    assert document.keys[0].input_time == pytest.approx(60 / 24)
    # What Blender finds by itself is what the editor's document comes to.
    run("preview")
    to, at = timing()
    frames = np.arange(1, 91)
    old = rig.animation_data.action
    assert run("take_from_editor") == {"FINISHED"}
    again_to, again_at = timing()
    # A BVH holds six digits, and not how long its unit is: the choice is a little another one.
    np.testing.assert_allclose(np.interp(frames, again_to, again_at), np.interp(frames, to, at), atol=1.5)
    assert (again_to[-1], np.interp(41, again_to, again_at)) == (90, pytest.approx(61, abs=1e-3))
    now = poses([rig], frames)
    rig.animation_data.action = old
    np.testing.assert_allclose(now, poses([rig], shown(frames)), atol=1e-5)


@pytest.mark.parametrize(
    ("script", "said"),
    [
        (None, r"No such file or directory: name the retime command in the preferences"),
        ("#!/bin/sh\nexit 3\n", r"retime ended with 3 and said nothing\. It needs retime of this version: pip install"),
        ("#!/bin/sh\necho 1 >&2\necho no websockets >&2\nexit 1\n", r"did not start: no websockets\. It needs retime"),
    ],
)
@pytest.mark.skipif(os.name == "nt", reason="a script stands for the command")
def test_an_editor_that_does_not_start_says_so(scene, tmp_path, script, said):
    select(walker())
    command = tmp_path / "retime"
    if script is not None:
        command.write_text(script, encoding="utf-8")
        command.chmod(command.stat().st_mode | stat.S_IEXEC)
    bpy.context.preferences.addons[PACKAGE].preferences.command = str(command)
    with pytest.raises(RuntimeError, match=said):
        run("open_editor")
    assert scene.retime.fault_field == "editor"
    assert scene.retime.project == ""


@pytest.mark.skipif(os.name == "nt", reason="a script stands for the command")
def test_an_editor_that_serves_is_waited_for_no_longer(scene, tmp_path):
    select(walker())
    command = tmp_path / "retime"
    command.write_text("#!/bin/sh\necho editing at http://127.0.0.1:1/\nexec sleep 15\n", encoding="utf-8")
    command.chmod(command.stat().st_mode | stat.S_IEXEC)
    bpy.context.preferences.addons[PACKAGE].preferences.command = str(command)
    begun = time.monotonic()
    assert run("open_editor") == {"FINISHED"}
    assert time.monotonic() - begun < 9
    assert scene.retime.project.endswith("_from_1.retime")


def test_a_project_from_elsewhere_is_refused(scene, tmp_path):
    select(walker())
    (tmp_path / "other.retime").write_text("{}", encoding="utf-8")
    scene.retime.project = str(tmp_path / "other.retime")
    with pytest.raises(RuntimeError, match="was not opened from here"):
        run("take_from_editor")
    (tmp_path / "a_from_1.retime").write_text("{", encoding="utf-8")
    scene.retime.project = str(tmp_path / "a_from_1.retime")
    with pytest.raises(RuntimeError, match=r"a_from_1\.retime"):
        run("take_from_editor")
