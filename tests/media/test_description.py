"""What is told of a file without retiming it."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from retime.errors import FormatError, RetimeWarning
from retime.warp.curve import Warp
from tests.media import clips

av = pytest.importorskip("av", reason="needs the extra 'video'")
pytest.importorskip("cv2", reason="needs the extra 'video'")

from retime.media.apply import retime_media  # noqa: E402
from retime.media.description import describe_media  # noqa: E402
from retime.media.options import MediaOptions  # noqa: E402

pytestmark = pytest.mark.extras


def test_video_with_sound(tmp_path) -> None:
    path = clips.write_clip(
        tmp_path / "a.mp4", 45, rate=Fraction(30000, 1001), codec="libx264", samples=clips.sound(1.5), sound_codec="aac"
    )
    told = describe_media(path)
    video, sound = told["streams"]
    assert (told["container"], told["n_streams"], told["chapters"]) == ("mp4", 2, [])
    assert (video["type"], video["codec"], video["width"], video["height"]) == ("video", "h264", 96, 64)
    assert (video["frames"], video["exact_rate"], video["variable_rate"]) == (45, "30000/1001", False)
    assert video["seconds"] == pytest.approx(45 * 1001 / 30000)
    assert (video["pixel_format"], video["bits"], video["alpha"], video["rotation"]) == ("yuv420p", 8, False, 0)
    assert (sound["type"], sound["codec"], sound["rate"], sound["layout"]) == ("audio", "aac", 48_000, "stereo")
    assert sound["seconds"] == pytest.approx(1.5, abs=1024 / 48_000)


def test_a_rate_that_is_said_is_taken(tmp_path) -> None:
    path = clips.write_clip(tmp_path / "a.mkv", 50)
    assert describe_media(path, fps=25)["streams"][0]["seconds"] == pytest.approx(2.0)


def test_what_a_phone_writes(tmp_path) -> None:
    """A turned picture of high range, ten bits deep, whose frames come when they come."""

    def prepare(stream) -> None:
        stream.set_display_rotation(-90)
        stream.codec_context.color_range, stream.codec_context.colorspace = 1, 9
        stream.codec_context.color_primaries, stream.codec_context.color_trc = 9, 18
        stream.options = {"x265-params": "log-level=none"}

    stamps = [0, 40, 70, 120, 170, 200]
    path = clips.write_clip(
        tmp_path / "a.mp4", 6, codec="libx265", form="yuv420p10le", stamps=stamps, base=Fraction(1, 1000),
        prepare=prepare,
    )  # fmt: skip
    video = describe_media(path)["streams"][0]
    assert (video["bits"], video["rotation"], video["hdr"], video["variable_rate"]) == (10, 90, "HLG", True)
    assert [video[name] for name in ("range", "matrix", "primaries", "transfer")] == [
        "limited", "bt2020nc", "bt2020", "arib-std-b67",
    ]  # fmt: skip
    assert video["frames"] == 6


def test_fields_are_seen(tmp_path) -> None:
    def in_fields(stream) -> None:
        stream.options = {"crf": "12", "x264-params": "tff=1"}

    video = describe_media(clips.write_clip(tmp_path / "a.mp4", 8, codec="libx264", prepare=in_fields))["streams"][0]
    whole = describe_media(clips.write_clip(tmp_path / "b.mp4", 8, codec="libx264"))["streams"][0]
    assert (video["interlaced"], whole["interlaced"]) == (True, False)


def test_chapters_titles_and_languages(tmp_path) -> None:
    with av.open(str(tmp_path / "a.mka"), "w") as output:
        stream = output.add_stream("pcm_s16le", rate=48_000, layout="mono")
        stream.metadata.update(language="dan", title="Room")
        marks = [(0, 400, "Start"), (400, 1000, "End")]
        output.set_chapters(
            [
                {"id": n, "start": a, "end": b, "time_base": Fraction(1, 1000), "metadata": {"title": title}}
                for n, (a, b, title) in enumerate(marks)
            ]
        )
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 48_000), np.int16), format="s16", layout="mono")
        frame.sample_rate, frame.pts = 48_000, 0
        output.mux(stream.encode(frame))
        output.mux(stream.encode(None))
    told = describe_media(tmp_path / "a.mka")
    assert told["chapters"] == [
        {"start": 0.0, "end": 0.4, "title": "Start"},
        {"start": 0.4, "end": 1.0, "title": "End"},
    ]
    (sound,) = told["streams"]
    assert (sound["language"], sound["title"], sound["channels"]) == ("dan", "Room", 1)
    assert sound["seconds"] == pytest.approx(1.0, abs=0.1)


def test_numbered_pictures(tmp_path) -> None:
    for number in range(3, 8):
        av.VideoFrame.from_ndarray(clips.picture(number), format="gray").save(str(tmp_path / f"a.{number:03d}.png"))
    (pictures,) = describe_media(tmp_path / "a.%03d.png", fps=10)["streams"]
    assert (pictures["codec"], pictures["frames"], pictures["seconds"]) == ("png", 5, pytest.approx(0.5))


def test_a_last_frame_may_be_shown_for_long(tmp_path) -> None:
    """Pictures that are all alike are one, in a WebP, which is shown for as long as they were."""
    clip = clips.write_clip(tmp_path / "a.mkv", 31)
    held = Warp([0, 0.5, 2.0], [0, 0.5, 0.5])
    with pytest.warns(RetimeWarning, match="left out"):
        retime_media(clip, tmp_path / "a.webp", held, MediaOptions(frames="nearest"))
    (video,) = describe_media(tmp_path / "a.webp")["streams"]
    assert video["frames"] < 31
    assert video["seconds"] == pytest.approx(2.0 + 1 / 30, abs=0.05)
    # It covers all of that time, so nothing is said of a part that is missing.
    retime_media(tmp_path / "a.webp", tmp_path / "b.mkv", Warp([0, 2], [0, 2]))
    assert describe_media(tmp_path / "b.mkv")["streams"][0]["frames"] == 61


def test_streams_that_are_not_seen_or_heard_are_named(tmp_path) -> None:
    """Fonts in a Matroska, a camera's timecode in a MOV."""
    clip = clips.write_clip(tmp_path / "a.mkv", 10)
    with av.open(str(clip)) as source, av.open(str(tmp_path / "b.mkv"), "w") as output:
        video = output.add_stream_from_template(source.streams.video[0])
        output.add_attachment("words.txt", "text/plain", b"words")
        for packet in source.demux(video=0):
            if packet.size:
                packet.stream = video
                output.mux(packet)
    with pytest.warns(RetimeWarning, match=r"neither seen nor heard was left out \(streams of attachment: 1\)"):
        retime_media(tmp_path / "b.mkv", tmp_path / "c.mkv", Warp([0, 0.3], [0, 0.3]))
    assert [one["type"] for one in describe_media(tmp_path / "b.mkv")["streams"]] == ["video", "attachment"]


@pytest.mark.parametrize("content", [b"", b"#EXTM3U\nother.mp4\n", b"no video", b"RIFF\0\0\0\0WAVEfmt "])
def test_what_is_none_is_refused(tmp_path, content) -> None:
    (tmp_path / "a.mp4").write_bytes(content)
    with pytest.raises(FormatError) as caught:
        describe_media(tmp_path / "a.mp4")
    assert caught.value.path == str(tmp_path / "a.mp4")
