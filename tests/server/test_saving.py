"""Projects saved and opened, and what is left after a death or on a full disk."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import signal
import subprocess
import threading
from pathlib import Path

import pytest

from retime.project import journal as journals
from retime.project.journal import read_journal
from retime.project.workspace import Workspace
from retime.server import PAGE, shared_document
from tests.cli.conftest import COMMAND
from tests.server.serving import KEY, Page, Served, serving


def saved(page: Page, path: str | None) -> dict:
    page.say("save", path=path, overwrite=False)
    return page.until("saved", "refused")


def test_a_project_is_saved_and_opened(folder) -> None:
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(keys=[KEY])
        assert (page.told()["path"], saved(page, None)["reason"]) == (
            None,
            "the project has no name yet: say where to save it",
        )
        assert "ends in .retime" in saved(page, "p.txt")["reason"]
        assert "is an input" in saved(page, "jump.bvh")["reason"]
        assert saved(page, "p.retime")["type"] == "saved"
        assert page.told(saved=True)["path"] == str(folder / "p.retime")
        page.edit(options={"length": "80%"})
        assert not page.told()["saved"]
        assert saved(page, None)["type"] == "saved"
        assert page.told(saved=True)["revision"] == page.revision
        page.say("open", path="leap.bvh")
        assert page.told(opened=1)["document"]["clips"][0]["path"].endswith("leap.bvh")
        page.say("open", path="p.retime")
        state = page.told(opened=2)
        assert (state["document"]["keys"], state["document"]["options"]["length"], state["saved"]) == (
            [KEY],
            "80%",
            True,
        )
        page.say("open", path="none.retime")
        assert page.until("refused", what="open", path="none.retime")["reason"].endswith("No such file or directory")
    assert {path.name for path in folder.iterdir()} == {"jump.bvh", "leap.bvh", "camera.csv", "p.retime"}


def test_a_clean_end_keeps_what_was_not_saved(folder) -> None:
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(keys=[KEY], label="add key")
        page.told()
    with serving(folder, "jump.bvh") as served, served.page() as page:
        state = page.until("state")
        assert (state["recovered"], state["undo_label"], state["document"]["keys"]) == (True, "add key", [KEY])


@pytest.mark.skipif(not (PAGE / "index.html").is_file(), reason="needs the page (make page)")
def test_kill_9_of_the_editor_loses_nothing_that_was_acknowledged(folder, tmp_path) -> None:
    environment = {**os.environ, "RETIME_STATE": str(tmp_path / "state")}
    process = subprocess.Popen(
        [*COMMAND, "edit", str(folder / "jump.bvh"), "--no-browser"], stdout=subprocess.PIPE, text=True, env=environment
    )
    assert process.stdout is not None
    try:
        address = process.stdout.readline().split()[-1]
        host, token = re.fullmatch(r"http://([\d.:]+)/\?token=(.+)", address).groups()
        with _page_at(host, token) as page:
            page.told(revision=1)
            page.edit(options={"length": "75%"}, label="set length")
            page.told()
            for number in range(5):
                page.edit("drag", done=False, label="move key", keys=[{**KEY, "output_time": 1.2 + 0.01 * number}])
            page.until("ack", revision=page.revision)
            process.send_signal(signal.SIGKILL)
    finally:
        process.kill()
        process.communicate()
    with serving(folder, "jump.bvh") as served, served.page() as page:
        state = page.told(revision=1)
        assert (state["recovered"], state["undo_label"]) == (True, "move key")
        assert state["document"]["keys"][0]["output_time"] == 1.24
        page.change("undo")
        state = page.told()
        assert (state["document"]["keys"], state["document"]["options"]["length"]) == ([], "75%")


@contextlib.contextmanager
def _page_at(host: str, token: str):
    class Guard:
        hosts = (host,)

    class Server:
        guard = Guard

    Guard.token = token
    with contextlib.suppress(OSError), Served(Server, Path()).page() as page:
        yield page


def test_a_full_disk_is_told_and_the_next_edit_makes_it_good(served, monkeypatch) -> None:
    write_all = journals._write_all

    def full(file, data) -> None:
        write_all(file, data[:100])
        raise OSError(28, "No space left on device")

    with served.ready_page() as page:
        monkeypatch.setattr(journals, "_write_all", full)
        page.edit(keys=[KEY], label="add key")
        assert "not safe: No space left on device" in page.until("notice")["text"]
        assert "state" not in page.heard
        monkeypatch.setattr(journals, "_write_all", write_all)
        page.edit(options={"length": "80%"}, label="set length")
        state = page.told()
        assert (state["document"]["keys"], state["document"]["options"]["length"]) == ([KEY], "80%")
        page.change("undo")
        assert page.told()["undo_label"] == "add key"


def test_an_edit_without_its_journal_is_not_called_safe(folder) -> None:
    state = folder.parent / "state" / "journals"
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.edit(keys=[KEY])
        page.told()
        shutil.rmtree(state)
        page.edit(options={"length": "80%"})
        assert page.until("notice")["text"] == (
            f"the autosave can't be written, so this edit is not safe: {state}: the folder is gone"
        )
        page.edit(options={"length": "70%"})
        assert "not safe" in page.until("notice")["text"]
        assert not [message for message in page.mail if message["type"] in ("state", "ack")]
        # It is solved all the same; and once the folder is there again, all of it is written.
        assert page.curve()["type"] == "curve"
        state.mkdir()
        page.edit(options={"length": "60%"})
        page.told()
    with serving(folder, "jump.bvh") as served, served.page() as page:
        state = page.until("state")
    assert (state["document"]["keys"], state["document"]["options"]) == ([KEY], {"length": "60%"})


def test_edits_that_come_while_it_is_saved_elsewhere_are_in_the_new_journal(folder, monkeypatch) -> None:
    may_save = threading.Event()
    save = Workspace.save

    def slow(*args, **kwargs) -> None:
        assert may_save.wait(30)
        save(*args, **kwargs)

    monkeypatch.setattr(Workspace, "save", slow)
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.say("save", path="p.retime", overwrite=False)
        # They are taken, and wait for the save to be over.
        page.edit(keys=[KEY], label="add key")
        page.edit(options={"length": "80%"}, label="set length")
        page.change("undo")
        page.curve()
        may_save.set()
        page.until("saved")
        state = page.told()
        assert (state["path"], state["saved"]) == (str(folder / "p.retime"), False)
        assert not [message for message in page.mail if message["type"] == "notice"]
        left = read_journal(folder / ".p.retime-journal").history
        assert [key.id for key in left.present.keys] == ["k"]
        assert left.redo_label == "set length"
    assert [file.suffix for file in (folder.parent / "state" / "journals").iterdir()] == [".saved"]


def test_after_an_edit_that_is_not_safe_every_page_can_make_the_next(served, monkeypatch) -> None:
    whole = journals._write_all

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    with served.ready_page() as page:
        monkeypatch.setattr(journals, "_write_all", full)
        page.edit(keys=[KEY])
        assert "not safe" in page.until("notice")["text"]
        # One that is refused is told how the document stands, and one that comes later too, with what is wrong.
        page.say("undo", revision=-1)
        assert page.told()["document"]["keys"] == [KEY]
        with served.page() as late:
            assert "not safe" in late.until("notice")["text"]
            (state,) = [message for message in late.mail if message["type"] == "state"]
            assert (state["revision"], state["document"]["keys"]) == (page.revision, [KEY])
            monkeypatch.setattr(journals, "_write_all", whole)
            late.document, late.revision = state["document"], state["revision"]
            late.edit(options={"length": "80%"})
            assert late.told()["document"]["options"] == {"length": "80%"}
        with served.page() as later:
            later.until("curve")
            assert "notice" not in later.heard


def test_nothing_else_is_opened_or_saved_before_a_document_is_open(folder, monkeypatch) -> None:
    may_open = threading.Event()
    whole = shared_document.open_document

    def slow(*args, **kwargs) -> Workspace:
        assert may_open.wait(30)
        return whole(*args, **kwargs)

    monkeypatch.setattr(shared_document, "open_document", slow)
    with serving(folder, "jump.bvh") as served, served.ready_page() as page:
        page.say("open", path="leap.bvh")
        page.say("open", path="camera.csv")
        assert page.until("refused")["reason"] == "another document is being opened"
        page.say("save", path="p.retime", overwrite=False)
        assert page.until("refused")["reason"] == "another document is being opened"
        may_open.set()
        state = page.told(opened=1)
        assert state["document"]["clips"][0]["path"].endswith("leap.bvh")
        page.edit(options={"length": "80%"})
        assert page.told()["opened"] == 1
