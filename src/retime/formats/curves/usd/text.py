"""Change the time samples in the text of a USD layer, and names of files, and leave every other byte as it was.

USD itself writes a layer in its own way: comments go, and numbers and lines are laid out anew. So what it would write
is taken for the samples alone, and put where the old ones stood. That this says the same is then checked by USD, which
reads both; where it doesn't, what USD writes is taken as a whole.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from pxr import Sdf, Tf

_TOKENS = re.compile(
    r'"""(?:\\.|[^\\])*?"""'
    r"|'''(?:\\.|[^\\])*?'''"
    r'|"(?:\\.|[^"\\\n])*"'
    r"|'(?:\\.|[^'\\\n])*'"
    r"|@@@.*?@@@|@[^@\n]*@"
    r"|<[^<>\n]*>"
    r"|\#[^\n]*|//[^\n]*|/\*.*?\*/"
    r"|(?P<time>(?<![\w:])timecode(?:\[\])?\s+[\w:]+)\s*=\s*(?P<value>\[[^\]]*\]|[-+.\w]+)"
    r"|(?P<samples>[\w:]+\.(?:timeSamples|spline))\s*=\s*(?=\{)"
    r"|(?P<code>(?<![\w:])(?:startTimeCode|endTimeCode)\s*=\s*)(?P<number>[-+.\w]+)"
    r"|[{}()]",
    re.DOTALL,
)
# The scanning is Python: in larger files comments are not worth the wait.
_MOST_LETTERS = 64 << 20

Place = tuple[str, ...]


def spliced_samples(source: bytes, before: str, layer: Any, assets: Mapping[str, str]) -> bytes:
    """Put the samples that USD wrote into the text that they were read from.

    Parameters
    ----------
    source : bytes
        The layer as it was.
    before : str
        The same as USD writes it.
    layer : Sdf.Layer
        The changed layer.
    assets : mapping of str to str
        Names of files that are others in it.

    Returns
    -------
    bytes
        The source with other samples, start and end; what USD writes, where that would say anything else than `layer`.
    """
    new: str = layer.ExportToString()
    written = new.encode("utf-8", "surrogateescape")
    if len(source) > _MOST_LETTERS:
        return written
    try:
        old = source.decode("utf-8")
    except UnicodeDecodeError:
        return written
    (old_spans, names), (before_spans, _), (new_spans, _) = _spans(old), _spans(before), _spans(new)
    if old_spans is None or before_spans is None or new_spans is None:
        return written
    if not old_spans.keys() == before_spans.keys() == new_spans.keys():
        return written
    changes = [
        (*old_spans[key], _laid(old, old_spans[key][0], new[first:last]))
        for key, (first, last) in new_spans.items()
        if new[first:last] != before[slice(*before_spans[key])]
    ]
    for first, last in names:
        mark = "@@@" if old.startswith("@@@", first) else "@"
        asset = old[first:last].removeprefix(mark).removesuffix(mark)
        if asset in assets:
            changes.append((first, last, f"{mark}{assets[asset]}{mark}"))
    parts, place = [], 0
    for first, last, text in sorted(changes):
        parts += [old[place:first], text]
        place = last
    text = "".join([*parts, old[place:]])
    check = Sdf.Layer.CreateAnonymous(".usda")
    try:
        if not check.ImportFromString(text) or check.ExportToString() != new:
            return written
    except Tf.ErrorException:
        return written
    return text.encode("utf-8")


Spans = dict[Place, tuple[int, int]]


def _spans(text: str) -> tuple[Spans | None, list[tuple[int, int]]]:
    """Find what may change: samples, with their braces, values that are times, start and end; and names of files.

    None for the first, where two have one place or brackets don't pair.
    """
    found: Spans = {}
    names: list[tuple[int, int]] = []
    # What each open brace belongs to: the last string before it, which names a prim, a variant set or a variant.
    inside: list[str] = []
    label, parens = "", 0
    begun: tuple[Place, int, int] | None = None
    waiting: Place | None = None
    for token in _TOKENS.finditer(text):
        word = token[0]
        if begun is not None:
            # Within samples only braces count.
            key, start, depth = begun
            depth += (word == "{") - (word == "}")
            begun = (key, start, depth)
            if not depth:
                if key in found:
                    return None, names
                found[key] = (start, token.end())
                begun = None
        elif word[0] == "@":
            names.append(token.span())
        elif token["time"]:
            key = (*inside, " ".join(token["time"].split()))
            if key in found:
                return None, names
            found[key] = token.span("value")
        elif token["samples"]:
            waiting = (*inside, token["samples"])
        elif token["code"]:
            if not inside and parens == 1:
                found[token["code"].partition("=")[0].strip(),] = token.span("number")
        elif word == "{":
            if waiting is not None:
                begun, waiting = (waiting, token.start(), 1), None
            else:
                inside.append(label)
                label = ""
        elif word == "}":
            if not inside:
                return None, names
            inside.pop()
        elif word == "(":
            parens += 1
        elif word == ")":
            parens -= 1
        elif word[0] == '"' and not parens:
            label = word
    return (found if begun is None and not inside else None), names


def _laid(text: str, start: int, new: str) -> str:
    """Indent samples as the line is that they stand in."""
    lines = new.split("\n")
    line = text[text.rfind("\n", 0, start) + 1 : start]
    margin = line[: len(line) - len(line.lstrip())]
    usual = lines[-1][: len(lines[-1]) - len(lines[-1].lstrip())]
    return "\n".join([lines[0], *(margin + one.removeprefix(usual) for one in lines[1:])])
