"""Write the version, which stands in pyproject.toml, into the other files that name it.

``python tools/make_version.py``

A release is one edit (the version in pyproject.toml), ``make docs``, and its heading in CHANGELOG.md.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VERSION = r"[0-9]+(?:\.[0-9]+)+(?:(?:a|b|rc)[0-9]+)?"
# For each file, what stands around the version, and how often.
PLACES = {
    "src/retime/__init__.py": (r'(?<=^__version__ = ")VERSION(?="$)', 1),
    "CITATION.cff": (r"(?<=^version: )VERSION$", 1),
    "blender/blender_manifest.toml": (r'(?<=^version = ")VERSION(?="$)', 1),
    "docs/blender.md": (r"(?<=`retime-)VERSION(?=(?:-linux_x64)?\.zip`)", 2),
}


def version() -> str:
    """Return the version that pyproject.toml has."""
    found: str = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    return found


def with_version(place: str, text: str, wanted: str) -> str:
    """Return a file's text with the version in all of its places; raise ValueError where there are not as many."""
    pattern, times = PLACES[place]
    made, count = re.subn(pattern.replace("VERSION", VERSION), wanted, text, flags=re.MULTILINE)
    if count != times:
        raise ValueError(f"{place} names the version {count} times, expected {times}")
    return made


def main() -> None:
    """Write the version into the other files."""
    for place in PLACES:
        path = ROOT / place
        path.write_text(with_version(place, path.read_text(encoding="utf-8"), version()), encoding="utf-8")


if __name__ == "__main__":
    main()
