"""The tasks that a worker process prepares and runs; see measure.py. Talks JSON lines on standard input and output.

A task is a function: it prepares, untimed, and returns what is to be timed. That returns the seconds of its stages; its
last result stays for `facts`.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import peers
from measure import Peak

from retime import Motion, Session, apply_warp, guided_warp, read, write
from retime.kernels import PathProblem, StepPairs, backend
from retime.search.path import MEMORY_LIMIT, path_scores, shortest_path
from retime.search.poses.spaces import difference_scales
from retime.search.score import build_model, triple_scores

N_NEIGHBORS = 3
RATE, TIME_SCALE = 30.0, 0.1


class Stages:
    """A stopwatch with named laps, and what was found."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.facts: dict[str, Any] = {}
        self._last = time.perf_counter()

    def lap(self, name: str) -> None:
        """End a stage."""
        now = time.perf_counter()
        self.seconds[name] = now - self._last
        self._last = now

    def total(self) -> dict[str, float]:
        """Seconds of all stages, and their sum."""
        return {**self.seconds, "total": sum(self.seconds.values())}


Run = Callable[[Stages], None]


def _poses(case: str) -> tuple[np.ndarray, np.ndarray]:
    with np.load(case) as arrays:
        return arrays["input"], arrays["reference"]


def retime(
    case: str,
    *,
    max_skip: int,
    n_output: int | None = None,
    score: str = "joint",
    search: str = "priced",
    kernels: str | None = None,
    first: int = 0,
    last: int | None = None,
    bounds: bool = True,
) -> Run:
    """Score with retime; search too where a length is given. Without `bounds` each triple meets the whole reference."""
    inputs, reference = _poses(case)
    inputs = inputs[first:last]
    use: Any = backend(kernels)
    long = use._LONG if hasattr(use, "_LONG") else 0

    def run(stages: Stages) -> None:
        model = build_model([reference], rate=RATE, time_scale=TIME_SCALE, n_neighbors=N_NEIGHBORS)
        stages.lap("model")
        if long:
            use._LONG = long if bounds else sys.maxsize
        scores = triple_scores(inputs, model, max_skip=max_skip, n_neighbors=N_NEIGHBORS, score=score, use=use)
        stages.lap("scores")
        if n_output:
            path = shortest_path(scores, n_output=n_output, search=search, use=use)
            stages.lap("path")
            stages.facts = {"total": path.total, "optimal": path.optimal, "search": path.search}

    return run


def save_scores(case: str, place: str, *, max_skip: int) -> Run:
    """Score with retime and keep the scores in a file."""
    inputs, reference = _poses(case)

    def run(stages: Stages) -> None:
        model = build_model([reference], rate=RATE, time_scale=TIME_SCALE, n_neighbors=N_NEIGHBORS)
        np.save(place, triple_scores(inputs, model, max_skip=max_skip, n_neighbors=N_NEIGHBORS))
        stages.lap("scores")

    return run


def retime_path(
    scores: str, *, n_output: int | None, n_input: int | None = None, search: str = "priced", kernels: str | None = None
) -> Run:
    """Search with retime in given scores, or in the first so many frames of them."""
    array = _scores(scores, n_input)
    use = backend(kernels)

    def run(stages: Stages) -> None:
        path = shortest_path(array, n_output=n_output, search=search, use=use)
        stages.lap("path")
        excess = (path.total - path.lower_bound) / path.total
        stages.facts = {"total": path.total, "optimal": path.optimal, "search": path.search, "excess": excess}

    return run


def path_work(scores: str, *, n_output: int, n_input: int) -> Run:
    """Search by price in the first so many frames of given scores, and say what it was made of."""
    array = _scores(scores, n_input)
    n_input, max_skip = array.shape[:2]
    free = np.zeros(max_skip)
    positions, frames = np.array([[0, n_output - 1], [0, n_input - 1]])
    pairs = array.reshape(n_input, -1)
    problem = PathProblem(pairs, StepPairs.up_to(max_skip), positions, frames, n_output - 1, free, free)
    use = backend("compiled")

    def run(stages: Stages) -> None:
        found = use.priced_path(problem, MEMORY_LIMIT)
        assert found is not None
        stages.lap("rest")
        # The kernel's own clock: sweeps over all scores, and what comes after.
        stages.seconds["rest"] -= found.sweep_seconds
        stages.seconds["sweeps"] = found.sweep_seconds
        stages.facts = {
            "sweeps": found.sweeps, "passes": found.passes, "labels": found.labels, "gave_up": found.gave_up,
            "sweep_seconds": found.sweep_seconds,
        }  # fmt: skip

    return run


