"""Memory that was freed, given back: by glibc alone, and when nobody waits."""

from __future__ import annotations

import os
import queue
import sys
from pathlib import Path

import pytest

from retime.server import freed_memory, solver_thread
from retime.server.freed_memory import give_back_freed_memory
from tests.server.serving import serving


@pytest.mark.skipif(freed_memory._trim() is None, reason="glibc alone keeps what is freed, and gives it back")
def test_what_was_freed_below_what_is_in_use_is_given_back() -> None:
    def held() -> int:
        return os.sysconf("SC_PAGE_SIZE") * int(Path("/proc/self/statm").read_text().split()[1])

    size = 64 << 20
    # Small enough for the heap. What was taken last is kept, so that the heap can't simply end before it.
    pieces = [bytearray(b"x" * (60 << 10)) for _ in range(size // (60 << 10))]
    last = pieces.pop()
    pieces.clear()
    before = held()
    give_back_freed_memory()
    assert held() < before - size // 2
    assert last[-1:] == b"x"


def test_another_system_has_nothing_to_give_back(monkeypatch) -> None:
    monkeypatch.setattr(sys, "platform", "darwin")
    freed_memory._trim.cache_clear()
    try:
        assert freed_memory._trim() is None
        give_back_freed_memory()
    finally:
        freed_memory._trim.cache_clear()


def test_memory_is_given_back_once_the_hand_rests_and_not_while_it_drags(folder: Path, monkeypatch) -> None:
    given: queue.Queue[str] = queue.Queue()
    monkeypatch.setattr(solver_thread, "give_back_freed_memory", lambda: given.put("given back"))
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        # Of the clip as it was opened, and of each edit.
        given.get(timeout=30)
        page.edit(options={"length": "80%"})
        page.curve()
        given.get(timeout=30)
        # The hand holds still in a drag: the curve is explained, and the next position is looked at after that.
        page.edit("g", done=False, options={"length": "70%"})
        page.until("why", revision=page.revision)
        page.edit("g", done=False, options={"length": "75%"})
        page.until("why", revision=page.revision)
        page.edit("g", done=False, options={"length": "90%"})
        page.curve()
        assert given.empty()
