"""USD scenes composed of layers: each that changes is written beside the new scene, which then shows what it should."""

from __future__ import annotations

import re
import warnings
import zipfile
from pathlib import Path

import numpy as np
import pytest

import retime
from retime.errors import FormatError, FormatWarning
from retime.files import noting_reads
from retime.formats.curves.usd.package import packed
from retime.formats.in_place import retime_file
from retime.formats.read_options import ReadOptions
from retime.formats.registry import facts_of
from retime.warp.curve import Warp
from tests.formats.curves.usd.scenes import DrawnScene
from tests.reference import usd as literal

pytest.importorskip("pxr", reason="usd-core is not installed (make extras)")

from pxr import Sdf, Usd

from tests.formats.curves.usd.test_format import CLIP, WITH_CLIPS, a_warp, pairs

pytestmark = pytest.mark.extras

SHOWN = "time samples that nothing in the scene shows now"


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def clock_of(scene: DrawnScene) -> str:
    return f"startTimeCode = {scene.start}\n    endTimeCode = {scene.end}\n    timeCodesPerSecond = {scene.per_second}"


def without_clock(scene: DrawnScene, per_second: float) -> str:
    text = re.sub(r" *(start|end)TimeCode = .*\n", "", scene.text())
    return re.sub(r"timeCodesPerSecond = \S+", f"timeCodesPerSecond = {per_second}", text)


def drawn_shot(seed: int, folder: Path) -> tuple[Path, float]:
    """A root that holds nothing that moves: all comes from layers, with offsets, other rates, layers of their own."""
    rng = np.random.default_rng(seed)
    scene, per_second = DrawnScene(seed), float(rng.choice([24, 30, 60]))

    def offset() -> str:
        return f"(offset = {rng.uniform(-5, 5):.3f}; scale = {rng.choice([0.5, 1, 2, 1.25])})"

    def rate() -> float:
        return float(rng.choice([24, 30, 48]))

    (folder / "lib" / "deep").mkdir(parents=True)
    (folder / "lib/walk.usda").write_text(without_clock(scene, scene.per_second))
    other = DrawnScene(seed + 100)
    (folder / "lib/deep/prop.usda").write_text(
        f"#usda 1.0\n(\n    timeCodesPerSecond = {other.per_second}\n)\n# of the library\n{other.prop()}"
    )
    (folder / "lib/set.usda").write_text(
        f'#usda 1.0\n(\n    timeCodesPerSecond = {rate()}\n)\ndef "Set"\n{{\n    asset wall = @./tex/wall.png@\n'
        f'    def "Prop" (\n        payload = @deep/prop.usda@</Prop> {offset()}\n    )\n    {{\n    }}\n}}\n'
    )
    (folder / "edits.usda").write_text(
        f"#usda 1.0\n(\n    timeCodesPerSecond = {rate()}\n    subLayers = [@lib/walk.usda@ {offset()}]\n)\n"
    )
    (folder / "still.usda").write_text('#usda 1.0\ndef "Still"\n{\n    double x = 1\n}\n')
    text = (
        f"#usda 1.0\n(\n    # by hand\n    timeCodesPerSecond = {per_second}\n"
        f"    subLayers = [@./edits.usda@ {offset()}, @still.usda@]\n)\n"
        f'def "Stage" (\n    variants = {{\n        string look = "full"\n    }}\n    variantSets = "look"\n)\n{{\n'
        '    asset sky = @lib/../tex/sky.png@\n    variantSet "look" = {\n        "full" (\n'
        f"            references = @lib/set.usda@</Set> {offset()}\n        ) {{\n        }}\n"
        '        "empty" {\n        }\n    }\n}\n'
    )
    # Its clock is that of what it shows.
    (folder / "clock.usda").write_text(text)
    codes = np.concatenate(list(literal.sampled(literal.opened(folder / "clock.usda")).values()))
    (folder / "clock.usda").unlink()
    path = folder / "shot.usda"
    ends = f"startTimeCode = {codes.min()}\n    endTimeCode = {codes.max()}\n    timeCodesPerSecond"
    path.write_text(text.replace("timeCodesPerSecond", ends, 1))
    return path, float(np.ptp(codes)) / per_second


