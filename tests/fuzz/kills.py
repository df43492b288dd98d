"""Kill -9 in the midst of autosaves, saves, exports and batches: nothing that was acknowledged is lost, all is whole.

    python -m tests.fuzz.kills --count 1000 --seed 1

What is killed is a fork of this process, so that a trial takes some hundredths of a second; the moment is drawn anew
for each.
"""

from __future__ import annotations

import functools
import json
import os
import random
import signal
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np

from retime.batch import run as run_batch
from retime.formats import read, write
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.project.document import ClipFile, Document, Key
from retime.project.file import read_project
from retime.project.journal import Edit
from retime.project.workspace import open_project
from retime.warp.curve import Warp
from tests.fuzz.trials import command_apart
from tests.warp.motions import wandering_motion

Tell = Callable[[str], None]


def _killed(work: Callable[[Tell], None], lines: int, seconds: float) -> list[str]:
    """Run something in a fork of this process until it has told so many lines, and so long after; return its lines."""
    source, sink = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(source)
            work(lambda line: os.write(sink, f"{line}\n".encode()) and None)
        finally:
            os._exit(0)
    os.close(sink)
    with os.fdopen(source) as told:
        found = []
        while len(found) < lines and (line := told.readline()):
            found.append(line)
        # What it is at takes some milliseconds: the kill comes at any moment of it.
        time.sleep(seconds)
        os.kill(child, signal.SIGKILL)
        found += told.readlines()
    os.waitpid(child, 0)
    return [line[:-1] for line in found if line.endswith("\n")]


def edits(draw: random.Random, folder: Path) -> str:
    """Kill an editor that edits and saves; what it told is in its journal, and in its file."""
    place = folder / "p.retime"
    start = Document((ClipFile("/clips/a.bvh"),))

    def work(tell: Tell) -> None:
        workspace = open_project(place, start)
        for number in range(1, 100_000):
            # Of different lengths, so that half of one would be seen.
            keys = tuple(Key(f"k{i}", 0.001 * number, 1.0 + i) for i in range(number % 50 + 1))
            edit = Edit(replace(workspace.history.present, keys=keys), f"to {number}", "", True)
            workspace.history = workspace.history.edit(edit.document, label=edit.label)
            workspace.journal.edit(edit, workspace.history, {})
            tell(f"edit {number}")
            if number % 3 == 0:
                workspace.save(place, workspace.history, {}, overwrite=False)
                tell(f"save {number}")

    told = {"edit": 0, "save": 0}
    for line in _killed(work, draw.randint(1, 12), draw.uniform(0, 0.01)):
        what, number = line.split()
        told[what] = int(number)
    if told["save"]:
        saved = _number(read_project(place).document)
        assert told["save"] <= saved <= told["edit"] + 1, f"saved {told}, found {saved}"
    workspace = open_project(place, start)
    found = _number(workspace.history.present)
    assert told["edit"] <= found <= told["edit"] + 1, f"told {told}, found {found}"
    assert not workspace.notes, workspace.notes
    workspace.close()
    return f"an editor is killed {'after' if told['save'] else 'before'} a save was told"


def _number(document: Document) -> int:
    """Say which edit a document is of; all of it must be there."""
    keys = document.keys
    if not keys:
        return 0
    number = round(1000 * keys[0].input_time)
    assert len(keys) == number % 50 + 1, f"{len(keys)} keys of edit {number}"
    return number


@functools.cache
def _motions() -> tuple[Motion, ...]:
    return tuple(wandering_motion(5 + 3 * length, seed=length) for length in range(7))


def _written(number: int, place: Path) -> None:
    """Write something over what is there, by which it can be told what number it was."""
    if place.suffix == ".json":
        Warp([0.0, 1.0 + number], [0.0, 1.0]).save(place, overwrite=True)
    elif place.suffix == ".bvh":
        write(_motions()[number % 7], place, overwrite=True)
    else:
        values = np.full((2 + number % 50, 3), float(number))
        write(Signal(("x", "y", "z"), values, Fraction(30)), place, overwrite=True)


def exports(draw: random.Random, folder: Path) -> str:
    """Kill what writes over a file again and again; the file is one that was told, or the one after it."""
    suffix = draw.choice([".bvh", ".csv", ".npz", ".json"])
    place = folder / f"out{suffix}"

    def work(tell: Tell) -> None:
        for number in range(1, 100_000):
            _written(number, place)
            tell(str(number))

    told = int(_killed(work, draw.randint(1, 8), draw.uniform(0, 0.005))[-1])
    if suffix == ".json":
        found = round(Warp.load(place).output_end) - 1
    elif suffix == ".bvh":
        clip = read(place)
        found = next(number for number in (told, told + 1, -1) if _motions()[number % 7].n_frames == clip.n_frames)
    else:
        clip = read(place)
        assert isinstance(clip, Signal)
        found = int(clip.values[0, 0])
        assert (clip.values == found).all()
        assert clip.n_frames == 2 + found % 50
    assert told <= found <= told + 1, f"told {told}, found {found}"
    # A file that was begun goes with the next write, once nobody holds it: no more than one is there.
    others = [path.name for path in folder.iterdir() if path != place]
    assert len(others) <= 1, others
    return f"a write of {suffix} is killed"


def batches(draw: random.Random, folder: Path) -> str:
    """Kill a batch, and run it again: all is as of a run that nobody killed, and what was done is not done again."""
    clips = folder / "clips"
    clips.mkdir()
    for number, motion in enumerate(_motions()):
        write(motion, clips / f"{number}.bvh")

    def work(tell: Tell) -> None:
        def done(task: object, records: object) -> None:
            tell("done")

        run_batch(clips, folder / "out", {"length": "80%"}, workers=0, progress=done)

    told = _killed(work, draw.randint(0, 6), draw.uniform(0, 0.1))
    again = run_batch(clips, folder / "out", {"length": "80%"}, workers=0)
    statuses = [record.status for record in again.records]
    # What was told is kept; its process may have ended one more.
    assert statuses[: len(told)] == ["kept"] * len(told), statuses
    assert set(statuses) <= {"kept", "done"}, statuses
    assert len(statuses) == 7, statuses
    lines = [json.loads(line) for line in (folder / "out" / "manifest.jsonl").read_text().splitlines()]
    assert {line["output"] for line in lines} == {f"{number}.bvh" for number in range(7)}
    for number, motion in enumerate(_motions()):
        assert read(folder / "out" / f"{number}.bvh").n_frames == max(1, round(0.8 * motion.n_frames))
    left = list((folder / "out").rglob(".retime-*.tmp"))
    assert len(left) <= 1, left
    return f"a batch is killed {'in the midst' if told else 'at its beginning'}"


def trial(draw: random.Random) -> str:
    """Kill one thing at some moment, and look at what it left."""
    # A batch starts processes of its own, which take their time.
    what = draw.choices([edits, exports, batches], [60, 38, 2])[0]
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        return what(draw, Path(name))


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(command_apart(trial, __doc__, name="kills", most_bytes=None))
