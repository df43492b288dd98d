"""The editor in a real browser: web/test/browser.mjs drives it, the command line has the last word.

Needs node, the page's npm packages, the built page and Chromium; skips, saying so, where one of them is missing.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import wave
from fractions import Fraction
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import retime
from retime.media.beats import read_beats
from retime.project.document import BeatsFile, InfluencePoint, MediaFile
from retime.project.file import read_project
from retime.project.solve import DocumentSolver
from retime.search.options import OPTIONS
from tests.cli.figures import figure
from tests.server.serving import serving  # noqa: F401  (says that this needs the packages that serve)

ROOT = Path(__file__).resolve().parents[2]
WEB = ROOT / "web"
PAGE = ROOT / "src" / "retime" / "server" / "page" / "index.html"
DATA = ROOT.parent / "shared" / "mocap"
# Of an option's declaration, what the page shows as it stands there.
SHOWN = ("label", "hint", "panel", "kind", "default", "slider", "curve", "needs_free")
CHROMIUM = ("/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome")


def _missing() -> str | None:
    if shutil.which("node") is None:
        return "needs node"
    if not (WEB / "node_modules" / "playwright-core").is_dir():
        return "needs the page's npm packages (make page)"
    if not PAGE.is_file():
        return "needs the page (make page)"
    if not any(Path(path).exists() for path in CHROMIUM):
        return "needs Chromium"
    return None


pytestmark = pytest.mark.skipif(_missing() is not None, reason=str(_missing()))


def drive(script: str, timeout: int, **settings: object) -> dict[str, object]:
    """Run one of the page's browser scripts; it prints what it found."""
    done = subprocess.run(
        ["node", str(WEB / "test" / script), json.dumps({"python": sys.executable, "options": [], **settings})],
        capture_output=True,
        text=True,
        timeout=timeout,
        cwd=WEB,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found: dict[str, object] = json.loads(done.stdout.splitlines()[-1])
    return found


@pytest.fixture
def rooms(tmp_path: Path) -> dict[str, str]:
    """Give folders for files, for the server's state, and for pictures of the page."""
    names = {name: tmp_path / name for name in ("folder", "state", "shots")}
    if "RETIME_SHOTS" in os.environ:
        names["shots"] = Path(os.environ["RETIME_SHOTS"])
    for folder in names.values():
        folder.mkdir(exist_ok=True, parents=True)
    return {name: str(folder) for name, folder in names.items()}


def test_edit_undo_die_recover_save_export(rooms, run):
    folder = Path(rooms["folder"])
    captured = [DATA / "cmu-asfamc" / name for name in ("86.asf", "86_01.amc")]
    if all(file.is_file() for file in captured):
        for file in captured:
            shutil.copy(file, folder)
        clip = folder / "86_01.amc"
    else:
        clip = folder / "sample.bvh"
        retime.write(retime.sample(), clip)

    retime.write(retime.sample(), folder / "other.bvh")
    found = drive("browser.mjs", 240, clip=str(clip), **rooms)

    # What was dragged in the page is in the project file, digit for digit; the command line makes the same of it.
    document = json.loads(Path(str(found["project"])).read_text(encoding="utf-8"))["document"]
    (key,) = document["keys"]
    assert f"input {key['input_time']:.3f} s at output {key['output_time']:.3f} s" in str(found["key"])
    assert document["options"] == {"length": "65%"}
    other = folder / f"by_hand{clip.suffix}"
    run(
        "warp", str(clip), "--length", "65%", "--key", f"{key['input_time']!r}={key['output_time']!r}", "-o", str(other)
    )
    assert Path(str(found["exported"])).read_bytes() == other.read_bytes()
    warp = folder / "by_hand.json"
    run(
        "warp",
        str(clip),
        "--length",
        "65%",
        "--key",
        f"{key['input_time']!r}={key['output_time']!r}",
        "--save",
        str(warp),
    )
    told = ("--host", "nuke", "--rate", "24", "--start", "1001", "--item", "Shot12")
    run("export", str(warp), "-o", str(folder / "by_hand.nk"), *told)
    assert Path(str(found["curve"])).read_bytes() == (folder / "by_hand.nk").read_bytes()
    assert len(list(Path(rooms["shots"]).glob("*.png"))) >= 10


def test_groups_references_channels_and_bounds(rooms):
    folder, elsewhere = Path(rooms["folder"]), Path(rooms["folder"]).parent / "elsewhere"
    elsewhere.mkdir()
    first = figure()
    made = {"first": first, "second": figure("second", swing=0.9)}
    made |= {
        "like_first": figure("like first", swing=0.4, seconds=3.0),
        "like_second": figure("like second", seconds=3.0),
    }
    for name, motion in made.items():
        retime.write(motion, folder / f"{name}.bvh")
    retime.write(first, elsewhere / "away.bvh")
    t = np.arange(121) / 30
    wide = retime.Signal(
        tuple(f"c{i}" for i in range(20)), np.stack([np.sin((1 + i / 7) * t) for i in range(20)], axis=1), Fraction(30)
    )
    retime.write(wide, folder / "wide.csv")
    value = {"format": "retime-project", "version": 2, "document": {"clips": [{"path": str(elsewhere / "away.bvh")}]}}
    (folder / "away.retime").write_text(json.dumps(value))

    found = drive(
        "fields.mjs",
        120,
        clips=["first.bvh", "second.bvh"],
        wide="wide.csv",
        counterpart="like_second.bvh",
        project="away.retime",
        elsewhere=str(elsewhere),
        options=[
            {
                **{name: getattr(option, name) for name in SHOWN},
                "usual": option.default_words,
                "in_short": option.in_short or option.default_words,
                "flag": option.on_command_line,
                "choices": [(choice.value, choice.label) for choice in option.choices],
                "least": option.least if np.isfinite(option.least) else None,
                "most": option.most if np.isfinite(option.most) else None,
            }
            for option in OPTIONS
        ],
        **rooms,
    )
    document = read_project(str(found["saved"])).document
    assert document.options == {"length": "75%", "rate": "20", "n_neighbors": 2}
    (reference,) = document.references
    assert [one.clip for one in reference.counterparts] == [1]
    # What the page made is what the library makes of the same clips.
    clips, likes = (
        [retime.read(folder / f"{name}.bvh") for name in names]
        for names in (("first", "second"), ("like_first", "like_second"))
    )
    n_frames = round(1.5 * float(likes[0].rate)) + 1
    expected = retime.guided_warp(
        clips,
        reference=retime.Reference([like.frames(0, n_frames) for like in likes]),
        length="75%",
        rate="20",
        n_neighbors=2,
    )
    np.testing.assert_array_equal(retime.read_warp(str(found["warp"])).input_times, expected.warp.input_times)


def test_curve_follows_the_hand(rooms, record_property):
    """Report how long a dragged key's curve takes to be on the screen, at V1's size; the machine decides how long."""
    clip = DATA / "cmu-bvh" / "05_18.bvh"
    if not clip.is_file():
        clip = Path(rooms["folder"]) / "sample.bvh"
        retime.write(retime.sample(), clip)
    found = drive(
        "latency.mjs", 180, clip=str(clip), length="57%", moves=45, folder=rooms["folder"], state=rooms["state"]
    )
    for pace in ("30", "60"):
        measured = found[pace]
        assert isinstance(measured, dict)
        assert measured["moves"] >= 40
        record_property(f"key moved to curve on screen, {pace} moves a second", json.dumps(measured))
    print(json.dumps(found))


def test_flights_are_put_right_a_reference_is_kept_step_with_and_an_example_carried_over(rooms):
    folder = Path(rooms["folder"])
    clip = retime.sample()
    retime.write(clip, folder / "sample.bvh")
    retime.write(clip.frames(60, 500), folder / "other.bvh")
    made = drive("ground.mjs", 240, clip=str(folder / "sample.bvh"), reference="other.bvh", **rooms)
    clip, other = (retime.read(folder / name) for name in ("sample.bvh", "other.bvh"))
    found = {
        name: (read_project(Path(paths["project"])).document, retime.Warp.load(paths["warp"]))
        for name, paths in made.items()
    }

    # What the page made is what the library makes of the same words, digit for digit.
    document, warp = found["flights"]
    flown = [(mark.start, mark.end) for mark in document.flights if mark.flies]
    (denied,) = [(mark.start, mark.end) for mark in document.flights if not mark.flies]
    first, second = [(first / 60, last / 60) for first, last in clip.flights()]
    assert denied == second
    assert sorted(flown)[-1] == (first[0], pytest.approx(first[1] - 10 / 60))
    expected = retime.guided_warp(clip, length="60%", flights=flown).warp
    np.testing.assert_array_equal(warp.input_times, expected.input_times)
    assert not np.array_equal(warp.input_times, retime.guided_warp(clip, length="60%").warp.input_times)

    document, warp = found["align"]
    assert (document.method, document.repeat, document.options) == ("align", 1.5, {"length": "60%"})
    with pytest.warns(retime.RetimeWarning, match="does not end as it begins"):
        expected = retime.align(clip, other, repeat=1.5).warp
    np.testing.assert_array_equal(warp.input_times, expected.input_times)

    document, warp = found["propagate"]
    assert document.example is not None
    assert (document.example.start, document.example.end) == (2.0, 3.4)
    keys = [(key.input_time, key.output_time) for key in document.keys]
    whole = retime.guided_warp(clip, keys=keys, flights=flown).warp
    outputs = np.interp([2.0, 3.4], whole.input_times, whole.output_times)
    inside = whole.output_times[(whole.output_times > outputs[0]) & (whole.output_times < outputs[1])]
    times = np.concatenate([outputs[:1], inside, outputs[1:]])
    hand = retime.Warp(times - times[0], whole(times) - 2.0)
    with pytest.warns(retime.RetimeWarning, match="the example says little"):
        # The keytime after the example holds in the result, too.
        expected = retime.imitate(clip, (120, 205), hand, keys=keys[1:]).warp
    np.testing.assert_allclose(warp.input_times, expected.input_times, atol=1e-9)
    assert len(list(Path(rooms["shots"]).glob("*_dark.png"))) >= 4


def _make_media(folder: Path, *, picture: bool) -> dict[str, object]:
    """Make a clip, 4 s of media that click each half second, beats, and files that are no media."""
    retime.write(retime.sample().frames(0, 241), folder / "walk.bvh")
    rate, name = 48_000, "take.wav"
    samples = np.zeros(4 * rate)
    click = 0.9 * np.sin(2 * np.pi * 1000 * np.arange(1200) / rate) * np.exp(-np.arange(1200) / 300)
    for start in np.arange(0.25, 4, 0.5):
        samples[round(start * rate) :][: len(click)] += click
    if picture:
        from tests.media.clips import write_clip

        name = "take.webm"
        write_clip(
            folder / name,
            120,
            codec="libvpx-vp9",
            sound_codec="libopus",
            samples=np.tile(samples, (2, 1)).astype(np.float32),
            size=(320, 192),
        )
    else:
        with wave.open(str(folder / name), "wb") as file:
            file.setnchannels(1)
            file.setsampwidth(2)
            file.setframerate(rate)
            file.writeframes((32_000 * samples).astype("<i2").tobytes())
    (folder / "beats.csv").write_text("time,strength\n0.303,1\n0.803,0.4\n1.303,1\n1.803,0.4\n2.303,1\n")
    (folder / "list.mp4").write_text("#EXTM3U\nsecret.mp4\n")
    (folder / "nothing.wav").write_bytes(b"RIFF\x04\0\0\0WAVE")
    return {"clip": "walk.bvh", "media": name, "beats": "beats.csv", "picture": picture}


def test_a_sound_goes_with_the_warp_and_keytimes_land_on_beats(rooms):
    if find_spec("av") is not None:
        pytest.skip("tests/server/test_browser.py has another test for where the extra video is installed")
    made = _make_media(Path(rooms["folder"]), picture=False)
    found = drive("media.mjs", 240, extras=False, **made, **rooms)
    document = read_project(str(found["project"])).document
    assert document.media == MediaFile(str(Path(rooms["folder"]) / "take.wav"), "0.25", "input")
    assert document.beats == BeatsFile(None, "onsets")


@pytest.mark.extras
def test_a_video_goes_with_the_warp_and_the_stage_is_filmed_frame_by_frame(rooms):
    av = pytest.importorskip("av", reason="needs PyAV (make extras)")
    pytest.importorskip("librosa", reason="needs librosa (make extras)")
    made = _make_media(Path(rooms["folder"]), picture=True)
    found = drive("media.mjs", 300, extras=True, **made, **rooms)
    # What the page says of the sound is what the command line hears in it.
    onsets = read_beats(Path(rooms["folder"]) / "take.webm", on="onsets")
    assert found["heard"] == f"{len(onsets)} beats found"
    # Of each moment the frame that is on then.
    for number, time in found["frames"]:
        assert number == int(time * 30)
    with av.open(found["film"]) as film:
        shown = [frame.to_ndarray(format="gray") for frame in film.decode(video=0)]
        assert film.streams.video[0].average_rate == 12
    # What the take clicks at is heard when the warp comes to it, a quarter of a second late as it was said to begin.
    clip = retime.sample().frames(0, 241)
    warp = retime.guided_warp(clip, length="60%").warp
    from tests.media.clips import clicks_in, read_sound

    heard, rate = read_sound(Path(found["film"]))
    assert heard.shape[1] / rate == pytest.approx(len(shown) / 12, abs=0.03)
    clicks = np.arange(0.25, 4, 0.5) + 0.25
    times = np.interp(clicks[clicks < warp.input_times[-1]], warp.input_times, warp.output_times)
    # Opus smears a beginning by some samples.
    np.testing.assert_allclose(clicks_in(heard[0], rate, least=0.3), times[: len(times)], atol=0.004)
    document = read_project(str(found["project"])).document
    assert len(shown) == int((0.6 * 241 - 1) / 60 * 12 + 1e-6) + 1
    assert {picture.shape for picture in shown} == {(360, 640)}
    # It moves, on both sides.
    for half in (slice(0, 320), slice(320, 640)):
        assert all(np.abs(a[:, half].astype(int) - b[:, half]).max() > 40 for a, b in pairwise(shown))
    assert document.media == MediaFile(str(Path(rooms["folder"]) / "take.webm"), "0.25", "input")


def test_a_group_is_aligned_seen_through_its_camera_and_written_at_once(rooms):
    folder = Path(rooms["folder"])
    first, second = figure("first"), figure("second", swing=0.9, seconds=3.0)
    retime.write(first, folder / "first.bvh")
    retime.write(second, folder / "second.bvh")
    t = np.arange(121) / 30
    turn = np.radians(20 + 50 * t / 4)
    columns = [4.5 * np.sin(turn), 1.4 + 0 * t, 4.5 * np.cos(turn), np.degrees(turn), -4 + 0 * t, 0 * t]
    camera = retime.Signal(("tx", "ty", "tz", "pan", "tilt", "roll"), np.stack(columns, axis=1), Fraction(30))
    retime.write(camera, folder / "camera.csv")
    found = drive("group.mjs", 180, clips=["first.bvh", "second.bvh", "camera.csv"], **rooms)
    document = read_project(str(found["project"])).document
    assert [clip.last_frame for clip in document.clips] == [180, None, 90]
    assert [clip.offset for clip in document.clips] == [None, None, None]
    # What the page made is what the library makes of the same words.
    warp = retime.guided_warp(first.frames(0, 181), length="70%").warp
    clips = {"out_first.bvh": first.frames(0, 181), "out_second.bvh": second, "out_camera.csv": camera.frames(0, 91)}
    assert sorted(clips) == sorted(map(str, found["written"]))
    for name, clip in clips.items():
        read, expected = retime.read(folder / name), retime.apply_warp(clip, warp)
        assert read.n_frames == expected.n_frames
        if isinstance(expected, retime.Signal):
            np.testing.assert_allclose(read.values, expected.values, atol=1e-5)
        else:
            np.testing.assert_allclose(read.translations[:, 0], expected.translations[:, 0], atol=1e-5)


def test_a_welcome_menus_shortcuts_and_ways_to_turn_the_stage(rooms):
    retime.write(retime.sample().frames(0, 200), Path(rooms["folder"]) / "earlier.bvh")
    drive("menus.mjs", 180, recent="earlier.bvh", **rooms)


def test_influence_is_painted_limits_are_suggested_and_an_output_leads(rooms):
    clip = retime.sample().frames(0, 420)
    retime.write(clip, Path(rooms["folder"]) / "walk.bvh")
    found = drive("limp.mjs", 240, clip="walk.bvh", **rooms)
    document = read_project(str(found["painted"])).document
    assert document.options == {"length": "60%", "speed": found["speed"]}
    assert document.influence == (InfluencePoint(0, 0), InfluencePoint(2.5, 0.25), InfluencePoint(3, 1))
    keys = [(key.input_time, key.output_time) for key in document.keys]
    expected = retime.guided_warp(
        clip, keys=keys, length="60%", speed=str(found["speed"]), influence=[(0, 0), (2.5, 0.25), (3, 1)]
    ).warp
    solved = DocumentSolver().solve(document)
    np.testing.assert_array_equal(solved.warp.input_times, expected.input_times)
    # What leads is the very output.
    (reference,) = read_project(str(found["led"])).document.references
    led, made = retime.read(str(reference.path)), retime.apply_warp(clip, expected)
    assert led.n_frames == made.n_frames
    np.testing.assert_allclose(led.translations[:, 0], made.translations[:, 0], atol=1e-4)
