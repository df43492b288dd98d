"""A library with broken and deadly clips, on a cluster whose workers are killed, begun anew in the middle.

python -m tests.batch.storm --clips 2000 --kills 30
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import retime
from retime.batch import BatchResult, run

UNRULY = Path(__file__).parent / "unruly"
SETTINGS = {"length": "80%"}
SECONDS = 10.0


@dataclass(frozen=True)
class Library:
    """A made library.

    Attributes
    ----------
    root : Path
        Its folder.
    good : tuple of str
        Clips that can be done.
    bad : dict of str to str
        Clips that can't, and the code that is right for each.
    """

    root: Path
    good: tuple[str, ...]
    bad: dict[str, str]


def make_library(root: Path, n: int, seed: int) -> Library:
    """Write clips; of each hundred, five are damaged, and one ends its process or never ends."""
    rng = np.random.default_rng(seed)
    whole = retime.sample()
    good: list[str] = []
    bad: dict[str, str] = {}
    root.mkdir(parents=True)
    damages = ("cut", "empty", "png", "nan", "short")
    for i in range(n):
        folder = f"set{i % 7}/subject{i % 3}"
        (root / folder).mkdir(parents=True, exist_ok=True)
        start = int(rng.integers(0, whole.n_frames - 60))
        name = f"{folder}/clip{i:05d}.bvh"
        unruly = ("kills", "hangs")[i // 100 % 2]
        if i % 100 == 50:
            name = f"{folder}/{unruly}{i:05d}.bvh"
        place = root / name
        length = 2 if i % 20 == 7 and damages[i // 20 % 5] == "short" else int(rng.integers(30, 60))
        retime.write(whole.frames(start, start + length), place)
        if i % 20 == 7:
            data, kind = place.read_bytes(), damages[i // 20 % 5]
            if kind == "cut":
                place.write_bytes(data[: len(data) * 2 // 3])
            elif kind == "empty":
                place.write_bytes(b"")
            elif kind == "png":
                place.write_bytes(b"\x89PNG\r\n\x1a\n" + data[:100])
            elif kind == "nan":
                place.write_bytes(data[:-20] + b" nan\n")
            bad[name] = "option" if kind == "short" else "format"
        elif i % 100 == 50:
            bad[name] = {"kills": "killed", "hangs": "timeout"}[unruly]
        else:
            good.append(name)
    return Library(root, tuple(good), bad)


def contents(out: Path) -> dict[str, bytes]:
    """Read all that a run has left of clips."""
    return {
        path.relative_to(out).as_posix(): path.read_bytes()
        for path in out.rglob("*")
        if path.is_file() and ".retime/" not in path.relative_to(out).as_posix() and path.suffix == ".bvh"
    }


def left_overs(out: Path) -> list[Path]:
    """Find what was begun and not ended."""
    return list(out.rglob(".retime-*.tmp"))


def environment() -> dict[str, str]:
    """Return the environment in which clips of certain names are deadly."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join([str(UNRULY), *filter(None, sys.path)])}


def run_in_process(library: Library, out: Path) -> BatchResult:
    """Do the good clips one after the other, with no Dask, as what the rest is compared with."""
    return run(library.root, out, SETTINGS, workers=0)


def start(library: Library, out: Path, workers: int) -> subprocess.Popen[bytes]:
    """Start the command, as a user does."""
    command = [sys.executable, "-m", "retime", "batch", str(library.root), "--out", str(out), "--json"]
    command += ["--length", SETTINGS["length"], "--workers", str(workers), "--time-limit", str(SECONDS)]
    return subprocess.Popen(command, env=environment(), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)


def children_of(pid: int) -> list[int]:
    """Return the processes that a process has started."""
    found = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            found.append(int(status.parent.name))
    return found


def workers_of(pid: int) -> list[int]:
    """Return the workers of a command's cluster: processes started by Python's multiprocessing from it."""
    found = []
    for child in children_of(pid):
        try:
            words = Path(f"/proc/{child}/cmdline").read_bytes()
        except OSError:
            continue
        if b"multiprocessing.spawn" in words or b"spawn_main" in words:
            found.append(child)
    return found


