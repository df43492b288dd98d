"""FBX retimed in place: each curve has at t what it had at warp(t); what was not asked to change did not."""

from __future__ import annotations

import itertools
import struct
import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import retime
from retime.errors import FormatError, FormatWarning
from retime.formats import registry
from retime.formats.curves.fbx import format as fbx
from retime.formats.curves.fbx.curve import Keys, resolved
from retime.formats.curves.fbx.motion import sample_stack
from retime.formats.curves.fbx.scene import FbxScene, parse_fbx
from retime.formats.curves.fbx.span import extended, read_stack
from retime.formats.in_place import retime_file
from retime.formats.read_options import Limits, ReadOptions
from retime.motion import rotation
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from tests.formats.curves.fbx.files import (
    AUTO,
    CONSTANT,
    CUBIC,
    INDEPENDENT,
    LINEAR,
    NEXT,
    PROGRESSIVE,
    TCB,
    TICKS,
    USER,
    Builder,
    Track,
    drawn_fbx,
    drawn_track,
    node,
    prop,
    text,
    track,
)
from tests.reference import fbx as literal
from tests.reference.fbx import Scene as Literal
from tests.warp.drawn import drawn_warp

FBX = Path(__file__).parents[5] / "shared" / "mocap" / "fbx"
needs_captures = pytest.mark.skipif(not FBX.is_dir(), reason="the captures are not beside the project (../shared)")
CAPTURES = [
    "animation_with_skeleton.fbx",
    "blender440_shape_weight_anim_7400_binary.fbx",
    "maya_anim_layers_7500_binary.fbx",
    "maya_game_sausage_7500_binary_wiggle.fbx",
    "maya_interpolation_modes_7500_ascii.fbx",
    "maya_interpolation_modes_7500_binary.fbx",
]
PLACE = Path("a.fbx")


def layouts(made: Builder) -> dict[str, bytes]:
    """The same scene in every form that a file may have."""
    return {
        "32 bits": made.binary(7400),
        "32 bits, compressed": made.binary(7300, packed=True),
        "64 bits": made.binary(7500),
        "64 bits, compressed": made.binary(7700, packed=True),
        "text": made.ascii(7500),
        "text before 7200, other line ends": made.ascii(7100, "\r\n"),
    }


LAYOUTS = list(layouts(Builder()))


def retimed(data: bytes, warp, **options) -> bytes:
    return fbx.retime(PLACE, data, warp, ReadOptions(**options))[""]


def one_curve(one, stop: float | None = None) -> Builder:
    """A limb that slides by one curve."""
    made = Builder()
    limb = made.model("limb")
    stack = made.stack("take", 0.0, stop) if stop else made.stack("take")
    made.animate(made.layer(stack), limb, "Lcl Translation", {"X": one})
    return made


def only(data: bytes) -> literal.Curve:
    (curve,) = Literal(data).curves.values()
    return curve


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(LAYOUTS))
def test_curves_evaluate_to_their_definition(seed: int, layout: str) -> None:
    data = layouts(drawn_fbx(seed, 0.25))[layout]
    scene = parse_fbx(PLACE, data, Limits())
    curves = read_stack(scene, scene.stacks[0])
    old, _ = extended(scene, curves, -1.0, 4.0)
    times = np.random.default_rng(seed).uniform(-1, 4, 25)
    wanted = Literal(data).curves
    assert len(curves.records) == len(wanted)
    for index, record in enumerate(curves.records):
        values = [wanted[record.item.id].value(time) for time in times.tolist()]
        np.testing.assert_allclose(old.batch.curve(index)(times)[:, 0], values, rtol=0, atol=2e-5)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(LAYOUTS), st.booleans())
def test_every_curve_has_at_t_what_it_had_at_the_warps_time(seed: int, layout: str, forward: bool) -> None:
    rng = np.random.default_rng(seed)
    start = round(rng.uniform(0, 2) * 30) / 30
    data = layouts(drawn_fbx(seed, start))[layout]
    warp = drawn_warp(rng, int(rng.integers(2, 8)), forward=forward)
    span = 1.2 * (np.ptp(warp.input_times) + 1e-9)
    warp = Warp(warp.output_times - warp.output_start, 3 * (warp.input_times - warp.input_times.min()) / span - 0.1)
    before, after = Literal(data).curves, Literal(retimed(data, warp)).curves
    times = rng.uniform(warp.output_start, warp.output_end, 25)
    shown = warp(times) + start
    for number, old in before.items():
        new = after[number]
        largest = np.abs(old.values + new.values).max()
        for time, there in zip((times + start).tolist(), shown.tolist(), strict=True):
            # Where a curve steps, a rounding of the time decides.
            if np.abs(np.subtract(old.times, there)).min() > 1e-6 and np.abs(np.subtract(new.times, time)).min() > 1e-9:
                assert new.value(time) == pytest.approx(old.value(there), abs=1e-5 * largest)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_file_is_itself_where_nothing_changes(layout: str) -> None:
    data = layouts(drawn_fbx(5, 0.5))[layout]
    assert parse_fbx(PLACE, data, Limits()).file.rewritten({}) == data
    # Shown as it was: every key, flag and attribute comes out the same.
    scene = parse_fbx(PLACE, data, Limits())
    curves = read_stack(scene, scene.stacks[0])
    end = curves.end - curves.start
    assert retimed(data, Warp([0.0, end], [0.0, end])) == data


