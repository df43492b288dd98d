"""A real server in a thread, and clients that speak with it as a page does, or as a stranger would."""

from __future__ import annotations

import http.client
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from websockets.sync.client import ClientConnection, connect

from retime import write
from retime.project.allowed_places import AllowedPlaces
from retime.project.workspace import new_document, open_document, open_project
from retime.server.app import Editor, EditorServer
from retime.server.messages import VERSION
from tests.cli.figures import curve, figure
from tests.server.frames import read

KEY = {"id": "k", "input_time": 2.0, "output_time": 1.5, "speed": None}


@dataclass(frozen=True)
class Answer:
    status: int
    headers: dict[str, str]
    body: bytes


@dataclass
class Page:
    """What a page says and is told, by a WebSocket.

    The answers to one edit come in no order between kinds: what is waited for may be in `mail` already.
    """

    socket: ClientConnection
    document: dict[str, Any] = field(default_factory=dict)
    revision: int = 0
    mail: list[dict[str, Any]] = field(default_factory=list)
    heard: list[str] = field(default_factory=list)

    def say(self, kind: str, **fields: Any) -> None:
        self.socket.send(json.dumps({"type": kind, **fields}))

    def hear(self) -> dict[str, Any]:
        message = read(self.socket.recv(timeout=30))
        self.heard.append(message["type"])
        return message

    def until(self, *kinds: str, **fields: Any) -> dict[str, Any]:
        """Take the first message of one of these kinds, with these fields, that has come or will come."""

        def fits(message: dict[str, Any]) -> bool:
            return message["type"] in kinds and all(message[name] == value for name, value in fields.items())

        for i, message in enumerate(self.mail):
            if fits(message):
                return self.mail.pop(i)
        while True:
            message = self.hear()
            if fits(message):
                return message
            self.mail.append(message)

    def change(self, kind: str, **fields: Any) -> int:
        """Ask for a change, and return the revision that it makes."""
        self.revision += 1
        self.say(kind, revision=self.revision, **fields)
        return self.revision

    def edit(self, gesture: str = "", *, done: bool = True, label: str = "edit", **changes: Any) -> int:
        """Send the document with changes, and return its revision."""
        self.document = {**self.document, **changes}
        return self.change("edit", gesture=gesture, done=done, label=label, document=self.document)

    def told(self, **fields: Any) -> dict[str, Any]:
        """Wait for the state of the last revision asked for, or of the one with these fields."""
        state = self.until("state", **(fields or {"revision": self.revision}))
        self.document, self.revision = state["document"], state["revision"]
        return state

    def curve(self, revision: int | None = None) -> dict[str, Any]:
        """Wait for the curve or the problem of a revision, the last asked for where it is left out."""
        return self.until("curve", "problem", revision=self.revision if revision is None else revision)


@dataclass
class Served:
    """A server that runs."""

    server: EditorServer
    folder: Path

    @property
    def host(self) -> str:
        return self.server.guard.hosts[0]

    def ask(
        self, path: str, *, method: str = "GET", body: Any = None, chunked: bool = False, **headers: str | None
    ) -> Answer:
        """Send a request; a header that is None is left out."""
        connection = http.client.HTTPConnection(self.host, timeout=30)
        try:
            connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            given = {"Host": self.host, "Cookie": self.cookie, **headers}
            if isinstance(body, bytes):
                given.setdefault("Content-Length", str(len(body)))
            for name, value in given.items():
                for one in [value] if isinstance(value, str) else value or []:
                    connection.putheader(name.replace("_", "-"), one)
            connection.endheaders(body, encode_chunked=chunked)
            answer = connection.getresponse()
            return Answer(answer.status, {k.lower(): v for k, v in answer.getheaders()}, answer.read())
        finally:
            connection.close()

    @property
    def cookie(self) -> str:
        """The cookie that the token is exchanged for."""
        connection = http.client.HTTPConnection(self.host, timeout=30)
        connection.request("GET", f"/?token={self.server.guard.token}")
        answer = connection.getresponse()
        answer.read()
        connection.close()
        return str(answer.headers["set-cookie"]).partition(";")[0]

    def socket(self, **options: Any) -> ClientConnection:
        given: dict[str, Any] = {
            "origin": f"http://{self.host}",
            "additional_headers": {"Cookie": self.cookie},
            "max_size": None,
            "compression": None,
            **options,
        }
        return connect(f"ws://{self.host}/socket", **given)

    @contextmanager
    def page(self) -> Iterator[Page]:
        """Open a page that has been greeted."""
        with self.socket() as socket:
            page = Page(socket)
            page.say("hello", version=VERSION)
            assert page.hear()["type"] == "welcome"
            yield page

    @contextmanager
    def ready_page(self) -> Iterator[Page]:
        """Open a page, and listen until it knows the document and its curve is explained."""
        with self.page() as page:
            page.until("why")
            (state,) = [message for message in page.mail if message["type"] == "state"]
            page.document, page.revision = state["document"], state["revision"]
            page.mail.clear()
            page.heard.clear()
            yield page


@contextmanager
def serving(
    folder: Path, *clips: str, references: tuple[str, ...] = (), project: str | None = None, page: Path | None = None
) -> Iterator[Served]:
    """Serve clips or a project of a folder; what was not saved is kept beside the folder."""
    state = folder.parent / "state"
    document = None
    if clips:
        document = new_document([str(folder / clip) for clip in clips], [str(folder / clip) for clip in references])
    if project is not None:
        workspace = open_project(folder / project, document)
    else:
        assert document is not None
        workspace = open_document(document, folder=state)
    places = AllowedPlaces([folder], command=["retime", "edit", *clips])
    server = EditorServer(Editor(workspace, places, state, page=page or folder / "no page"))
    thread = threading.Thread(target=server.serve_until_interrupted)
    thread.start()
    try:
        yield Served(server, folder)
    finally:
        server.should_exit = True
        thread.join(30)
        assert not thread.is_alive()


def make_clips(place: Path) -> Path:
    """Make a folder with clips."""
    place.mkdir()
    write(figure(), place / "jump.bvh")
    write(figure("leap", swing=0.9), place / "leap.bvh")
    write(curve(), place / "camera.csv")
    return place
