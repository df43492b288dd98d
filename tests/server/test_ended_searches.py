"""A search that nobody waits for any more is ended: by the page, by a newer document, by the editor's own end."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from retime.progress import look
from retime.project.document import ClipFile, Document
from retime.server import messages, solver_thread
from retime.server.solver_thread import Findings, Job, SolverThread

# Alone it takes tens of seconds of a processor's time, by which it is told that it was ended: the clock's time tells
# what else the machine has to do.
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
        thread.cancel(1)
        begun = time.process_time()
        assert "was stopped" in str(until(found, "problem").messages["problem"])
        assert time.process_time() - begun < 3
        thread.ask(Job(2, 1, replace(document, options={"length": "50%"})))
        assert until(found, "curve").job.revision == 2


def _assert_taken_over(thread: SolverThread, found: queue.Queue[Findings], job: Job) -> None:
    """A newer job is solved, though the one at work would take long."""
    begun = time.process_time()
    thread.ask(job)
    assert until(found, "curve").job.revision == job.revision
    assert time.process_time() - begun < 8


def test_a_newer_document_does_not_wait_for_ever(document: Document, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solver_thread, "_PATIENCE", 0.5)
    with solving() as (thread, found):
        thread.ask(Job(1, 1, document))
        until(found, "clip 0")
        _assert_taken_over(thread, found, Job(2, 1, replace(document, options={"length": "50%"})))


def test_the_next_position_of_a_drag_waits(document: Document, monkeypatch: pytest.MonkeyPatch) -> None:
    # Without patience: all that is not of the same drag would end the search at once.
    monkeypatch.setattr(solver_thread, "_PATIENCE", 0.0)
    some = replace(document, options={"length": "150%", "upsample": 2, "max_skip": 8})
    with solving() as (thread, found):
        thread.ask(Job(1, 1, some, "drag"))
        until(found, "clip 0")
        thread.ask(Job(2, 1, replace(some, options={"length": "140%"}), "drag"))
        assert until(found, "curve").job.revision == 1
        assert until(found, "curve").job.revision == 2


def test_a_long_search_tells_how_far_it_is(document: Document) -> None:
    with solving() as (thread, found):
        thread.ask(Job(7, 1, document))
        told = [until(found, "progress").messages["progress"] for _ in range(3)]
        thread.cancel(7)
        assert "was stopped" in str(until(found, "problem").messages["problem"])
    assert [progress.revision for progress in told] == [7, 7, 7]
    assert told[-1].doing == "searching"
    assert all(progress.share is None or 0 <= progress.share <= 1 for progress in told)


def test_an_older_revision_ends_nothing_newer(document: Document) -> None:
    with solving() as (thread, found):
        thread.ask(Job(2, 1, replace(document, options={"length": "50%"})))
        thread.cancel(1)
        assert until(found, "curve").job.revision == 2


def test_who_goes_on_does_not_wait_for_an_explanation(document: Document, monkeypatch: pytest.MonkeyPatch) -> None:
    begun = threading.Event()

    def endless(revision: int, solution: object) -> None:
        begun.set()
        while True:
            look()

    monkeypatch.setattr(solver_thread, "why_message", endless)
    quick = replace(document, options={"length": "50%"})
    with solving() as (thread, found):
        thread.ask(Job(1, 1, quick))
        assert begun.wait(30)
        thread.ask(Job(2, 1, replace(quick, options={"length": "60%"})))
        until(found, "curve")
        assert until(found, "curve").job.revision == 2


def test_a_hand_that_rests_has_a_rest_of_its_own(document: Document, monkeypatch: pytest.MonkeyPatch) -> None:
    # After the one rest nothing would be explained in time.
    monkeypatch.setattr(solver_thread, "_REST", 600.0)
    monkeypatch.setattr(solver_thread, "_REST_IN_HAND", 0.01)
    with solving() as (thread, found):
        thread.ask(Job(3, 1, replace(document, options={"length": "50%"}), "drag", in_hand=True))
        assert until(found, "why").job.revision == 3


def test_the_editor_ends_at_once(document: Document) -> None:
    with solving() as (thread, found):
        thread.ask(Job(1, 1, document))
        until(found, "clip 0")
        begun = time.process_time()
    assert time.process_time() - begun < 3


def warp_export(place: Path) -> messages.Export:
    return messages.Export("warp", str(place), 0, False)


def test_a_file_is_read_while_a_search_is_at_work_which_goes_on(document: Document, tmp_path: Path) -> None:
    (tmp_path / "broken.csv").write_text("time,x\n0,1\n0.1,two\n")
    answers: queue.Queue[str] = queue.Queue()
    with solving() as (thread, found):
        thread.ask(Job(1, 1, document))
        until(found, "progress")
        begun = time.process_time()
        for name in ("walk.csv", "broken.csv"):
            thread.check(str(tmp_path / name), lambda error, notices: answers.put(str(error)))
        assert answers.get(timeout=60) == "None"
        assert "broken.csv:3" in answers.get(timeout=60)
        assert time.process_time() - begun < 5
        # What was at work has not been ended.
        while not found.empty():
            assert "problem" not in found.get().messages
        until(found, "progress")
        thread.cancel(1)
        until(found, "problem")


def test_another_document_ends_the_search_of_the_old_one_at_once(
    document: Document, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(solver_thread, "_PATIENCE", 600.0)
    with solving() as (thread, found):
        thread.ask(Job(1, 1, document))
        until(found, "progress")
        _assert_taken_over(thread, found, Job(2, 2, replace(document, options={"length": "50%"})))


def test_an_export_of_a_search_that_was_ended_is_refused_and_not_begun_anew(document: Document, tmp_path: Path) -> None:
    answers: queue.Queue[messages.ServerMessage] = queue.Queue()
    place = tmp_path / "out.json"
    with solving() as (thread, found):
        job = Job(1, 1, document)
        thread.ask(job)
        until(found, "progress")
        thread.export(warp_export(place), job, place, answers.put)
        begun = time.process_time()
        thread.cancel(1)
        answer = answers.get(timeout=60)
        assert time.process_time() - begun < 3
    assert isinstance(answer, messages.Refused)
    assert "was stopped" in answer.reason
    assert not place.exists()


def test_an_export_tells_how_far_its_own_search_is_and_can_be_ended(document: Document, tmp_path: Path) -> None:
    answers: queue.Queue[messages.ServerMessage] = queue.Queue()
    place = tmp_path / "out.json"
    with solving() as (thread, found):
        # Nobody has asked for its curve.
        thread.export(warp_export(place), Job(3, 1, document), place, answers.put)
        assert until(found, "progress").job.revision == 3
        thread.cancel(3)
        assert isinstance(answers.get(timeout=60), messages.Refused)
        thread.export(warp_export(place), Job(4, 1, replace(document, options={"length": "50%"})), place, answers.put)
        assert isinstance(answers.get(timeout=60), messages.Exported)
    assert place.exists()


def test_what_is_to_be_exported_is_not_given_up_for_what_comes_after(
    document: Document, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(solver_thread, "_PATIENCE", 0.0)
    answers: queue.Queue[messages.ServerMessage] = queue.Queue()
    place = tmp_path / "out.json"
    some = replace(document, options={"length": "150%", "upsample": 2, "max_skip": 8})
    with solving() as (thread, found):
        job = Job(1, 1, some)
        thread.ask(job)
        until(found, "clip 0")
        thread.export(warp_export(place), job, place, answers.put)
        thread.ask(Job(2, 1, replace(document, options={"length": "50%"})))
        assert [until(found, "curve").job.revision for _ in range(2)] == [1, 2]
        assert isinstance(answers.get(timeout=60), messages.Exported)
