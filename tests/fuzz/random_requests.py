"""Random requests: each ends in a warp that keeps all that was asked for, or in an error that retime raises on purpose.

    python -m tests.fuzz.random_requests --count 20000 --seed 1

Every request is made of its own seed alone, so that one that fails can be tried again: ``--only SEED``. In turn they
are for signals, for motions of any skeleton, for groups of both with clocks of their own, to be aligned with another
clip, and to go on as an example does. The clips are short and the wishes are not: holds, reversals, locks with keytimes
in them, lengths from a frame to a fortnight.
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
from retime.motion.any_motion import AnyMotion
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.search.align import align
from retime.search.guided import guided_warp
from retime.search.imitate import imitate
from retime.search.poses.references import Reference
from retime.search.poses.spaces import PoseOptions
from retime.search.promises import broken_promises
from retime.search.result import GuidedWarp
from retime.search.wishes.locks import Lock
from retime.warp.curve import Warp
from retime.warp.spline import linear_warp
from tests.fuzz import random_clips

MOST_SECONDS, MOST_BYTES = 10.0, 1 << 30
KINDS = ("signal", "motion", "group", "align", "imitate")
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
    asked : str
        What for: one of `KINDS`.
    kind : str
        "kept", "kept but for rounding", or the name of an error.
    faults : tuple of str
        What must not be.
    seconds : float
        It took, of the processor.
    peak : int
        Bytes that the process held at most meanwhile, where the system tells; else 0.
    """

    seed: int
    asked: str
    kind: str
    faults: tuple[str, ...]
    seconds: float
    peak: int


def request(rng: np.random.Generator, motion: AnyMotion) -> dict[str, Any]:
    """Return what is asked of a clip, but for its reference."""
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
    return asked


def for_figures(rng: np.random.Generator, asked: dict[str, Any], motion: AnyMotion) -> None:
    """Ask for what only makes sense of motions."""
    for name, usual, unusual in (
        ("features", ["heading", "torso"], ["signal", PoseOptions("heading", joints=["Hips"])]),
        ("keep_flights", [0.0, 24.0], [1e300, -1.0]),
        ("own_timing", [0.1], [1e300]),
        ("match_tempo", [True], [True]),
    ):
        if rng.random() < 0.15:
            values = unusual if rng.random() < 0.1 else usual
            asked[name] = values[rng.integers(len(values))]
    if rng.random() < 0.15:
        asked["flights"] = [tuple(np.sort(rng.uniform(0, motion.end_time, 2)).round(3).tolist())]


def another(rng: np.random.Generator, clip: AnyMotion) -> AnyMotion:
    """Return a clip that has what another one has, and moves otherwise."""
    if isinstance(clip, Motion):
        return random_clips.motion(rng, "reference")
    found = random_clips.signal(rng, "reference")
    values = np.resize(found.values, (found.n_frames, len(clip.names)))
    return Signal(clip.names, values, found.rate, name="reference")


def at_another_pace(rng: np.random.Generator, clips: list[AnyMotion]) -> list[AnyMotion]:
    """Return the same clips, or the same part of each, at another pace."""
    end = min(clip.end_time for clip in clips)
    low, high = np.sort(rng.uniform(0, end, 2)) if rng.random() < 0.3 else (0.0, end)
    pace = float(rng.choice([0.5, 1.0, 1.7]))

    def paced(clip: AnyMotion) -> AnyMotion:
        rate = float(clip.rate)
        n_frames = max(2, round((high - low) / pace * rate) + 1)
        return clip.at(np.minimum(low + np.arange(n_frames) / rate * pace, high))

    return [paced(clip) for clip in clips]


def reference_for(rng: np.random.Generator, clips: list[AnyMotion]) -> Any:
    """Return what a clip or a group is to move like."""
    other = rng.random() < (0.6 if isinstance(clips[0], Signal) else 0.15)
    found = [another(rng, clip) for clip in clips] if other else at_another_pace(rng, clips)
    if len(found) > 1:
        return Reference(found)
    if rng.random() < 0.25:
        mirror = bool(rng.random() < (0.05 if isinstance(found[0], Signal) else 0.5))
        return Reference(found[0], weight=float(rng.choice([0.5, 2.0, 1e-9, 1e9])), mirror=mirror)
    return found[0]


def hand_for(rng: np.random.Generator, seconds: float) -> Warp:
    """Return a warp that somebody made of an example: hurried, slowed, held, and now and then nonsense."""
    places = np.concatenate([[0.0], np.sort(rng.uniform(0, seconds, int(rng.integers(0, 4)))), [seconds]])
    if rng.random() < 0.05:
        places = places * rng.choice([-1.0, 0.0, 3.0])
    steps = np.maximum(np.abs(np.diff(places)), 1e-3) / rng.choice(SPEEDS, len(places) - 1)
    if rng.random() < 0.2 and seconds > 0:
        return linear_warp([(0.0, 0.0), (seconds, seconds * float(rng.choice(SPEEDS)))])
    return Warp(np.concatenate([[0.0], np.cumsum(steps)]), places)


