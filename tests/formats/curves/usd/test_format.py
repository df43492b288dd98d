"""USD retimed three ways: evaluated by USD, a scene has at t what it had at warp(t); all else is as it was."""

from __future__ import annotations

import re
import tempfile
import warnings
import zipfile
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import retime
from retime.errors import FormatError, FormatWarning, OptionError
from retime.formats.curves.usd import format as usd
from retime.formats.curves.usd.package import packed
from retime.formats.in_place import retime_file
from retime.formats.read_options import Limits, ReadOptions
from retime.formats.registry import animation_names
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from tests.formats.curves.usd.scenes import DrawnScene
from tests.reference import usd as literal
from tests.warp.drawn import drawn_warp

pytest.importorskip("pxr", reason="usd-core is not installed (make extras)")

from pxr import Sdf, Ts, Usd, UsdGeom, UsdSkel

from retime.formats.curves.usd import animation
from retime.formats.curves.usd.child import answered
from retime.formats.curves.usd.stage import naming

pytestmark = pytest.mark.extras

USD = Path(__file__).parents[5] / "shared" / "mocap" / "usd"
needs_captures = pytest.mark.skipif(not USD.is_dir(), reason="the captures are not beside the project (../shared)")
REAL = ["CesiumMan.usdz", "lbs.usda", "usdskel_blendshapes.usda"]


def a_warp(length: float) -> Warp:
    """Faster than life, a hold, backward, and a jump back to slow."""
    knots = [0.0, 0.6, 0.6, 0.2, 0.2001, 1.0]
    return Warp(np.array([0.0, 0.3, 0.45, 0.6, 0.6001, 1.3]) * length, np.array(knots) * length)


def pairs(stage, warp: Warp, *, away: float = 1e-4, seed: int = 0) -> list[tuple[float, float]]:
    """Every output frame and times between them, as (output code, input code); none where a value may step."""
    start, per_second = stage.GetStartTimeCode(), stage.GetTimeCodesPerSecond()
    keys = np.unique(np.concatenate(list(literal.sampled(stage).values())))
    frames = np.arange(int(np.ceil(warp.output_end * 30)) + 1) / 30
    times = np.concatenate([frames, np.random.default_rng(seed).uniform(0, warp.output_end, 60)])
    times = times[times <= warp.output_end]
    found = []
    for time in times:
        shown = start + float(warp(time)) * per_second
        if np.abs(keys - shown).min() > away * per_second:
            found.append((start + time * per_second, shown))
    return found


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("way", ["usda", "usdc", "clips", "over"])
def test_all_that_changes_is_at_t_what_it_was_at_the_warps_time(tmp_path: Path, seed: int, way: str) -> None:
    rng = np.random.default_rng(seed)
    scene = DrawnScene(seed, authored=seed % 3 > 0)
    path = tmp_path / "a.usda"
    path.write_text(scene.text())
    if way == "usdc":
        layer = Sdf.Layer.FindOrOpen(str(path))
        path = path.with_suffix(".usdc")
        layer.Export(str(path))
    before = literal.opened(path)
    drawn = drawn_warp(rng, int(rng.integers(2, 8)), forward=bool(seed % 2))
    low, span = drawn.input_times.min(), np.ptp(drawn.input_times) + 1e-9
    # A little beyond both ends, where the scene holds.
    length = scene.length / scene.per_second
    warp = Warp(
        drawn.output_times - drawn.output_start, (drawn.input_times - low) / span * length * 1.1 - 0.04 * length
    )
    place = tmp_path / f"b{path.suffix}"
    retime_file(path, place, warp, tolerance=0, layer=way if way in ("clips", "over") else None)
    after = literal.opened(place)
    if not scene.authored:
        before.SetStartTimeCode(scene.start)
    relative, degrees, other = literal.worst(before, after, pairs(before, warp, seed=seed))
    assert relative < 1e-6
    assert degrees < 1e-3
    assert other == []
    if scene.authored or way in ("clips", "over"):
        np.testing.assert_allclose(after.GetStartTimeCode(), scene.start)
        np.testing.assert_allclose(after.GetEndTimeCode(), scene.start + warp.output_end * scene.per_second)


def test_what_the_text_says_beside_its_samples_stays_to_the_letter(tmp_path: Path) -> None:
    scene = DrawnScene(1)
    # As people write it, not as USD does.
    old = (
        scene.text()
        .replace("def Xform", "  # by hand\n def   Xform")
        .replace("uniform token[] xformOp", "uniform  token[] xformOp")
    )
    (tmp_path / "a.usda").write_text(old)
    retime_file(tmp_path / "a.usda", tmp_path / "b.usda", a_warp(scene.length / scene.per_second))
    new = (tmp_path / "b.usda").read_text()
    blocks = re.compile(r"(\.timeSamples = )\{.*?\n *\}", re.DOTALL)
    assert len(blocks.findall(old)) == 12
    ends = re.compile(r"endTimeCode = \S+")
    assert blocks.sub(r"\1", ends.sub("", old)) == blocks.sub(r"\1", ends.sub("", new))
    # One sample is the same at any time, and stays where it is.
    assert sum(a[0] != b[0] for a, b in zip(blocks.finditer(old), blocks.finditer(new), strict=True)) == 11


