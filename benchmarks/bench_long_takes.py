"""Measure long takes: the whole command, reading, writing, motionless clips, and memory as a take gets longer.

    python benchmarks/bench_long_takes.py [--quick] [--results FOLDER] [--older PYTHON] [--hour]

Makes its own clips at 120 Hz. --older names the Python of an environment with an earlier retime, with which the whole
command is compared; the results then say which version that is. --hour measures the memory of an hour too, which takes
minutes. Ratios are of one run, in turns. On a machine that others use, the ratio of the least times and that of
processor time say more than the clock's: both are kept.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import clips
import numpy as np
from measure import HERE, VERSION, Bench, NotHere, Times, machine, n_cores, ratio, save, summary, take_turns

import retime

RATE = 120
MINUTES = 10
COMMAND = "import sys; from retime.cli.main import main; sys.exit(main())"
ASK_VERSION = "from importlib.metadata import version; print(version('retime'))"


def finished(words: list[str]) -> tuple[float, float, int]:
    """Run a process: seconds of the clock, of the processor, and the most bytes that it held."""
    # As a user has it: modules are compiled once, in the first run.
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    start = time.perf_counter()
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=environment)
    assert process.stderr is not None
    said = process.stderr.read()
    # The times of this one child; subprocess would keep them to itself.
    _, status, used = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - start
    process.returncode = os.waitstatus_to_exitcode(status)
    process.stderr.close()
    if process.returncode:
        raise RuntimeError(f"{' '.join(words)} failed: {said.decode(errors='replace')}")
    # macOS counts bytes, others kilobytes.
    most = used.ru_maxrss << (0 if sys.platform == "darwin" else 10)
    return seconds, used.ru_utime + used.ru_stime, most


class LongTakes:
    """The rows, each measured by a method of its own."""

    def __init__(self, bench: Bench, quick: bool, older: str | None, hour: bool) -> None:
        self.bench, self.older, self.hour = bench, older, hour
        self.n_frames = 600 if quick else MINUTES * 60 * RATE
        self.rounds, self.seconds = (2, 0.01) if quick else (5, 120.0)
        self.rows: list[dict[str, Any]] = []
        self.moving, self.still = bench.folder / "moving.bvh", bench.folder / "still.bvh"
        take = clips.long_motion(self.n_frames)
        retime.write(take, self.moving)
        same = np.zeros(self.n_frames, dtype=np.int64)
        angles = take.declared_angles
        retime.write(
            replace(
                take, rotations=take.rotations[same], translations=take.local_translations[same],
                declared_angles=None if angles is None else angles[same],
            ),
            self.still,
        )  # fmt: skip

    def warp(self, clip: Path, python: str = sys.executable) -> list[str]:
        """Return the words of the whole command on a clip."""
        out = str(self.bench.folder / "out.bvh")
        return [python, "-c", COMMAND, "warp", str(clip), "--length", "80%", "-o", out, "--force", "--quiet"]

    def command(self, clip: Path, python: str = sys.executable) -> Callable[[], dict[str, float]]:
        """Return a contender: the whole command, as a process of its own."""

        def run() -> dict[str, float]:
            seconds, processor, most = finished(self.warp(clip, python))
            return {"total": seconds, "processor": processor, "bytes": float(most)}

        return run

    def row(
        self, what: str, target: float | None, times: Times, ours: str, theirs: str, *, stages: tuple[str, ...]
    ) -> None:
        """Compare two contenders, and keep a row; met where the least of the first stage meets it."""
        found = {stage: ratio(times, ours, theirs, stage=stage) for stage in stages}
        first = found[stages[0]]
        low, high = first["quartiles"]
        text = f"{first['ratio']:.2f}x ({low:.2f} to {high:.2f}); " + ", ".join(
            f"least {stage} {ratios['of_least']:.2f}x" for stage, ratios in found.items()
        )
        met = None if target is None else first["of_least"] <= target
        self.rows.append({
            "what": what, "target": "" if target is None else f"<= {target:g}x", "met": met, "text": text,
            "ratios": found, "seconds": summary(times),
        })  # fmt: skip
        print(f"{what:<60} {self.rows[-1]['target']:<8} {text}", flush=True)

    def left_out(self, what: str, why: str) -> None:
        """Keep a row of what could not be measured."""
        self.rows.append({"what": what, "target": "", "met": None, "text": why})
        print(f"{what:<60} {why}", flush=True)

    def whole(self) -> None:
        """Time the whole command, against an earlier version and on a clip in which nothing moves."""
        contenders = {"moving": self.command(self.moving), "still": self.command(self.still)}
        version = ""
        if self.older is not None:
            version = subprocess.run(
                [self.older, "-c", ASK_VERSION], check=True, capture_output=True, text=True
            ).stdout.strip()
            contenders["older"] = self.command(self.moving, self.older)
        times = take_turns(contenders, rounds=self.rounds, seconds=self.seconds)
        kinds = ("total", "processor")
        what = f"retime warp, {self.n_frames:,} frames to 80 %, whole process"
        if self.older is None:
            self.left_out(f"{what}, against an earlier version", "no earlier version was named (--older)")
        else:
            self.row(f"{what}, against version {version}", 0.6, times, "moving", "older", stages=(*kinds, "bytes"))
        self.row("the same on a clip in which nothing moves, against one that moves", 1.0, times, "still", "moving",
                 stages=kinds)  # fmt: skip

    def files(self) -> None:
        """Time reading and writing, against pybvh."""
        out = self.bench.folder
        ours = self.bench.worker(n_cores()).task("copy_retime", motion=str(self.moving), output=str(out / "a.bvh"))
        try:
            theirs = self.bench.worker(n_cores(), "peers").task(
                "whole_pybvh", motion=str(self.moving), output=str(out / "b.bvh")
            )
        except NotHere as error:
            self.left_out("reading and writing, against pybvh", str(error))
            return
        times = take_turns({"retime": ours, "pybvh": theirs}, rounds=self.rounds, seconds=self.seconds)
        for stage, what, target in (("read", "reading", 0.3), ("write", "writing", None)):
            self.row(f"{what} {self.n_frames:,} frames, against pybvh", target, times, "retime", "pybvh",
                     stages=(stage,))  # fmt: skip

    def memory(self) -> None:
        """Tell the most memory that the whole command holds, and what an hour takes more."""
        _, _, short = finished(self.warp(self.moving))
        text, figures = f"{short / 1e9:.2f} GB", {"frames": [self.n_frames], "bytes": [short]}
        met = None
        if self.hour:
            clip, n_frames = self.bench.folder / "hour.bvh", 6 * self.n_frames
            retime.write(clips.long_motion(n_frames), clip)
            seconds, processor, long = finished(self.warp(clip))
            figures = {"frames": [self.n_frames, n_frames], "bytes": [short, long], "seconds": [seconds, processor]}
            text += f"; {n_frames:,} frames: {long / 1e9:.2f} GB, {long / short:.1f} times as much"
            met = long <= 4e9
        target = "<= 4 GB an hour" if self.hour else ""
        self.rows.append({"what": f"the most memory of the whole command, {self.n_frames:,} frames", "target": target,
                          "met": met, "text": text, **figures})  # fmt: skip
        print(f"{self.rows[-1]['what']:<60} {target:<8} {text}", flush=True)


def main() -> None:
    """Run, print, and save long_takes.json."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="tiny sizes: only shows that everything runs")
    parser.add_argument("--results", type=Path, help="folder for the JSON [default: as the others; with --quick: none]")
    parser.add_argument("--older", metavar="PYTHON", help="the Python of an environment with an earlier retime")
    parser.add_argument("--hour", action="store_true", help="measure the memory of an hour too")
    options = parser.parse_args()
    folder = options.results or (None if options.quick else HERE / "results" / VERSION)
    conditions = {"machine": machine(), "motion": clips.source()}
    with Bench() as bench:
        takes = LongTakes(bench, options.quick, options.older, options.hour)
        for measure in (takes.files, takes.whole, takes.memory):
            measure()
    if folder:
        print("wrote", save("long_takes", {**conditions, "rows": takes.rows}, folder))


if __name__ == "__main__":
    main()
