"""What was written for a host, read by programs that have nothing to do with retime."""

from __future__ import annotations

import json
import os
import subprocess
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime import export_curve
from retime.hosts.fcpxml import read as read_fcpxml
from retime.hosts.shot import Shot
from retime.warp.curve import Warp
from tests.hosts.material import RATES, drawn_warp, frame_times

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.extras
_FRAMES = 0.001 + 1e-7


@pytest.mark.parametrize("rate", RATES, ids=str)
def test_opentimelineio_shows_the_input_frame_of_each_output_frame(tmp_path, rate) -> None:
    otio = pytest.importorskip("opentimelineio", reason="needs the peers of make extras")
    for seed in range(8):
        warp = drawn_warp(seed, forward=seed % 2 == 0)
        place = tmp_path / f"{seed}.otio"
        export_curve(warp, place, "otio", rate=rate, item="walk.mov", start=100)
        track = otio.adapters.read_from_file(str(place)).video_tracks()[0]
        at = frame_times(warp, rate)
        assert track.duration().value == len(at)
        shown = []
        for frame in range(len(at)):
            clip = track.child_at_time(otio.opentime.RationalTime(frame, float(rate)))
            begun = clip.range_in_parent().start_time
            assert clip.media_reference.target_url == "walk.mov"
            (effect,) = clip.effects
            assert isinstance(effect, otio.schema.FreezeFrame) == (effect.time_scalar == 0)
            source = clip.source_range.start_time.value + effect.time_scalar * (frame - begun.value)
            shown.append((source - 100) / float(rate))
            assert clip.available_range().start_time.value == 100
        assert np.abs(np.array(shown) - warp(at)).max() <= _FRAMES


@pytest.mark.parametrize("rate", RATES, ids=str)
def test_lottie_remaps_to_the_second_of_each_frame(tmp_path, rate) -> None:
    pytest.importorskip("lottie", reason="needs the peers of make extras")
    from lottie.parsers.tgs import parse_tgs

    for seed in range(8):
        warp = drawn_warp(seed, forward=seed % 2 == 0)
        place = tmp_path / f"{seed}.json"
        export_curve(warp, place, "lottie", rate=rate, item="walk")
        animation = parse_tgs(str(place))
        assert animation.frame_rate == float(rate)
        (layer,) = animation.layers
        assert layer.reference_id == "walk"
        at = frame_times(warp, rate)
        shown = [layer.time_remapping.get_value(frame) for frame in at * float(rate)]
        # The library solves the handles' cubic by halving.
        assert np.abs(np.ravel(shown) - warp(at)).max() <= _FRAMES + 1e-3


@pytest.mark.parametrize("rate", RATES, ids=str)
def test_usd_evaluates_the_clip_at_the_warped_time_of_each_frame(tmp_path, rate) -> None:
    pytest.importorskip("pxr", reason="needs the peers of make extras")
    from pxr import Sdf, Usd, UsdGeom

    source = Usd.Stage.CreateNew(str(tmp_path / "walk.usda"))
    source.SetTimeCodesPerSecond(float(rate))
    prim = UsdGeom.Xform.Define(source, "/World/Char").GetPrim()
    clock = prim.CreateAttribute("clock", Sdf.ValueTypeNames.Double)
    for frame in (-1000.0, 10_000.0):
        clock.Set(frame, frame)
    source.Save()
    for seed in range(8):
        warp = drawn_warp(seed, forward=seed % 2 == 0)
        place = tmp_path / f"{seed}.usda"
        export_curve(warp, place, "usd-clips", rate=rate, item="walk.usda</World/Char>", start=seed)
        stage = Usd.Stage.Open(str(place))
        assert stage.GetTimeCodesPerSecond() == pytest.approx(float(rate), abs=1e-9)
        retimed = stage.GetDefaultPrim()
        assert retimed.GetTypeName() == "Xform"
        at = frame_times(warp, rate)
        shown = [retimed.GetAttribute("clock").Get(seed + frame) - seed for frame in at * float(rate)]
        assert np.abs(np.array(shown) / float(rate) - warp(at)).max() <= _FRAMES
        stage.GetRootLayer().Clear()


@pytest.mark.parametrize("rate", RATES, ids=str)
def test_ffmpeg_shows_the_frames_that_are_due(tmp_path, rate) -> None:
    av = pytest.importorskip("av", reason="needs the peers of make extras")
    for seed in range(6):
        warp = drawn_warp(2 * seed, forward=True)
        place = tmp_path / f"{seed}.txt"
        export_curve(warp, place, "ffmpeg", rate=rate)
        shown = ffmpeg_frames(av, place.read_text(), rate, int(np.ceil(warp.input_times[-1] * float(rate))) + 5)
        at = frame_times(warp, rate)
        assert len(shown) == len(at)
        # The whole frame that is nearest to what the curve says.
        off = np.array(shown) - warp(at) * float(rate)
        assert np.abs(off).max() <= 0.5 + _FRAMES * float(rate) + 1e-3