def kill_workers(process: subprocess.Popen[bytes], out: Path, kills: int, rng: random.Random) -> int:
    """Kill workers at random moments until so many have died, or the command ends; return how many died."""
    killed, begun = 0, time.time()
    while killed < kills and process.poll() is None:
        time.sleep(rng.uniform(0.1, 0.8))
        workers = workers_of(process.pid)
        # A cluster is up once something was done.
        journals = list((out / ".retime").glob("journal-*"))
        if not workers or not any(journal.stat().st_mtime > begun for journal in journals):
            continue
        try:
            os.kill(rng.choice(workers), signal.SIGKILL)
        except ProcessLookupError:
            continue
        killed += 1
    return killed


def wait_for_lines(path: Path, lines: int, seconds: float = 120.0) -> None:
    """Wait until a manifest has so many lines."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if path.exists() and path.read_bytes().count(b"\n") >= lines:
            return
        time.sleep(0.05)
    raise TimeoutError(f"{path} has not got {lines} lines in {seconds:g} s")


@dataclass(frozen=True)
class Outcome:
    """What became of a storm.

    Attributes
    ----------
    faults : list of str
        What is not as it should be.
    killed : int
        Workers that were killed.
    kept, done : int
        Of the run that followed the one that was killed.
    """

    faults: list[str]
    killed: int
    kept: int
    done: int


def storm(folder: Path, *, clips: int, kills: int, seed: int, workers: int = 2) -> Outcome:
    """Do a library while everything dies; compare with the same done in peace."""
    rng = random.Random(seed)
    library = make_library(folder / "in", clips, seed)
    out = folder / "out"
    manifest = out / "manifest.jsonl"
    # The first run is killed as a whole when a third is done, the scheduler with it.
    first = start(library, out, workers)
    wait_for_lines(manifest, clips // 3)
    first.kill()
    first.communicate()
    before = {
        json.loads(line)["output"]
        for line in manifest.read_bytes().splitlines()
        if json.loads(line)["status"] != "failed"
    }
    # The second loses its workers one by one.
    second = start(library, out, workers)
    killed = kill_workers(second, out, kills, rng)
    answer = json.loads(second.communicate()[0])
    faults = []
    records = [json.loads(line) for line in manifest.read_text().splitlines()]
    by_name = {record["name"]: record for record in records}
    if len(records) != clips or len(by_name) != clips:
        faults.append(f"{len(records)} lines of {len(by_name)} clips, of {clips}")
    for name, code in library.bad.items():
        found = by_name.get(name, {})
        if found.get("code") != code or not found.get("message"):
            faults.append(f"{name}: expected {code}, found {found.get('code')}: {found.get('message')}")
    kept = {record["name"] for record in records if record["status"] == "kept"}
    again = [name for name in before if name not in kept]
    if again:
        faults.append(f"{len(again)} clips were done twice: {again[:3]}")
    if left_overs(out):
        faults.append(f"left over: {left_overs(out)[:3]}")
    peace = folder / "peace"
    quiet = run(library.root, peace, SETTINGS, workers=0)
    wanted = {record.name for record in quiet.records if record.status != "failed"}
    if not set(library.good) <= wanted:
        faults.append("in peace some good clips failed")
    expected, found_files = contents(peace), contents(out)
    for name in library.good:
        if found_files.get(name) != expected[name]:
            faults.append(f"{name} is not what a single process makes of it")
    strangers = set(found_files) - set(library.good)
    if strangers:
        faults.append(f"outputs of clips that can't be done: {sorted(strangers)[:3]}")
    if Counter(answer["failures"]) != Counter(library.bad.values()):
        faults.append(f"failures {answer['failures']}, expected {Counter(library.bad.values())}")
    # Whatever is left to do, a third run does nothing.
    third = json.loads(start(library, out, workers).communicate()[0])
    if third["done"] or third["kept"] != len(library.good):
        faults.append(f"the third run did {third['done']} and kept {third['kept']}")
    return Outcome(faults, killed, answer["kept"], answer["done"])


def main() -> None:
    """Say what became of it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--clips", type=int, default=200)
    parser.add_argument("--kills", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        outcome = storm(Path(folder), clips=given.clips, kills=given.kills, seed=given.seed)
        print(f"{outcome}, {time.perf_counter() - begun:.0f} s")
    sys.exit(bool(outcome.faults))


if __name__ == "__main__":
    main()
