"""Joint maps in files: which joint of a reference is which of the input, where their names don't say it.

Either a JSON object, ``{"input joint": "reference joint", ...}``, or CSV with two columns, input joint and reference
joint, separated by a comma, a semicolon or a tab; a first row ``input,reference`` is a heading. Both are read strictly:
a map that is half understood would compare wrong joints and say nothing.
"""

from __future__ import annotations

import csv
import json
import re
from io import StringIO
from os import PathLike
from pathlib import Path

from retime.errors import FormatError
from retime.files import read_bytes
from retime.formats.file_signatures import foreign_kind
from retime.formats.number_text import show
from retime.formats.read_options import Limits
from retime.formats.text_lines import utf8_text

_LINE_END = re.compile(r"\r\n?|\n")
_SPACE = re.compile(r"[ \t\r\n]*")
# Possessive: a string as long as the file must not cost a way back for each of its characters.
_STRING = re.compile(r'"(?:[^"\\\x00-\x1f]++|\\(?:["\\/bfnrt]|u[0-9a-fA-F]{4}))*+"')
_HEADING = ["input", "reference"]


def read_joint_map(path: str | PathLike[str], *, limits: Limits | None = None) -> dict[str, str]:
    """Read a joint map.

    Parameters
    ----------
    path : path-like
        A file that ends in .json or .csv.
    limits : Limits, optional
        Sizes not to go past.

    Returns
    -------
    dict of str to str
        Input joint to reference joint, in the file's order.

    Raises
    ------
    FormatError
        Not such a file; an empty name, an input joint that stands there twice, or a reference joint that does.
    OSError
        The file can't be opened.
    """
    path = Path(path)
    limits = limits or Limits()
    suffix = path.suffix.lower()
    if suffix not in (".json", ".csv"):
        raise FormatError(f"a joint map ends in .json or .csv, found {suffix or 'nothing'!r}", path=path)
    data = read_bytes(path, limits.file_bytes)
    kind = foreign_kind(data)
    if kind is not None and not (suffix == ".json" and kind == "a JSON document"):
        raise FormatError(f"this is {kind}; expected a joint map ({suffix})", path=path)
    text = utf8_text(path, data)
    if not text.strip():
        raise FormatError("the file is empty; expected a joint map", path=path)
    found = _JointMap(path, limits)
    if suffix == ".json":
        _read_json(text, found)
    else:
        _read_csv(text, found)
    if not found.joints:
        raise FormatError("the map names no joint", path=path)
    return found.joints


class _JointMap:
    """A map as it grows."""

    def __init__(self, path: Path, limits: Limits) -> None:
        self.path, self.limits = path, limits
        self.joints: dict[str, str] = {}
        self._lines: dict[str, int] = {}
        self._reference_lines: dict[str, int] = {}

    def error(self, line: int, problem: str) -> FormatError:
        return FormatError(problem, path=self.path, line=line)

    def add(self, line: int, joint: str, reference: str) -> None:
        for name, whose, seen in ((joint, "input", self._lines), (reference, "reference", self._reference_lines)):
            if not name.strip():
                raise self.error(line, f"expected the name of a joint of the {whose}, found none")
            # A lone half of a surrogate pair is no text, and could not be written in any message.
            encoded = name.encode("utf-8", "surrogatepass")
            if len(encoded) > self.limits.name_bytes:
                raise self.error(
                    line, f"a name has {len(encoded)} bytes, the limit is {self.limits.name_bytes} (Limits.name_bytes)"
                )
            if encoded.decode("utf-8", "replace") != name:
                raise self.error(line, f"expected the name of a joint of the {whose}, found half a character in it")
            if name in seen:
                raise self.error(
                    line, f"the {whose} joint {show(encoded)} stands here a second time, after line {seen[name]}"
                )
            seen[name] = line
        if len(self.joints) >= self.limits.joints:
            raise self.error(line, f"more than {self.limits.joints} joints (Limits.joints)")
        self.joints[joint] = reference


def _read_json(text: str, found: _JointMap) -> None:
    """Read one flat object of strings; nothing nests, so there is no depth to bound."""
    at = 0
    counted, number = 0, 1

    def line() -> int:
        nonlocal counted, number
        number += len(_LINE_END.findall(text, counted, at))
        counted = at
        return number

    def skip_space() -> None:
        nonlocal at
        match = _SPACE.match(text, at)
        assert match is not None
        at = match.end()

    def fail(expected: str) -> FormatError:
        rest = text[at : at + 40].split("\n")[0].strip()
        return found.error(line(), f"expected {expected}, found {show(rest.encode()) if rest else 'the end of it'}")

    def take(character: str, expected: str) -> None:
        nonlocal at
        skip_space()
        if not text.startswith(character, at):
            raise fail(expected)
        at += len(character)

    def string(expected: str) -> str:
        nonlocal at
        skip_space()
        match = _STRING.match(text, at)
        if match is None:
            raise fail(expected)
        at = match.end()
        return str(json.loads(match[0]))

    take("{", 'a JSON object, {"input joint": "reference joint", ...}')
    skip_space()
    if text.startswith("}", at):
        at += 1
    else:
        more = True
        while more:
            joint = string('the name of an input joint, in quotes ("...")')
            here = line()
            take(":", "a colon after the input joint")
            found.add(here, joint, string('the name of a reference joint, in quotes ("...")'))
            skip_space()
            more = text.startswith(",", at)
            if more:
                at += 1
        take("}", "a comma, or } at the end of the object")
    skip_space()
    if at < len(text):
        raise fail("nothing after the object")


def _read_csv(text: str, found: _JointMap) -> None:
    """Read rows of two fields; blank ones are left out."""
    # One kind of line end, so that the reader counts lines as an editor does.
    text = _LINE_END.sub("\n", text)
    unquoted = re.sub('"[^"]*"', "", text)
    first = next((line for line in unquoted.split("\n") if line.strip()), "")
    delimiter = next((mark for mark in "\t;" if mark in first.strip()), ",")
    reader = csv.reader(StringIO(text, newline=""), delimiter=delimiter, strict=True, skipinitialspace=True)
    try:
        heading = True
        for row in reader:
            fields = [field.strip() for field in row]
            if not any(fields):
                continue
            if len(fields) != 2:
                raise found.error(
                    reader.line_num, f"expected two fields, input joint and reference joint, found {len(fields)}"
                )
            if not (heading and [field.lower() for field in fields] == _HEADING):
                found.add(reader.line_num, *fields)
            heading = False
    except csv.Error as error:
        raise found.error(reader.line_num, f"expected fields separated by {delimiter!r}: {error}") from None
