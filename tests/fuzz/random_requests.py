"""Random requests: each ends in a warp that keeps all that was asked for, or in an error that retime raises on purpose.

    python -m tests.fuzz.random_requests --count 20000 --seed 1

Every request is made of its own seed alone, so that one that fails can be tried again: ``--only SEED``. The clips are
short and the wishes are not: holds, reversals, locks with keytimes in them, lengths from a frame to a fortnight.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import time
import warnings
from collections import Counter
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from retime.errors import RetimeError
from retime.motion.signal import Signal
from retime.search.guided import guided_warp
from retime.search.promises import broken_promises
from retime.search.result import GuidedWarp
from retime.search.wishes.locks import Lock

MOST_SECONDS, MOST_BYTES = 10.0, 1 << 30
RATES = [Fraction(24), Fraction(25), Fraction(30), Fraction(60), Fraction(120), Fraction(30000, 1001)]
# What people type, and what nobody should.
SPEEDS = [0.25, 1 / 3, 0.5, 0.75, 1.0, 1.0, 1.0, 1.5, 2.0, 3.0, 0.37, 1.234]
ODD_SPEEDS = [1e-9, 1e-3, 0.05, 16.0, 255.0, 1e9, 1.7e308]
ODD_TIMES = [5e-324, 1e-9, 1e-4, 1e3, 1e5, 1e9, 1.7e308]


class TooLongError(Exception):
    """It took twice as long as it may."""


@dataclass(frozen=True)
class Outcome:
    """How a request ended.

    Attributes
    ----------
    seed : int
        Of the request.
    kind : str
        "kept", "kept but for rounding", or the name of an error.
    faults : tuple of str
        What must not be.
    seconds : float
        It took.
    peak : int
        Bytes that the process held at most meanwhile, where the system tells; else 0.
    """

    seed: int
    kind: str
    faults: tuple[str, ...]
    seconds: float
    peak: int


def clip(rng: np.random.Generator, name: str) -> Signal:
    """Return a short clip: smooth, random, standing still for a while, or all the time."""
    rate = RATES[rng.integers(len(RATES))]
    n_frames = int(rng.choice([rng.integers(2, 8), rng.integers(8, 60), rng.integers(60, 400)], p=[0.06, 0.34, 0.6]))
    n_channels = int(rng.integers(1, 4))
    t = np.arange(n_frames) / float(rate)
    kind = rng.choice(["smooth", "walk", "paused", "still"], p=[0.5, 0.2, 0.2, 0.1])
    values = np.stack([np.sin(t ** rng.uniform(1, 1.6) * rng.uniform(1, 5)) for _ in range(n_channels)], axis=1)
    if kind == "walk":
        values = rng.standard_normal(values.shape).cumsum(axis=0)
    elif kind == "paused":
        first, last = np.sort(rng.integers(0, n_frames, 2))
        values[first:last] = values[first]
    elif kind == "still":
        values[:] = values[0]
    return Signal(tuple(f"{name}{i}" for i in range(n_channels)), values, rate, name=name)


def request(rng: np.random.Generator, motion: Signal) -> dict[str, Any]:
    """Return what is asked of a clip."""
    asked: dict[str, Any] = {}
    end = motion.end_time

    def odd() -> bool:
        return bool(rng.random() < 0.04)

    def speed() -> float:
        return float(rng.choice(ODD_SPEEDS if rng.random() < 0.02 else SPEEDS))

    def inside() -> float:
        return float(rng.choice(ODD_TIMES)) if rng.random() < 0.01 else float(np.round(rng.uniform(0, end), 3))

    share = float(np.exp(rng.uniform(np.log(0.4), np.log(2.5)))) if rng.random() < 0.6 else float(rng.choice([1, 0.65]))
    share = round(share, 2)
    extreme = [f"{round(float(np.exp(rng.uniform(np.log(1), np.log(20000)))))}%", "1000000s", "2f", 0.05]
    length = rng.choice(["none", "usual", "extreme", "free"], p=[0.25, 0.54, 0.06, 0.15])
    if length == "usual":
        asked["length"] = f"{round(100 * share)}%"
    elif length == "extreme":
        asked["length"] = extreme[rng.integers(4)]
    elif length == "free":
        asked["length"] = "free"
        if rng.random() < 0.4:
            asked["min_length"], asked["max_length"] = "60%", "140%"
        if rng.random() < 0.3:
            asked["free_weight"] = "sum"
    keys: list[tuple[float, ...]] = []
    for _ in range(rng.choice([0, 1, 2, 4], p=[0.4, 0.3, 0.2, 0.1])):
        place = inside()
        shown = float(rng.choice(ODD_TIMES)) if odd() else round(place * share * rng.uniform(0.8, 1.1), 3)
        keys.append((place, shown) if rng.random() < 0.7 else (place, shown, speed()))
    if keys and rng.random() < 0.2:
        # A hold.
        keys.append((keys[-1][0], keys[-1][1] + 0.4))
    if keys:
        asked["keys"] = keys
    locks = []
    for _ in range(rng.choice([0, 1, 2, 3], p=[0.45, 0.3, 0.15, 0.1])):
        first, last = sorted((inside(), inside()))
        slowest = speed()
        fastest = slowest if rng.random() < 0.7 else slowest * float(rng.choice([1.2, 2.0, 4.0]))
        if first < last and np.isfinite(fastest):
            locks.append(Lock(first, last, slowest, fastest))
    if locks:
        asked["locks"] = locks
    if rng.random() < 0.3:
        low, high = sorted((speed(), speed()))
        asked["speed"] = [(low, high), (0.0, high), f"{low:.17f}..", (0.5, 2.0)][rng.integers(4)]
    if rng.random() < 0.3:
        curve = np.sort(rng.uniform(0, 2 * end, 3))
        shares = rng.uniform(0, 1, 3)
        asked["influence"] = [0.0, 0.5, float(rng.random()), np.stack([curve, shares], axis=1), []][
            rng.choice(5, p=[0.2, 0.3, 0.2, 0.27, 0.03])
        ]
    if rng.random() < 0.15:
        asked["loop"] = True
    for name, usual, unusual in (
        ("smoothness", [0.3, 2.0], [1e6, 1e308]),
        ("ends", [0.2], [1e300]),
        ("content", [2.0], [1e300]),
        ("evenness", [0.0, 4.0], [1e300]),
        ("smoothing", [0, 1, 9], [101]),
        ("upsample", [1, 2, 8], [24, 1000]),
        ("max_skip", [4, 8, 32], [1, 64, 255]),
        ("rate", [10, 12.5, 60, "29.97"], [5, 1000, 100000]),
        ("n_neighbors", [1, 5], [50]),
        ("score", ["conditional"], ["other"]),
        ("search", ["layered", "heuristic"], ["best"]),
        ("paper", [True], [1]),
        ("low_pass", [0.0, 1.0], [1e300]),
        ("time_scale", [0.01, 1.0], [1e-300, 1e6, 1e300]),
    ):
        if rng.random() < 0.1:
            values = unusual if rng.random() < 0.1 else usual
            asked[name] = values[rng.integers(len(values))]
    if rng.random() < 0.25:
        reference = clip(rng, "reference")
        asked["reference"] = Signal(
            motion.names, np.resize(reference.values, (reference.n_frames, len(motion.names))), reference.rate
        )
    return asked


def faults_of(result: GuidedWarp, motion: Signal, asked: dict[str, Any]) -> list[str]:
    """List what a result does not keep, or keeps in a way that it must not."""
    wishes = result.plan.request.wishes
    broken = broken_promises(
        result.warp,
        result.reduction.keytimes,
        locks=asked.get("locks", ()),
        slowest=wishes.slowest,
        fastest=wishes.fastest,
        loop=bool(asked.get("loop")),
        tolerance=0.06 if result.given_up else 1e-5,
    )
    faults = [f"broken: {one}" for one in broken]
    warp = result.warp
    shown = {(key.input_time, key.output_time) for key in warp.keytimes}
    faults += [f"key {key} is not in the result" for key in asked.get("keys", ()) if tuple(key[:2]) not in shown]
    length = asked.get("length")
    if isinstance(length, str) and length.endswith("%"):
        wanted = max(1, round(Fraction(length[:-1]) / 100 * motion.n_frames))
        if abs(warp.count_frames(motion.rate) - wanted) > 0:
            faults.append(f"{warp.count_frames(motion.rate)} frames where {length} of {motion.n_frames} were asked for")
    if not (np.isfinite(warp.input_times).all() and warp.input_times.min() >= -1e-9):
        faults.append("input times outside of the clip")
    if warp.input_times.max() > motion.end_time + 1e-9:
        faults.append("input times beyond the clip")
    return faults


def _ring(*_: object) -> None:
    raise TooLongError


def _peak(begin: bool) -> int:
    """Return the bytes held at most since it was called with `begin`; 0 where the system does not tell."""
    try:
        if begin:
            Path("/proc/self/clear_refs").write_text("5")
            return 0
        lines = Path("/proc/self/status").read_text().splitlines()
        return 1024 * int(next(line for line in lines if line.startswith("VmHWM:")).split()[1])
    except OSError:
        return 0


def run(seed: int) -> tuple[Outcome, dict[str, Any]]:
    """Make one request, and look at what comes of it."""
    rng = np.random.default_rng([20_261_130, seed])
    motion = clip(rng, "c")
    asked = request(rng, motion)
    faults: list[str] = []
    before = signal.signal(signal.SIGALRM, _ring)
    signal.setitimer(signal.ITIMER_REAL, 1.5 * MOST_SECONDS)
    _peak(begin=True)
    begun = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            result = guided_warp(motion, **asked)
        except RetimeError as error:
            kind = type(error).__name__
            if "nan" in str(error).replace("-", " ").split():
                faults.append(f"speaks of nan: {error}")
        except TooLongError:
            kind = "no end"
        except Exception as error:
            kind = f"uncaught {type(error).__name__}"
            faults.append(f"uncaught {error!r}")
        else:
            faults += faults_of(result, motion, asked)
            kind = "kept but for rounding" if result.given_up else "kept"
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)
    seconds, peak = time.perf_counter() - begun, _peak(begin=False)
    if seconds > MOST_SECONDS:
        faults.append(f"took {seconds:.1f} s")
    if peak > MOST_BYTES:
        faults.append(f"held {peak / 2**20:.0f} MB")
    return Outcome(seed, kind, tuple(faults), seconds, peak), {"motion": motion, **asked}


def limit() -> dict[str, str]:
    """Return the limits that let through what is asked of each request here, by a search's own estimate."""
    return {"RETIME_MOST_MEMORY": "0.75", "RETIME_MOST_SECONDS": "5"}


