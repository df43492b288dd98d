"""Print what CHANGELOG.md says of a version: ``python tools/release_notes.py v1.0.0``.

Ends with an error where the tag is not the version that pyproject.toml has, or the changelog says nothing of it.
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def notes_of(tag: str, changelog: str, version: str) -> str:
    """Return the notes of a tag; raise ValueError where tag, version and changelog don't agree."""
    if tag != f"v{version}":
        raise ValueError(f"the tag is {tag}, and pyproject.toml says version {version}")
    found = re.search(
        rf"^## {re.escape(version)}(?![\w.])[^\n]*\n(.*?)(?=^## |\Z)", changelog, re.MULTILINE | re.DOTALL
    )
    if found is None or not found[1].strip():
        raise ValueError(f"CHANGELOG.md says nothing of version {version}")
    return found[1].strip() + "\n"


def main() -> None:
    """Print the notes of the tag that is named."""
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    try:
        sys.stdout.write(notes_of(sys.argv[1], (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), version))
    except ValueError as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
