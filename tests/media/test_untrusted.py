"""Files from strangers: refused, or an error; never another file opened, nothing left behind."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import signal
import subprocess
import sys
import textwrap
import time
import warnings
from pathlib import Path

import numpy as np
import pytest

from retime.errors import FormatError, RetimeWarning
from retime.media import apply, process
from retime.media.kinds import refuse_references
from retime.warp.curve import Warp
from tests.media import clips

av = pytest.importorskip("av", reason="needs the extra 'video'")
for package in ("cv2", "python_stretch"):
    pytest.importorskip(package, reason="needs the extra 'video'")

pytestmark = [pytest.mark.extras, pytest.mark.filterwarnings("ignore:the warp (uses|reaches)")]

WARP = Warp([0, 1], [0, 1])
PLAYLISTS = {
    "hls": b"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\nother.mp4\n",
    "bom": b"\xef\xbb\xbf#EXTM3U\nother.mp4\n",
    "utf16": "#EXTM3U\nother.mp4\n".encode("utf-16"),
    "blanks": b"\n\n  #EXTM3U\nother.mp4\n",
    "concat": b"ffconcat version 1.0\nfile other.mp4\n",
    "concat without its head": b"# joined\nfile 'other.mp4'\n",
    "pls": b"[playlist]\nFile1=other.mp4\n",
    "asx": b"<ASX version='3'><entry><ref href='other.mp4'/></entry></ASX>",
    "dash": b"<?xml version='1.0'?>\n<MPD><BaseURL>other.mp4</BaseURL></MPD>",
    "smil": b"<smil><body><video src='other.mp4'/></body></smil>",
    "sdp": b"v=0\no=- 0 0 IN IP4 127.0.0.1\nm=video 1 RTP/AVP 96\n",
    "svg": b"<svg xmlns='http://www.w3.org/2000/svg'><image href='other.png'/></svg>",
    "address": b"http://example.com/take.mp4\n",
}


@pytest.mark.parametrize("kind", PLAYLISTS)
@pytest.mark.parametrize("name", ["take.mp4", "take.wav"])
def test_what_names_other_files_is_refused_by_its_content(tmp_path, kind, name) -> None:
    clips.write_clip(tmp_path / "other.mp4", 5, codec="libx264")
    (tmp_path / name).write_bytes(PLAYLISTS[kind])
    with pytest.raises(FormatError, match=r"not opened|expected video") as caught:
        apply.retime_media(tmp_path / name, tmp_path / "out.mp4", WARP)
    assert caught.value.path == str(tmp_path / name)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([name, "other.mp4"])


def test_a_movie_that_refers_to_another_opens_nothing(tmp_path) -> None:
    # QuickTime's reference: the samples lie in a file that an alias names.
    clip = clips.write_clip(tmp_path / "other.mov", 10, codec="libx264")
    data = bytearray(clip.read_bytes())
    at = data.find(b"url \0\0\0\x01")
    assert at > 0
    # An address in place of "the same file".
    data[at : at + 8] = b"url \0\0\0\0"
    (tmp_path / "take.mov").write_bytes(data)
    opened = _opened_by(tmp_path / "take.mov", tmp_path / "out.mov")
    assert tmp_path / "other.mov" not in opened


@pytest.mark.skipif(shutil.which("strace") is None, reason="needs strace")
def test_only_the_named_file_is_opened(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 10, samples=clips.sound(0.5))
    opened = _opened_by(clip, tmp_path / "o.mkv")
    own = {path for path in opened if tmp_path in path.parents}
    assert {path for path in own if not path.name.startswith(".retime-")} == {clip}


def _opened_by(clip: Path, out: Path) -> set[Path]:
    """Trace what the process opens once it has begun with the file; without strace nothing is known."""
    if shutil.which("strace") is None:
        with pytest.raises(FormatError):
            apply.retime_media(clip, out, WARP)
        return set()
    code = (
        "from retime import Warp; from retime.media.apply import retime_media; "
        f"retime_media({str(clip)!r}, {str(out)!r}, Warp([0, 1], [0, 1]))"
    )
    log = clip.parent / "trace.txt"
    subprocess.run(
        ["strace", "-f", "-e", "trace=openat,open", "-o", str(log), sys.executable, "-c", code],
        check=False,
        capture_output=True,
        timeout=120,
    )
    lines = [line for line in log.read_text().splitlines() if "ENOENT" not in line and '"' in line]
    log.unlink()
    return {Path(line.split('"')[1]) for line in lines}


def test_once_begun_the_process_can_open_nothing(tmp_path) -> None:
    code = textwrap.dedent(
        """
        from retime.media.child import _load_everything, _lock_up
        _load_everything()
        _lock_up(0)
        try:
            open("/dev/null")
        except OSError as error:
            print(error.errno)
        """
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == str(errno.EMFILE)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "empty"),
        (b"\x89PNG\r\n\x1a\n" + bytes(100), "can be read"),
        (bytes(5000), "can be read"),
        (b"just some words", "can be read"),
    ],
)
def test_what_is_no_video_is_refused(tmp_path, content, message) -> None:
    (tmp_path / "take.mp4").write_bytes(content)
    with pytest.raises(FormatError, match=message):
        apply.retime_media(tmp_path / "take.mp4", tmp_path / "o.mp4", WARP)
    assert [path.name for path in tmp_path.iterdir()] == ["take.mp4"]


def test_a_cut_file_ends_in_an_error_or_in_frames_and_a_warning(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 60, codec="libx264", gop=10)
    data = clip.read_bytes()
    (tmp_path / "cut.mkv").write_bytes(data[: len(data) // 2])
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        apply.retime_media(tmp_path / "cut.mkv", tmp_path / "o.mkv", Warp([0, 59 / 30], [0, 59 / 30]))
    assert any("runs from 0 to" in str(one.message) for one in caught)
    mp4 = clips.write_clip(tmp_path / "a.mp4", 60, codec="libx264").read_bytes()
    (tmp_path / "cut.mp4").write_bytes(mp4[: len(mp4) // 2])
    with pytest.raises(FormatError, match=r"cut\.mp4: no video"):
        apply.retime_media(tmp_path / "cut.mp4", tmp_path / "p.mp4", WARP)
    assert not (tmp_path / "p.mp4").exists()


@pytest.mark.parametrize("seed", range(6))
def test_damaged_files_end_in_an_error_or_an_output(tmp_path, seed) -> None:
    chance = np.random.default_rng(seed)
    name = ["a.mp4", "a.mkv", "a.avi", "a.gif", "a.webm", "a.wav"][seed]
    if name == "a.wav":
        clip = clips.write_sound(tmp_path / name, clips.sound(1.0))
    elif name == "a.gif":
        apply.retime_media(clips.write_clip(tmp_path / "b.mkv", 20), tmp_path / name, Warp([0, 0.6], [0, 0.6]))
        clip = tmp_path / name
    else:
        codec = {".mp4": "libx264", ".mkv": "ffv1", ".avi": "mpeg4", ".webm": "libvpx-vp9"}[Path(name).suffix]
        clip = clips.write_clip(tmp_path / name, 20, codec=codec)
    data = np.frombuffer(clip.read_bytes(), np.uint8)
    for _ in range(3):
        broken = data.copy()
        places = chance.integers(4, len(data), chance.integers(1, 40))
        broken[places] = chance.integers(0, 256, len(places))
        clip.write_bytes(broken.tobytes())
        out = tmp_path / f"out{clip.suffix}"
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RetimeWarning)
            # Whatever else is raised fails the test.
            with contextlib.suppress(FormatError):
                apply.retime_media(clip, out, Warp([0, 0.6], [0, 0.6]), overwrite=True)
        assert not list(tmp_path.glob(".retime*"))


@pytest.mark.parametrize("ending", ["dies", "hangs"])
def test_a_death_and_a_hang_end_as_errors(tmp_path, monkeypatch, ending) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 5)
    body = {"dies": "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "hangs": "import time; time.sleep(1000)"}
    monkeypatch.setattr(process, "_COMMAND", body[ending])
    monkeypatch.setattr(process, "MOST_STILL", 1.0)
    begun = time.monotonic()
    with pytest.raises(FormatError, match={"dies": "damaged file.*-11", "hangs": "nothing came of it"}[ending]):
        apply.retime_media(clip, tmp_path / "o.mkv", WARP)
    assert time.monotonic() - begun < 30
    assert [path.name for path in tmp_path.iterdir()] == ["a.mkv"]


@pytest.mark.skipif(sys.platform == "win32", reason="signals of POSIX")
def test_ctrl_c_leaves_nothing(tmp_path) -> None:
    clip = clips.write_clip(tmp_path / "a.mkv", 900, size=(640, 480), codec="libx264")
    Warp([0, 200.0], [0, 29.0]).save(tmp_path / "w.json")
    command = [
        sys.executable,
        "-m",
        "retime.cli.main",
        "apply",
        "w.json",
        clip.name,
        "-o",
        "o.mp4",
        "--between",
        "flow",
    ]
    running = subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.DEVNULL, start_new_session=True)
    deadline = time.monotonic() + 60
    while not any(path.stat().st_size for path in tmp_path.glob(".retime*")):
        assert running.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.05)
    os.killpg(running.pid, signal.SIGINT)
    assert running.wait(timeout=20) == 130
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.mkv", "w.json"]


def test_text_that_only_mentions_a_playlist_is_no_playlist() -> None:
    refuse_references(Path("a.wav"), b"RIFF....WAVEfmt #EXTM3U file ")
