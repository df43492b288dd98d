"""glTF retimed in place: each channel has at t what it had at warp(t); what was not asked to change did not."""

from __future__ import annotations

import json
import shutil
import struct
import subprocess
import warnings
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import retime
from retime.errors import FormatError, FormatWarning, OutputExistsError
from retime.formats.curves.gltf import format as gltf
from retime.formats.in_place import retime_file
from retime.formats.read_options import Limits, ReadOptions
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.warp.apply import apply_warp
from retime.warp.curve import Warp
from tests.formats.curves.gltf.scenes import Scene, drawn_scene, unit_rows
from tests.reference.gltf import Scene as Literal
from tests.warp.drawn import drawn_warp

GLTF = Path(__file__).parents[5] / "shared" / "mocap" / "gltf"
needs_captures = pytest.mark.skipif(not GLTF.is_dir(), reason="the captures are not beside the project (../shared)")


def retimed(path: Path, warps, place: Path, options: ReadOptions | None = None, bake: bool | None = None) -> Path:
    """Retime a file into a folder of its own."""
    options = options or ReadOptions()
    data = path.read_bytes()
    names = gltf.animation_names(path, data, options)
    warps = dict.fromkeys(names, warps) if isinstance(warps, Warp) else warps
    if bake is None:
        files = gltf.retime(path, data, warps, options)
    else:
        files = gltf.bake(path, data, warps, options, average=bake)
    for name, content in files.items():
        content = content.replace(b"{stem}", place.stem.encode()) if not name else content
        (place.parent / name.replace("{stem}", place.stem) if name else place).write_bytes(content)
    return place


def worst_error(before: Literal, after: Literal, animation: int, warp: Warp, start: float, seed: int = 0) -> float:
    """The largest error of any channel, relative to its largest value, at times away from steps."""
    rng = np.random.default_rng(seed)
    times = rng.uniform(warp.output_start, warp.output_end, 40)
    worst = 0.0
    track = before.json["animations"][animation]
    for channel, item in enumerate(track["channels"]):
        sampler = track["samplers"][item["sampler"]]
        keys = np.array(before.accessor(sampler["input"]))[:, 0]
        values = np.abs(before.accessor(sampler["output"]))
        for time in times:
            shown = float(warp(time)) + start
            # Single precision moves a step, and a corner between steep lines, by a millionth of a second.
            if np.abs(keys - shown).min() < 1e-5 and sampler.get("interpolation") == "STEP":
                continue
            a, b = before.value(animation, channel, shown), after.value(animation, channel, time + start)
            if item["target"]["path"] == "rotation" and sampler.get("interpolation", "LINEAR") == "LINEAR":
                b = b if np.dot(a, b) >= 0 else [-x for x in b]
            worst = max(worst, np.abs(np.subtract(a, b)).max() / values.max())
    return worst


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
def test_every_channel_has_at_t_what_it_had_at_the_warps_time(tmp_path, seed, forward, binary) -> None:
    rng = np.random.default_rng(seed)
    start = float(np.float32(rng.uniform(0, 2)))
    scene = drawn_scene(seed, start)
    path = tmp_path / ("a.glb" if binary else "a.gltf")
    path.write_bytes(scene.glb() if binary else scene.gltf())
    warp = drawn_warp(rng, int(rng.integers(2, 8)), forward=forward)
    span = 1.2 * (warp.input_times.max() - warp.input_times.min() + 1e-9)
    warp = Warp(warp.output_times - warp.output_start, 3 * (warp.input_times - warp.input_times.min()) / span - 0.1)
    out = retimed(path, warp, tmp_path / f"b{path.suffix}")
    # A fast curve feels the rounding of a key's time to single precision, here at most 2.4e-7 s.
    fastest = float(np.abs(warp.slopes).max())
    assert worst_error(Literal(path), Literal(out), 0, warp, start, seed) < 4e-6 * max(5.0, fastest)


