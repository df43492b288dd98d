"""Measure each of the project's speed targets as a ratio in one run, and say whether it is met.

    python benchmarks/bench_targets.py [--quick] [--results FOLDER]

Peaks are those of a fresh process while it runs the task, less what it held when all was loaded: a path's scores and a
score's poses are not counted, everything that retime makes of them is, its result too.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import clips
from measure import (
    Bench,
    NotHere,
    arguments,
    command,
    exponent,
    machine,
    n_cores,
    ratio,
    save,
    summary,
    take_turns,
)

import retime

PEER = "scikit-learn brute + NumPy"
RETIME = ("-c", "import sys; from retime.cli.main import main; sys.exit(main())")


class Targets:
    """The rows, each measured by a method of its own."""

    def __init__(self, bench: Bench, quick: bool) -> None:
        self.bench, self.quick = bench, quick
        self.rounds, self.seconds = (2, 0.02) if quick else (11, 3.0)
        self.rows: list[dict[str, Any]] = []

    def row(self, what: str, target: str, measured: float | None, met: bool | None, text: str, **figures: Any) -> None:
        """Keep a row and print it."""
        self.rows.append({"what": what, "target": target, "measured": measured, "met": met, "text": text, **figures})
        verdict = "not measured" if met is None else "met" if met else "NOT MET"
        print(f"{what:<62} {target:<20} {text:<58} {verdict}", flush=True)

    def compare(self, contenders: dict[str, Callable[[], dict[str, float]]], **options: Any) -> Any:
        """Time contenders in turns."""
        return take_turns(contenders, rounds=self.rounds, seconds=self.seconds, **options)

    def v1(self) -> None:
        """V1's size: both scores, one thread, against what a user would build."""
        size, inputs, reference = clips.table_size("V1")
        if self.quick:
            size, inputs, reference = size._replace(n_output=30), inputs[:50], reference[:50]
        shared = {
            "case": self.bench.case("V1", inputs, reference),
            "max_skip": size.max_skip,
            "n_output": size.n_output,
        }
        worker = self.bench.worker(1)
        contenders: dict[str, Callable[[], dict[str, float]]] = {
            score: worker.task("retime", score=score, **shared) for score in ("joint", "conditional")
        }
        rows = (("joint", "V1 size, scores + path, one thread", 40), ("conditional", "the same, conditional score", 80))
        try:
            contenders[PEER] = self.bench.worker(n_cores(), "peers").task("peer", library="sklearn brute", **shared)
        except NotHere as error:
            for _, what, least in rows:
                self.row(what, f">= {least}x", None, None, str(error))
            return
        times = self.compare(contenders)
        found = summary(times)
        for score, what, least in rows:
            self.at_least(what, least, times, PEER, score, seconds={name: found[name] for name in (score, PEER)})

    def at_least(self, what: str, least: float, times: Any, slow: str, fast: str, **figures: Any) -> None:
        """Add a row: `fast` must be so many times faster."""
        found, both = ratio(times, slow, fast), summary(times)
        low, high = found["quartiles"]
        text = (
            f"{found['ratio']:.1f}x ({low:.1f} to {high:.1f}; {_ms(both[fast]['median'])} against "
            f"{_ms(both[slow]['median'])})"
        )
        self.row(what, f">= {least:g}x", found["ratio"], found["ratio"] >= least, text, figures=found, **figures)

    def at_most(self, what: str, most: float, times: Any, ours: str, theirs: str, **figures: Any) -> None:
        """Add a row: ours may take so many times as long."""
        found, both = ratio(times, ours, theirs), summary(times)
        low, high = found["quartiles"]
        text = (
            f"{found['ratio']:.2f}x ({low:.2f} to {high:.2f}; {_ms(both[ours]['median'])} against "
            f"{_ms(both[theirs]['median'])})"
        )
        self.row(what, f"<= {most:g}x", found["ratio"], found["ratio"] <= most, text, figures=found, **figures)

    def path(self) -> None:
        """Path alone, against the compiled layered recurrence on the same scores."""
        n, m = (80, 48) if self.quick else (1775, 1065)
        take = clips.long_take(n, seed=11)
        scores = self.bench.scores("path", self.bench.case("path", take, take), 8)
        worker = self.bench.worker(1)
        tasks = {
            search: worker.task("retime_path", scores=scores, n_output=m, search=search)
            for search in ("priced", "layered")
        }
        times = self.compare(tasks)
        same = tasks["priced"].facts()["total"] == tasks["layered"].facts()["total"]
        self.at_least(
            f"path alone, n = {n}, m = {m}, s = 8, against C++ layers", 5, times, "layered", "priced", same=same
        )

    def long_path(self) -> None:
        """Growth of the path's time up to 48,000 frames, and the longest one's proof and memory."""
        sizes = [30, 120] if self.quick else [3000, 6000, 12_000, 24_000, 48_000]
        case = self.bench.case("long", clips.long_take(sizes[-1]), clips.long_take(30 if self.quick else 4000, seed=7))
        scores = self.bench.scores("long", case, 8)
        worker = self.bench.worker(1)
        wanted = {n: {"scores": scores, "n_input": n, "n_output": round(0.6 * n)} for n in sizes}
        tasks = {str(n): worker.task("retime_path", **wanted[n]) for n in sizes}
        found = summary(self.compare(tasks))
        seconds = [found[str(n)]["median"] for n in sizes]
        slope = exponent(sizes, seconds)
        self.row(
            f"growth of path time from n = {sizes[0]} to {sizes[-1]}, exponent", "<= 1.15", slope, slope <= 1.15,
            f"{slope:.2f} ({_ms(seconds[0])} to {_ms(seconds[-1])})",
            n_input=sizes, seconds=seconds, exponent_of_least=exponent(sizes, [found[str(n)]["min"] for n in sizes]),
        )  # fmt: skip
        facts, n = tasks[str(sizes[-1])].facts(), sizes[-1]
        peak = self.bench.peak(1, "retime_path", **wanted[n]) / 1e6
        own = Path(scores).stat().st_size / 1e6
        self.row(
            f"path, n = {n}, m = {round(0.6 * n)}, s = 8: optimal, peak memory", "<= 300 MB", peak,
            bool(facts["optimal"]) and peak + own <= 300,
            f"{'optimal' if facts['optimal'] else 'not proved'}, {peak:.0f} MB + {own:.0f} MB of scores, "
            f"{_ms(seconds[-1])}",
            search=facts["search"], seconds=seconds[-1], peak_mb=peak, scores_mb=own,
        )  # fmt: skip

    def long_scores(self) -> None:
        """Scores of a self-reference: memory, time of a part with bounds and without, and an approximate index."""
        # A quarter of the input: what is prepared once must not weigh more than it does for all of it.
        n, part = (200, 50) if self.quick else (48_000, 12_000)
        take = clips.long_take(n)
        case = self.bench.case("self", take, take)
        middle = {"case": case, "max_skip": 8, "first": n // 2, "last": n // 2 + part}
        worker = self.bench.worker(1)
        names = {"bounds": True, "no bounds": False}
        times = take_turns(
            {name: worker.task("retime", bounds=bounds, **middle) for name, bounds in names.items()},
            rounds=2, seconds=self.seconds,
        )  # fmt: skip
        # Scoring works through the input in tiles: beyond a few of them only the result grows, by 64 numbers a frame.
        some = n // 16
        peak = self.bench.peak(n_cores(), "retime", case=case, max_skip=8, last=some) / 1e9
        peak += (n - some) * 8 * 64 / 1e9
        self.row(
            f"scores, self-reference of {n} frames, peak memory", "<= 1.5 GB", peak, peak <= 1.5,
            f"{peak:.2f} GB above {take.nbytes / 1e9:.2f} GB of poses (run for n = {some}, the result's rest added)",
        )  # fmt: skip
        found = ratio(times, "no bounds", "bounds", stage="scores")
        seconds = {name: figures["stages"]["scores"] for name, figures in summary(times).items()}
        self.row(
            f"the same, {part} frames of the input, against no bounds", ">= 3x", found["ratio"], found["ratio"] >= 3,
            f"{found['ratio']:.2f}x ({seconds['bounds']:.2f} s against {seconds['no bounds']:.2f} s)",
            figures=found, seconds=seconds, index=self.index(case, n, part // 20),
        )  # fmt: skip

    def index(self, case: str, n: int, part: int) -> dict[str, Any] | str:
        """Time an approximate index against the exact scores, all on one thread; and what it loses."""
        worker = self.bench.worker(1)
        middle = {"case": case, "max_skip": 8, "first": n // 2, "last": n // 2 + part}
        found: dict[str, Any] = {"n_input": part, "exact": worker.task("retime", **middle)()["scores"]}
        try:
            for probes in (1, 8):
                task = worker.task("index", lists=max(4, n // 200), probes=probes, **middle)
                found[f"{probes} probes"] = {**task(), **task.facts()}
                task.drop()
        except NotHere as error:
            return str(error)
        print(f"an approximate index for {part} frames of the input: {found}")
        return found

    def whole(self) -> None:
        """Time the whole command on 16 s at 120 Hz, against reading and writing the file with pybvh."""
        folder = self.bench.folder
        clip, out, other = folder / "clip.bvh", folder / "out.bvh", folder / "other.bvh"
        retime.write(clips.motion(121 if self.quick else 1921), clip)
        read_write = (
            "import sys, warnings, pybvh; warnings.simplefilter('ignore'); "
            "pybvh.write_bvh_file(pybvh.read_bvh_file(sys.argv[1]), sys.argv[2])"
        )
        try:
            theirs = self.bench.worker(n_cores(), "peers").task("whole_pybvh", motion=str(clip), output=str(other))
        except NotHere as error:
            self.row("retime warp on 16 s, 120 Hz", "<= 8x", None, None, str(error))
            return
        ours = self.bench.worker(n_cores()).task("whole_retime", motion=str(clip), output=str(out), length="65%")
        processes = {
            "retime": command(
                sys.executable, *RETIME, "warp", str(clip), "--length", "65%", "-o", str(out), "--force", "--quiet"
            ),
            "pybvh": command(sys.executable, "-W", "ignore", "-c", read_write, str(clip), str(other)),
        }
        self.at_most("retime warp on 16 s, 120 Hz, whole processes", 8, self.compare(processes), "retime", "pybvh")
        times = self.compare({"retime": ours, "pybvh": theirs})
        stages = summary(times)["retime"]["stages"]
        self.at_most("the same, within a process", 8, times, "retime", "pybvh", stages=stages, warp=ours.facts())

    def session(self) -> None:
        """Time moving a keytime in a session, against a cold solve; V1's size from a motion at 120 Hz."""
        clip = self.bench.folder / "session.bvh"
        retime.write(clips.motion(161 if self.quick else 1969), clip)
        shared = {"motion": str(clip), "key": [0.6, 0.4] if self.quick else [8.0, 5.0], "length": "57%"}
        worker = self.bench.worker(n_cores())
        tasks = {name: worker.task("session", moved=name == "moved", **shared) for name in ("moved", "cold")}
        times = self.compare(tasks)
        self.at_most(
            "moving one keytime in a session, V1 size, against cold", 0.2, times, "moved", "cold",
            facts={name: task.facts() for name, task in tasks.items()},
        )  # fmt: skip

    def start(self) -> None:
        """Time the start of `retime info`, against importing NumPy."""
        sample = str(Path(retime.__file__).parent / "data" / "sample.bvh")
        times = self.compare({
            "numpy": command(sys.executable, "-c", "import numpy"),
            "help": command(sys.executable, *RETIME, "info", "--help"),
            "info": command(sys.executable, *RETIME, "info", sample),
        })  # fmt: skip
        self.at_most("retime info --help, against import numpy", 3, times, "help", "numpy")
        self.at_most("retime info on the sample clip, against import numpy", 3, times, "info", "numpy")


def _ms(seconds: float) -> str:
    return f"{seconds * 1e3:.3g} ms" if seconds < 1 else f"{seconds:.2f} s"


def main() -> None:
    """Run, print, and save targets.json."""
    options = arguments("Measure the speed targets.")
    conditions = {"machine": machine(), "motion": clips.source()}
    print(f"Motion: {conditions['motion']}.")
    with Bench() as bench:
        targets = Targets(bench, options.quick)
        for measure in (
            targets.v1, targets.path, targets.long_path, targets.long_scores,
            targets.whole, targets.session, targets.start,
        ):  # fmt: skip
            measure()
    if options.results:
        print("wrote", save("targets", {**conditions, "rows": targets.rows}, options.results))


if __name__ == "__main__":
    main()
