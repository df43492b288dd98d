"""How the benchmarks measure: processes of their own that take turns, and what is made of their times.

Contenders take turns (A B A B ...), so that a busy machine slows all of them. Each runs in a worker process whose
number of threads was set before NumPy was imported. A ratio is the median of the ratios of the rounds that both ran,
its spread their quartiles.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

HERE = Path(__file__).resolve().parent
VERSION = metadata.version("retime")
PACKAGES = ("numpy", "scipy", "scikit-learn", "numba", "faiss-cpu", "gdtw", "pybvh")
_THREADS = ("RETIME_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def n_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class NotHere(Exception):
    """A contender can't run here; the message says why."""


class Worker:
    """A process that prepares tasks of tasks.py and runs them when asked; between calls it waits."""

    def __init__(self, threads: int) -> None:
        self._process = subprocess.Popen(
            [sys.executable, str(HERE / "tasks.py")],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, **dict.fromkeys(_THREADS, str(threads))},
        )
        self._n_tasks = 0
        self.threads = threads

    def ask(self, **message: object) -> dict[str, Any]:
        """Send one message, wait for its answer."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(message) + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError(f"a worker ended while it was asked {message}")
        answer: dict[str, Any] = json.loads(line)
        if "missing" in answer:
            raise NotHere(answer["missing"])
        return answer

    def task(self, name: str, **arguments: object) -> Task:
        """Prepare a task; raise NotHere where what it needs is not installed."""
        self._n_tasks += 1
        self.ask(prepare=name, slot=self._n_tasks, arguments=arguments)
        return Task(self, self._n_tasks)

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


class Bench:
    """Workers and files of one run; all gone at its end."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory()
        self._workers: dict[tuple[str, int], Worker] = {}
        self.folder = Path(self._folder.name)

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self._workers.values():
            worker.close()
        self._folder.cleanup()

    def worker(self, threads: int, who: str = "retime") -> Worker:
        """Return the worker with so many threads; retime and its peers don't share one."""
        if (who, threads) not in self._workers:
            self._workers[who, threads] = Worker(threads)
        return self._workers[who, threads]

    def case(self, name: str, inputs: NDArray[np.float64], reference: NDArray[np.float64]) -> str:
        """Keep poses in a file that tasks read."""
        place = self.folder / f"{name}.npz"
        np.savez(place, input=inputs, reference=reference)
        return str(place)

    def peak(self, threads: int, name: str, **arguments: object) -> int:
        """Bytes that a task takes in a process that has run nothing before."""
        worker = Worker(threads)
        try:
            return worker.task(name, **arguments).peak()
        finally:
            worker.close()

    def scores(self, name: str, case: str, max_skip: int) -> str:
        """Score a case on all cores into a file that tasks read."""
        place = str(self.folder / f"{name}-{max_skip}.npy")
        self.worker(n_cores()).task("save_scores", case=case, place=place, max_skip=max_skip)()
        return place


class Task:
    """A prepared task."""

    def __init__(self, worker: Worker, slot: int) -> None:
        self._worker, self._slot = worker, slot

    def __call__(self) -> dict[str, float]:
        """Run once: seconds of each stage, and of all as "total"."""
        stages: dict[str, float] = self._worker.ask(run=self._slot)["seconds"]
        # Idle threads of a BLAS wait actively for some time: the next contender should not pay for that.
        if self._worker.threads > 1:
            time.sleep(0.05)
        return stages

    def facts(self) -> dict[str, Any]:
        """Return what the last run found."""
        return dict(self._worker.ask(facts=self._slot)["facts"])

    def peak(self) -> int:
        """Run once more: bytes that the process grew by at most, over what it held before."""
        return int(self._worker.ask(peak=self._slot)["bytes"])

    def drop(self) -> None:
        """Forget the task and its arrays."""
        self._worker.ask(drop=self._slot)


def command(*words: str) -> Callable[[], dict[str, float]]:
    """Return a contender that runs a whole process."""

    def run() -> dict[str, float]:
        start = time.perf_counter()
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        return {"total": time.perf_counter() - start}

    return run


Times = dict[str, list[dict[str, float]]]


