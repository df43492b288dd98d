"""What an output can't hold of the input's looks: turned where that helps, and told where nothing does."""

from __future__ import annotations

import warnings
from fractions import Fraction

import numpy as np
import pytest

from retime.errors import RetimeWarning
from retime.media import apply, options
from retime.warp.curve import Warp
from tests.media import clips

av = pytest.importorskip("av", reason="needs the extra 'video'")
for package in ("cv2", "python_stretch"):
    pytest.importorskip(package, reason="needs the extra 'video'")

pytestmark = pytest.mark.extras
WARP = Warp([0, 0.5], [0, 0.6])
# How a phone writes what is to be turned: a quarter to the right, the other way, half, and mirrored.
TURNS = {
    "right": ([0, 1 << 16, 0, -1 << 16, 0, 0, 0, 0, 1 << 30], lambda seen: np.rot90(seen, -1)),
    "left": ([0, -1 << 16, 0, 1 << 16, 0, 0, 0, 0, 1 << 30], np.rot90),
    "half": ([-1 << 16, 0, 0, 0, -1 << 16, 0, 0, 0, 1 << 30], lambda seen: np.rot90(seen, 2)),
    "mirrored": ([-1 << 16, 0, 0, 0, 1 << 16, 0, 0, 0, 1 << 30], np.fliplr),
}


