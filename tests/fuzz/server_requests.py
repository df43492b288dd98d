"""Hostile requests to the editor's server: each is refused, says nothing of what lies outside, and the next is served.

    python -m tests.fuzz.server_requests --count 40

One trial is fifty requests to a server of its own: of another host or origin, without the cookie or with half of it,
for files outside of the page's folder, by other methods, with lengths that are none, and handshakes of a WebSocket like
these; each with one thing wrong or several. Then who has the cookie is served.
"""

from __future__ import annotations

import random
import socket
import string
import sys
import tempfile
import warnings
from pathlib import Path
from urllib.parse import parse_qs

from retime.formats import write
from retime.server.guard import MAX_URL
from tests.fuzz.trials import command, mutated_bytes
from tests.server.serving import Served, serving
from tests.warp.motions import wandering_motion

N_REQUESTS = 50
MOST_SECONDS = 120
_SECRET = b"what nobody is told"
_WRONG = ("host", "origin", "cookie", "path", "method", "length", "target", "bytes")
_PATHS = (
    *("/../secret.txt", "/%2e%2e/secret.txt", "/..%2fsecret.txt", "/%252e%252e/secret.txt", "/way_out/secret.txt"),
    *("//secret.txt", "/assets/../../secret.txt", "/..\\secret.txt", "/%00", "/assets/%00.js", "/socket", "/nothing"),
    *("/assets", "/.", "/index.html/", "/secret.txt", "/%c0%ae%c0%ae/secret.txt", "/\u00fc", "/assets//index.js/.."),
)


def _other(draw: random.Random, right: str) -> str:
    """Return a word that is nearly the right one."""
    at = draw.randrange(len(right) + 1)
    letter = draw.choice(string.printable.replace("\r", "").replace("\n", ""))
    return draw.choice(
        [right[:at] + letter + right[at:], right[:at], right[at:], right[:at] + right[at + 1 :], right * 2]
    )


def _request(draw: random.Random, served: Served, cookie: str) -> bytes:
    """Write a request with something wrong in it."""
    wrong = set(draw.sample(_WRONG, draw.choice([1, 1, 1, 2, 3])))
    host = served.host
    port = host.rpartition(":")[2]
    socket_asked = draw.random() < 0.3 and not wrong & {"path", "method", "length", "target"}
    method, path = "GET", draw.choice(["/", "/health", "/assets/index.js"])
    lines = []
    if "host" in wrong:
        hosts = ["evil.example", f"evil.example:{port}", "127.0.0.1:1", f"[::1]:{port}", _other(draw, host), ""]
        other = draw.choice(hosts)
        lines.append(f"Host: {other if other.strip().lower() not in served.server.guard.hosts else 'x'}")
        if draw.random() < 0.3:
            lines.append(f"Host: {host}")
    else:
        lines.append(f"Host: {host}")
    origin = f"http://{host}"
    if "origin" in wrong:
        origins = ["null", "http://evil.example", f"https://{host}", f"http://localhost:{port}", _other(draw, origin)]
        other = draw.choice(origins)
        lines.append(f"Origin: {other if other.strip() not in ('', origin) else 'null'}")
    elif socket_asked or wrong & {"method", "length"}:
        lines.append(f"Origin: {origin}")
    if "cookie" in wrong:
        name, _, secret = cookie.partition("=")
        cookies = [
            f"{name}={served.server.guard.token}",
            f"{name}=",
            "=;=",
            f"{secret}={name}",
            f"{name[:-1]}={secret}",
        ]
        wrong_one = draw.choice([*cookies, f"{name}={secret[:-1]}", f"{name}={secret}x", f'{name}="{secret[:9]}"', ""])
        if wrong_one:
            lines.append(f"Cookie: {wrong_one}")
    else:
        lines.append(f"Cookie: {cookie}")
    body = b""
    if "length" in wrong:
        method, path = "POST", "/drop?name=a.bvh"
        lines.append(f"Content-Length: {draw.choice(['-1', '1e3', '0x10', '9' * 20, str(1 << 30), 'x', '1 2', '+5'])}")
    elif "method" in wrong:
        method = draw.choice(["PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "BREW", "get", "POST", "G\x00T"])
        body = b"x" * draw.choice([0, 5])
        lines.append(f"Content-Length: {len(body)}")
    if "path" in wrong:
        path = draw.choice(_PATHS)
    elif "target" in wrong:
        token = served.server.guard.token
        other = _other(draw, token)
        if parse_qs(f"token={other}".strip().partition("#")[0]).get("token") == [token]:
            # Nothing was left out, or what was put in says nothing in an address.
            other = token[1:]
        longest = [
            f"/{'x' * (MAX_URL + 10)}",
            f"/?token={other}",
            "/?token=&token=",
            "*",
        ]
        path = draw.choice([*longest, f"http://evil.example{path}/x", "no-slash", "/" + draw.randbytes(8).hex()])
    if socket_asked:
        path = "/socket"
        lines += ["Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13"]
        lines.append(f"Sec-WebSocket-Key: {'AAAAAAAAAAAAAAAAAAAAAA=='}")
    else:
        lines.append("Connection: close")
    draw.shuffle(lines)
    head = f"{method} {path} HTTP/1.1\r\n" + "".join(f"{line}\r\n" for line in lines) + "\r\n"
    data = head.encode("latin-1") + body
    if "bytes" in wrong:
        # What is left of it may be right; so it is without the cookie.
        data = mutated_bytes(draw, data.replace(cookie.encode(), b"none"))
    return data


def _answer(served: Served, data: bytes) -> bytes:
    """Send bytes, and nothing more; return all that comes."""
    name, _, port = served.host.rpartition(":")
    with socket.create_connection((name, int(port)), timeout=30) as connection:
        try:
            connection.sendall(data)
            connection.shutdown(socket.SHUT_WR)
            answer = b""
            while piece := connection.recv(1 << 16):
                answer += piece
        except (ConnectionResetError, BrokenPipeError):
            # It was refused before it was read.
            return b""
    return answer


def trial(draw: random.Random) -> str:
    """Serve a clip, send requests, and see that it goes on."""
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        place = Path(name).resolve()
        folder, page = place / "clips", place / "page"
        (page / "assets").mkdir(parents=True)
        folder.mkdir()
        (page / "index.html").write_text("<!doctype html><title>retime</title>")
        (page / "assets" / "index.js").write_text("export {};")
        (page / "way_out").symlink_to(place)
        (place / "secret.txt").write_bytes(_SECRET)
        write(wandering_motion(20), folder / "walk.bvh")
        with serving(folder, "walk.bvh", page=page) as served:
            cookie = served.cookie
            for _ in range(N_REQUESTS):
                data = _request(draw, served, cookie)
                answer = _answer(served, data)
                assert _SECRET not in answer, data
                assert cookie.partition("=")[2].encode() not in answer, data
                # Nothing at all is said to what is no request.
                status = answer[9:12]
                assert not answer or (answer.startswith(b"HTTP/1.1 4") and status.isdigit()), (data, answer[:200])
            assert served.ask("/health").body == b"ok"
        assert [path.name for path in folder.iterdir()] == ["walk.bvh"]
    return f"{N_REQUESTS} are refused"


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(command(trial, __doc__, most_seconds=MOST_SECONDS))
