"""Maya: a curve from time to time (``animCurveTT``), which warps the whole scene, or the curves that are named.

``ktv`` holds pairs of output frame and input frame, in the unit of time that the file declares (``currentUnit -t``);
frames count from 1 by custom. Tangents are linear (``tan 2``). The scene's warp is the curve's output connected to
``time1.timewarpIn``, switched on by ``time1.enableTimewarp``; what is named by `Shot.item` is warped alone, by a script
that connects the curve to each animation curve's own input. A scene can't do that for curves of another scene.

Read are curves with linear, flat and fixed tangents, the last two drawn by lines to within the tolerance: handles are
a third of the tangent away from the key, in seconds, and without weights a tangent is a slope. What Maya computes
itself (spline, auto, clamped, plateau) is not in the file.

Source: Maya Tech Docs, nodes ``animCurve``, ``animCurveTT`` and ``time``
(https://help.autodesk.com/cloudhelp/2015/CHS/Maya-Tech-Docs/Nodes/animCurve.html,
https://help.autodesk.com/cloudhelp/ENU/MayaCRE-Tech-Docs/Nodes/time.html), commands ``currentUnit`` and ``setAttr``.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise

import numpy as np

from retime.errors import FormatError, OptionError, RetimeWarning
from retime.hosts.bezier import drawn
from retime.hosts.choosing import chosen
from retime.hosts.shot import MOST_KEYS, Shot, plain_rows, warp_of
from retime.hosts.text import Lines, decoded, number, quoted, script_numbers
from retime.limits import MOST_SECONDS
from retime.warp.curve import Warp

_UNITS = {
    "game": Fraction(15),
    "film": Fraction(24),
    "pal": Fraction(25),
    "ntsc": Fraction(30),
    "show": Fraction(48),
    "palf": Fraction(50),
    "ntscf": Fraction(60),
    "23.976fps": Fraction(24000, 1001),
    "29.97fps": Fraction(30000, 1001),
    "29.97df": Fraction(30000, 1001),
    "47.952fps": Fraction(48000, 1001),
    "59.94fps": Fraction(60000, 1001),
    "millisec": Fraction(1000),
    "sec": Fraction(1),
    "min": Fraction(1, 60),
    "hour": Fraction(1, 3600),
    **{
        f"{n}fps": Fraction(n)
        for n in (
            *(2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 40, 75, 80, 90, 100, 120, 125, 150, 200, 240, 250, 300, 375, 400, 500),
            *(600, 750, 1200, 1500, 2000, 3000, 6000, 44100, 48000),
        )
    },
}
_LINEAR, _FIXED, _FLAT, _STEPS, _UNSAID = 2, 1, 3, (5, 17), -1
_TYPES = {_UNSAID: "not said in the file", 6: "slow", 7: "fast", 9: "spline", 10: "clamped", 16: "plateau", 18: "auto"}
_ITEM = re.compile(r"[A-Za-z_:|][\w:|]*", re.ASCII)
_KEYS_A_LINE = 100
# Of a script of ours.
_UNIT, _CURVES = re.compile(r'^UNIT = "([^"]*)"$', re.MULTILINE), re.compile(r"^CURVES = \[(.*)\]$", re.MULTILINE)
# A comment, a text in quotes (or one that never ends), the end of a statement, a word.
_TOKEN = re.compile(r'//[^\n]*|"((?:[^"\\]|\\.)*)"|(")|(;)|([^\s";]+)', re.DOTALL)
_INDEXED = re.compile(r"\.(\w+)(?:\[(\d{1,7})(?::(\d{1,7}))?\])?")


def unit_of(rate: Fraction) -> str:
    """Name Maya's unit of time; raise OptionError, which lists them, where it has none of that rate."""
    for name, fits in _UNITS.items():
        if fits == rate:
            return name
    rates = ", ".join(f"{float(each):g}" for each in sorted(set(_UNITS.values())) if 1 < each < 1000)
    raise OptionError(f"Maya has no time unit of {float(rate):g} frames a second; it has {rates} (--rate)")


def write(warp: Warp, shot: Shot) -> str:
    """Write a scene to import, or a script for the curves that are named."""
    unit = unit_of(shot.exact_rate)
    at, use = plain_rows(shot.frames(warp.output_times)), plain_rows(shot.frames(warp.input_times))
    return _script(at, use, unit, shot.item) if shot.item else _scene(at, use, unit)


