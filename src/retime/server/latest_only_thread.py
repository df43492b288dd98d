"""One worker thread; of the documents that wait to be solved, only the latest is."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

Job = TypeVar("Job")


class LatestOnlyThread(Generic[Job]):
    """Do jobs in a thread of their own: one at a time, and of those that come meanwhile only the last.

    A key that is dragged asks for more solutions than can be found. What was asked for in between is of no use to
    anyone, so no queue builds up: a job that was not begun is replaced by a newer one. Errands, which a person asked
    for one by one, are all done, before the job that waits. Asides are short, and need not even wait for the job at
    work to end: it does them itself, wherever it looks (`do_asides`).

    Parameters
    ----------
    work : function of a job
        Called in the thread.
    name : str
        Of the thread.
    failed : function of a job and an exception
        Called in the thread with whatever `work` raised, and with None and whatever an errand raised. The thread goes
        on: one job that can't be done says nothing of the next.
    """

    def __init__(
        self, work: Callable[[Job], None], *, name: str, failed: Callable[[Job | None, BaseException], None]
    ) -> None:
        self._work = work
        self._failed = failed
        self._latest: Job | None = None
        self._errands: deque[Callable[[], None]] = deque()
        self._asides: deque[Callable[[], None]] = deque()
        self._changed = threading.Condition()
        self._open = True
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def submit(self, job: Job) -> None:
        """Ask for a job, in place of one that waits and was not begun."""
        with self._changed:
            self._latest = job
            self._changed.notify()

    def add(self, errand: Callable[[], None]) -> None:
        """Ask for something that is done in any case."""
        with self._changed:
            self._errands.append(errand)
            self._changed.notify()

    def add_aside(self, aside: Callable[[], None]) -> None:
        """Ask for something short, which is done in the middle of what is at work."""
        with self._changed:
            self._asides.append(aside)
            self._changed.notify()

    def do_asides(self) -> None:
        """Do what need not wait for the work at hand. Called in the thread, now and then, by that work."""
        while True:
            with self._changed:
                if not self._open or not self._asides:
                    return
                aside = self._asides.popleft()
            self._do(aside)

    def idle(self, seconds: float) -> bool:
        """Wait so long for something to do; whether there is still nothing. Called in the thread, between two."""
        with self._changed:
            return not self._changed.wait_for(lambda: not self._open or self._waits, timeout=seconds)

    @property
    def _waits(self) -> bool:
        """Whether there is something to do; the lock is held."""
        return bool(self._asides or self._errands or self._latest is not None)

    @property
    def newer(self) -> Job | None:
        """The job that waits for the one at work to be done, if one does."""
        with self._changed:
            return self._latest

    @property
    def stopped(self) -> bool:
        """Whether nothing more is begun."""
        with self._changed:
            return not self._open

    def stop(self) -> None:
        """Begin nothing more."""
        with self._changed:
            self._open = False
            self._changed.notify()

    def close(self) -> None:
        """Begin nothing more, and wait for what is at work."""
        self.stop()
        self._thread.join()

    def _run(self) -> None:
        while True:
            job = None
            with self._changed:
                while self._open and not self._waits:
                    self._changed.wait()
                if not self._open:
                    return
                errand = next((queue.popleft() for queue in (self._asides, self._errands) if queue), None)
                if errand is None:
                    job, self._latest = self._latest, None
            if errand is not None:
                self._do(errand)
            elif job is not None:
                try:
                    self._work(job)
                except BaseException as error:
                    # No interrupt comes here, they are the main thread's.
                    self._failed(job, error)

    def _do(self, errand: Callable[[], None]) -> None:
        try:
            errand()
        except BaseException as error:
            self._failed(None, error)
