"""Clips of a known answer, retimed through files."""

from __future__ import annotations

import warnings
import wave
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatError, OptionError, OutputExistsError, RetimeWarning
from retime.media import apply, options
from retime.media.description import describe_media
from retime.warp.curve import Warp
from tests.media import clips

av = pytest.importorskip("av", reason="needs the extra 'video'")
for package in ("cv2", "python_stretch"):
    pytest.importorskip(package, reason="needs the extra 'video'")

# Warps here need not play all of a clip; what is said of that is tested where it is expected.
pytestmark = [pytest.mark.extras, pytest.mark.filterwarnings("ignore:the warp (uses|reaches)")]
RATE = 30
# Faster, slower, held, backward, at the input's own speed: ends on frames.
TURNS = Warp([0, 1, 2, 2.5, 3, 3.5], [0, 1.9, 1.4, 1.4, 1.0, 1.5])


def shown_by(warp: Warp, rate: float, n_input: int, count: int | None = None) -> np.ndarray:
    """Return literally which frame is nearest at each output frame."""
    count = warp.count_frames(rate) if count is None else count
    times = warp(warp.output_start + np.arange(count) / rate)
    return np.clip(np.floor(times * rate + 0.5 + 1e-6), 0, n_input - 1).astype(int)


@pytest.mark.parametrize(
    ("name", "codec", "gop"),
    [
        ("a.mkv", "ffv1", 1),
        ("a.mp4", "libx264", 12),
        ("a.mov", "libx264", 250),
        ("a.avi", "mpeg4", 12),
        ("a.webm", "libvpx-vp9", 20),
        ("a.ts", "libx264", 12),
    ],
)
def test_each_output_frame_shows_the_nearest_input_frame(tmp_path, name, codec, gop) -> None:
    clip = clips.write_clip(tmp_path / name, codec=codec, gop=gop)
    out = tmp_path / f"out{clip.suffix}"
    with pytest.warns(RetimeWarning, match="left out|runs from"):
        apply.retime_media(clip, out, TURNS, options.MediaOptions(frames="nearest", quality=5))
    numbers, times, frames = clips.read_frames(out)
    assert numbers == shown_by(TURNS, RATE, 60).tolist()
    # A transport stream's clock begins somewhere; those of Matroska and WebM tick in milliseconds.
    times = [time - times[0] for time in times]
    if clip.suffix not in (".mkv", ".webm"):
        assert times == [Fraction(k, RATE) for k in range(len(numbers))]
    assert np.abs(np.array([float(t) for t in times]) - np.arange(len(numbers)) / RATE).max() < 1e-3
    assert frames[0].format.name == "yuv420p"


def test_a_rate_of_television_stays_exact(tmp_path) -> None:
    rate = Fraction(30000, 1001)
    clip = clips.write_clip(tmp_path / "a.mp4", 90, rate=rate, codec="libx264")
    warp = Warp([0, 89 / float(rate) / 2], [0, 89 / float(rate)])
    apply.retime_media(clip, tmp_path / "o.mp4", warp, options.MediaOptions(frames="nearest"))
    _, times, _ = clips.read_frames(tmp_path / "o.mp4")
    assert times == [k / rate for k in range(46)] or times == [k / rate for k in range(45)]
    with av.open(str(tmp_path / "o.mp4")) as container:
        assert container.streams.video[0].average_rate == rate


def test_sound_follows_to_the_millisecond_and_keeps_its_pitch(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 180, samples=clips.sound(6.0))
    knots = np.linspace(0, 5.9, 40)
    warp = Warp(knots * 1.2, knots + 0.25 * np.sin(knots * np.pi / 5.9 * 2), keytimes=[(2.5, 3.0)])
    apply.retime_media(clip, tmp_path / "o.mkv", warp)
    samples, rate = clips.read_sound(tmp_path / "o.mkv")
    assert samples.shape[1] == pytest.approx((warp.count_frames(RATE)) / RATE * rate, abs=rate / RATE)
    given = np.arange(0.25, 5.9, 0.5) + 12 / rate
    wanted = np.interp(given, warp.input_times, warp.output_times)
    found = clips.clicks_in(samples[0], rate)
    assert len(found) == len(wanted)
    assert np.abs(found - wanted).max() < 1e-3
    for start in np.arange(0.5, 6.0, 0.5):
        part = samples[1, round(start * rate) : round((start + 0.5) * rate)]
        assert clips.pitch_of(part, rate) == pytest.approx(440, rel=0.01)


