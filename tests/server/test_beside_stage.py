"""What stands beside the stage: media that the document names, served in parts; beats."""

from __future__ import annotations

import json
import os
import wave
from importlib.util import find_spec
from pathlib import Path

import pytest

from retime import apply_warp, guided_warp, read
from retime.media.kinds import ANIMATION_SUFFIXES, SOUND_SUFFIXES, VIDEO_SUFFIXES

WEB = Path(__file__).resolve().parents[2] / "web"


def _write_sound(path, n=4000):
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(8000)
        file.writeframes(bytes(i % 251 for i in range(2 * n)))
    return path.read_bytes()


def _put(page, served, name, **beside):
    page.edit(media={"path": str(served.folder / name), "offset": None, "clock": "input", **beside})
    page.told()


def test_media_are_given_whole_and_in_parts(served) -> None:
    data = _write_sound(served.folder / "song.wav")
    assert served.ask("/media").status == 404
    with served.ready_page() as page:
        _put(page, served, "song.wav")
        whole = served.ask("/media")
        assert (whole.status, whole.body) == (200, data)
        assert whole.headers["content-type"] == "audio/wav"
        assert whole.headers["accept-ranges"] == "bytes"
        assert whole.headers["x-content-type-options"] == "nosniff"
        for first, last in ((0, 0), (44, 543), (len(data) - 7, len(data) - 1)):
            part = served.ask("/media", Range=f"bytes={first}-{last}")
            assert (part.status, part.body) == (206, data[first : last + 1])
            assert part.headers["content-range"] == f"bytes {first}-{last}/{len(data)}"
        assert served.ask("/media", Range="bytes=-5").body == data[-5:]
        assert served.ask("/media", Range=f"bytes={len(data)}-").status == 416
        assert "media-src 'self'" in whole.headers["content-security-policy"]


def test_media_are_for_the_pages_own_browser_alone(served) -> None:
    _write_sound(served.folder / "song.wav")
    with served.ready_page() as page:
        _put(page, served, "song.wav")
        assert served.ask("/media", Cookie=None).status == 403
        assert served.ask("/media", Origin="http://elsewhere.example").status == 403
        assert served.ask("/media", Host="elsewhere.example").status == 421
        assert served.ask("/beats", Cookie=None).status == 403


@pytest.mark.parametrize(
    ("name", "content", "status", "says"),
    [
        ("list.mp4", b"#EXTM3U\nother.mp4\n", 415, "a playlist"),
        ("page.webm", b"<html><script>alert(1)</script>", 415, "markup"),
        ("empty.wav", b"", 415, "empty"),
        ("jump.bvh", None, 415, "nothing here reads .bvh"),
        ("gone.wav", None, 404, "No such file"),
    ],
)
def test_what_is_no_media_is_refused_by_what_it_holds(served, name, content, status, says) -> None:
    if content is not None:
        (served.folder / name).write_bytes(content)
    with served.ready_page() as page:
        _put(page, served, name)
        answer = served.ask("/media")
        assert answer.status == status
        assert says in answer.body.decode()


def test_a_folder_and_a_pipe_are_no_media(served) -> None:
    (served.folder / "folder.mp4").mkdir()
    names = ["folder.mp4"]
    if hasattr(os, "mkfifo"):
        os.mkfifo(served.folder / "pipe.wav")
        names.append("pipe.wav")
    with served.ready_page() as page:
        for name in names:
            _put(page, served, name)
            answer = served.ask("/media")
            assert (answer.status, "not a regular file" in answer.body.decode()) == (415, True)


