"""The clip's own file in a host's document: its address, and what the clip is called."""

from __future__ import annotations

import re
from pathlib import PurePath, PureWindowsPath
from urllib.parse import quote, unquote, urlsplit

# A document may be written on another system than the one where the shot lives.
_OF_WINDOWS = re.compile(r"[A-Za-z]:[\\/]|\\\\")


def address(source: str) -> str:
    r"""Return the address of a file; what is one already stays as it is.

    Examples
    --------
    >>> address("/shots/a b.mov"), address("a b.mov"), address("https://farm/a%20b.mov")
    ('file:///shots/a%20b.mov', './a%20b.mov', 'https://farm/a%20b.mov')
    >>> address(r"C:\shots\a b.mov"), address(r"\\farm\shots\a.mov")
    ('file:///C:/shots/a%20b.mov', 'file://farm/shots/a.mov')
    """
    if "://" in source:
        return source
    path = _path(source)
    text = path.as_posix()
    if text.startswith("//"):
        return f"file:{quote(text)}"
    if path.drive:
        return f"file:///{path.drive}{quote(text.removeprefix(path.drive))}"
    return ("file://" if text.startswith("/") else "./") + quote(text)


def name_of(source: str) -> str:
    r"""Return what a clip is called: its file's name without the ending.

    Examples
    --------
    >>> name_of("/shots/a b.mov"), name_of(r"C:\shots\a b.mov"), name_of("https://farm/a%20b.mov")
    ('a b', 'a b', 'a b')
    """
    if "://" in source:
        return PurePath(unquote(urlsplit(source).path)).stem or source
    return _path(source).stem or source


def file_name_of(source: str) -> str:
    r"""Return a file's name with its ending.

    Examples
    --------
    >>> file_name_of(r"C:\shots\a b.mov")
    'a b.mov'
    """
    if "://" in source:
        return PurePath(unquote(urlsplit(source).path)).name or source
    return _path(source).name or source


def _path(source: str) -> PurePath:
    return PureWindowsPath(source) if _OF_WINDOWS.match(source) else PurePath(source)
