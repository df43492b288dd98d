"""Time the eight sizes of the paper's Table 1 on real motion, against what a user would build this from.

    python benchmarks/bench_sizes.py [--quick] [--results FOLDER]

Peers that are not installed are left out, with a message; requirements/bench.txt has them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import clips
from measure import Bench, NotHere, arguments, machine, n_cores, ratio, save, summary, take_turns

Contender = Callable[[], dict[str, float]]

# k-d trees are slow in 270 dimensions: they answer each so-many-th triple only, and their time is multiplied.
EVERY = 20


def main() -> None:
    """Run, print, and save sizes.json."""
    options = arguments("Time the eight sizes of Table 1, against peers.")
    results: dict[str, Any] = {"machine": machine(), "motion": clips.source(), "sizes": {}, "left_out": {}}
    print(f"Motion: {results['motion']}. Seconds are medians.")
    with Bench() as bench:
        for name in ["V1"] if options.quick else clips.SIZES:
            results["sizes"][name] = one_size(bench, name, results["left_out"], quick=options.quick)
    for peer, why in results["left_out"].items():
        print(f"left out: {peer}: {why}")
    if options.results:
        print("wrote", save("sizes", results, options.results))


def one_size(bench: Bench, name: str, left_out: dict[str, str], *, quick: bool) -> dict[str, Any]:
    """Measure one row of Table 1."""
    size, inputs, reference = clips.table_size(name)
    if quick:
        size = size._replace(n_input=50, n_output=30, n_reference=40)
        inputs, reference = inputs[:50], reference[:40]
    case = bench.case(name, inputs, reference)
    shared = {"case": case, "max_skip": size.max_skip, "n_output": size.n_output}
    alone, all_cores = bench.worker(1), bench.worker(n_cores())
    contenders: dict[str, Contender] = {
        "retime, one thread": alone.task("retime", **shared),
        "retime, all cores": all_cores.task("retime", **shared),
        "retime, conditional, one thread": alone.task("retime", score="conditional", **shared),
    }
    facts = contenders["retime, one thread"]
    wanted: dict[str, dict[str, Any]] = {"scikit-learn brute + NumPy": {"library": "sklearn brute", **shared}}
    if name == "V1":
        contenders["retime, layered, one thread"] = alone.task("retime", search="layered", **shared)
        contenders["retime, NumPy backend, one thread"] = alone.task("retime", kernels="numpy", **shared)
        for label, library in (("scikit-learn k-d tree", "sklearn kd_tree"), ("scipy cKDTree", "scipy")):
            wanted[label] = {"library": library, "case": case, "max_skip": size.max_skip, "every": EVERY}
        wanted["faiss flat"] = {"library": "faiss", "case": case, "max_skip": size.max_skip}
    for label, values in wanted.items():
        add(contenders, left_out, label, lambda values=values: bench.worker(n_cores(), "peers").task("peer", **values))
    if name == "V1":
        scores = bench.scores(name, case, size.max_skip)
        alone_peer = bench.worker(1, "peers")
        for label, library in (("NumPy recurrence", "numpy"), ("Numba recurrence", "numba")):
            add(
                contenders, left_out, label,
                lambda library=library: alone_peer.task(
                    "peer_path", scores=scores, n_output=size.n_output, library=library
                ),
            )  # fmt: skip
        add(contenders, left_out, "gdtw", lambda: alone_peer.task("gdtw", case=case, n_output=size.n_output))
    times = take_turns(contenders, rounds=2 if quick else 9, seconds=0.05 if quick else 1.5)
    found = summary(times)
    row: dict[str, Any] = {
        "n_input": size.n_input, "n_output": size.n_output, "n_reference": size.n_reference,
        "max_skip": size.max_skip, "n_numbers": inputs.shape[1], "path": facts.facts(), "contenders": found,
    }  # fmt: skip
    print(f"{name}: n = {size.n_input}, m = {size.n_output}, r = {size.n_reference}, s = {size.max_skip}")
    for label, figures in found.items():
        stages = ", ".join(f"{stage} {seconds * 1e3:.2f}" for stage, seconds in figures["stages"].items())
        print(f"  {label:<36} {figures['median'] * 1e3:9.2f} ms  (least {figures['min'] * 1e3:.2f})  {stages}")
    peer = "scikit-learn brute + NumPy"
    if peer in times:
        row["ratios"] = {label: ratio(times, peer, label) for label in times if label.startswith("retime")}
        for label, figures in row["ratios"].items():
            print(f"  {label} is {figures['ratio']:.1f}x as fast as {peer}")
    return row


def add(
    contenders: dict[str, Contender], left_out: dict[str, str], label: str, prepare: Callable[[], Contender]
) -> None:
    """Add a contender, or say why it is left out."""
    try:
        contenders[label] = prepare()
    except NotHere as error:
        left_out[label] = str(error)


if __name__ == "__main__":
    main()