@pytest.mark.parametrize("layout", LAYOUTS)
def test_what_changes_are_curves_and_times_and_nothing_else(layout: str) -> None:
    data = layouts(drawn_fbx(6))[layout]
    new = retimed(data, Warp([0.0, 1.0, 3.0], [0.0, 1.5, 2.5]))

    def leaves(records, path=()):
        for name, values, inner in records:
            here = (*path, (name, repr(values[:1]) if name not in ("P", "C") else repr(values[:4])))
            yield here, values
            yield from leaves(inner, here)

    before, after = list(leaves(Literal(data).records)), list(leaves(Literal(new).records))
    assert len(before) == len(after)
    allowed = {"KeyTime", "KeyValueFloat", "KeyAttrFlags", "KeyAttrDataFloat", "KeyAttrRefCount"}
    allowed |= {"LocalTime", "ReferenceTime"}
    changed = set()
    for (path, values), (_, others) in zip(before, after, strict=True):
        if values != others:
            name = path[-1][0]
            changed.add(str(values[0]) if name == "P" else name)
            times = ("LocalSt", "ReferenceSt", "TimeSpanSt")
            assert name in allowed or (name == "P" and any(one in repr(values[0]) for one in times))
    assert {"KeyTime", "LocalTime", "ReferenceTime"} <= changed
    if "text" in layout:
        # Text that isn't touched stays, its comments and line ends too.
        end = b"\r\n" if b"\r\n" in data else b"\n"
        lines, others = data.split(end), new.split(end)
        kept = [line for line in lines if b"Vertices" in line or b"limb" in line or b"FBX" in line or b"C:" in line]
        assert all(line in others for line in kept)
        assert b";KeyTime: told" in data
        # Comments that told the old numbers are gone.
        curves, new_curves = Literal(data).curves, Literal(new).curves
        same = [old for number, old in curves.items() if vars(old) == vars(new_curves[number])]
        assert len(same) < len(curves) / 2
        assert len([line for line in others if b"told in a comment" in line]) == 1 + 5 * len(same)
    else:
        mesh = next(values[0] for path, values in before if path[-1][0] == "Vertices")
        assert struct.pack("<9d", *mesh) in new or "compressed" in layout
        assert len(new) % 16 == len(data) % 16


def test_retiming_again_and_again_does_not_grow_the_file() -> None:
    data = drawn_fbx(4).binary(7500)
    sizes = []
    for _ in range(4):
        data = retimed(data, Warp([0.0, 4.0], [0.0, 4.0]))
        sizes.append(len(data))
    assert len(set(sizes)) == 1


def test_a_hold_and_a_span_played_backward() -> None:
    data = one_curve(track([0.0, 2.0], [0.0, 2.0], LINEAR)).binary()
    new = only(retimed(data, Warp([0.0, 1.0, 2.0, 3.0], [0.0, 1.5, 1.5, 1.0])))
    assert new.times == [0.0, 1.0, 2.0, 3.0]
    assert new.values == [0.0, 1.5, 1.5, 1.0]


def test_a_key_further_off_than_any_that_is_read_is_refused() -> None:
    """A curve between two keys that are zero overshoots by its slopes, and a cut makes a key of it."""
    data = one_curve(track([0.0, 90.0], [0.0, 0.0], CUBIC | USER, [(9e29, 0.0), (0.0, 0.0)])).binary()
    with pytest.raises(FormatError, match="key 1 of a curve has a value that is not finite, or beyond any use"):
        retimed(data, Warp([0.0, 10.0, 70.0], [0.0, 30.0, 90.0]))
    # What goes straight on as steeply as its last keys, a tick apart, is soon beyond what single precision holds.
    steep = replace(track([0.0, 1.0, 1.0 + 1 / TICKS], [0.0, 0.0, 1e29], LINEAR), post="K")
    with pytest.raises(FormatError, match="of a curve has a value that is not finite, or beyond any use"):
        retimed(one_curve(steep, 2.0).binary(), Warp([0.0, 3.0], [0.0, 2.0]))


def test_a_step_played_backward_jumps_where_its_key_was() -> None:
    data = one_curve(track([0.0, 1.0, 2.0], [1.0, 5.0, 9.0], CONSTANT)).binary()
    new = only(retimed(data, Warp([0.0, 2.0], [2.0, 0.0])))
    assert [new.value(time) for time in (0.5, 0.999, 1.001, 1.5)] == [5.0, 5.0, 1.0, 1.0]
    # What leads to the jump on a straight line is kept by a step to the next key's value.
    data = one_curve(track([0.0, 1.0, 2.0], [1.0, 5.0, 9.0], [CONSTANT, LINEAR, LINEAR])).binary()
    new = only(retimed(data, Warp([0.0, 2.0], [2.0, 0.0])))
    assert [round(new.value(time), 6) for time in (0.5, 1.0 - 1e-9, 1.0 + 1e-9, 1.5)] == [7.0, 5.0, 1.0, 1.0]
    assert new.flags[1] == CONSTANT | NEXT


def test_a_step_to_the_next_keys_value_stays_one() -> None:
    data = one_curve(
        track([0.0, 1.0, 2.0, 3.0], [1.0, 5.0, 9.0, 2.0], [LINEAR, CONSTANT | NEXT, LINEAR, LINEAR])
    ).binary()
    new = only(retimed(data, Warp([0.0, 6.0], [0.0, 3.0])))
    assert new.ticks == [0, 2 * TICKS, 4 * TICKS, 6 * TICKS]
    assert new.values == [1.0, 5.0, 9.0, 2.0]
    assert new.flags[1] == CONSTANT | NEXT
    assert [new.value(time) for time in (1.0, 2.001, 3.9)] == [3.0, 9.0, 9.0]
    # Before a first key of that kind the curve has that key's value.
    data = one_curve(track([1.0, 2.0], [4.0, 6.0], CONSTANT | NEXT), 3.0).binary()
    new = only(retimed(data, Warp([0.0, 3.0], [0.0, 3.0])))
    assert [new.value(time) for time in (0.5, 1.5)] == [4.0, 6.0]


def test_automatic_keys_stay_so_where_their_slope_does() -> None:
    flags = CUBIC | AUTO | INDEPENDENT | PROGRESSIVE
    data = one_curve(track(np.arange(6.0), [0.0, 2.0, 3.0, 5.0, 5.5, 8.0], flags)).binary()
    slower = only(retimed(data, Warp([0.0, 10.0], [0.0, 5.0])))
    assert slower.flags == [flags] * 6
    # Where the speed changes between two keys, there and beside it slopes are given.
    bent = only(retimed(data, Warp([0.0, 2.5, 7.5], [0.0, 2.5, 5.0])))
    assert [flag & USER != 0 for flag in bent.flags] == [False, False, True, True, True, False, False]
    assert len(bent.times) == 7