def _scene(at: list[str], use: list[str], unit: str) -> str:
    n = len(at)
    pairs = [f"{a} {b}" for a, b in zip(at, use, strict=True)]
    keys = []
    for first in range(0, n, _KEYS_A_LINE):
        last = min(first + _KEYS_A_LINE, n) - 1
        count = f"-s {n} " if first == 0 else ""
        keys.append(f'\tsetAttr {count}".ktv[{first}:{last}]" {" ".join(pairs[first : last + 1])};\n')
    return (
        "//Maya ASCII 2022 scene\n"
        'requires maya "2022";\n'
        f"currentUnit -l centimeter -a degree -t {unit};\n"
        'createNode animCurveTT -n "retimeWarp";\n'
        f'\tsetAttr ".tan" {_LINEAR};\n'
        '\tsetAttr ".wgt" no;\n'
        f"{''.join(keys)}"
        'connectAttr "retimeWarp.output" ":time1.timewarpIn";\n'
        'setAttr ":time1.enableTimewarp" yes;\n'
    )


def _script(at: list[str], use: list[str], unit: str, item: str) -> str:
    names = [name.strip() for name in item.split(",")]
    for name in names:
        if not _ITEM.fullmatch(name):
            raise OptionError(
                f"--item {name}: expected the name of an animation curve in Maya, such as hips_translateX or "
                "ns:hips_rotateY, with commas between several"
            )
    return (
        f"# Retimes animation curves of the open scene ({len(names)}), and nothing else. Run it in the Script Editor\n"
        "# (Python). To take it back, use Undo or delete the node.\n"
        "from maya import cmds, mel\n\n"
        f"UNIT = {quoted(unit)}\n"
        f"CURVES = [{', '.join(quoted(name) for name in names)}]\n"
        f"AT_FRAME = [{', '.join(at)}]\n"
        f"SHOWS_FRAME = [{', '.join(use)}]\n\n"
        "found = cmds.currentUnit(query=True, time=True)\n"
        "if found != UNIT:\n"
        '    raise RuntimeError("the scene counts %s, this curve %s" % (found, UNIT))\n'
        "missing = [name for name in CURVES if not cmds.ls(name, type='animCurve')]\n"
        "if missing:\n"
        '    raise RuntimeError("no animation curve is called " + ", ".join(missing))\n'
        "cmds.undoInfo(openChunk=True)\n"
        "try:\n"
        '    warp = cmds.createNode("animCurveTT", name="retimeWarp")\n'
        f'    cmds.setAttr(warp + ".tan", {_LINEAR})\n'
        '    cmds.setAttr(warp + ".wgt", False)\n'
        "    # Keys as a scene file has them: pairs of frames, in the unit above.\n"
        '    pairs = " ".join("%r %r" % pair for pair in zip(AT_FRAME, SHOWS_FRAME))\n'
        "    n = len(AT_FRAME)\n"
        """    mel.eval('setAttr -s %d "%s.ktv[0:%d]" %s' % (n, warp, n - 1, pairs))\n"""
        "    for name in CURVES:\n"
        '        cmds.connectAttr(warp + ".output", name + ".input", force=True)\n'
        "finally:\n"
        "    cmds.undoInfo(closeChunk=True)\n"
    )


@dataclass
class _Node:
    """A curve as the file has it.

    Attributes
    ----------
    line : int
        Where it begins.
    values : dict
        Of each attribute: index and number.
    lines : dict
        Of each index of ``ktv``: its line.
    """

    line: int
    values: dict[str, dict[int, float]] = field(default_factory=dict)
    lines: dict[int, int] = field(default_factory=dict)

    def at(self, attribute: str, key: int, otherwise: float) -> float:
        return self.values.get(attribute, {}).get(key, otherwise)


