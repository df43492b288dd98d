"""What an engine costs a clip: tiny clips, joined linearly, so that next to nothing is the clip's own.

    .venv/extras/bin/python benchmarks/bench_batch.py [--clips 1000 5000 20000 50000] [--workers 2]

Needs the environment of "make extras". What a clip costs is measured in processor time of all processes, which a busy
machine changes least; "alone" is the same done by one process with no engine. The overhead of a clip is the difference.
Memory is the most that the process of client and scheduler took.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.batch import Recipe, Treatment, retime_clip, run
from retime.batch.manifest import Known
from retime.batch.run import plan, survey
from retime.batch.treatment import settings
from retime.formats import write
from retime.motion.signal import Signal

HERE = Path(__file__).resolve().parent
_ONE = "import sys; sys.path.insert(0, sys.argv[1]); import bench_batch; bench_batch.one(*sys.argv[2:])"


def make_clips(root: Path, n: int) -> None:
    """Write clips of 20 frames and two channels, a thousand a folder."""
    rng = np.random.default_rng(1)
    for i in range(n):
        folder = root / f"{i // 1000:03d}"
        if i % 1000 == 0:
            folder.mkdir(parents=True)
        write(Signal(("a", "b"), rng.normal(size=(20, 2)), Fraction(30)), folder / f"clip{i:06d}.npz")


def _processor_seconds() -> float:
    """Return what this process and all that have ended before it took."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def one(root: str, out: str, workers: str, chunk: str) -> None:
    """Run in a process of its own, so that its memory is its own."""
    settings_given = {"method": "linear", "length": "80%"}
    begun, used = time.perf_counter(), _processor_seconds()
    if workers == "0":
        planned = plan(survey(Path(root), Path(out), Recipe(Treatment().with_(settings(settings_given)))), Known())
        for task in planned.tasks:
            assert retime_clip(task)[0].status == "done"
        n = len(planned.tasks)
    else:
        result = run(root, out, settings_given, workers=int(workers), chunk=int(chunk))
        assert result.counts["done"] == result.n_clips, result.counts
        n = result.n_clips
    answer = {
        "clips": n,
        "workers": int(workers),
        "chunk": int(chunk),
        "seconds": time.perf_counter() - begun,
        "processor_seconds": _processor_seconds() - used,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }
    if workers != "0":
        begun = time.perf_counter()
        kept = run(root, out, settings_given, workers=int(workers), chunk=int(chunk))
        assert kept.counts["kept"] == n, kept.counts
        answer["again_seconds"] = time.perf_counter() - begun
    print(json.dumps(answer))


def _asked(root: str, n_workers: int, chunk: int) -> dict[str, float]:
    with tempfile.TemporaryDirectory() as out:
        command = [sys.executable, "-c", _ONE, str(HERE), root, out, str(n_workers), str(chunk)]
        answer = subprocess.run(command, check=True, capture_output=True, text=True)
    found: dict[str, float] = json.loads(answer.stdout.splitlines()[-1])
    return found


def main() -> None:
    """Measure, print, and keep the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clips", type=int, nargs="+", default=[1000, 5000, 20000, 50000])
    parser.add_argument("--chunks", type=int, nargs="+", default=[8])
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--save", type=Path)
    given = parser.parse_args()
    rows = []
    for n in given.clips:
        with tempfile.TemporaryDirectory() as root:
            make_clips(Path(root, "in"), n)
            alone = _asked(f"{root}/in", 0, 1)
            for chunk in given.chunks:
                row = _asked(f"{root}/in", given.workers, chunk)
                row["alone_ms"] = 1000 * alone["processor_seconds"] / n
                row["overhead_ms"] = 1000 * (row["processor_seconds"] - alone["processor_seconds"]) / n
                rows.append(row)
                print(
                    f"{n:>7,} clips, chunks of {chunk:>2}: {row['seconds']:7.1f} s; processor time a clip: alone "
                    f"{row['alone_ms']:5.2f} ms, overhead {row['overhead_ms']:5.2f} ms; again "
                    f"{row['again_seconds']:6.1f} s; {row['peak_mb']:5.0f} MB",
                    flush=True,
                )
    if given.save is not None:
        given.save.write_text(json.dumps({"workers": given.workers, "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
