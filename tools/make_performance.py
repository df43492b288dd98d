"""Write docs/performance.md and its plots from the newest results in benchmarks/results ("make bench" makes them).

Usage: python tools/make_performance.py
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results"
PAGE = ROOT / "docs" / "performance.md"
IMAGES = ROOT / "docs" / "images"
PEER = "scikit-learn brute + NumPy"
ALONE = "retime, one thread"
CONDITIONAL = "retime, conditional, one thread"

_HEAD = """\
# Performance

Generated from `benchmarks/results/{version}` by `tools/make_performance.py`; `make bench` measures again and rewrites
both.

{how}

A *ratio* compares two contenders of one run that took turns: the median of the ratios of single rounds, and in
brackets their quartiles. Absolute times (medians, unless it says least) belong to the machine they were measured on.
V1 to V7 are sizes: those of the paper's evaluations, as [the study](study/README.md) has them.
"""

_TARGETS = """
## Targets

| what | target | measured | |
|---|---|---|---|
{rows}

* The V1 yardstick is what a user would build: feature vectors of all triples in NumPy, scikit-learn's brute-force k-NN
  on all cores, the layered recurrence in NumPy. retime runs on one thread.
* Memory is the peak of a fresh process above what it held with its data loaded. For the path, the scores are added.
* *No bounds* is the loop that shorter references get: every triple meets every reference frame in all its numbers.
  With bounds, the reference is put in order, projected on the directions that hold nearly all of its variance, triples
  begin with the neighbours of the triple before, and blocks of 64 frames are rejected by their centre and radius. Both
  give the same bits; the time to put it in order counts. [Decisions](decisions.md) say what limits the ratio.
"""

_LONG_TAKES = """
## Long takes

A figure of 31 joints at 120 Hz, made for the purpose, no two frames alike. Measured apart from the rest, on {cores}
cores with Python {python}, at a load of {load} when it began.

| what | target | measured | |
|---|---|---|---|
{rows}

* *processor* is the time that all cores together worked for it, *total* that of the clock. Where the load is above the
  cores' number, others worked at the same time: the ratio of processor times, and of least times, are what to go by.
* pybvh keeps a file's angles; reading here makes rotations of them too, and checks every number.
"""

_SIZES = """
## The eight sizes of Table 1

Scores and path, {motion}. n, m, r: frames of the input, the output and the reference; s: `max_skip`; k = 3
neighbours. The peer is scikit-learn's brute force on all cores and a NumPy recurrence; the ratio is its time to that of
retime's joint score and path on one thread.

| | n | m | r | s | scores, ms | path, ms | conditional, ms | all cores, ms | peer, ms | ratio |
|---|---|---|---|---|---|---|---|---|---|---|
{rows}

![Times of the eight sizes](images/performance_sizes.svg)

### All peers at V1's size

| | ms | least | what it does |
|---|---|---|---|
{peers}

{left_out}"""

_DOES = {
    ALONE: "joint scores, priced search",
    "retime, all cores": "the same",
    CONDITIONAL: "conditional scores, priced search",
    "retime, layered, one thread": "joint scores, layered recurrence (compiled)",
    "retime, NumPy backend, one thread": "where nothing could be compiled: joint scores, layered recurrence",
    PEER: "joint scores on all cores, layered recurrence",
    "scikit-learn k-d tree": "joint scores alone, all cores; every 20th triple, times 20",
    "scipy cKDTree": "joint scores alone, all cores; every 20th triple, times 20",
    "faiss flat": "joint scores alone, all cores, single precision",
    "NumPy recurrence": "path alone",
    "Numba recurrence": "path alone, one thread, compiled before",
    "gdtw": "the nearest relative: aligns one number with a given shorter signal; another problem of like size",
}

_GROWTH = """
## Growth

One thread. Takes are joined from real clips, each pass in another order and at other speeds, with a thousandth of
noise.

![Growth in n, m, r and s](images/performance_growth.svg)

| path, m = 0.6 n, s = 8 | {sizes} | exponent |
|---|{dashes}---|
{path}

The reference has {r:,} frames, about as many as all the clips together.
{hard}

* Scores grow with n to the power {scores_n:.2f}, with r to the power {scores_r:.2f}, with s to the power
  {scores_s:.2f}.
* Memory that the scores take for n = {fixed}: {memory}.
* {cores} cores against one at n = r = {threads_n}: scores {threads_scores}; the search runs on one thread.
"""

_ROOFLINE = """
## Against the machine's peak