def said_of(clip, place, **given) -> list[str]:
    """Retime a clip; the warnings of what was not kept."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        apply.retime_media(clip, place, WARP, options.MediaOptions(**given))
    return [str(one.message) for one in said if "not kept" in str(one.message)]


@pytest.mark.parametrize("name", ["o.gif", "o.apng", "o.avi", "o.ts", "o.%02d.png", "o.%02d.jpg", "o.mov", "o.mkv"])
@pytest.mark.parametrize("turn", list(TURNS))
def test_a_picture_that_is_to_be_turned_is_upright_in_every_output(tmp_path, turn, name) -> None:
    matrix, seen = TURNS[turn]
    clip = clips.write_clip(
        tmp_path / "a.mp4",
        20,
        codec="libx264",
        form="yuv420p" if name != "o.ts" else "yuv422p",
        prepare=lambda stream: stream.set_display_matrix(matrix),
    )
    assert said_of(clip, tmp_path / name, frames="nearest") == []
    with av.open(str(tmp_path / (name % 1 if "%" in name else name))) as container:
        frame = next(container.decode(video=0))
        grey = frame.to_ndarray(format="gray").astype(int)
        sides = [
            np.frombuffer(bytes(one), np.int32)[:9].tolist()
            for one in frame.side_data
            if one.type.name == "DISPLAYMATRIX"
        ]
    picture = clips.picture(0).astype(int)
    if name in ("o.mov", "o.mkv"):
        # These say it beside the picture.
        assert sides == [matrix]
        assert np.abs(grey - picture).mean() < 4
    else:
        assert sides == []
        assert grey.shape == seen(picture).shape
        # The full range of JPEG is read as a narrow one; turned otherwise it would be off by 20 and more.
        assert np.abs(grey - seen(picture)).mean() < (14 if name.endswith("jpg") else 4)


def test_the_shape_of_pixels_is_kept_whatever_says_it(tmp_path) -> None:
    def prepare(stream):
        stream.codec_context.sample_aspect_ratio = Fraction(4, 3)
        stream.set_display_rotation(90)

    clip = clips.write_clip(tmp_path / "a.mp4", 20, codec="libx264", prepare=prepare)
    # ProRes has it in the container alone.
    assert said_of(clip, tmp_path / "b.mov", codec="prores") == []
    assert said_of(tmp_path / "b.mov", tmp_path / "c.mov") == []
    with av.open(str(tmp_path / "c.mov")) as container:
        assert container.streams.video[0].sample_aspect_ratio == Fraction(4, 3)
    # Turned pixels lie the other way.
    assert said_of(clip, tmp_path / "d.avi") == []
    with av.open(str(tmp_path / "d.avi")) as container:
        assert container.streams.video[0].sample_aspect_ratio == Fraction(3, 4)


def test_what_an_output_can_not_hold_is_named(tmp_path) -> None:
    def wide(stream):
        context = stream.codec_context
        context.color_range, context.colorspace, context.color_primaries, context.color_trc = 1, 9, 9, 16
        context.sample_aspect_ratio = Fraction(4, 3)

    light = "G(13250,34500)B(7500,3000)R(34000,16000)WP(15635,16450)L(10000000,50)"
    hdr = clips.write_clip(
        tmp_path / "hdr.mp4",
        20,
        codec="libx265",
        form="yuv420p10le",
        prepare=wide,
        options={"x265-params": f"log-level=none:hdr10=1:master-display={light}:max-cll=1000,400"},
    )
    for name, codec in (("h.mp4", None), ("h.mkv", None), ("a.mp4", "av1"), ("x.mp4", "h264")):
        assert said_of(hdr, tmp_path / name, codec=codec) == []
    (said,) = said_of(hdr, tmp_path / "o.webm")
    assert "vp9 in .webm" in said
    assert "2 of 10 bits a sample, the shape of its pixels (4/3) and its light (HDR). Another ending" in said
    (said,) = said_of(hdr, tmp_path / "o.avi")
    assert "what its colours mean (matrix, primaries, transfer)" in said
    # What was asked for is no loss.
    assert said_of(hdr, tmp_path / "told.mp4", pixel_format="yuv420p") == []

    through = clips.write_clip(tmp_path / "alpha.mkv", 20, form="bgra", change=_half_clear)
    (said,) = said_of(through, tmp_path / "o.mp4", codec="h264")
    assert "its alpha" in said
    assert said_of(through, tmp_path / "o.mkv") == []
    # Alpha that hides nothing is none.
    assert said_of(clips.write_clip(tmp_path / "solid.mkv", 20, form="bgra"), tmp_path / "p.mp4", codec="h264") == []


def _half_clear(number, frame):
    values = frame.to_ndarray(format="bgra")
    values[:, ::2, 3] = 0
    made = av.VideoFrame.from_ndarray(values, format="bgra")
    made.pts, made.time_base = frame.pts, frame.time_base
    return made


def test_pictures_of_wide_colours_say_that_their_range_is_full(tmp_path) -> None:
    def wide(stream):
        context = stream.codec_context
        context.color_range, context.colorspace, context.color_primaries, context.color_trc = 1, 9, 9, 16

    clip = clips.write_clip(tmp_path / "a.mkv", 20, form="yuv420p10le", prepare=wide)
    assert said_of(clip, tmp_path / "o.%02d.png") == []
    data = (tmp_path / "o.01.png").read_bytes()
    at = data.index(b"cICP") + 4
    # Primaries, transfer, no matrix, full range.
    assert list(data[at : at + 4]) == [9, 16, 0, 1]


@pytest.mark.parametrize(
    ("name", "wanted"),
    [
        ("o.wav", "pcm_s16le"),
        ("o.aiff", "pcm_s16be"),
        ("o.mp4", "aac"),
        ("o.3gp", "aac"),
        ("o.flac", "flac"),
        ("o.mov", "aac"),
    ],
)
def test_sound_is_what_programs_expect_in_a_file_of_the_kind(tmp_path, name, wanted) -> None:
    clip = clips.write_clip(tmp_path / "a.mp4", 20, codec="libx264", samples=clips.sound(0.7), sound_codec="aac")
    said_of(clip, tmp_path / name)
    with av.open(str(tmp_path / name)) as container:
        assert container.streams.audio[0].codec_context.codec.canonical_name == wanted
    plain = clips.write_sound(tmp_path / "s.wav", clips.sound(0.7))
    said_of(plain, tmp_path / f"s_{name}")
    with av.open(str(tmp_path / f"s_{name}")) as container:
        found = container.streams.audio[0].codec_context.codec.canonical_name
    assert found == (wanted if name != "o.mov" else "pcm_s16le")


@pytest.mark.parametrize(
    ("codec", "form", "kind", "profile"),
    [
        ("dnxhd", "yuv422p", {"profile": "dnxhr_hq"}, "DNXHR HQ"),
        ("dnxhd", "yuv422p", {"profile": "dnxhr_lb"}, "DNXHR LB"),
        ("dnxhd", "yuv422p10le", {"profile": "dnxhr_hqx"}, "DNXHR HQX"),
        ("prores_ks", "yuv422p10le", {"profile": "proxy"}, "Proxy"),
        ("prores_ks", "yuva444p10le", {}, "4444"),
    ],
)
def test_the_kind_of_a_codec_of_editing_programs_is_kept(tmp_path, codec, form, kind, profile) -> None:
    clip = clips.write_clip(tmp_path / "a.mov", 20, codec=codec, form=form, options=kind, size=(320, 192))
    assert said_of(clip, tmp_path / "o.mov") == []
    with av.open(str(tmp_path / "o.mov")) as container:
        assert container.streams.video[0].codec_context.profile == profile
    assert len(clips.read_frames(tmp_path / "o.mov")[0]) == 16


def test_what_begins_in_the_middle_begins_with_its_first_whole_frame(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.ts", 60, codec="libx264", gop=20, options={"bf": "0"})
    with av.open(str(clip)) as source, av.open(str(tmp_path / "cut.ts"), "w") as output:
        stream = output.add_stream_from_template(source.streams.video[0])
        for packet in list(source.demux(video=0))[7:]:
            if packet.size:
                packet.stream = stream
                output.mux(packet)
    with pytest.warns(RetimeWarning, match="13 of 53 frames can't be decoded .*those next to them"):
        apply.retime_media(
            tmp_path / "cut.ts", tmp_path / "o.mkv", Warp([0, 52 / 30], [0, 52 / 30]), options.MediaOptions()
        )
    numbers, _, _ = clips.read_frames(tmp_path / "o.mkv")
    assert numbers == [20] * 13 + list(range(20, 60))
