"""What a stranger may not do, over real HTTP and WebSocket."""

from __future__ import annotations

import asyncio
import socket
import struct
from collections.abc import Iterator
from urllib.parse import quote

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from retime.server import guard as guards
from retime.server.app import listen
from retime.server.guard import HEADERS
from tests.server.serving import Served, make_clips, serving


@pytest.fixture(scope="module")
def served(tmp_path_factory) -> Iterator[Served]:
    """Serve a page; these tests leave it as it is."""
    place = tmp_path_factory.mktemp("guard")
    page = place / "page"
    (page / "assets").mkdir(parents=True)
    (page / "index.html").write_text("<!doctype html><title>retime</title>")
    (page / "assets" / "index.js").write_text("export {};")
    (place / "secret.txt").write_text("secret")
    (page / "way_out").symlink_to(place)
    folder = make_clips(place / "clips")
    (folder / "way_out").symlink_to(place)
    with serving(folder, "jump.bvh", page=page) as found:
        yield found


def test_the_page_is_served_to_who_has_the_cookie(served) -> None:
    answer = served.ask("/")
    assert (answer.status, b"<title>retime" in answer.body) == (200, True)
    assert served.ask("/assets/index.js").headers["content-type"].startswith("text/javascript")


def test_the_token_is_exchanged_for_a_cookie_and_taken_out_of_the_address(served) -> None:
    answer = served.ask(f"/?token={served.server.guard.token}", Cookie=None)
    assert (answer.status, answer.headers["location"]) == (303, "/")
    name, _, rest = answer.headers["set-cookie"].partition("=")
    value, *attributes = rest.split("; ")
    assert name == f"retime-{served.host.rpartition(':')[2]}"
    assert served.server.guard.token not in value
    assert {attribute.lower() for attribute in attributes} == {"httponly", "path=/", "samesite=strict"}


@pytest.mark.parametrize(
    "query", ["token=", "token=wrong", "token=%00", "token=a&token=b", "x=1&token=wrong", "token=%ff%fe"]
)
def test_a_wrong_token_opens_nothing(served, query) -> None:
    answer = served.ask(f"/?{query}", Cookie=None)
    assert (answer.status, answer.headers.get("set-cookie")) == (403, None)


def test_a_token_in_a_cookie_and_a_cookie_in_a_token_open_nothing(served) -> None:
    name, _, secret = served.cookie.partition("=")
    assert served.ask("/", Cookie=f"{name}={served.server.guard.token}").status == 403
    assert served.ask(f"/?token={secret}", Cookie=None).status == 403


@pytest.mark.parametrize("path", ["/", "/assets/index.js", "/health", "/nothing"])
@pytest.mark.parametrize("cookie", [None, "retime-1=x", "{name}=wrong", "{name}=", "=;=;;"])
def test_nothing_is_served_without_the_cookie(served, path, cookie) -> None:
    name = served.cookie.partition("=")[0]
    assert served.ask(path, Cookie=cookie and cookie.format(name=name)).status == 403


HOSTS = ["evil.example", "evil.example:{port}", "127.0.0.1", "127.0.0.1:1", "127.0.0.1.evil.example:{port}", "", None]


@pytest.mark.parametrize("host", HOSTS)
def test_another_host_is_refused(served, host) -> None:
    # A name under a stranger's control may point to the loopback address: the browser then says that name.
    port = served.host.rpartition(":")[2]
    answer = served.ask("/", Host=host if host is None else host.format(port=port))
    assert answer.status in ((421,) if host else (400, 421))


def test_two_hosts_are_refused(served) -> None:
    assert served.ask("/", Host=[served.host, "evil.example"]).status in (400, 421)


def test_localhost_is_this_host_too(served) -> None:
    assert served.ask("/", Host=served.host.replace("127.0.0.1", "localhost")).status == 200


