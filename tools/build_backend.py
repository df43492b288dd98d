"""What pip calls to build retime: scikit-build-core, and before it npm for the editor's page.

The page is not in the repository. A wheel or an sdist gets it here, with CMake or without, where npm works. Where npm
is missing or fails, or its registry can't be reached, the build goes on without a page, and leaves the reason where the
page would be: ``retime edit`` and ``retime info --build`` say it, for pip shows what a build prints with ``-v`` alone.
RETIME_REQUIRE_PAGE=1 makes that an error.

An editable install (``make install``) takes the page that ``make page`` builds.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from scikit_build_core import build as _inner
from scikit_build_core.build import (
    build_editable,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    get_requires_for_build_wheel,
)

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
]

ROOT = Path(__file__).resolve().parents[1]
# A registry that does not answer must not hold an install up for long: npm's own choice is five minutes a file, thrice.
_SOON = ("--fetch-retries=1", "--fetch-retry-mintimeout=1000", "--fetch-timeout=30000")
_INSTALL = ("ci", "--no-audit", "--no-fund", "--loglevel=error", *_SOON)
_BUILD = ("run", "build")


def build_wheel(
    wheel_directory: str,
    config_settings: dict[str, list[str] | str] | None = None,
    metadata_directory: str | None = None,
) -> str:
    """Build the page and then the wheel (PEP 517)."""
    make_page(ROOT)
    return _inner.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_sdist(sdist_directory: str, config_settings: dict[str, list[str] | str] | None = None) -> str:
    """Build the page and then the sdist (PEP 517)."""
    make_page(ROOT)
    return _inner.build_sdist(sdist_directory, config_settings)


def make_page(root: Path) -> None:
    """Build the page in a source tree, unless it is there and of these sources.

    Raises
    ------
    SystemExit
        There is none to be had, and RETIME_REQUIRE_PAGE=1 asks for it.
    """
    web, page = root / "web", root / "src" / "retime" / "server" / "page"
    built = [page / "index.html", page / "widget.js", page / "widget.css"]
    there = all(file.is_file() for file in built)
    # An sdist holds the page of its own sources; in a checkout they may have changed since.
    if there and (
        (root / "PKG-INFO").is_file() or _newest(_sources(web)) <= min(file.stat().st_mtime for file in built)
    ):
        return
    problem = _run_npm(web)
    if not problem and not all(file.is_file() for file in built):
        problem = "npm built no page"
    if not problem:
        return
    if os.environ.get("RETIME_REQUIRE_PAGE") == "1":
        raise SystemExit(f"*** The editor's page: {problem}")
    if all(file.is_file() for file in built):
        print(
            f"*** The editor's page could not be built again, and is older than its sources: {problem}", file=sys.stderr
        )
        return
    print(f"*** Going on without the editor's page: {problem}", file=sys.stderr)
    shutil.rmtree(page, ignore_errors=True)
    page.mkdir(parents=True)
    (page / "missing.txt").write_text(problem + "\n", encoding="utf-8")


def _sources(web: Path) -> Iterator[Path]:
    for path in web.rglob("*"):
        if path.is_file() and "node_modules" not in path.relative_to(web).parts:
            yield path


def _newest(files: Iterator[Path]) -> float:
    return max((file.stat().st_mtime for file in files), default=0.0)


def _run_npm(web: Path) -> str:
    """Install what the page is built with, and build it; return what went wrong."""
    npm = shutil.which("npm")
    if npm is None:
        return "npm was not found"
    # The makefile's stamp: "make page" after this has nothing to do, and the other way round.
    stamp, lock = web / "node_modules" / ".made", web / "package-lock.json"
    commands = [_BUILD]
    if not stamp.is_file() or stamp.stat().st_mtime < lock.stat().st_mtime:
        commands.insert(0, _INSTALL)
    for command in commands:
        print(f"*** npm {' '.join(command)}", file=sys.stderr, flush=True)
        try:
            # Its words belong with the build's: on stdout a front end looks for nothing.
            code = subprocess.run([npm, "--prefix", str(web), *command], stdout=sys.stderr, check=False).returncode
        except OSError as error:
            return f"npm could not be run: {error.strerror or error}"
        if code != 0:
            return f"npm {command[0]} failed (exit code {code}; pip install -v shows what it said)"
        if command == _INSTALL:
            stamp.touch()
    return ""
