"""Having a process of its own do work on a media file, and passing on what it tells."""

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
from pathlib import Path
from typing import IO, Any

from retime.child_process import child_environment
from retime.errors import FormatError, MissingExtraError, OptionError, RetimeWarning
from retime.media.kinds import find_sequence, is_media, is_sequence, refuse_references
from retime.progress import look

FAILED = 7
"""How the process ends where it has said why."""

# Seconds without a sign of life after which a process hangs.
MOST_STILL = 60.0
_COMMAND = "from retime.media.child import main; main()"


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
    environment = child_environment()
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
        return MissingExtraError("work on video, pictures or sound", package=more["package"], extra=more["extra"])
    if kind == "MemoryError":
        return FormatError("it needs more memory than a file may", path=path)
    return FormatError(fact["text"], path=path)


def _ending(code: int, errors: IO[bytes]) -> str:
    """Say how a process ended."""
    errors.seek(0, os.SEEK_END)
    errors.seek(max(0, errors.tell() - 2000))
    lines = errors.read().decode("utf-8", "replace").strip().splitlines()
    return f"{code}{': ' + lines[-1][:200] if lines and code != FAILED else ''}"