def test_a_key_by_tension_continuity_and_bias_is_told_apart_by_both_its_slopes() -> None:
    # With a continuity of -1 what lies before such a key bends how it is reached, not how it is left.
    one = track(np.arange(4.0), [0.0, 2.0, -3.0, 5.0], CUBIC | TCB)
    one.data[:, 1] = np.array([-1.0], "<f4").view(np.uint32)
    data = one_curve(one).binary()
    warp = Warp([0.0, 1.0, 3.0, 6.0], [0.0, 0.5, 1.0, 3.0])
    old, new = only(data), only(retimed(data, warp))
    for time in np.linspace(0.01, 5.99, 60):
        assert new.value(time) == pytest.approx(old.value(float(warp(time))), abs=1e-5)


def test_curves_that_differ_in_what_they_hold_keep_their_order(tmp_path: Path) -> None:
    # One key, keys at one time, no key at all.
    made = Builder()
    limb = made.model("limb")
    layer = made.layer(made.stack("take"))
    twice = track([0.0, 1.0, 1.0, 2.0], [0.0, 1.0, 5.0, 6.0], LINEAR)
    made.animate(layer, limb, "Lcl Translation", {"X": track([0.5], [3.0], LINEAR), "Y": twice})
    empty = track([], [], LINEAR)
    numbers = made.animate(layer, limb, "Lcl Rotation", {"X": empty})
    data = made.binary()
    new = retimed(data, Warp([0.0, 4.0], [0.0, 2.0]))
    scene = parse_fbx(PLACE, new, Limits())
    curves = read_stack(scene, scene.stacks[0])
    old, _ = extended(scene, curves, 0.0, 4.0)
    np.testing.assert_allclose(old.batch.curve(0)(np.array([0.1, 3.0]))[:, 0], [3.0, 3.0])
    np.testing.assert_allclose(
        old.batch.curve(1)(np.array([1.0, 1.999, 2.001, 3.0]))[:, 0], [0.5, 1.0, 5.0, 5.5], atol=1e-3
    )
    assert len(curves.records) == 2
    # A jump that no flag says takes two keys, one tick apart.
    assert np.diff(curves.keys.ticks[1:]).tolist() == [2 * TICKS - 1, 1, 2 * TICKS]
    assert scene.items[numbers[0]].record.child("KeyTime") is not None


def stack_times(data: bytes, name: str = "take") -> dict[str, float]:
    """Seconds of what says when an animation, and the scene, begins and ends."""
    scene = parse_fbx(PLACE, data, Limits())
    stack = next(one for one in scene.stacks if one.name == name)
    found = {}
    for table in (scene.properties(stack.item), scene.settings):
        for key, (_, values) in table.items():
            if key.endswith(("Start", "Stop")):
                found[key] = values[4].content / TICKS
    takes = scene.file.section("Takes")
    assert takes is not None
    for take in takes.children:
        if take.name == "Take" and scene.file.values(take)[0].content == name:
            for key in ("LocalTime", "ReferenceTime"):
                record = take.child(key)
                assert record is not None
                found[key + " 0"], found[key + " 1"] = (one.content / TICKS for one in scene.file.values(record))
    return found


@pytest.mark.parametrize(
    ("warp", "start", "stop"),
    [
        (Warp([0.0, 5.0], [0.0, 2.5]), 0.5, 5.5),
        (Warp([0.0, 2.5], [2.5, 0.0]), 0.5, 3.0),  # backward
        (Warp([0.0, 1.0, 2.0], [0.0, 2.5, 0.0]), 0.5, 2.5),  # there and back
        (Warp([0.0, 1.0], [0.5, 1.5]), 0.5, 1.5),  # a part
    ],
)
def test_times_of_stack_take_and_scene_follow(warp: Warp, start: float, stop: float) -> None:
    for data in layouts(drawn_fbx(8, 0.5)).values():
        found = stack_times(retimed(data, warp))
        for key, time in found.items():
            wanted = start if key.endswith(("Start", " 0")) else stop
            if not key.startswith("TimeSpan"):
                assert time == pytest.approx(wanted, abs=1e-9), key
        # What of the scene's own span lies outside the stack's keeps its distance from it; inside it is mapped.
        assert found["TimeSpanStart"] == pytest.approx(0.0)
        assert 0.0 < found["TimeSpanStop"] <= stop


def test_endless_times_stay_so_and_spans_reach_beyond_keys() -> None:
    made = one_curve(track([1.0, 2.0], [0.0, 1.0], LINEAR))
    stack = next(one for one in made.objects if one[0] == "AnimationStack")
    table = stack[2][0][2]
    endless = 2**63 - 1
    table += [node("P", text("LocalStop"), text("KTime"), text("Time"), text(""), ("L", endless))]
    new = retimed(made.binary(), Warp([0.0, 2.0], [0.0, 1.0]))
    assert only(new).times == [1.0, 3.0]
    assert parse_fbx(PLACE, new, Limits()).stacks[0].name == "take"
    # A stack that goes on after its keys is that long.
    long = one_curve(track([1.0, 2.0], [0.0, 1.0], LINEAR), 10.0).binary()
    clip = fbx.read(PLACE, long, ReadOptions(rate=10))
    assert clip.n_frames == 101
    assert stack_times(retimed(long, Warp([0.0, 5.0], [0.0, 10.0])))["LocalStop"] == pytest.approx(5.0)


@pytest.mark.parametrize(("mode", "repetition"), list(itertools.product("RAMK", [-1, 0, 1, 2])))
def test_what_a_curve_does_beyond_its_keys_becomes_keys(mode: str, repetition: int) -> None:
    one = drawn_track(np.random.default_rng(3), 4, start=2.0)
    data = one_curve(replace(one, pre=mode, post=mode, repetition=repetition), 8.0).binary()
    warp = Warp([0.0, 4.0, 6.0], [0.0, 8.0, 6.5])
    with pytest.warns(FormatWarning, match="1 curves go on beyond their keys"):
        new = only(retimed(data, warp))
    old = only(data)
    assert (old.pre, new.pre, new.post) == ((mode, repetition), ("C", repetition), ("C", repetition))
    largest = np.abs(new.values).max()
    for time in np.random.default_rng(1).uniform(0, 6, 120):
        if np.abs(np.subtract(new.times, time)).min() > 1e-6:
            assert new.value(time) == pytest.approx(old.value(float(warp(time))), abs=1e-5 * largest)


