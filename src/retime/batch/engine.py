"""Many clips on a Dask cluster: in chunks, in a window, and once more where a worker died.

A chunk is a task of Dask's: 8 to 16 clips cost it as much as one (`docs/batch.md` has figures). Only as many are
submitted as keep all workers busy: a scheduler that holds 50,000 at once is slow for minutes. A clip that kills what
works at it does so in a process of its own (`retime.batch.child`), so that a worker of Dask's dies of other reasons
only, and its chunk is run again.
"""

from __future__ import annotations

import atexit
import contextlib
import math
import os
import secrets
import signal
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from retime.batch import dask_worker
from retime.batch.child import ChildRunner
from retime.batch.clip import failed
from retime.batch.manifest import STATE
from retime.batch.task import ClipTask, Record, own_version
from retime.errors import MissingExtraError, OptionError, RetimeWarning, words_of

if TYPE_CHECKING:
    from distributed import Client, Future, LocalCluster

# Clips of a chunk, and chunks that wait at each thread of a worker beside the one at work.
CHUNK, AHEAD = 8, 2
# Seconds after which it is asked again how many workers there are.
_ASK_AGAIN = 5.0
# Seconds between looks at how many workers a cluster of ours has, and after which one that is missing is replaced.
_LOOK, _STAYS_AWAY = 2.0, 45.0
_GONE = "the scheduler is gone; run the same command again to go on"
_UNFIT = (
    "a worker of the cluster can't work ({error}): all must see the clips and {out} under these names, and have this "
    "version of retime[batch]. What is done is kept; run the same command again to go on"
)
# A clip that was alone at so many workers when they died is set aside.
_AGAIN = 3


@dataclass(frozen=True)
class Bounds:
    """What one clip may take.

    Attributes
    ----------
    memory : int, optional
        Bytes; None: as much as there is.
    seconds : float
        For one clip.
    """

    memory: int | None = None
    seconds: float = 600.0

    def wider_than(self, failure: Mapping[str, Any]) -> bool:
        """Tell whether a clip met a bound (`Record.to_json`) that is a wider one now."""
        met = failure.get("limit", 0.0)
        now = {"timeout": self.seconds, "memory": self.memory or math.inf}.get(failure["code"], 0.0)
        return bool(met and now > met)


def connect(scheduler: str | None, *, workers: int) -> Client:
    """Return a client of a cluster: the one at an address, or one made on this machine.

    Parameters
    ----------
    scheduler : str, optional
        Address, ``tcp://host:8786``; left out, a cluster on this machine.
    workers : int
        Of the cluster on this machine.

    Raises
    ------
    MissingExtraError
        There is no Dask.
    OptionError
        The address is none.
    OSError
        Nothing answers at the address.
    """
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise MissingExtraError("retiming many clips", package="distributed", extra="batch") from error
    if scheduler is not None:
        try:
            return Client(scheduler, timeout="30s")
        except ValueError as error:
            raise OptionError(f"a scheduler is at an address such as tcp://host:8786: {error}") from None
    import dask

    # What a worker holds is small; the clips lie in the processes that work at them, which have bounds of their own.
    dask.config.set({"distributed.worker.memory.terminate": False})
    cluster = LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        memory_limit=0,
        silence_logs=50,
        # By its file: a worker that starts needs nothing else of this package yet.
        preload=[dask_worker.__file__],
    )
    threading.Thread(target=_replace_lost, args=(cluster, workers), daemon=True).start()
    return Client(cluster)


def _replace_lost(cluster: LocalCluster, workers: int) -> None:
    """Start another worker where one stays away, until the cluster is closed.

    Dask starts a worker again that has died, but for one that dies as it starts: a run without any would wait for ever.
    """
    from distributed.core import Status

    missed = time.monotonic()
    while cluster.status == Status.running:
        time.sleep(_LOOK)
        if len(cluster.scheduler.workers) >= workers:
            missed = time.monotonic()
        elif time.monotonic() - missed > _STAYS_AWAY:
            cluster.scale(len(cluster.worker_spec) + 1)
            missed = time.monotonic()


def disconnect(client: Client, *, keep_cluster: bool = False) -> None:
    """Close a client of `connect`, and the cluster that was made for it; a second Ctrl-C does not cut that short."""
    with _undisturbed():
        cluster = client.cluster
        client.close()
        if not keep_cluster and cluster is not None:
            cluster.close()