def test_resampled_sound_changes_its_pitch_with_the_speed(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 120, samples=clips.sound(4.0))
    apply.retime_media(clip, tmp_path / "o.mkv", Warp([0, 2], [0, 3.96]), options.MediaOptions(sound="resample"))
    samples, rate = clips.read_sound(tmp_path / "o.mkv")
    assert clips.pitch_of(samples[1, rate // 2 : rate], rate) == pytest.approx(440 * 1.98, rel=0.002)


def test_sound_is_dropped_where_asked(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 30, samples=clips.sound(1.0))
    apply.retime_media(clip, tmp_path / "o.mkv", Warp([0, 1], [0, 29 / 30]), options.MediaOptions(sound="drop"))
    with av.open(str(tmp_path / "o.mkv")) as container:
        assert [stream.type for stream in container.streams] == ["video"]


@pytest.mark.parametrize(("name", "codec"), [("a.wav", "pcm_s16le"), ("a.flac", "flac"), ("a.opus", "libopus")])
def test_sound_alone(tmp_path, name, codec) -> None:
    take = clips.write_sound(tmp_path / name, clips.sound(4.0), codec=codec)
    warp = Warp([0, 1, 5], [0, 2, 3.99])
    apply.retime_media(take, tmp_path / f"o{take.suffix}", warp)
    samples, rate = clips.read_sound(tmp_path / f"o{take.suffix}")
    assert samples.shape[1] == pytest.approx(5 * rate, abs=0.03 * rate)
    found = clips.clicks_in(samples[0], rate, least=0.15)
    wanted = np.interp(np.arange(0.25, 3.9, 0.5) + 12 / 48_000, warp.input_times, warp.output_times)
    assert len(found) == len(wanted)
    assert np.abs(found - wanted).max() < 2e-3


def test_sped_up_frames_are_averages_of_those_that_they_pass(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 61)
    apply.retime_media(clip, tmp_path / "o.mkv", Warp([0, 0.5], [0, 2.0]))
    _, _, frames = clips.read_frames(tmp_path / "o.mkv")
    assert len(frames) == 16
    # Four frames pass in one: the mean of the line through the frames, over a window of four less one.
    pictures = np.array([clips.picture(k) for k in range(61)], float)
    for number in (1, 7, 14):
        centre = 4 * number
        weights = hat_areas(centre - 1.5, centre + 1.5, 61)
        wanted = np.tensordot(weights / weights.sum(), pictures, 1)
        luma = np.frombuffer(frames[number].planes[0], np.uint8).reshape(-1, frames[number].planes[0].line_size)
        scaled = 16 + wanted * 219 / 255
        assert np.abs(luma[: clips.HEIGHT, : clips.WIDTH] - scaled).max() <= 1.5


def hat_areas(low: float, high: float, n: int) -> np.ndarray:
    """Integrate, literally, the hats that stand on frames."""
    steps = np.linspace(low, high, 20_001)
    middle = (steps[1:] + steps[:-1]) / 2
    return np.array([np.maximum(0, 1 - np.abs(middle - k)).mean() for k in range(n)])


def test_in_betweens_by_flow_are_nearer_than_blends(tmp_path) -> None:
    smooth = {"size": (192, 128)}
    clip = clips.write_clip(tmp_path / "a.mkv", 30, **smooth, change=passing_texture)
    every = clips.write_clip(tmp_path / "b.mkv", 59, **smooth, change=lambda n, f: passing_texture(n / 2, f))
    wanted = clips.read_frames(every)[2]
    off = {}
    for mode in ("nearest", "blend", "flow"):
        out = tmp_path / f"{mode}.mkv"
        apply.retime_media(clip, out, Warp([0, 58 / 30], [0, 29 / 30]), options.MediaOptions(frames=mode))
        frames = clips.read_frames(out)[2]
        assert len(frames) == 59
        luma = [
            np.stack([np.frombuffer(f.planes[0], np.uint8).astype(float) for f in some]) for some in (frames, wanted)
        ]
        off[mode] = np.mean((luma[0][11:49:2] - luma[1][11:49:2]) ** 2)
    assert off["flow"] < 0.25 * off["blend"] < off["nearest"]


def passing_texture(number: float, frame):
    """Draw a texture that passes by, six pixels a frame."""
    y, x = np.mgrid[0:128, 0:192].astype(float)
    x = x - 6 * number
    grey = 120 + 40 * np.sin(x / 3.1 + np.sin(y / 9)) * np.cos(y / 4 + np.sin(x / 11)) + 30 * np.sin(x / 17)
    made = av.VideoFrame.from_ndarray(np.clip(grey, 0, 255).astype(np.uint8), format="gray").reformat(format="yuv420p")
    made.pts, made.time_base = frame.pts, frame.time_base
    return made


def test_variable_rate_stays_variable_with_frames_where_they_are_shown(tmp_path) -> None:
    chance = np.random.default_rng(3)
    stamps = np.cumsum(chance.integers(20, 60, 60)).tolist()
    stamps = [stamp - stamps[0] for stamp in stamps]
    clip = clips.write_clip(
        tmp_path / "a.mkv", 60, codec="libx264", stamps=stamps, base=Fraction(1, 1000), options={"bf": "0"}
    )
    end = stamps[-1] / 1000
    apply.retime_media(clip, tmp_path / "o.mkv", Warp([0, 2 * end], [0, end]))
    numbers, times, _ = clips.read_frames(tmp_path / "o.mkv")
    assert numbers == list(range(60))
    assert np.abs(np.array([float(t) for t in times]) - 2 * np.array(stamps) / 1000).max() <= 2e-3
    # Twice as fast they would come closer together than any did.
    apply.retime_media(clip, tmp_path / "p.mkv", Warp([0, end / 2], [0, end]))
    _, times, _ = clips.read_frames(tmp_path / "p.mkv")
    assert np.diff([float(t) for t in times]).min() >= np.diff(stamps).min() / 1000 - 2e-3
    # And at a constant rate.
    apply.retime_media(
        clip, tmp_path / "q.mkv", Warp([0, end], [0, end]), options.MediaOptions(rate=Fraction(25), frames="nearest")
    )
    numbers, times, _ = clips.read_frames(tmp_path / "q.mkv")
    at = np.interp(np.arange(len(numbers)) / 25, np.array(stamps) / 1000, np.arange(60))
    assert np.abs(np.array(numbers) - at).max() <= 0.51


def test_an_offset_moves_the_clip_against_the_warp(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 60, samples=clips.sound(2.0))
    with pytest.warns(RetimeWarning, match="runs from"):
        apply.retime_media(
            clip, tmp_path / "o.mkv", Warp([0, 2], [0, 2]), options.MediaOptions(offset=0.5, frames="nearest")
        )
    numbers, _, _ = clips.read_frames(tmp_path / "o.mkv")
    assert numbers == [max(0, k - 15) for k in range(61)]
    samples, rate = clips.read_sound(tmp_path / "o.mkv")
    assert clips.clicks_in(samples[0], rate) == pytest.approx([0.75025, 1.25025, 1.75025], abs=1e-3)


def test_what_the_samples_mean_is_kept(tmp_path) -> None:
    def prepare(stream):
        context = stream.codec_context
        context.color_range, context.colorspace, context.color_primaries, context.color_trc = 1, 9, 9, 16
        context.sample_aspect_ratio = Fraction(4, 3)
        stream.set_display_rotation(90)

    clip = clips.write_clip(tmp_path / "a.mov", 20, codec="libx264", form="yuv420p10le", prepare=prepare)
    apply.retime_media(clip, tmp_path / "o.mov", Warp([0, 1], [0, 0.6]))
    with av.open(str(tmp_path / "o.mov")) as container:
        context = container.streams.video[0].codec_context
        frame = next(container.decode(video=0))
    assert context.pix_fmt == "yuv420p10le"
    assert (int(frame.color_range), int(frame.colorspace)) == (1, 9)
    assert (int(frame.color_primaries), int(frame.color_trc)) == (9, 16)
    assert context.sample_aspect_ratio == Fraction(4, 3)
    assert frame.rotation == 90


@pytest.mark.parametrize("form", ["yuva420p", "bgra", "yuv444p16le", "gray16le"])
def test_alpha_and_depth_are_kept(tmp_path, form) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 20, form=form)
    apply.retime_media(clip, tmp_path / "o.mkv", Warp([0, 1], [0, 0.6]))
    _, _, frames = clips.read_frames(tmp_path / "o.mkv")
    assert frames[0].format.name == form


def test_numbered_pictures_in_and_out(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 31)
    apply.retime_media(clip, tmp_path / "take.%04d.png", Warp([0, 1], [0, 1]), options.MediaOptions(frames="nearest"))
    names = sorted(path.name for path in tmp_path.glob("take.*"))
    assert names == [f"take.{k:04d}.png" for k in range(1, 32)]
    apply.retime_media(
        tmp_path / "take.%04d.png",
        tmp_path / "half.%03d.png",
        Warp([0, 0.5], [0, 1]),
        options.MediaOptions(frames="nearest", fps=Fraction(30)),
    )
    assert len(list(tmp_path.glob("half.*"))) == 16
    with av.open(str(tmp_path / "half.004.png")) as container:
        assert clips.number_of(next(container.decode(video=0))) == 6
    with pytest.raises(OutputExistsError):
        apply.retime_media(clip, tmp_path / "take.%04d.png", Warp([0, 1], [0, 1]))
    (tmp_path / "take.0007.png").unlink()
    with pytest.raises(FormatError, match="picture 7 is missing"):
        apply.retime_media(tmp_path / "take.%04d.png", tmp_path / "b.mp4", Warp([0, 1], [0, 1]))
    assert not list(tmp_path.glob(".retime*"))


@pytest.mark.parametrize("form", [None, "yuv420p"])
@pytest.mark.parametrize("suffix", [".mp4", ".mkv", ".webm", ".avi", ".mov", ".ts", ".mpg", ".mxf"])
@pytest.mark.parametrize("kind", ["rgb24", "gray", "gray16be", "pal8", "jpeg"])
def test_pictures_keep_their_colours_in_a_video(tmp_path, kind, suffix, form) -> None:
    colours = np.array([(255, 0, 0), (0, 255, 0), (0, 0, 255), (20, 20, 20), (235, 235, 235)], np.uint8)
    if kind.startswith("gray"):
        colours = np.repeat(np.array([[20], [70], [110], [150], [240]], np.uint8), 3, axis=1)
    picture = np.repeat(np.tile(colours, (64, 1, 1)), 20, axis=1)
    coder, kept = ("mjpeg", "yuvj444p") if kind == "jpeg" else ("png", kind)
    for number in range(6):
        context = av.CodecContext.create(coder, "w")
        context.width, context.height, context.pix_fmt, context.time_base = 100, 64, kept, Fraction(1, 25)
        frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
        if kind == "pal8":
            frame = _of_palette(picture)
        elif kind != "rgb24":
            frame = frame.reformat(format=kept, dst_color_range="JPEG")
        data = b"".join(bytes(packet) for packet in (*context.encode(frame), *context.encode(None)))
        (tmp_path / f"take.{number}.{coder.removeprefix('m')}").write_bytes(data)
    clip = options.MediaOptions(frames="nearest", fps=Fraction(25), pixel_format=form)
    source = next(tmp_path.glob("take.0.*"))
    read = next(clips.read_frames(source)[2].__iter__()).to_ndarray(format="rgb24")[32, 10::20]
    np.testing.assert_allclose(read.astype(int), colours.astype(int), atol=4)
    place = tmp_path / f"o{suffix}"
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        apply.retime_media(tmp_path / f"take.%d{source.suffix}", place, Warp([0, 0.2], [0, 0.2]), clip)
    _, _, frames = clips.read_frames(place)
    assert len(frames) == 6
    # Of the depth, all that is lost is told, but what was asked for.
    bits = frames[0].format.components[0].bits
    expected = [f"{16 - bits} of 16 bits a sample"] if kind == "gray16be" and form is None and bits < 16 else []
    assert [any(words in str(one.message) for one in said) for words in expected] == [True] * len(said)
    for frame in frames:
        found = frame.to_ndarray(format="rgb24")[32, 10::20]
        np.testing.assert_allclose(found.astype(int), colours.astype(int), atol=12)
        grey = np.ptp(colours, axis=1) == 0
        np.testing.assert_allclose(found[grey].astype(int), colours[grey].astype(int), atol=5)


def _of_palette(picture: np.ndarray) -> av.VideoFrame:
    """Make a frame of a palette, of the colours of a picture."""
    table, places = np.unique(picture.reshape(-1, 3), axis=0, return_inverse=True)
    palette = np.zeros((256, 4), np.uint8)
    palette[: len(table)] = np.column_stack([np.full(len(table), 255), table])
    return av.VideoFrame.from_ndarray((places.reshape(picture.shape[:2]).astype(np.uint8), palette), format="pal8")


@pytest.mark.parametrize(("codec", "suffix"), [("hevc", ".mp4"), ("h264", ".mkv"), ("vp9", ".webm"), ("ffv1", ".mkv")])
def test_pictures_of_alpha_find_a_format_that_the_codec_writes(tmp_path, codec, suffix) -> None:
    picture = np.full((48, 64, 4), (200, 120, 40, 255), np.uint8)
    for number in range(4):
        context = av.CodecContext.create("png", "w")
        context.width, context.height, context.pix_fmt, context.time_base = 64, 48, "rgba", Fraction(1, 25)
        frame = av.VideoFrame.from_ndarray(picture, format="rgba")
        data = b"".join(bytes(packet) for packet in (*context.encode(frame), *context.encode(None)))
        (tmp_path / f"take.{number}.png").write_bytes(data)
    clip = options.MediaOptions(frames="nearest", fps=Fraction(25), codec=codec)
    apply.retime_media(tmp_path / "take.%d.png", tmp_path / f"o{suffix}", Warp([0, 0.12], [0, 0.12]), clip)
    _, _, frames = clips.read_frames(tmp_path / f"o{suffix}")
    assert len(frames) == 4
    for frame in frames:
        found = frame.to_ndarray(format="rgb24")[24, 32]
        np.testing.assert_allclose(found.astype(int), picture[0, 0, :3].astype(int), atol=12)


@pytest.mark.parametrize("suffix", [".gif", ".webp", ".apng"])
def test_animations_in_and_out(tmp_path, suffix) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 31, rate=Fraction(25), samples=clips.sound(1.2))
    out = tmp_path / f"a{suffix}"
    apply.retime_media(clip, out, Warp([0, 1.2], [0, 1.2]), options.MediaOptions(frames="nearest", quality=0))
    again = tmp_path / "again.mkv"
    apply.retime_media(out, again, Warp([0, 0.6], [0, 1.2]), options.MediaOptions(frames="nearest", rate=Fraction(25)))
    numbers, _, _ = clips.read_frames(again)
    assert numbers == [2 * k for k in range(16)]


