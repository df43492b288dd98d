"""Films of the stage: what is checked before, and that every picture is in the film once."""

from __future__ import annotations

import json
import struct
import zlib
from importlib.util import find_spec
from urllib.parse import urlencode

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