def real_assets(stage) -> dict[str, str]:
    """Where files lie that attributes name, as their layers say it."""
    found = {}
    for prim in stage.Traverse():
        for attribute in prim.GetAttributes():
            if attribute.GetTypeName() == Sdf.ValueTypeNames.Asset:
                spec = attribute.GetPropertyStack(Usd.TimeCode.Default())[0]
                place = Path(spec.layer.realPath).parent / spec.default.path
                found[attribute.GetPath().pathString] = str(place.resolve())
    return found


@pytest.mark.parametrize("seed", range(6))
def test_a_shot_shows_at_t_what_it_showed_at_the_warps_time(tmp_path: Path, seed: int) -> None:
    path, length = drawn_shot(seed, tmp_path / "in")
    out = tmp_path / ("in" if seed % 3 == 0 else "out/new")
    out.mkdir(parents=True, exist_ok=True)
    old = contents(tmp_path / "in")
    before = literal.opened(path)
    assert len(literal.sampled(before)) == 19
    warp = a_warp(length)
    place = out / "short.usda"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        retime_file(path, place, warp, tolerance=0)
    after = literal.opened(place)
    relative, degrees, other = literal.worst(before, after, pairs(before, warp, seed=seed))
    assert (relative < 1e-6, degrees < 1e-3, other) == (True, True, [])
    new = {name: data for name, data in contents(out).items() if name not in old}
    assert sorted(new) == sorted(f"short.{name}usda" for name in ("", "edits.", "prop.", "set.", "walk."))
    # Nothing of the input is touched, and what is not retimed is where it was.
    assert {name: data for name, data in contents(tmp_path / "in").items() if name in old} == old
    assert real_assets(after) == real_assets(before)
    assert len(real_assets(after)) == 2
    assert after.GetAttributeAtPath("/Still.x").Get() == 1
    assert b"# of the library" in new["short.prop.usda"]
    assert b"# by hand" in new["short.usda"]
    # What was made is a scene like any: once more, and no chain of names.
    half = Warp([0.0, 0.4 * length], [0.0, 0.8 * length])
    retime_file(place, out / "again.usda", half, tolerance=0, outside=out != path.parent)
    assert (out / "again.walk.usda").is_file()
    again = literal.opened(out / "again.usda")
    relative, degrees, other = literal.worst(after, again, pairs(after, half))
    assert (relative < 2e-6, degrees < 1e-3, other) == (True, True, [])


def test_layers_of_the_binary_kind_and_packages_are_written_as_what_they_are(tmp_path: Path) -> None:
    scene = DrawnScene(3)
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(without_clock(scene, 24))
    layer.Export(str(tmp_path / "walk.usdc"))
    inner = DrawnScene(4).prop().replace('"Prop"', '"Boxed"')
    members = {"root.usda": f"#usda 1.0\n# in the box\n{inner}".encode(), "tex.png": b"picture"}
    (tmp_path / "box.usdz").write_bytes(packed(members))
    path = tmp_path / "a.usda"
    path.write_text(
        f"#usda 1.0\n(\n    {clock_of(scene)}\n    subLayers = [@walk.usdc@]\n)\n"
        'def "Ref" (\n    references = @box.usdz@</Boxed> (offset = 4)\n)\n{\n}\n'
    )
    warp = a_warp(scene.length / scene.per_second)
    before = literal.opened(path)
    assert "/Ref.xformOp:translate" in literal.sampled(before)
    retime_file(path, tmp_path / "b.usda", warp, tolerance=0)
    relative, degrees, other = literal.worst(before, literal.opened(tmp_path / "b.usda"), pairs(before, warp))
    assert (relative < 1e-6, degrees < 1e-3, other) == (True, True, [])
    assert (tmp_path / "b.walk.usdc").read_bytes().startswith(b"PXR-USDC")
    with zipfile.ZipFile(tmp_path / "b.box.usdz") as archive:
        assert archive.namelist() == list(members)
        assert archive.read("tex.png") == b"picture"
        assert b"# in the box" in archive.read("root.usda")


def test_frames_are_baked_in_every_layer_and_feet_average_as_one_skeleton(tmp_path: Path) -> None:
    scene = DrawnScene(5)
    for name in ("whole.usda", "anim.usda"):
        (tmp_path / name).write_text(DrawnScene(5).text())
    path = tmp_path / "a.usda"
    # Which feet stand is told by sizes and by what is up, and those are what the root says.
    body = 'upAxis = "Z"\n    metersPerUnit = 0.01'
    path.write_text(f"#usda 1.0\n(\n    {clock_of(scene)}\n    {body}\n    subLayers = [@anim.usda@]\n)\n")
    length = scene.length / scene.per_second
    warp = Warp([0.0, length / 2, length], [0.0, length, length])
    for source, place in (("a.usda", "b.usda"), ("whole.usda", "c.usda")):
        retime_file(tmp_path / source, tmp_path / place, warp, rate=40, bake=True)
    parts, whole = literal.opened(tmp_path / "b.usda"), literal.opened(tmp_path / "c.usda")
    assert literal.sampled(parts) == literal.sampled(whole)
    every = sorted({code for codes in literal.sampled(whole).values() for code in codes})
    assert literal.worst(whole, parts, [(code, code) for code in every]) == (0.0, 0.0, [])


