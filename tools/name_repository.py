"""Name the repository in what a release tells the index: ``python tools/name_repository.py URL REF``.

On the index's page nothing stands beside README.md, so that its pictures and links, which are relative for the sake of
forks, would lead nowhere; and pyproject.toml names no repository, for it has no way to know in which it lies. The
workflow that builds a release does, and runs this in its own checkout: links then lead to REF (a tag) in the repository
at URL, and the package's page lists it.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# A link or a picture, its target without a title; of those in a line of code none is one.
_LINK = re.compile(r"`[^`]*`|(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
_PAPER = re.compile(r'^urls = \{ (Paper = "[^"]*") \}$', re.MULTILINE)


def published_readme(text: str, repository: str, ref: str) -> str:
    """Return the text of README.md with the targets of its links and pictures at a tag of a repository."""

    def absolute(match: re.Match[str]) -> str:
        mark, label, target = match.groups()
        if target is None or target.startswith("#") or re.match(r"[a-z]+:", target):
            return match[0]
        # A picture may be what a link is written on.
        label = _LINK.sub(absolute, label)
        return f"{mark}[{label}]({repository}/{'raw' if mark else 'blob'}/{ref}/{target})"

    # Between fences stands what is typed.
    pieces = re.split(r"(^```.*?^```$)", text, flags=re.MULTILINE | re.DOTALL)
    return "".join(piece if piece.startswith("```") else _LINK.sub(absolute, piece) for piece in pieces)


def published_project(text: str, repository: str, ref: str) -> str:
    """Return the text of pyproject.toml with the repository among its addresses; raise ValueError without a place."""
    urls = {
        "Homepage": repository,
        "Documentation": f"{repository}/blob/{ref}/docs/index.md",
        "Changelog": f"{repository}/blob/{ref}/CHANGELOG.md",
        "Issues": f"{repository}/issues",
    }
    listed = ", ".join(f'{name} = "{url}"' for name, url in urls.items())
    made, count = _PAPER.subn(lambda match: f"urls = {{ {listed}, {match[1]} }}", text)
    if count != 1:
        raise ValueError('pyproject.toml: expected one line of urls = { Paper = "..." }')
    return made


def main() -> None:
    """Write both files."""
    repository, ref = sys.argv[1].rstrip("/"), sys.argv[2]
    for name, published in (("README.md", published_readme), ("pyproject.toml", published_project)):
        path = ROOT / name
        path.write_text(published(path.read_text(encoding="utf-8"), repository, ref), encoding="utf-8")


if __name__ == "__main__":
    main()