def test_a_curve_that_goes_on_only_outside_its_stack_stays_a_loop() -> None:
    one = replace(track([0.0, 1.0], [0.0, 4.0], LINEAR), pre="M", post="R")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        new = only(retimed(one_curve(one).binary(), Warp([0.0, 2.0], [0.0, 1.0])))
    assert (new.pre, new.post) == (("M", -1), ("R", -1))
    assert new.value(2.5) == pytest.approx(1.0)
    # Where it reaches to one side only, the other stays.
    with pytest.warns(FormatWarning, match="1 curves go on"):
        new = only(retimed(one_curve(one, 3.0).binary(), Warp([0.0, 3.0], [0.0, 3.0])))
    assert (new.pre[0], new.post[0]) == ("M", "C")
    # What would be millions of keys is refused.
    with pytest.raises(FormatError, match="is repeated"):
        retimed(one_curve(replace(one, ticks=np.array([0, 9])), 1e5).binary(), Warp([0.0, 1e5], [0.0, 1e5]))


def two_takes() -> Builder:
    made = Builder()
    limb = made.model("limb")
    for name in ("walk", "run"):
        layer = made.layer(made.stack(name, 0.0, 1.0))
        made.animate(layer, limb, "Lcl Translation", {"X": track([0.0, 1.0], [0.0, 1.0], LINEAR)})
    made.stack("empty")
    return made


def test_several_animations_are_named_and_the_first_is_read() -> None:
    data = two_takes().binary()
    assert fbx.animation_names(PLACE, data, ReadOptions()) == ["walk", "run"]
    with pytest.warns(FormatWarning, match=r"2 animations \(walk, run\); walk is read"):
        assert fbx.read(PLACE, data, ReadOptions()).name == "walk"
    assert fbx.read(PLACE, data, ReadOptions(animation="run")).name == "run"
    assert fbx.read(PLACE, data, ReadOptions(animation="1")).name == "run"
    for name in ("jump", "empty", "2", "²", "9" * 100):
        with pytest.raises(FormatError, match=f"no animation is called '{name}'; there are walk, run"):
            fbx.read(PLACE, data, ReadOptions(animation=name))
    # Each gets its own timing; the one that isn't meant stays.
    new = retimed(data, {"run": Warp([0.0, 3.0], [0.0, 1.0])})
    assert [curve.times for curve in Literal(new).curves.values()] == [[0.0, 1.0], [0.0, 3.0]]
    assert stack_times(new, "walk")["LocalStop"] == 1.0
    assert stack_times(new, "run")["LocalTime 1"] == 3.0


def test_a_curve_that_animations_share_is_refused() -> None:
    made = two_takes()
    curves = [one for one in made.objects if one[0] == "AnimationCurve"]
    nodes = [one for one in made.objects if one[0] == "AnimationCurveNode"]
    made.link(curves[0][1][0][1], nodes[1][1][0][1], "d|Y")
    with pytest.raises(FormatError, match="'walk' and 'run' share a curve"):
        retimed(made.binary(), Warp([0.0, 2.0], [0.0, 1.0]))


def sampled(data: bytes, rate: int = 30):
    scene = parse_fbx(PLACE, data, Limits())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        return scene, sample_stack(scene, read_stack(scene, scene.stacks[0]), rate, Limits())


def literal_poses(scene: FbxScene, data: bytes, time: float):
    """Poses of the limbs of `drawn_fbx`, with its two layers, by the definition."""
    curves = Literal(data).curves

    def shown(layer, item, name, missing):
        for held in layer.nodes:
            if (item, name) in [(one, prop) for one, prop in held.targets]:
                start = [scene.numbers(held.item, f"d|{axis}", (0.0,))[0] for axis in "XYZ"]
                return [
                    curves[held.curves[f"d|{axis}"].id].value(time) if f"d|{axis}" in held.curves else start[i]
                    for i, axis in enumerate("XYZ")
                ]
        return missing

    base, top = scene.stacks[0].layers
    weight = next(
        curves[held.curves["d|Weight"].id].value(time) / 100 for held in top.nodes if "d|Weight" in held.curves
    )
    poses = {}
    for item in scene.items.values():
        if item.kind != "Model":
            continue
        props = {
            name: scene.numbers(item, name, (0.0,) * 3).tolist()
            for name in scene.properties(item)
            if "Rotation" in name[3:]
        }
        props = {name: values for name, values in props.items() if name in ("PreRotation", "PostRotation")}
        for name in ("RotationPivot", "ScalingOffset"):
            props[name] = scene.numbers(item, name, (0.0,) * 3).tolist()
        props["Lcl Translation"] = shown(base, item, "Lcl Translation", None)
        props["Lcl Scaling"] = shown(base, item, "Lcl Scaling", [1.0] * 3)
        order = ["XYZ", "XZY", "YZX", "YXZ", "ZXY", "ZYX"][scene.whole(item, "RotationOrder", 0)]
        turned = shown(base, item, "Lcl Rotation", None)
        more = shown(top, item, "Lcl Rotation", [0.0] * 3)
        if scene.whole(top.item, "RotationAccumulationMode", 0):
            turned = literal.euler([a + weight * b for a, b in zip(turned, more, strict=True)], order)
        else:
            turned = literal.times(literal.euler(turned, order), literal.part_of(literal.euler(more, order), weight))
        poses[item.name] = literal.node_pose(turned, props)
    return poses


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(LAYOUTS))
def test_a_motion_has_the_poses_that_the_file_describes(seed: int, layout: str) -> None:
    data = layouts(drawn_fbx(seed))[layout]
    scene, found = sampled(data)
    assert isinstance(found.clip, Motion)
    assert found.clip.skeleton.parents == (-1, 0, 1)
    for frame in (1, 17, 40):
        wanted = literal_poses(scene, data, float(found.values.times[frame]))
        for joint, item in enumerate(found.nodes):
            assert item is not None
            turned, placed = wanted[item.name]
            matrix = rotation.to_matrix(found.clip.rotations[frame, joint])
            np.testing.assert_allclose(matrix, turned, atol=1e-6)
            scale = found.scales[joint]
            np.testing.assert_allclose(
                found.clip.local_translations[frame, joint], np.multiply(placed, scale), atol=1e-5 * scale
            )