All on one thread, in one run, least times; n = r = {n_input}, s = {max_skip}, {n_numbers} numbers a pose.

| what | reached | of this machine's |
|---|---|---|
| scores at s = 1, as if they were three matrix products, 6 n r d operations | {products_gflops:.0f} GFLOP/s | \
{products_share} of a large `sgemm`, {peak_gflops:.0f} GFLOP/s |
| what s = {max_skip} takes more, as if it were a loop over triples and reference frames, 2 operations each | \
{loop_gflops:.1f} GFLOP/s | \
{loop_share} of the same |
| the same, reading 8 bytes each | {loop_gbytes:.1f} GB/s | \
{loop_bytes_share} of a copy within the cache, {cache_gbytes:.0f} GB/s |

A triple meets each reference frame with one subtraction and one minimum, on products made once a pair of frames, in
tiles that stay in the cache. Scores with s = 1 have nearly all of the products and few of the triples
({products_ms:.1f} ms of the {scores_ms:.1f} ms at s = {max_skip}); what more triples take, for {pairs:.3g} pairs of a
triple and a reference frame, is the other row. The minimum needs no comparison until 64 frames are through, and eight
triples share what they load. At V1's size a third of the row is that loop; the rest sets each triple's limit, and
measures its few candidates in double precision, from products of single steps that all triples of a frame share.
What keeps the loop from the peak: one subtraction and one minimum to every load, and no multiplication to join with
an addition.
"""

_PATH_ROOFLINE = """
### The search

Least times on one thread. A sweep reads every score once, and makes an addition and a comparison of it. *Read* is the
speed at which NumPy finds the least number of an array as large as the scores, in the same run.

| | scores | sweeps | a sweep | reached | of reading | the rest of the search |
|---|---|---|---|---|---|---|
{rows}