def test_several_streams_subtitles_and_chapters(tmp_path) -> None:
    path = tmp_path / "a.mkv"
    clips.write_clip(tmp_path / "v.mkv", 60, samples=clips.sound(2.0))
    with av.open(str(tmp_path / "v.mkv")) as source, av.open(str(path), "w") as output:
        video = output.add_stream_from_template(source.streams.video[0])
        sounds = [output.add_stream_from_template(source.streams.audio[0]) for _ in range(2)]
        sounds[1].metadata["language"] = "fra"
        texts = output.add_mux_stream("subrip")
        output.set_chapters(
            [
                {
                    "id": k,
                    "start": k * 1000,
                    "end": (k + 1) * 1000,
                    "time_base": Fraction(1, 1000),
                    "metadata": {"title": f"part {k}"},
                }
                for k in range(2)
            ]
        )
        for packet in source.demux():
            if packet.dts is None:
                continue
            if packet.stream.type == "video":
                packet.stream = video
                output.mux(packet)
            else:
                for sound in sounds:
                    copy = av.Packet(bytes(packet))
                    copy.pts, copy.dts, copy.time_base, copy.stream = packet.pts, packet.dts, packet.time_base, sound
                    copy.is_keyframe = True
                    output.mux(copy)
        for start, text in ((500, b"first"), (1200, b"second")):
            packet = av.Packet(text)
            packet.stream, packet.time_base = texts, Fraction(1, 1000)
            packet.pts = packet.dts = start
            packet.duration, packet.is_keyframe = 400, True
            output.mux(packet)
    warp = Warp([0, 1, 3.5], [0, 1, 1.95])
    apply.retime_media(path, tmp_path / "o.mkv", warp)
    with av.open(str(tmp_path / "o.mkv")) as container:
        assert [stream.type for stream in container.streams] == ["video", "audio", "audio", "subtitle"]
        assert container.streams[2].language == "fra"
        chapters = [
            (c["start"] * c["time_base"], c["end"] * c["time_base"], c["metadata"]["title"])
            for c in container.chapters()
        ]
        found = [
            (float(p.pts * p.time_base), float(p.duration * p.time_base), bytes(p))
            for p in container.demux(subtitles=0)
            if p.size
        ]
    assert [(round(float(a), 2), title) for a, _, title in chapters] == [(0.0, "part 0"), (1.0, "part 1")]
    slow = 2.5 / 0.95
    assert [(text, start) for start, _, text in found] == [
        (b"first", 0.5),
        (b"second", pytest.approx(1 + 0.2 * slow, abs=2e-3)),
    ]
    assert found[1][1] == pytest.approx(0.4 * slow, abs=2e-3)
    # As MP4 and WebM write text, and back again.
    for source, name, codec in (
        (path, "o.mp4", "mov_text"),
        (path, "o.webm", "webvtt"),
        (tmp_path / "o.mp4", "again.mkv", "subrip"),
    ):
        used = warp if source == path else Warp([0, 3.5], [0, 3.5])
        apply.retime_media(source, tmp_path / name, used, options.MediaOptions(codec="vp9", quality=40))
        with av.open(str(tmp_path / name)) as container:
            (stream,) = container.streams.subtitles
            assert stream.codec_context.codec.canonical_name == codec
            texts = [
                (round(float(packet.pts * packet.time_base), 2), bytes(packet))
                for packet in container.demux(stream)
                if packet.size > 2
            ]
        begun = round(1 + 0.2 * slow, 2)
        lead = (lambda text: len(text).to_bytes(2, "big") + text) if codec == "mov_text" else bytes
        assert texts == [(0.5, lead(b"first")), (begun, lead(b"second"))]


