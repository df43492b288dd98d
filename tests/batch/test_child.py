"""The process that does clips: its death, its silence and its memory are the clip's, and no one else's."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import retime
from retime.batch.child import TRIES, ChildRunner
from retime.batch.task import ClipTask
from retime.batch.treatment import Treatment, settings
from retime.child_process import child_environment
from tests.batch.storm import UNRULY, children_of

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="signals, and /proc")


@pytest.fixture
def unruly(monkeypatch: pytest.MonkeyPatch) -> None:
    # What the child is started with begins with this process's own path.
    monkeypatch.syspath_prepend(str(UNRULY))


def task_of(tmp_path: Path, name: str, n: int = 40, **given: object) -> ClipTask:
    place = tmp_path / "in" / name
    place.parent.mkdir(exist_ok=True)
    retime.write(retime.sample().frames(0, n), place)
    treatment = Treatment().with_(settings({"length": "80%", **given}))
    return ClipTask(str(place), name, str(tmp_path / "out"), (name,), treatment)


def test_a_deadly_clip_is_tried_again_and_set_aside(tmp_path: Path, unruly: None) -> None:
    runner = ChildRunner(tmp_path / "out", most_memory=None, most_seconds=60)
    try:
        (good,) = runner.run(task_of(tmp_path, "a.bvh"))
        (killed,) = runner.run(task_of(tmp_path, "kills.bvh"))
        (after,) = runner.run(task_of(tmp_path, "b.bvh"))
    finally:
        runner.close()
    assert [good.status, killed.status, after.status] == ["done", "failed", "done"]
    assert killed.code == "killed"
    assert f"{TRIES} processes died of it, the last one with signal {signal.SIGKILL:d}" in killed.message
    assert killed.hash


def test_a_process_whose_owner_is_gone_says_nothing_and_leaves_what_it_did(tmp_path: Path) -> None:
    task = task_of(tmp_path, "a.bvh")
    command = [*ChildRunner(tmp_path / "out", most_memory=None, most_seconds=60)._command]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, env=child_environment(), **pipes) as process:
        # Nobody will hear its answer; its orders are still open, or it would end before it has one.
        process.stdout.close()
        process.stdin.write(json.dumps(task.to_json()).encode() + b"\n")
        process.stdin.flush()
        assert process.stderr.read() == b""
        assert process.wait(60) == 0
    assert (tmp_path / "out" / "a.bvh").exists()
    (journal,) = (tmp_path / "out" / ".retime").glob("journal-*")
    assert json.loads(journal.read_text().splitlines()[-1])["output"] == "a.bvh"


def test_a_clip_that_never_ends_is_ended(tmp_path: Path, unruly: None) -> None:
    runner = ChildRunner(tmp_path / "out", most_memory=None, most_seconds=3)
    try:
        begun = time.monotonic()
        (late,) = runner.run(task_of(tmp_path, "hangs.bvh"))
        (after,) = runner.run(task_of(tmp_path, "b.bvh"))
    finally:
        runner.close()
    assert (late.code, after.status) == ("timeout", "done")
    # It is not tried again: it would hang again.
    assert time.monotonic() - begun < 2 * 3 + 20


def test_memory_is_bounded(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    place = tmp_path / "in" / "large.npy"
    np.lib.format.open_memmap(place, mode="w+", dtype=np.float64, shape=(2_000_000, 16)).flush()
    large_task = ClipTask(str(place), "large.npy", str(tmp_path / "out"), ("large.npy",), Treatment(fps="30"))
    runner = ChildRunner(tmp_path / "out", most_memory=300 << 20, most_seconds=60)
    try:
        (large,) = runner.run(large_task)
        (after,) = runner.run(task_of(tmp_path, "b.bvh"))
    finally:
        runner.close()
    assert (large.status, large.code) == ("failed", "memory"), large.message
    assert after.status == "done"


def test_the_process_ends_with_its_owner(tmp_path: Path) -> None:
    runner = ChildRunner(tmp_path / "out", most_memory=None, most_seconds=60)
    runner.run(task_of(tmp_path, "a.bvh"))
    assert runner._process is not None
    pid = runner._process.pid
    assert pid in children_of(os.getpid())
    # What its owner leaves when it is killed: closed pipes.
    assert runner._process.stdin is not None
    runner._process.stdin.close()
    assert runner._process.wait(timeout=20) == 0
    runner.close()
