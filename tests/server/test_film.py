"""Films of the stage: what is checked before, and that every picture is in the film once."""

from __future__ import annotations

import json
import struct
import zlib
from importlib.util import find_spec
from urllib.parse import urlencode

import numpy as np
import pytest

WITHOUT = find_spec("av") is None or find_spec("cv2") is None


def _png(value: int, width: int = 64, height: int = 48) -> bytes:
    """Write a picture of one grey, by the standard library alone."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = (b"\0" + bytes([value] * width)) * height
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def _post(served, address, body=b"", **given):
    query = f"?{urlencode(given)}" if given else ""
    return served.ask(address + query, method="POST", body=body, Origin=f"http://{served.host}")


@pytest.mark.skipif(not WITHOUT, reason="the extra video is installed")
def test_the_extra_that_films_need_is_named_before_anything_is_drawn(served) -> None:
    answer = _post(served, "/film", path=str(served.folder / "a.webm"), rate="30", frames="5")
    assert answer.status == 400
    assert "pip install 'retime[video]'" in answer.body.decode()


def test_a_film_is_for_the_pages_own_browser_alone(served) -> None:
    assert served.ask("/film", method="POST", body=b"").status == 403
    assert served.ask("/film", method="GET").status == 405
    assert _post(served, "/film/none/0", _png(0)).status == 404
    assert _post(served, "/film/none/end").status == 404
    assert _post(served, "/film/none/stop").status == 204


@pytest.mark.extras
@pytest.mark.skipif(WITHOUT, reason="needs PyAV and OpenCV (make extras)")
@pytest.mark.parametrize("name", ["film.webm", "film.mp4", "film.gif"])
def test_a_film_has_every_picture_once(served, name) -> None:
    import av

    place = served.folder / name
    count = 23
    begun = _post(served, "/film", path=str(place), rate="24", frames=str(count))
    assert begun.status == 200, begun.body
    film = json.loads(begun.body)["film"]
    for i in range(count):
        # In their order, each once.
        assert _post(served, f"/film/{film}/{i + 1}", _png(0)).status == 409
        assert _post(served, f"/film/{film}/end").status == 409
        assert _post(served, f"/film/{film}/{i}", _png(10 * i + 10)).status == 204
    assert _post(served, f"/film/{film}/{count}", _png(0)).status == 409
    assert not place.exists()
    done = _post(served, f"/film/{film}/end")
    assert (done.status, json.loads(done.body)) == (200, {"path": str(place)})
    with av.open(str(place)) as made:
        frames = [frame.to_ndarray(format="gray").mean() for frame in made.decode(video=0)]
        assert float(made.streams.video[0].average_rate) == pytest.approx(24, rel=0.05)
    assert frames == pytest.approx([10 * i + 10 for i in range(count)], abs=4)
    # It is done, and forgotten.
    assert _post(served, f"/film/{film}/end").status == 404


@pytest.mark.extras
@pytest.mark.skipif(WITHOUT, reason="needs PyAV and OpenCV (make extras)")
def test_what_a_film_can_not_be_is_said_before_it_is_drawn(served, tmp_path) -> None:
    (served.folder / "there.webm").write_bytes(b"mine")
    good = {"path": str(served.folder / "new.webm"), "rate": "30", "frames": "5"}
    for change, status, says in (
        ({"path": str(tmp_path / "away.webm")}, 400, "lies outside the folders"),
        ({"path": str(served.folder / "film.bvh")}, 400, "a film's name ends in one of"),
        ({"path": str(served.folder / "there.webm")}, 409, "there"),
        ({"frames": "1"}, 400, "a film has 2 to"),
        ({"frames": "many"}, 400, "a film has 2 to"),
        ({"rate": "never"}, 400, "frame rate"),
    ):
        answer = _post(served, "/film", **{**good, **change})
        assert (answer.status, says in answer.body.decode()) == (status, True), (change, answer.body)
    film = json.loads(_post(served, "/film", **good).body)["film"]
    assert _post(served, f"/film/{film}/0", b"GIF89a").status == 415
    assert _post(served, f"/film/{film}/0", _png(3)).status == 204
    assert _post(served, f"/film/{film}/stop").status == 204
    assert _post(served, f"/film/{film}/1", _png(3)).status == 404
    # Damaged pictures end it with words, and leave nothing behind.
    film = json.loads(_post(served, "/film", **{**good, "frames": "2"}).body)["film"]
    for i in range(2):
        assert _post(served, f"/film/{film}/{i}", _png(3)[:40]).status == 204
    answer = _post(served, f"/film/{film}/end")
    assert answer.status in (400, 500)
    assert len(answer.body) > 10
    assert not (served.folder / "new.webm").exists()
    assert (served.folder / "there.webm").read_bytes() == b"mine"


def _put(page, served, name, **beside):
    page.edit(media={"path": str(served.folder / name), "offset": None, "clock": "input", **beside})
    page.told()


def _film(served, place, heard, count=25, rate="10"):
    """Film so many pictures, with what is heard; the server's answers to the first and the last word."""
    address = f"/film?{urlencode({'path': str(place), 'rate': rate, 'frames': str(count)})}"
    begun = _post(served, address, json.dumps(heard).encode())
    if begun.status != 200:
        return begun, None
    film = json.loads(begun.body)["film"]
    for i in range(count):
        assert _post(served, f"/film/{film}/{i}", _png(10 * i % 250)).status == 204
    return begun, _post(served, f"/film/{film}/end")