TWICE = """def "A" (
    references = @b.usda@</Prop>
)
{{
}}
def "B" (
    references = @b.usda@</{}> (offset = {})
)
{{
}}
"""


def test_what_is_shown_at_two_times_is_refused_in_plain_words(tmp_path: Path) -> None:
    scene = DrawnScene(6)
    prop = scene.prop()
    (tmp_path / "b.usda").write_text("#usda 1.0\n" + prop + prop.replace('"Prop"', '"Other"'))
    path, place = tmp_path / "a.usda", tmp_path / "c.usda"
    head = f"#usda 1.0\n(\n    {clock_of(scene)}\n)\n"
    path.write_text(head + TWICE.format("Prop", 5))
    warp = a_warp(scene.length / scene.per_second)
    old = contents(tmp_path)
    told = r"/Prop of b\.usda is shown at 2 times \(offset 0.*, offset 5.*\).*--layer over"
    with pytest.raises(FormatError, match=told):
        retime_file(path, place, warp, tolerance=0)
    assert contents(tmp_path) == old
    # Other samples of one file are each on a clock of their own, and one clock twice is one.
    for other, offset, way in (("Prop", 5, "over"), ("Other", 5, None), ("Prop", 0, None)):
        # Places of their own, for USD remembers what it has read.
        folder = tmp_path / f"{other}{offset}"
        folder.mkdir()
        (folder / "b.usda").write_bytes(old["b.usda"])
        path, place = folder / "a.usda", folder / "c.usda"
        path.write_text(head + TWICE.format(other, offset))
        before = literal.opened(path)
        with warnings.catch_warnings():
            # The library's other half is not shown at all; it is on the one clock that there is.
            warnings.simplefilter("error" if way is None else "ignore")
            retime_file(path, place, warp, tolerance=0, layer=way)
        relative, degrees, differs = literal.worst(before, literal.opened(place), pairs(before, warp))
        assert (relative < 1e-6, degrees < 1e-3, differs) == (True, True, []), (other, offset, way)


def test_a_class_is_on_the_clock_of_what_shows_it(tmp_path: Path) -> None:
    path = tmp_path / "a.usda"
    samples = "double x.timeSamples = {\n        0: 0,\n        48: 48,\n    }\n"
    head = "#usda 1.0\n(\n    startTimeCode = 10\n    endTimeCode = 58\n)\n"
    shown = 'def "B" (\n    references = </{}> (offset = 10)\n)\n{{\n}}\n'
    path.write_text(head + f'class "C"\n{{\n    {samples}}}\n' + shown.format("C"))
    warp = Warp([0.0, 0.5, 1.0], [0.0, 1.5, 2.0])
    retime_file(path, tmp_path / "b.usda", warp, tolerance=0)
    stage = literal.opened(tmp_path / "b.usda")
    for code in np.linspace(10, 34, 13):
        wanted = 24 * float(warp((code - 10) / 24))
        np.testing.assert_allclose(stage.GetAttributeAtPath("/B.x").Get(code), wanted, atol=1e-6)
    # The same of a prim that is itself seen is at two times.
    path.write_text(head + f'def "C"\n{{\n    {samples}}}\n' + shown.format("C"))
    with pytest.raises(FormatError, match=r"/C of a\.usda is shown at 2 times"):
        retime_file(path, tmp_path / "b.usda", warp, overwrite=True)


