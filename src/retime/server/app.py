"""The web application: static files, one WebSocket, and the running of it all."""

from __future__ import annotations

import asyncio
import contextlib
import socket
import sys
from collections.abc import AsyncIterator, Callable
from pathlib import Path

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from retime.errors import FormatError
from retime.formats.registry import FORMATS
from retime.project.document import Document
from retime.project.places import Places
from retime.server import messages
from retime.server.guard import Guard
from retime.server.messages import read_message, write_message
from retime.server.session import EditorSession, Outbox

PAGE = Path(__file__).parent / "page"
# Of one message of the page's: a document is a few thousand bytes.
MAX_MESSAGE = 4 << 20


class Editor:
    """The application and its session."""

    def __init__(self, places: Places, document: Document, *, page: Path = PAGE) -> None:
        self._places = places
        self._document = document
        self._session: EditorSession | None = None
        routes = [WebSocketRoute("/socket", self._socket), Route("/health", self._health)]
        if (page / "index.html").is_file():
            routes.append(Mount("/", StaticFiles(directory=page, html=True)))
        else:
            routes.append(Route("/", self._no_page))
        self.app = Starlette(routes=routes, lifespan=self._lifespan)

    @contextlib.asynccontextmanager
    async def _lifespan(self, app: Starlette) -> AsyncIterator[None]:
        self._session = EditorSession(self._places, self._document)
        yield
        self._session.close()

    async def _health(self, request: Request) -> Response:
        return PlainTextResponse("ok")

    async def _no_page(self, request: Request) -> Response:
        return PlainTextResponse(NO_PAGE, 501)

    async def _socket(self, socket: WebSocket) -> None:
        await socket.accept()
        session = self._session
        assert session is not None
        page = Outbox()
        sender: asyncio.Task[None] | None = None
        try:
            hello = read_message(await socket.receive_text())
            if not isinstance(hello, messages.Hello):
                raise FormatError('expected "hello" first')
            opens = tuple(suffix for known in FORMATS for suffix in known.suffixes)
            welcome = messages.Welcome(messages.VERSION, _version(), opens)
            await socket.send_text(str(write_message(welcome)))
            if hello.version != messages.VERSION:
                await socket.close(1000)
                return
            session.join(page)
            sender = asyncio.create_task(_send_all(socket, page))
            while True:
                session.handle(page, read_message(await socket.receive_text()))
        except FormatError as error:
            # A page that does not speak the language is of another version, or no page.
            await socket.close(1003, str(error)[:120])
        except (WebSocketDisconnect, KeyError):
            pass
        finally:
            session.leave(page)
            if sender is not None:
                sender.cancel()


def _version() -> str:
    from importlib.metadata import version

    return version("retime")


async def _send_all(socket: WebSocket, page: Outbox) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        while True:
            payload = await page.get()
            if isinstance(payload, str):
                await socket.send_text(payload)
            else:
                await socket.send_bytes(payload)


NO_PAGE = (
    "This installation has no page for the editor. Wheels have it; in a source checkout build it with npm: make page."
)


def listen(port: int) -> socket.socket:
    """Listen on a loopback port; 0 takes any that is free."""
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    if sys.platform != "win32":
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind(("127.0.0.1", port))
        listener.listen(128)
    except OSError:
        listener.close()
        raise
    return listener


def serve(editor: Editor, *, port: int = 0, started: Callable[[str], None]) -> None:
    """Serve until interrupted.

    Parameters
    ----------
    editor : Editor
        What to serve.
    port : int
        On the loopback address; 0 takes any that is free.
    started : function of str
        Called with the address, token included, when it listens.
    """
    with listen(port) as listener:
        guard = Guard(editor.app, port=listener.getsockname()[1])
        config = uvicorn.Config(
            guard,
            log_level="warning",
            access_log=False,
            ws="websockets-sansio",
            ws_max_size=MAX_MESSAGE,
            ws_per_message_deflate=False,
            server_header=False,
            lifespan="on",
            timeout_graceful_shutdown=2,
        )
        started(guard.address)
        uvicorn.Server(config).run(sockets=[listener])
