"""A recipe: what each clip of a library gets, by rules for patterns of names and by rows of a table."""

from __future__ import annotations

import csv
import tomllib
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from io import StringIO
from pathlib import Path, PurePosixPath
from typing import Any

from retime.batch.treatment import Treatment, settings
from retime.brief import brief_repr
from retime.errors import FormatError, OptionError, RetimeWarning
from retime.files import read_bytes
from retime.formats.number_text import count_of

# What separates several texts of one cell.
_SEVERAL = ";"


@dataclass(frozen=True)
class Rule:
    """Settings for the clips whose name fits a pattern.

    Attributes
    ----------
    match : str
        A pattern of names below the folder: ``*`` stands for any letters, slashes too, ``?`` for one.
    settings : mapping of str to object
        As `retime.batch.treatment.settings` returns them.
    skip : bool
        Leave these clips out.
    """

    match: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    skip: bool = False

    __repr__ = brief_repr


@dataclass(frozen=True)
class Recipe:
    """What each clip gets.

    Attributes
    ----------
    base : Treatment
        What holds for all.
    rules : tuple of Rule
        In their order, each over those before it.
    rows : mapping of str to mapping
        Settings of single clips by their names, over all rules; ``skip`` leaves one out.
    """

    base: Treatment = field(default_factory=Treatment)
    rules: tuple[Rule, ...] = ()
    rows: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    __repr__ = brief_repr

    def treatment_of(self, name: str) -> Treatment | None:
        """Return what a clip gets; None where it is to be left out.

        Parameters
        ----------
        name : str
            The clip's place below the folder, with ``/``.

        Raises
        ------
        OptionError
            What all that holds for it says contradicts itself.
        """
        given: dict[str, Any] = {}
        skip = False
        for rule in self.rules:
            if fnmatchcase(name, rule.match):
                skip = rule.skip
                given.update(rule.settings)
        if name in self.rows:
            row = dict(self.rows[name])
            skip = row.pop("skip", False)
            given.update(row)
        try:
            return None if skip else self.base.with_(given)
        except OptionError as error:
            raise OptionError(f"{name}: {error}") from None

    def refuse_unknown(self, names: Sequence[str]) -> None:
        """Raise OptionError where a row speaks of a clip that is not there; warn where a rule fits none.

        A row names one clip, and a name that is nowhere is a mistake. A rule says what clips of a kind get, and a
        folder may have none of that kind today.
        """
        known = set(names)
        missing = [name for name in self.rows if name not in known]
        if missing:
            some = ", ".join(missing[:5]) + (" ..." if len(missing) > 5 else "")
            raise OptionError(f"{len(missing)} clips of the recipe's table are not there: {some}")
        for rule in self.rules:
            if not any(fnmatchcase(name, rule.match) for name in names):
                warnings.warn(f"no clip fits the recipe's pattern {rule.match!r}", RetimeWarning, stacklevel=2)


def read_recipe(path: Path, base: Treatment) -> Recipe:
    """Read a recipe: TOML with rules, or a table with a row a clip.

    TOML says at its top what holds for all, in each ``[[rule]]`` what holds for names that ``match``, and in ``table``
    which CSV has rows for single clips. A CSV has a column ``clip`` and one for each setting, and may have one called
    ``skip``; an empty cell says nothing, and ``;`` parts several texts. Files are looked for from the recipe's folder.

    Parameters
    ----------
    path : Path
        The file (.toml, .csv).
    base : Treatment
        What holds where the recipe says nothing.

    Raises
    ------
    FormatError
        It is neither.
    OptionError
        A setting is unknown, or says nothing.
    """
    if path.suffix.lower() == ".csv":
        return Recipe(base, (), _rows(path))
    try:
        document = tomllib.loads(read_bytes(path).decode())
    except (ValueError, RecursionError) as error:
        # No TOML, no UTF-8, or a number of thousands of digits.
        raise FormatError(f"not a recipe (TOML): {error}", path=path) from None
    rules, table = document.pop("rule", []), document.pop("table", None)
    if not isinstance(rules, list) or not all(isinstance(rule, dict) for rule in rules):
        raise FormatError("rules are written as [[rule]], once for each", path=path)
    if table is not None and not isinstance(table, str):
        raise FormatError("table names a CSV", path=path)
    found = []
    for number, rule in enumerate(rules, start=1):
        match, skip = rule.pop("match", None), rule.pop("skip", False)
        if not isinstance(match, str) or not isinstance(skip, bool):
            raise FormatError(f'rule {number} needs match = "a pattern"; skip is true or false', path=path)
        found.append(Rule(match, _here(settings(rule, place=f"{path}: rule {number}"), path.parent), skip))
    whole = _here(settings(document, place=str(path)), path.parent)
    return Recipe(base.with_(whole), tuple(found), {} if table is None else _rows(path.parent / table))


def _rows(path: Path) -> dict[str, dict[str, Any]]:
    """Read a table of settings."""
    try:
        text = read_bytes(path).decode("utf-8-sig")
        # A spreadsheet of a country that writes 0,5 parts cells otherwise; the head says how.
        delimiter = max(",;\t", key=text.partition("\n")[0].count)
        rows = list(csv.reader(StringIO(text), delimiter=delimiter))
    except (csv.Error, UnicodeDecodeError) as error:
        raise FormatError(f"not a table: {error}", path=path) from None
    head = [name.strip().lower() for name in rows[0]] if rows else []
    if "clip" not in head:
        raise FormatError("expected a table with a column called clip", path=path, line=1)
    twice = next((name for name in head if name and head.count(name) > 1), None)
    if twice is not None:
        raise FormatError(f"two columns are called {twice}", path=path, line=1)
    column = head.index("clip")
    found: dict[str, dict[str, Any]] = {}
    for line, row in enumerate(rows[1:], start=2):
        if not any(row):
            continue
        if len(row) > len(head):
            raise FormatError(f"{len(row)} cells, the head has {len(head)}", path=path, line=line)
        clip = row[column].strip() if column < len(row) else ""
        if not clip:
            raise FormatError("the row names no clip", path=path, line=line)
        name = str(PurePosixPath(clip.replace("\\", "/")))
        if name in found:
            raise FormatError(f"{name} has two rows", path=path, line=line)
        given = {head[i]: _value(cell.strip()) for i, cell in enumerate(row) if i != column and cell.strip()}
        skip = given.pop("skip", False)
        if not isinstance(skip, bool):
            raise FormatError(f"skip is true or false, found {skip!r}", path=path, line=line)
        found[name] = _here(settings(given, place=f"{path}:{line}"), path.parent)
        if skip:
            found[name]["skip"] = True
    return found


def _value(cell: str) -> Any:
    if cell.lower() in ("true", "false"):
        return cell.lower() == "true"
    count = count_of(cell)
    if count is not None:
        return count
    return [text.strip() for text in cell.split(_SEVERAL)] if _SEVERAL in cell else cell


def _here(given: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Let files be looked for from a recipe's folder."""
    if "reference" in given:
        given["reference"] = tuple(str(folder / path) for path in given["reference"])
    if "skeleton" in given:
        given["skeleton"] = str(folder / given["skeleton"])
    return given