ORIGINS = [
    "http://evil.example",
    "http://evil.example:{port}",
    "http://127.0.0.1",
    "http://127.0.0.1:1",
    "https://127.0.0.1:{port}",
    "http://localhost:{port}",
    "http://127.0.0.1:{port}.evil.example",
    "null",
]


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("method", ["GET", "POST"])
def test_another_origin_is_refused_over_http(served, origin, method) -> None:
    port = served.host.rpartition(":")[2]
    given = origin.format(port=port)
    path = "/" if method == "GET" else "/drop?name=a.bvh"
    assert served.ask(path, method=method, body=b"", Origin=given).status == 403


def test_a_post_that_does_not_say_where_it_comes_from_is_refused(served) -> None:
    assert served.ask("/drop?name=a.bvh", method="POST", body=b"x").status == 403


@pytest.mark.parametrize("origin", [*ORIGINS, None])
def test_another_origin_is_refused_over_websocket(served, origin) -> None:
    port = served.host.rpartition(":")[2]
    with pytest.raises(InvalidStatus) as refused, served.socket(origin=origin and origin.format(port=port)):
        pass
    assert refused.value.response.status_code == 403


def test_another_host_is_refused_over_websocket(served) -> None:
    port = served.host.rpartition(":")[2]
    with (
        socket.create_connection(("127.0.0.1", int(port))) as raw,
        pytest.raises(InvalidStatus) as refused,
        _connect(raw, f"ws://evil.example:{port}/socket", served),
    ):
        pass
    assert refused.value.response.status_code == 403


def _connect(raw, address, served):
    return connect(address, sock=raw, origin=f"http://{served.host}", additional_headers={"Cookie": served.cookie})


@pytest.mark.parametrize("cookie", [{}, {"Cookie": "retime-1=x"}])
def test_a_websocket_without_the_cookie_is_refused(served, cookie) -> None:
    with pytest.raises(InvalidStatus) as refused, served.socket(additional_headers=cookie):
        pass
    assert refused.value.response.status_code == 403


def test_a_message_that_is_too_large_ends_the_connection(served) -> None:
    with served.page() as page:
        # A frame of text that says it has 5 MiB; its mask follows, and nothing else.
        page.socket.socket.sendall(b"\x81\xff" + struct.pack(">Q", 5 << 20) + bytes(4))
        with pytest.raises(ConnectionClosed) as closed:
            page.until("listing", "notice")
        assert closed.value.rcvd.code == 1009


def test_a_body_that_says_it_is_too_large_is_refused_unread(served, monkeypatch) -> None:
    monkeypatch.setattr(guards, "MAX_BODY", 1000)
    answer = served.ask("/drop?name=a.bvh", method="POST", Content_Length="1001", Origin=f"http://{served.host}")
    assert answer.status == 413


@pytest.mark.parametrize("length", ["-1", "1e3", "\xb2", "9" * 20])
def test_a_length_that_is_no_number_is_refused(served, length) -> None:
    answer = served.ask("/drop?name=a.bvh", method="POST", Content_Length=length, Origin=f"http://{served.host}")
    assert answer.status in (400, 413)


def test_a_body_that_does_not_end_is_refused(served, monkeypatch) -> None:
    monkeypatch.setattr(guards, "MAX_BODY", 1000)
    answer = served.ask(
        "/drop?name=a.bvh",
        method="POST",
        body=(b"x" * 100 for _ in range(50)),
        chunked=True,
        Transfer_Encoding="chunked",
        Origin=f"http://{served.host}",
    )
    assert answer.status == 413


def test_a_long_address_is_refused(served) -> None:
    assert served.ask("/" + "x" * 5000).status == 414


@pytest.mark.parametrize(
    "path",
    [
        "/../secret.txt",
        "/%2e%2e/secret.txt",
        "/..%2fsecret.txt",
        "/assets/../../secret.txt",
        "/way_out/secret.txt",
        "//etc/passwd",
        "/assets/%00",
        "/assets",
    ],
)
def test_nothing_outside_the_pages_folder_is_served(served, path) -> None:
    answer = served.ask(path)
    assert answer.status == 404
    assert b"secret" not in answer.body