def test_scale_of_parents_reaches_their_children_as_they_inherit_it() -> None:
    for inherit, wanted in ((0, 24.0), (1, 24.0), (2, 12.0)):
        made = Builder()
        top = made.model("top", Lcl_Scaling=[3.0, 3.0, 3.0])
        middle = made.model("middle", top, Lcl_Scaling=[2.0, 2.0, 2.0])
        low = made.model("low", middle, InheritType=inherit, Lcl_Scaling=[4.0, 4.0, 4.0])
        end = made.model("end", low, Lcl_Translation=[1.0, 0.0, 0.0])
        slide = {"X": track([0.0, 1.0], [1.0, 2.0], LINEAR)}
        made.animate(made.layer(made.stack("take")), end, "Lcl Translation", slide)
        clip = fbx.read(PLACE, made.binary(), ReadOptions(rate=10))
        assert isinstance(clip, Motion)
        assert clip.local_translations[0, 3, 0] == pytest.approx(wanted)


def test_axes_unit_and_rate_are_those_that_the_scene_declares() -> None:
    made = one_curve(track([0.0, 1.0], [0.0, 1.0], LINEAR))
    made.settings = [("UpAxis", ("I", 2)), ("UnitScaleFactor", ("D", 2.54)), ("TimeMode", ("I", 9))]
    clip = fbx.read(PLACE, made.binary(), ReadOptions())
    assert isinstance(clip, Motion)
    assert (clip.up, clip.metres_per_unit) == ("z", pytest.approx(0.0254))
    assert clip.rate == retime.motion.rate.parse_rate("29.97")
    # A rate of its own; one that keys lie between is no rate of theirs.
    made.settings = [
        ("UpAxis", ("I", 0)),
        ("UpAxisSign", ("I", -1)),
        ("TimeMode", ("I", 14)),
        ("CustomFrameRate", ("D", 12.5)),
    ]
    made.objects[-1:] = [track([0.0, 0.08, 0.8], [0.0, 1.0, 2.0], LINEAR).record(made.number)]
    clip = fbx.read(PLACE, made.binary(), ReadOptions())
    assert isinstance(clip, Motion)
    assert (clip.rate, clip.skeleton.names) == (12.5, ("scene", "limb"))
    # What lies down the X axis lies above.
    np.testing.assert_allclose(clip.positions[-1, 1], [0.0, -2.0, 0.0], atol=1e-9)
    made.settings = [("TimeMode", ("I", 11))]
    made.objects[-1:] = [track([0.0, 1 / 120, 1.0], [0.0, 1.0, 2.0], LINEAR).record(made.number)]
    assert fbx.read(PLACE, made.binary(), ReadOptions()).rate == 120


def test_what_moves_no_node_is_a_signal() -> None:
    made = Builder()
    shape = made.add("Deformer", "smile", "SubDeformer", "BlendShapeChannel", [prop("DeformPercent", ("D", 0.0))])
    light = made.add(
        "NodeAttribute", "lamp", "NodeAttribute", "Light", [prop("Color", ("D", 1.0), ("D", 1.0), ("D", 1.0))]
    )
    still = made.model("still")
    layer = made.layer(made.stack("talk"))
    made.animate(layer, shape, "DeformPercent", {"DeformPercent": track([0.0, 1.0], [0.0, 100.0], LINEAR)})
    made.animate(layer, light, "Color", {"Y": track([0.0, 1.0], [1.0, 0.0], LINEAR)}, X=0.5, Z=0.25)
    made.animate(layer, still, "Lcl Translation", {"X": track([0.0, 1.0], [2.0, 2.0], LINEAR)})
    data = made.binary()
    clip = fbx.read(PLACE, data, ReadOptions(rate=4))
    assert isinstance(clip, Signal)
    assert clip.names[:4] == ("smile.DeformPercent", "lamp.Color.X", "lamp.Color.Y", "lamp.Color.Z")
    np.testing.assert_allclose(clip.values[2, :4], [50.0, 0.5, 0.5, 0.25])
    for average in (True, False):
        new = fbx.bake(PLACE, data, Warp([0.0, 0.5], [0.0, 1.0]), ReadOptions(rate=4), average=average)[""]
        found = fbx.read(PLACE, new, ReadOptions(rate=4))
        wanted = apply_warp(clip, Warp([0.0, 0.5], [0.0, 1.0]), average=average)
        assert isinstance(found, Signal)
        np.testing.assert_allclose(found.values, wanted.values, atol=1e-5)


def test_baked_frames_are_those_of_the_motion_retimed() -> None:
    for seed, binary in ((6, True), (7, False)):
        made = drawn_fbx(seed)
        # One layer: the first.
        tops = {one[1][0][1] for one in made.objects if "top" in repr(one[1])}
        made.links = [one for one in made.links if not tops & {one[1][1][1], one[1][2][1]}]
        data = made.binary(7500, packed=True) if binary else made.ascii()
        options = ReadOptions(rate=40)
        clip = fbx.read(PLACE, data, options)
        assert isinstance(clip, Motion)
        warp = Warp([0.0, clip.end_time / 2], [0.0, clip.end_time])
        for average in (True, False):
            new = fbx.bake(PLACE, data, warp, options, average=average)[""]
            scene, found = sampled(new, 40)
            wanted = apply_warp(clip, warp, average=average)
            assert isinstance(found.clip, Motion)
            assert found.clip.n_frames >= wanted.n_frames
            n = wanted.n_frames
            places = {name: joint for joint, name in enumerate(found.clip.skeleton.names)}
            for joint, name in enumerate(wanted.skeleton.names):
                q = found.clip.rotations[:n, places[name]]
                np.testing.assert_allclose(np.abs((q * wanted.rotations[:, joint]).sum(axis=1)), 1, atol=1e-9)
            curve = next(iter(Literal(new).curves.values()))
            assert np.ptp(np.diff(curve.ticks)) <= 1
            assert curve.flags[0] in (LINEAR | USER, CONSTANT)
            assert scene.stacks[0].name == "take"


def _edited(data: bytes, old: bytes, new: bytes) -> bytes:
    assert old in data
    return data.replace(old, new, 1)


def _claims(data: bytes, name: bytes) -> bytes:
    """Let an array claim more numbers than it holds."""
    place = data.index(name) + len(name)
    return data[: place + 1] + struct.pack("<I", 2**31 - 1) + data[place + 5 :]


