"""A process that retimes clips and may die of them, and the end of it that its owner holds.

Files come from strangers: one may take all memory, end the process that reads it, or never end. A clip is therefore
done by a process of its own kind, started once and used for many clips; where it dies or takes too long, its owner
knows which clip it was at, and starts another.
"""

from __future__ import annotations

import contextlib
import json
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import IO, Any

from retime.batch.clip import failed, retime_clip
from retime.batch.task import ClipTask, Record, places_with
from retime.child_process import child_environment

# A clip of which so many processes have died is set aside.
TRIES = 3
# Ctrl-C is for the process that asks, which ends this one; a terminal sends it to all of them.
_CHILD = (
    "import signal, sys; signal.signal(signal.SIGINT, signal.SIG_IGN); from retime.batch.child import serve; "
    "serve(sys.argv[1], int(sys.argv[2]))"
)
# Seconds that a process may take to start.
_START = 120.0


class ChildRunner:
    """Hands clips to a process, one after the other.

    Parameters
    ----------
    out : Path
        The folder of all outputs, for the process's journal.
    most_memory : int, optional
        Bytes that the process may take.
    most_seconds : float
        That a clip may take.
    """

    def __init__(self, out: Path, *, most_memory: int | None, most_seconds: float) -> None:
        self._command = [sys.executable, "-c", _CHILD, str(out), str(most_memory or 0)]
        self._memory, self._seconds = most_memory or 0, most_seconds
        self._process: subprocess.Popen[bytes] | None = None
        self._answers: queue.Queue[bytes | None] = queue.Queue()
        self._ready = False

    def run(self, task: ClipTask) -> tuple[Record, ...]:
        """Do one clip, in a process that may die of it up to `TRIES` times."""
        begun = time.perf_counter()
        how = ""
        # Where nothing stood, what stands there after a process has died is its own.
        free = not any(
            os.path.lexists(Path(task.out, one)) for i in range(len(task.places)) for one in places_with(task, i)
        )
        for _ in range(TRIES):
            answer, how = self._ask(task)
            if answer is not None:
                records = tuple(Record.from_json(line) for line in answer)
                return tuple(self._of_memory(record) if record.code == "memory" else record for record in records)
            if how == "timeout":
                break
            task = replace(task, overwrite=task.overwrite or free)
        seconds = time.perf_counter() - begun
        if how == "timeout":
            message = f"not done after {self._seconds:g} s; its process was ended (--time-limit sets another)"
            return (failed(task, "timeout", message, seconds, limit=self._seconds),)
        message = f"{TRIES} processes died of it, the last one with {how}; it was set aside"
        return (failed(task, "killed", message, seconds),)

    def _of_memory(self, record: Record) -> Record:
        """Say by which bound a clip failed."""
        if not self._memory:
            return record
        message = f"{record.message}; it may take {self._memory / (1 << 30):.3g} GB (--memory sets another bound)"
        return replace(record, message=message, limit=float(self._memory))

    def _ask(self, task: ClipTask) -> tuple[list[dict[str, Any]] | None, str]:
        """Return what the process answers; None where it ends without, and how."""
        process = self._started()
        assert process.stdin is not None
        try:
            process.stdin.write(json.dumps(task.to_json()).encode() + b"\n")
            process.stdin.flush()
            if not self._ready:
                # It starts; that is no clip's time.
                self._ready = self._answers.get(timeout=max(self._seconds, _START)) is not None
                if not self._ready:
                    raise BrokenPipeError
            line = self._answers.get(timeout=self._seconds)
        except queue.Empty:
            self.close()
            return None, "timeout"
        except OSError:
            line = None
        if line is None:
            code = process.wait()
            self.close()
            return None, f"signal {-code}" if code < 0 else f"exit code {code}"
        return json.loads(line), ""

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is not None and self._process.poll() is None:
            return self._process
        self.close()
        environment = child_environment()
        # One clip is done by one thread of arithmetic: there are as many processes as processors.
        for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RETIME_THREADS"):
            environment.setdefault(name, "1")
        self._process = subprocess.Popen(
            self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment, bufsize=0
        )
        assert self._process.stdout is not None
        self._answers, self._ready = queue.Queue(), False
        threading.Thread(target=_listen, args=(self._process.stdout, self._answers), daemon=True).start()
        return self._process

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for stream in (process.stdin, process.stdout):
                if stream is not None:
                    stream.close()


def _listen(stream: IO[bytes], answers: queue.Queue[bytes | None]) -> None:
    """Put lines of a process into a queue, and None at its end."""
    buffered = b""
    while True:
        try:
            piece = os.read(stream.fileno(), 1 << 16)
        except (OSError, ValueError):
            piece = b""
        if not piece:
            answers.put(None)
            return
        buffered += piece
        *lines, buffered = buffered.split(b"\n")
        for line in lines:
            answers.put(line)


def serve(out: str, most_memory: int) -> None:
    """Do clips as they are asked for, until the owner is gone."""
    from retime.batch.manifest import Journal

    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    # Whatever else prints must not be taken for an answer.
    os.dup2(2, 1)
    if most_memory and sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_DATA, (most_memory, most_memory))
    asked: queue.Queue[Mapping[str, Any]] = queue.Queue()
    threading.Thread(target=_hear, args=(asked,), daemon=True).start()
    journal = Journal(Path(out))
    with contextlib.suppress(BrokenPipeError):
        answers.write(b"ready\n")
    while True:
        task = ClipTask.from_json(asked.get())
        records = retime_clip(task, begun=lambda task=task: journal.intend(task))  # type: ignore[misc]
        with contextlib.suppress(OSError):
            # The disk is full, say. The owner hears of them all the same.
            journal.written(records)
        try:
            answers.write(json.dumps([record.to_json() for record in records]).encode() + b"\n")
        except BrokenPipeError:
            # The owner went while this was at work; what was done is in the journal.
            return


def _hear(asked: queue.Queue[Mapping[str, Any]]) -> None:
    """Take orders; where the owner is gone, end at once, in the middle of a clip too: another will do it."""
    with os.fdopen(os.dup(0), "rb") as orders:
        for line in orders:
            asked.put(json.loads(line))
    os._exit(0)