def main() -> int:
    """Run many requests, and print figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0, help="of the first request")
    parser.add_argument("--only", type=int, help="one request, told in full")
    given = parser.parse_args()
    if sys.platform != "win32":
        import resource

        # More than the bound, so that what passes it fails by itself and leaves the machine alone.
        resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
    os.environ.update(limit())
    if given.only is not None:
        outcome, asked = run(given.only)
        print(asked)
        print(outcome)
        return bool(outcome.faults)
    kinds: Counter[str] = Counter()
    slowest = largest = Outcome(-1, "", (), 0.0, 0)
    n_faulty = 0
    for seed in range(given.seed, given.seed + given.count):
        outcome, _ = run(seed)
        kinds[outcome.kind] += 1
        slowest = max(slowest, outcome, key=lambda one: one.seconds)
        largest = max(largest, outcome, key=lambda one: one.peak)
        if outcome.faults:
            n_faulty += 1
            print(f"{seed}: {'; '.join(outcome.faults)[:400]}", flush=True)
    print(
        json.dumps(
            {
                "requests": given.count,
                "faulty": n_faulty,
                "ends": dict(kinds.most_common()),
                "slowest": {"seed": slowest.seed, "seconds": round(slowest.seconds, 2), "end": slowest.kind},
                "largest": {"seed": largest.seed, "MB": round(largest.peak / 2**20), "end": largest.kind},
            },
            indent=2,
        )
    )
    return bool(n_faulty)


if __name__ == "__main__":
    sys.exit(main())
