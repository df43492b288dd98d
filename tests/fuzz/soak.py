"""A day at the editor, at speed: whether its process grows.

    python -m tests.fuzz.soak --gestures 7200

A gesture every four seconds makes eight hours of 7,200. Most are drags of a key, each of its steps an edit that is on
disk before the next is sent; others undo and redo, change the length, add and remove keys and locks, save, and export.
The server is a process of its own, whose memory is looked at as it goes: after the first thousand gestures, by when
undo holds all that it may, it grows by no more than a twentieth.
"""

from __future__ import annotations

import argparse
import gc
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from websockets.sync.client import connect

from retime.formats import write
from retime.motion.signal import Signal
from retime.project.allowed_places import AllowedPlaces
from retime.project.workspace import new_document, open_project
from retime.server.app import Editor, EditorServer
from retime.server.messages import VERSION
from tests.server.serving import Page

PROJECT = "soak.retime"
CLIP = "camera.csv"
# Gestures after which it holds what it needs: undo has nearly all the steps that it may have.
SETTLED = 1000
# Every so many gestures the hand rests for so many seconds, as a person's does after nearly each.
_RESTS, _REST = 20, 0.5
# Of what it holds then, the most that it may grow by.
MOST_GROWTH = 0.05
_SAMPLES = 60


@dataclass(frozen=True)
class Outcome:
    """What became of it.

    Attributes
    ----------
    gestures, edits : int
        How many were made.
    seconds : float
        It took.
    settled : int
        Bytes that the process held after the first thousand gestures, or after a tenth of them where they are few.
    most, ended : int
        Bytes that it held at most from then on, and at the end.
    """

    gestures: int
    edits: int
    seconds: float
    settled: int
    most: int
    ended: int

    @property
    def growth(self) -> float:
        """By what share of what it held it grew, at most."""
        return self.most / self.settled - 1


def _clip() -> Signal:
    """Return a short path, so that a search takes some milliseconds."""
    t = np.arange(40)[:, None] / 30
    return Signal(("pan", "tilt"), np.concatenate([np.sin(3 * t**1.4), np.cos(2 * t)], axis=1), Fraction(30))


def serve(folder: Path) -> None:
    """Serve a project of a folder, and say where, until this process is ended."""
    document = new_document([str(folder / CLIP)], [])
    workspace = open_project(folder / PROJECT, document)
    server = EditorServer(Editor(workspace, AllowedPlaces([folder], command=[]), folder / "state", page=folder / "no"))
    print(server.guard.hosts[0], server.guard.cookie, server.guard._secret, flush=True)
    server.serve_until_interrupted()


