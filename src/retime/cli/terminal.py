"""What a person sees: lines of result, warnings, errors, and the stage at work."""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys
import threading
import time
import warnings
from collections.abc import Iterator, Sequence
from typing import Any, TextIO

import click

from retime.errors import RetimeWarning

_TICK = 0.2


def printable(text: str) -> str:
    """Escape control characters: a file's joint names must not steer the terminal."""
    if text.isprintable():
        return text
    return "".join(
        letter if letter.isprintable() or letter == "\n" else letter.encode("unicode_escape").decode()
        for letter in text
    )


def say(text: str) -> None:
    """Print a line of result."""
    _print(text, err=False)


def say_json(document: dict[str, Any]) -> None:
    """Print one JSON object, on one line."""
    say(json.dumps(document, allow_nan=False))


def say_table(rows: Sequence[tuple[str, str]]) -> None:
    """Print rows of a label and its text, in two columns."""
    width = max(len(label) for label, _ in rows)
    for label, text in rows:
        say(f"{label.ljust(width)}  {text}")


def report_error(message: str) -> None:
    """Print an error."""
    _print("error: " + message.replace("\n", "\n  "), err=True)


def _print(text: str, *, err: bool) -> None:
    stream = sys.stderr if err else sys.stdout
    text = printable(text)
    # A name may hold letters that this terminal's encoding lacks.
    encoding = getattr(stream, "encoding", None) or "utf-8"
    click.echo(text.encode(encoding, "backslashreplace").decode(encoding), err=err)


@contextlib.contextmanager
def showing_warnings() -> Iterator[None]:
    """Print each warning of retime's once, as a line on standard error; leave others to Python."""
    shown = set()
    with warnings.catch_warnings():
        warnings.filterwarnings("always", category=RetimeWarning)
        otherwise = warnings.showwarning

        def show(
            message: Warning | str,
            category: type[Warning],
            filename: str,
            lineno: int,
            file: TextIO | None = None,
            line: str | None = None,
        ) -> None:
            if not issubclass(category, RetimeWarning):
                otherwise(message, category, filename, lineno, file, line)
            elif str(message) not in shown:
                shown.add(str(message))
                live_line.clear()
                _print(f"warning: {message}", err=True)

        warnings.showwarning = show
        yield


class _LiveLine:
    """One line on a terminal that is written over and over."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._width = 0

    def show(self, text: str) -> None:
        with self._lock:
            self._write("\r" + text.ljust(self._width))
            self._width = len(text)

    def clear(self) -> None:
        with self._lock:
            if self._width:
                self._write("\r" + " " * self._width + "\r")
                self._width = 0

    def _write(self, text: str) -> None:
        # The terminal may be gone; that must not end the work.
        with contextlib.suppress(OSError, ValueError):
            sys.stderr.write(text)
            sys.stderr.flush()


live_line = _LiveLine()


def progress_text(doing: str, seconds: float, share: float) -> str:
    """Say how long something has taken, and, where it is known how much is done, how long it will still take.

    Examples
    --------
    >>> progress_text("reading", 3.2, math.nan), progress_text("writing", 30.0, 0.25)
    ('reading 3 s', 'writing 30 s, 25 %, about 90 s left')
    """
    if math.isnan(share):
        return f"{doing} {seconds:.0f} s"
    left = f", about {seconds * (1 - share) / share:.0f} s left" if share >= 0.01 and seconds >= 1 else ""
    return f"{doing} {seconds:.0f} s, {share:.0%}{left}".replace("%", " %")


class Stages:
    """Times the stages of a command; on a terminal, names the one at work.

    Attributes
    ----------
    seconds : dict of str to float
        Time spent in each.
    """

    def __init__(self, *, quiet: bool = False) -> None:
        self.seconds: dict[str, float] = {}
        self._begun = time.perf_counter()
        # Of the stage at work, where it tells.
        self._share = math.nan
        self._live = not quiet and sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") != "dumb"

    def elapsed(self) -> float:
        """Return the seconds since the command began its work."""
        return time.perf_counter() - self._begun

    @contextlib.contextmanager
    def stage(self, name: str, doing: str) -> Iterator[None]:
        """Time a stage under `name`, shown as `doing`."""
        start = time.perf_counter()
        done = threading.Event()
        self._share = math.nan
        ticker = threading.Thread(target=self._tick, args=(doing, start, done), daemon=True)
        if self._live:
            ticker.start()
        try:
            yield
        finally:
            if self._live:
                done.set()
                ticker.join()
                live_line.clear()
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start

    def tell(self, share: float) -> None:
        """Take how much of the stage at work is done (`retime.progress`)."""
        if not math.isnan(share):
            self._share = share

    def _tick(self, doing: str, start: float, done: threading.Event) -> None:
        while True:
            live_line.show(progress_text(doing, time.perf_counter() - start, self._share))
            if done.wait(_TICK):
                return
