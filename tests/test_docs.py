"""The documents name files and modules that are there, and write times, keytimes and locks as they are read."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

from retime import Limits
from retime.motion.grammar import check_length, parse_speeds, read_key, read_lock, read_span

ROOT = Path(__file__).resolve().parents[1]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
# Versions before named files that are gone since.
CURRENT = [path for path in DOCUMENTS if path.name != "CHANGELOG.md"]
# A file of the source, or a folder of it; a path with letters that stand for others is an example.
FILE = re.compile(r"`((?:[\w.-]+/)+(?:[\w.-]+\.(?:py|hpp|cpp|ts|md|json|toml))?)`")
NAME = re.compile(r"`(retime(?:\.\w+)+)(?:\(\))?`")
# What is written for an option: on a command line, where it has digits (capitals are placeholders), and in Python.
TYPED = re.compile(r"--(lock|keep|flight|no-flight|key|length|speed) (?=[\w./]*\d)([^\s`|,;)]+)")
LOCKS = re.compile(r"locks=\[((?:\"[^\"]*\"(?:, )?)+)\]")
READERS = {
    "lock": read_lock,
    "keep": read_span,
    "flight": read_span,
    "no-flight": read_span,
    "key": read_key,
    "length": check_length,
    "speed": parse_speeds,
}


def found(name: str) -> bool:
    """Whether a dotted name is a module, or something in one."""
    parts = name.split(".")
    for n in range(len(parts), 0, -1):
        try:
            value = importlib.import_module(".".join(parts[:n]))
        except ModuleNotFoundError:
            continue
        for attribute in parts[n:]:
            if not hasattr(value, attribute):
                return False
            value = getattr(value, attribute)
        return True
    return False


@pytest.mark.parametrize("document", CURRENT, ids=lambda path: path.name)
def test_files_that_a_document_names_are_there(document: Path) -> None:
    named = set(FILE.findall(document.read_text(encoding="utf-8")))
    # Most are written as one sees them from the package, or from the folder of the page or the study.
    bases = [ROOT, ROOT / "src" / "retime", ROOT / "src", ROOT / "web", ROOT / "study", document.parent]
    assert sorted(name for name in named if not any((base / name).exists() for base in bases)) == []


@pytest.mark.parametrize("document", CURRENT, ids=lambda path: path.name)
def test_names_of_the_package_that_a_document_has_are_there(document: Path) -> None:
    named = set(NAME.findall(document.read_text(encoding="utf-8")))
    assert sorted(name for name in named if not found(name)) == []


def test_what_documents_give_to_options_is_what_options_read() -> None:
    read = set()
    for document in CURRENT:
        text = document.read_text(encoding="utf-8")
        typed = TYPED.findall(text)
        typed += [("lock", lock) for locks in LOCKS.findall(text) for lock in re.findall(r"\"([^\"]*)\"", locks)]
        for option, value in typed:
            READERS[option](value)
            read.add(option)
    assert read == set(READERS)


def test_the_page_of_what_is_promised_has_every_limit_as_it_is() -> None:
    units = {"": 1, "million": 10**6, "KiB": 1 << 10, "MiB": 1 << 20, "GiB": 1 << 30}
    page = (
        (ROOT / "docs" / "reliability.md").read_text(encoding="utf-8").partition("## Limits")[2].partition("\n## ")[0]
    )
    rows = re.findall(r"^\| `(\w+)` \| ([\d,]+) ?(\w*) \|", page, flags=re.MULTILINE)
    told = {name: int(number.replace(",", "")) * units[unit] for name, number, unit in rows}
    # A million is told in round numbers.
    assert told == {name: pytest.approx(value, rel=0.005) for name, value in vars(Limits()).items()}
