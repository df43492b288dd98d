"""Nuke: a TimeWarp node, whose ``lookup`` says which input frame each frame shows.

``{{curve L x1 1 x2 1.5}}`` has ``x`` and the frame of the output, then the frame of the input; the letter before a key
is its interpolation, L linear, which holds on for the keys after it. Frames count from 1 by custom, and Nuke's script
has no rate: the project's counts. A key is written for every frame, so that no interpolation is left to chance. A value
without ``x`` stands as far behind the key before it as that one behind its own.

Read are keys with lines between them, and others no more than a frame apart, where the frames themselves are keys.

Source: Foundry, NDK Developers Guide, "Curve serialisation format"
(https://learn.foundry.com/nuke/developers/13.1/ndkdevguide/advanced/curveformat.html).
"""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np

from retime.errors import FormatError, OptionError
from retime.hosts.choosing import chosen
from retime.hosts.shot import MOST_KEYS, Shot, plain, warp_of
from retime.hosts.text import Lines, decoded, number
from retime.warp.curve import Warp

_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_NODE = re.compile(r"^[ \t]*TimeWarp[ \t]*\{", re.MULTILINE)
_CURVE = re.compile(r"^[ \t]*lookup[ \t]+\{\{[ \t]*curve\b([^{}]*)\}", re.MULTILINE)
_OWN_NAME = re.compile(r"^[ \t]*name[ \t]+(\S+)", re.MULTILINE)
_TOKEN = re.compile(r"\S+")
# Lines are drawn after these; what other letters mean, only Nuke draws.
_LINEAR = "L"
_EXTRAPOLATIONS, _HANDLES = {"k", "l", "i", "I"}, {"s", "t", "u", "v"}


def write(warp: Warp, shot: Shot) -> str:
    """Write the node, to be pasted into the node graph or imported as a script."""
    name = shot.item or "RetimeWarp1"
    if not _NAME.fullmatch(name):
        raise OptionError(f"--item {name}: a node's name in Nuke has letters, digits and _ only")
    at = np.rint(shot.frames(warp.output_times)).astype(np.int64).tolist()
    keys = " ".join(
        f"x{frame} {plain(value)}" for frame, value in zip(at, shot.frames(warp.input_times).tolist(), strict=True)
    )
    return f"TimeWarp {{\n lookup {{{{curve L {keys}}}}}\n filter none\n name {name}\n}}\n"


def read(data: bytes, shot: Shot) -> Warp:
    """Read the one TimeWarp of a script, or that of the name `Shot.item`."""
    text = decoded(data)
    found = {}
    starts = [match.start() for match in _NODE.finditer(text)]
    for count, (start, end) in enumerate(pairwise([*starts, len(text)]), start=1):
        if curve := _CURVE.search(text, start, end):
            own = _OWN_NAME.search(text, start, end)
            found[own[1] if own else f"TimeWarp {count}"] = curve
    match = chosen(found, shot.item, "TimeWarp with a curve as its lookup", "a Nuke script")
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
    for token in _TOKEN.finditer(match[1]):
        word, line = token[0], places.at(match.start(1) + token.start())
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
    for key in range(len(at) - 1):
        # The slope into a key is of the key's own interpolation.
        other = next((found for found in letters[key : key + 2] if found != _LINEAR), None)
        if other is not None and at[key + 1] - at[key] > 1:
            raise FormatError(
                f"from frame {at[key]:g} to {at[key + 1]:g} the curve is no line ({_LETTERS[other]}), and only "
                "Nuke draws it: choose Interpolation > Linear for its keys there, or generate a key for each frame",
                line=lines[key],
            )
    return warp_of(shot.times(np.array(at)), shot.times(np.array(use)), place=lambda key: {"line": lines[key]})


_LETTERS = {"K": "constant", "S": "smooth", "R": "Catmull-Rom", "C": "cubic", "cubic": "handles of its own"}
