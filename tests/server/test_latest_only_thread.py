"""The latest job wins, and no queue builds up. Everything waits for events; nothing sleeps."""

from __future__ import annotations

import threading
from collections.abc import Iterator

import pytest

from retime.server.latest_only_thread import LatestOnlyThread


class Work:
    """Work that goes on until it is let go."""

    def __init__(self) -> None:
        self.begun: list[int] = []
        self.started = threading.Semaphore(0)
        self.may_end = threading.Semaphore(0)
        self.idle: list[bool] = []
        self.rest: float | None = None
        self.worker = LatestOnlyThread(self.work, name="test", failed=self.failed)

    def work(self, job: int) -> None:
        self.begun.append(job)
        self.started.release()
        assert self.may_end.acquire(timeout=30)
        if self.rest is not None:
            self.idle.append(self.worker.idle(self.rest))

    def failed(self, job: int | None, error: BaseException) -> None:
        raise AssertionError(f"{job} failed") from error


@pytest.fixture
def work() -> Iterator[Work]:
    made = Work()
    yield made
    for _ in range(10):
        made.may_end.release()
    made.worker.close()


def test_of_the_jobs_that_come_meanwhile_only_the_last_is_done(work) -> None:
    work.worker.submit(1)
    assert work.started.acquire(timeout=30)
    for job in range(2, 1000):
        work.worker.submit(job)
    work.may_end.release()
    assert work.started.acquire(timeout=30)
    assert work.begun == [1, 999]
    # Nothing else waits: the next one asked for is the next one done.
    work.may_end.release()
    work.worker.submit(1000)
    assert work.started.acquire(timeout=30)
    assert work.begun == [1, 999, 1000]


def test_errands_are_all_done_and_go_before_the_job_that_waits(work) -> None:
    done: list[str] = []
    work.worker.submit(1)
    assert work.started.acquire(timeout=30)
    work.worker.submit(2)
    for name in "abc":
        work.worker.add(lambda name=name: done.append(name))
    work.may_end.release()
    assert work.started.acquire(timeout=30)
    assert (done, work.begun) == (["a", "b", "c"], [1, 2])


def test_a_rest_ends_when_a_job_comes(work) -> None:
    # It would take an hour otherwise.
    work.rest = 3600.0
    work.worker.submit(1)
    assert work.started.acquire(timeout=30)
    work.may_end.release()
    work.worker.submit(2)
    assert work.started.acquire(timeout=30)
    assert work.idle == [False]
    work.rest = 0.0
    work.may_end.release()
    work.worker.submit(3)
    assert work.started.acquire(timeout=30)


def test_a_rest_in_which_nothing_comes_is_one() -> None:
    found: list[bool] = []
    over = threading.Event()

    def do(job: int) -> None:
        found.append(worker.idle(0.001))
        over.set()

    worker = LatestOnlyThread(do, name="test", failed=lambda job, error: found.append(False))
    worker.submit(1)
    assert over.wait(30)
    worker.close()
    assert found == [True]


def test_a_fault_of_the_works_is_told_and_the_next_is_done() -> None:
    told: list[tuple[int | None, type[BaseException]]] = []
    done: list[int] = []
    over = threading.Event()

    def work(job: int) -> None:
        done.append(6 // job)
        over.set()

    worker: LatestOnlyThread[int] = LatestOnlyThread(
        work, name="test", failed=lambda job, error: (told.append((job, type(error))), over.set())
    )
    for job in (0, 2):
        over.clear()
        worker.submit(job)
        assert over.wait(30)
    over.clear()
    worker.add(lambda: work(0))
    assert over.wait(30)
    over.clear()
    worker.submit(3)
    assert over.wait(30)
    worker.close()
    assert told == [(0, ZeroDivisionError), (None, ZeroDivisionError)]
    assert done == [3, 2]


def test_what_was_not_begun_when_it_closes_is_not_done(work) -> None:
    work.worker.submit(1)
    assert work.started.acquire(timeout=30)
    work.worker.submit(2)
    work.worker.stop()
    work.may_end.release()
    work.worker.close()
    assert work.begun == [1]


def test_asides_are_done_in_the_middle_of_a_job_and_their_faults_are_told() -> None:
    done: list[str] = []
    told: list[type[BaseException]] = []
    begun, asked, over = threading.Event(), threading.Event(), threading.Event()

    def work(job: int) -> None:
        begun.set()
        assert asked.wait(30)
        worker.do_asides()
        done.append(f"job {job}")

    worker: LatestOnlyThread[int] = LatestOnlyThread(
        work, name="test", failed=lambda job, error: told.append(type(error))
    )
    worker.submit(1)
    assert begun.wait(30)
    worker.add(lambda: done.append("errand"))
    worker.add_aside(lambda: done.append(str(1 // 0)))
    worker.add_aside(lambda: done.append("aside"))
    asked.set()
    worker.add(over.set)
    assert over.wait(30)
    # With nothing at work they are done as well.
    over.clear()
    worker.add_aside(over.set)
    assert over.wait(30)
    worker.close()
    assert done == ["aside", "job 1", "errand"]
    assert told == [ZeroDivisionError]
