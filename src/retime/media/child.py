"""The process that opens a media file: bounded in memory, able to open nothing else, free to die.

It takes a job as JSON on its standard input, whose end tells it that nobody waits any more, and tells what it does in
lines of JSON on its standard output.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import pkgutil
import signal
import sys
import tempfile
import threading
import time
import traceback
import warnings
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO

from retime.errors import FormatError, MissingExtraError, RetimeError, words_of
from retime.media.process import FAILED

# Bytes that it may have: programs and threads, and, of the media, some hundreds of frames in all.
MOST_MEMORY = 5 << 30
# Seconds between two signs of life.
_TICK = 0.1


def main() -> None:
    """Do the job that the standard input names."""
    with contextlib.suppress(ValueError, OSError):
        # Ctrl-C is for the process that waits, which then ends this one.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    channel = os.fdopen(os.dup(1), "w", encoding="utf-8")
    # What libraries print is no part of what is told.
    os.dup2(2, 1)
    job = json.loads(_first_line())
    threading.Thread(target=_end_with_parent, daemon=True).start()
    tell = _Teller(channel)
    try:
        _DOES[job["do"]](job, tell)
    except BaseException as raised:
        error = raised
        if type(error).__module__.startswith("av."):
            # What is damaged of the input is met where it is read; this is what an encoder or a container says.
            log = getattr(error, "log", None)
            said = log[2] if log else words_of(error)
            error = FormatError(f"it can't be written so: {said}", path=job.get("place"))
        if isinstance(error, RetimeError | OSError | MemoryError):
            tell({"error": type(error).__name__, "text": words_of(error), "more": _more(error)})
            channel.flush()
            os._exit(FAILED)
        # Not waiting for threads, as an ending by itself would.
        traceback.print_exc()
        sys.stderr.flush()
        os._exit(1)
    tell({"done": 1})
    channel.flush()
    # Threads of codecs that still wait for something must not keep it.
    os._exit(0)


def _more(error: BaseException) -> dict[str, Any]:
    if isinstance(error, FormatError):
        return {"problem": error.problem, "path": error.path}
    if isinstance(error, MissingExtraError):
        return {"package": error.package, "extra": error.extra}
    return {}


def _first_line() -> bytes:
    """Read the standard input to the end of its first line."""
    parts: list[bytes] = []
    while not (parts and parts[-1].endswith(b"\n")):
        part = os.read(0, 1 << 16)
        if not part:
            os._exit(1)
        parts.append(part)
    return b"".join(parts)


def _end_with_parent() -> None:
    """End where the process that asked has ended: its end of the pipe is closed then."""
    while os.read(0, 1):
        pass
    os._exit(1)


class _Teller:
    """Writes facts; what is told more often than anybody looks is left out."""

    def __init__(self, channel: Any) -> None:
        self._channel, self._lock = channel, threading.Lock()
        self._last = 0.0

    def __call__(self, fact: dict[str, Any]) -> None:
        now = time.monotonic()
        frequent = "beat" in fact or "share" in fact
        with self._lock:
            if frequent and now - self._last < _TICK:
                return
            if frequent:
                self._last = now
            try:
                self._channel.write(json.dumps(fact) + "\n")
                self._channel.flush()
            except OSError:
                os._exit(1)


def _lock_up(spare: int) -> None:
    """Bound the memory, and let no more files be opened than are open by now and some that are `spare`."""
    if sys.platform == "win32":
        return
    import resource

    for limit, most in ((resource.RLIMIT_AS, MOST_MEMORY), (resource.RLIMIT_CORE, 0)):
        with contextlib.suppress(ValueError, OSError):
            hard = resource.getrlimit(limit)[1]
            resource.setrlimit(limit, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    # The lowest number that is free is the one that the next file would get.
    free = os.open(os.devnull, os.O_RDONLY)
    os.close(free)
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_NOFILE, (free + spare, free + spare))


def _load_everything() -> None:
    """Import what will be used, while files can still be opened."""
    from retime.media import encoding, losses, mixing, reader, sound_reader, work  # noqa: F401
    from retime.media.extras import needed

    # First that which reads no file of its own: its threads start with it.
    needed("cv2").setNumThreads(1)
    av = needed("av")
    av.logging.set_level(av.logging.PANIC)
    # Parts of it are imported when a stream of their kind is met.
    for module in pkgutil.walk_packages(av.__path__, "av."):
        # The one that fetches samples from the network is the slowest to import, and nobody's business here.
        if not module.name.endswith(("__main__", ".datasets")):
            with contextlib.suppress(ImportError):
                importlib.import_module(module.name)
    # And so does NumPy.
    for name in ("ma", "random", "fft", "linalg", "polynomial", "lib.stride_tricks"):
        importlib.import_module(f"numpy.{name}")


def _retime(job: dict[str, Any], tell: _Teller) -> None:
    """Retime a file into one that is there, empty."""
    _load_everything()
    from retime.media.extras import needed
    from retime.media.job import Job, OtherSound, Report
    from retime.media.kinds import is_sequence
    from retime.media.options import MediaOptions
    from retime.media.work import MOST_SOUNDS, retime_file
    from retime.warp.curve import Warp

    options = MediaOptions.from_json(job["options"])
    if options.sound == "keep-pitch":
        try:
            needed("python_stretch")
        except MissingExtraError:
            if not job["only_pictures"]:
                raise
    path = Path(job["path"])
    sound = None
    if job.get("sound") is not None:
        sound = OtherSound(Path(job["sound"]["path"]), Warp.from_json(job["sound"]["warp"]))
    with Path(job["beside"]).open("r+b") as target, contextlib.ExitStack() as stack:
        source = None if is_sequence(path) else stack.enter_context(path.open("rb"))
        heard = None if sound is None else stack.enter_context(sound.path.open("rb"))
        # Sound is decoded onto the disk, a stream a file.
        spools: list[BinaryIO] = [stack.enter_context(tempfile.TemporaryFile()) for _ in range(MOST_SOUNDS)]
        # Numbered pictures are opened one at a time.
        _lock_up(2 if source is None else 0)
        warnings.simplefilter("ignore")
        made = Job(path, Path(job["place"]), Warp.from_json(job["warp"]), options, sound)
        retime_file(made, source, target, spools, Report(tell), heard)
        target.flush()


def _features(job: dict[str, Any], tell: _Teller) -> None:
    """Tell what moves in a video."""
    _load_everything()
    from retime.media.features import find_features

    _look(job, tell, find_features)


def _describe(job: dict[str, Any], tell: _Teller) -> None:
    """Tell what a file holds."""
    _load_everything()
    from retime.media.description import tell_description

    _look(job, tell, tell_description)


def _look(job: dict[str, Any], tell: _Teller, look: Callable[..., None]) -> None:
    """Lock the process up with one file in it, and tell what is found there."""
    from retime.media.job import Report
    from retime.media.kinds import is_sequence

    path = Path(job["path"])
    fps = None if job["fps"] is None else Fraction(job["fps"])
    with contextlib.ExitStack() as stack:
        source = None if is_sequence(path) else stack.enter_context(path.open("rb"))
        # Numbered pictures are opened one at a time.
        _lock_up(2 if source is None else 0)
        look(path, source, fps, Report(tell))


def _sound(job: dict[str, Any], tell: _Teller) -> None:
    """Write a file's sound as plain samples."""
    _load_everything()
    from retime.media.beats import write_samples
    from retime.media.job import Report

    path = Path(job["path"])
    with path.open("rb") as source, Path(job["beside"]).open("wb") as target, tempfile.TemporaryFile() as spool:
        _lock_up(0)
        write_samples(path, source, target, spool, Report(tell))


_DOES = {"sound": _sound, "retime": _retime, "features": _features, "describe": _describe}

if __name__ == "__main__":
    main()
