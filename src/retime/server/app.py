"""The web application: static files, one WebSocket, and the running of it all."""

from __future__ import annotations

import asyncio
import contextlib
import re
import secrets
import shutil
import socket
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, PlainTextResponse, Response
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect, WebSocketState

from retime.errors import FormatError, RetimeError
from retime.project.allowed_places import AllowedPlaces
from retime.project.document import Document
from retime.project.recent import recent
from retime.project.workspace import Workspace
from retime.server import PAGE, messages, no_page
from retime.server.beside_stage import BesideStage
from retime.server.film import Films
from retime.server.guard import BodyTooLarge, Guard
from retime.server.message_coding import read_message, write_message
from retime.server.outbox import Outbox
from retime.server.returning import Returning
from retime.server.shared_document import SharedDocument, welcome
from retime.server.unexpected import words_for_page

# Of one message of the page's: a document is a few thousand bytes.
MAX_MESSAGE = 4 << 20


class Editor:
    """The application, and the document that it serves.

    Parameters
    ----------
    workspace : Workspace
        What to edit.
    places : AllowedPlaces
        Where it may read and write.
    state : Path
        Folder for what has no place of its own.
    page : Path
        Folder of the page that npm built.
    welcome : bool
        Nothing was named to edit: the page begins with what could be.
    command : str
        What starts this editor again; empty where no command did.
    key : str
        Which its pages hold, to come back to a later run; left out, a random one, and they can't.
    """

    def __init__(
        self,
        workspace: Workspace,
        places: AllowedPlaces,
        state: Path,
        *,
        page: Path = PAGE,
        welcome: bool = False,
        command: str = "",
        key: str | None = None,
    ) -> None:
        self._command = command
        self.returning = Returning(key or secrets.token_urlsafe(32))
        self._workspace, self._places, self._state = workspace, places, state
        self._shared: SharedDocument | None = None
        self._is_welcome = welcome
        # One folder for all files dropped in this run: they keep their names, so an AMC finds its ASF.
        self._drops = state / "dropped" / secrets.token_hex(8)
        self._beside = BesideStage(self._document, places)
        self._films = Films(self._document, self._project, places)
        routes: list[BaseRoute] = [
            WebSocketRoute("/socket", self._socket),
            Route("/drop", self._drop, methods=["POST"]),
            Route("/health", self._health),
            Route("/welcome", self._welcome),
            Route("/output", self._output, methods=["POST"]),
            *self._beside.routes,
            *self._films.routes,
        ]
        if (page / "index.html").is_file():
            # It resolves every path, and serves what is inside the folder only.
            routes.append(Mount("/", StaticFiles(directory=page, html=True)))
        else:
            routes.append(Route("/", self._no_page))
        self.app = Starlette(routes=routes, lifespan=self._lifespan)

    @contextlib.asynccontextmanager
    async def _lifespan(self, app: Starlette) -> AsyncIterator[None]:
        shared = self._shared = SharedDocument(self._workspace, self._places, self._state)
        yield
        self._beside.close()
        self._films.close()
        await shared.close()
        used = shared.files()
        if self._drops.is_dir() and not any(Path(path).is_relative_to(self._drops) for path in used):
            shutil.rmtree(self._drops)

    def _document(self) -> Document:
        assert self._shared is not None
        return self._shared.document

    def _project(self) -> Path | None:
        assert self._shared is not None
        return self._shared.path

    async def _health(self, request: Request) -> Response:
        return PlainTextResponse("ok")

    async def _output(self, request: Request) -> Response:
        """Keep the output as it is now, as a file that can be a reference; answer with its path."""
        assert self._shared is not None
        try:
            place = await self._shared.keep_output(self._drops)
        except (RetimeError, OSError) as error:
            return PlainTextResponse(words_for_page(error), 409)
        except Exception as error:
            return PlainTextResponse(words_for_page(error), 500)
        return JSONResponse({"path": str(place)})

    async def _welcome(self, request: Request) -> Response:
        """Say whether the page begins with a welcome, and what was opened last that may be opened again."""
        files = await asyncio.to_thread(recent, self._state)
        listed = [{"path": str(path), "name": path.name} for path in files if self._places.allows(path)]
        return JSONResponse({"show": self._is_welcome, "recent": listed})

    async def _no_page(self, request: Request) -> Response:
        return PlainTextResponse(no_page(), 501)

    async def _drop(self, request: Request) -> Response:
        """Keep a file that was dropped on the page, and answer with its path."""
        assert self._shared is not None
        name = request.query_params.get("name", "")
        if not name.isprintable() or not _PLAIN_NAME.fullmatch(name):
            return PlainTextResponse("a dropped file needs a plain name", 400)
        try:
            data = await request.body()
            place = await asyncio.to_thread(self._shared.drop, name, data, self._drops)
        except BodyTooLarge as error:
            return PlainTextResponse(str(error), 413)
        except FormatError as error:
            return PlainTextResponse(str(error), 415)
        except OSError as error:
            return PlainTextResponse(error.strerror or "it can't be written", 507)
        except Exception as error:
            return PlainTextResponse(words_for_page(error), 500)
        return JSONResponse({"path": str(place)})

    async def _socket(self, socket: WebSocket) -> None:
        shared = self._shared
        assert shared is not None
        await socket.accept()
        page = Outbox()
        sender: asyncio.Task[None] | None = None
        try:
            if not await _greeted(socket, welcome(self._command, self.returning.key)):
                return
            shared.join(page)
            sender = asyncio.create_task(_send_all(socket, page))
            while True:
                text = await socket.receive_text()
                try:
                    message = read_message(text)
                except Exception as error:
                    shared.refuse(page, error)
                else:
                    shared.handle(page, message)
        except (WebSocketDisconnect, KeyError):
            # A binary message ends in a KeyError; pages send none.
            pass
        except RuntimeError:
            # A page that has gone is found out by who sends to it: then there is nothing to receive from either.
            if socket.application_state is WebSocketState.CONNECTED:
                raise
        finally:
            shared.leave(page)
            if sender is not None:
                sender.cancel()