def test_a_file_that_is_there_stays(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 10)
    (tmp_path / "o.mkv").write_bytes(b"mine")
    with pytest.raises(OutputExistsError):
        apply.retime_media(clip, tmp_path / "o.mkv", Warp([0, 1], [0, 0.3]))
    assert (tmp_path / "o.mkv").read_bytes() == b"mine"
    apply.retime_media(clip, tmp_path / "o.mkv", Warp([0, 1], [0, 0.3]), overwrite=True)
    assert len(clips.read_frames(tmp_path / "o.mkv")[0]) == 31


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"frames": "best"}, "frames is one of"),
        ({"shutter": 2.0}, "share from 0 to 1"),
        ({"quality": 99}, "from 0 to 63"),
        ({"sound": "loud"}, "sound is one of"),
        ({"offset": float("nan")}, "number of seconds"),
        ({"rate": "fast"}, "rate is a Fraction"),
    ],
)
def test_options_that_are_none(given, message) -> None:
    with pytest.raises(OptionError, match=message):
        options.MediaOptions(**given)


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("o.mp4", {"codec": "vp9x"}, "no encoder"),
        ("o.mp4", {"codec": "aac"}, "encodes audio"),
        ("o.webm", {"codec": "h264"}, "can't hold"),
        ("o.mp4", {"codec": "h264", "pixel_format": "rgb565"}, "takes"),
    ],
)
def test_encoders_that_are_none(tmp_path, name, given, message) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 5)
    with pytest.raises(OptionError, match=message):
        apply.retime_media(clip, tmp_path / name, Warp([0, 0.1], [0, 0.1]), options.MediaOptions(**given))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.mkv"]


