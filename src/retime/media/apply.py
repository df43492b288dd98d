"""`retime_media`: a video, numbered pictures or sound with a warp's timing."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import IO, Any

from retime.checks import path_of
from retime.errors import FormatError, MissingExtraError, OptionError, OutputExistsError, RetimeWarning
from retime.files import beside, resolved, write_bytes
from retime.media.child import FAILED
from retime.media.encoding import CONTAINERS
from retime.media.extras import needed
from retime.media.kinds import find_sequence, is_media, is_sequence, refuse_references
from retime.media.options import MediaOptions
from retime.progress import look
from retime.warp.curve import WarpLike, as_warp

# Seconds without a sign of life after which a process hangs.
MOST_STILL = 60.0
_COMMAND = "from retime.media.child import main; main()"


def retime_media(
    path: str | PathLike[str],
    place: str | PathLike[str],
    warp: WarpLike,
    options: MediaOptions | None = None,
    *,
    overwrite: bool = False,
) -> None:
    """Give a video, its sound, numbered pictures, or sound alone a warp's timing.

    Frames are shown where the warp has them, and averaged where it plays faster than life, as motions are (§3.4); sound
    is stretched with its pitch kept. The output appears whole or not at all. The work is done in a process of its own,
    which can open no other file and may die of a damaged one.

    Parameters
    ----------
    path : path-like
        The input. ``take.%04d.png`` stands for numbered pictures.
    place : path-like
        The output; its ending says what it is.
    warp : Warp or GuidedWarp
        From output time to input time. Its input time 0 is the moment of the first frame (or sample), `options.offset`
        aside.
    options : MediaOptions, optional
        How.
    overwrite : bool
        Replace what is there.

    Raises
    ------
    FormatError
        The file is not what it should be, is damaged, or names other files; or the output can't hold this.
    OutputExistsError
        The output is there, and `overwrite` is not set.
    OptionError
        Options that contradict each other or the file.
    MissingExtraError
        There is no PyAV, OpenCV or python-stretch.
    OSError
        A file can't be read or written.

    Warns
    -----
    RetimeWarning
        The warp and the file don't cover the same times, or something of the file can't be kept.
    """
    path, place = path_of(path, "retime_media(path, place, warp)"), path_of(place, "retime_media(path, place, warp)")
    warp = as_warp(warp, "retime_media(path, place, warp)")
    options = options or MediaOptions()
    for module in ("av", "cv2"):
        needed(module)
    check_media(path)
    if not (is_sequence(place) or place.suffix.lower() in CONTAINERS):
        raise FormatError(
            f"nothing here writes {place.suffix or 'a file without an ending'}; known endings are "
            f"{', '.join(CONTAINERS)}, and numbered pictures (take.%04d.png)",
            path=place,
        )
    request = {
        "do": "retime",
        "path": str(resolved(path)),
        "place": str(place),
        "warp": replace(warp, name="").to_json(),
        "options": options.to_json(),
        "only_pictures": is_sequence(path),
        # Streams of sound that may be spooled.
        "n_spooled": 16,
    }
    if is_sequence(place):
        _write_pictures(path, place, request, overwrite=overwrite)
        return
    with beside(place, overwrite=overwrite) as file:
        run({**request, "beside": file.name}, path)


def check_media(path: Path) -> None:
    """Refuse what is no media file, by its name and its first bytes; raise FormatError or OSError."""
    if is_sequence(path):
        find_sequence(path)
        return
    if not is_media(path):
        raise FormatError(
            f"nothing here reads {path.suffix or 'a file without an ending'} as video or sound", path=path
        )
    if path.exists() and not path.is_file():
        raise FormatError("this is not a regular file", path=path)
    with path.open("rb") as file:
        refuse_references(path, file.read(1 << 16))


def _write_pictures(path: Path, place: Path, request: dict[str, Any], *, overwrite: bool) -> None:
    """Have pictures written into one temporary file, then each put into its place."""
    found: list[tuple[str, int]] = []

    def take(fact: dict[str, Any]) -> None:
        if "picture" in fact:
            found.append((fact["picture"][0], fact["picture"][1]))

    with tempfile.NamedTemporaryFile(dir=place.parent, prefix=".retime-", suffix=".tmp") as file:
        run({**request, "beside": file.name}, path, take)
        places = [place.with_name(name) for name, _ in found]
        if not overwrite:
            for one in places:
                if one.exists():
                    raise OutputExistsError(one)
        written: list[Path] = []
        try:
            for one, (_, size) in zip(places, found, strict=True):
                new = not one.exists()
                write_bytes(one, file.read(size), overwrite=overwrite)
                if new:
                    written.append(one)
        except BaseException:
            for one in written:
                one.unlink(missing_ok=True)
            raise


def run(request: dict[str, Any], path: Path, take: Callable[[dict[str, Any]], None] | None = None) -> None:
    """Have a process do a job, and pass on what it tells.

    Parameters
    ----------
    request : dict
        The job, as `retime.media.child` takes it.
    path : Path
        The file, for messages.
    take : function, optional
        Gets every fact that is told.

    Raises
    ------
    FormatError
        The file ends the process, or it hangs; and whatever the process raises.
    """
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with tempfile.TemporaryFile() as errors:
        process = subprocess.Popen(
            [sys.executable, "-c", _COMMAND],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            env=environment,
        )
        try:
            assert process.stdin is not None
            assert process.stdout is not None
            with contextlib.suppress(BrokenPipeError):
                process.stdin.write(json.dumps(request).encode() + b"\n")
                process.stdin.flush()
            failure = None
            for fact in _facts(process.stdout, path):
                if take is not None:
                    take(fact)
                if "share" in fact:
                    look(float(fact["share"]))
                elif "warning" in fact:
                    warnings.warn(fact["warning"], RetimeWarning, stacklevel=3)
                elif "error" in fact:
                    failure = _error(fact, path)
                elif not fact:
                    look()
            code = process.wait()
        finally:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    with contextlib.suppress(OSError):
                        pipe.close()
        if failure is not None:
            raise failure
        if code:
            raise FormatError(
                f"a damaged file: reading it ends the program that does ({_ending(code, errors)})", path=path
            )


def _facts(stream: IO[bytes], path: Path) -> Iterator[dict[str, Any]]:
    """Take what a process tells; an empty fact now and then, for whoever watches; raise FormatError where it hangs."""
    told: queue.Queue[bytes | None] = queue.Queue()

    def listen() -> None:
        with contextlib.suppress(OSError, ValueError):
            for line in stream:
                told.put(line)
        told.put(None)

    threading.Thread(target=listen, daemon=True).start()
    last = time.monotonic()
    while True:
        try:
            line = told.get(timeout=0.1)
        except queue.Empty:
            if time.monotonic() - last > MOST_STILL:
                raise FormatError(
                    f"nothing came of it for {MOST_STILL:.0f} s: a damaged file, or one too large for this machine",
                    path=path,
                ) from None
            yield {}
            continue
        if line is None:
            return
        last = time.monotonic()
        yield json.loads(line)


def _error(fact: dict[str, Any], path: Path) -> BaseException:
    """Make the error that another process raised."""
    kind, more = fact["error"], fact["more"]
    if kind == "FormatError":
        return FormatError(more["problem"], path=more["path"])
    if kind == "OptionError":
        return OptionError(fact["text"])
    if kind == "MissingExtraError":
        return MissingExtraError("video, pictures and sound", package=more["package"], extra=more["extra"])
    if kind == "MemoryError":
        return FormatError("it needs more memory than a file may", path=path)
    return FormatError(fact["text"], path=path)


def _ending(code: int, errors: IO[bytes]) -> str:
    """Say how a process ended."""
    errors.seek(0, os.SEEK_END)
    errors.seek(max(0, errors.tell() - 2000))
    lines = errors.read().decode("utf-8", "replace").strip().splitlines()
    return f"{code}{': ' + lines[-1][:200] if lines and code != FAILED else ''}"
