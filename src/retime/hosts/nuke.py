"""Nuke: a TimeWarp node, whose ``lookup`` says which input frame each frame shows.

``{{curve L x1 1 x2 1.5}}`` has ``x`` and the frame of the output, then the frame of the input; the letter before a key
is its interpolation, L linear, which holds on for the keys after it. Frames count from 1 by custom, and Nuke's script
has no rate: the project's counts. A key is written for every frame, so that no interpolation is left to chance. A value
without ``x`` stands as far behind the key before it as that one behind its own. Where more than the word ``curve``
stands before the keys, as in ``{{curve+5 x1 1}}``, an expression is worked out of what they say: that is refused.

Read are keys with lines between them, and others no more than a frame apart, where the frames themselves are keys.

Source: Foundry, NDK Developers Guide, "Curve serialisation format"
(https://learn.foundry.com/nuke/developers/13.1/ndkdevguide/advanced/curveformat.html).
"""

from __future__ import annotations

import re
import warnings
from itertools import pairwise

import numpy as np

from retime.errors import FormatError, OptionError, RetimeWarning
from retime.hosts.choosing import chosen
from retime.hosts.shot import MOST_KEYS, Shot, plain, warp_of
from retime.hosts.text import Lines, decoded, number
from retime.warp.curve import Warp

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_NODE = re.compile(r"^[ \t]*TimeWarp[ \t]*\{", re.MULTILINE)
# Keys that nothing is worked out of, or whatever else stands there.
_LOOKUP = re.compile(
    r"^[ \t]*lookup[ \t]+\{\{[ \t]*(?:curve(?=[ \t}])(?P<keys>[^{}]*)\}|(?P<other>[^\n]*))", re.MULTILINE
)
_OWN_NAME = re.compile(r"^[ \t]*name[ \t]+(\S+)", re.MULTILINE)
_CLOSED = re.compile(r"^[ \t]*\}[ \t\r]*$", re.MULTILINE)
_OFF = re.compile(r"^[ \t]*disable[ \t]+true\b", re.MULTILINE)
_TOKEN = re.compile(r"\S+")
# Lines are drawn after these; what other letters mean, only Nuke draws.
_LINEAR = "L"
_EXTRAPOLATIONS, _HANDLES = {"k", "l", "i", "I"}, {"s", "t", "u", "v"}


def write(warp: Warp, shot: Shot) -> str:
    """Write the node, to be pasted into the node graph or imported as a script."""
    name = shot.item or "RetimeWarp1"
    if not _NAME.fullmatch(name):
        raise OptionError(
            f"--item {name}: a node's name in Nuke has the letters A to Z, digits and _ only, and begins with no digit"
        )
    at = np.rint(shot.frames(warp.output_times)).astype(np.int64).tolist()
    keys = " ".join(
        f"x{frame} {plain(value)}" for frame, value in zip(at, shot.frames(warp.input_times).tolist(), strict=True)
    )
    return f"TimeWarp {{\n lookup {{{{curve L {keys}}}}}\n filter none\n name {name}\n}}\n"


def read(data: bytes, shot: Shot) -> Warp:
    """Read the one TimeWarp of a script, or that of the name `Shot.item`."""
    text = decoded(data)
    found: dict[str, tuple[re.Match[str], bool]] = {}
    starts = [match.start() for match in _NODE.finditer(text)]
    for count, (start, later) in enumerate(pairwise([*starts, len(text)]), start=1):
        closed = _CLOSED.search(text, start, later)
        end = closed.start() if closed else later
        if curve := _LOOKUP.search(text, start, end):
            own = _OWN_NAME.search(text, start, end)
            found[own[1] if own else f"TimeWarp {count}"] = curve, _OFF.search(text, start, end) is not None
    match, off = chosen(found, shot.item, "TimeWarp with a curve as its lookup", "a Nuke script")
    if match["keys"] is None:
        raise FormatError(
            f"the node's lookup is an expression, {match['other'].strip().removesuffix('}}')[:40]!r}, which only Nuke "
            "works out: generate a key for each frame",
            line=Lines(text).at(match.start("other")),
        )
    if off:
        warnings.warn(
            "the node is disabled, so Nuke plays the shot as it is; its curve is read all the same",
            RetimeWarning,
            stacklevel=2,
        )
    return _curve(text, match, shot)


def _curve(text: str, match: re.Match[str], shot: Shot) -> Warp:
    """Read the keys of a curve."""
    places = Lines(text)
    at: list[float] = []
    use: list[float] = []
    lines: list[int] = []
    letters: list[str] = []
    # Nuke's own, where no letter was written.
    letter, frame = "S", None
    for token in _TOKEN.finditer(match["keys"]):
        word, line = token[0], places.at(match.start("keys") + token.start())
        if frame is not None and word[0] == "x":
            raise FormatError(f"the key at x{frame:g} has no value", line=line)
        if word in ("K", "L", "S", "R", "C"):
            letter = word
        elif word in _EXTRAPOLATIONS:
            continue
        elif word[0] == "x":
            frame = number(word[1:], line)
        elif word[0] in _HANDLES:
            number(word[1:], line)
            if letters:
                # Slopes of its own make a cubic of any letter.
                letters[-1] = "cubic"
        else:
            if frame is None:
                frame = 0.0 if not at else at[-1] + (at[-1] - at[-2] if len(at) > 1 else 1.0)
            if len(at) == MOST_KEYS:
                raise FormatError(f"more than {MOST_KEYS} keys", line=line)
            at.append(frame)
            use.append(number(word, line))
            lines.append(line)
            letters.append(letter)
            frame = None
    if frame is not None:
        raise FormatError(f"the key at x{frame:g} has no value", line=places.at(match.end("keys")))
    for key in range(len(at) - 1):
        # The slope into a key is of the key's own interpolation.
        other = next((found for found in letters[key : key + 2] if found != _LINEAR), None)
        if other is not None and at[key + 1] - at[key] > 1:
            raise FormatError(
                f"from frame {at[key]:g} to {at[key + 1]:g} the curve is no line ({_LETTERS[other]}), and only "
                "Nuke draws it: choose Interpolation > Linear for its keys there, or generate a key for each frame",
                line=lines[key],
            )
    return warp_of(
        shot.times(np.array(at)),
        shot.times(np.array(use)),
        place=lambda key: {"line": lines[key]},
        begins={"line": places.at(match.start("keys"))},
    )


_LETTERS = {"K": "constant", "S": "smooth", "R": "Catmull-Rom", "C": "cubic", "cubic": "handles of its own"}
