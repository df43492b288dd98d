"""Hostile folders: outputs that are links, circles of links, pipes, devices and folders; journals that are taken away.

    python -m tests.fuzz.folders --count 10000 --seed 1

All of it happens in a temporary folder, with nodes of its own. Whatever is written, what is no regular file is still
there afterwards, and is what it was; no other file is changed; and nothing is left beside.
"""

from __future__ import annotations

import os
import random
import stat
import sys
import tempfile
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from retime.formats import write
from retime.project.allowed_places import AllowedPlaces
from retime.project.document import ClipFile, Document, Key
from retime.project.journal import Edit, read_journal
from retime.project.workspace import Workspace, open_project
from retime.warp.curve import Warp
from tests.fuzz.trials import command
from tests.warp.motions import wandering_motion, wandering_signal

NAMES = ("a.bvh", "b.bvh", "c.csv", "p.retime", "q.retime", "w.json", "d", ".p.retime-journal")
MOTION, SIGNAL = wandering_motion(3), wandering_signal(3)


def _node(draw: random.Random, path: Path, folder: Path) -> None:
    """Put something in a place."""
    kind = draw.choice(["none", "file", "file", "link", "link", "absolute link", "folder", "pipe", "device"])
    target = draw.choice(NAMES)
    if kind == "file":
        path.write_bytes(draw.choice([b"", b"mine", b"HIERARCHY\n"]))
    elif kind == "link":
        path.symlink_to(target)
    elif kind == "absolute link":
        path.symlink_to(folder / "d" / target)
    elif kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        try:
            # One that takes whatever is written and gives nothing, as /dev/null.
            os.mknod(path, 0o600 | stat.S_IFCHR, os.makedev(1, 3))
        except PermissionError:
            os.mkfifo(path)


def _seen(folder: Path) -> dict[str, tuple[int, object]]:
    """List all nodes: their kinds, and what they hold or point to."""
    found: dict[str, tuple[int, object]] = {}
    for path in sorted(folder.rglob("*")):
        mode = path.lstat().st_mode
        holds: object = None
        if stat.S_ISREG(mode):
            holds = path.read_bytes()
        elif stat.S_ISLNK(mode):
            holds = str(path.readlink())
        found[str(path.relative_to(folder))] = stat.S_IFMT(mode), holds
    return found


def trial(draw: random.Random) -> str:
    """Make a folder, write to it, and compare."""
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        folder = Path(os.path.realpath(name))
        for place in NAMES:
            _node(draw, folder / place, folder)
        if draw.random() < 0.4:
            return _edit(draw, folder)
        before = _seen(folder)
        path = folder / draw.choice(NAMES[:6])
        meant = Path(os.path.realpath(path))
        overwrite = draw.random() < 0.7
        suffix = path.suffix
        actions: dict[str, Callable[[], object]] = {
            ".bvh": lambda: write(MOTION, path, overwrite=overwrite),
            ".csv": lambda: write(SIGNAL, path, overwrite=overwrite),
            ".json": lambda: _save_warp(path, overwrite=overwrite),
            ".retime": lambda: _save_project(path, overwrite=overwrite),
        }
        try:
            AllowedPlaces([folder]).find(str(path))
            actions[suffix]()
            return f"{suffix} is written"
        finally:
            _compare(before, _seen(folder), str(meant.relative_to(folder)) if meant.is_relative_to(folder) else "")


def _compare(before: dict[str, tuple[int, object]], after: dict[str, tuple[int, object]], meant: str) -> None:
    for name, node in before.items():
        if name.endswith("-journal"):
            # What lies where a journal is to be is moved aside, whole.
            name = next((one for one in (f"{name}.old-1", name) if one in after), name)
        assert after.get(name, (0, None))[0] == node[0], f"{name} is no more what it was"
        if name != meant:
            assert after[name] == node, f"{name} was changed, and {meant} was meant"
    # A project may be saved to a folder that is made for it.
    made = {meant, str(Path(meant).parent)} if meant in after else set()
    new = {name for name in after if name not in {*before, *made} and not name.endswith("-journal.old-1")}
    assert not new, f"left behind: {new}"


def _save_warp(path: Path, *, overwrite: bool) -> None:
    Warp([0.0, 1.0], [0.0, 2.0]).save(path, overwrite=overwrite)


def _save_project(path: Path, *, overwrite: bool) -> None:
    workspace = _workspace(path.parent / "elsewhere" / "own.retime")
    try:
        workspace.save(path, workspace.history, workspace.warps, overwrite=overwrite)
    finally:
        workspace.close()
        for place in (path.parent / "elsewhere").iterdir():
            place.unlink()
        (path.parent / "elsewhere").rmdir()


def _workspace(path: Path) -> Workspace:
    return open_project(path, Document((ClipFile("/clips/a.bvh"),)))


def _edit(draw: random.Random, folder: Path) -> str:
    """Edit a project while its folder changes; what is called safe is there for the next editor."""
    workspace = _workspace(folder / "d2" / "p.retime" if draw.random() < 0.7 else folder / "p.retime")
    journal = workspace.journal.path
    safe = None
    try:
        for number in range(6):
            _disturb(draw, journal)
            document = replace(workspace.history.present, keys=(Key("k", 0.01 * (number + 1), 1.0),))
            edit = Edit(document, f"to {number}", "", True)
            workspace.history = workspace.history.edit(document, label=edit.label)
            workspace.journal.edit(edit, workspace.history, {})
            safe = workspace.history
            assert read_journal(journal).history == safe, "what was called safe is not there"
    finally:
        workspace.close()
    return "all edits are safe"


def _disturb(draw: random.Random, journal: Path) -> None:
    """Do to a journal what other programs may."""
    what = draw.randrange(10)
    folder = journal.parent
    if what == 0 and folder.name == "d2":
        folder.rename(folder.with_name("moved"))
    elif what == 1:
        journal.unlink(missing_ok=True)
    elif what == 2 and journal.exists():
        journal.rename(journal.with_name("moved.journal"))
    elif what == 3:
        journal.with_name(journal.name + ".lock").unlink(missing_ok=True)
    elif what == 4:
        journal.unlink(missing_ok=True)
        journal.symlink_to(folder / "nowhere")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(command(trial, __doc__))