def read(data: bytes, shot: Shot) -> Warp:
    """Read the one curve from time to time of a scene, or that of the name `Shot.item`; or a script of ours."""
    text = decoded(data)
    if text.startswith("# Retimes"):
        return _of_script(text, shot)
    if not text.lstrip().startswith("//Maya ASCII"):
        raise FormatError(
            "expected a scene of Maya ASCII, which begins with //Maya ASCII; save the scene as .ma", line=1
        )
    nodes, unit = _nodes(text)
    node = chosen(nodes, shot.item, "curve from time to time (animCurveTT)", "a Maya scene")
    return _warp(node, replace(shot, rate=_rate_of(unit)))


def _of_script(text: str, shot: Shot) -> Warp:
    """Read a script that `write` made: one curve, whichever of those that it is for is named."""
    unit, names = _UNIT.search(text), _CURVES.search(text)
    if unit is None or names is None:
        raise FormatError("expected a script that retime wrote, with UNIT and CURVES")
    if shot.item:
        curves = dict.fromkeys(name.strip('" ') for name in names[1].split(","))
        chosen(curves, shot.item, "animation curve", "a script that retime wrote")
    shot = replace(shot, rate=_rate_of(unit[1]))
    at, use = script_numbers(text, "AT_FRAME"), script_numbers(text, "SHOWS_FRAME")
    if len(at) != len(use):
        raise FormatError(f"expected a frame for each of {len(at)}, found {len(use)}")
    return warp_of(shot.times(np.array(at)), shot.times(np.array(use)))


def _rate_of(unit: str) -> Fraction:
    """Return a time unit's frames a second; raise FormatError where Maya has none of the name."""
    if unit not in _UNITS:
        raise FormatError(
            f"expected one of Maya's time units (currentUnit -t), such as film or 30fps, found {unit[:40]!r}"
        )
    return _UNITS[unit]


def _nodes(text: str) -> tuple[dict[str, _Node], str]:
    """Find the curves from time to time, and the unit of time."""
    nodes: dict[str, _Node] = {}
    unit, node = "film", None
    for words, line in _statements(text):
        if words[0] == "currentUnit":
            unit = _after(words, "-t", "-time") or unit
        elif words[0] == "createNode":
            node = None
            if words[1:2] == ["animCurveTT"]:
                name = _after(words, "-n", "-name") or f"animCurveTT{len(nodes) + 1}"
                node = nodes[name] = _Node(line)
        elif words[0] in ("select", "connectAttr"):
            node = None
        elif words[0] == "setAttr" and node is not None:
            _set(node, words[1:], line)
    return nodes, unit


def _statements(text: str) -> Iterator[tuple[list[str], int]]:
    """Give the words of each statement, and its line."""
    places = Lines(text)
    words: list[str] = []
    start = 0
    for match in _TOKEN.finditer(text):
        quotes, endless, end, bare = match.groups()
        if endless:
            raise FormatError("a text in quotes does not end", line=places.at(match.start()))
        if end:
            if words:
                yield words, places.at(start)
            words = []
        elif quotes is not None or bare is not None:
            if not words:
                start = match.start()
            words.append(quotes if bare is None else bare)


def _after(words: list[str], *flags: str) -> str | None:
    """Return the word after a flag."""
    for flag, word in pairwise(words):
        if flag in flags:
            return word
    return None


def _set(node: _Node, words: list[str], line: int) -> None:
    """Keep what a setAttr sets."""
    place = next((i for i, word in enumerate(words) if _INDEXED.fullmatch(word)), None)
    if place is None:
        return
    match = _INDEXED.fullmatch(words[place])
    assert match is not None
    attribute, first = match[1], int(match[2] or 0)
    if attribute not in ("ktv", "kit", "kot", "kix", "kiy", "kox", "koy", "tan", "wgt", "pre", "pst"):
        return
    # A flag, such as -type, may stand between.
    values = [_value(word, line) for word in words[place + 1 :] if not re.match("-[a-z]", word)]
    kept = node.values.setdefault(attribute, {})
    size = 2 if attribute == "ktv" else 1
    if len(values) % size:
        raise FormatError(f"expected pairs of time and value, found {len(values)} numbers", line=line)
    n = int(match[3] or first) - first + 1
    if len(values) != size * n:
        # What is missing would be taken for the curve's usual tangent, or for no key.
        raise FormatError(
            f"{words[place]} is of {n} keys, found {len(values) // size}: is the file cut off?", line=line
        )
    if attribute == "ktv":
        for key, (time, value) in enumerate(zip(values[::2], values[1::2], strict=True), start=first):
            kept[key], node.values.setdefault("value", {})[key] = time, value
            node.lines[key] = line
    else:
        kept.update(enumerate(values, start=first))
    if len(kept) > MOST_KEYS:
        raise FormatError(f"more than {MOST_KEYS} keys", line=line)