def test_what_served_the_animation_alone_is_replaced_and_all_else_stays(tmp_path: Path) -> None:
    scene = drawn_scene(3)
    path = tmp_path / "a.glb"
    path.write_bytes(scene.glb())
    out = retimed(path, Warp([0.0, 1.0, 3.0], [0.0, 0.7, 1.0]), tmp_path / "b.glb")
    before, after = Literal(path), Literal(out)
    for name in ("asset", "nodes", "meshes", "scenes", "extras"):
        assert before.json[name] == after.json[name]
    assert len(after.json["accessors"]) == len(before.json["accessors"])
    assert len(after.json["bufferViews"]) == len(before.json["bufferViews"])
    for kept in (0, len(before.json["accessors"]) - 1):
        assert before.accessor(kept) == after.accessor(kept)
    # The text is as it was, but for the members that changed.
    old, new = (data[20 : 20 + struct.unpack_from("<I", data, 12)[0]] for data in (path.read_bytes(), out.read_bytes()))
    assert old[: old.index(b'"accessors"')] == new[: new.index(b'"accessors"')]
    assert '"extras": {"kept": [1.0, "ü"]}'.encode() in old
    assert '"extras": {"kept": [1.0, "ü"]}'.encode() in new


@pytest.mark.parametrize("binary", [True, False])
def test_a_view_of_bytes_that_its_buffer_does_not_declare_is_refused(binary: bool, tmp_path: Path) -> None:
    scene = drawn_scene(3)
    size = len(scene.chunk)
    scene.json["bufferViews"].append({"buffer": 0, "byteOffset": size + 160, "byteLength": 8})
    path = tmp_path / ("a.glb" if binary else "a.gltf")
    scene.chunk += bytes(200)
    data = scene.glb() if binary else scene.gltf()
    # There are as many bytes; the buffer has fewer.
    declared = b'"byteLength": %d' % len(scene.chunk)
    assert data.count(declared) == 1
    path.write_bytes(data.replace(declared, (b'"byteLength": %d' % size).ljust(len(declared))))
    problem = f"ends at byte {size + 168} of buffer 0, which has {size}"
    with pytest.raises(FormatError, match=problem):
        retimed(path, Warp([0.0, 1.0, 3.0], [0.0, 0.7, 1.0]), tmp_path / f"b{path.suffix}")


def test_retiming_again_and_again_does_not_grow_the_file(tmp_path: Path) -> None:
    path = tmp_path / "0.glb"
    path.write_bytes(drawn_scene(4).glb())
    sizes = []
    for turn in range(1, 5):
        path = retimed(path, Warp([0.0, 4.0], [0.0, 4.0]), tmp_path / f"{turn}.glb")
        sizes.append(len(path.read_bytes()))
    # The first time the numbers in its text may take another digit.
    assert len(set(sizes[1:])) == 1
    assert abs(sizes[0] - sizes[1]) < 32


def test_times_that_clips_share_are_changed_for_the_one_that_was_asked_for(tmp_path: Path) -> None:
    scene = Scene()
    scene.node(name="a")
    times = scene.accessor([0.0, 1.0, 2.0])
    values = scene.accessor(np.arange(9.0).reshape(3, 3))
    for name in ("one", "two"):
        scene.animation(name, [(0, "translation", times, values, "LINEAR")])
    path = tmp_path / "a.glb"
    path.write_bytes(scene.glb())
    options = ReadOptions(animation="two")
    out = Literal(retimed(path, Warp([0.0, 4.0], [0.0, 2.0]), tmp_path / "b.glb", options))
    samplers = [animation["samplers"][0] for animation in out.json["animations"]]
    assert out.accessor(samplers[0]["input"]) == [[0.0], [1.0], [2.0]]
    assert out.accessor(samplers[1]["input"]) == [[0.0], [2.0], [4.0]]
    assert samplers[0]["output"] == samplers[1]["output"] or out.accessor(samplers[1]["output"]) == [
        [0.0, 1.0, 2.0],
        [3.0, 4.0, 5.0],
        [6.0, 7.0, 8.0],
    ]
    item = out.json["accessors"][samplers[1]["input"]]
    assert (item["min"], item["max"], item["count"]) == ([0.0], [4.0], 3)


