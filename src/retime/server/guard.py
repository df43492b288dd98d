"""Who may speak with the server: this machine's browser, from this server's own page, with the secret it was given.

Any page in the same browser can send requests to a loopback address, and a name under a stranger's control can be made
to point there. So the Host, the Origin and a secret are checked, on HTTP and WebSocket alike, before anything else.
"""

from __future__ import annotations

import hmac
import secrets
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from retime.server.returning import Returning

# Of the body of a request; what is dropped on the page is the largest.
MAX_BODY = 256 << 20
# The page does not ask for this in a year; who guesses tokens does.
MAX_URL = 4096

_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; media-src 'self'; "
    "font-src 'self'; connect-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": _POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class Guard:
    """Refuses what does not come from the server's own page.

    Parameters
    ----------
    app : ASGI application
        What is guarded.
    port : int
        The port listened on.
    token : str, optional
        The secret in the first address; left out, a random one.
    returning : Returning, optional
        Admits pages of an earlier run that prove that they were admitted to that.

    Attributes
    ----------
    token : str
        The secret in the first address.
    cookie : str
        Name of the cookie that it is exchanged for. It tells the port, for cookies don't.
    """

    def __init__(
        self, app: ASGIApp, *, port: int, token: str | None = None, returning: Returning | None = None
    ) -> None:
        self._app = app
        self._returning = returning
        self.token = token or secrets.token_urlsafe(32)
        self.cookie = f"retime-{port}"
        self._secret = secrets.token_urlsafe(32)
        self.hosts = (f"127.0.0.1:{port}", f"localhost:{port}")

    @property
    def address(self) -> str:
        """The first address, with the token in it."""
        return f"http://{self.hosts[0]}/?token={self.token}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Check a request, and pass it on."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        refusal = self._refusal(scope)
        if scope["type"] == "websocket":
            if refusal is None:
                await self._app(scope, receive, send)
            else:
                await self._refuse_socket(refusal, receive, send)
            return
        if refusal is not None:
            await self._answer(refusal, scope, receive, send)
            return
        await self._app(scope, _capped(receive), _with_headers(send))

    def _refusal(self, scope: Scope) -> Response | None:
        """Say what is wrong with a request; nothing, where it may pass."""
        headers = Headers(scope=scope)
        hosts = headers.getlist("host")
        if len(hosts) != 1 or hosts[0].lower() not in self.hosts:
            return PlainTextResponse("this server answers to the address that it printed, and to no other", 421)
        origins = headers.getlist("origin")
        websocket = scope["type"] == "websocket"
        # Scheme, host and port: another server on this machine is a stranger too. The page speaks with the address that
        # it came from, so both must agree.
        expected = f"http://{hosts[0].lower()}"
        if (websocket or scope["method"] not in ("GET", "HEAD")) and origins != [expected]:
            return PlainTextResponse("this request does not come from the editor's own page", 403)
        if any(origin != expected for origin in origins):
            return PlainTextResponse("this request does not come from the editor's own page", 403)
        if len(scope.get("raw_path") or b"") + len(scope["query_string"]) > MAX_URL:
            return PlainTextResponse("the address is too long", 414)
        if not websocket and scope["path"] == "/" and b"token=" in scope["query_string"]:
            return self._exchange(scope)
        if not websocket and scope["path"] == "/resume" and self._returning is not None:
            return self._resume(self._returning, scope, hosts[0].lower(), headers)
        if not self._knows_secret(headers):
            return PlainTextResponse(
                "open the address that retime edit printed: it holds the key to this page, and works in one browser "
                "after the other",
                403,
            )
        return self._body_refusal(headers)

    def _exchange(self, scope: Scope) -> Response:
        """Take the token out of the address, and give a cookie for it."""
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])
        if len(given) != 1 or not hmac.compare_digest(given[0].encode(), self.token.encode()):
            return PlainTextResponse("the token in this address is not this server's", 403)
        return self._with_cookie(RedirectResponse("/", 303))

    def _resume(self, returning: Returning, scope: Scope, host: str, headers: Headers) -> Response:
        """Answer a page of an earlier run: first prove who we are, then let it prove who it is."""
        if headers.get("sec-fetch-site", "same-origin") != "same-origin":
            return PlainTextResponse("this request does not come from the editor's own page", 403)
        given = parse_qs(scope["query_string"].decode("latin-1"))
        word = given.get("word", [""])[0]
        if scope["method"] == "GET":
            greeting = returning.greet(host, word)
            return PlainTextResponse("no word", 400) if greeting is None else JSONResponse(greeting)
        if not returning.admits(host, word, given.get("proof", [""])[0]):
            return PlainTextResponse("this page belongs to another editor", 403)
        return self._with_cookie(Response(status_code=204))

    def _with_cookie(self, response: Response) -> Response:
        response.set_cookie(self.cookie, self._secret, path="/", httponly=True, samesite="strict")
        return response

    def _knows_secret(self, headers: Headers) -> bool:
        jar: SimpleCookie = SimpleCookie()
        try:
            for text in headers.getlist("cookie"):
                jar.load(text)
        except CookieError:
            return False
        morsel = jar.get(self.cookie)
        return morsel is not None and hmac.compare_digest(morsel.value.encode(), self._secret.encode())

    def _body_refusal(self, headers: Headers) -> Response | None:
        length = headers.get("content-length")
        if length is None:
            return None
        if not (length.isascii() and length.isdigit() and len(length) <= 15):
            return PlainTextResponse("the length of the body is no number", 400)
        if int(length) > MAX_BODY:
            return PlainTextResponse(f"the body has {length} bytes, the limit is {MAX_BODY}", 413)
        return None

    async def _answer(self, response: Response, scope: Scope, receive: Receive, send: Send) -> None:
        await response(scope, receive, _with_headers(send))

    async def _refuse_socket(self, response: Response, receive: Receive, send: Send) -> None:
        """Refuse a WebSocket before it is one: the browser sees the handshake fail."""
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": bytes(response.body).decode()[:120]})


def _capped(receive: Receive) -> Receive:
    """Count a body's bytes: a length need not be declared, nor true."""
    seen = 0

    async def counted() -> Message:
        nonlocal seen
        message = await receive()
        seen += len(message.get("body", b""))
        if seen > MAX_BODY:
            raise BodyTooLarge(f"the body has more than {MAX_BODY} bytes, the limit")
        return message

    return counted


class BodyTooLarge(Exception):
    """A body goes on beyond its limit."""


def _with_headers(send: Send) -> Send:
    async def added(message: Message) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = [
                *message.get("headers", []),
                *((name.lower().encode(), value.encode()) for name, value in HEADERS.items()),
            ]
        await send(message)

    return added