def _value(word: str, line: int) -> float:
    """Read a number, or yes and no."""
    if word in ("yes", "on", "true"):
        return 1.0
    return 0.0 if word in ("no", "off", "false") else number(word, line)


def _warp(node: _Node, shot: Shot) -> Warp:
    """Make the warp, round spans drawn by lines."""
    keys = sorted(node.values.get("ktv", {}))
    if keys != list(range(len(keys))):
        raise FormatError("the curve's keys are not numbered one after the other", line=node.line)
    lines = [node.lines[key] for key in keys]
    times = shot.times(np.array([node.values["ktv"][key] for key in keys]))
    values = shot.times(np.array([node.values["value"][key] for key in keys])) if keys else times
    plain_curve = warp_of(times, values, place=lambda key: {"line": lines[key]}, begins={"line": node.line})
    if node.at("pre", 0, 0.0) or node.at("pst", 0, 0.0):
        warnings.warn(
            "the curve goes on beyond its keys (pre or post infinity), which a warp does not: it holds its ends",
            RetimeWarning,
            stacklevel=2,
        )
    weighted = bool(node.at("wgt", 0, 1.0))
    usual = node.at("tan", 0, _UNSAID)
    out_times, in_times, curved = [times[:1]], [values[:1]], False
    for key in range(len(times) - 1):
        width, rise = times[key + 1] - times[key], values[key + 1] - values[key]
        handles = [_handle(node, side, at, usual, width, rise, weighted) for side, at in (("o", key), ("i", key + 1))]
        if handles == [None, None]:
            out_times.append(times[key + 1 : key + 2])
            in_times.append(values[key + 1 : key + 2])
            continue
        (dx0, dy0), (dx1, dy1) = (handle or (width / 3, rise / 3) for handle in handles)
        x = np.array([times[key], times[key] + dx0, times[key + 1] - dx1, times[key + 1]])
        y = np.array([values[key], values[key] + dy0, values[key + 1] - dy1, values[key + 1]])
        xs, ys = drawn(x, y, shot.tolerance / 2, {"line": lines[key]})
        out_times.append(xs)
        in_times.append(ys)
        curved = True
    if not curved:
        return plain_curve
    return warp_of(np.concatenate(out_times), np.concatenate(in_times)).simplify(shot.tolerance / 2)


def _handle(
    node: _Node, side: str, key: int, usual: float, width: float, rise: float, weighted: bool
) -> tuple[float, float] | None:
    """Return how far a handle is from its key, seconds; None where it lies on the line to the next key."""
    kind = int(node.at(f"k{side}t", key, usual))
    line = node.lines[key]
    if kind == _LINEAR:
        return None
    if kind == _FLAT:
        return width / 3, 0.0
    if kind in _STEPS:
        raise FormatError(
            f"key {key} is stepped, and a warp can't jump: choose Tangents > Linear in the Graph Editor", line=line
        )
    x, y = node.at(f"k{side}x", key, 0.0), node.at(f"k{side}y", key, 0.0)
    known = key in node.values.get(f"k{side}x", {}) and key in node.values.get(f"k{side}y", {})
    if kind != _FIXED or not known or not (x > 0 or (weighted and x == 0 and y == 0)):
        what = _TYPES.get(kind, "fixed, but without its direction" if kind == _FIXED else f"of type {kind}")
        raise FormatError(
            f"the tangent of key {key} is {what}: only Maya knows where that curve runs. In the Graph Editor choose "
            "Tangents > Fixed, which writes it down, or Linear",
            line=line,
        )
    # Multiplied, as the quotient of a direction that is all but upright is no number.
    if not weighted and abs(width / 3 * y) > MOST_SECONDS * x:
        raise FormatError(
            f"the tangent of key {key} is all but upright, its handle ends beyond {MOST_SECONDS:g} s: make it flatter",
            line=line,
        )
    return (x / 3, y / 3) if weighted else (width / 3, width / 3 * y / x)
