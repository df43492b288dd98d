"""What the fuzz scripts share: trials of a seed each, their ends counted, and what must not be told with its seed.

A trial ends in what it names, or in an error that retime raises on purpose. Any other error is a fault; so is a warning
of NumPy's, a number that is not finite, and a trial that takes longer than it may.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import random
import signal
import threading
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

from retime.errors import RetimeError, RetimeWarning

MOST_SECONDS = 10
ODD_NUMBERS = [0, -0.0, -1, 1, 2, 0.5, 5e-324, 1e-300, 1e-12, 1e6, 1e7, 1e9, 2**31, 2**53, 2**64, 1e77, 1e100, 1.7e308]

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
    """

    ends: Counter[str] = field(default_factory=Counter)
    faults: dict[int, str] = field(default_factory=dict)
    slowest: tuple[float, int] = (0.0, 0)


@contextlib.contextmanager
def time_limit(seconds: int) -> Iterator[None]:
    """Raise TooLongError after so many seconds, where alarms are to be had: in the main thread, not on Windows."""
    if not hasattr(signal, "SIGALRM") or threading.current_thread() is not threading.main_thread():
        yield
        return

    def ring(*_: object) -> None:
        raise TooLongError(f"more than {seconds} s")

    before = signal.signal(signal.SIGALRM, ring)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def run(trial: Trial, seeds: Iterable[int], *, most_seconds: int = MOST_SECONDS) -> Tally:
    """Run trials; each is made of its own seed alone, so that one that fails can be tried again."""
    tally = Tally()
    for seed in seeds:
        begun = time.perf_counter()
        try:
            with time_limit(most_seconds), warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.simplefilter("ignore", RetimeWarning)
                end = trial(random.Random(seed))
        except (RetimeError, OSError) as error:
            end = type(error).__name__
            if len(str(error)) > 2000:
                tally.faults[seed] = f"a message of {len(str(error))} letters"
        except (Exception, TooLongError) as error:
            end = "fault"
            tally.faults[seed] = f"{type(error).__name__}: {str(error)[:200]}\n{_place(error)}"
        tally.ends[end] += 1
        tally.slowest = max(tally.slowest, (time.perf_counter() - begun, seed))
    return tally


def _place(error: BaseException) -> str:
    return "".join(traceback.format_tb(error.__traceback__)[-3:])


def command(trial: Trial, description: str | None, *, most_seconds: int = MOST_SECONDS) -> int:
    """Run as many trials as a command line asks for; return its exit code."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1, help="the first one")
    parser.add_argument("--only", type=int, help="try one seed again")
    given = parser.parse_args()
    seeds = [given.only] if given.only is not None else range(given.seed, given.seed + given.count)
    tally = run(trial, seeds, most_seconds=most_seconds)
    for seed, fault in tally.faults.items():
        print(f"seed {seed}: {fault}")
    print(f"{sum(tally.ends.values())} trials, {len(tally.faults)} faults; slowest {tally.slowest[0]:.2f} s")
    print(", ".join(f"{end} {count}" for end, count in tally.ends.most_common()))
    return 1 if tally.faults else 0


# Mutations of text, bytes and JSON.


def mutated_text(draw: random.Random, text: bytes) -> bytes:
    """Change a text in a few places: its numbers, words, lines and bytes."""
    for _ in range(draw.choice([1, 1, 1, 2, 4])):
        kind = draw.randrange(8)
        lines = text.split(b"\n")
        place = draw.randrange(len(lines))
        words = lines[place].split(b" ")
        word = draw.randrange(len(words))
        if kind == 0:
            words[word] = repr(draw.choice(ODD_NUMBERS)).encode()
        elif kind == 1:
            words[word] = draw.choice(_ODD_WORDS)
        elif kind == 2:
            words[word] = draw.choice(draw.choice(lines).split(b" "))
        elif kind == 3:
            del words[word]
        lines[place] = b" ".join(words)
        if kind == 4:
            del lines[place]
        elif kind == 5:
            lines.insert(place, draw.choice(lines))
        text = b"\n".join(lines)
        if kind >= 6:
            text = mutated_bytes(draw, text)
    return text


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
