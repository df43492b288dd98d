"""What the fuzz scripts share: trials of a seed each, their ends counted, and what must not be told with its seed.

A trial ends in what it names, or in an error that retime raises on purpose. Any other error is a fault; so is a warning
of NumPy's, a number that is not finite, a trial that takes longer than it may, or more memory, and one that ends the
process.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import mmap
import os
import random
import re
import select
import signal
import struct
import sys
import tempfile
import threading
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from retime.errors import RetimeError, RetimeWarning

MOST_SECONDS = 10
MOST_BYTES = 1 << 30
ODD_NUMBERS = [0, -0.0, -1, 1, 2, 0.5, 5e-324, 1e-300, 1e-12, 1e6, 1e7, 1e9, 2**31, 2**53, 2**64, 1e77, 1e100, 1.7e308]
# A process that sleeps for so long is asleep for good, however busy the machine is.
_ASLEEP = 600
# How often a long run says how far it is.
_PRINT_SECONDS = 60

Trial = Callable[[random.Random], str]
"""Does one thing, and says how it ended."""


class TooLongError(BaseException):
    """A trial took longer than it may. No `except Exception` takes it for an error of its own."""


@dataclass
class Tally:
    """How trials ended.

    Attributes
    ----------
    ends : Counter of str
        What they named, or the name of the error.
    faults : dict of int to str
        By the seed, what must not be.
    slowest : tuple of (float, int)
        Seconds, and the seed.
    seconds : float
        All of them together.
    peak : int
        Bytes that a process held at most, where the system tells.
    """

    ends: Counter[str] = field(default_factory=Counter)
    faults: dict[int, str] = field(default_factory=dict)
    slowest: tuple[float, int] = (0.0, 0)
    seconds: float = 0.0
    peak: int = 0

    def add(self, other: Tally) -> None:
        """Take in the ends of other trials."""
        self.ends += other.ends
        self.faults |= other.faults
        self.slowest = max(self.slowest, other.slowest)
        self.seconds += other.seconds
        self.peak = max(self.peak, other.peak)


@contextlib.contextmanager
def time_limit(seconds: int, *, processor: bool = False) -> Iterator[None]:
    """Raise TooLongError after so many seconds, where alarms are to be had: in the main thread, not on Windows.

    Seconds are those of a clock on the wall, or those that this process was at work.
    """
    if not hasattr(signal, "SIGALRM") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def ring(*_: object) -> None:
        raise TooLongError(f"more than {seconds} s")

    number, timer = (signal.SIGPROF, signal.ITIMER_PROF) if processor else (signal.SIGALRM, signal.ITIMER_REAL)
    before = signal.signal(number, ring)
    signal.setitimer(timer, seconds)
    try:
        yield
    finally:
        signal.setitimer(timer, 0)
        signal.signal(number, before)


def run(
    trial: Trial,
    seeds: Iterable[int],
    *,
    most_seconds: int = MOST_SECONDS,
    processor: bool = False,
    begins: Callable[[int], None] = lambda seed: None,
) -> Tally:
    """Run trials; each is made of its own seed alone, so that one that fails can be tried again.

    Parameters
    ----------
    trial : callable
        What is tried.
    seeds : iterable of int
        A trial each.
    most_seconds : int
        What a trial may take.
    processor : bool
        Count the time that this process is at work, and not what passes while others are, or while it waits.
    begins : callable
        Told each seed before its trial.
    """
    tally = Tally()
    clock = time.process_time if processor else time.perf_counter
    for seed in seeds:
        begins(seed)
        begun = clock()
        try:
            with time_limit(most_seconds, processor=processor), warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.simplefilter("ignore", RetimeWarning)
                end = trial(random.Random(seed))
        except TimeoutError as error:
            # An error of the system's by its kind, but nothing here ends by it: somebody waited for what never came.
            end = "fault"
            tally.faults[seed] = f"waited in vain: {str(error)[:200]}\n{_place(error)}"
        except (RetimeError, OSError) as error:
            end = type(error).__name__
            if len(str(error)) > 2000:
                tally.faults[seed] = f"a message of {len(str(error))} letters"
        except (Exception, TooLongError) as error:
            end = "fault"
            tally.faults[seed] = f"{type(error).__name__}: {str(error)[:200]}\n{_place(error)}"
        seconds = clock() - begun
        tally.ends[end] += 1
        tally.seconds += seconds
        tally.slowest = max(tally.slowest, (seconds, seed))
    return tally


def _place(error: BaseException) -> str:
    return "".join(traceback.format_tb(error.__traceback__)[-3:])


def run_apart(
    trial: Trial,
    seeds: range,
    *,
    most_seconds: int = MOST_SECONDS,
    most_bytes: int | None = MOST_BYTES,
    block: int = 10_000,
    told: Callable[[range, Tally], None] = lambda seeds, tally: None,
) -> Tally:
    """Run trials in processes of their own, a block of seeds each, so that one that ends its process is noticed too.

    Parameters
    ----------
    trial, seeds, most_seconds
        As of `run`; seconds are those of the processor.
    most_bytes : int, optional
        What trials may hold beyond what the process held before them. None for those that start processes, which would
        be bounded too.
    block : int
        Seeds of a process.
    told : callable
        Told each block when it is done, and how it ended.
    """
    if not hasattr(os, "fork"):
        return run(trial, seeds, most_seconds=most_seconds, processor=True)
    whole = Tally()
    waiting = [seeds[at : at + block] for at in range(0, len(seeds), block)][::-1]
    while waiting:
        part = waiting.pop()
        ended = _in_a_process(trial, part, most_seconds, most_bytes)
        if isinstance(ended, Tally):
            whole.add(ended)
            told(part, ended)
            continue
        # What was counted died with the process: all before the seed that ended it is done again, and all behind it.
        died_at, how = ended
        fault = Tally(Counter(fault=1), {died_at: how})
        whole.add(fault)
        told(range(died_at, died_at + 1), fault)
        waiting += [rest for rest in (range(died_at + 1, part.stop), range(part.start, died_at)) if rest]
    return whole


def _in_a_process(trial: Trial, seeds: range, most_seconds: int, most_bytes: int | None) -> Tally | tuple[int, str]:
    """Run trials in a fork of this process; where it dies, return the seed at which it did, and how."""
    sys.stdout.flush()
    sys.stderr.flush()
    at = mmap.mmap(-1, 8)
    source, sink = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(source)
        try:
            if most_bytes is not None:
                _bound_memory(most_bytes)
            # A loop in compiled code sees no handler: the second clock ends the process.
            signal.signal(signal.SIGVTALRM, signal.SIG_DFL)

            def begins(seed: int) -> None:
                at[:] = struct.pack("<q", seed)
                signal.setitimer(signal.ITIMER_VIRTUAL, 2 * most_seconds)

            tally = run(trial, seeds, most_seconds=most_seconds, processor=True, begins=begins)
            tally.peak = _most_held()
            with os.fdopen(sink, "w") as told:
                json.dump(tally.__dict__, told)
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(0)
    os.close(sink)
    text, asleep = b"", False
    seen, since = b"", time.monotonic()
    while True:
        if select.select([source], [], [], 5)[0]:
            piece = os.read(source, 1 << 16)
            if not piece:
                break
            text += piece
        elif at[:] != seen:
            seen, since = at[:], time.monotonic()
        elif time.monotonic() - since > _ASLEEP:
            asleep = True
            os.kill(child, signal.SIGKILL)
            break
    os.close(source)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if text and not asleep:
        told = json.loads(text)
        return Tally(
            Counter(told["ends"]),
            {int(seed): fault for seed, fault in told["faults"].items()},
            tuple(told["slowest"]),
            told["seconds"],
            told["peak"],
        )
    how = f"nothing came of it for {_ASLEEP} s" if asleep else f"it ended the process, with {code}"
    return struct.unpack("<q", at[:])[0], how


def _bound_memory(most_bytes: int) -> None:
    """Let this process hold so much more than it does; what asks for more fails."""
    try:
        import resource

        pages = int(Path("/proc/self/statm").read_text().split()[0])
    except (ImportError, OSError):
        return
    most = pages * resource.getpagesize() + most_bytes
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


def _most_held() -> int:
    """Return the bytes that this process held at most; 0 where the system does not tell."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return 0
    return 1024 * int(next(line for line in lines if line.startswith("VmHWM:")).split()[1])


