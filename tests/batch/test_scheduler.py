"""Somebody else's cluster: two machines' worth of workers on the loopback, and a scheduler that goes away."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import retime
from retime.batch import engine, run
from retime.errors import OptionError, RetimeWarning
from tests.batch.storm import children_of, contents, make_library, wait_for_lines

distributed = pytest.importorskip("distributed", reason="distributed (the extra retime[batch]) is not installed")
from distributed.client import ClosedClientError  # noqa: E402 - of what may be missing
from distributed.comm import CommClosedError  # noqa: E402

pytestmark = pytest.mark.extras


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """Start a scheduler, and two workers that know only its address."""
    place = tmp_path / "scheduler.json"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": environment, "cwd": tmp_path}
    known = ["--scheduler-file", str(place)]

    def python(name: str) -> list[str]:
        return [sys.executable, "-c", f"from distributed.cli import dask_{name}; dask_{name}.main()"]

    scheduler = subprocess.Popen([*python("scheduler"), "--port", "0", "--dashboard-address", ":0", *known], **quiet)
    end = time.monotonic() + 60
    while not place.exists() and time.monotonic() < end:
        time.sleep(0.05)
    workers = [
        subprocess.Popen(
            [*python("worker"), *known, "--nthreads", "1", "--no-dashboard", "--name", f"machine{i}"], **quiet
        )
        for i in range(2)
    ]
    with distributed.Client(scheduler_file=str(place), timeout="60s") as client:
        client.wait_for_workers(2, timeout=60)
        address = client.scheduler.address
    yield scheduler, address
    for process in (*workers, scheduler):
        process.send_signal(signal.SIGTERM)
    for process in (*workers, scheduler):
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def test_the_command_uses_a_cluster_that_is_there(cluster: tuple[subprocess.Popen[bytes], str], tmp_path: Path) -> None:
    _, address = cluster
    library = make_library(tmp_path / "in", 30, 5)
    command = [sys.executable, "-m", "retime", "batch", str(library.root), "--out", str(tmp_path / "out"), "-q"]
    ended = subprocess.run([*command, "--scheduler", address, "--length", "80%", "--chunk", "4"], check=False)
    assert ended.returncode == 4
    quiet = run(library.root, tmp_path / "peace", {"length": "80%"}, workers=0)
    assert contents(tmp_path / "out") == contents(tmp_path / "peace")
    assert len(quiet.failures) == len(library.bad)


def test_a_scheduler_that_goes_away_is_said_and_gone_on_without(
    cluster: tuple[subprocess.Popen[bytes], str], tmp_path: Path
) -> None:
    scheduler, address = cluster
    library = make_library(tmp_path / "in", 90, 6)
    command = [sys.executable, "-m", "retime", "batch", str(library.root), "--out", str(tmp_path / "out")]
    process = subprocess.Popen(
        [*command, "--scheduler", address, "--length", "80%"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    wait_for_lines(tmp_path / "out" / "manifest.jsonl", 20)
    scheduler.kill()
    _, said = process.communicate(timeout=120)
    assert process.returncode == 1, said
    assert b"the scheduler is gone; run the same command again to go on" in said
    result = run(library.root, tmp_path / "out", {"length": "80%"}, workers=0)
    assert result.counts["kept"] >= 15
    # Here no clip is deadly: what is damaged fails.
    damaged = {name for name, code in library.bad.items() if code in ("format", "option")}
    assert {record.name for record in result.failures} == damaged


@pytest.mark.parametrize(
    ("what", "error"),
    [
        ("nthreads", CommClosedError("in <TCP>: Connection reset by peer")),
        ("nthreads", TimeoutError("Timed out during handshake")),
        ("submit", ClosedClientError("Client is closed. Can't send update-graph message.")),
        ("result", CommClosedError("in <TCP>: Stream is closed")),
        ("result", distributed.CancelledError("lost")),
    ],
)
def test_a_line_that_breaks_at_any_call_has_one_error(
    what: str, error: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = make_library(tmp_path / "in", 4, 7)

    def broken(*_args: object, **_kwargs: object) -> None:
        raise error

    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0") as local,
        distributed.Client(local) as client,
    ):
        with monkeypatch.context() as patch:
            patch.setattr(distributed.Future if what == "result" else client, what, broken)
            with pytest.raises(ConnectionError, match="the scheduler is gone; run the same command again"):
                run(library.root, tmp_path / "out", {"length": "80%"}, client=client)
        # The same call goes on.
        result = run(library.root, tmp_path / "out", {"length": "80%"}, client=client)
    assert len(result.failures) == len(library.bad)


def test_a_client_is_taken_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    for i in range(5):
        retime.write(retime.sample().frames(40 * i, 40 * i + 40), tmp_path / "in" / f"{i}.bvh")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as local,
        distributed.Client(local) as client,
    ):
        result = run(tmp_path / "in", tmp_path / "out", {"length": "80%"}, client=client, chunk=2)
        assert result.counts == {"done": 5, "kept": 0, "failed": 0}
        # It is still there.
        assert client.submit(lambda: 2).result() == 2
    assert not [pid for pid in children_of(os.getpid()) if b"retime.batch" in Path(f"/proc/{pid}/cmdline").read_bytes()]


def test_a_worker_that_stands_elsewhere_finds_relative_names(
    cluster: tuple[subprocess.Popen[bytes], str], tmp_path: Path
) -> None:
    _, address = cluster
    here = tmp_path / "here"
    (here / "in").mkdir(parents=True)
    retime.write(retime.sample().frames(0, 40), here / "in" / "a.bvh")
    retime.write(retime.sample().frames(40, 80), here / "like.bvh")
    command = [sys.executable, "-m", "retime", "batch", "in", "--out", "out", "--reference", "like.bvh", "-q"]
    subprocess.run([*command, "--scheduler", address], check=True, cwd=here)
    assert (here / "out" / "a.bvh").exists()
    said = subprocess.run(
        [*command, "--scheduler", address, "--restart", "--dry-run"], check=True, cwd=here, stdout=subprocess.PIPE
    )
    assert b"by 1 process" in said.stdout
    assert sorted(path.name for path in tmp_path.iterdir() if path.is_dir()) == ["here"]


def one_clip(tmp_path: Path) -> Path:
    (tmp_path / "in").mkdir()
    retime.write(retime.sample().frames(0, 40), tmp_path / "in" / "a.bvh")
    return tmp_path / "in"


def test_a_worker_that_can_t_work_ends_the_run_and_is_no_fault_of_a_clip(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = one_clip(tmp_path)
    monkeypatch.setattr(engine, "own_version", lambda: "0.0.1")
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0") as local,
        distributed.Client(local) as client,
    ):
        with pytest.raises(ConnectionError, match=r"can't work \(RuntimeError: it has retime .*, and 0\.0\.1 asks\)"):
            run(root, tmp_path / "out", {"length": "80%"}, client=client)
        monkeypatch.undo()
        assert run(root, tmp_path / "out", {"length": "80%"}, client=client).counts["done"] == 1


def test_a_cluster_without_workers_is_said_and_waited_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = one_clip(tmp_path)
    count = engine.count_threads
    with (
        distributed.LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address=":0") as local,
        distributed.Client(local) as client,
    ):

        def counted(asked: distributed.Client) -> int:
            found = count(asked)
            if not found:
                local.scale(1)
            return found

        monkeypatch.setattr(engine, "count_threads", counted)
        with pytest.warns(RetimeWarning, match="the cluster has no worker yet"):
            result = run(root, tmp_path / "out", {"length": "80%"}, client=client)
    assert result.counts == {"done": 1, "kept": 0, "failed": 0}


def test_a_worker_that_stays_away_is_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = one_clip(tmp_path)
    monkeypatch.setattr(engine, "_LOOK", 0.1)
    monkeypatch.setattr(engine, "_STAYS_AWAY", 1.0)
    client = engine.connect(None, workers=1)
    try:
        client.wait_for_workers(1, timeout=60)
        # What starts workers again when they die is gone itself.
        for nanny in list(client.cluster.workers.values()):
            client.sync(nanny.close)
        with pytest.warns(RetimeWarning, match="the cluster has no worker yet"):
            assert run(root, tmp_path / "out", {"length": "80%"}, client=client).counts["done"] == 1
    finally:
        engine.disconnect(client)


def test_an_address_that_is_none_is_said() -> None:
    with pytest.raises(OptionError, match=r"an address such as tcp://host:8786"):
        engine.connect("nonsense", workers=0)


def test_a_terminal_s_interrupt_ends_all_without_a_word_of_the_workers(tmp_path: Path) -> None:
    library = make_library(tmp_path / "in", 90, 8)
    command = [sys.executable, "-m", "retime", "batch", str(library.root), "--out", str(tmp_path / "out")]
    process = subprocess.Popen(
        [*command, "--length", "80%", "--workers", "1"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    wait_for_lines(tmp_path / "out" / "manifest.jsonl", 10)
    # A terminal sends it to each process of its foreground.
    os.killpg(process.pid, signal.SIGINT)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 130, said
    assert b"Traceback" not in said
    result = run(library.root, tmp_path / "out", {"length": "80%"}, workers=0)
    assert result.counts["kept"] >= 5


@pytest.mark.parametrize("workers", [None, 0, 1, 2, 100_000])
def test_a_machine_s_memory_is_shared(workers: int | None) -> None:
    share = engine.share_of_memory(workers)
    assert share is not None
    assert share >= 2 << 30
    assert workers != 100_000 or share == 2 << 30
    assert share <= (engine.share_of_memory(1) or 0)