@contextlib.contextmanager
def _undisturbed() -> Iterator[None]:
    """Let Ctrl-C wait; it reaches the main thread alone."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def share_of_memory(workers: int | None) -> int | None:
    """Return what one of so many processes may take of this machine's memory, bytes; None where nobody tells.

    A clip needs some room however many there are: no less than 2 GB.

    Parameters
    ----------
    workers : int, optional
        Processes; left out, one a processor.
    """
    try:
        total = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, ValueError, OSError):
        return None
    # A container has less than its machine.
    for name in ("memory.max", "memory/memory.limit_in_bytes"):
        with contextlib.suppress(OSError, ValueError):
            total = min(total, int(Path("/sys/fs/cgroup", name).read_text(encoding="ascii")))
    processes = 1 if workers == 0 else workers or os.cpu_count() or 1
    return max(total // processes, 2 << 30)


def count_threads(client: Client) -> int:
    """Return how many clips a cluster can do at once."""
    return sum(_of_scheduler(client.nthreads).values())


def run_serially(tasks: Iterable[ClipTask], out: Path, bounds: Bounds) -> Iterator[tuple[Record, ...]]:
    """Do clips one after the other, each in a process that may die of it; needs no Dask."""
    runner = ChildRunner(out, most_memory=bounds.memory, most_seconds=bounds.seconds)
    try:
        for task in tasks:
            yield runner.run(task)
    finally:
        runner.close()


def run_on(
    client: Client,
    tasks: Sequence[ClipTask],
    out: Path,
    bounds: Bounds,
    refreshed: Callable[[ClipTask], ClipTask],
    *,
    chunk: int = CHUNK,
) -> Iterator[tuple[Record, ...]]:
    """Do clips on a cluster, and yield what became of each as it is known.

    Parameters
    ----------
    client : distributed.Client
        Of the cluster; its workers see the same folders.
    tasks : sequence of ClipTask
        What is to be done.
    out : Path
        The folder of all outputs.
    bounds : Bounds
        What one clip may take.
    refreshed : function of ClipTask
        Tells a task what workers have written by now of it; called where one has died.
    chunk : int
        Clips of a task of Dask's.

    Raises
    ------
    ConnectionError
        The scheduler is gone, or workers can't do what is asked, whatever the clip.

    Warns
    -----
    RetimeWarning
        There is no worker yet.
    """
    from distributed import KilledWorker, as_completed

    waiting = deque(tuple(tasks[i : i + chunk]) for i in range(0, len(tasks), chunk))
    deaths: dict[str, int] = {}
    troubles: dict[str, int] = {}
    at_work: dict[Future, tuple[ClipTask, ...]] = {}
    completed = as_completed()

    threads, asked = 0, 0.0

    def submit() -> None:
        nonlocal threads, asked
        # Workers come and go; to ask for them takes a while.
        if not threads or time.monotonic() - asked > _ASK_AGAIN:
            first, threads, asked = not asked, count_threads(client), time.monotonic()
            if first and not threads:
                warnings.warn("the cluster has no worker yet: waiting for one", RetimeWarning, stacklevel=3)
            threads = threads or 1
        while waiting and len(at_work) < threads * (1 + AHEAD):
            part = waiting.popleft()
            mark = secrets.token_hex(8)
            lines = [task.to_json() for task in part]
            future = _of_scheduler(
                client.submit, _do_chunk, lines, str(out), mark, bounds, own_version(), pure=False, retries=0
            )
            at_work[future] = part
            completed.add(future)

    submit()
    while at_work:
        future = next(completed)
        part = at_work.pop(future)
        if future.status in ("cancelled", "lost"):
            raise ConnectionError(_GONE)
        answers = _of_scheduler(future.result) if future.status == "finished" else None
        error = _of_scheduler(future.exception) if future.status == "error" else None
        if error is not None and not isinstance(error, KilledWorker):
            # What a clip does wrong it says itself: this is of the worker, or of what it sees.
            name = part[0].name
            troubles[name] = troubles.get(name, 0) + 1
            if troubles[name] == _AGAIN:
                raise ConnectionError(_UNFIT.format(out=out, error=f"{type(error).__name__}: {words_of(error)}"))
            waiting.appendleft(tuple(refreshed(task) for task in part))
            submit()
            continue
        if answers is not None:
            for answer in answers:
                yield tuple(Record.from_json(line) for line in answer)
        elif len(part) > 1:
            waiting.extendleft((refreshed(task),) for task in reversed(part))
        else:
            (task,) = part
            deaths[task.name] = deaths.get(task.name, 0) + 1
            if deaths[task.name] < _AGAIN:
                waiting.append((refreshed(task),))
            else:
                message = f"the worker that did it died {_AGAIN} times"
                yield (failed(task, "killed", message, 0.0),)
        submit()


def _of_scheduler(ask: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
    """Return what a call of the scheduler answers; a line that broke meanwhile has one error, whatever was asked.

    The futures of a client are called cancelled a moment after its line broke; what is asked before, or just when
    the line breaks, ends in errors of other kinds.
    """
    from distributed import CancelledError
    from distributed.client import ClosedClientError

    try:
        return ask(*args, **kwargs)
    except (OSError, CancelledError, ClosedClientError) as error:
        raise ConnectionError(_GONE) from error


_runners: dict[tuple[int, str, Bounds], ChildRunner] = {}


def _do_chunk(
    tasks: list[dict[str, Any]], out: str, mark: str, bounds: Bounds, asked: str
) -> list[list[dict[str, Any]]] | None:
    """Do the clips of a chunk; runs in a worker. None, where a worker that began it has died.

    Dask by itself runs a task again whose worker died, and knows nothing of what was done by then.
    """
    if asked != own_version():
        raise RuntimeError(f"it has retime {own_version()}, and {asked} asks")
    try:
        (Path(out) / STATE / f"chunk-{mark}").open("x").close()
    except FileExistsError:
        return None
    bounds = _bounded(bounds)
    key = (threading.get_ident(), out, bounds)
    if key not in _runners:
        # A worker lives through many runs; what it held for the last one goes.
        for other in [one for one in _runners if one[0] == key[0]]:
            runner = _runners.pop(other)
            atexit.unregister(runner.close)
            runner.close()
        _runners[key] = ChildRunner(Path(out), most_memory=bounds.memory, most_seconds=bounds.seconds)
        atexit.register(_runners[key].close)
    runner = _runners[key]
    return [[record.to_json() for record in runner.run(ClipTask.from_json(task))] for task in tasks]


def _bounded(bounds: Bounds) -> Bounds:
    """Give a clip the memory that its worker may take, where nobody said how much."""
    from distributed import get_worker

    worker = get_worker()
    most = worker.memory_manager.memory_limit
    return replace(bounds, memory=most // worker.state.nthreads) if bounds.memory is None and most else bounds