def test_samples_that_stay_as_they_were_are_told(tmp_path: Path) -> None:
    scene = DrawnScene(7)
    for name in ("walk", "run"):
        (tmp_path / f"{name}.usda").write_text(scene.text())
    path = tmp_path / "a.usda"
    variants = "".join(
        f'        "{name}" (\n            references = @{name}.usda@</Prop>\n        ) {{\n        }}\n'
        for name in ("walk", "run")
    )
    path.write_text(
        f'#usda 1.0\n(\n    {clock_of(scene)}\n)\ndef "A" (\n    variants = {{\n        string how = "walk"\n    }}\n'
        f'    variantSets = "how"\n)\n{{\n    variantSet "how" = {{\n{variants}    }}\n}}\n'
    )
    warp = a_warp(scene.length / scene.per_second)
    with pytest.warns(FormatWarning, match=rf"{SHOWN}.*: run\.usda$"):
        retime_file(path, tmp_path / "b.usda", warp)
    assert not (tmp_path / "b.run.usda").exists()
    assert "@./b.walk.usda@" in (tmp_path / "b.usda").read_text()
    assert "references = @run.usda@" in (tmp_path / "b.usda").read_text()
    with pytest.warns(FormatWarning, match=rf"{SHOWN}.*run\.usda"):
        retime_file(path, tmp_path / "over.usda", warp, layer="over")


def test_no_file_of_the_scene_is_written_over(tmp_path: Path) -> None:
    scene = DrawnScene(8)
    (tmp_path / "anim.usda").write_text(scene.text())
    (tmp_path / "b.anim.usda").write_text("#usda 1.0\n")
    path = tmp_path / "a.usda"
    path.write_text(f"#usda 1.0\n(\n    {clock_of(scene)}\n    subLayers = [@anim.usda@, @b.anim.usda@]\n)\n")
    old = contents(tmp_path)
    warp = a_warp(scene.length / scene.per_second)
    with pytest.raises(FormatError, match=r"anim\.usda is a part of the scene.*choose another name"):
        retime_file(path, tmp_path / "anim.usda", warp, overwrite=True)
    assert contents(tmp_path) == old
    retime_file(path, tmp_path / "b.usda", warp, overwrite=True)
    new = contents(tmp_path)
    assert {name: new[name] for name in old} == old
    assert sorted(new.keys() - old.keys()) == ["b.anim-2.usda", "b.usda"]


def test_layers_elsewhere_are_retimed_where_that_is_allowed(tmp_path: Path) -> None:
    scene = DrawnScene(9)
    (tmp_path / "shared").mkdir()
    (tmp_path / "in").mkdir()
    (tmp_path / "shared/anim.usda").write_text(scene.text())
    (tmp_path / "shared/lib.usda").write_text(
        f'#usda 1.0\n{DrawnScene(10).prop().replace("Prop", "Far")}def "Tex"\n{{\n    asset f = @./a.png@\n}}\n'
    )
    path = tmp_path / "in/a.usda"
    far = tmp_path / "shared/lib.usda"
    path.write_text(f"#usda 1.0\n(\n    {clock_of(scene)}\n    subLayers = [@../shared/anim.usda@, @{far}@]\n)\n")
    warp = a_warp(scene.length / scene.per_second)
    with pytest.raises(FormatError, match="--allow-outside"):
        retime_file(path, tmp_path / "in/b.usda", warp)
    old = contents(tmp_path)
    before = literal.opened(path)
    retime_file(path, tmp_path / "in/b.usda", warp, tolerance=0, outside=True)
    new = contents(tmp_path)
    assert {name: new[name] for name in old} == old
    assert sorted(new.keys() - old.keys()) == ["in/b.anim.usda", "in/b.lib.usda", "in/b.usda"]
    after = literal.opened(tmp_path / "in/b.usda")
    relative, degrees, other = literal.worst(before, after, pairs(before, warp))
    assert (relative < 1e-6, degrees < 1e-3, other) == (True, True, [])
    assert real_assets(after) == {"/Tex.f": str(tmp_path / "shared/a.png")}