def _in_fields(path: Path, *, speed: int = 4) -> Path:
    """Write a bar that moves to the right, a field at a time: even rows show it half a frame later."""

    def field(time: int) -> np.ndarray:
        grey = np.full((96, 160), 40, np.uint8)
        grey[:, 10 + speed * time : 34 + speed * time] = 220
        return grey

    with av.open(str(path), "w") as output:
        stream = output.add_stream("libx264", rate=25, options={"crf": "1", "x264-params": "bff=1"})
        stream.width, stream.height, stream.pix_fmt = 160, 96, "yuv420p"
        for number in range(12):
            # x264 calls the lower field the first one, where a frame says nothing.
            grey = field(2 * number)
            grey[::2] = field(2 * number + 1)[::2]
            frame = av.VideoFrame.from_ndarray(grey, format="gray").reformat(format="yuv420p")
            frame.pts = number
            output.mux(stream.encode(frame))
        output.mux(stream.encode(None))
    return path


def _combs(frame) -> float:
    """Say how much rows differ from those above and below, which a bar that stands upright never does."""
    grey = frame.reformat(format="gray").to_ndarray().astype(float)
    return float(np.abs(2 * grey[9:-9:2] - grey[8:-10:2] - grey[10:-8:2]).max())


def test_whole_frames_are_made_of_fields(tmp_path) -> None:
    clip = _in_fields(tmp_path / "a.mp4")
    same = Warp([0, 11 / 25], [0, 11 / 25])
    sharp = options.MediaOptions(codec="ffv1", frames="nearest")
    with pytest.warns(RetimeWarning, match="whole frames were made of its fields"):
        apply.retime_media(clip, tmp_path / "b.mkv", same, sharp)
    with pytest.warns(RetimeWarning, match="look like combs"):
        apply.retime_media(clip, tmp_path / "c.mkv", same, replace(sharp, deinterlace=False))
    whole, kept = (list(av.open(str(tmp_path / name)).decode(video=0)) for name in ("b.mkv", "c.mkv"))
    assert len(whole) == len(kept) == 12
    assert max(map(_combs, whole)) < 60 < 200 < min(map(_combs, kept))
    # What is shown is the first field, at its own moment; frames come in their order also backward.
    assert [_left_of(frame) for frame in whole] == pytest.approx([10 + 8 * n for n in range(12)], abs=1)
    with pytest.warns(RetimeWarning, match="fields"):
        apply.retime_media(clip, tmp_path / "d.mkv", Warp([0, 11 / 25], [11 / 25, 0]), sharp)
    back = [_left_of(frame) for frame in av.open(str(tmp_path / "d.mkv")).decode(video=0)]
    assert back == pytest.approx([10 + 8 * n for n in range(11, -1, -1)], abs=1)


