"""The words that the readers of a format know: they are no names, and stay in a file without names.

They are taken from the readers' own code, so that a word that a reader learns is known here too.
"""

from __future__ import annotations

import functools
import importlib.util
import pkgutil
import re
from collections.abc import Iterator
from types import CodeType

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
        spec = importlib.util.find_spec(name)
        if spec is None or spec.loader is None:
            raise ValueError(f"there is no module {name}")
        inner = (
            [one.name for one in pkgutil.iter_modules(spec.submodule_search_locations, f"{name}.")]
            if (spec.submodule_search_locations)
            else []
        )
        code = spec.loader.get_code(name)  # type: ignore[attr-defined]
        for text in _texts(code):
            if len(text) <= _MOST_LETTERS and len(text.split()) <= _MOST_WORDS:
                found |= {word.lower() for word in _WORD.findall(text)}
        for one in inner:
            found |= words_of_modules(one)
    return frozenset(found)


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
