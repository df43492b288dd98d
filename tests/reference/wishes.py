"""What is asked of a path beside its scores, by its meaning: every path is tried, and looked at step by step."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from retime.kernels import StepPairs
from retime.search.reduction import Reduction
from retime.search.wishes.locks import Lock
from tests.reference.paths import Frames

# A fixed speed is played by a step within 3 % of it.
NEAR = 0.03
CLOSE = 1e-6


@dataclass(frozen=True)
class Wishes:
    """Tangents are the keytimes' own."""

    locks: Sequence[Lock] = ()
    slowest: float = 0.0
    fastest: float = math.inf


# All steps up to some length, in any order; or a list of them, and which may follow which.
Steps = int | StepPairs


def lengths_of(steps: Steps) -> list[int]:
    return list(range(1, steps + 1)) if isinstance(steps, int) else steps.steps.tolist()


def follows(steps: Steps, before: int, after: int) -> bool:
    if isinstance(steps, int):
        return True
    pairs = zip(steps.steps[steps.before].tolist(), steps.steps[steps.after].tolist(), strict=True)
    return (before, after) in list(pairs)


def paths(reduction: Reduction, steps: Steps, wishes: Wishes, lengths: Sequence[int]) -> Iterator[Frames]:
    """Yield every path of the given numbers of frames that meets the keytimes and obeys the wishes."""
    places = dict(zip(reduction.frames, reduction.positions, strict=True))
    last = reduction.n_input - 1
    del places[last]

    def extend(path: Frames) -> Iterator[Frames]:
        here = path[-1]
        if here == last:
            if len(path) in lengths:
                yield path
            return
        if here in places and places[here] != len(path) - 1:
            return
        for step in lengths_of(steps):
            if here + step > last or any(here < place < here + step for place in places):
                return
            if len(path) == 1 or follows(steps, here - path[-2], step):
                yield from extend((*path, here + step))

    for path in extend((0,)):
        if obeys(path, reduction, steps, wishes):
            yield path


def obeys(path: Frames, reduction: Reduction, steps: Steps, wishes: Wishes) -> bool:
    if not set(reduction.frames) <= set(path):
        return False
    if wishes == Wishes() and all(key.speed is None for key in reduction.keytimes):
        return True
    taken = list(itertools.pairwise(path))
    for step in taken:
        if not holds(reduction, step) and not (
            wishes.slowest - CLOSE <= speed(reduction, step) <= wishes.fastest + CLOSE
        ):
            return False
    for first, last, lock in locked_frames(reduction, steps, wishes.locks):
        if first not in path or last not in path:
            return False
        for step in taken:
            if first <= step[0] and step[1] <= last and not plays(reduction, step, lock):
                return False
    for key, frame in zip(reduction.keytimes, reduction.frames, strict=True):
        for step in taken:
            if key.speed is not None and frame in step and not holds(reduction, step):
                if abs(speed(reduction, step) - key.speed) > NEAR * key.speed + CLOSE:
                    return False
                if (step[1] - step[0]) != max(1, round(key.speed * upsample(reduction, step))):
                    return False
    return True


def holds(reduction: Reduction, step: tuple[int, int]) -> bool:
    return reduction.still[span_of(reduction, step)]


def speed(reduction: Reduction, step: tuple[int, int]) -> float:
    return (step[1] - step[0]) / upsample(reduction, step)


def upsample(reduction: Reduction, step: tuple[int, int]) -> int:
    return reduction.upsamples[span_of(reduction, step)]


def span_of(reduction: Reduction, step: tuple[int, int]) -> int:
    return sum(frame <= step[0] for frame in reduction.frames) - 1


def plays(reduction: Reduction, step: tuple[int, int], lock: Lock) -> bool:
    if lock.slowest == lock.fastest:
        return step[1] - step[0] == max(1, round(lock.fastest * upsample(reduction, step)))
    return lock.slowest - CLOSE <= speed(reduction, step) <= lock.fastest + CLOSE


def locked_frames(reduction: Reduction, steps: Steps, locks: Sequence[Lock]) -> list[tuple[int, int, Lock]]:
    """Find the frames at which locks begin and end: from the nearest to a whole number of steps, in each span."""
    found = []
    for (f0, k0), (f1, k1) in itertools.pairwise(zip(reduction.frames, reduction.keytimes, strict=True)):
        if holds(reduction, (f0, f1)):
            continue
        shown = []
        for lock in locks:
            low = max(lock.start, min(k0.input_time, k1.input_time))
            high = min(lock.end, max(k0.input_time, k1.input_time))
            if high - low < 1e-8:
                continue
            times = reduction.input_times[f0 : f1 + 1].copy()
            # Each span has its keytimes on its own grid.
            grid = reduction.rate * upsample(reduction, (f0, f1))
            for i, key in ((0, k0), (-1, k1)):
                times[i] = math.floor(key.input_time * grid + 0.5 + CLOSE) / grid
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
                        for b in lengths_of(steps)
                        if frame + b <= room and plays(reduction, (frame, frame + b), lock)
                    }
            nearest = min(able, key=lambda frame: (abs(frame - last), -frame))
            if nearest > first:
                found.append((first, nearest, lock))
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
    total = 0.0
    for before, after in itertools.pairwise(itertools.pairwise(path)):
        (i, j), (_, k) = before, after
        paid = float(scores[j, j - i - 1, k - j - 1])
        if smoothness and not holds(reduction, before) and not holds(reduction, after):
            change = math.log(speed(reduction, after) / speed(reduction, before))
            paid += smoothness * float(np.median(scores[np.isfinite(scores)])) * change**2
        total += paid * (math.sqrt((speed(reduction, before) + speed(reduction, after)) / 2) if neutral else 1.0)
    return total
