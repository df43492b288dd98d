"""`retime edit`, as a process: the address, the page's way in, and the end."""

from __future__ import annotations

import http.client
import importlib.util
import json
import os
import re
import shlex
import signal
import socket
import subprocess
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from retime.data import SAMPLE
from retime.server import PAGE
from tests.cli.conftest import COMMAND

pytestmark = pytest.mark.skipif(
    importlib.util.find_spec("starlette") is None, reason="needs the extra edit: starlette is not installed"
)
needs_page = pytest.mark.skipif(not (PAGE / "index.html").is_file(), reason="needs the editor's page: make page")


@contextmanager
def edited(*arguments: str | Path, folder: Path, **environment: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run `retime edit`, and give it with the address that it prints."""
    process = subprocess.Popen(
        [*COMMAND, "edit", *map(str, arguments), "--no-browser"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder,
        env={**os.environ, "RETIME_STATE": str(folder / "state"), **environment},
    )
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert line.startswith("editing at http://127.0.0.1:"), line + process.communicate()[1]
        yield process, line.split()[-1]
    finally:
        process.kill()
        process.communicate()


def ended(process: subprocess.Popen[str], address: str) -> tuple[str, str]:
    """Interrupt an editor that has begun to serve; return what it said."""
    connection = http.client.HTTPConnection(address.split("/")[2], timeout=30)
    connection.request("GET", "/health")
    assert connection.getresponse().status == 403
    connection.close()
    process.send_signal(signal.SIGINT)
    return process.communicate(timeout=30)


@needs_page
def test_it_prints_an_address_that_works_once_the_token_is_exchanged(clips, run, tmp_path, monkeypatch) -> None:
    with edited(clips.bvh, "--reference", clips.bvh, "--port", "0", "--up", "y", folder=tmp_path) as (process, address):
        host, path = re.fullmatch(r"http://([\d.]+:\d+)(/\?token=[\w-]+)", address).groups()
        connection = http.client.HTTPConnection(host, timeout=30)
        connection.request("GET", path)
        answer = connection.getresponse()
        answer.read()
        assert (answer.status, answer.getheader("location")) == (303, "/")
        cookie = answer.getheader("set-cookie").partition(";")[0]
        connection.request("GET", "/health", headers={"Cookie": cookie})
        assert connection.getresponse().read() == b"ok"
        connection.close()

        # Its port is taken now; another editor says so, and leaves nothing behind.
        monkeypatch.setenv("RETIME_STATE", str(tmp_path / "another"))
        result = run("edit", clips.bvh, "--port", host.rpartition(":")[2], "--no-browser", code=1)
        assert result.stderr == "error: Address already in use\n"
        assert list((tmp_path / "another" / "journals").iterdir()) == []

        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=30) == ("", "")
        assert process.returncode == 0


@needs_page
def test_a_project_is_begun_and_open_once(clips, run, tmp_path) -> None:
    with edited(clips.bvh, "--project", "p.retime", "--folder", tmp_path, folder=tmp_path):
        assert (tmp_path / ".p.retime-journal").exists()
        again = run("edit", clips.bvh, "--project", "p.retime", "--no-browser", code=2)
        assert "another editor has this open" in again.stderr


@needs_page
def test_a_project_whose_files_lie_elsewhere_says_what_to_type(clips, tmp_path) -> None:
    home = tmp_path / "projects"
    home.mkdir()
    value = {"clips": [{"path": str(clips.bvh)}]}
    (home / "p.retime").write_text(json.dumps({"format": "retime-project", "version": 2, "document": value}))
    with edited("--project", "p.retime", folder=home) as (process, address):
        said = ended(process, address)[1]
    typed = shlex.split(said.partition("type: ")[2])
    assert typed == ["retime", "edit", "--project", "p.retime", "--folder", str(clips.bvh.parent)]
    # What it says to type, typed.
    with edited(*typed[2:], folder=home) as (process, address):
        assert ended(process, address) == ("", "")


def _asked(address: str, path: str) -> Any:
    """Ask an editor as its page does."""
    opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
    opener.open(address).close()
    with opener.open(f"{address.partition('?')[0]}{path}") as answer:
        return json.load(answer)


@needs_page
def test_without_a_clip_it_begins_with_the_sample_and_what_was_opened_last(clips, tmp_path) -> None:
    (tmp_path / "elsewhere").mkdir()
    with edited(clips.bvh, folder=tmp_path) as (process, address):
        assert _asked(address, "welcome") == {
            "show": False,
            "recent": [{"path": str(clips.bvh), "name": clips.bvh.name}],
        }
        assert ended(process, address) == ("", "")
    # From another folder too: what was opened before was named by a person then.
    environment = {"RETIME_STATE": str(tmp_path / "state")}
    with edited(folder=tmp_path / "elsewhere", **environment) as (process, address):
        told = _asked(address, "welcome")
        assert told == {"show": True, "recent": [{"path": str(clips.bvh), "name": clips.bvh.name}]}
        assert (tmp_path / "state" / "sample" / "sample.bvh").read_bytes() == SAMPLE.read_bytes()
        assert ended(process, address) == ("", "")


@needs_page
def test_media_and_beats_stand_in_the_document(clips, run, tmp_path) -> None:
    (tmp_path / "take.wav").write_bytes(b"RIFF\x04\0\0\0WAVE")
    (tmp_path / "beats.csv").write_text("0.5\n")
    (tmp_path / "list.mp4").write_text("#EXTM3U\n")
    beside = ("--media", tmp_path / "take.wav", "--media-offset", "-12f", "--beats", tmp_path / "beats.csv")
    with edited(clips.bvh, *beside, folder=tmp_path) as (process, address):
        opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
        opener.open(address).close()
        with opener.open(f"{address.partition('?')[0]}media") as answer:
            assert answer.read() == (tmp_path / "take.wav").read_bytes()
        with opener.open(f"{address.partition('?')[0]}beats") as answer:
            assert json.load(answer)["times"] == [0.5]
        (journal,) = (tmp_path / "state" / "journals").glob("*.journal")
        said = json.loads(journal.read_text().splitlines()[0].partition(" ")[2])
        assert ended(process, address) == ("", "")
    assert said["start"]["media"] == {"path": str(tmp_path / "take.wav"), "offset": "-12f", "clock": "input"}
    refused = run("edit", clips.bvh, "--media", tmp_path / "list.mp4", "--no-browser", code=1)
    assert "a playlist" in refused.stderr


@needs_page
@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--reference", "x.bvh", "--project", "p.retime"], "--reference needs a clip"),
        (["--media", "take.mp4", "--project", "p.retime"], "--media needs a clip"),
        (["--beats", "song.csv", "--project", "p.retime"], "--beats needs a clip"),
        (["x.bvh", "--media-offset", "1s"], "--media-offset needs --media"),
        (["x.bvh", "--media", "take.mp4", "--media-offset", "soon"], "expected a time such as"),
        (["--project", "p.txt"], "a project's name ends in .retime"),
        (["x.bvh", "--project", "there.retime"], "is there already, with clips of its own"),
    ],
)
def test_what_makes_no_sense_is_refused(run, tmp_path, arguments, says) -> None:
    (tmp_path / "there.retime").touch()
    assert says in run("edit", *arguments, "--no-browser", code=1 if "p.txt" in arguments else 2).stderr


def test_it_says_which_extra_is_missing(run, clips, monkeypatch) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "uvicorn" else find(name))
    result = run("edit", clips.bvh, "--no-browser", code=1)
    assert "uvicorn, which is not installed: pip install 'retime[edit]'" in result.stderr


def test_without_a_page_it_says_so_before_it_serves(run, clips, tmp_path, monkeypatch) -> None:
    page = tmp_path / "site-packages" / "retime" / "server" / "page"
    page.mkdir(parents=True)
    monkeypatch.setattr("retime.server.PAGE", page)
    monkeypatch.setattr("retime.server.app.EditorServer", None)
    monkeypatch.setenv("RETIME_STATE", str(tmp_path / "state"))
    for reason, says in (
        (None, "which npm builds"),
        ("npm was not found", "when retime was installed, npm was not found"),
    ):
        if reason is not None:
            (page / "missing.txt").write_text(reason + "\n")
        result = run("edit", clips.bvh, "--no-browser", code=1)
        assert result.stderr.startswith("error: the editor has no page here")
        assert says in result.stderr
        assert "pip install --force-reinstall" in result.stderr
        assert result.stdout == ""
        row = run("info", "--build").stdout.splitlines()[-1]
        assert row.startswith("page")
        assert says in row
    # In a checkout it is built, not installed.
    page = tmp_path / "src" / "retime" / "server" / "page"
    (tmp_path / "web").mkdir()
    (tmp_path / "web" / "package.json").write_text("{}")
    monkeypatch.setattr("retime.server.PAGE", page)
    assert run("edit", clips.bvh, "--no-browser", code=1).stderr.endswith("make page\n")
    assert not (tmp_path / "state").exists()


@needs_page
def test_a_project_is_opened_like_a_clip(clips, run, tmp_path) -> None:
    project = tmp_path / "limp.retime"
    value = {"format": "retime-project", "version": 2, "document": {"clips": [{"path": str(clips.bvh)}]}}
    project.write_text(json.dumps(value))
    with edited(project, folder=tmp_path) as (process, address):
        ended(process, address)
    result = run("edit", project, clips.bvh, "--no-browser", code=2)
    assert f"{project} is a project: open it alone, as retime edit {shlex.quote(str(project))}" in result.stderr
    result = run("edit", project, "--new", "--no-browser", code=2)
    assert "--new begins anew with clips" in result.stderr


@needs_page
def test_the_next_run_takes_the_same_port_where_that_is_free(clips, tmp_path) -> None:
    with edited(clips.bvh, folder=tmp_path) as (process, address):
        ended(process, address)
    with edited(clips.bvh, folder=tmp_path) as (process, again):
        assert again.split("/")[2] == address.split("/")[2]
        # Its token is another, though.
        assert again != address
        ended(process, again)
    port = int(address.split("/")[2].rpartition(":")[2])
    with socket.socket() as taken:
        taken.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        taken.bind(("127.0.0.1", port))
        taken.listen()
        with edited(clips.bvh, folder=tmp_path) as (process, other):
            assert other.split("/")[2] != address.split("/")[2]
            ended(process, other)


@needs_page
def test_clips_that_were_saved_are_found_again_and_one_can_begin_anew(clips, tmp_path) -> None:
    from retime.project.workspace import new_document, open_document

    state, project = tmp_path / "state", tmp_path / "limp.retime"
    workspace = open_document(new_document([str(clips.bvh)]), folder=state)
    workspace.save(project, workspace.history, workspace.warps, overwrite=False)
    workspace.close()
    command = [*COMMAND, "edit", str(clips.bvh), "--no-browser"]
    for more, said in (([], f"going on with {project}, where these clips were saved"), (["--new"], "editing at ")):
        process = subprocess.Popen(
            [*command, *more],
            stdout=subprocess.PIPE,
            text=True,
            cwd=tmp_path,
            env={**os.environ, "RETIME_STATE": str(state)},
        )
        try:
            assert process.stdout is not None
            line = process.stdout.readline()
            assert line.startswith(said)
            if not more:
                assert f"to begin anew: retime edit {shlex.quote(str(clips.bvh))} --new" in line
                assert process.stdout.readline().startswith("editing at ")
        finally:
            process.kill()
            process.communicate()
    assert project.exists()