def read_through(*, n_bytes: int, repeats: int) -> Run:
    """Find the least of an array's numbers, again and again: NumPy's quickest way to read it."""
    array = np.ones(n_bytes // 8)

    def run(stages: Stages) -> None:
        for _ in range(repeats):
            array.min()
        stages.lap("read")

    return run


def _scores(place: str, n_input: int | None) -> np.ndarray:
    scores = np.load(place)
    if n_input is None:
        return scores
    scores = scores[:n_input].copy()
    # No triple reaches beyond the last frame.
    for b in range(1, scores.shape[2] + 1):
        scores[max(0, n_input - b) :, :, b - 1] = np.inf
    return scores


def peer_path(scores: str, *, n_output: int, library: str) -> Run:
    """Search with a peer's recurrence in given scores."""
    array, search = np.load(scores), peers.numpy_path
    if library == "numba":
        search = peers.numba_path()
        # Compiles.
        search(array, n_output)

    def run(stages: Stages) -> None:
        _, total = search(array, n_output)
        stages.lap("path")
        stages.facts = {"total": total}

    return run


def peer(case: str, *, max_skip: int, library: str, n_output: int | None = None, every: int = 1) -> Run:
    """Score with a library's k-NN; with a length, search by the NumPy recurrence too."""
    neighbors: Callable[..., Any]
    if library.startswith("sklearn"):
        import sklearn  # noqa: F401

        neighbors = partial(peers.sklearn_neighbors, algorithm=library.partition(" ")[2])
    elif library == "faiss":
        import faiss  # noqa: F401

        neighbors = peers.faiss_neighbors
    else:
        neighbors = peers.scipy_neighbors
    inputs, reference = _poses(case)
    velocity, acceleration = difference_scales(RATE, TIME_SCALE)

    def run(stages: Stages) -> None:
        before, here, after = reference[:-2], reference[1:-1], reference[2:]
        model = np.concatenate(
            [here, (after - before) * velocity, ((after - here) - (here - before)) * acceleration], axis=1
        )
        scores = peers.scores_by(
            neighbors,
            inputs,
            model,
            max_skip=max_skip,
            n_neighbors=N_NEIGHBORS,
            velocity=velocity,
            acceleration=acceleration,
            every=every,
        )
        stages.lap("scores")
        # Where only a part of the triples was asked for, all of them would take so many times longer.
        stages.seconds["scores"] *= every
        if n_output:
            _, total = peers.numpy_path(scores, n_output)
            stages.lap("path")
            stages.facts = {"total": total}

    return run


def index(case: str, *, max_skip: int, first: int, last: int, lists: int, probes: int) -> Run:
    """Score by faiss' inverted lists: approximate. Building them is a stage of its own; facts tell what is lost."""
    import faiss

    inputs, reference = _poses(case)
    model = build_model([reference], rate=RATE, time_scale=TIME_SCALE, n_neighbors=N_NEIGHBORS)
    exact = triple_scores(inputs[first:last], model, max_skip=max_skip, n_neighbors=N_NEIGHBORS)
    part = inputs[first:last] - model.origin

    def run(stages: Stages) -> None:
        features = model.features.astype(np.float32)
        quantizer = faiss.IndexFlatL2(features.shape[1])
        found = faiss.IndexIVFFlat(quantizer, features.shape[1], lists)
        found.train(features)
        found.add(features)
        found.nprobe = probes
        stages.lap("index")
        queries, places = peers.triple_features(part, max_skip, model.velocity, model.acceleration)
        squares, _ = found.search(queries.astype(np.float32), N_NEIGHBORS)
        scores = np.full(exact.shape, np.inf)
        scores[tuple(places.T)] = np.sqrt(np.maximum(squares, 0)).mean(axis=1)
        stages.lap("search")
        inside = np.isfinite(exact)
        # Single precision alone can't be off by as much as a wrong neighbour.
        same = scores[inside] <= exact[inside] * 1.001 + 1e-3
        n_output = round(0.6 * len(part))
        best = shortest_path(exact, n_output=n_output)
        frames = shortest_path(scores, n_output=n_output).frames
        stages.facts = {
            "same": float(same.mean()),
            "excess": path_scores(exact, frames).sum() / best.total - 1,
        }

    return run


def gdtw(case: str, *, n_output: int) -> Run:
    """Align the input's first principal component with an evenly shortened copy of it, on gdtw's own grid."""
    import gdtw as library

    inputs, _ = _poses(case)
    inputs = np.linalg.svd(inputs - inputs.mean(axis=0), full_matrices=False)[0][:, 0]
    shorter = inputs[np.linspace(0, len(inputs) - 1, n_output).round().astype(int)]

    def run(stages: Stages) -> None:
        library.warp(inputs, shorter)
        stages.lap("align")

    return run


def gemm(*, size: int) -> Run:
    """Multiply two square matrices in single precision."""
    a, b = (np.random.default_rng(seed).random((size, size), dtype=np.float32) for seed in (1, 2))

    def run(stages: Stages) -> None:
        a @ b
        stages.lap("gemm")

    return run


def copy(*, n_bytes: int, repeats: int) -> Run:
    """Copy an array again and again."""
    a = np.ones(n_bytes // 8)
    b = np.ones_like(a)

    def run(stages: Stages) -> None:
        for _ in range(repeats):
            np.copyto(b, a)
        stages.lap("copy")

    return run


def subtract(*, n_numbers: int, repeats: int) -> Run:
    """Subtract two rows that stay in the first cache, in single precision, again and again."""
    a, b, c = (np.ones(n_numbers, dtype=np.float32) for _ in range(3))

    def run(stages: Stages) -> None:
        for _ in range(repeats):
            np.subtract(a, b, out=c)
        stages.lap("subtract")

    return run


def session(motion: str, *, key: tuple[float, float], length: str, moved: bool) -> Run:
    """Solve with one keytime: from the motion on (cold), or again in a session with the keytime moved."""
    clip = read(motion)
    assert isinstance(clip, Motion)
    kept = Session(clip)
    kept.solve(length=length, keys=[key])
    turn = 0

    def run(stages: Stages) -> None:
        nonlocal turn
        turn += 1
        # Another place each time, one frame to either side, so that no answer can be kept from the last run.
        keys = [(key[0], key[1] + (turn % 3 - 1) / RATE)]
        result = (kept if moved else Session(clip)).solve(length=length, keys=keys)
        stages.lap("solve")
        stages.facts = {"n_input": result.n_input, "n_output": result.n_output, **result.seconds}

    return run


def whole_retime(motion: str, output: str, *, length: str) -> Run:
    """Read, find the warp, apply it, write; in this process."""

    def run(stages: Stages) -> None:
        clip = read(motion)
        stages.lap("read")
        assert isinstance(clip, Motion)
        result = guided_warp(clip, length=length)
        stages.lap("warp")
        out = apply_warp(clip, result.warp)
        stages.lap("apply")
        write(out, output, overwrite=True)
        stages.lap("write")
        stages.facts = result.seconds

    return run


def copy_retime(motion: str, output: str) -> Run:
    """Read and write with retime, in this process."""

    def run(stages: Stages) -> None:
        clip = read(motion)
        stages.lap("read")
        write(clip, output, overwrite=True)
        stages.lap("write")

    return run


def whole_pybvh(motion: str, output: str) -> Run:
    """Read and write with pybvh, in this process."""
    import warnings

    import pybvh

    # It guesses which way is up and says when it is unsure; that is no matter here.
    warnings.simplefilter("ignore", UserWarning)

    def run(stages: Stages) -> None:
        clip = pybvh.read_bvh_file(motion)
        stages.lap("read")
        pybvh.write_bvh_file(clip, output)
        stages.lap("write")

    return run


TASKS: dict[str, Callable[..., Run]] = {
    task.__name__: task
    for task in (
        copy, copy_retime, gdtw, gemm, index, path_work, peer, peer_path, read_through, retime, retime_path,
        save_scores, session, subtract, whole_pybvh, whole_retime,
    )
}  # fmt: skip


def main() -> None:
    """Answer messages until the input ends."""
    # Libraries may print: the answers have a channel of their own.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    slots: dict[int, Run] = {}
    facts: dict[int, dict[str, Any]] = {}
    for line in sys.stdin:
        message = json.loads(line)
        answer: dict[str, Any] = {}
        if "prepare" in message:
            try:
                slots[message["slot"]] = TASKS[message["prepare"]](**message["arguments"])
            except ImportError as error:
                answer = {"missing": f"{error.name} is not installed"}
        elif "run" in message:
            stages = Stages()
            slots[message["run"]](stages)
            answer, facts[message["run"]] = {"seconds": stages.total()}, stages.facts
        elif "peak" in message:
            peak = Peak()
            peak.reset()
            slots[message["peak"]](Stages())
            answer = {"bytes": peak.growth()}
        elif "drop" in message:
            del slots[message["drop"]]
        else:
            answer = {"facts": facts[message["facts"]]}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
