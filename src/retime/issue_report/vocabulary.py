"""The words that the readers of a format know: they are no names, and stay in a file without names.

They are taken from the readers' own code, so that a word that a reader learns is known here too.
"""

from __future__ import annotations

import errno
import functools
import importlib.util
import os
import pkgutil
import re
from collections.abc import Iterator
from types import CodeType

SPOKEN = re.compile(r"\w+")
"""A word of a message."""

_WORD = re.compile(rb"[A-Za-z][A-Za-z0-9_]*")
# What is longer is a sentence of a message or a docstring.
_MOST_WORDS, _MOST_LETTERS = 3, 40


@functools.cache
def words_of_modules(*names: str) -> frozenset[bytes]:
    """Collect the words in the texts of modules, in lower case; of a package, those of all of its modules.

    Examples
    --------
    >>> words = words_of_modules("retime.formats.bvh_hierarchy")
    >>> b"xrotation" in words, b"channels" in words, b"hips" in words
    (True, True, False)
    """
    found: set[bytes] = set()
    for name in names:
        for text in _texts_of(name):
            if len(text) <= _MOST_LETTERS and len(text.split()) <= _MOST_WORDS:
                found |= {word.lower() for word in _WORD.findall(text)}
    return frozenset(found)


@functools.cache
def words_of_messages(*names: str) -> frozenset[str]:
    """Collect the words of all texts of modules, whole sentences too, and of the system's errors, in lower case.

    Examples
    --------
    >>> words = words_of_messages("retime.formats.bvh_hierarchy")
    >>> "xrotation" in words, "allowed" in words, "directory" in words, "annabel" in words
    (True, True, True, False)
    """
    texts = [text.decode("utf-8", "replace") for name in names for text in _texts_of(name)]
    texts += [os.strerror(code) for code in errno.errorcode]
    return frozenset(word for text in texts for word in SPOKEN.findall(text.lower()))


def _texts_of(name: str) -> Iterator[bytes]:
    """Go through the texts of a module; of a package, through those of all of its modules."""
    spec = importlib.util.find_spec(name)
    if spec is None or spec.loader is None:
        raise ValueError(f"there is no module {name}")
    yield from _texts(spec.loader.get_code(name))  # type: ignore[attr-defined]
    for one in pkgutil.iter_modules(spec.submodule_search_locations or (), f"{name}."):
        yield from _texts_of(one.name)


def _texts(code: CodeType) -> Iterator[bytes]:
    waiting: list[object] = [code]
    while waiting:
        one = waiting.pop()
        if isinstance(one, CodeType):
            waiting += one.co_consts
        elif isinstance(one, tuple | frozenset):
            waiting += one
        elif isinstance(one, str):
            yield one.encode()
        elif isinstance(one, bytes):
            yield one