def ffmpeg_frames(av, chain: str, rate: Fraction, n_input: int) -> list[int]:
    """Send numbered frames through a chain of filters; return the number of each that comes out."""
    graph = av.filter.Graph()
    base = f"{rate.denominator}/{rate.numerator}"
    source = graph.add("buffer", f"video_size=16x16:pix_fmt=gray:time_base={base}:frame_rate={rate}")
    last = source
    for part in _split(chain.strip()):
        name, _, arguments = part.partition("=")
        node = graph.add(name, arguments)
        last.link_to(node)
        last = node
    sink = graph.add("buffersink")
    last.link_to(sink)
    graph.configure()
    shown = []

    def pull() -> None:
        while True:
            try:
                got = graph.pull()
            except (av.error.BlockingIOError, av.error.EOFError):
                return
            pixels = got.to_ndarray()
            shown.append(int(pixels[0, 0]) * 256 + int(pixels[0, 8]))

    for number in range(n_input):
        pixels = np.zeros((16, 16), dtype=np.uint8)
        pixels[:, :8], pixels[:, 8:] = divmod(number, 256)
        frame = av.VideoFrame.from_ndarray(pixels, format="gray")
        frame.pts, frame.time_base = number, 1 / rate
        try:
            graph.push(frame)
        except av.error.EOFError:
            # What comes after the warp's end is not taken.
            break
        pull()
    else:
        graph.push(None)
    pull()
    return shown


def _split(chain: str) -> list[str]:
    """Part a chain at commas that stand in no quotes."""
    parts, quoted = [""], False
    for letter in chain:
        quoted ^= letter == "'"
        if letter == "," and not quoted:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


def test_fcpxml_is_what_the_type_definition_says(tmp_path) -> None:
    etree = pytest.importorskip("lxml.etree", reason="needs the peers of make extras")
    definition = etree.DTD(str(Path(__file__).with_name("fcpxml_subset.dtd")))
    for seed, rate in enumerate(RATES):
        warp = drawn_warp(seed, forward=False)
        place = tmp_path / f"{seed}.fcpxml"
        export_curve(warp, place, "fcpxml", rate=rate, item='/shots/a & b "c".mov')
        tree = etree.parse(str(place))
        assert definition.validate(tree), definition.error_log
        clip = tree.find(".//asset-clip")
        # All places and lengths in the timeline stand on frames.
        for name in ("offset", "start", "duration"):
            value = Fraction(clip.get(name).rstrip("s")) * rate
            assert value.denominator == 1
        # The map ends with the clip, once its last frame has been shown; that is no part of the warp.
        points = tree.findall(".//timept")
        ends = [Fraction(clip.get(name).rstrip("s")) for name in ("start", "duration")]
        assert Fraction(points[-1].get("time").rstrip("s")) == sum(ends)
        assert points[-1].get("value") == points[-2].get("value")
        assert len(points) - 1 == len(read_fcpxml(place.read_bytes(), Shot()).output_times)
        broken = etree.fromstring(place.read_bytes().replace(b' interp="linear"', b' interp="lines"', 1))
        assert not definition.validate(broken)


_BLENDER = """
import json, sys
import bpy
told = json.loads(sys.argv[sys.argv.index("--") + 1])
scene = bpy.context.scene
scene.render.fps, scene.render.fps_base = told["fps"], told["base"]
thing = bpy.data.objects.new("clock", None)
scene.collection.objects.link(thing)
action = bpy.data.actions.new("clock")
thing.animation_data_create().action = action
last = told["last"]
for frame in (told["start"], last):
    thing.location.x = frame
    thing.keyframe_insert("location", index=0, frame=frame)
for layer in action.layers:
    for strip in layer.strips:
        for bag in strip.channelbags:
            for curve in bag.fcurves:
                for key in curve.keyframe_points:
                    key.interpolation = "LINEAR"
track = thing.animation_data.nla_tracks.new()
slot = thing.animation_data.action_slot
thing.animation_data.action = None
strip = track.strips.new("clock", told["start"], action)
strip.action_slot = slot
strip.use_animated_time = True
strip.frame_end_ui = told["at"][-1] + 10
for at, shows in zip(told["at"], told["shows"]):
    strip.strip_time = shows
    strip.keyframe_insert("strip_time", frame=at)
curve = strip.fcurves.find("strip_time")
for key in curve.keyframe_points:
    key.interpolation = "LINEAR"
found = []
for frame in told["frames"]:
    scene.frame_set(int(frame))
    found.append(thing.matrix_world.translation.x)
print("FOUND" + json.dumps(found))
"""


def test_blender_plays_a_framecurve_as_strip_time(tmp_path) -> None:
    # What docs/hosts.md tells to do: the rows as linear keys of an NLA strip's animated time.
    blender = Path(os.environ.get("RETIME_TEST_BPY", ROOT / ".venv" / "blender-4.5" / "bin" / "python"))
    if not blender.is_file():
        pytest.skip("needs Blender as a module: make blender, or RETIME_TEST_BPY=/path/to/python")
    warp = Warp([0.0, 1.0, 2.0, 3.0, 3.5], [0.0, 2.0, 2.0, 1.0, 1.2])
    export_curve(warp, tmp_path / "a.txt", "framecurve", rate=24, start=1)
    rows = np.loadtxt(tmp_path / "a.txt")
    frames = list(range(1, 86))
    told = {
        "fps": 24,
        "base": 1.0,
        "start": 1,
        "last": 100,
        "at": rows[:, 0].tolist(),
        "shows": rows[:, 1].tolist(),
        "frames": frames,
    }
    script = tmp_path / "play.py"
    script.write_text(_BLENDER)
    done = subprocess.run(
        [str(blender), str(script), "--", json.dumps(told)],
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
        env={**os.environ, "HOME": str(tmp_path)},
    )
    found = json.loads(done.stdout.split("FOUND")[1].splitlines()[0])
    shows = warp((np.array(frames) - 1) / 24) * 24 + 1
    assert np.abs(np.array(found) - shows).max() < 1e-3