def _left_of(frame) -> int:
    """Return where the bar begins."""
    return int(np.argmax(frame.reformat(format="gray").to_ndarray()[49] > 128))


@pytest.mark.parametrize("suffix", [".mp4", ".mov"])
def test_a_movie_begins_with_its_table_of_contents(tmp_path, suffix) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 40, codec="libx264", samples=clips.sound(1.3))
    apply.retime_media(clip, tmp_path / f"b{suffix}", Warp([0, 2.6], [0, 1.3]))
    data = (tmp_path / f"b{suffix}").read_bytes()
    assert 0 < data.find(b"moov") < data.find(b"mdat")
    numbers, times, _ = clips.read_frames(tmp_path / f"b{suffix}")
    assert len(numbers) == 79
    assert float(times[-1]) == pytest.approx(2.6)
    samples, rate = clips.read_sound(tmp_path / f"b{suffix}")
    assert samples.shape[1] / rate == pytest.approx(2.6, abs=0.1)


def test_a_warp_is_found_from_animations(tmp_path) -> None:
    from retime.media.features import video_signal

    clip = clips.write_clip(tmp_path / "a.mkv", 20)
    for suffix in (".gif", ".webp"):
        apply.retime_media(clip, tmp_path / f"a{suffix}", Warp([0, 19 / 30], [0, 19 / 30]))
        assert video_signal(tmp_path / f"a{suffix}").n_frames >= 19, suffix


