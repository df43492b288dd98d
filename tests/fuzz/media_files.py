"""Mutants of video, animations, pictures and sound: each is retimed or described, or refused as retime refuses.

    python -m tests.fuzz.media_files --count 2000

Needs the extra ``video``. A process of its own opens each of them, which takes half a second a file; it may die of one,
but not of an error of our own. Nothing is left behind, and what is written can be read.
"""

from __future__ import annotations

import functools
import random
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

from retime.errors import FormatError
from retime.media.apply import retime_media
from retime.media.description import describe_media
from retime.media.features import video_signal
from retime.media.options import MediaOptions
from retime.warp.curve import Warp
from tests.fuzz.text_files import check
from tests.fuzz.trials import command, mutated_bytes
from tests.media import clips

# Starting a process may take its time on a busy machine, and a hanging one is waited for (retime.media.process).
MOST_SECONDS = 120
WARPS = (Warp([0, 0.2], [0, 0.4]), Warp([0, 0.3, 0.5, 0.6], [0, 0.3, 0.1, 0.1]), Warp([0, 0.5], [0.1, 0.2]))
# Endings, and what a file of them is retimed to.
KINDS = {
    "mp4": "mp4", "mkv": "mkv", "mov": "mkv", "avi": "avi", "ts": "ts", "webm": "mkv", "gif": "gif", "webp": "gif",
    "apng": "mkv", "wav": "wav", "flac": "wav", "ogg": "flac", "%03d.png": "gif",
}  # fmt: skip


@functools.cache
def whole_file(kind: str) -> bytes:
    """Return a small file of a kind; of numbered pictures, one of them."""
    sound = clips.sound(0.4)
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        path = Path(name) / f"a.{kind}"
        if kind in ("wav", "flac", "ogg"):
            clips.write_sound(path, sound, codec={"wav": "pcm_s16le", "flac": "flac", "ogg": "libopus"}[kind])
        elif kind == "%03d.png":
            import av

            path = Path(name) / "a.png"
            av.VideoFrame.from_ndarray(clips.picture(5, width=40, height=32), format="gray").save(str(path))
        elif kind in ("gif", "webp", "apng"):
            video = clips.write_clip(Path(name) / "v.mkv", 6, size=(40, 32))
            retime_media(video, path, Warp([0, 0.16], [0, 0.16]))
        else:
            codec = {"mkv": "ffv1", "webm": "libvpx", "avi": "mpeg4"}.get(kind, "libx264")
            heard = None if kind in ("avi", "webm") else sound
            clips.write_clip(path, 12, codec=codec, samples=heard, size=(40, 32), gop=4, sound_codec="aac")
        return path.read_bytes()


def trial(draw: random.Random) -> str:
    """Make a mutant, and have it read."""
    kind = draw.choice(list(KINDS))
    data = whole_file(kind)
    for _ in range(draw.choice([1, 1, 2, 5])):
        data = mutated_bytes(draw, data)
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        folder = Path(name)
        path = folder / f"a.{kind}"
        if kind == "%03d.png":
            for number in range(3):
                (folder / f"a.{number:03d}.png").write_bytes(data if number == 1 else whole_file(kind))
        else:
            path.write_bytes(data)
        before = sorted(folder.iterdir())
        try:
            return _done(draw, path, kind)
        except FormatError as error:
            refused = error
        # A signal ends it with a number below 0; 1 is how Python ends.
        assert "ends the program that does (1" not in str(refused), str(refused)
        assert sorted(folder.iterdir()) == before
        raise refused


def _done(draw: random.Random, path: Path, kind: str) -> str:
    what = draw.random()
    if what < 0.2:
        told = describe_media(path)
        assert told["streams"]
        return f"{kind} is described"
    if what < 0.3 and kind not in ("wav", "flac", "ogg"):
        check(video_signal(path))
        return f"{kind} is looked at"
    out = path.with_name(f"out.{KINDS[kind]}")
    options = MediaOptions(
        frames=draw.choice(["nearest", "blend", "flow"]),
        sound=draw.choice(["keep-pitch", "resample", "drop"]) if kind not in ("wav", "flac", "ogg") else "resample",
        offset=draw.choice([0.0, 0.0, -0.05, 0.1]),
    )
    retime_media(path, out, draw.choice(WARPS), options)
    (first, *_) = describe_media(out)["streams"]
    assert np.isfinite(first["seconds"])
    assert first["seconds"] < 5
    return f"{kind} is retimed"


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(command(trial, __doc__, most_seconds=MOST_SECONDS))