def _cycle(made: Builder) -> bytes:
    limbs = [one[1][0][1] for one in made.objects if one[0] == "Model"]
    made.links = [one for one in made.links if one[1][1][1] != limbs[0] or one[1][0][1] != "OO"]
    made.link(limbs[0], limbs[2])
    return made.binary()


BROKEN = {
    "empty": (lambda: b"", "empty"),
    "a picture": (lambda: b"\x89PNG\r\n\x1a\n" + b"0" * 99, "a PNG picture, not an FBX"),
    "version 6100": (lambda: drawn_fbx(1).binary(6100), r"FBX 6\.1 .* export it as"),
    "text of version 6100": (lambda: drawn_fbx(1).ascii(6100), r"FBX 6\.1 .* export it as"),
    "a later version": (lambda: drawn_fbx(1).binary(8000), "version 8000 is not known"),
    "other byte order": (lambda: b"Kaydara FBX Binary  \0\x1a\1" + b"\0" * 99, "byte order"),
    "encrypted": (
        lambda: replace(drawn_fbx(1), header=[node("EncryptionType", ("I", 1))]).binary(),
        "encrypted",
    ),
    "no animation": (lambda: Builder().binary(), "no animation"),
    "claimed numbers": (lambda: _claims(drawn_fbx(1).binary(), b"KeyTime"), "claims 2147483647 numbers"),
    "a bomb": (lambda: _claims(drawn_fbx(1).binary(packed=True), b"KeyTime"), r"Limits\.zip_ratio"),
    "a damaged bomb": (
        lambda: _edited(drawn_fbx(1).binary(packed=True), b"KeyValueFloatf", b"KeyValueFloatx"),
        "unknown type 'x'",
    ),
    "no values": (lambda: _edited(drawn_fbx(1).binary(), b"KeyValueFloat", b"KeyValueFlo  "), "no KeyValueFloat"),
    "times that go back": (
        lambda: one_curve(track([0.0, 1.0, 0.5], [0.0] * 3, LINEAR)).binary(),
        "before the one in front",
    ),
    "a number that is none": (lambda: one_curve(track([0.0, 1.0], [0.0, np.inf], LINEAR)).binary(), "not finite"),
    "a signalling NaN": (
        lambda: _edited(
            one_curve(track([0.0, 1.0], [0.0, 0.625], LINEAR)).binary(), struct.pack("<f", 0.625), b"\1\0\x80\x7f"
        ),
        "not finite",
    ),
    "another number in text": (
        lambda: _edited(one_curve(track([0.0, 1.0], [0.5, 1.0], LINEAR)).ascii(), b"a: 0.5,", b"a: 0_5,"),
        "no number",
    ),
    "fewer numbers in text": (
        lambda: _edited(one_curve(track([0.0, 1.0], [0.5, 1.0], LINEAR)).ascii(), b"a: 0.5,", b"a: "),
        "claims 2 numbers, it holds 1",
    ),
    "a time beyond any clip": (lambda: one_curve(track([0.0, 1e8], [0.0, 1.0], LINEAR)).binary(), "no clip can have"),
    "a node under itself": (lambda: _cycle(drawn_fbx(1)), "its own ancestor|under each other"),
    "a brace too many": (lambda: drawn_fbx(1).ascii() + b"}\n", "a brace too many"),
    "no brace at the end": (lambda: drawn_fbx(1).ascii()[:-3], "the file ends within"),
    "runs for other keys": (
        lambda: _edited(
            one_curve(track([0.0, 1.0], [0.5, 1.0], LINEAR)).ascii(),
            b"KeyAttrRefCount: *1 {\n\t\t\ta: 2",
            b"KeyAttrRefCount: *1 {\n\t\t\ta: 3",
        ),
        "attributes are for 3 keys, it has 2",
    ),
    "too much in all": (lambda: drawn_fbx(1).binary(packed=True), r"Limits\.inflated_bytes"),
    "too many records": (lambda: drawn_fbx(1).binary(), r"Limits\.records"),
    "records too deep": (lambda: drawn_fbx(1).binary(), "deep"),
    "an animation too long": (lambda: one_curve(track([0.0, 9e6], [0.0, 1.0], LINEAR)).binary(), "give a lower rate"),
}


@pytest.mark.parametrize("what", BROKEN)
def test_what_is_broken_is_refused_with_its_place(what: str, tmp_path: Path) -> None:
    make, message = BROKEN[what]
    path = tmp_path / "a.fbx"
    limits = {
        "too many records": Limits(records=20),
        "records too deep": Limits(depth=1),
        "too much in all": Limits(inflated_bytes=1500),
    }.get(what, Limits())
    with pytest.raises(FormatError, match=message) as caught:
        fbx.read(path, make(), ReadOptions(limits=limits))
    assert str(path) in str(caught.value)


def test_frames_are_not_made_on_the_word_of_one_time(tmp_path: Path) -> None:
    """Of keys within a second, one that is a day off, or an end of the stack, would make 2.6 million frames."""
    path = tmp_path / "a.fbx"
    far = one_curve(track([0.0, 0.5, 86400.0], [0.0, 1.0, 2.0], LINEAR)).binary()
    ended = one_curve(track([0.0, 0.5], [0.0, 1.0], LINEAR), 86400.0).binary()
    for data, n_times in ((far, 3), (ended, 2)):
        words = (
            rf"'take' lasts 86400 s, and no key lies between 0\.5 and 86400 s: 2\d{{6}} frames .* at {n_times} times"
        )
        with pytest.raises(FormatError, match=words):
            fbx.read(path, data, ReadOptions())
        with pytest.warns(FormatWarning, match="86401 frames, and no key"):
            assert fbx.read(path, data, ReadOptions(rate=Fraction(1))).n_frames == 86_401
    hour = one_curve(track([0.0, 0.5], [0.0, 1.0], LINEAR), 3600.0).binary()
    with pytest.warns(FormatWarning, match=r"'take' lasts 3600 s, \d+ frames, and no key lies between 0\.5 and 3600 s"):
        fbx.read(path, hour, ReadOptions())


