"""The process that runs pxr, seen from here: it is asked for one thing after another, and its end is an error."""

from __future__ import annotations

import contextlib
import importlib.util
import json
import re
import subprocess
import sys
import tempfile
import threading
from dataclasses import asdict
from pathlib import Path
from types import TracebackType

from retime.child_process import child_environment
from retime.errors import FormatError, MissingExtraError
from retime.files import note_read
from retime.formats.curves.usd.exchange import NO_MEMORY, Message, receive, send
from retime.formats.read_options import Limits

_BYTES_A_SECOND = 1e6
# Where pxr would look for more of itself, and what would have it print.
_LEFT_OUT = ("PXR_", "USD_", "TF_", "SDF_", "AR_")


class Decoder:
    """A process that runs pxr, for a while.

    Parameters
    ----------
    limits : Limits
        Of sizes; they bound its memory too.
    seconds : float
        How long it may take for anything, and a second more for each megabyte.

    Raises
    ------
    MissingExtraError
        There is no usd-core.
    """

    def __init__(self, limits: Limits, seconds: float = 60.0) -> None:
        if importlib.util.find_spec("pxr") is None:
            raise MissingExtraError("a USD file", package="usd-core", extra="usd")
        self.limits, self._seconds = limits, seconds
        self.is_dead = False
        self._folder = tempfile.TemporaryDirectory(prefix="retime-usd-", ignore_cleanup_errors=True)
        environment = {name: value for name, value in child_environment().items() if not name.startswith(_LEFT_OUT)}
        environment["PXR_WORK_THREAD_LIMIT"] = "1"
        command = [
            sys.executable,
            "-m",
            "retime.formats.curves.usd.child",
            json.dumps(asdict(limits)),
            self._folder.name,
        ]
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
            cwd=self._folder.name,
        )

    def __enter__(self) -> Decoder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()
        self._folder.cleanup()

    def ask(self, request: Message, path: Path) -> Message:
        """Ask for something.

        Raises
        ------
        FormatError
            The file can't be read, or reading it ends the process, or takes for ever.
        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        seconds = self._seconds + sum(map(len, request.files.values())) / _BYTES_A_SECOND
        late = threading.Event()

        def end() -> None:
            late.set()
            self._process.kill()

        clock = threading.Timer(seconds, end)
        clock.daemon = True
        clock.start()
        answer = None
        try:
            send(request, self._process.stdin)
            answer = receive(self._process.stdout, self.limits.file_bytes + self.limits.inflated_bytes)
        except (OSError, FormatError):
            # It ended while it was spoken to, or in the middle of a word.
            self._process.kill()
        finally:
            clock.cancel()
        self.is_dead = answer is None
        if late.is_set():
            raise FormatError(f"a USD file that is not read after {seconds:.0f} s", path=path)
        if answer is None:
            code = self._process.wait()
            raise FormatError(f"a damaged USD file: reading it ends the program that does ({code})", path=path)
        self._note(answer, path)
        fault = answer.facts.get("fault")
        if fault is not None:
            raise FormatError(
                f"retime can't do this with the file, by a fault of its own and not of the file: {str(fault)[:1000]}; "
                "please report it, with the file if you may",
                path=path,
            )
        said = answer.facts.get("error")
        if said == NO_MEMORY:
            raise FormatError("a USD file that needs too much memory", path=path)
        if said is not None:
            # A place in the copy that was read is one in the file.
            told = re.sub(rf"{re.escape(self._folder.name)}/\d+/", "", str(said)[:1000])
            raise FormatError(told.replace(f": {path.name}:", ": line "), path=path)
        return answer

    def _note(self, answer: Message, path: Path) -> None:
        """Note which layers were read for a scene, as `noting_reads` has it."""
        read = answer.facts.get("read")
        for one in read if isinstance(read, list) else ():
            if isinstance(one, str) and not one.startswith(self._folder.name):
                found = Path(one)
                folder = path.parent.resolve()
                note_read(path.parent / found.relative_to(folder) if folder in found.parents else found)