def test_channels_that_nobody_placed_are_placed_as_usual(tmp_path) -> None:
    """A WAV of two channels, or of six, need not say where they are heard; QuickTime must."""
    for n_channels, layout in ((2, "stereo"), (6, "5.1")):
        wav = tmp_path / f"{n_channels}.wav"
        tone = 0.3 * np.sin(2 * np.pi * 440 * np.arange(48_000) / 48_000).astype(np.float32)
        samples = np.round(32767 * np.stack([tone * (k + 1) / n_channels for k in range(n_channels)])).astype("<i2")
        with wave.open(str(wav), "wb") as file:
            file.setnchannels(n_channels)
            file.setsampwidth(2)
            file.setframerate(48_000)
            file.writeframes(samples.T.tobytes())
        apply.retime_media(wav, tmp_path / "a.mov", Warp([0, 1], [0, 1]), overwrite=True)
        with av.open(str(tmp_path / "a.mov")) as container:
            assert container.streams.audio[0].layout.name == layout
        found, _ = clips.read_sound(tmp_path / "a.mov")
        sizes = np.abs(found[:, 10_000:20_000]).max(axis=1)
        np.testing.assert_allclose(sizes, 0.3 * np.arange(1, n_channels + 1) / n_channels, atol=0.02)


@pytest.mark.parametrize("codec", ["libvpx-vp9", "libvpx"])
def test_alpha_beside_the_picture_is_kept(tmp_path, codec) -> None:
    """WebM keeps alpha as a second picture beside each packet, which the usual decoders leave out."""

    def see_through(number: int, frame):
        colours = np.full((64, 96, 4), 120, np.uint8)
        colours[:, :, 3] = np.where(np.arange(96) < 48, 255, 8 * number)
        made = av.VideoFrame.from_ndarray(colours, format="rgba").reformat(format="yuva420p")
        made.pts, made.time_base = frame.pts, frame.time_base
        return made

    clip = clips.write_clip(
        tmp_path / "a.webm", 30, codec=codec, form="yuva420p", change=see_through, options={"auto-alt-ref": "0"}
    )
    apply.retime_media(
        clip, tmp_path / "b.webm", Warp([0, 0.5], [0, 1.0 - 1 / 30]), options.MediaOptions(frames="nearest", quality=4)
    )
    apply.retime_media(
        clip, tmp_path / "b.%02d.png", Warp([0, 29 / 30], [29 / 30, 0]), options.MediaOptions(frames="nearest")
    )
    last = next(av.open(str(tmp_path / "b.01.png")).decode(video=0)).to_ndarray(format="rgba")
    assert last[:, :40, 3].min() > 250
    assert abs(float(last[:, 56:, 3].mean()) - 8 * 29) < 6
    pictures = tmp_path / "c.%02d.png"
    apply.retime_media(tmp_path / "b.webm", pictures, Warp([0, 0.5], [0, 0.5]))
    middle = next(av.open(str(tmp_path / "c.09.png")).decode(video=0)).to_ndarray(format="rgba")
    assert abs(float(middle[:, 56:, 3].mean()) - 8 * 15) < 20


def test_a_codec_that_cannot_be_written_is_named(tmp_path) -> None:
    clip = clips.write_clip(
        tmp_path / "a.avi", 8, codec="dvvideo", form="yuv411p", size=(720, 480), rate=Fraction(30000, 1001)
    )
    with pytest.warns(RetimeWarning) as caught:
        apply.retime_media(clip, tmp_path / "b.avi", Warp([0, 0.4], [0, 0.2]))
    assert any(
        "its video is dvvideo, which can't be written so; the output's is mpeg4" in str(w.message) for w in caught
    )
    # A camera's MPEG stays what it is.
    disc = clips.write_clip(tmp_path / "a.mpg", 20, codec="mpeg2video", samples=clips.sound(0.6), sound_codec="mp2")
    apply.retime_media(disc, tmp_path / "b.mpg", Warp([0, 1.2], [0, 0.6]))
    with av.open(str(tmp_path / "b.mpg")) as container:
        assert {stream.codec_context.name for stream in container.streams} <= {"mpeg2video", "mp2", "mp2float"}


