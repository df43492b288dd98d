"""What nobody expected is told with a number and logged, and the next request is answered."""

from __future__ import annotations

import asyncio
import json
import logging
import re

import pytest
from starlette.websockets import WebSocket, WebSocketDisconnect

from retime.project.journal import Journal
from retime.project.solve import DocumentSolver
from retime.project.workspace import Workspace
from retime.server import app, files, shared_document, solver_thread
from retime.server.messages import VERSION, Notice
from retime.server.outbox import Outbox
from retime.server.returning import Returning
from retime.server.unexpected import words_for_page
from tests.server.serving import KEY, serving


class Broken:
    """Breaks a function for one call, and has the log checked."""

    def __init__(self, monkeypatch, caplog) -> None:
        self._patch, self._caplog = monkeypatch, caplog

    def once(self, owner: object, name: str, error: BaseException | None = None) -> None:
        whole, calls = getattr(owner, name), []

        def broken(*args, **kwargs):
            calls.append(args)
            if len(calls) == 1:
                raise error or RuntimeError("nobody expected this")
            return whole(*args, **kwargs)

        self._patch.setattr(owner, name, broken)

    def logged(self, words: str) -> None:
        """The number that was told stands in the log, with the place in the program."""
        found = re.search(r"fault (\d+) in retime \(RuntimeError: nobody expected this\)", words)
        assert found, words
        (record,) = [one for one in self._caplog.records if one.getMessage() == f"fault {found[1]} in retime"]
        assert record.levelno == logging.ERROR
        assert record.exc_info is not None
        assert str(record.exc_info[1]) == "nobody expected this"


@pytest.fixture
def broken(monkeypatch, caplog) -> Broken:
    return Broken(monkeypatch, caplog)


def test_each_fault_has_its_own_number_and_what_is_expected_has_none(caplog) -> None:
    first, second = words_for_page(RuntimeError("a")), words_for_page(KeyError("b" * 10_000))
    numbers = [int(re.search(r"fault (\d+)", words)[1]) for words in (first, second)]
    assert numbers[1] == numbers[0] + 1
    assert len(second) < 600
    assert len(caplog.records) == 2
    assert (
        words_for_page(FileNotFoundError(2, "No such file or directory", "a.bvh")) == "a.bvh: No such file or directory"
    )
    assert words_for_page(MemoryError()) == "MemoryError"
    assert len(caplog.records) == 2


@pytest.mark.parametrize(
    ("owner", "name"),
    [(DocumentSolver, "read"), (DocumentSolver, "solve"), (solver_thread, "curve_message")],
)
def test_a_fault_of_the_search_is_a_problem_and_the_next_edit_is_solved(served, broken, owner, name) -> None:
    with served.ready_page() as page:
        broken.once(owner, name)
        page.edit(options={"length": "80%"})
        problem = page.curve()
        assert problem["type"] == "problem"
        broken.logged(problem["message"])
        page.edit(options={"length": "70%"})
        assert page.curve()["type"] == "curve"


def test_a_fault_of_finding_what_is_at_fault_is_told(served, broken) -> None:
    with served.ready_page() as page:
        broken.once(solver_thread, "fault_of")
        page.edit(options={"length": "soon"})
        broken.logged(page.curve()["message"])
        page.edit(options={"length": "soon!"})
        assert "expected a length" in page.curve()["message"]


def test_a_fault_of_the_explanation_keeps_the_curve(served, broken) -> None:
    with served.ready_page() as page:
        broken.once(solver_thread, "why_message")
        page.edit(options={"length": "80%"})
        assert page.curve()["type"] == "curve"
        notice = page.until("notice")["text"]
        assert notice.startswith("this curve can't be explained: ")
        broken.logged(notice)
        page.edit(options={"length": "70%"})
        assert page.until("why")["revision"] == page.revision


def test_a_fault_of_an_export_is_told_and_the_next_is_written(served, broken) -> None:
    with served.ready_page() as page:
        broken.once(solver_thread, "export_warp")
        for kind in ("refused", "exported"):
            page.say("export", what="warp", path="w.json", clip=0, overwrite=False)
            told = page.until("refused", "exported")
            assert told["type"] == kind
            if kind == "refused":
                broken.logged(told["reason"])


@pytest.mark.parametrize("request_", ["listing", "found"])
def test_a_fault_of_an_answer_is_told_and_the_next_is_given(served, broken, request_) -> None:
    say = {
        "listing": ("browse", {"folder": None, "holds": "clip"}),
        "found": ("find", {"path": "jump.bvh", "writing": False}),
    }
    kind, fields = say[request_]
    with served.ready_page() as page:
        broken.once(files, request_)
        page.say(kind, **fields)
        broken.logged(page.until("notice")["text"])
        page.say(kind, **fields)
        assert page.until(request_)


