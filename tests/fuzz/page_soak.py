"""A day at the page, in a browser: whether what it holds grows.

    python -m tests.fuzz.page_soak --gestures 3000

Keytimes are dragged, made and taken back, lengths are typed, frames are pointed at, the clip is played, help is opened.
Every round of ten ends as it began. Of the page are told the bytes of its heap, the values that its scripts hold, its
nodes and its listeners, each after garbage was collected. Needs node, the page and its npm packages (make page), and
Chromium.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import retime

WEB = Path(__file__).resolve().parents[2] / "web"
# Gestures after which everything was opened once.
SETTLED = 100
# Chromium can take back what was typed in fields, the last thousand times, and keeps a node of text for each where the
# page has written over it since. One in ten gestures types.
TYPED, TAKEN_BACK = 10, 1000
# Of what it holds then, the most that it may grow by, nodes of what was typed left out. The heap has the machine code
# that the browser makes of the scripts, too.
MOST = {"values": 0.02, "nodes": 0.02, "listeners": 0.02, "bytes": 0.2}


@dataclass(frozen=True)
class Held:
    """What a page holds.

    Attributes
    ----------
    number : int
        Gestures so far.
    bytes : int
        Of the heap of its scripts.
    nodes, listeners : int
        How many there are.
    values : int
        Objects, functions and lists of its scripts.
    """

    number: int
    bytes: int
    nodes: int
    listeners: int
    values: int


def soak(gestures: int, every: int, seed: int = 1, told: Callable[[Held], None] = lambda held: None) -> list[Held]:
    """Edit so long, and return what the page held every so many gestures."""
    found = []
    with tempfile.TemporaryDirectory(prefix="retime-soak-") as name:
        folder = Path(name).resolve()
        (folder / "state").mkdir()
        retime.write(retime.sample(), folder / "sample.bvh")
        settings = {
            **{"python": sys.executable, "clip": str(folder / "sample.bvh"), "folder": name, "seed": seed},
            **{"state": str(folder / "state"), "gestures": gestures, "every": every},
        }
        command = ["node", "test/soak.mjs", json.dumps(settings)]
        with subprocess.Popen(command, cwd=WEB, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            for line in process.stdout:
                value = json.loads(line)
                if "errors" in value:
                    assert value["errors"] == [], value["errors"]
                else:
                    found.append(Held(**value))
                    told(found[-1])
        assert process.returncode == 0, f"the browser's script ended with {process.returncode}"
    return found


def grown(held: list[Held], settled: int = SETTLED) -> dict[str, float]:
    """Return by what share of what it held once settled each grew at most, nodes of what was typed left out."""
    first, *later = (one for one in held if one.number >= settled)

    def nodes(one: Held) -> int:
        return one.nodes - min((one.number - first.number) // TYPED, TAKEN_BACK)

    return {
        "values": max(one.values for one in later) / first.values - 1,
        "nodes": max(nodes(one) for one in later) / first.nodes - 1,
        "listeners": max(one.listeners for one in later) / first.listeners - 1,
        "bytes": max(one.bytes for one in later) / first.bytes - 1,
    }


def main() -> int:
    """Run from a shell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gestures", type=int, default=3000)
    parser.add_argument("--every", type=int, default=100, help="gestures between two looks")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    held = soak(given.gestures, given.every, given.seed, lambda one: print(one, flush=True))
    shares = grown(held)
    print(", ".join(f"{what} {share:+.1%}" for what, share in shares.items()), f"after {SETTLED} gestures")
    return int(any(shares[what] > MOST[what] for what in MOST))


if __name__ == "__main__":
    sys.exit(main())