def test_a_rate_of_which_the_scene_is_not_one_frame_is_none(tmp_path: Path) -> None:
    """All keys lay within a five hundredth of its first frame, and so on it: the clip was that frame."""

    def scene(rate: float, last: float) -> bytes:
        made = one_curve(track([0.0, last / 4, last], [0.0, 1.0, 2.0], LINEAR))
        made.settings = [("TimeMode", ("I", 14)), ("CustomFrameRate", ("D", rate))]
        return made.binary()

    clip = fbx.read(tmp_path / "a.fbx", scene(0.001, 1.0), ReadOptions())
    assert (clip.rate, clip.n_frames) == (24, 25)
    assert fbx.read(tmp_path / "a.fbx", scene(0.5, 8.0), ReadOptions()).rate == Fraction(1, 2)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_cut_file_is_noticed(layout: str) -> None:
    data = layouts(drawn_fbx(2))[layout]
    end = data.index(b"Connections:") + 99 if "text" in layout else len(data) - 200
    for size in np.linspace(1, end, 60).astype(int):
        with pytest.raises(FormatError):
            fbx.read(PLACE, data[:size], ReadOptions())


def test_what_programs_read_in_more_than_one_way_is_said() -> None:
    turn = {"X": track([0.0, 1.0], [0.0, 90.0], LINEAR)}

    def said(change, retime_too: bool = False) -> list[str]:
        made = Builder()
        limb = made.model("limb", **change.get("limb", {}))
        stack = made.stack("take")
        made.animate(made.layer(stack), limb, "Lcl Rotation", turn)
        if "layer" in change:
            made.animate(made.layer(stack, "top", **change["layer"]), limb, "Lcl Rotation", turn)
        if "other" in change:
            made.add(*change["other"])
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            if retime_too:
                retimed(made.binary(), Warp([0.0, 2.0], [0.0, 1.0]))
            else:
                fbx.read(PLACE, made.binary(), ReadOptions(rate=10))
        return [str(one.message) for one in found]

    assert said({}) == []
    for change, words in (
        ({"limb": {"QuaternionInterpolate": 1}}, "interpolated as quaternions"),
        ({"limb": {"PreRotation": [1.0, 2.0, 3.0]}}, "RotationActive switches off"),
        ({"limb": {"RotationOrder": 6}}, "spheric order"),
        ({"layer": {"Mute": 1}}, "muted layers are not shown: top"),
        ({"layer": {"Solo": 1}}, "marked solo"),
        ({"layer": {"BlendMode": 1, "Weight": 50.0}}, "overrides those below it"),
        ({"other": ("Constraint", "aim", "Constraint")}, "has constraints"),
    ):
        (message,) = said(change)
        assert words in message
    for kind, words in (("Audio", "sound keep their timing"), ("Cache", "caches of moving points keep their timing")):
        assert words in said({"other": (kind, "more", kind)}, retime_too=True)[0]
    assert "cut as angles" in said({"limb": {"QuaternionInterpolate": 1}}, retime_too=True)[0]


def test_odd_but_legal_text_is_read() -> None:
    made = one_curve(track([0.0, 1.0], [0.5, 1.0], LINEAR))
    plain = fbx.read(PLACE, made.ascii(), ReadOptions(rate=10))
    odd = made.ascii().replace(b"\t\t\ta: 0,", b"\t\t\ta: 0\n , ").replace(b"\t", b"  ")
    odd = b"\xef\xbb\xbf" + odd.replace(b"Takes: {", b"Takes:\n ; a word\n{ ; another")
    found = fbx.read(PLACE, odd, ReadOptions(rate=10))
    assert isinstance(plain, Motion)
    assert isinstance(found, Motion)
    np.testing.assert_array_equal(found.local_translations, plain.local_translations)
    # Attributes may be written as what their bits mean.
    curved = one_curve(track([0.0, 1.0], [0.0, 1.0], CUBIC | USER, slopes=[[2.5, 0.5], [0.0, 0.0]])).ascii()
    bits = ",".join(str(one) for one in np.array([2.5, 0.5], "<f4").view("<i4")).encode()
    assert bits in curved
    plain = fbx.read(PLACE, curved, ReadOptions(rate=10))
    found = fbx.read(PLACE, curved.replace(bits, b"2.5,0.5"), ReadOptions(rate=10))
    assert isinstance(plain, Motion)
    assert isinstance(found, Motion)
    np.testing.assert_allclose(found.local_translations, plain.local_translations, atol=1e-6)
    # So it is where all stands in one line, which is retimed too.
    flat = b" ".join(line for line in made.ascii().splitlines() if not line.lstrip().startswith(b";"))
    flat = b"; FBX 7.5.0 project file\n" + flat
    again = only(retimed(flat, Warp([0.0, 2.0], [0.0, 1.0])))
    assert (again.times, again.values) == ([0.0, 2.0], [0.5, 1.0])
    # A comment may hold what looks like a record, a text what looks like a comment or a brace.
    named = made.ascii().replace(b'"Model::limb"', b'"Model::a; }{ limb"')
    assert fbx.read(PLACE, named, ReadOptions(rate=10)).skeleton.names == ("a; }{ limb",)


def test_a_motion_is_written_as_a_skeleton_that_reads_back(tmp_path: Path) -> None:
    clip = retime.sample()[:40]
    for up, unit, rate in (("y", None, 60), ("z", 0.0254, 24), ("y", 1.0, 23.5)):
        path = tmp_path / f"{up}{rate}.fbx"
        retime.write(replace(clip, up=up, metres_per_unit=unit, rate=rate), path)
        found = retime.read(path)
        assert isinstance(found, Motion)
        joints = [found.skeleton.names.index(name) for name in clip.skeleton.names]
        wanted, poses = global_poses(replace(clip, up=up)), global_poses(found)
        np.testing.assert_allclose(poses.positions[:, joints], wanted.positions, atol=2e-4)
        assert (found.up, found.rate, found.n_frames, found.name) == (up, rate, 40, clip.name)
        assert found.metres_per_unit == pytest.approx(unit or 0.01)
        data = path.read_bytes()
        assert parse_fbx(path, data, Limits()).file.rewritten({}) == data
        assert len(Literal(data).curves) >= 3 * clip.skeleton.n_joints
    with pytest.raises(FormatError, match="not a signal"):
        fbx.write(Signal(("x",), [[0.0]]), tmp_path / "b.fbx", overwrite=False)