def test_a_fault_of_reading_a_message_is_told(served, broken) -> None:
    with served.ready_page() as page:
        broken.once(app, "read_message")
        page.say("browse", folder=None, holds="clip")
        broken.logged(page.until("notice")["text"])
        page.say("browse", folder=None, holds="clip")
        assert page.until("listing")


def test_a_fault_of_the_autosave_is_told_and_the_next_edit_is_written(served, broken) -> None:
    with served.ready_page() as page:
        broken.once(Journal, "edit")
        page.edit(keys=[KEY])
        notice = page.until("notice")["text"]
        assert "this edit is not safe" in notice
        broken.logged(notice)
        page.edit(keys=[{**KEY, "output_time": 1.6}])
        assert page.told()["document"]["keys"][0]["output_time"] == 1.6


def test_faults_of_saving_and_opening_are_told_and_the_next_works(served, broken) -> None:
    with served.ready_page() as page:
        broken.once(Workspace, "save")
        broken.once(shared_document, "open_document")
        for say in (
            lambda: page.say("save", path="p.retime", overwrite=False),
            lambda: page.say("open", path="leap.bvh"),
        ):
            say()
            broken.logged(page.until("refused")["reason"])
            say()
            assert page.until("saved", "state")


def test_a_fault_of_a_drop_is_told(served, broken) -> None:
    broken.once(files, "keep_dropped")
    data = (served.folder / "jump.bvh").read_bytes()
    origin = f"http://{served.host}"
    answer = served.ask("/drop?name=new.bvh", method="POST", body=data, Origin=origin)
    assert answer.status == 500
    broken.logged(answer.body.decode())
    assert served.ask("/drop?name=new.bvh", method="POST", body=data, Origin=origin).status == 200


def test_links_that_lead_in_a_circle_are_told_and_the_editor_goes_on(folder) -> None:
    for a, b in (("a.bvh", "b.bvh"), ("b.bvh", "a.bvh"), ("a.retime", "b.retime"), ("b.retime", "a.retime")):
        (folder / a).symlink_to(folder / b)
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        for kind, fields in (
            ("open", {"path": "a.retime"}),
            ("save", {"path": "a.retime", "overwrite": True}),
            ("export", {"what": "motion", "path": "a.bvh", "clip": 0, "overwrite": True}),
        ):
            page.say(kind, **fields)
            text = page.until("refused")["reason"]
            assert "symbolic link" in text, (kind, text)
            assert "fault" not in text
        clip = page.document["clips"][0]
        page.edit(clips=[clip, {"path": "a.bvh", "role": "follow"}])
        assert "symbolic link" in page.curve()["message"]
        page.edit(clips=[clip], options={"length": "80%"})
        assert page.curve()["type"] == "curve"
    assert (folder / "a.bvh").is_symlink()


def test_a_page_that_has_gone_is_sent_nothing_more() -> None:
    class Gone:
        """The loop hears of the lost connection as asyncio does: by a call that waits behind the sender."""

        sent = 0
        lost = False

        async def send_text(self, text: str) -> None:
            if self.lost:
                raise WebSocketDisconnect(1006)
            self.sent += 1
            asyncio.get_running_loop().call_soon(setattr, self, "lost", True)

    async def run() -> int:
        page, socket = Outbox(), Gone()
        for number in range(100):
            page.put(Notice("warning", str(number)))
        await asyncio.wait_for(app._send_all(socket, page), 30)
        return socket.sent

    assert asyncio.run(run()) == 1


def test_a_page_whose_going_is_found_out_by_the_sender_ends_quietly() -> None:
    """Its last message is still heard; then there is nothing left to receive from."""

    class Document:
        def __init__(self) -> None:
            self.heard: list[object] = []
            self.left = 0

        def join(self, page: Outbox) -> None:
            page.put(Notice("warning", "told to nobody"))

        def handle(self, page: Outbox, message: object) -> None:
            self.heard.append(message)

        def leave(self, page: Outbox) -> None:
            self.left += 1

    async def run() -> Document:
        document = Document()
        gone = asyncio.Event()
        said = iter(
            [
                {"type": "websocket.connect"},
                {"type": "websocket.receive", "text": json.dumps({"type": "hello", "version": VERSION})},
                {"type": "websocket.receive", "text": json.dumps({"type": "browse", "folder": None, "holds": "clip"})},
            ]
        )
        n_said = 0

        async def receive():
            nonlocal n_said
            n_said += 1
            if n_said == 3:
                await gone.wait()
            return next(said)

        async def send(message) -> None:
            if "told to nobody" in str(message.get("text")):
                gone.set()
                raise OSError("gone")

        editor = object.__new__(app.Editor)
        editor._shared = document
        editor._command, editor.returning = "", Returning("")
        scope = {"type": "websocket", "path": "/socket", "headers": [], "query_string": b""}
        await asyncio.wait_for(editor._socket(WebSocket(scope, receive, send)), 30)
        return document

    document = asyncio.run(run())
    assert len(document.heard) == document.left == 1