def test_clips_of_a_sublayer_get_other_times(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "lib/one.usda").write_text(CLIP)
    (tmp_path / "lib/two.usda").write_text(CLIP.replace("48: 48", "48: 480"))
    (tmp_path / "lib/played.usda").write_text(WITH_CLIPS)
    path = tmp_path / "a.usda"
    path.write_text(
        "#usda 1.0\n(\n    startTimeCode = 0\n    endTimeCode = 48\n"
        "    subLayers = [@lib/played.usda@ (offset = 6)]\n)\n"
    )
    warp = Warp([0.0, 0.5, 1.0, 2.0], [0.0, 1.0, 1.0, 2.0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        retime_file(path, tmp_path / "out/b.usda", warp, tolerance=0)
    before, after = literal.opened(path), literal.opened(tmp_path / "out/b.usda")
    for code in np.arange(0, 48.0):
        shown = before.GetAttributeAtPath("/A.x").Get(float(warp(code / 24)) * 24)
        np.testing.assert_allclose(after.GetAttributeAtPath("/A.x").Get(code), shown, atol=1e-6)


TIMES = """#usda 1.0
(
    startTimeCode = 10
    endTimeCode = 58
)
def "Sound"
{
    # when it begins
    timecode startTime =   22
    custom timecode[] steps = [10, 34, 58, 82]
    custom double level = 22
    custom timecode said.timeSamples = {
        10: 10,
        58: 58,
    }
}
"""


def test_values_that_are_times_go_through_the_warp(tmp_path: Path) -> None:
    (tmp_path / "a.usda").write_text(TIMES)
    # On the clock of the root code 8 + 2 x is what the layer calls x.
    (tmp_path / "ref.usda").write_text(
        '#usda 1.0\n(\n    startTimeCode = 28\n    endTimeCode = 124\n)\ndef "R" (\n'
        "    references = @a.usda@</Sound> (offset = 8; scale = 2)\n)\n{\n}\n"
    )
    for name, prim, start, length in (("a.usda", "/Sound", 10, 2.0), ("ref.usda", "/R", 28, 4.0)):
        old = literal.opened(tmp_path / name)
        warp = Warp([0.0, length / 2], [0.0, length])
        for way in (None, "over"):
            place = tmp_path / f"new-{way}-{name}"
            retime_file(tmp_path / name, place, warp, tolerance=0, layer=way)
            new = literal.opened(place)
            for attribute in ("startTime", "steps"):
                was, now = (stage.GetAttributeAtPath(f"{prim}.{attribute}").Get() for stage in (old, new))
                was, now = (np.atleast_1d([float(x) for x in np.atleast_1d(one)]) for one in (was, now))
                # Twice as fast: each time is half as far from the start, and one after the end stays as far after it.
                end = start + 24 * length
                wanted = start + (np.minimum(was, end) - start) / 2 + np.maximum(was - end, 0)
                np.testing.assert_allclose(now, wanted, atol=1e-9)
            assert new.GetAttributeAtPath(f"{prim}.level").Get() == 22
            said = new.GetAttributeAtPath(f"{prim}.said")
            for code in np.linspace(start, start + 12 * length, 7):
                np.testing.assert_allclose(float(said.Get(float(code))), code, atol=1e-6)
    text = (tmp_path / "new-None-a.usda").read_text()
    assert "    # when it begins\n    timecode startTime =   16\n" in text
    with pytest.raises(FormatError, match=r"/Sound\.said says times.*--layer over"):
        retime_file(tmp_path / "a.usda", tmp_path / "clips.usda", Warp([0.0, 1.0], [0.0, 2.0]), layer="clips")


def test_instances_of_a_layer_are_retimed_together(tmp_path: Path) -> None:
    scene = DrawnScene(11)
    (tmp_path / "b.usda").write_text(f"#usda 1.0\n{scene.prop()}")
    path = tmp_path / "a.usda"
    one = 'def "{}" (\n    instanceable = true\n    references = @b.usda@</Prop> (offset = 2)\n)\n{{\n}}\n'
    path.write_text(f"#usda 1.0\n(\n    {clock_of(scene)}\n)\n" + one.format("A") + one.format("B"))
    warp = a_warp(scene.length / scene.per_second)
    before = literal.opened(path)
    retime_file(path, tmp_path / "c.usda", warp, tolerance=0)
    relative, degrees, other = literal.worst(before, literal.opened(tmp_path / "c.usda"), pairs(before, warp))
    assert (relative < 1e-6, degrees < 1e-3, other) == (True, True, [])
    assert retime.read(tmp_path / "c.usda").n_frames > 1


def test_info_tells_layers_clock_and_what_moves(tmp_path: Path) -> None:
    path, _ = drawn_shot(2, tmp_path)
    stage = literal.opened(path)
    samples = literal.sampled(stage)
    found = facts_of(path, ReadOptions())
    start, end, per_second = stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()
    joints = len(stage.GetPrimAtPath("/Body/Skel").GetAttribute("joints").Get())
    turns = {code for name in ("rotations", "translations") for code in samples[f"/Body/Skel/Anim.{name}"]}
    weights = len(samples["/Body/Skel/Anim.blendShapeWeights"])
    assert found == {
        "stored": "text",
        "layers": "6: shot.usda, edits.usda, lib/deep/prop.usda, lib/set.usda, lib/walk.usda, still.usda",
        "clock": f"{per_second:g} time codes a second, from {start:g} to {end:g}",
        "scene": "7 prims, 1 skeletons, 0 meshes, 0 cameras; up axis Y, 0.01 m a unit (not said)",
        "animations": f"1: /Body/Skel/Anim ({joints} joints, {len(turns)} samples; 2 blend shapes, {weights} samples)",
        "animated": "3: /Body/Skel/Anim, /Prop, /Stage/Prop; 19 attributes, "
        f"{sum(len(codes) for codes in samples.values())} samples",
    }
    boxed = tmp_path / "a.usdz"
    boxed.write_bytes(packed({"a.usda": WITH_CLIPS.encode(), "one.usda": CLIP.encode(), "two.usda": CLIP.encode()}))
    found = facts_of(boxed, ReadOptions())
    assert found["stored"] == "package of 3 files, the first is a.usda (text)"
    assert (found["value clips"], found["animations"]) == ("1: /A", "none")


def test_a_library_is_done_again_where_a_layer_changes(tmp_path: Path) -> None:
    (tmp_path / "shared").mkdir()
    path, _ = drawn_shot(1, tmp_path / "in")
    with noting_reads() as read:
        retime.read(path)
    names = ("shot", "edits", "still", "lib/set", "lib/walk", "lib/deep/prop")
    assert sorted(read) == sorted(tmp_path / f"in/{name}.usda" for name in names)
    # Also where it is elsewhere, and where it is what is wrong.
    (tmp_path / "shared/a.usda").write_text(DrawnScene(1).text())
    outer = tmp_path / "in/outer.usda"
    outer.write_text("#usda 1.0\n(\n    subLayers = [@../shared/a.usda@]\n)\n")
    with noting_reads() as read:
        retime.read(outer, outside=True)
    assert set(read) == {outer, tmp_path / "shared/a.usda"}
    (tmp_path / "in/lib/set.usda").write_text("#usda 1.0\ndef {")
    with noting_reads() as read, pytest.raises(FormatError, match=r"set\.usda"):
        retime.read(path)
    assert tmp_path / "in/lib/set.usda" in read


def test_pictures_that_change_are_named_from_where_the_new_layer_lies(tmp_path: Path) -> None:
    shown = (
        'def "Sky"\n{\n    asset f.timeSamples = {\n        0: @./tex/a.png@,\n        24: @../b.png@,\n    }\n'
        "    asset[] g.timeSamples = {\n        0: [@c.png@],\n        24: [@c.png@, @@],\n    }\n}\n"
    )
    clock = "startTimeCode = 0\n    endTimeCode = 48"
    (tmp_path / "in/lib").mkdir(parents=True)
    (tmp_path / "out").mkdir()
    (tmp_path / "in/lib/sky.usda").write_text(f"#usda 1.0\n{shown}")
    root = f"#usda 1.0\n(\n    {clock}\n    subLayers = [@lib/sky.usda@]\n)\n"
    (tmp_path / "in/a.usda").write_text(root)
    boxed = {"a.usda": root.encode(), "lib/sky.usda": f"#usda 1.0\n{shown}".encode(), "b.png": b"", "lib/c.png": b""}
    (tmp_path / "in/a.usdz").write_bytes(packed({**boxed, "lib/tex/a.png": b""}))
    warp = Warp([0.0, 1.0], [0.0, 2.0])
    for name, way, names in (
        ("a.usda", "over", ("../in/lib/tex/a.png", "../in/b.png", "../in/lib/c.png")),
        ("a.usdz", "over", ("../in/a.usdz[lib/tex/a.png]", "../in/a.usdz[b.png]", "../in/a.usdz[lib/c.png]")),
        ("a.usda", None, ("../in/lib/tex/a.png", "../in/b.png", "../in/lib/c.png")),
    ):
        place = tmp_path / f"out/{way}-{name[:6].replace('.', '-')}.usda"
        retime_file(tmp_path / "in" / name, place, warp, layer=way)
        stage = literal.opened(place)
        f, g = (stage.GetAttributeAtPath(f"/Sky.{one}") for one in "fg")
        assert [f.Get(code).path for code in (0, 11, 13)] == [names[0], names[0], names[1]]
        assert [[one.path for one in g.Get(code)] for code in (0, 13)] == [[names[2]], [names[2], ""]]
