"""Time how scores and search grow, in n, m, r, s and threads; their memory; and what share of the machine they reach.

    python benchmarks/bench_growth.py [--quick] [--results FOLDER]

The machine's peaks are measured in the same run. n: input frames, m: output frames, r: reference frames, s: max_skip.
"""

from __future__ import annotations

from typing import Any

import clips
from measure import Bench, Task, arguments, exponent, machine, n_cores, ratio, save, summary, take_turns

# Poses of the captures have 90 numbers; of the sample clip, fewer.
SKIP = 8


class Growth:
    """Measurements that share a bench and a long take."""

    def __init__(self, bench: Bench, quick: bool) -> None:
        self.bench, self.quick = bench, quick
        self.longest = 120 if quick else 48_000
        self.take = clips.long_take(self.longest)
        self.reference = clips.long_take(60 if quick else 4000, seed=7)
        self.rounds, self.seconds = (2, 0.01) if quick else (7, 1.0)
        self.case = bench.case("growth", self.take, self.reference)
        self.mirror = bench.case("mirror", self.reference, self.take)

    def scale(self, *sizes: int) -> list[int]:
        """Return the sizes; the first two, and a hundredth of them, for a quick run."""
        return [max(30, size // 100) * (place + 1) for place, size in enumerate(sizes[:2])] if self.quick else [*sizes]

    def turns(self, tasks: dict[Any, Task]) -> dict[str, dict[str, Any]]:
        """Time tasks in turns, and forget them."""
        found = summary(
            take_turns({str(key): task for key, task in tasks.items()}, rounds=self.rounds, seconds=self.seconds)
        )
        for task in tasks.values():
            task.drop()
        return found

    def path_in_n(self) -> dict[str, Any]:
        """Search takes of growing length, m = 0.6 n; the layered recurrence for the shorter ones."""
        scores = self.bench.scores("growth", self.case, SKIP)
        sizes = self.scale(3000, 6000, 12_000, 24_000, 48_000)
        worker = self.bench.worker(1)
        found: dict[str, Any] = {
            "n_input": sizes,
            "n_output": [round(0.6 * n) for n in sizes],
            "r": len(self.reference),
        }
        for search, some in (("priced", sizes), ("layered", sizes[:3])):
            tasks = {
                n: worker.task("retime_path", scores=scores, n_input=n, n_output=round(0.6 * n), search=search)
                for n in some
            }
            times = take_turns({str(n): task for n, task in tasks.items()}, rounds=self.rounds, seconds=self.seconds)
            figures = summary(times)
            seconds = [figures[str(n)]["median"] for n in some]
            least = [figures[str(n)]["min"] for n in some]
            found[search] = {
                "seconds": seconds, "least": least,
                "exponent": exponent(some, seconds), "exponent_of_least": exponent(some, least),
                "facts": [tasks[n].facts() for n in some],
                "peak_bytes": [
                    self.bench.peak(1, "retime_path", scores=scores, n_input=n, n_output=round(0.6 * n), search=search)
                    for n in some
                ],
            }  # fmt: skip
            for task in tasks.values():
                task.drop()
        return found

    def path_hard(self) -> dict[str, Any]:
        """Search takes most of whose motions the reference doesn't have: whole stretches switch speed at one price."""
        sizes = self.scale(3000, 6000, 12_000)
        case = self.bench.case("hard", self.take[: sizes[-1]], self.reference[: len(self.reference) // 4])
        scores, worker = self.bench.scores("hard", case, SKIP), self.bench.worker(1)
        tasks = {n: worker.task("retime_path", scores=scores, n_input=n, n_output=round(0.6 * n)) for n in sizes}
        figures = summary(
            take_turns({str(n): task for n, task in tasks.items()}, rounds=self.rounds, seconds=self.seconds)
        )
        return {
            "n_input": sizes, "r": len(self.reference) // 4, "facts": [tasks[n].facts() for n in sizes],
            "seconds": [figures[str(n)]["median"] for n in sizes],
        }  # fmt: skip

    def path_in_m(self) -> dict[str, Any]:
        """Search one take for growing lengths of the output."""
        n = self.scale(6000)[0]
        scores = self.bench.scores("growth", self.case, SKIP)
        lengths = [round(share * n) for share in (0.2, 0.4, 0.6, 0.8, 0.95)]
        worker = self.bench.worker(1)
        figures = self.turns({m: worker.task("retime_path", scores=scores, n_input=n, n_output=m) for m in lengths})
        return {"n_input": n, "n_output": lengths, "seconds": [figures[str(m)]["median"] for m in lengths]}

    def path_in_s(self) -> dict[str, Any]:
        """Search one take with growing max_skip."""
        n = self.scale(3000)[0]
        skips, worker = [4, 8] if self.quick else [4, 8, 12, 16, 24], self.bench.worker(1)
        case = self.bench.case("skips", self.take[:n], self.reference[: max(30, len(self.reference) // 4)])
        tasks = {
            s: worker.task("retime_path", scores=self.bench.scores("skips", case, s), n_output=round(0.6 * n))
            for s in skips
        }
        figures = self.turns(tasks)
        return {"n_input": n, "max_skip": skips, "seconds": [figures[str(s)]["median"] for s in skips]}

    def scores(self, what: str, sizes: list[int]) -> dict[str, Any]:
        """Score with growing n, r or s; the others stay at 500, 500 and 8."""
        fixed = 30 if self.quick else 500
        worker, tasks = self.bench.worker(1), {}
        arguments: dict[int, dict[str, Any]] = {}
        for size in sizes:
            n, r = (size if what == "n" else fixed), (size if what == "r" else fixed)
            case = self.bench.case(f"{what}{size}", self.take[:n], clips.long_take(r, seed=3))
            arguments[size] = {"case": case, "max_skip": size if what == "s" else SKIP}
            tasks[size] = worker.task("retime", **arguments[size])
        figures = self.turns(tasks)
        seconds = [figures[str(size)]["stages"]["scores"] for size in sizes]
        found = {what: sizes, "seconds": seconds, "exponent": exponent(sizes, seconds)}
        if what == "r":
            found["peak_bytes"] = [self.bench.peak(1, "retime", **arguments[size]) for size in sizes]
        return found

    def threads(self) -> dict[str, Any]:
        """Score and search on one thread and on all cores, in turns."""
        n = self.scale(2000)[0]
        case = self.bench.case("threads", self.take[:n], self.take[:n])
        tasks = {
            threads: self.bench.worker(threads).task("retime", case=case, max_skip=SKIP, n_output=round(0.6 * n))
            for threads in sorted({1, n_cores()})
        }
        times = take_turns({str(k): task for k, task in tasks.items()}, rounds=self.rounds, seconds=3 * self.seconds)
        most = str(max(tasks))
        return {
            "n_input": n, "n_reference": n, "seconds": summary(times),
            "scores_ratio": ratio(times, "1", most, stage="scores"),
            "path_ratio": ratio(times, "1", most, stage="path"),
        }  # fmt: skip

    def roofline(self) -> dict[str, Any]:
        """Measure the machine's peaks, and the scores beside them, all on one thread."""
        worker, side = self.bench.worker(1), 256 if self.quick else 1536
        n = self.scale(1000)[0]
        far, near = (1 << 20, 1 << 16) if self.quick else (1 << 28, 1 << 18)
        inputs = self.take[:n]
        case = self.bench.case("roofline", inputs, inputs)
        n_row, repeats = 2048, 2000
        copies = max(1, far // near // 4)
        found = self.turns({
            "gemm": worker.task("gemm", size=side),
            "memory": worker.task("copy", n_bytes=far, repeats=1),
            "cache": worker.task("copy", n_bytes=near, repeats=copies),
            "subtract": worker.task("subtract", n_numbers=n_row, repeats=repeats),
            "retime": worker.task("retime", case=case, max_skip=SKIP),
            "one step": worker.task("retime", case=case, max_skip=1),
        })  # fmt: skip
        least = {name: figures["min"] for name, figures in found.items()}
        least["retime"] = found["retime"]["stages_min"]["scores"]
        least["one step"] = found["one step"]["stages_min"]["scores"]
        # A triple meets each inner reference frame with one subtraction and one comparison. With max_skip = 1 there are
        # few triples: nearly all that is left are the products, which don't depend on it.
        pairs = sum(n - a - b for a in range(1, SKIP + 1) for b in range(1, SKIP + 1)) * (n - 2)
        loop = least["retime"] - least["one step"]
        return {
            "n_input": n, "n_reference": n, "max_skip": SKIP, "n_numbers": inputs.shape[1],
            "peak_gflops": 2 * side**3 / least["gemm"] / 1e9,
            "memory_gbytes": 2 * far / least["memory"] / 1e9,
            "cache_gbytes": 2 * near * copies / least["cache"] / 1e9,
            "subtract_gflops": n_row * repeats / least["subtract"] / 1e9,
            "scores_seconds": least["retime"],
            "products_seconds": least["one step"],
            "products_gflops": 6 * n * n * inputs.shape[1] / least["one step"] / 1e9,
            "pairs": pairs,
            "loop_gflops": 2 * pairs / loop / 1e9,
            "loop_gbytes": 8 * pairs / loop / 1e9,
        }  # fmt: skip

    def path_roofline(self) -> list[dict[str, Any]]:
        """Search within the cache and beyond it, beside reading as much memory, on one thread."""
        scores, worker, found = self.bench.scores("growth", self.case, SKIP), self.bench.worker(1), []
        sizes = self.scale(3000, 6000, 12_000, 24_000, 48_000)
        for n in (sizes[0], sizes[-1]):
            n_bytes = 8 * n * SKIP * SKIP
            repeats = max(1, (1 << 20 if self.quick else 1 << 26) // n_bytes)
            tasks = {
                "path": worker.task("path_work", scores=scores, n_input=n, n_output=round(0.6 * n)),
                "read": worker.task("read_through", n_bytes=n_bytes, repeats=repeats),
            }
            times = take_turns(tasks, rounds=3 * self.rounds, seconds=self.seconds)
            facts, figures = tasks["path"].facts(), summary(times)
            for task in tasks.values():
                task.drop()
            stages = figures["path"]["stages_min"]
            # Each pair of steps takes an addition and a comparison.
            numbers = facts["sweeps"] * n * SKIP * SKIP
            found.append({
                "n_input": n, "max_skip": SKIP, "n_bytes": n_bytes, **facts,
                "seconds": figures["path"]["min"], "sweep_seconds": stages["sweeps"],
                "sweep_gbytes": 8 * numbers / stages["sweeps"] / 1e9,
                "sweep_gflops": 2 * numbers / stages["sweeps"] / 1e9,
                "read_gbytes": n_bytes * repeats / figures["read"]["min"] / 1e9,
            })  # fmt: skip
        return found


def main() -> None:
    """Run, print, and save growth.json."""
    options = arguments("Time growth in n, m, r, s and threads; memory; the machine's peaks.")
    results: dict[str, Any] = {"machine": machine(), "motion": clips.source()}
    print(f"Motion: {results['motion']}.")
    with Bench() as bench:
        growth = Growth(bench, options.quick)
        results["roofline"] = growth.roofline()
        results["path_roofline"] = growth.path_roofline()
        results["threads"] = growth.threads()
        results["path_in_n"] = growth.path_in_n()
        results["path_hard"] = growth.path_hard()
        results["path_in_m"] = growth.path_in_m()
        results["path_in_s"] = growth.path_in_s()
        results["scores_in_n"] = growth.scores("n", growth.scale(500, 1000, 2000, 4000, 8000))
        results["scores_in_r"] = growth.scores("r", growth.scale(500, 1500, 5000, 16_000, 48_000))
        results["scores_in_s"] = growth.scores("s", [2, 4] if options.quick else [2, 4, 8, 12, 16])
    for name, found in results.items():
        print(f"{name}: {found}")
    if options.results:
        print("wrote", save("growth", results, options.results))


if __name__ == "__main__":
    main()