# Slower, held, then faster: seconds of the film and of the sound.
HEARD = {"times": [0.0, 1.2, 1.5, 2.6], "values": [0.0, 1.0, 1.0, 3.2], "keys": [1.2]}


@pytest.mark.extras
@pytest.mark.skipif(WITHOUT or find_spec("python_stretch") is None, reason="needs the extra video (make extras)")
@pytest.mark.parametrize(
    ("name", "codec"), [("film.mp4", "aac"), ("film.webm", "opus"), ("film.mov", "aac"), ("film.mkv", "aac")]
)
@pytest.mark.parametrize("beside", ["take.wav", "take.mp4"])
def test_a_film_has_the_sound_beside_the_stage_as_it_is_heard(served, name, codec, beside) -> None:
    import av

    from tests.media import clips

    # A click each third of a second on the left, and a tone on the right.
    samples = clips.sound(4.0, every=1 / 3, first=0.2)
    if beside == "take.wav":
        clips.write_sound(served.folder / beside, samples)
    else:
        clips.write_clip(served.folder / beside, 120, codec="libx264", samples=samples, sound_codec="pcm_s16le")
    place = served.folder / name
    with served.ready_page() as page:
        _put(page, served, beside)
        begun, done = _film(served, place, HEARD)
    assert json.loads(begun.body)["heard"] is True
    assert done.status == 200, done.body
    with av.open(str(place)) as made:
        assert made.streams.audio[0].codec_context.codec.canonical_name == codec
        assert sum(1 for _ in made.decode(video=0)) == 25
    heard, rate = clips.read_sound(place)
    # A frame more than its seconds times its rate, as the pictures.
    assert heard.shape[1] / rate == pytest.approx(2.5, abs=0.03)
    clicks = np.arange(0.2, 3, 1 / 3) + 12 / 48_000
    # Each side of the hold by itself.
    wanted = np.where(clicks <= 1, 1.2 * clicks, 1.5 + (clicks - 1) / 2)
    found = clips.clicks_in(heard[0].copy(), rate, least=0.2)
    # While the last frame is held, from 2.4 s on, sound goes on at its own speed.
    np.testing.assert_allclose(found[found < 2.4], wanted[wanted < 2.4], atol=4e-3)
    for first, last in ((0.15, 1.05), (1.7, 2.3)):
        assert clips.pitch_of(heard[1, round(first * rate) : round(last * rate)], rate) == pytest.approx(440, rel=0.01)


@pytest.mark.extras
@pytest.mark.skipif(WITHOUT or find_spec("python_stretch") is None, reason="needs the extra video (make extras)")
def test_a_film_of_media_without_sound_is_silent_and_what_can_not_be_heard_is_said(served) -> None:
    import av

    from tests.media import clips

    clips.write_clip(served.folder / "mute.mp4", 30, codec="libx264")
    clips.write_sound(served.folder / "take.wav", clips.sound(1.0))
    place = served.folder / "film.mp4"
    assert "no sound beside the stage" in _film(served, place, HEARD)[0].body.decode()
    with served.ready_page() as page:
        _put(page, served, "mute.mp4")
        begun, done = _film(served, place, HEARD)
        assert (json.loads(begun.body)["heard"], done.status) == (False, 200)
        with av.open(str(place)) as made:
            assert [stream.type for stream in made.streams] == ["video"]
        place.unlink()
        _put(page, served, "take.wav")
        for heard, says in (
            ({"times": [0, 1], "values": [0], "keys": []}, "as many of each"),
            ({"times": [0, 0], "values": [0, 1], "keys": []}, "as many of each"),
            ({"times": [0, "soon"], "values": [0, 1], "keys": []}, "as many of each"),
            ({"times": [0, 1]}, "as many of each"),
            ([1, 2], "as many of each"),
            ({"times": [0, float("nan")], "values": [0, 1], "keys": []}, "NaN is not a number"),
        ):
            answer, _ = _film(served, place, heard)
            assert (answer.status, says in answer.body.decode()) == (400, True), (heard, answer.body)
        answer, _ = _film(served, served.folder / "film.gif", HEARD)
        assert "a .gif has no sound" in answer.body.decode()
        (served.folder / "list.mp4").write_text("#EXTM3U\nother.mp4\n")
        _put(page, served, "list.mp4")
        assert "a playlist" in _film(served, place, HEARD)[0].body.decode()
    assert not place.exists()
    assert not [path for path in served.folder.iterdir() if path.name.startswith(".retime")]