def test_turns_are_written_in_the_order_of_the_motions_file(tmp_path: Path) -> None:
    clip = retime.sample()[:5]
    assert clip.declaration is not None
    orders = {"".join(one[0] for one in channels if "rotation" in one) for channels in clip.declaration.channels}
    retime.write(clip, tmp_path / "a.fbx")
    scene = parse_fbx(PLACE, (tmp_path / "a.fbx").read_bytes(), Limits())
    written = {scene.whole(item, "RotationOrder", 0) for item in scene.items.values() if item.subtype == "LimbNode"}
    assert {["ZYX", "YZX", "XZY", "ZXY", "YXZ", "XYZ"][number] for number in written} >= orders


def test_slopes_of_keys_without_neighbours_are_level() -> None:
    one = track([0.0], [3.0], CUBIC | AUTO)
    found = resolved(Keys(np.array([1]), one.ticks, one.values, one.flags, one.data), TICKS)
    assert (found.left[0], found.right[0]) == (0.0, 0.0)


def test_a_scene_is_retimed_by_the_registry(tmp_path: Path) -> None:
    path = tmp_path / "a.fbx"
    path.write_bytes(drawn_fbx(3).binary())
    retime_file(path, tmp_path / "b.fbx", Warp([0.0, 5.0], [0.0, 2.5]), animation="take")
    assert registry.animation_names(tmp_path / "b.fbx") == ["take"]
    with pytest.raises(FormatError, match="stays one"):
        retime_file(path, tmp_path / "b.glb", Warp([0.0, 5.0], [0.0, 2.5]))


@needs_captures
@pytest.mark.parametrize("name", CAPTURES)
def test_real_scenes_are_retimed_in_place(name: str) -> None:
    data = (FBX / name).read_bytes()
    scene = parse_fbx(FBX / name, data, Limits())
    assert scene.file.rewritten({}) == data
    curves = read_stack(scene, scene.stacks[0])
    end = curves.end - curves.start
    assert retimed(data, Warp([0.0, end], [0.0, end])) == data
    warp = Warp([0.0, 0.3 * end, 0.4 * end, 0.6 * end, 0.9 * end], [0, 0.6 * end, 0.6 * end, 0.2 * end, end])
    before, after = Literal(data).curves, Literal(retimed(data, warp)).curves
    weighted = "interpolation" in name
    for number, old in before.items():
        new = after[number]
        largest = max(np.abs(old.values + new.values).max(), 1e-9)
        for time in np.random.default_rng(0).uniform(0, 0.9 * end, 40):
            there = float(warp(time)) + curves.start
            if np.abs(np.subtract(old.times, there)).min() > 1e-6:
                tolerance = (1e-5 if weighted else 1e-6) * largest
                assert new.value(time + curves.start) == pytest.approx(old.value(there), abs=tolerance)


@pytest.mark.parametrize("version", [7400, 7700])
def test_the_new_file_is_what_its_new_numbers_make_byte_for_byte(version: int) -> None:
    made = drawn_fbx(9, 0.5)
    data = made.binary(version)
    new = retimed(data, Warp([0.0, 1.0, 3.0], [0.0, 1.5, 2.5]))
    curves, times = Literal(new).curves, stack_times(new)
    # Put into the records that the file was made of, the numbers of curves and of spans of time give the whole file.
    for place, record in enumerate(made.objects):
        number = record[1][0][1]
        if record[0] == "AnimationCurve":
            curve = curves[number]
            data_of = np.array(curve.data, dtype=np.int64).astype(np.uint32)
            again = Track(np.array(curve.ticks), np.array(curve.values), np.array(curve.flags), data_of)
            made.objects[place] = again.record(number)
        elif record[0] == "AnimationStack":
            for index, one in enumerate(record[2][0][2]):
                key = one[1][0][1]
                record[2][0][2][index] = node("P", *one[1][:4], ("L", round(times[key] * TICKS)))
    for key in ("TimeSpanStart", "TimeSpanStop"):
        spot = next(i for i, one in enumerate(made.settings) if one[0] == key)
        made.settings[spot] = (key, ("L", round(times[key] * TICKS)))
    span = (("L", round(times["LocalTime 0"] * TICKS)), ("L", round(times["LocalTime 1"] * TICKS)))
    made.takes[0] = node("Take", text("take"), inner=[node("LocalTime", *span), node("ReferenceTime", *span)])
    assert made.binary(version) == new


def test_baked_keys_are_on_the_curves_where_nothing_is_averaged() -> None:
    data = drawn_fbx(11).binary()
    curves = Literal(data).curves
    for warp, average in ((Warp([0.0, 4.0], [0.0, 2.5]), True), (Warp([0.0, 1.0], [0.0, 2.5]), False)):
        new = Literal(fbx.bake(PLACE, data, warp, ReadOptions(rate=30), average=average)[""]).curves
        for number, old in curves.items():
            baked = new[number]
            assert len(baked.times) == round(30 * warp.output_end) + 1
            for time, value in zip(baked.times, baked.values, strict=True):
                there = float(warp(time))
                if np.abs(np.subtract(old.times, there)).min() > 1e-6:
                    assert value == pytest.approx(old.value(there), rel=1e-6, abs=1e-5)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_info_tells_stacks_layers_curves_and_keys(layout: str) -> None:
    made = drawn_fbx(3)
    data = layouts(made)[layout]
    curves = Literal(data).curves
    n_keys = sum(len(curve.times) for curve in curves.values())
    told = fbx.facts(PLACE, data, ReadOptions())
    version = {"text": "7.5", "64 bits": "7.5", "64 bits, compressed": "7.7"}
    version |= {"32 bits": "7.4", "32 bits, compressed": "7.3", "text before 7200, other line ends": "7.1"}
    assert told == {
        "stored": f"{'text' if layout.startswith('text') else 'binary'}, version {version[layout]}",
        "animations": f"1: take (2.500 s, 2 layers (BaseLayer, top), {len(curves)} curves, {n_keys} keys)",
        "takes": "1: take",
        "time mode": "6: 30 Hz",
        "scene": "3 models, 1 geometries, 0 deformers, 0 materials; up axis Y, 1 cm a unit",
    }