@pytest.mark.parametrize(
    ("path", "options"),
    [("/", {}), ("/", {"Cookie": None}), ("/", {"Host": "evil.example"}), ("/nothing", {}), ("/assets/index.js", {})],
)
def test_every_answer_says_what_the_browser_may_do_with_it(served, path, options) -> None:
    answer = served.ask(path, **options)
    for name, value in HEADERS.items():
        assert answer.headers[name.lower()] == value
    policy = dict(rule.split(" ", 1) for rule in HEADERS["Content-Security-Policy"].split("; "))
    # Nothing of any other host; no script but the page's own files, none written into it, none made of text.
    assert policy["default-src"] == "'none'"
    assert policy["script-src"] == policy["connect-src"] == "'self'"
    assert policy["frame-ancestors"] == policy["base-uri"] == "'none'"
    assert not any("unsafe" in sources or "http" in sources or "*" in sources for sources in policy.values())


@pytest.mark.parametrize("method", ["PUT", "DELETE", "PATCH", "OPTIONS"])
def test_other_methods_do_nothing(served, method) -> None:
    assert served.ask("/", method=method, Origin=f"http://{served.host}").status == 405


def test_it_listens_on_the_loopback_address_alone(served) -> None:
    (listener,) = served.server.servers[0].sockets
    assert listener.getsockname()[0] == "127.0.0.1"


def test_small_answers_are_not_held_back() -> None:
    # With Nagle's algorithm on, a curve waits up to 40 ms for the browser's delayed acknowledgement of the one before.
    async def accepted_without_delay() -> int:
        found: asyncio.Future[int] = asyncio.get_running_loop().create_future()

        async def answer(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
            found.set_result(writer.get_extra_info("socket").getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
            writer.close()

        with listen(0) as listener:
            async with await asyncio.start_server(answer, sock=listener):
                _, writer = await asyncio.open_connection(*listener.getsockname())
                answered = await asyncio.wait_for(found, 10)
                writer.close()
                return answered

    assert asyncio.run(accepted_without_delay()) != 0


@pytest.mark.parametrize(
    "name",
    ["", "../a.bvh", "a/b.bvh", "..", ".a.bvh", "a\\b.bvh", "a\x00.bvh", "-rf.bvh", "a\u202e.bvh", "x" * 300 + ".bvh"],
)
def test_a_dropped_file_needs_a_plain_name(served, name) -> None:
    answer = served.ask(f"/drop?name={quote(name)}", method="POST", body=b"x", Origin=f"http://{served.host}")
    assert answer.status == 400


@pytest.mark.parametrize("name", ["a.py", "a.exe", "a.bvh.html"])
def test_a_dropped_file_of_no_known_kind_is_refused(served, name) -> None:
    answer = served.ask(f"/drop?name={name}", method="POST", body=b"x", Origin=f"http://{served.host}")
    assert answer.status == 415


OUTSIDE = ["/etc/hostname.bvh", "../secret.bvh", "~/x.bvh", "way_out/x.bvh", "x\x00.bvh"]


@pytest.mark.parametrize("path", OUTSIDE)
def test_files_outside_the_folders_are_neither_opened_nor_written(served, path) -> None:
    with served.page() as page:
        page.revision, page.document = page.until("state")["revision"], {}
        for ask in (
            lambda: page.say("open", path=path),
            lambda: page.say("browse", folder=path, holds="clip"),
            lambda: page.say("export", what="motion", path=path, clip=0, overwrite=True),
            lambda: page.say("save", path=path.replace(".bvh", ".retime"), overwrite=True),
        ):
            ask()
            answer = page.until("notice", "refused", "listing", "exported", "saved")
            assert answer["type"] in ("notice", "refused")
            said = answer.get("text") or answer["reason"]
            assert "outside the folders" in said or "no path" in said
        for writing in (False, True):
            page.say("find", path=path, writing=writing)
            found = page.until("found")
            assert found["place"] == ""
            assert "outside the folders" in found["refused"] or "no path" in found["refused"]
        page.edit(clips=[{"path": path}])
        problem = page.until("problem")
        assert "outside the folders" in problem["message"] or "no path" in problem["message"]