def test_a_hold_and_a_span_played_backward(tmp_path: Path) -> None:
    scene = Scene()
    scene.node(name="a")
    scene.animation(
        "x", [(0, "translation", scene.accessor([0.0, 2.0]), scene.accessor([[0.0] * 3, [2.0] * 3]), "LINEAR")]
    )
    path = tmp_path / "a.glb"
    path.write_bytes(scene.glb())
    out = Literal(retimed(path, Warp([0.0, 1.0, 2.0, 3.0], [0.0, 1.5, 1.5, 1.0]), tmp_path / "b.glb"))
    sampler = out.json["animations"][0]["samplers"][0]
    assert out.accessor(sampler["input"]) == [[0.0], [1.0], [2.0], [3.0]]
    assert [row[0] for row in out.accessor(sampler["output"])] == [0.0, 1.5, 1.5, 1.0]


def test_a_motion_is_read_with_its_nodes_as_joints(tmp_path: Path) -> None:
    scene = drawn_scene(5)
    path = tmp_path / "a.glb"
    path.write_bytes(scene.glb())
    clip = gltf.read(path, path.read_bytes(), ReadOptions(rate=50))
    assert isinstance(clip, Motion)
    assert clip.skeleton.names == ("bone 0", "bone 1", "bone 2")
    assert clip.skeleton.parents == (-1, 0, 1)
    literal = Literal(path)
    for frame in (0, 17, 31):
        q = np.array(literal.value(0, 1, frame / 50))
        np.testing.assert_allclose(np.abs(np.dot(np.roll(clip.rotations[frame, 0], -1), q)), 1, atol=1e-9)
        np.testing.assert_allclose(clip.local_translations[frame, 0], literal.value(0, 0, frame / 50), atol=1e-9)
    assert clip.end_time >= max(literal.accessor(i)[-1][0] for i in (1, 2)) - 1e-4


def test_the_rate_is_that_on_whose_frames_the_keys_lie(tmp_path: Path) -> None:
    for rate, found in ((24, 24), (30, 30), (25, 25), (120, 120), (59.3, 60)):
        scene = Scene()
        scene.node(name="a")
        keys = np.arange(40) / rate + 0.3
        scene.animation("x", [(0, "scale", scene.accessor(keys), scene.accessor(np.ones((40, 3))), "LINEAR")])
        clip = gltf.read(tmp_path / "a.glb", scene.glb(), ReadOptions())
        assert clip.rate == found