def test_a_sample_that_a_knot_does_not_meet_keeps_its_bits(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text(
        "#usda 1.0\n(\n    startTimeCode = 0\n    endTimeCode = 48\n)\n"
        'def "A"\n{\n    custom double x.timeSamples = {\n'
        "        0: 0.1,\n        12: 0.30000000000000004,\n        24: 1e-300,\n        48: 7,\n    }\n}\n"
    )
    retime_file(tmp_path / "a.usda", tmp_path / "b.usda", Warp([0.0, 1.0, 2.0], [0.0, 1.0, 1.5]))
    text = (tmp_path / "b.usda").read_text()
    found = re.findall(r"^ *(\S+): (\S+),$", text, re.MULTILINE)
    assert found == [("0", "0.1"), ("12", "0.30000000000000004"), ("24", "1e-300"), ("48", "3.5")]
    assert "endTimeCode = 48" in text


def test_a_held_scene_and_held_types_step_where_the_warp_says(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text(
        '#usda 1.0\n(\n    startTimeCode = 0\n    endTimeCode = 48\n)\ndef "A"\n{\n    custom token x.timeSamples = {\n'
        '        0: "a",\n        24: "b",\n        36: "c",\n    }\n}\n'
    )
    # Backward from the end, then a hold.
    retime_file(tmp_path / "a.usda", tmp_path / "b.usda", Warp([0.0, 2.0, 3.0], [2.0, 0.0, 0.0]))
    stage = literal.opened(tmp_path / "b.usda")
    shown = [stage.GetAttributeAtPath("/A.x").Get(code) for code in (0, 11, 13, 23, 25, 48, 72)]
    assert shown == ["c", "c", "b", "b", "a", "a", "a"]


def test_a_layer_that_only_writes_over_others_is_retimed_too(tmp_path: Path) -> None:
    scene = DrawnScene(10)
    path, place = tmp_path / "a.usda", tmp_path / "b.usda"
    text = scene.text()
    path.write_text(re.sub(r"^( *)def \w+ ", r"\1over ", text, flags=re.MULTILINE))
    warp = a_warp(scene.length / scene.per_second)
    retime_file(path, place, warp, tolerance=0)
    (tmp_path / "whole.usda").write_text(text)
    retime_file(tmp_path / "whole.usda", tmp_path / "c.usda", warp, tolerance=0)
    same = re.sub(r"^( *)def \w+ ", r"\1over ", (tmp_path / "c.usda").read_text(), flags=re.MULTILINE)
    assert place.read_text() == same
    with pytest.warns(FormatWarning, match=r"left out: .*/Prop\.grown"):
        assert isinstance(retime.read(path), Signal)


@pytest.mark.parametrize("average", [True, False])
def test_baked_frames_are_those_of_the_motion_retimed(tmp_path: Path, average: bool) -> None:
    scene = DrawnScene(5 if average else 4)
    path, place = tmp_path / "a.usda", tmp_path / "b.usda"
    path.write_text(scene.text())
    clip = retime.read(path, rate=40)
    warp = Warp([0.0, clip.end_time / 2, clip.end_time], [0.0, clip.end_time, clip.end_time])
    retime_file(path, place, warp, rate=40, bake=True, average=average)
    stage = literal.opened(place)
    n_frames = warp.count_frames(40)
    assert len(literal.sampled(stage)["/Body/Skel/Anim.translations"]) == n_frames
    found = retime.read(place, rate=40)
    assert isinstance(clip, Motion)
    assert isinstance(found, Motion)
    wanted = apply_warp(clip, warp, average=average)
    np.testing.assert_allclose(found.local_translations[:n_frames], wanted.local_translations, atol=2e-6)
    np.testing.assert_allclose(np.abs((found.rotations[:n_frames] * wanted.rotations).sum(axis=2)), 1, atol=1e-9)
    # What is no joint is averaged by itself, and what is held is held.
    weights = np.array(
        [stage.GetAttributeAtPath("/Body/Skel/Anim.blendShapeWeights").Get(time) for time in outs(stage, n_frames)]
    )
    old = literal.opened(path)
    before = old.GetAttributeAtPath("/Body/Skel/Anim.blendShapeWeights")
    input_frames = [scene.start + frame / 40 * scene.per_second for frame in range(clip.n_frames)]
    shown = np.array([before.Get(code) for code in input_frames])
    np.testing.assert_allclose(weights, apply_warp(shown, warp, average=average, rate=40), atol=1e-5)
    words = {stage.GetAttributeAtPath("/Prop.word").Get(time) for time in outs(stage, n_frames)}
    assert words <= {"a", "b", "c", "d"}


def outs(stage, n_frames: int) -> list[float]:
    return [stage.GetStartTimeCode() + frame / 40 * stage.GetTimeCodesPerSecond() for frame in range(n_frames)]


def test_a_motion_has_the_joints_of_the_skeleton_and_its_place_in_the_scene(tmp_path: Path) -> None:
    for seed in range(4):
        scene = DrawnScene(seed)
        text = scene.text().replace(
            "    # A comment of whoever made it.\n",
            "    double3 xformOp:translate.timeSamples = {\n"
            f"        {scene.start!r}: (1, 2, 3),\n        {scene.end!r}: (4, 2, 3),\n    }}\n"
            "    float3 xformOp:scale = (2, 2, 2)\n"
            '    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale"]\n',
        )
        path = tmp_path / f"{seed}.usda"
        path.write_text(text)
        clip = retime.read(path, rate=30)
        assert isinstance(clip, Motion)
        assert clip.skeleton.names == ("Skel", *scene.names)
        assert (clip.up, clip.metres_per_unit) == ("z", 0.01)
        poses = global_poses(replace(clip, up="y"))
        stage = literal.opened(path)
        cache = UsdSkel.Cache()
        root = UsdSkel.Root(stage.GetPrimAtPath("/Body"))
        cache.Populate(root, Usd.PrimDefaultPredicate)
        query = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/Body/Skel")))
        for frame in (0, 3, clip.n_frames - 1):
            code = scene.start + frame / 30 * scene.per_second
            matrices = np.array(query.ComputeJointWorldTransforms(UsdGeom.XformCache(code)))
            np.testing.assert_allclose(poses.positions[frame, 1:], matrices[:, 3, :3], atol=2e-5)


def test_prims_that_move_are_joints_where_there_is_no_skeleton(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text(
        '#usda 1.0\n(\n    timeCodesPerSecond = 10\n)\ndef Xform "World"\n{\n    def Xform "Rig"\n    {\n'
        "        float3 xformOp:rotateXYZ.timeSamples = {\n            5: (0, 0, 0),\n            15: (0, 90, 0),\n"
        '        }\n        uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]\n        def Camera "Cam"\n        {\n'
        "            double3 xformOp:translate = (0, 0, 2)\n"
        '            uniform token[] xformOpOrder = ["xformOp:translate"]\n'
        "            float focalLength.timeSamples = {\n"
        "                5: 35,\n                15: 50,\n            }\n        }\n    }\n}\n"
    )
    clip = retime.read(tmp_path / "a.usda")
    assert isinstance(clip, Motion)
    assert (clip.skeleton.names, clip.skeleton.parents) == (("World", "Rig"), (-1, 0))
    assert (clip.rate, clip.n_frames) == (10, 11)
    np.testing.assert_allclose(clip.rotations[10, 1], [0.5**0.5, 0, 0.5**0.5, 0], atol=1e-6)
    lens = retime.read(tmp_path / "a.usda", animation="/World/Rig/Cam.focalLength")
    assert isinstance(lens, Signal)
    assert lens.names == ("World/Rig/Cam.focalLength",)
    np.testing.assert_allclose(lens.values[:, 0], np.linspace(35, 50, 11), atol=1e-5)


def test_several_animations_are_named_and_the_first_is_read(tmp_path: Path) -> None:
    text = DrawnScene(2).text()
    start = text.index("        def SkelAnimation")
    stop = text.index("    }\n}\n", start)
    other = text[start:stop].replace('"Anim"', '"Other"')
    path = tmp_path / "a.usda"
    path.write_text(text[:stop] + other + text[stop:])
    with pytest.warns(
        FormatWarning, match=r"2 animations \(/Body/Skel/Anim, /Body/Skel/Other\); /Body/Skel/Anim is read"
    ):
        retime.read(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for chosen in ("/Body/Skel/Other", "Other", "1"):
            assert retime.read(path, animation=chosen).name == "Other"
        assert retime.read(path, animation="/Prop").name == "Prop"
    with pytest.raises(FormatError, match="no animation is called 'Jump'; there are /Body/Skel/Anim, /Body/Skel/Other"):
        retime.read(path, animation="Jump")
    # One clock, one warp.
    assert animation_names(path) == ["/Body/Skel/Anim"]


def test_a_motion_is_written_as_a_skeleton_that_reads_back(tmp_path: Path) -> None:
    clip = retime.sample()[:40]
    names = [f"{name} é{i}" for i, name in enumerate(clip.skeleton.names)]
    odd = replace(clip, skeleton=replace(clip.skeleton, names=tuple(names)), rate="30000/1001")
    for motion, ending in ((clip, "usda"), (odd, "usdc"), (replace(clip, metres_per_unit=0.01), "usdz"), (odd, "usd")):
        for up in ("y", "z"):
            path = tmp_path / f"{up}.{ending}"
            retime.write(replace(motion, up=up), path)
            found = retime.read(path)
            assert isinstance(found, Motion)
            assert found.skeleton.names == motion.skeleton.names
            assert found.skeleton.parents == motion.skeleton.parents
            assert [site.parent for site in found.skeleton.end_sites] == [
                site.parent for site in motion.skeleton.end_sites
            ]
            assert (found.rate, found.n_frames, found.up) == (motion.rate, 40, up)
            assert found.metres_per_unit == motion.metres_per_unit
            np.testing.assert_allclose(
                global_poses(found).positions, global_poses(replace(motion, up=up)).positions, atol=2e-4
            )
            np.testing.assert_allclose(np.abs((found.rotations * motion.rotations).sum(axis=2)), 1, atol=1e-9)
    with pytest.raises(FormatError, match="holds a motion, not a signal"):
        retime.write(Signal(("x",), [[0.0], [1.0]], rate=30), tmp_path / "s.usda")


def test_a_package_keeps_its_other_files_and_stays_aligned(tmp_path: Path) -> None:
    scene = DrawnScene(3)
    files = {"walk.usda": scene.text().encode(), "tex/skin.png": bytes(range(256)) * 3, "note.usda": b"#usda 1.0\n"}
    path, place = tmp_path / "a.usdz", tmp_path / "b.usdz"
    path.write_bytes(packed(files))
    before = literal.opened(path)
    warp = a_warp(scene.length / scene.per_second)
    retime_file(path, place, warp, tolerance=0)
    relative, degrees, other = literal.worst(before, literal.opened(place), pairs(before, warp))
    assert (relative < 1e-6, degrees < 1e-3, other) == (True, True, [])
    archive = zipfile.ZipFile(BytesIO(place.read_bytes()))
    assert archive.namelist() == list(files)
    for entry in archive.infolist():
        assert entry.compress_type == zipfile.ZIP_STORED
        assert (entry.header_offset + 30 + len(entry.filename) + len(entry.extra)) % 64 == 0
        if entry.filename != "walk.usda":
            assert archive.read(entry) == files[entry.filename]


def test_samples_anywhere_in_a_package_are_retimed_on_their_own_clocks(tmp_path: Path) -> None:
    scene = DrawnScene(11)
    inner = DrawnScene(7).prop().replace('def Xform "Prop"', 'def Xform "Other"')
    clock = f"startTimeCode = {scene.start}\n    endTimeCode = {scene.end}\n    timeCodesPerSecond = {scene.per_second}"
    files = {
        "root.usda": (
            f"#usda 1.0\n(\n    {clock}\n    subLayers = [@./sub/a.usda@]\n)\n"
            'def "Ref" (\n    references = @./b.usda@</Other> (offset = 3; scale = 0.5)\n)\n{\n}\n'
        ).encode(),
        "sub/a.usda": scene.text().encode(),
        "b.usda": f"#usda 1.0\n(\n    timeCodesPerSecond = 48\n)\n# kept\n{inner}".encode(),
        "c.png": b"picture",
    }
    path, place = tmp_path / "a.usdz", tmp_path / "b.usdz"
    path.write_bytes(packed(files))
    before = literal.opened(path)
    assert "/Ref.xformOp:translate" in literal.sampled(before)
    warp = a_warp(scene.length / scene.per_second)
    retime_file(path, place, warp, tolerance=0)
    after = literal.opened(place)
    assert literal.sampled(after)["/Ref.xformOp:translate"] != literal.sampled(before)["/Ref.xformOp:translate"]
    relative, degrees, other = literal.worst(before, after, pairs(before, warp))
    assert (relative < 1e-6, degrees < 1e-3, other) == (True, True, [])
    archive = zipfile.ZipFile(place)
    assert archive.namelist() == list(files)
    assert archive.read("c.png") == b"picture"
    assert b"# kept" in archive.read("b.usda")
    # Used twice, on two clocks, a layer can have no one timing.
    twice = files["root.usda"] + b'def "Again" (\n    references = @./b.usda@</Other>\n)\n{\n}\n'
    path.write_bytes(packed({**files, "root.usda": twice}))
    with pytest.raises(FormatError, match=r"/Other of b\.usda is shown at 2 times.*--layer over"):
        retime_file(path, place, warp, overwrite=True)


def _before_and_after(layer: Any, warp: Warp, folder: Path, name: str) -> tuple[Any, Any]:
    """Write a layer, retime it, and open both."""
    path, place = folder / f"{name}.usda", folder / f"{name}b.usda"
    layer.Export(str(path))
    retime_file(path, place, warp, tolerance=0)
    return literal.opened(path), literal.opened(place)


def test_a_spline_is_cut_exactly(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    for turn in range(6):
        layer = Sdf.Layer.CreateAnonymous(".usda")
        layer.startTimeCode, layer.endTimeCode = 10, 58
        prim = Sdf.PrimSpec(layer, "A", Sdf.SpecifierDef)
        spec = Sdf.AttributeSpec(prim, "x", Sdf.ValueTypeNames.Double)
        spline = Ts.Spline("double")
        times = np.sort(rng.choice(np.arange(10, 59), 5, replace=False)).astype(float)
        for i, time in enumerate(times):
            knot = Ts.Knot("double", time=time, value=float(rng.normal()))
            knot.SetNextInterpolation([Ts.InterpCurve, Ts.InterpLinear, Ts.InterpHeld][int(rng.integers(3))])
            room = np.diff(times).min() * 0.45
            knot.SetPreTanWidth(float(rng.uniform(0, room)))
            knot.SetPostTanWidth(float(rng.uniform(0, room)))
            knot.SetPreTanSlope(float(rng.normal()))
            knot.SetPostTanSlope(float(rng.normal()))
            if i and turn % 2:
                knot.SetPreValue(float(rng.normal()))
            spline.SetKnot(knot)
        spec.SetSpline(spline)
        warp = a_warp(2.0)
        before, after = _before_and_after(layer, warp, tmp_path, str(turn))
        assert after.GetAttributeAtPath("/A.x").HasSpline()
        chosen = [pair for pair in pairs(before, warp) if np.abs(times - pair[1]).min() > 0.01]
        relative, _, other = literal.worst(before, after, chosen)
        assert other == []
        assert relative < 1e-5


def _beyond(mode: Any, slope: float = 0.0) -> Any:
    made = Ts.Extrapolation(mode)
    if mode == Ts.ExtrapSloped:
        made.slope = slope
    return made


@pytest.mark.filterwarnings("ignore:Ts.Spline inner looping:FutureWarning")
def test_loops_and_lines_beyond_the_ends_are_written_out(tmp_path: Path) -> None:
    """Whatever pxr shows of a spline at the warp's times it shows of the new one, whose knots are all its own."""
    rng = np.random.default_rng(8)
    modes = [Ts.ExtrapHeld, Ts.ExtrapLinear, Ts.ExtrapSloped]
    modes += [Ts.ExtrapLoopRepeat, Ts.ExtrapLoopReset, Ts.ExtrapLoopOscillate]
    for turn in range(24):
        layer = Sdf.Layer.CreateAnonymous(".usda")
        layer.startTimeCode, layer.endTimeCode = 10, 58
        spec = Sdf.AttributeSpec(Sdf.PrimSpec(layer, "A", Sdf.SpecifierDef), "x", Sdf.ValueTypeNames.Double)
        spline = Ts.Spline("double")
        first = float(rng.integers(5, 40))
        codes = first + np.array([0.0, 3, 7, 9])
        for i, code in enumerate(codes):
            knot = Ts.Knot("double", time=code, value=float(rng.normal()))
            knot.SetNextInterpolation([Ts.InterpCurve, Ts.InterpLinear][int(rng.integers(2))])
            for width, slope in (
                (knot.SetPreTanWidth, knot.SetPreTanSlope),
                (knot.SetPostTanWidth, knot.SetPostTanSlope),
            ):
                width(float(rng.uniform(0, 0.9)))
                slope(float(rng.normal()))
            if i and turn % 3 == 0:
                knot.SetPreValue(float(rng.normal()))
            spline.SetKnot(knot)
        spline.SetPreExtrapolation(_beyond(modes[turn % 6], float(rng.normal())))
        spline.SetPostExtrapolation(_beyond(modes[(turn // 2) % 6], float(rng.normal())))
        if turn % 4 == 3:
            inner = Ts.LoopParams()
            inner.protoStart, inner.protoEnd = first, first + 7
            inner.numPreLoops, inner.numPostLoops, inner.valueOffset = 1, 2, float(rng.normal())
            spline.SetInnerLoopParams(inner)
        spec.SetSpline(spline)
        warp = a_warp(2.0)
        before, after = _before_and_after(layer, warp, tmp_path, str(turn))
        new = after.GetAttributeAtPath("/A.x").GetSpline()
        assert not new.HasLoops()
        shown = before.GetAttributeAtPath("/A.x").GetSpline()
        # Where values jump the two may fall on different sides, by rounding.
        chosen = [
            (out, code)
            for out, code in pairs(before, warp)
            if abs(shown.Eval(code - 0.01) - shown.Eval(code + 0.01)) < 0.5
        ]
        assert len(chosen) > 20
        off = max(abs(new.Eval(out) - shown.Eval(code)) / max(1.0, abs(shown.Eval(code))) for out, code in chosen)
        assert off < 1e-5, (turn, off)


def test_a_spline_that_loops_without_end_is_refused_by_name(tmp_path: Path) -> None:
    body = "        1: 5; post curve (0.0001, 0),\n        1.001: 3; pre (0.0001, 0),\n"
    (tmp_path / "a.usda").write_text(
        '#usda 1.0\n(\n    endTimeCode = 90000\n    startTimeCode = 0\n)\ndef "A"\n{\n    double x.spline = {\n'
        f"        bezier,\n        post: loop repeat,\n{body}    }}\n}}\n"
    )
    with pytest.raises(FormatError, match=r"the spline /A\.x loops so often that it would have more than 100000 knots"):
        retime_file(tmp_path / "a.usda", tmp_path / "b.usda", Warp([0.0, 3000.0], [0.0, 3000.0]))


CLIP = '#usda 1.0\nover "A"\n{\n    double x.timeSamples = {\n        0: 0,\n        48: 48,\n    }\n}\n'
WITH_CLIPS = """#usda 1.0
(
    startTimeCode = 0
    endTimeCode = 48
)
def "A" (
    clips = {
        dictionary default = {
            double2[] active = [(0, 0), (30, 1)]
            asset[] assetPaths = [@./one.usda@, @./two.usda@]
            string primPath = "/A"
            double2[] times = [(0, 0), (24, 24), (48, 36)]
        }
    }
)
{
    double x
}
"""


def test_clips_that_a_scene_has_get_other_times(tmp_path: Path) -> None:
    (tmp_path / "one.usda").write_text(CLIP)
    (tmp_path / "two.usda").write_text(CLIP.replace("48: 48", "48: 480"))
    (tmp_path / "a.usda").write_text(WITH_CLIPS)
    warp = Warp([0.0, 0.5, 1.0, 2.0], [0.0, 1.0, 1.0, 2.0])
    retime_file(tmp_path / "a.usda", tmp_path / "b.usda", warp, tolerance=0)
    before, after = literal.opened(tmp_path / "a.usda"), literal.opened(tmp_path / "b.usda")
    for code in np.arange(0, 48.0):
        shown = before.GetAttributeAtPath("/A.x").Get(float(warp(code / 24)) * 24)
        np.testing.assert_allclose(after.GetAttributeAtPath("/A.x").Get(code), shown, atol=1e-6)


TEMPLATE = """#usda 1.0
(
    startTimeCode = 0
    endTimeCode = 8
)
def "A" (
    clips = {{
        dictionary default = {{
            string primPath = "/A"
            string templateAssetPath = "./c/w.{}.usda"
            double templateStartTime = {}
            double templateEndTime = {}
            double templateStride = {}
{}        }}
    }}
)
{{
    double x
}}
"""


@pytest.mark.parametrize(
    ("marks", "start", "end", "stride", "offset", "files"),
    [
        ("###", 1, 5, 1, None, {"001": 1, "002": 2, "003": 3, "005": 5}),
        ("#", 1, 7, 2, None, {"1": 1, "3": 3, "5": 5, "6": 6, "7": 7}),
        ("##", 1, 5, 1, -0.25, {"01": 1, "02": 2, "03": 3, "05": 5}),
        ("##", 1, 5, 2, 0.25, {"01": 1, "03": 3, "05": 5}),
        ("##.##", 1, 4, 0.5, None, {"01.00": 1, "01.50": 1.5, "02.50": 2.5, "03.00": 3, "04.00": 4}),
    ],
)
def test_clips_named_by_a_template_are_named_one_by_one(
    tmp_path: Path, marks: str, start: float, end: float, stride: float, offset: float | None, files: dict[str, float]
) -> None:
    (tmp_path / "c").mkdir()
    for name, at in files.items():
        samples = f"{at}: {10 * at}, {at + 0.5}: {10 * at + 5}, {at + 1}: {10 * at + 7}"
        (tmp_path / "c" / f"w.{name}.usda").write_text(
            f'#usda 1.0\nover "A"\n{{\n    double x.timeSamples = {{ {samples} }}\n}}\n'
        )
    more = "" if offset is None else f"            double templateActiveOffset = {offset}\n"
    path = tmp_path / "a.usda"
    path.write_text(TEMPLATE.format(marks, start, end, stride, more))
    old = literal.opened(path)
    before = old.GetAttributeAtPath("/A.x")
    # The plain warp shows what is written out, every quarter of a code and beyond the first and the last clip.
    warps = Warp([0.0, 8 / 24], [0.0, 8 / 24]), Warp([0.0, 0.1, 0.2, 0.5], [0.0, 3 / 24, 3 / 24, 8 / 24])
    for number, warp in enumerate(warps):
        place = tmp_path / f"b{number}.usda"
        retime_file(path, place, warp, tolerance=0)
        new = literal.opened(place)
        after = new.GetAttributeAtPath("/A.x")
        for code in np.arange(0, warp.output_end * 24, 0.25):
            shown = float(warp(code / 24)) * 24
            # Where one clip follows another, rounding may show either.
            if min(abs(shown - time - by) for time in files.values() for by in (0.0, offset or 0.0)) > 1e-3:
                assert after.Get(code) == pytest.approx(before.Get(shown), abs=1e-5), (code, shown)
    assert "templateAssetPath" not in place.read_text()
    assert retime.read(path).n_frames > 1


def test_a_knot_where_usd_blends_from_clip_to_clip_is_refused(tmp_path: Path) -> None:
    """Between a clip's last sample and the next clip USD blends; at a knot of the clips' times it would hold."""
    for i in range(5):
        (tmp_path / f"w.{i}.usda").write_text(
            f'#usda 1.0\nover "A"\n{{\n    double x.timeSamples = {{ {i}: {i * i} }}\n}}\n'
        )
    path = tmp_path / "a.usda"
    path.write_text(TEMPLATE.format("#", 0, 4, 1, "").replace("./c/", "./"))
    with pytest.raises(FormatError, match=r"code 1\.5 the warp bends.*last time that \./w\.1\.usda says.*--flatten"):
        retime_file(path, tmp_path / "b.usda", Warp([0.0, 2.5 / 24, 6 / 24], [0.0, 1.5 / 24, 4 / 24]), tolerance=0)
    # On a clip's own sample it does no harm.
    warp = Warp([0.0, 3 / 24, 6 / 24], [0.0, 1 / 24, 4 / 24])
    retime_file(path, tmp_path / "b.usda", warp, tolerance=0)
    old, new = literal.opened(path), literal.opened(tmp_path / "b.usda")
    for code in np.arange(0, 6, 0.25):
        shown = old.GetAttributeAtPath("/A.x").Get(float(warp(code / 24)) * 24)
        assert new.GetAttributeAtPath("/A.x").Get(code) == pytest.approx(shown, abs=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("double templateStride = 1", "double templateStride = 0", "by 0 name no clips, or too many"),
        ("double templateEndTime = 5", "double templateEndTime = 1e11", "name no clips, or too many"),
        ("double templateEndTime = 5\n", "", "templateEndTime is not there"),
        ("w.##.usda", "w.usda", "is no template"),
        ("./c/w.##.usda", "../w.##.usda", "leaves its folder"),
        ("string primPath", "asset[] assetPaths = [@./one.usda@]\n            string primPath", "one by one as well"),
    ],
)
def test_templates_that_name_no_clips_are_refused(tmp_path: Path, old: str, new: str, told: str) -> None:
    text = TEMPLATE.format("##", 1, 5, 1, "")
    assert old in text
    (tmp_path / "a.usda").write_text(text.replace(old, new))
    with pytest.raises(FormatError, match=told):
        retime.read(tmp_path / "a.usda")


def test_a_layer_over_shows_samples_of_another_layer_and_clips_do_not(tmp_path: Path) -> None:
    scene = DrawnScene(6)
    (tmp_path / "anim.usda").write_text(scene.text())
    path = tmp_path / "a.usda"
    clock = f"startTimeCode = {scene.start}\n    endTimeCode = {scene.end}\n    timeCodesPerSecond = {scene.per_second}"
    path.write_text(f"#usda 1.0\n(\n    {clock}\n    subLayers = [@./anim.usda@ (offset = 2; scale = 0.5)]\n)\n")
    warp = a_warp(scene.length / scene.per_second)
    with pytest.raises(FormatError, match=r"not in the file itself.*--layer over"):
        retime_file(path, tmp_path / "b.usda", warp, layer="clips")
    retime_file(path, tmp_path / "b.usda", warp, layer="over", tolerance=0)
    before = literal.opened(path)
    relative, degrees, other = literal.worst(before, literal.opened(tmp_path / "b.usda"), pairs(before, warp))
    assert (relative < 1e-6, degrees < 1e-3, other) == (True, True, [])


NAMING = {
    "a sublayer": "(\n    subLayers = [@{}@]\n)\n",
    "a reference": 'def "A" (\n    references = @{}@\n)\n{{\n}}\n',
    "a payload": 'def "A" (\n    payload = @{}@</B>\n)\n{{\n}}\n',
    "a texture": 'def "A"\n{{\n    asset inputs:file = @{}@\n}}\n',
    "a clip": 'def "A" (\n    clips = {{\n        dictionary c = {{\n'
    "            asset[] assetPaths = [@{}@]\n        }}\n    }}\n)\n{{\n}}\n",
    "a variant": 'def "A" (\n    variantSets = "v"\n)\n{{\n    variantSet "v" = {{\n        "a" (\n'
    "            references = @{}@\n        ) {{\n        }}\n    }}\n}}\n",
}
PLACES = [
    "../secret.usda",
    "{}/secret.usda",
    "https://example.org/a.usda",
    "b/../../secret.usda",
    "c:/x.usda",
    "`x`.usda",
]


@pytest.mark.parametrize(
    ("named", "how"),
    [("../secret.usda", how) for how in NAMING] + [(named, "a reference") for named in PLACES[1:]],
)
def test_files_elsewhere_are_refused(named: str, how: str, tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    (tmp_path / "secret.usda").write_text(DrawnScene(1).text())
    path = folder / "a.usda"
    path.write_text("#usda 1.0\n" + NAMING[how].format(named.format(tmp_path)))
    with pytest.raises(FormatError, match=r"it names .*(no file beside it|leaves its folder|only files can be read)"):
        retime.read(path)


def test_a_layer_beside_the_scene_is_looked_at_too_and_so_are_links(tmp_path: Path) -> None:
    folder = tmp_path / "in"
    folder.mkdir()
    (tmp_path / "secret.usda").write_text(DrawnScene(1).text())
    (folder / "a.usda").write_text("#usda 1.0\n(\n    subLayers = [@./b.usda@]\n)\n")
    (folder / "b.usda").write_text("#usda 1.0\n(\n    subLayers = [@../secret.usda@]\n)\n")
    with pytest.raises(FormatError, match="leaves its folder"):
        retime.read(folder / "a.usda")
    (folder / "b.usda").unlink()
    (folder / "b.usda").symlink_to(tmp_path / "secret.usda")
    with pytest.raises(FormatError, match="a link that leaves its folder"):
        retime.read(folder / "a.usda")
    # Asked for, they are read; what is within the folder always is.
    assert retime.read(folder / "a.usda", outside=True).n_frames > 1
    (folder / "b.usda").unlink()
    (folder / "b.usda").write_text(DrawnScene(1).text())
    assert retime.read(folder / "a.usda").n_frames > 1
    (folder / "b.usda").unlink()
    (folder / "c.usda").write_text(DrawnScene(1).text().replace("(\n    ", "(\n    subLayers = [@./b.usda@]\n    ", 1))
    with pytest.warns(FormatWarning, match=r"not there: b\.usda"):
        retime.read(folder / "c.usda")


def test_a_package_that_leads_out_of_itself_is_refused(tmp_path: Path) -> None:
    for names in (["../a.usda"], ["a.usda", "/b.png"], ["a.png"], ["a.usda", "a\\b.png"]):
        path = tmp_path / "a.usdz"
        path.write_bytes(packed(dict.fromkeys(names, b"#usda 1.0\n")))
        with pytest.raises(FormatError, match="usdz package"):
            retime.read(path)
    squeezed = BytesIO()
    with zipfile.ZipFile(squeezed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.usda", "#usda 1.0\n" + " " * 10**6)
    path.write_bytes(squeezed.getvalue())
    with pytest.raises(FormatError, match="compressed"):
        retime.read(path)


def test_what_is_damaged_or_no_scene_is_refused(tmp_path: Path) -> None:
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(DrawnScene(1).text())
    layer.Export(str(tmp_path / "whole.usdc"))
    whole = (tmp_path / "whole.usdc").read_bytes()
    for size in (0, 5, 8, 80, len(whole) // 2, len(whole) - 1):
        path = tmp_path / "a.usdc"
        path.write_bytes(whole[:size])
        with pytest.raises(FormatError, match=re.escape(str(path))):
            retime.read(path)
    for text in ("", "#usda 1.0\ndef {", "#usda 1.0\n", "hello", "#usda 1.0\n(\n    timeCodesPerSecond = 0\n)\n"):
        path = tmp_path / "a.usda"
        path.write_text(text)
        with pytest.raises(FormatError, match=re.escape(str(path))):
            retime.read(path)


def test_a_layer_is_of_usd_and_small(tmp_path: Path) -> None:
    scene = DrawnScene(8)
    path = tmp_path / "a.usda"
    path.write_text(scene.text())
    (tmp_path / "out").mkdir()
    place = tmp_path / "out" / "b.usda"
    warp = Warp([0.0, 1.0], [0.0, 0.5])
    retime_file(path, place, warp, layer="clips")
    assert "@../a.usda@" in place.read_text()
    assert len(place.read_text()) < 1500
    with pytest.raises(OptionError, match="is one of clips, over"):
        retime_file(path, place, warp, layer="under")
    with pytest.raises(OptionError, match="can't be baked"):
        retime_file(path, place, warp, layer="over", bake=True)
    with pytest.raises(FormatError, match=r"\.usda, \.usdc or \.usd"):
        retime_file(path, tmp_path / "b.usdz", warp, layer="over")
    with pytest.raises(FormatError, match=r"a \.usda file stays one"):
        retime_file(path, tmp_path / "b.usdc", warp)


def test_clips_show_nothing_where_root_prims_point_at_each_other(tmp_path: Path) -> None:
    scene = DrawnScene(8)
    path = tmp_path / "a.usda"
    path.write_text(scene.text().replace("</Body/Skel/Anim>", "</Prop>"))
    with pytest.raises(FormatError, match=r"/Body/Skel points at /Prop, .*--layer over"):
        retime_file(path, tmp_path / "b.usda", Warp([0.0, 1.0], [0.0, 0.5]), layer="clips")


@needs_captures
@pytest.mark.parametrize("name", REAL)
@pytest.mark.parametrize("way", ["", "clips", "over"])
def test_real_scenes_keep_their_skeletons_poses(name: str, way: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes((USD / name).read_bytes())
    clip = retime.read(path)
    warp = a_warp(clip.end_time)
    place = tmp_path / (f"b{path.suffix}" if not way else "b.usda")
    retime_file(path, place, warp, tolerance=0, layer=way or None)
    before, after = literal.opened(path), literal.opened(place)
    relative, degrees, other = literal.worst(before, after, pairs(before, warp, away=0))
    assert relative < 1e-6
    assert degrees < 1e-3
    assert other == []
    poses = []
    for stage in (before, after):
        cache, found = UsdSkel.Cache(), []
        for prim in stage.Traverse():
            if prim.IsA(UsdSkel.Root):
                cache.Populate(UsdSkel.Root(prim), Usd.PrimDefaultPredicate)
        for prim in stage.Traverse():
            if prim.IsA(UsdSkel.Skeleton):
                found.append(cache.GetSkelQuery(UsdSkel.Skeleton(prim)))
        poses.append(found)
    assert len(poses[0]) == len(poses[1]) > 0
    for out, into in pairs(before, warp, away=0):
        for a, b in zip(*poses, strict=True):
            old, new = (np.array(query.ComputeJointLocalTransforms(code)) for query, code in ((a, into), (b, out)))
            np.testing.assert_allclose(new, old, atol=2e-6 * max(1.0, float(np.abs(old).max(initial=0))))


def test_a_jump_of_the_warp_is_one_of_the_clips(tmp_path: Path) -> None:
    scene = DrawnScene(9)
    path, place = tmp_path / "a.usda", tmp_path / "b.usda"
    path.write_text(scene.text())
    length = scene.length / scene.per_second
    warp = Warp([0.0, 1.0, 1.0 + 1e-8, 2.0], [0.0, 0.5 * length, 0.2 * length, 0.9 * length])
    retime_file(path, place, warp, tolerance=0, layer="clips")
    before, after = literal.opened(path), literal.opened(place)
    chosen = pairs(before, warp)
    # At the jump itself the warp is still where it comes from.
    assert any(out == pytest.approx(scene.start + scene.per_second, abs=1e-9) for out, _ in chosen)
    relative, degrees, other = literal.worst(before, after, chosen)
    assert (relative < 1e-6, degrees < 1e-3, other) == (True, True, [])


def test_held_values_played_backward_by_clips_step_where_the_warp_says(tmp_path: Path) -> None:
    words = (
        '#usda 1.0\n(\n    startTimeCode = 0\n    endTimeCode = 48\n)\ndef "A"\n{\n    custom token x.timeSamples = {\n'
    )
    (tmp_path / "a.usda").write_text(words + '        0: "a",\n        20: "b",\n        36: "c",\n    }\n}\n')
    retime_file(tmp_path / "a.usda", tmp_path / "b.usda", Warp([0.0, 1.0, 4.0], [0.1, 1.6, 0.0]), layer="clips")
    stage = literal.opened(tmp_path / "b.usda")
    warp = Warp([0.0, 1.0, 4.0], [0.1, 1.6, 0.0])
    for code in np.arange(0.1, 97, 0.5):
        shown = float(warp(code / 24)) * 24
        assert stage.GetAttributeAtPath("/A.x").Get(code) == ("a" if shown < 20 else "b" if shown < 36 else "c")
    times = [row[0] for row in stage.GetPrimAtPath("/A").GetMetadata("clips")["default"]["times"]]
    # Two entries at one time, where a step is passed backward.
    assert len(times) - len(set(times)) == 2


def test_the_end_of_the_process_that_reads_is_an_error_and_no_more(tmp_path: Path) -> None:
    path = tmp_path / "a.usda"
    data = DrawnScene(1).text().encode()
    with usd.Decoder(Limits()) as decoder:
        assert usd.read_by(decoder, path, data, ReadOptions()).n_frames > 1
        assert not decoder.is_dead
        decoder._process.kill()
        with pytest.raises(FormatError, match="reading it ends the program that does"):
            usd.read_by(decoder, path, data, ReadOptions())
        assert decoder.is_dead
    # A process that has hardly begun is late.
    with usd.Decoder(Limits(), seconds=-0.01) as decoder, pytest.raises(FormatError, match="is not read after"):
        usd.read_by(decoder, path, data[:10], ReadOptions())


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            "double2[] times = [(0, 0), (24, 24), (48, 36)]",
            "double times = 5",
            r"default.*: times must be pairs of num",
        ),
        (
            "double2[] times = [",
            "double3[] times = [(1, 2, 3)]\n            double2[] none = [",
            r"default.*: times must be",
        ),
        (
            "dictionary default",
            "double other = 1\n        dictionary default",
            r"/A has value clips 'other' that are no",
        ),
    ],
)
def test_clips_that_are_none_are_the_files_fault(tmp_path: Path, old: str, new: str, told: str) -> None:
    for name in ("one", "two"):
        (tmp_path / f"{name}.usda").write_text(CLIP)
    assert old in WITH_CLIPS
    (tmp_path / "a.usda").write_text(WITH_CLIPS.replace(old, new))
    with pytest.raises(FormatError, match=told):
        retime_file(tmp_path / "a.usda", tmp_path / "b.usda", Warp([0.0, 1.0], [0.0, 0.5]))


def test_a_unit_that_is_no_number_is_refused_by_name(tmp_path: Path) -> None:
    for unit in ("nan", "inf"):
        (tmp_path / "a.usda").write_text(
            DrawnScene(1).text().replace("metersPerUnit = 0.01", f"metersPerUnit = {unit}")
        )
        with pytest.raises(FormatError, match=f"metersPerUnit is {unit}, which is no length"):
            retime.read(tmp_path / "a.usda")


def test_a_fault_of_retimes_own_is_not_called_damage(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.usda"
    path.write_text(DrawnScene(1).text())
    request = usd._request("names", path, path.read_bytes(), ReadOptions())

    def fails(_: object) -> list[str]:
        raise TypeError("'NoneType' object is not iterable\nand more")

    (tmp_path / "work").mkdir()
    with monkeypatch.context() as patch:
        patch.setattr(animation, "names_of", fails)
        answer = answered(request, tmp_path / "work", Limits())
    assert list(answer.facts) == ["fault"]
    assert re.fullmatch(
        r"TypeError: 'NoneType' object is not iterable \(usd/child\.py, line \d+\)", answer.facts["fault"]
    )
    monkeypatch.setattr("retime.formats.curves.usd.decoder.receive", lambda *_: answer)
    told = r"a\.usda: retime can't do this with the file, by a fault of its own .*TypeError: 'NoneType'.*report it"
    with pytest.raises(FormatError, match=told):
        animation_names(path)


def test_values_that_python_can_not_have_are_named_with_their_type() -> None:
    told = r"/A\.x is of the type odd\[\], whose values can't be read: No to_python \(by-value\) .* type: Odd$"
    with pytest.raises(FormatError, match=told), naming("/A.x", "odd[]"):
        raise TypeError("No to_python (by-value) C++ converter found for C++ type: Odd\nmore")


def test_nothing_is_left_of_the_copy_that_was_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    path = tmp_path / "a.usda"
    path.write_text(DrawnScene(1).text())
    retime.read(path)
    path.write_text("#usda 1.0\ndef {")
    with pytest.raises(FormatError) as caught:
        retime.read(path)
    assert "temporary" not in str(caught.value)
    assert "line 2:" in str(caught.value)
    assert list((tmp_path / "temporary").iterdir()) == []


def test_frames_are_not_made_on_the_word_of_one_time(tmp_path: Path) -> None:
    """A sample that is a day off, an end of the scene, or a clock, would make millions of frames of a few."""
    path = tmp_path / "a.usda"

    def scene(last: float, head: str = "timeCodesPerSecond = 24") -> Path:
        rows = f"double3 xformOp:translate.timeSamples = {{ 0: (0, 0, 0), 12: (1, 0, 0), {last!r}: (2, 0, 0) }}"
        order = 'uniform token[] xformOpOrder = ["xformOp:translate"]'
        path.write_text(f'#usda 1.0\n(\n    {head}\n)\ndef Xform "A"\n{{\n    {rows}\n    {order}\n}}\n')
        return path

    words = r"the scene lasts 86400 s, and no key lies between 0\.5 and 86400 s: 2073601 frames .* at 3 times"
    with pytest.raises(FormatError, match=words):
        retime.read(scene(86400 * 24.0))
    with pytest.raises(FormatError, match=words.replace(r"0\.5", r"0\.833333")):
        retime.read(scene(20.0, f"timeCodesPerSecond = 24\n    startTimeCode = 0\n    endTimeCode = {86400 * 24}"))
    with pytest.warns(FormatWarning, match=r"no key lies between 0\.833333 and 86400 s"):
        assert retime.read(path, rate=1).n_frames == 86_401
    with pytest.raises(FormatError, match=r"the scene lasts 245000 s, and no key .* frames would be made"):
        retime.read(scene(24.5, "timeCodesPerSecond = 0.0001"))
    with pytest.warns(FormatWarning, match=r"the scene lasts 3600 s, 86401 frames, and no key lies between 0\.5 and"):
        assert retime.read(scene(3600 * 24.0)).n_frames == 86_401