@pytest.mark.parametrize("suffix", [".mp4", ".mov", ".mkv", ".webm", ".gif", ".apng", ".webp"])
def test_a_hold_at_the_end_of_a_variable_rate_is_as_long_as_it_should_be(tmp_path, suffix) -> None:
    stamps = np.cumsum(np.random.default_rng(4).integers(20, 60, 40)).tolist()
    # With B frames the last packet is not the last frame.
    clip = clips.write_clip(
        tmp_path / "a.mp4", 40, codec="libx264", stamps=stamps, base=Fraction(1, 1000), options={"bf": "3"}
    )
    apply.retime_media(clip, tmp_path / f"o{suffix}", Warp([0, 0.8, 3], [0, 0.8, 0.8]))
    # And then a frame more, as long as the others in the mean.
    assert 3 <= describe_media(tmp_path / f"o{suffix}")["streams"][0]["seconds"] < 3.2


def test_stamps_that_were_rounded_to_milliseconds_are_even(tmp_path) -> None:
    # As of a Matroska file that became an MP4.
    stamps = [round(1000 * k / 29.97 / 1000 * 90_000 / 90) * 90 for k in range(60)]
    clip = clips.write_clip(
        tmp_path / "a.mp4", 60, codec="libx264", rate=Fraction(30_000, 1001), stamps=stamps, base=Fraction(1, 90_000)
    )
    apply.retime_media(clip, tmp_path / "o.mp4", Warp([0, 1], [0, 1.5]), options.MediaOptions(frames="nearest"))
    numbers, times, _ = clips.read_frames(tmp_path / "o.mp4")
    assert np.diff([float(time) for time in times]) == pytest.approx(1001 / 30_000, abs=1e-4)
    assert np.abs(np.array(numbers) - 1.5 * np.arange(len(numbers))).max() <= 0.51


def test_the_usual_stream_and_the_comment_stay_so_and_chapters_are_no_stream_that_is_left_out(tmp_path) -> None:
    path = tmp_path / "a.mp4"
    clips.write_clip(tmp_path / "v.mkv", 60, codec="libx264", samples=clips.sound(2.0), sound_codec="aac")
    with av.open(str(tmp_path / "v.mkv")) as source, av.open(str(path), "w") as output:
        video = output.add_stream_from_template(source.streams.video[0])
        sounds = [output.add_stream_from_template(source.streams.audio[0]) for _ in range(2)]
        sounds[1].disposition = av.stream.Disposition.comment
        output.set_chapters(
            [
                {"id": k, "start": k, "end": k + 1, "time_base": Fraction(1), "metadata": {"title": f"part {k}"}}
                for k in range(2)
            ]
        )
        for packet in source.demux():
            if packet.size:
                for stream in [video] if packet.stream.type == "video" else sounds:
                    copy = av.Packet(bytes(packet))
                    copy.pts, copy.dts, copy.time_base, copy.stream = packet.pts, packet.dts, packet.time_base, stream
                    copy.is_keyframe = packet.is_keyframe
                    output.mux(copy)
    # Nothing is warned of: warnings are errors here.
    apply.retime_media(path, tmp_path / "o.mp4", Warp([0, 1], [0, 1.9]))
    with av.open(str(tmp_path / "o.mp4")) as container:
        assert [stream.disposition & av.stream.Disposition.comment for stream in container.streams.audio] == [
            0,
            av.stream.Disposition.comment,
        ]
        assert len(container.chapters()) == 2


@pytest.mark.parametrize(
    ("suffix", "codec"), [(".avi", "libx264"), (".avi", "mpeg4"), (".mxf", "libx264"), (".mxf", "mpeg2video")]
)
def test_frames_in_another_order_than_packets_are_told_apart_where_the_file_does_not(tmp_path, suffix, codec) -> None:
    """AVI and MXF number packets as they are decoded."""
    clip = clips.write_clip(
        tmp_path / f"a{suffix}", 60, codec=codec, samples=clips.sound(2.0), options={"bf": "2"}, form="yuv420p"
    )
    place = tmp_path / "o.mkv"
    chosen = options.MediaOptions(frames="nearest", codec="ffv1", sound="resample")
    # Backward, too.
    warp = Warp([0, 1, 2, 3], [0, 1, 0.5, 59 / 30])
    apply.retime_media(clip, place, warp, chosen)
    numbers, _, _ = clips.read_frames(place)
    assert numbers == shown_by(warp, RATE, 60).tolist()
    samples, rate = clips.read_sound(place)
    assert clips.clicks_in(samples[0], rate)[:2] == pytest.approx([0.25025, 0.75025], abs=1e-3)


def test_an_avi_has_its_frames_in_the_order_of_showing(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.mp4", 60, codec="libx264", options={"bf": "3"})
    apply.retime_media(clip, tmp_path / "o.avi", Warp([0, 1], [0, 1]), options.MediaOptions(frames="nearest"))
    with av.open(str(tmp_path / "o.avi")) as container:
        assert container.streams.video[0].codec_context.codec.canonical_name == "h264"
        found = [(frame.pts, clips.number_of(frame)) for frame in container.decode(video=0)]
    assert [number for _, number in sorted(found)] == list(range(31))
    assert found == sorted(found)
