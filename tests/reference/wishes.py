"""What is asked of a path beside its scores, by its meaning: every path is tried, and looked at step by step."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from retime.warp.control import Lock
from retime.warp.keytimes import Reduction
from tests.reference.paths import Frames, every_path

# A fixed speed is played by a step within 3 % of it.
NEAR = 0.03
CLOSE = 1e-6


@dataclass(frozen=True)
class Wishes:
    """Tangents are the keytimes' own."""

    locks: Sequence[Lock] = ()
    slowest: float = 0.0
    fastest: float = math.inf


def paths(reduction: Reduction, max_skip: int, wishes: Wishes, lengths: Sequence[int]) -> Iterator[Frames]:
    """Yield every path of the given numbers of frames that meets the keytimes and obeys the wishes."""
    inner = dict(zip(reduction.positions[:-1], reduction.frames[:-1], strict=True))
    for n_output in lengths:
        for path in every_path(reduction.n_input, n_output, max_skip, inner):
            if obeys(path, reduction, max_skip, wishes):
                yield path


def obeys(path: Frames, reduction: Reduction, max_skip: int, wishes: Wishes) -> bool:
    steps = list(itertools.pairwise(path))
    if not set(reduction.frames) <= set(path):
        return False
    for step in steps:
        if not holds(reduction, step) and not (
            wishes.slowest - CLOSE <= speed(reduction, step) <= wishes.fastest + CLOSE
        ):
            return False
    for first, last, lock in locked_frames(reduction, max_skip, wishes.locks):
        if first not in path or last not in path:
            return False
        for step in steps:
            if first <= step[0] and step[1] <= last and not plays(reduction, step, lock):
                return False
    for key, frame in zip(reduction.keytimes, reduction.frames, strict=True):
        for step in steps:
            if key.speed is not None and frame in step and not holds(reduction, step):
                if abs(speed(reduction, step) - key.speed) > NEAR * key.speed + CLOSE:
                    return False
                if (step[1] - step[0]) != max(1, round(key.speed * reduction.upsample)):
                    return False
    return True


def holds(reduction: Reduction, step: tuple[int, int]) -> bool:
    return bool(reduction.input_times[step[0]] == reduction.input_times[step[1]])


def speed(reduction: Reduction, step: tuple[int, int]) -> float:
    return (step[1] - step[0]) / reduction.upsample


def plays(reduction: Reduction, step: tuple[int, int], lock: Lock) -> bool:
    if lock.slowest == lock.fastest:
        return step[1] - step[0] == max(1, round(lock.fastest * reduction.upsample))
    return lock.slowest - CLOSE <= speed(reduction, step) <= lock.fastest + CLOSE


def locked_frames(reduction: Reduction, max_skip: int, locks: Sequence[Lock]) -> list[tuple[int, int, Lock]]:
    """Find the frames at which locks begin and end: from the nearest to a whole number of steps, in each span."""
    found = []
    for (f0, k0), (f1, k1) in itertools.pairwise(zip(reduction.frames, reduction.keytimes, strict=True)):
        if reduction.input_times[f0] == reduction.input_times[f1]:
            continue
        shown = []
        for lock in locks:
            low = max(lock.start, min(k0.input_time, k1.input_time))
            high = min(lock.end, max(k0.input_time, k1.input_time))
            if high - low < 1e-8:
                continue
            times = reduction.input_times[f0 : f1 + 1]
            ends = sorted(f0 + int(np.argmin(np.abs(times - time))) for time in (low, high))
            if ends[0] < f1:
                shown.append((*ends, lock))
        for first, last, lock in shown:
            room = min([f1, *(other for other, _, _ in shown if other >= last)])
            able = {first}
            for frame in range(first, room):
                if frame in able:
                    able |= {
                        frame + b
                        for b in range(1, max_skip + 1)
                        if frame + b <= room and plays(reduction, (frame, frame + b), lock)
                    }
            able.discard(first)
            if able:
                found.append((first, min(able, key=lambda frame: (abs(frame - last), -frame)), lock))
    return found


def cost(
    path: Frames,
    scores: np.ndarray,
    reduction: Reduction,
    *,
    smoothness: float = 0.0,
    neutral: bool = False,
) -> float:
    """Add up the scores, the charges for changes of speed, and weight them where a free length is neutral."""
    median = float(np.median(scores[np.isfinite(scores)]))
    total = 0.0
    for before, after in itertools.pairwise(itertools.pairwise(path)):
        (i, j), (_, k) = before, after
        paid = float(scores[j, j - i - 1, k - j - 1])
        if not holds(reduction, before) and not holds(reduction, after):
            paid += smoothness * median * math.log((k - j) / (j - i)) ** 2
        total += paid * (math.sqrt((k - i) / 2 / reduction.upsample) if neutral else 1.0)
    return total
