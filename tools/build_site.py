"""Build the documentation as a site, into build/site: ``python tools/build_site.py [FOLDER]``.

The pages of docs/ are read in the repository too, where a link to ``../CHANGELOG.md`` leads to that file. So they are
laid out beside pages made of such files and of the docstrings of the package, their links are turned, and Sphinx makes
a site of that; what it warns of is an error.
"""

from __future__ import annotations

import ast
import os
import posixpath
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SITE = ROOT / "tools" / "site"
# Files of the repository that are pages of the site.
OUTSIDE = {
    "CHANGELOG.md": "changes.md",
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "security.md",
    "CODE_OF_CONDUCT.md": "conduct.md",
    "LICENSE": "licence.md",
    "THIRD_PARTY.md": "third-party.md",
}
_LINK = re.compile(r"(\]\(\s*)([^)\s#]+)(#[^)\s]*)?(\s*\))")
# The menu: headings, and below each its pages in the order of reading.
MENU = {
    "Begin": ["install", "tutorial", "gallery", "coming-from"],
    "How to": [
        "howto/shorten",
        "howto/limp",
        "howto/dance",
        "blender",
        "howto/video",
        "howto/many-clips",
        "howto/notebook",
        "reporting",
    ],
    "Guide": [
        "guide",
        "choosing",
        "editor",
        "data",
        "formats",
        "usd",
        "parquet",
        "video",
        "batch",
        "hosts",
    ],
    "Reference": ["cli", "options", "api", "reference/index", "conventions", "glossary", "project-file"],
    "Method": ["method", "decisions", "study/README", "study/video", "performance", "since-0.1"],
    "Trust": [
        "reliability",
        "portability",
        "stability",
        "changes",
        "contributing",
        "security",
        "conduct",
        "licence",
        "third-party",
    ],
}


def pages() -> dict[str, str]:
    """Return the text of every page by its place on the site."""
    found = {}
    for path in sorted((ROOT / "docs").rglob("*.md")):
        place = path.relative_to(ROOT / "docs").as_posix()
        found[place] = moved(path.read_text(encoding="utf-8"), f"docs/{place}", place)
    for source, place in OUTSIDE.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        found[place] = moved(text if source.endswith(".md") else f"# Licence\n\n```text\n{text}```\n", source, place)
    found |= reference_pages()
    found["index.md"] += "".join(
        f"\n```{{toctree}}\n:hidden:\n:caption: {caption}\n\n{chr(10).join(names)}\n```\n"
        for caption, names in MENU.items()
    )
    return found


def moved(text: str, source: str, place: str) -> str:
    """Write a page's links anew: its file stands at `source` in the repository, the page at `place` on the site."""

    def one(match: re.Match[str]) -> str:
        before, target, anchor, after = match[1], match[2], match[3] or "", match[4]
        if re.match(r"[a-z]+:|/", target):
            return match[0]
        named = posixpath.normpath(posixpath.join(posixpath.dirname(source), target))
        # The front page of the repository is that of the site.
        there = {**OUTSIDE, "README.md": "index.md"}.get(named, named.removeprefix("docs/"))
        return f"{before}{posixpath.relpath(there, posixpath.dirname(place) or '.')}{anchor}{after}"

    # What is code is no link.
    parts = re.split(r"(^```.*?^```|`[^`\n]+`)", text, flags=re.MULTILINE | re.DOTALL)
    return "".join(part if index % 2 else _LINK.sub(one, part) for index, part in enumerate(parts))


def reference_pages() -> dict[str, str]:
    """Make the pages of the reference: one for each part of the package's table of contents."""
    source = ast.parse((ROOT / "src" / "retime" / "__init__.py").read_text(encoding="utf-8"))
    contents = ast.get_docstring(source) or ""
    homes: dict[str, str] = next(
        ast.literal_eval(node.value)
        for node in source.body
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and node.targets[0].id == "_HOMES"
    )
    found, listed = {}, []
    for heading, text in re.findall(r"^(\S[^\n]*)\n((?: {4}[^\n]*\n?)+)", contents, re.MULTILINE):
        names = [name for name in re.findall(r"`(?:retime\.)?([A-Za-z_]+)`", text) if name in homes]
        paths = [f"{homes[name]}.{name}" for name in names]
        if "RetimeError" in names:
            paths = [f"{home}.{name}" for name, home in sorted(homes.items()) if home == "retime.errors"]
        elif heading == "Many clips":
            paths = [f"retime.batch.{name}" for name in ("run", "BatchResult", "retime_clip", "ClipTask", "Record")]
        if paths:
            slug = re.sub(r"[^a-z]+", "-", heading.lower()).strip("-")
            found[f"reference/{slug}.md"] = f"# {heading}\n\n" + "\n".join(map(_directive, paths))
            listed.append((slug, heading, [path.rpartition(".")[2] for path in paths]))
    lines = [f"* [{heading}]({slug}.md): {', '.join(f'`{name}`' for name in names)}" for slug, heading, names in listed]
    tree = "\n".join(slug for slug, _, _ in listed)
    found["reference/index.md"] = (
        "# Python\n\nFrom the docstrings, as `help(retime.guided_warp)` shows them. All that is promised stands with "
        f"its signature on [one page](../api.md).\n\n{chr(10).join(lines)}\n\n```{{toctree}}\n:hidden:\n\n{tree}\n```\n"
    )
    return found


def _directive(path: str) -> str:
    is_class = path.rpartition(".")[2][0].isupper()
    kind, more = ("autoclass", "\n   :members:\n   :show-inheritance:") if is_class else ("autofunction", "")
    return f"```{{eval-rst}}\n.. {kind}:: {path}{more}\n```\n"


def main() -> None:
    """Lay the pages out, and have Sphinx make the site."""
    place = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "site"
    laid_out = place.with_name(f"{place.name}-pages")
    shutil.rmtree(laid_out, ignore_errors=True)
    shutil.rmtree(place, ignore_errors=True)
    shutil.copytree(ROOT / "docs" / "images", laid_out / "images")
    for path in (ROOT / "docs" / "study").iterdir():
        if path.suffix != ".md":
            (laid_out / "study").mkdir(exist_ok=True)
            shutil.copy(path, laid_out / "study")
    for name, text in pages().items():
        (laid_out / name).parent.mkdir(parents=True, exist_ok=True)
        (laid_out / name).write_text(text, encoding="utf-8")
    # The package is read from the checkout: its docstrings need NumPy alone.
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-W", "--keep-going", "-q", "-c", str(SITE)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run([*command, str(laid_out), str(place)], check=False, env=environment)
    sys.exit(done.returncode)


if __name__ == "__main__":
    main()
