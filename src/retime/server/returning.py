"""How a page finds its server again after that was started anew, without telling its secret to whoever took the port.

A page holds a key that it was told over its own connection. The next run of the same command knows that key from a
file that only its user can read (`retime.project.runs`), and listens on the same port where it is free. Neither ever
sends the key: the page asks with a word of its own, the server proves with it that it has the key, and gives a word of
its own, with which the page proves the same. All proofs name the address, so one that was got at another port is worth
nothing, and each word is good for one answer.
"""

from __future__ import annotations

import hashlib
import hmac
import secrets
from collections import deque

# Words that wait for their answer.
_MOST_WORDS = 64
# A page's own word: more than this is no word of the page's.
_MOST_LETTERS = 128


class Returning:
    """The server's side: words given, and proofs.

    Parameters
    ----------
    key : str
        Which pages of this run and of the one before hold.
    """

    def __init__(self, key: str) -> None:
        self.key = key
        self._words: deque[str] = deque(maxlen=_MOST_WORDS)

    def greet(self, host: str, word: str) -> dict[str, str] | None:
        """Answer a page's word with a proof, and with a word for the page to answer; None where it is no word."""
        if not 16 <= len(word) <= _MOST_LETTERS or not word.isascii():
            return None
        own = secrets.token_urlsafe(24)
        self._words.append(own)
        return {"proof": self._proof("server", host, word), "word": own}

    def admits(self, host: str, word: str, proof: str) -> bool:
        """Whether a page has proved that it holds the key; a word is good for one answer, right or wrong."""
        if word not in self._words:
            return False
        self._words.remove(word)
        return hmac.compare_digest(self._proof("page", host, word).encode(), proof.encode("utf-8", "replace"))

    def _proof(self, who: str, host: str, word: str) -> str:
        return hmac.new(self.key.encode(), f"{who} {host} {word}".encode(), hashlib.sha256).hexdigest()