def arguments(description: str | None) -> argparse.ArgumentParser:
    """Return a parser of what every script may be told."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1, help="the first one")
    parser.add_argument("--only", type=int, help="try one seed again")
    parser.add_argument("--block", type=int, default=5000, help="seeds of one process, where trials have some")
    return parser


def command(trial: Trial, description: str | None, *, most_seconds: int = MOST_SECONDS) -> int:
    """Run as many trials as a command line asks for; return its exit code."""
    given = arguments(description).parse_args()
    seeds = [given.only] if given.only is not None else range(given.seed, given.seed + given.count)
    return tell(run(trial, seeds, most_seconds=most_seconds))


def command_apart(trial: Trial, description: str | None, *, name: str, most_bytes: int | None = MOST_BYTES) -> int:
    """Do as `command`, in processes of their own; see `run_apart`."""
    return run_told(trial, arguments(description).parse_args(), name=name, most_bytes=most_bytes)


def run_told(trial: Trial, given: argparse.Namespace, *, name: str, most_bytes: int | None = MOST_BYTES) -> int:
    """Run trials in processes of their own, and print how far they are and what is wrong; return an exit code."""
    seeds = range(given.seed, given.seed + given.count) if given.only is None else range(given.only, given.only + 1)
    begun = told_at = time.monotonic()

    def told(part: range, tally: Tally) -> None:
        nonlocal told_at
        for seed, fault in tally.faults.items():
            print(f"{name}, seed {seed}: {fault}", flush=True)
        if time.monotonic() - told_at > _PRINT_SECONDS:
            told_at = time.monotonic()
            print(f"{name}: done up to seed {part.stop - 1}", flush=True)

    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as folder:
        # What a process that died has left goes with it.
        tempfile.tempdir = folder
        tally = run_apart(trial, seeds, most_bytes=most_bytes, block=given.block, told=told)
        tempfile.tempdir = None
    print(
        f"{name}, seeds {seeds.start} to {seeds.stop - 1}: {tally.seconds:.0f} s of the processor in "
        f"{time.monotonic() - begun:.0f} s, at most {tally.peak / 2**20:.0f} MB"
    )
    tally.faults = {seed: fault.partition("\n")[0] for seed, fault in tally.faults.items()}
    return tell(tally)


def tell(tally: Tally) -> int:
    """Print how trials ended; return the exit code that says it."""
    for seed, fault in tally.faults.items():
        print(f"seed {seed}: {fault}")
    slowest, seed = tally.slowest
    print(f"{sum(tally.ends.values())} trials, {len(tally.faults)} faults; slowest {slowest:.2f} s (seed {seed})")
    print(", ".join(f"{end} {count}" for end, count in tally.ends.most_common()), flush=True)
    return 1 if tally.faults else 0


# Mutations of text, bytes and JSON.


def mutated_text(draw: random.Random, text: bytes, words: Sequence[bytes] = (), others: Sequence[bytes] = ()) -> bytes:
    """Change a text in a few places: its numbers, words, lines, stretches and bytes.

    Parameters
    ----------
    draw : random.Random
        What it is drawn from.
    text : bytes
        What is changed.
    words : sequence of bytes
        Words of its grammar, to be put where they don't belong.
    others : sequence of bytes
        Texts of its kind: the front of it is now and then followed by the back of one of them.
    """
    for _ in range(draw.choice([1, 1, 1, 2, 4])):
        # Numbers more often than all else: they leave the rest whole, and more of it is come to.
        kind = draw.choice([0, 1, 2, 3, 3, 3, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13])
        if kind < 4:
            text = _with_other_word(draw, text, kind, words)
        elif kind < 8:
            lines = text.splitlines(keepends=True) or [b""]
            at, other = draw.randrange(len(lines)), draw.randrange(len(lines))
            if kind == 4:
                del lines[at]
            elif kind == 5:
                lines.insert(at, lines[other])
            elif kind == 6:
                lines[at], lines[other] = lines[other], lines[at]
            else:
                lines = [*lines[:at], *(draw.choice(others).splitlines(keepends=True)[other:] if others else ())]
            text = b"".join(lines)
        elif kind < 11:
            text = mutated_bytes(draw, text)
        else:
            text = _with_other_stretch(draw, text, kind, words, others)
    return text


_WORD = re.compile(rb"[^\s,;:=\"'{}()<>\[\]]+")
_NUMBER = re.compile(rb"[+-]?[0-9]+(?:[.,][0-9]*)?(?:[eE][+-]?[0-9]+)?|[+-]?\.[0-9]+")


def _with_other_word(draw: random.Random, text: bytes, kind: int, words: Sequence[bytes]) -> bytes:
    """Exchange a word: for an odd one, another of the text, nothing; or a number for an odd one, or one like it."""
    found = list((_NUMBER if kind == 3 else _WORD).finditer(text))
    if not found:
        return text + draw.choice(_ODD_WORDS)
    match = draw.choice(found)
    if kind == 0:
        new = draw.choice(words) if words and draw.random() < 0.6 else draw.choice(_ODD_WORDS)
    elif kind == 1:
        new = draw.choice(found)[0]
    elif kind == 2:
        new = b""
    else:
        new = _odd_number(draw, match[0])
    return text[: match.start()] + new + text[match.end() :]


def _odd_number(draw: random.Random, written: bytes) -> bytes:
    """Write a number that is odd, or that is like another."""
    how = draw.randrange(6)
    if how == 0:
        return repr(draw.choice(ODD_NUMBERS)).encode()
    if how == 1:
        return str(draw.randint(-3, 300)).encode()
    if how == 2:
        return b"-" + written
    if how == 3:
        return written + draw.choice([b"0", b"e5", b"e-5", b".5", b"e308", b"9" * 30, b"-1", b"%", b"s", b"f"])
    if how == 4:
        return written[:-1] + draw.choice([b"0", b"1", b"5", b"9"])
    return draw.choice([b"2000000000", b"4294967296", b"65536", b"99999999999999999999", b"1e1000", b"0x10", b"1_0"])


def _with_other_stretch(
    draw: random.Random, text: bytes, kind: int, words: Sequence[bytes], others: Sequence[bytes]
) -> bytes:
    """Exchange two stretches, put a word anywhere, or go on with the back of another text."""
    first, last = sorted((draw.randint(0, len(text)), draw.randint(0, len(text))))
    if kind == 11:
        middle = draw.randint(first, last)
        return text[:first] + text[middle:last] + text[first:middle] + text[last:]
    if kind == 12 or not others:
        return text[:first] + draw.choice([*words, *_ODD_WORDS]) + text[first:]
    other = draw.choice(others)
    return text[:first] + other[draw.randint(0, len(other)) :]


_ODD_WORDS = [b"nan", b"-inf", b"1_0", b"1e999", b"0x10", b"\xd9\xa1", b"1,5", b"--1", b"{", b"}", b"", b"\x00", b'"']
_ODD_WORDS += [b"JOINT", b"CHANNELS", b"ROOT", b"End Site", b"OFFSET", b":degrees", b"2000000000", b"-5", b"\xff\xfe"]


def mutated_bytes(draw: random.Random, data: bytes) -> bytes:
    """Change bytes: one, a few, a number of four; or cut, or double a stretch."""
    if not data:
        return draw.randbytes(draw.randint(0, 8))
    changed = bytearray(data)
    place, length = draw.randrange(len(data)), draw.choice([1, 2, 4, 8, 64])
    kind = draw.randrange(5)
    if kind == 0:
        changed[place] ^= 1 << draw.randrange(8)
    elif kind == 1:
        changed[place : place + length] = draw.randbytes(length)
    elif kind == 2:
        changed[place : place + 4] = draw.choice([0, 1, 2**31 - 1, 2**31, 2**32 - 1]).to_bytes(4, "little")
    elif kind == 3:
        del changed[place : draw.choice([place + length, len(data)])]
    else:
        changed[place:place] = changed[place : place + length]
    return bytes(changed)


def mutated_json(draw: random.Random, value: Any) -> Any:
    """Change a value that JSON holds in one place: a leaf, or what holds some."""
    inside = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else []
    if not inside or draw.random() < 0.05:
        return _odd_value(draw, value)
    changed = dict(value) if isinstance(value, dict) else list(value)
    key = draw.choice(list(inside))
    what = draw.random()
    if what < 0.04:
        del changed[key]
    elif what < 0.08 and isinstance(changed, list):
        changed.append(changed[key])
    elif what < 0.1 and isinstance(changed, dict):
        changed[draw.choice(["note", "id", "length", "\x00"])] = changed[key]
    else:
        changed[key] = mutated_json(draw, value[key])
    return changed


def _odd_value(draw: random.Random, value: Any) -> Any:
    if isinstance(value, int | float) and not isinstance(value, bool) and draw.random() < 0.9:
        near = [value + 1, -value, value * 1.01, value / 3, value + 1e-9] if math.isfinite(value) else []
        return draw.choice([*near, *ODD_NUMBERS])
    if isinstance(value, str) and draw.random() < 0.7:
        return draw.choice([*_ODD_TEXTS, value + draw.choice("\x00/%é "), value[:-1], repr(draw.choice(ODD_NUMBERS))])
    return draw.choice([None, True, False, 0, -1, 1e9, "", "free", [], {}, [[]], [0, 1], {"a": 1}, "x" * 5000])


_ODD_TEXTS = [
    "",
    "\x00",
    "0",
    "-1",
    "1f",
    "1e9s",
    "1000000%",
    "1/0",
    "nan",
    "inf",
    "1e308",
    "0..0",
    "2..1",
    "..",
    "/",
    "~x",
]
_ODD_TEXTS += ["\ud800", "٣", "free", "y", "guided", "spline", "align", "1e-9..2", "5e-324", "0.001%", "1000000s", "é"]