# What is asked of `align`, of what there is to ask.
_OF_ALIGN = ("keys", "locks", "speed", "smoothness", "influence", "rate", "max_skip", "upsample", "time_scale")
_OF_ALIGN += ("low_pass", "features", "smoothing")


@dataclass(frozen=True)
class Made:
    """A request, and what it is for."""

    kind: str
    clips: list[AnyMotion]
    asked: dict[str, Any]

    def solve(self) -> GuidedWarp:
        """Do it."""
        motion = self.clips if len(self.clips) > 1 else self.clips[0]
        return {"align": align, "imitate": imitate}.get(self.kind, guided_warp)(motion, **self.asked)


def made(seed: int) -> Made:
    """Make a request."""
    kind = KINDS[seed % len(KINDS)]
    rng = np.random.default_rng([20_261_130, seed])
    usual = kind if kind in ("signal", "motion", "group") else str(rng.choice(["signal", "motion", "group"]))
    clips: list[AnyMotion] = (
        random_clips.group(rng)
        if usual == "group"
        else [random_clips.motion(rng, "m") if usual == "motion" else random_clips.signal(rng, "c")]
    )
    first = clips[0]
    asked = request(rng, first)
    if any(isinstance(clip, Motion) for clip in clips):
        for_figures(rng, asked, first)
    if kind == "align":
        # Nine of ten requests would be refused for their keytimes alone.
        odd = bool(rng.random() < 0.2)
        asked = {name: value for name, value in asked.items() if name in _OF_ALIGN and (odd or name != "keys")}
        asked["reference"] = reference_for(rng, clips)
        if rng.random() < 0.2:
            asked["repeat"] = float(rng.choice([2.0, 2.5, 0.5, 1e6]))
    elif kind == "imitate":
        start, stop = np.sort(rng.integers(0, first.n_frames + 1, 2)).tolist()
        asked["example"] = (start, stop)
        asked["hand"] = hand_for(rng, max(0.0, (stop - start - 1) / float(first.rate)))
        if rng.random() < 0.7:
            for name in ("score", "free_weight", "evenness", "keep_flights", "content", "ends", "search", "flights"):
                asked.pop(name, None)
        if rng.random() < 0.2:
            asked["paper"] = True
        if rng.random() < 0.2:
            asked["example_clip"] = reference_for(rng, clips)
    elif rng.random() < 0.25:
        asked["reference"] = reference_for(rng, clips)
    return Made(kind, clips, asked)


def faults_of(result: GuidedWarp, kind: str, motion: AnyMotion, asked: dict[str, Any]) -> list[str]:
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
    if kind == "align":
        reference = asked["reference"]
        followed = reference.clips if isinstance(reference, Reference) else (reference,)
        wanted_end = asked.get("repeat", 1.0) * min(clip.end_time for clip in followed)
        # To half a frame of the output, and half of one of a reference that is repeated.
        if abs(warp.output_end - wanted_end) > 0.5001 * max(1 / float(one.rate) for one in (motion, *followed)) * 2:
            faults.append(f"it ends at {warp.output_end} s, its reference at {wanted_end} s")
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
    one = made(seed)
    faults: list[str] = []
    # Of the processor, all threads together: how many others use the machine is no fault of a request.
    before = signal.signal(signal.SIGPROF, _ring)
    signal.setitimer(signal.ITIMER_PROF, 1.5 * MOST_SECONDS)
    _peak(begin=True)
    begun = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            result = one.solve()
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
            faults += faults_of(result, one.kind, one.clips[0], one.asked)
            kind = "kept but for rounding" if result.given_up else "kept"
    signal.setitimer(signal.ITIMER_PROF, 0)
    signal.signal(signal.SIGPROF, before)
    seconds, peak = time.process_time() - begun, _peak(begin=False)
    if seconds > MOST_SECONDS:
        faults.append(f"took {seconds:.1f} s")
    if peak > MOST_BYTES:
        faults.append(f"held {peak / 2**20:.0f} MB")
    return Outcome(seed, one.kind, kind, tuple(faults), seconds, peak), {"clips": one.clips, **one.asked}


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
    ends = {kind: Counter[str]() for kind in KINDS}
    slowest = largest = Outcome(-1, "", "", (), 0.0, 0)
    n_faulty = 0
    for seed in range(given.seed, given.seed + given.count):
        outcome, _ = run(seed)
        ends[outcome.asked][outcome.kind] += 1
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
                "ends": {kind: dict(counts.most_common()) for kind, counts in ends.items()},
                "slowest": {"seed": slowest.seed, "seconds": round(slowest.seconds, 2), "end": slowest.kind},
                "largest": {"seed": largest.seed, "MB": round(largest.peak / 2**20), "end": largest.kind},
            },
            indent=2,
        )
    )
    return bool(n_faulty)


if __name__ == "__main__":
    sys.exit(main())
