"""Kill -9 in the midst of saves and autosaves: nothing that was acknowledged is lost, and the file is whole.

python -m tests.fuzz.kills --count 200 --seed 1
"""

from __future__ import annotations

import random
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

from retime.project.document import ClipFile, Document
from retime.project.file import read_project
from retime.project.workspace import open_project
from tests.fuzz.trials import command

EDITOR = """
import sys
from dataclasses import replace
from pathlib import Path
from retime.project.document import ClipFile, Document, Key
from retime.project.journal import Edit
from retime.project.workspace import open_project

workspace = open_project(Path(sys.argv[1]), Document((ClipFile("/clips/a.bvh"),)))
for number in range(1, 100000):
    # Of different lengths, so that half of one would be seen.
    keys = tuple(Key(f"k{i}", 0.001 * number, 1.0 + i) for i in range(number % 50 + 1))
    edit = Edit(replace(workspace.history.present, keys=keys), f"to {number}", "", True)
    workspace.history = workspace.history.edit(edit.document, label=edit.label)
    workspace.journal.edit(edit, workspace.history, {})
    print("edit", number, flush=True)
    if number % 3 == 0:
        workspace.save(Path(sys.argv[1]), workspace.history, {}, overwrite=False)
        print("save", number, flush=True)
"""


def trial(draw: random.Random) -> str:
    """Start an editor, kill it at some moment, and open what it left."""
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        place = Path(name) / "p.retime"
        process = subprocess.Popen([sys.executable, "-c", EDITOR, str(place)], stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        lines = [process.stdout.readline() for _ in range(draw.randint(1, 12))]
        # A save takes some milliseconds: the kill comes at any moment of it.
        time.sleep(draw.uniform(0, 0.01))
        process.kill()
        lines += process.stdout.read().splitlines(keepends=True)
        process.stdout.close()
        process.wait(30)
        told = {"edit": 0, "save": 0}
        for line in lines:
            if line.endswith("\n"):
                what, number = line.split()
                told[what] = int(number)
        if told["save"]:
            saved = _number(read_project(place).document)
            assert told["save"] <= saved <= told["edit"] + 1, f"saved {told}, found {saved}"
        workspace = open_project(place, Document((ClipFile("/clips/a.bvh"),)))
        found = _number(workspace.history.present)
        assert told["edit"] <= found <= told["edit"] + 1, f"told {told}, found {found}"
        assert not workspace.notes, workspace.notes
        workspace.close()
    return "killed before a save was told" if not told["save"] else "killed after a save was told"


def _number(document: Document) -> int:
    """Say which edit a document is of; all of it must be there."""
    keys = document.keys
    if not keys:
        return 0
    number = round(1000 * keys[0].input_time)
    assert len(keys) == number % 50 + 1, f"{len(keys)} keys of edit {number}"
    return number


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(command(trial, __doc__, most_seconds=60))
