"""Writes changes to the disk one after the other, in a thread, while the event loop goes on."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass


@dataclass(frozen=True)
class Change:
    """What is put on the disk, and what is done then.

    Attributes
    ----------
    write : function
        Called in a thread.
    done : function
        Called in the event loop once `write` has returned.
    failed : function of an exception
        Called with what either of them raised.
    gesture : str
        Of an edit that is part of a gesture that goes on; a later edit of it may take its place.
    """

    write: Callable[[], None]
    done: Callable[[], None]
    failed: Callable[[Exception], None]
    gesture: str = ""


class DiskWriter:
    """Writes changes one by one, in order. Made in a running event loop.

    Parameters
    ----------
    fault : function of an exception
        Called with what a change's `failed` raised.
    """

    def __init__(self, fault: Callable[[Exception], None]) -> None:
        self._fault = fault
        self._waiting: list[Change] = []
        self._changed = asyncio.Event()
        self._open = True
        # One thread for all of them. Of asyncio's own each change would take another, and each of those keeps for good
        # the memory that it once needed.
        self._thread = ThreadPoolExecutor(1, "retime-writer")
        self._task = asyncio.create_task(self._write_all())

    def put(self, change: Change) -> None:
        """Have a change written after those that wait."""
        self._waiting.append(change)
        self._changed.set()

    def drop_last_of(self, gesture: str) -> None:
        """Forget the last change that waits if it is of this gesture: the same key was dragged on meanwhile."""
        if gesture and self._waiting and self._waiting[-1].gesture == gesture:
            self._waiting.pop()

    async def close(self) -> None:
        """Write what waits, and end."""
        self._open = False
        self._changed.set()
        await asyncio.wait([self._task])
        self._thread.shutdown()

    async def _write_all(self) -> None:
        loop = asyncio.get_running_loop()
        while True:
            while not self._waiting:
                if not self._open:
                    return
                self._changed.clear()
                await self._changed.wait()
            change = self._waiting.pop(0)
            # Whatever is raised, the changes that come after are written.
            try:
                await loop.run_in_executor(self._thread, change.write)
                change.done()
            except Exception as error:
                self._fail(change, error)

    def _fail(self, change: Change, error: Exception) -> None:
        try:
            change.failed(error)
        except Exception as another:
            self._fault(another)