Within the cache, latency binds: each frame waits for the one before it, whose costs are stored, read, added and
compared in turn. Beyond it the scores come from memory. A sweep asks for those of the frames ahead; what it takes
longer than within the cache is the time that they need to come. So full sweeps are what to save: long spans guess
their price from pieces that stay in the cache, and what follows the sweeps touches near-optimal vertices only.
"""


def main() -> None:
    """Write the page and its plots."""
    results = newest()
    PAGE.write_text(page(results), encoding="utf-8")
    draw(results)


def newest() -> dict[str, Any]:
    """Load the results of the last release that has some."""
    folder = max(RESULTS.iterdir(), key=lambda folder: [int(part) for part in folder.name.split(".") if part.isdigit()])
    found = {name: json.loads((folder / f"{name}.json").read_text()) for name in ("sizes", "growth", "targets")}
    # Results of an earlier release lack them.
    long_takes = folder / "long_takes.json"
    if long_takes.exists():
        found["long_takes"] = json.loads(long_takes.read_text())
    return {"version": folder.name, **found}


def page(results: Mapping[str, Any]) -> str:
    """Return the text of docs/performance.md."""
    sizes, growth, targets = results["sizes"], results["growth"], results["targets"]
    machine = sizes["machine"]
    packages = ", ".join(f"{name} {version}" for name, version in machine["packages"].items())
    how = (
        f"Measured on {machine['cores']} cores ({machine['system']}, {', '.join(machine['simd'])}; "
        f"load {machine['load_before']} when it began) with Python {machine['python']}, {packages}. "
        f"The motion: {sizes['motion']}."
    )
    return (
        _HEAD.format(version=results["version"], how=how)
        + _TARGETS.format(rows="\n".join(map(_target, targets["rows"])))
        + _long_takes(results.get("long_takes"))
        + _sizes(sizes)
        + _growth(growth)
        + _roofline(growth["roofline"])
        + _path_roofline(growth.get("path_roofline", ()))
    )


def _target(row: Mapping[str, Any]) -> str:
    verdict = "met" if row["met"] else "**not met**"
    if row["met"] is None:
        verdict = "not measured" if row["target"] else ""
    return f"| {row['what']} | {row['target'].replace('>=', '≥').replace('<=', '≤')} | {row['text']} | {verdict} |"


def _long_takes(found: Mapping[str, Any] | None) -> str:
    if found is None:
        return ""
    return _LONG_TAKES.format(
        rows="\n".join(map(_target, found["rows"])),
        cores=found["machine"]["cores"],
        load=found["machine"]["load_before"],
        python=found["machine"]["python"],
    )


def _sizes(sizes: Mapping[str, Any]) -> str:
    rows = []
    for name, row in sizes["sizes"].items():
        found = row["contenders"]
        cells = [name, row["n_input"], row["n_output"], row["n_reference"], row["max_skip"]]
        cells += [_ms(found[ALONE]["stages"][stage]) for stage in ("scores", "path")]
        cells += [_ms(found[label]["median"]) for label in (CONDITIONAL, "retime, all cores")]
        if PEER in found:
            ratio = row["ratios"][ALONE]
            cells += [_ms(found[PEER]["median"]), f"{ratio['ratio']:.0f}x ({_range(ratio['quartiles'])})"]
        else:
            cells += ["", ""]
        rows.append("| " + " | ".join(map(str, cells)) + " |")
    peers = [
        f"| {label} | {_ms(figures['median'])} | {_ms(figures['min'])} | {_DOES[label]} |"
        for label, figures in sizes["sizes"]["V1"]["contenders"].items()
    ]
    left_out = "".join(f"* Left out: {peer}: {why}.\n" for peer, why in sizes["left_out"].items())
    return _SIZES.format(rows="\n".join(rows), peers="\n".join(peers), motion=sizes["motion"], left_out=left_out)


def _growth(growth: Mapping[str, Any]) -> str:
    path, scores_r, threads = growth["path_in_n"], growth["scores_in_r"], growth["threads"]
    lines = []
    for search in ("priced", "layered"):
        found = path[search]
        empty = [""] * (len(path["n_input"]) - len(found["seconds"]))
        cells = [*(f"{_ms(seconds)} ms" for seconds in found["seconds"]), *empty, f"{found['exponent']:.2f}"]
        lines.append(f"| {search} | " + " | ".join(cells) + " |")
        cells = [*(f"{peak / 1e6:.1f} MB" for peak in found["peak_bytes"]), *empty, ""]
        lines.append(f"| {search}, memory | " + " | ".join(cells) + " |")
    hard = growth["path_hard"]
    excess = max(facts["excess"] for facts in hard["facts"])
    slow = ", ".join(
        f"n = {n:,} took {_ms(seconds)} ms ({facts['search']})"
        for n, seconds, facts in zip(hard["n_input"], hard["seconds"], hard["facts"], strict=True)
    )
    return _GROWTH.format(
        r=path["r"],
        hard=(
            f"With {hard['r']:,} frames of it, which lack most of the motions, {slow}; "
            f"the optimum was at most {excess * 100:.2g} % above the bound found first."
        ),
        sizes=" | ".join(f"n = {n:,}" for n in path["n_input"]),
        dashes="---|" * len(path["n_input"]),
        path="\n".join(lines),
        scores_n=growth["scores_in_n"]["exponent"],
        scores_r=scores_r["exponent"],
        scores_s=growth["scores_in_s"]["exponent"],
        fixed=growth["scores_in_n"]["n"][0],
        memory=", ".join(
            f"{peak / 1e6:.0f} MB at r = {r:,}"
            for r, peak in zip(scores_r["r"], scores_r["peak_bytes"], strict=True)
        ),
        cores=growth["machine"]["cores"],
        threads_n=threads["n_input"],
        threads_scores=f"{threads['scores_ratio']['ratio']:.2f}x ({_range(threads['scores_ratio']['quartiles'])})",
    )  # fmt: skip


def _roofline(found: Mapping[str, Any]) -> str:
    return _ROOFLINE.format(
        **found,
        products_share=_share(found["products_gflops"] / found["peak_gflops"]),
        loop_share=_share(found["loop_gflops"] / found["peak_gflops"]),
        loop_bytes_share=_share(found["loop_gbytes"] / found["cache_gbytes"]),
        n_neighbors=3,
        scores_ms=found["scores_seconds"] * 1e3,
        products_ms=found["products_seconds"] * 1e3,
    )


def _path_roofline(found: Sequence[Mapping[str, Any]]) -> str:
    # Results of an earlier release may lack them.
    if not found:
        return ""
    rows = [
        f"| n = {row['n_input']:,} | {row['n_bytes'] / 1e6:.1f} MB | {row['sweeps']} | "
        f"{_ms(row['sweep_seconds'] / row['sweeps'])} ms | {row['sweep_gbytes']:.1f} GB/s, "
        f"{row['sweep_gflops']:.1f} GFLOP/s | {_share(row['sweep_gbytes'] / row['read_gbytes'])} of "
        f"{row['read_gbytes']:.1f} GB/s | {_ms(row['seconds'] - row['sweep_seconds'])} ms, {row['labels']:,} labels |"
        for row in found
    ]
    return _PATH_ROOFLINE.format(rows="\n".join(rows))


def _ms(seconds: float) -> str:
    return f"{seconds * 1e3:,.{0 if seconds >= 0.1 else 1 if seconds >= 0.01 else 2}f}"


def _range(quartiles: Sequence[float]) -> str:
    low, high = quartiles
    digits = 0 if high >= 10 else 2
    return f"{low:.{digits}f} to {high:.{digits}f}"


def _share(share: float) -> str:
    return f"{share * 100:.{0 if share >= 0.1 else 1}f} %"


def draw(results: Mapping[str, Any]) -> None:
    """Write the plots."""
    import matplotlib as mpl

    mpl.use("svg")
    import matplotlib.pyplot as plt

    # The same figures give the same file.
    mpl.rcParams.update(
        {"svg.hashsalt": "retime", "font.size": 9, "axes.spines.top": False, "axes.spines.right": False}
    )
    labels = {ALONE: "retime", CONDITIONAL: "retime, conditional score", PEER: "scikit-learn (all cores) + NumPy"}
    colors = {ALONE: "#0b6e99", CONDITIONAL: "#7fb8d0", PEER: "#b0b0b0"}
    sizes = results["sizes"]["sizes"]
    figure, axes = plt.subplots(figsize=(7.2, 2.8), layout="constrained")
    for place, (label, text) in enumerate(labels.items()):
        found = [(x, row["contenders"][label]) for x, row in enumerate(sizes.values()) if label in row["contenders"]]
        heights = [figures["median"] * 1e3 for _, figures in found]
        axes.bar([x + 0.27 * (place - 1) for x, _ in found], heights, 0.25, label=text, color=colors[label])
    axes.set(yscale="log", ylabel="scores + path, ms", xticks=range(len(sizes)))
    axes.set_xticklabels([f"{name}\nn = {row['n_input']}" for name, row in sizes.items()])
    axes.legend(frameon=False, ncols=3, loc="lower left", bbox_to_anchor=(0, 1))
    _save(figure, "performance_sizes.svg")

    growth = results["growth"]
    figure, panels = plt.subplots(2, 2, figsize=(7.2, 5.2), layout="constrained")
    path = growth["path_in_n"]
    for search, color in (("priced", "#0b6e99"), ("layered", "#b0b0b0")):
        found = path[search]
        n = path["n_input"][: len(found["seconds"])]
        panels[0, 0].plot(n, [1e3 * t for t in found["seconds"]], "o-", color=color, label=search, ms=4)
        panels[0, 1].plot(n, [peak / 1e6 for peak in found["peak_bytes"]], "o-", color=color, label=search, ms=4)
    panels[0, 0].set(xscale="log", yscale="log", xlabel="n (m = 0.6 n, s = 8)", ylabel="path, ms")
    panels[0, 1].set(xscale="log", yscale="log", xlabel="n (m = 0.6 n, s = 8)", ylabel="path, MB")
    for panel in panels[0]:
        # Over little more than one power of ten every number would have a label, each in the way of the next.
        panel.set_xticks(path["n_input"], [f"{n:,}" for n in path["n_input"]])
        panel.set_xticks([], minor=True)
    panels[0, 0].legend(frameon=False)
    for what, color in (("n", "#0b6e99"), ("r", "#c1531b"), ("s", "#3f7d20")):
        found = growth[f"scores_in_{what}"]
        start = found[what][0]
        panels[1, 0].plot(
            [size / start for size in found[what]], [1e3 * t for t in found["seconds"]], "o-", color=color, ms=4,
            label=f"{what}, from {start}",
        )  # fmt: skip
    panels[1, 0].set(xscale="log", yscale="log", xlabel="times as large", ylabel="scores, ms")
    panels[1, 0].legend(frameon=False)
    lengths = growth["path_in_m"]
    shares = [m / lengths["n_input"] for m in lengths["n_output"]]
    panels[1, 1].plot(shares, [1e3 * t for t in lengths["seconds"]], "o-", color="#0b6e99", ms=4)
    panels[1, 1].set(xlabel=f"m / n, n = {lengths['n_input']:,}", ylabel="path, ms", ylim=(0, None), xlim=(0, 1))
    _save(figure, "performance_growth.svg")


def _save(figure: Any, name: str) -> None:
    IMAGES.mkdir(parents=True, exist_ok=True)
    figure.savefig(IMAGES / name, metadata={"Date": None})


if __name__ == "__main__":
    main()