def take_turns(
    contenders: Mapping[str, Callable[[], dict[str, float]]], *, rounds: int, seconds: float, warm: bool = True
) -> Times:
    """Run all in turns, once before they count; one that has used up its seconds is left out after three runs."""
    times: Times = {name: [] for name in contenders}
    spent = dict.fromkeys(contenders, 0.0)
    for turn in range(-1 if warm else 0, rounds):
        for name, run in contenders.items():
            if spent[name] > seconds and len(times[name]) > 2:
                continue
            took = run()
            spent[name] += took["total"]
            # A first run as long as that was not slow for want of warmth.
            if turn >= 0 or took["total"] > seconds:
                times[name].append(took)
    return times


def summary(times: Times) -> dict[str, dict[str, Any]]:
    """Median, least and number of runs of each contender; medians of its stages."""
    found = {}
    for name, runs in times.items():
        totals = [run["total"] for run in runs]
        stages = {stage: float(np.median([run[stage] for run in runs])) for stage in runs[0] if stage != "total"}
        least = {stage: min(run[stage] for run in runs) for stage in stages}
        found[name] = {
            "median": float(np.median(totals)),
            "min": min(totals),
            "runs": len(totals),
            "stages": stages,
            "stages_min": least,
        }
    return found


def ratio(times: Times, slow: str, fast: str, *, stage: str = "total") -> dict[str, float]:
    """How many times longer `slow` takes than `fast`: median and quartiles of the rounds; and of the least times."""
    a, b = (np.array([run[stage] for run in times[name]]) for name in (slow, fast))
    rounds = min(len(a), len(b))
    low, middle, high = np.quantile(a[:rounds] / b[:rounds], [0.25, 0.5, 0.75])
    return {
        "ratio": float(middle),
        "of_least": float(a.min() / b.min()),
        "quartiles": [float(low), float(high)],
    }


def exponent(sizes: Sequence[float], seconds: Sequence[float]) -> float:
    """Slope of log(seconds) over log(size), by least squares."""
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])


class Peak:
    """The most memory that this process held since `reset`."""

    def reset(self) -> None:
        """Begin to watch. Linux forgets the old peak when asked; elsewhere it stays, and the growth may read low."""
        clear = Path("/proc/self/clear_refs")
        if clear.exists():
            clear.write_text("5")
        self._before = self._status("VmRSS")

    def growth(self) -> int:
        """Bytes at the peak, less those at the reset."""
        return max(0, self._status("VmHWM") - self._before)

    def _status(self, field: str) -> int:
        status = Path("/proc/self/status")
        if status.exists():
            return next(
                int(line.split()[1]) << 10 for line in status.read_text().splitlines() if line.startswith(field)
            )
        # macOS counts bytes, others kilobytes.
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss << (0 if sys.platform == "darwin" else 10)


def machine() -> dict[str, Any]:
    """Say what the figures were measured with: no names, only what they depend on."""
    versions = {}
    for package in PACKAGES:
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    cpu = Path("/proc/cpuinfo")
    flags = cpu.read_text() if cpu.exists() else ""
    simd = [name for name in ("avx2", "avx512f", "asimd", "sve") if f" {name} " in flags]
    return {
        "retime": VERSION,
        "python": platform.python_version(),
        "system": f"{platform.system()} {platform.machine()}",
        "cores": n_cores(),
        "simd": simd,
        "load_before": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
        "packages": versions,
    }


def save(name: str, results: Mapping[str, Any], folder: Path) -> Path:
    """Write results/<version>/<name>.json."""
    folder.mkdir(parents=True, exist_ok=True)
    place = folder / f"{name}.json"
    # Four digits are more than any of these repeats; they keep the files' differences readable.
    place.write_text(json.dumps(_rounded(results), indent=1) + "\n", encoding="utf-8")
    return place


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.4g}")
    if isinstance(value, Mapping):
        return {key: _rounded(inner) for key, inner in value.items()}
    return [_rounded(inner) for inner in value] if isinstance(value, list | tuple) else value


def arguments(description: str) -> argparse.Namespace:
    """Read the options that all benchmarks share."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--quick", action="store_true", help="tiny sizes: only shows that everything runs")
    parser.add_argument(
        "--results", type=Path, help="folder for the JSON [default: benchmarks/results/VERSION; with --quick: none]"
    )
    options = parser.parse_args()
    if options.results is None and not options.quick:
        options.results = HERE / "results" / VERSION
    return options
