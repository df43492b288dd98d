"""Write docs/since-0.1.md: what the newest results in benchmarks/results say beside those of version 0.1.

Usage: python tools/make_comparison.py

``make bench`` runs this after the measurements. Without results of a later version the page says so, and has what a run
measured against an installed 0.1.0 itself.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RESULTS = ROOT / "benchmarks" / "results"
PAGE = ROOT / "docs" / "since-0.1.md"
FIRST = "0.1.0"

_HEAD = """\
# Speed since 0.1

Generated from `benchmarks/results` by `tools/make_comparison.py`; `make bench` measures again and rewrites it. All that
is measured of the newest version, and how, is on [its own page](performance.md).
"""
_BOTH = """
Version {new} beside {old}. The two were measured on different days: {new} on {new_machine}; {old} on {old_machine}.
So a ratio here says no more than which of the two is the faster by far; least times are what other work on the machine
disturbs least. Below 1 is better now.
"""
_ALONE = """
There are no results of a version after {old} yet: `make bench` makes them once the version in `pyproject.toml` is
another.
"""
_IN_TURNS = """
## Measured in turns with 0.1.0

In one run, on one machine, the two versions by turns; below 1x is better now.

| what | target | measured | |
|---|---|---|---|
{rows}
"""


def versions(folder: Path = RESULTS) -> list[str]:
    """Return the versions that there are results of, the oldest first."""
    return sorted(
        (path.name for path in folder.iterdir() if (path / "sizes.json").is_file()),
        key=lambda name: tuple(int(part) for part in name.split(".")),
    )


def results_of(version: str, folder: Path = RESULTS) -> dict[str, Any]:
    """Read the results of a version, a file each."""
    return {
        path.stem: json.loads(path.read_text(encoding="utf-8")) for path in sorted((folder / version).glob("*.json"))
    }


def page(found: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the page for the results of some versions, the oldest first."""
    *_, newest = found
    parts = [_HEAD]
    if newest == FIRST or FIRST not in found:
        parts.append(_ALONE.format(old=FIRST))
    else:
        old, new = found[FIRST], found[newest]
        machines = {"new_machine": _machine(new), "old_machine": _machine(old)}
        parts += [_BOTH.format(old=FIRST, new=newest, **machines), _sizes(old["sizes"], new["sizes"], newest)]
        parts.append(_rows(old, new, newest))
    parts.append(_in_turns(found[newest].get("long_takes", {}).get("rows", ())))
    return "\n".join(part.strip("\n") + "\n" for part in parts if part)


def _machine(results: Mapping[str, Any]) -> str:
    machine = results["sizes"]["machine"]
    return (
        f"{machine['cores']} cores, {machine['system']}, Python {machine['python']}, at a load of "
        f"{machine['load_before']:.1f} when it began"
    )


def _sizes(old: Mapping[str, Any], new: Mapping[str, Any], version: str) -> str:
    """Compare the paper's eight sizes, for each way that both versions measured."""
    lines = ["## The eight sizes of the paper's Table 1", "", f"Least times of a search. {version} against {FIRST}."]
    ways = sorted(
        {way for size in old["sizes"].values() for way in size["contenders"] if way.startswith("retime")}
        & {way for size in new["sizes"].values() for way in size["contenders"]}
    )
    for way in ways:
        lines += ["", f"**{way}**", "", f"| size | {FIRST} | {version} | ratio |", "|---|---|---|---|"]
        for name, before in old["sizes"].items():
            now = new["sizes"].get(name, {}).get("contenders", {}).get(way)
            then = before["contenders"].get(way)
            if now and then:
                ratio = now["min"] / then["min"]
                lines.append(f"| {name} | {_time(then['min'])} | {_time(now['min'])} | {ratio:.2f}x |")
    return "\n".join(lines)


def _rows(old: Mapping[str, Any], new: Mapping[str, Any], version: str) -> str:
    """Put the targets of both versions side by side; each is a ratio of its own run, and so comparable."""
    lines = ["## Targets", "", "Each is a ratio, or a growth, of its own run.", ""]
    lines += [f"| what | {FIRST} | {version} |", "|---|---|---|"]
    before = {row["what"]: row["text"] for row in old["targets"]["rows"]}
    for row in new["targets"]["rows"]:
        lines.append(f"| {row['what']} | {before.get(row['what'], 'not measured')} | {row['text']} |")
    gone = [what for what in before if what not in {row["what"] for row in new["targets"]["rows"]}]
    lines += [f"| {what} | {before[what]} | not measured any more |" for what in gone]
    return "\n".join(lines)


def _in_turns(rows: Sequence[Mapping[str, Any]]) -> str:
    compared = [row for row in rows if f"version {FIRST}" in row["what"]]
    said = {True: "met", False: "**not met**", None: ""}
    lines = [f"| {row['what']} | {row['target']} | {row['text']} | {said[row['met']]} |" for row in compared]
    return _IN_TURNS.format(rows="\n".join(lines)) if lines else ""


def _time(seconds: float) -> str:
    return f"{1000 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def main() -> None:
    """Write the page."""
    PAGE.write_text(page({version: results_of(version) for version in versions()}), encoding="utf-8")


if __name__ == "__main__":
    main()
