"""A page comes back to a later run of its editor, and to nobody else."""

from __future__ import annotations

import hashlib
import hmac
import json

from retime.server.returning import Returning
from tests.server.serving import serving

KEY = "k" * 43
WORD = "w" * 32


def proof(key: str, who: str, host: str, word: str) -> str:
    return hmac.new(key.encode(), f"{who} {host} {word}".encode(), hashlib.sha256).hexdigest()


def test_both_sides_prove_that_they_hold_the_key() -> None:
    returning, host = Returning(KEY), "127.0.0.1:4711"
    greeting = returning.greet(host, WORD)
    assert greeting is not None
    assert greeting["proof"] == proof(KEY, "server", host, WORD)
    own = proof(KEY, "page", host, greeting["word"])
    # Got at another address, or by the server's own proof, it is worth nothing; and each word is good once.
    for wrong in (
        proof(KEY, "page", "127.0.0.1:4712", greeting["word"]),
        proof(KEY, "server", host, greeting["word"]),
        proof("x" * 43, "page", host, greeting["word"]),
        "é",
    ):
        again = returning.greet(host, WORD)
        assert again is not None
        assert not returning.admits(host, again["word"], wrong)
    assert returning.admits(host, greeting["word"], own)
    assert not returning.admits(host, greeting["word"], own)
    assert not returning.admits(host, "never given", proof(KEY, "page", host, "never given"))
    assert [returning.greet(host, word) for word in ("", "short", "w" * 999, "é" * 20)] == [None] * 4


def test_a_page_is_admitted_over_http(folder) -> None:
    with serving(folder, "jump.bvh") as served:
        with served.page() as page:
            page.until("curve")
        key = served.server.key
        ask = served.ask
        assert ask("/resume?word=short", Cookie=None).status == 400
        # From another site, or as a stranger, there is no proof of anything.
        assert ask(f"/resume?word={WORD}", Cookie=None, Sec_Fetch_Site="cross-site").status == 403
        assert ask(f"/resume?word={WORD}", Cookie=None, Origin="http://evil.example").status == 403
        assert ask(f"/resume?word={WORD}", Cookie=None, Host="evil.example").status == 421
        greeting = json.loads(ask(f"/resume?word={WORD}", Cookie=None).body)
        assert greeting["proof"] == proof(key, "server", served.host, WORD)
        origin = {"Cookie": None, "Origin": f"http://{served.host}"}
        word = greeting["word"]
        wrong = ask(f"/resume?word={word}&proof={proof('x', 'page', served.host, word)}", method="POST", **origin)
        assert (wrong.status, "set-cookie" in wrong.headers) == (403, False)
        # The word is used up: the right answer comes too late.
        right = proof(key, "page", served.host, word)
        assert ask(f"/resume?word={word}&proof={right}", method="POST", **origin).status == 403
        word = json.loads(ask(f"/resume?word={WORD}", Cookie=None).body)["word"]
        right = proof(key, "page", served.host, word)
        # Without the page's own origin not even that.
        assert ask(f"/resume?word={word}&proof={right}", method="POST", Cookie=None).status == 403
        admitted = ask(f"/resume?word={word}&proof={right}", method="POST", **origin)
        assert admitted.status == 204
        cookie = admitted.headers["set-cookie"].partition(";")[0]
        assert ask("/health", Cookie=cookie).body == b"ok"