def test_baked_frames_are_those_of_the_motion_retimed(tmp_path: Path) -> None:
    path = tmp_path / "a.glb"
    path.write_bytes(drawn_scene(6).glb())
    options = ReadOptions(rate=40)
    clip = gltf.read(path, path.read_bytes(), options)
    warp = Warp([0.0, clip.end_time / 2], [0.0, clip.end_time])
    for average in (True, False):
        out = retimed(path, warp, tmp_path / f"{average}.glb", options, bake=average)
        found = gltf.read(out, out.read_bytes(), options)
        wanted = apply_warp(clip, warp, average=average)
        assert isinstance(found, Motion)
        assert found.n_frames == wanted.n_frames
        np.testing.assert_allclose(found.local_translations, wanted.local_translations, atol=1e-6)
        np.testing.assert_allclose(np.abs((found.rotations * wanted.rotations).sum(axis=2)), 1, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_baked_keys_lie_on_the_curves_between_the_frames_too(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "a.glb"
    path.write_bytes(drawn_scene(seed).glb())
    # Few frames: between them a cubic bends, and its corners are not to be cut.
    options = ReadOptions(rate=7)
    clip = gltf.read(path, path.read_bytes(), options)
    warp = Warp([0.0, clip.end_time * 1.3], [0.0, clip.end_time])
    before = Literal(path)
    after = Literal(retimed(path, warp, tmp_path / "b.glb", options, bake=False))
    track = before.json["animations"][0]
    first = min(row[0] for one in track["samplers"] for row in before.accessor(one["input"]))
    for channel in range(len(track["channels"])):
        for frame in range(warp.count_frames(7)):
            wanted = np.array(before.value(0, channel, first + float(warp(frame / 7))))
            found = np.array(after.value(0, channel, np.float32(first + frame / 7)))
            assert min(np.abs(found - wanted).max(), np.abs(found + wanted).max()) < 2e-5 * max(1, np.abs(wanted).max())


def test_weights_alone_are_a_signal(tmp_path: Path) -> None:
    scene = Scene()
    scene.node(name="face")
    weights = scene.accessor([0.0, 1.0, 0.5, 0.25, 0.5, 0.75])
    scene.animation("talk", [(0, "weights", scene.accessor([0.0, 0.5, 1.0]), weights, "LINEAR")])
    clip = gltf.read(tmp_path / "a.glb", scene.glb(), ReadOptions(rate=4))
    assert isinstance(clip, Signal)
    assert clip.names == ("face.weights.0", "face.weights.1")
    np.testing.assert_allclose(clip.values, [[0, 1], [0.25, 0.625], [0.5, 0.25], [0.5, 0.5], [0.5, 0.75]])


def test_weights_in_rows_of_another_width_are_laid_out_one_by_one(tmp_path: Path) -> None:
    scene = Scene()
    scene.node(name="face")
    # Two keys of six weights each, in three rows of four.
    rows = scene.accessor(np.arange(12.0).reshape(3, 4) / 12)
    scene.animation("talk", [(0, "weights", scene.accessor([0.0, 1.0]), rows, "LINEAR")])
    path = tmp_path / "a.glb"
    path.write_bytes(scene.glb())
    out = Literal(retimed(path, Warp([0.0, 1.0, 3.0], [0.0, 0.5, 1.0]), tmp_path / "b.glb"))
    np.testing.assert_allclose(out.value(0, 0, 1.0), (np.arange(6) + 3) / 12, atol=1e-6)
    assert [row[0] for row in out.accessor(out.json["animations"][0]["samplers"][0]["input"])] == [0.0, 1.0, 3.0]


def test_several_animations_are_named_and_the_first_is_read(tmp_path: Path) -> None:
    scene = Scene()
    scene.node(name="a")
    for name in ("walk", "run"):
        scene.animation(name, [(0, "scale", scene.accessor([0.0, 1.0]), scene.accessor(np.ones((2, 3))), "LINEAR")])
    path = tmp_path / "a.glb"
    with pytest.warns(FormatWarning, match=r"2 animations \(walk, run\); walk is read"):
        assert gltf.read(path, scene.glb(), ReadOptions()).name == "walk"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert gltf.read(path, scene.glb(), ReadOptions(animation="run")).name == "run"
        assert gltf.read(path, scene.glb(), ReadOptions(animation="1")).name == "run"
    for name in ("jump", "²", "2"):
        with pytest.raises(FormatError, match=f"no animation is called '{name}'; there are walk, run"):
            gltf.read(path, scene.glb(), ReadOptions(animation=name))
    with pytest.raises(FormatError, match=r"no animation is called '9{100}'; there are walk, run"):
        gltf.read(path, scene.glb(), ReadOptions(animation="9" * 5000))


def _broken(change) -> bytes:
    scene = drawn_scene(1)
    change(scene.json)
    return scene.glb()


BROKEN = {
    "beyond its view": lambda j: j["accessors"][1].update(count=9999),
    "beyond its buffer": lambda j: j["bufferViews"][1].update(byteLength=10**9),
    "no such accessor": lambda j: j["animations"][0]["samplers"][0].update(input=999),
    "no such node": lambda j: j["animations"][0]["channels"][0]["target"].update(node=77),
    "a node that is its own ancestor": lambda j: j["nodes"][2].update(children=[0]),
    "two parents": lambda j: j["nodes"].append({"children": [1]}),
    "an unknown interpolation": lambda j: j["animations"][0]["samplers"][0].update(interpolation="CUBIC"),
    "a negative count": lambda j: j["accessors"][1].update(count=-3),
    "a type that is none": lambda j: j["accessors"][1].update(type="VEC7"),
    "values that don't fit": lambda j: j["animations"][0]["samplers"][0].update(output=0),
    "a bomb of zeros": lambda j: j["accessors"].__setitem__(
        1,
        {
            "count": 2**40,
            "type": "SCALAR",
            "componentType": 5126,
            "sparse": {"count": 0, "indices": {"bufferView": 0, "componentType": 5125}, "values": {"bufferView": 0}},
        },
    ),
}


@pytest.mark.parametrize("what", BROKEN)
def test_what_is_broken_is_refused_with_its_place(what: str, tmp_path: Path) -> None:
    path = tmp_path / "a.glb"
    data = _broken(BROKEN[what])
    with pytest.raises(FormatError) as caught:
        gltf.read(path, data, ReadOptions())
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    "uri", ["../secret.bin", "/etc/passwd", "http://example.org/a.bin", "file:///etc/passwd", "a/../../b.bin", "c:\\x"]
)
def test_a_buffer_elsewhere_is_refused(uri: str, tmp_path: Path) -> None:
    (tmp_path / "secret.bin").write_bytes(b"\0" * 64)
    folder = tmp_path / "in"
    folder.mkdir()
    document = {"asset": {"version": "2.0"}, "buffers": [{"uri": uri, "byteLength": 4}]}
    with pytest.raises(FormatError, match=r"beside this one|leaves the file's folder"):
        gltf.read(folder / "a.gltf", json.dumps(document).encode(), ReadOptions())


def test_a_cut_glb_is_noticed(tmp_path: Path) -> None:
    data = drawn_scene(2).glb()
    for size in (0, 3, 11, 19, 100, len(data) // 2, len(data) - 1):
        with pytest.raises(FormatError):
            gltf.read(tmp_path / "a.glb", data[:size], ReadOptions())


@pytest.mark.parametrize("body", ["AAA", "AA=A", "AA\u00e9A", "AA AA"])
def test_data_that_are_no_base64_are_refused(body: str, tmp_path: Path) -> None:
    uri = f"data:application/octet-stream;base64,{body}"
    document = {"asset": {"version": "2.0"}, "buffers": [{"uri": uri, "byteLength": 3}]}
    with pytest.raises(FormatError, match=r"buffers\[0\]\.uri: "):
        gltf.read(tmp_path / "a.gltf", json.dumps(document).encode(), ReadOptions())


def test_an_animation_too_long_for_its_rate_is_refused(tmp_path: Path) -> None:
    scene = Scene()
    scene.node(name="a")
    scene.animation("x", [(0, "scale", scene.accessor([0.0, 9e6]), scene.accessor(np.ones((2, 3))), "LINEAR")])
    with pytest.raises(FormatError, match="give a lower rate"):
        gltf.read(tmp_path / "a.glb", scene.glb(), ReadOptions(limits=Limits()))


def test_frames_are_not_made_on_the_word_of_one_key(tmp_path: Path) -> None:
    """Of three small keys one that is a day off would make 2.6 million frames; one that is an hour off is said."""

    def scene(last: float) -> bytes:
        made = Scene()
        made.node(name="a")
        times = made.accessor([0.0, 0.5, last])
        made.animation("x", [(0, "translation", times, made.accessor(np.arange(9.0).reshape(3, 3)), "LINEAR")])
        return made.glb()

    words = (
        r"'x' lasts 86400 s, and no key lies between 0\.5 and 86400 s: 2073601 frames would be made of keys at 3 times"
    )
    with pytest.raises(FormatError, match=words):
        gltf.read(tmp_path / "a.glb", scene(86400.0), ReadOptions())
    with pytest.warns(FormatWarning, match="86401 frames, and no key"):
        slow = gltf.read(tmp_path / "a.glb", scene(86400.0), ReadOptions(rate=Fraction(1)))
    assert slow.n_frames == 86_401
    with pytest.warns(FormatWarning, match=r"'x' lasts 3600 s, 86401 frames, and no key lies between 0\.5 and 3600 s"):
        clip = gltf.read(tmp_path / "a.glb", scene(3600.0), ReadOptions())
    assert clip.n_frames == 86_401
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert gltf.read(tmp_path / "a.glb", scene(60.0), ReadOptions()).n_frames == 1441


def test_a_motion_is_written_as_a_skeleton_that_reads_back(tmp_path: Path) -> None:
    clip = retime.sample()[:40]
    for up in ("y", "z"):
        path = tmp_path / f"{up}.glb"
        retime.write(replace(clip, up=up, metres_per_unit=0.01), path)
        found = retime.read(path)
        assert isinstance(found, Motion)
        joints = [found.skeleton.names.index(name) for name in clip.skeleton.names]
        wanted = global_poses(replace(clip, up=up))
        poses = global_poses(found)
        np.testing.assert_allclose(poses.positions[:, joints], wanted.positions * 0.01, atol=2e-6)
        assert (found.rate, found.n_frames, found.name) == (clip.rate, 40, clip.name)


def test_a_scene_in_text_says_what_the_binary_one_says(tmp_path: Path) -> None:
    clip = retime.sample()[:20]
    for ending in ("glb", "gltf"):
        retime.write(clip, tmp_path / f"a.{ending}")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.glb", "a.gltf"]
    binary, text = Literal(tmp_path / "a.glb"), Literal(tmp_path / "a.gltf")
    assert {**text.json, "buffers": []} == {**binary.json, "buffers": []}
    assert text.buffers[0] == binary.buffers[0][: len(text.buffers[0])]
    found = [retime.read(tmp_path / f"a.{ending}") for ending in ("glb", "gltf")]
    assert np.array_equal(found[0].rotations, found[1].rotations)


def test_what_a_scene_names_beside_itself_goes_with_it(tmp_path: Path) -> None:
    scene = drawn_scene(7)
    document = json.loads(scene.gltf())
    (tmp_path / "in").mkdir()
    (tmp_path / "out").mkdir()
    (tmp_path / "in" / "a b.bin").write_bytes(bytes(scene.chunk))
    (tmp_path / "in" / "skin.png").write_bytes(b"a picture")
    document["buffers"] = [{"uri": "a%20b.bin", "byteLength": len(scene.chunk)}]
    document["images"] = [{"uri": "skin.png"}]
    path, out = tmp_path / "in" / "a.gltf", tmp_path / "out" / "new take.gltf"
    path.write_text(json.dumps(document))
    retime_file(path, out, Warp([0.0, 4.0], [0.0, 2.0]))
    assert (tmp_path / "out" / "a b.bin").read_bytes() == bytes(scene.chunk)
    assert (tmp_path / "out" / "skin.png").read_bytes() == b"a picture"
    assert (tmp_path / "out" / "new take_animation.bin").is_file()
    found = gltf.read(out, out.read_bytes(), ReadOptions(rate=30))
    wanted = gltf.read(path, path.read_bytes(), ReadOptions(rate=30))
    assert isinstance(found, Motion)
    assert isinstance(wanted, Motion)
    np.testing.assert_allclose(found.local_translations[60], wanted.local_translations[30], atol=1e-5)
    with pytest.raises(OutputExistsError):
        retime_file(path, out, Warp([0.0, 4.0], [0.0, 2.0]))


@needs_captures
@pytest.mark.parametrize(
    "name", ["Fox.glb", "CesiumMan.glb", "cubicspline_cube.glb", "AnimatedMorphCube/AnimatedMorphCube.gltf"]
)
def test_real_scenes_are_retimed_in_place(name: str, tmp_path: Path) -> None:
    path = GLTF / name
    place = tmp_path / path.name
    for one in path.parent.glob("*.bin"):
        (tmp_path / one.name).write_bytes(one.read_bytes())
    names = gltf.animation_names(path, path.read_bytes(), ReadOptions())
    before = Literal(path)
    warps, starts = {}, []
    for one in names:
        end = gltf.read(path, path.read_bytes(), ReadOptions(animation=one)).end_time
        warps[one] = Warp([0.0, 0.3 * end, 0.4 * end, 0.6 * end, 0.9 * end], [0, 0.6 * end, 0.6 * end, 0.2 * end, end])
    after = Literal(retimed(path, warps, place))
    for index, one in enumerate(names):
        samplers = before.json["animations"][index]["samplers"]
        starts.append(min(before.accessor(sampler["input"])[0][0] for sampler in samplers))
        assert worst_error(before, after, index, warps[one], starts[-1]) < 1e-6
    for kind in ("meshes", "nodes", "skins", "materials", "images"):
        assert before.json.get(kind) == after.json.get(kind)


THREE = Path(__file__).parents[4] / "web" / "node_modules" / "three"


@needs_captures
@pytest.mark.skipif(shutil.which("node") is None or not THREE.is_dir(), reason="the page's three.js is not installed")
@pytest.mark.parametrize("name", ["Fox.glb", "CesiumMan.glb", "cubicspline_cube.glb"])
def test_another_program_finds_the_same_values_at_the_warps_times(name: str, tmp_path: Path) -> None:
    path = GLTF / name
    warps = {}
    for one in gltf.animation_names(path, path.read_bytes(), ReadOptions()):
        end = gltf.read(path, path.read_bytes(), ReadOptions(animation=one)).end_time
        warps[one] = Warp([0.0, 0.3 * end, 0.4 * end, 0.6 * end, 0.9 * end], [0, 0.6 * end, 0.6 * end, 0.2 * end, end])
    out = retimed(path, warps, tmp_path / name)
    asked = {"before": str(path), "after": str(out), "three": str(THREE)}
    asked["warps"] = [[warp.output_times.tolist(), warp.input_times.tolist()] for warp in warps.values()]
    script = Path(__file__).with_name("evaluate.mjs")
    run = subprocess.run(["node", str(script)], input=json.dumps(asked), capture_output=True, text=True, check=True)
    for found in json.loads(run.stdout):
        assert found["tracks"] > 0
        assert found["relative"] < 1e-6
        assert found["degrees"] < 1e-3


def test_a_rotation_is_unit_where_it_was(tmp_path: Path) -> None:
    scene = Scene()
    scene.node(name="a")
    quaternions = unit_rows(np.random.default_rng(0), 8)
    scene.animation("x", [(0, "rotation", scene.accessor(np.arange(8.0)), scene.accessor(quaternions), "LINEAR")])
    path = tmp_path / "a.glb"
    path.write_bytes(scene.glb())
    out = Literal(retimed(path, Warp(np.arange(15.0), np.arange(15.0) / 2 + 0.01), tmp_path / "b.glb"))
    rows = np.array(out.accessor(out.json["animations"][0]["samplers"][0]["output"]))
    np.testing.assert_allclose(np.linalg.norm(rows, axis=1), 1, atol=1e-6)


@pytest.mark.parametrize("late", [0.0, 60.0, 3600.0, 40000.0])
def test_late_keys_are_off_by_the_rounding_of_their_times_alone(tmp_path: Path, late: float) -> None:
    """Times are single precision: what moves at a unit a second is off by half of the last place, as docs say."""
    scene = Scene()
    scene.node(name="a")
    times = (late + np.arange(31) / 30).astype(np.float32).astype(np.float64)
    rng = np.random.default_rng(3)
    # From key to key it moves by a unit a second, up and down.
    values = np.cumsum(np.append(0.0, np.diff(times) * rng.choice([-1.0, 1.0], 30)))
    keyed = np.stack([values, values, values], axis=1)
    scene.animation("x", [(0, "translation", scene.accessor(times), scene.accessor(keyed), "LINEAR")])
    (tmp_path / "a.glb").write_bytes(scene.glb())
    warp = Warp([0.0, 0.4, 0.75], [0.0, 0.3, 1.0])
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        out = Literal(retimed(tmp_path / "a.glb", warp, tmp_path / "b.glb"))
    told = [str(one.message) for one in said if "single precision" in str(one.message)]
    # Of a frame at 30 Hz half of the last place at 40,000 s is 0.06; at the rate of 60, where no grid is seen, 0.12.
    assert bool(told) == (late == 40000.0)
    sampler = out.json["animations"][0]["samplers"][0]
    at = np.array(out.accessor(sampler["input"]))[:, 0]
    x = np.array(out.accessor(sampler["output"]))[:, 0]
    # Twice as fast at most as the input, so twice as far off; values are single precision themselves.
    off = np.spacing(np.float32(late + 1.0)) / 2
    moments = np.linspace(0.0, 0.75, 2001)
    wanted = np.interp(warp(moments) + times[0], times, values)
    found = np.interp(moments + times[0], at, x)
    fastest = (1.0 - 0.3) / 0.35
    assert np.abs(found - wanted).max() <= fastest * off + 1e-6
    assert np.abs(at[[0, -1]] - (times[0] + np.array([0.0, 0.75]))).max() <= off


def test_rotations_of_8_bits_gain_no_error_of_their_own(tmp_path: Path) -> None:
    """No program shows them further off than programs differ on the file as it was."""
    turns = np.cumsum(np.random.default_rng(1).normal(size=(20, 3)) * 0.4, axis=0)
    angle = np.linalg.norm(turns, axis=1)[:, None]
    rows = np.concatenate([turns / angle * np.sin(angle / 2), np.cos(angle / 2)], axis=1)
    warp = Warp([0.0, 0.37, 0.9, 1.33, 2.2], [0.0, 0.25, 0.95, 1.2, 1.9])
    moments = np.linspace(0.0, 2.2, 4001)
    most = {"i1": (0.05, 0.003), "i2": (3e-4, 3e-4)}
    for kind, (unit_first, as_they_are) in most.items():
        scene = Scene()
        scene.node(name="a")
        held = scene.accessor(rows, kind, normalized=True)
        scene.animation("x", [(0, "rotation", scene.accessor(np.arange(20) / 10), held, "LINEAR")])
        (tmp_path / f"{kind}.glb").write_bytes(scene.glb())
        curves = []
        for path in (tmp_path / f"{kind}.glb", retimed(tmp_path / f"{kind}.glb", warp, tmp_path / f"{kind}_out.glb")):
            one = Literal(path)
            sampler = one.json["animations"][0]["samplers"][0]
            curves.append([np.array(one.accessor(sampler[name])) for name in ("input", "output")])
        (before, after), apart = curves, {}
        for first in (True, False):
            apart[first] = degrees_apart(
                slerped(*before, warp(moments), unit=first), slerped(*after, moments, unit=first)
            )
        differ = degrees_apart(slerped(*before, warp(moments), unit=True), slerped(*before, warp(moments), unit=False))
        assert apart[True] <= min(unit_first, differ)
        assert apart[False] <= min(as_they_are, differ)
        assert differ < (0.09 if kind == "i1" else 4e-4)


def slerped(times: np.ndarray, rows: np.ndarray, at: np.ndarray, *, unit: bool) -> np.ndarray:
    """Go from key to key as glTF has it, of rotations made unit before or not; unit in the end."""
    keys = times[:, 0]
    i = np.clip(np.searchsorted(keys, at, side="right") - 1, 0, len(keys) - 2)
    share = np.clip((at - keys[i]) / (keys[i + 1] - keys[i]), 0, 1)[:, None]
    a, b = (rows / np.linalg.norm(rows, axis=1)[:, None] if unit else rows)[np.stack([i, i + 1])]
    cosine = np.sum(a * b, axis=1)[:, None]
    angle = np.arccos(np.clip(np.abs(cosine), 0, 1))
    with np.errstate(invalid="ignore", divide="ignore"):
        arc = (np.sin((1 - share) * angle) * a + np.sign(cosine) * np.sin(share * angle) * b) / np.sin(angle)
    shown = np.where(angle > 1e-9, arc, a + share * (np.sign(cosine) * b - a))
    return shown / np.linalg.norm(shown, axis=1)[:, None]


def degrees_apart(a: np.ndarray, b: np.ndarray) -> float:
    apart = np.minimum(np.linalg.norm(a - b, axis=1), np.linalg.norm(a + b, axis=1))
    return float(np.degrees(4 * np.arcsin(apart / 2)).max())