class Person:
    """Who edits: draws what to do next, and waits until it is done.

    Parameters
    ----------
    page : Page
        The page, which has been greeted.
    draw : random.Random
        What all is drawn from.
    folder : Path
        Where to export to.
    """

    def __init__(self, page: Page, draw: random.Random, folder: Path) -> None:
        self.page, self.draw, self.folder = page, draw, folder
        self.edits = 0
        state = page.until("state")
        page.document, page.revision = state["document"], state["revision"]

    def gesture(self, number: int) -> None:
        """Do one thing."""
        what = self.draw.choices(
            [self._drag, self._change, self._undo, self._save, self._export], [60, 18, 16, 4, 2], k=1
        )[0]
        what(number)
        if number % _RESTS == 0:
            time.sleep(_REST)
        self.page.mail.clear()
        self.page.heard.clear()

    def _edit(self, gesture: str, *, done: bool, label: str, **changes: Any) -> None:
        self.page.edit(gesture, done=done, label=label, **changes)
        self.edits += 1
        # It is on disk before the next one is sent.
        self.page.until("state" if done else "ack", revision=self.page.revision)

    def _drag(self, number: int) -> None:
        """Drag a key, or a new one, through some places; wait for the curve of the last."""
        keys = list(self.page.document["keys"])
        if not keys or (len(keys) < 6 and self.draw.random() < 0.3):
            name, place = f"k{number}", self.draw.uniform(0.1, 1.2)
        else:
            key = self.draw.choice(keys)
            name, place = key["id"], key["input_time"]
            keys.remove(key)
        n_steps = self.draw.randint(4, 20)
        for step in range(n_steps):
            moved = {"id": name, "input_time": place, "output_time": place * (0.7 + 0.02 * step), "speed": None}
            self._edit(f"g{number}", done=step == n_steps - 1, label="move key", keys=[*keys, moved])
        self.page.curve()

    def _change(self, number: int) -> None:
        """Change something at once."""
        document = self.page.document
        changes: list[dict[str, Any]] = [
            {"options": {"length": self.draw.choice(["70%", "90%", "1.2", "free"])}},
            {"keys": document["keys"][1:]},
            {"options": {}},
            {"locks": [{"id": "l", "start": 0.3, "end": 0.5, "slowest": 1.0, "fastest": 1.0}]},
            {"locks": []},
            {"method": self.draw.choice(["guided", "spline", "linear"])},
        ]
        self._edit("", done=True, label="change", **self.draw.choice(changes))
        self.page.curve()

    def _undo(self, number: int) -> None:
        """Take some steps back, and do some of them again."""
        for kind in ["undo"] * self.draw.randint(1, 4) + ["redo"] * self.draw.randint(0, 3):
            self.page.change(kind)
            state = self.page.until("state", revision=self.page.revision)
            self.page.document = state["document"]
        self.page.curve()

    def _save(self, number: int) -> None:
        self.page.say("save", path=None, overwrite=False)
        self.page.until("saved")

    def _export(self, number: int) -> None:
        place = str(self.folder / f"out{self.draw.choice(['.csv', '.json'])}")
        what = "warp" if place.endswith(".json") else "motion"
        self.page.say("export", what=what, path=place, clip=0, overwrite=True)
        # Refused where the document can't be solved, as it is.
        self.page.until("exported", "refused")


def _held(process: int) -> int:
    lines = Path(f"/proc/{process}/status").read_text().splitlines()
    return 1024 * int(next(line for line in lines if line.startswith("VmRSS:")).split()[1])


def soak(gestures: int, seed: int = 1, told: Callable[[str], None] = lambda line: None) -> Outcome:
    """Edit so long, telling now and then how far it is, and return what became of it. Needs /proc."""
    with tempfile.TemporaryDirectory(prefix="retime-soak-") as name:
        folder = Path(name).resolve()
        write(_clip(), folder / CLIP)
        command = [sys.executable, "-m", "tests.fuzz.soak", "--serve", str(folder)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        begun = time.monotonic()
        try:
            host, cookie, secret = process.stdout.readline().split()
            address, headers = f"ws://{host}/socket", {"Cookie": f"{cookie}={secret}"}
            with connect(
                address, origin=f"http://{host}", additional_headers=headers, max_size=None, compression=None
            ) as socket:
                page = Page(socket)
                page.say("hello", version=VERSION)
                page.until("welcome")
                person = Person(page, random.Random(seed), folder)
                held = []
                for number in range(gestures):
                    person.gesture(number)
                    if number % max(1, gestures // _SAMPLES) == 0:
                        held.append((number, _held(process.pid)))
                        told(f"{number} gestures: {held[-1][1] / 2**20:.1f} MB")
        finally:
            process.terminate()
            process.wait(60)
            process.stdout.close()
        gc.collect()
    later = [size for number, size in held if number >= min(SETTLED, gestures // 10)]
    return Outcome(gestures, person.edits, time.monotonic() - begun, later[0], max(later), later[-1])


def main() -> int:
    """Run from a shell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gestures", type=int, default=7200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--serve", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.serve:
        serve(given.serve)
        return 0
    found = soak(given.gestures, given.seed, lambda line: print(line, flush=True))
    settled, most, ended = (f"{size / 2**20:.1f} MB" for size in (found.settled, found.most, found.ended))
    print(
        f"{found.gestures} gestures, {found.edits} edits in {found.seconds:.0f} s; {settled} once settled, "
        f"at most {most} after that ({found.growth:+.1%}), {ended} at the end"
    )
    return int(found.gestures > 2 * SETTLED and found.growth > MOST_GROWTH)


if __name__ == "__main__":
    sys.exit(main())
