"""A search that nobody waits for any more is ended: by the page, by a newer document, by the editor's own end."""

from __future__ import annotations

import queue
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from retime.project.document import ClipFile, Document
from retime.server import solver_thread
from retime.server.solver_thread import Findings, Job, SolverThread

# Alone it takes tens of seconds.
LONG = {"length": "150%", "upsample": 8, "max_skip": 40}


@pytest.fixture
def document(tmp_path: Path) -> Document:
    values = np.random.default_rng(0).standard_normal((4000, 30)).cumsum(axis=0)
    rows = "\n".join(",".join(f"{value:.6f}" for value in (i / 30, *row)) for i, row in enumerate(values))
    names = ",".join(["time", *(f"c{i}" for i in range(30))])
    (tmp_path / "walk.csv").write_text(f"{names}\n{rows}\n")
    return Document(clips=(ClipFile(path=str(tmp_path / "walk.csv")),), options=dict(LONG))


@contextmanager
def solving() -> Iterator[tuple[SolverThread, queue.Queue[Findings]]]:
    found: queue.Queue[Findings] = queue.Queue()
    thread = SolverThread(Path, found.put)
    try:
        yield thread, found
    finally:
        thread.close()


def until(found: queue.Queue[Findings], what: str) -> Findings:
    end = time.monotonic() + 30
    while True:
        findings = found.get(timeout=max(0.1, end - time.monotonic()))
        if what in findings.messages:
            return findings


def test_a_page_can_end_a_search_and_the_next_one_is_found(document: Document) -> None:
    with solving() as (thread, found):
        thread.ask(Job(1, 1, document))
        until(found, "clip 0")
        # It is read, and the search comes next.
        thread.cancel()
        begun = time.monotonic()
        assert "was ended" in str(until(found, "problem").messages["problem"])
        assert time.monotonic() - begun < 3
        thread.ask(Job(2, 1, replace(document, options={"length": "50%"})))
        assert until(found, "curve").job.revision == 2


def test_a_newer_document_does_not_wait_for_ever(document: Document, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solver_thread, "_PATIENCE", 0.5)
    with solving() as (thread, found):
        thread.ask(Job(1, 1, document))
        until(found, "clip 0")
        begun = time.monotonic()
        thread.ask(Job(2, 1, replace(document, options={"length": "50%"})))
        assert until(found, "curve").job.revision == 2
        assert time.monotonic() - begun < 8


def test_the_editor_ends_at_once(document: Document) -> None:
    with solving() as (thread, found):
        thread.ask(Job(1, 1, document))
        until(found, "clip 0")
        begun = time.monotonic()
    assert time.monotonic() - begun < 3