def test_an_output_is_kept_as_a_file_that_can_lead(served) -> None:
    with served.ready_page() as page:
        page.edit(options={"length": "60%"})
        assert page.curve()["type"] == "curve"
        page.told()
        places = []
        for _ in range(2):
            answer = served.ask("/output", method="POST", body=b"", Origin=f"http://{served.host}")
            assert answer.status == 200, answer.body
            places.append(Path(json.loads(answer.body)["path"]))
        assert [place.name for place in places] == ["jump_output.bvh", "jump_output-2.bvh"]
        clip = read(served.folder / "jump.bvh")
        assert read(places[0]).n_frames == apply_warp(clip, guided_warp(clip, length="60%")).n_frames
        # It can be a reference, wherever it lies.
        page.edit(references=[{"path": str(places[0])}])
        assert page.curve()["type"] == "curve"
        # What can't be done has no output.
        page.edit(options={"length": "nonsense"}, references=[])
        assert page.curve()["type"] == "problem"
        answer = served.ask("/output", method="POST", body=b"", Origin=f"http://{served.host}")
        assert answer.status == 409
        assert len(answer.body) > 10
    assert served.ask("/output", method="POST", body=b"").status == 403


def test_media_outside_the_allowed_folders_are_refused(served, tmp_path) -> None:
    _write_sound(tmp_path / "away.wav")
    (served.folder / "link.wav").symlink_to(tmp_path / "away.wav")
    with served.ready_page() as page:
        for path in (tmp_path / "away.wav", served.folder / "link.wav"):
            page.edit(media={"path": str(path), "offset": None, "clock": "input"})
            page.told()
            answer = served.ask("/media")
            assert answer.status == 403
            assert "lies outside the folders" in answer.body.decode()


def test_beats_of_a_table_are_those_of_the_command_line(served) -> None:
    (served.folder / "beats.csv").write_text("beat,strength,name\n0.5,2,one\n0.25,1,two\n0.9,0,\n")
    assert served.ask("/beats").status == 404
    with served.ready_page() as page:
        page.edit(beats={"path": str(served.folder / "beats.csv"), "on": "beats"})
        page.told()
        answer = served.ask("/beats")
        assert json.loads(answer.body) == {
            "times": [0.25, 0.5, 0.9],
            "strengths": [0.5, 1.0, 0.0],
            "names": ["two", "one", ""],
        }
        # A table that was changed is read again.
        (served.folder / "beats.csv").write_text("1.5\n")
        assert json.loads(served.ask("/beats").body)["times"] == [1.5]
        (served.folder / "beats.csv").write_text("soon\nlater\n")
        answer = served.ask("/beats")
        assert (answer.status, "expected a time in seconds" in answer.body.decode()) == (415, True)


@pytest.mark.skipif(find_spec("librosa") is not None, reason="the extra beats is installed")
def test_the_extra_that_beats_of_sound_need_is_named(served) -> None:
    _write_sound(served.folder / "song.wav")
    with served.ready_page() as page:
        page.edit(
            media={"path": str(served.folder / "song.wav"), "offset": None, "clock": "input"},
            beats={"path": None, "on": "onsets"},
        )
        page.told()
        answer = served.ask("/beats")
        assert answer.status == 501
        assert "pip install 'retime[beats]'" in answer.body.decode()


def test_a_document_has_no_beats_of_media_that_it_has_not(served) -> None:
    with served.ready_page() as page:
        page.edit(beats={"path": None, "on": "beats"})
        assert "the document has none" in page.until("notice")["text"]


def test_a_sound_that_is_dropped_can_stand_beside_the_stage(served) -> None:
    data = _write_sound(served.folder / "song.wav")
    answer = served.ask("/drop?name=my%20song.wav", method="POST", body=data, Origin=f"http://{served.host}")
    place = json.loads(answer.body)["path"]
    with served.ready_page() as page:
        page.edit(media={"path": place, "offset": None, "clock": "output"})
        page.told()
        assert served.ask("/media").body == data
        page.say("browse", folder=None, holds="media")
        assert page.until("listing")["files"] == ["song.wav"]


def test_the_page_knows_the_same_endings() -> None:
    script = WEB / "src" / "media" / "endings.ts"
    if not script.is_file():
        pytest.skip("there are no scripts of the page here")
    known, animations = (text.split("]")[0] for text in script.read_text(encoding="utf-8").split("= [")[1:])
    assert json.loads(f"[{known.strip().rstrip(',')}]") == [*VIDEO_SUFFIXES, *SOUND_SUFFIXES]
    assert json.loads(f"[{animations.strip()}]") == [*ANIMATION_SUFFIXES]