# No separator of any system, no leading dot or dash, nothing that a shell or a terminal would take amiss.
_PLAIN_NAME = re.compile(r"[^\W_][\w .()+,=@~-]{0,150}\.\w{1,8}")


async def _greeted(socket: WebSocket, answer: messages.Welcome) -> bool:
    """Exchange versions; whether the page speaks ours."""
    try:
        hello = read_message(await socket.receive_text())
        if not isinstance(hello, messages.Hello):
            raise FormatError('expected "hello" first')
    except FormatError as error:
        await socket.close(1003, str(error)[:120])
        return False
    await socket.send_text(str(write_message(answer)))
    if hello.version != messages.VERSION:
        await socket.close(1003, "the page is of another version than its server: load it again")
        return False
    return True


async def _send_all(socket: WebSocket, page: Outbox) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        while True:
            payload = await page.get()
            # While much waits, only this lets the loop find out that the page has gone; asyncio logs every later send.
            await asyncio.sleep(0)
            if isinstance(payload, str):
                await socket.send_text(payload)
            else:
                await socket.send_bytes(payload)


def listen(port: int) -> socket.socket:
    """Listen on a loopback port; 0 takes any that is free."""
    # The protocol is named because asyncio switches Nagle's algorithm off only where it knows that this is TCP. With it
    # on, a curve waits for the browser's delayed acknowledgement of what was sent before: up to 40 ms.
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
    if sys.platform != "win32":
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    else:
        # There any program may listen on a port that is listened on, unless this forbids it.
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
    try:
        listener.bind(("127.0.0.1", port))
        listener.listen(128)
    except OSError:
        listener.close()
        raise
    return listener


class EditorServer(uvicorn.Server):  # type: ignore[misc, unused-ignore]
    """A server of the editor on a loopback port.

    Parameters
    ----------
    editor : Editor
        What to serve.
    port : int
        0 takes any that is free.

    Attributes
    ----------
    guard : Guard
        Knows the address.
    port : int
        Where it listens.
    key : str
        Which its pages hold.

    Raises
    ------
    OSError
        The port is taken.
    """

    def __init__(self, editor: Editor, *, port: int = 0) -> None:
        self._listener = listen(port)
        self.port: int = self._listener.getsockname()[1]
        self.key = editor.returning.key
        self.guard = Guard(editor.app, port=self.port, returning=editor.returning)
        super().__init__(
            uvicorn.Config(
                self.guard,
                log_level="warning",
                access_log=False,
                ws="websockets-sansio",
                ws_max_size=MAX_MESSAGE,
                ws_per_message_deflate=False,
                server_header=False,
                lifespan="on",
                timeout_graceful_shutdown=2,
            )
        )

    def serve_until_interrupted(self) -> None:
        """Serve; from before this call on, connections wait to be served."""
        with self._listener:
            self.run(sockets=[self._listener])
