"""What pip builds: a page where npm works, a reason where it does not, and an install either way."""

from __future__ import annotations

import importlib.util
import json
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[1]
FILES = ("index.html", "widget.js", "widget.css")
# Writes down how it is called; CI and BUILD say how it ends.
NPM = f"""#!{sys.executable}
import os, pathlib, sys
root = pathlib.Path(__file__).parents[1]
with (root / "calls").open("a") as calls:
    print(*sys.argv[3:5], file=calls)
assert sys.argv[1:3] == ["--prefix", str(root / "web")], sys.argv
page = root / "src" / "retime" / "server" / "page"
if sys.argv[3] == "ci":
    (root / "web" / "node_modules").mkdir(exist_ok=True)
    sys.exit(int(os.environ.get("CI_CODE", "0")))
for file in page.glob("*"):
    file.unlink()
page.mkdir(exist_ok=True)
for name in os.environ.get("BUILDS", "{" ".join(FILES)}").split():
    (page / name).write_text("new")
sys.exit(int(os.environ.get("BUILD_CODE", "0")))
"""


def backend() -> ModuleType:
    pytest.importorskip("scikit_build_core", reason="needs scikit-build-core, which builds retime")
    spec = importlib.util.spec_from_file_location("build_backend", ROOT / "tools" / "build_backend.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@dataclass
class Tree:
    """A source tree with an npm of its own."""

    root: Path

    @property
    def page(self) -> Path:
        return self.root / "src" / "retime" / "server" / "page"

    @property
    def calls(self) -> list[str]:
        file = self.root / "calls"
        return file.read_text().splitlines() if file.exists() else []

    def with_page(self, *, age: float) -> None:
        """Put a page there that is so many seconds older than its sources."""
        self.page.mkdir(parents=True)
        newest = max(file.stat().st_mtime for file in (self.root / "web").rglob("*"))
        for name in FILES:
            (self.page / name).write_text("old")
            os.utime(self.page / name, (newest - age, newest - age))

    def texts(self) -> dict[str, str]:
        return {file.name: file.read_text() for file in self.page.iterdir()}


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Tree:
    for name in ("web/package.json", "web/package-lock.json", "web/src/main.ts"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("{}")
    (tmp_path / "src" / "retime" / "server").mkdir(parents=True)
    npm = tmp_path / "bin" / "npm"
    npm.parent.mkdir()
    npm.write_text(NPM)
    npm.chmod(0o755)
    monkeypatch.setenv("PATH", str(npm.parent))
    monkeypatch.delenv("RETIME_REQUIRE_PAGE", raising=False)
    return Tree(tmp_path)


def test_npm_builds_the_page_once(tree: Tree) -> None:
    backend().make_page(tree.root)
    assert tree.texts() == dict.fromkeys(FILES, "new")
    assert tree.calls == ["ci --no-audit", "run build"]
    backend().make_page(tree.root)
    assert tree.calls == ["ci --no-audit", "run build"]


def test_sources_that_changed_are_built_again_with_what_is_installed(tree: Tree) -> None:
    backend().make_page(tree.root)
    newest = (tree.page / "index.html").stat().st_mtime + 10
    os.utime(tree.root / "web" / "src" / "main.ts", (newest, newest))
    backend().make_page(tree.root)
    assert tree.calls == ["ci --no-audit", "run build", "run build"]


def test_an_sdist_with_a_page_needs_no_npm(tree: Tree) -> None:
    # What an archive makes of times is no reason to build again.
    tree.with_page(age=1000)
    (tree.root / "PKG-INFO").write_text("Name: retime\n")
    (tree.root / "bin" / "npm").unlink()
    backend().make_page(tree.root)
    assert tree.texts() == dict.fromkeys(FILES, "old")


def test_an_sdist_without_a_page_builds_it(tree: Tree) -> None:
    (tree.root / "PKG-INFO").write_text("Name: retime\n")
    backend().make_page(tree.root)
    assert tree.texts() == dict.fromkeys(FILES, "new")


@pytest.mark.parametrize(
    ("environment", "says"),
    [
        pytest.param({"PATH": ""}, "npm was not found", id="no_npm"),
        pytest.param({"CI_CODE": "7"}, "npm ci failed (exit code 7", id="no_registry"),
        pytest.param({"BUILD_CODE": "2", "BUILDS": "index.html"}, "npm run failed (exit code 2", id="half_a_page"),
        pytest.param({"BUILDS": "index.html widget.js"}, "npm built no page", id="not_all_of_it"),
    ],
)
def test_without_a_page_the_build_goes_on_and_leaves_the_reason(
    tree: Tree,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    environment: dict[str, str],
    says: str,
) -> None:
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    backend().make_page(tree.root)
    ((name, text),) = tree.texts().items()
    assert name == "missing.txt"
    assert says in text
    assert says in capfd.readouterr().err
    # A failed install is tried again; a release may ask for the page.
    monkeypatch.setenv("RETIME_REQUIRE_PAGE", "1")
    with pytest.raises(SystemExit, match="The editor's page: npm"):
        backend().make_page(tree.root)


def test_an_older_page_is_better_than_none(tree: Tree, capfd: pytest.CaptureFixture[str]) -> None:
    tree.with_page(age=1000)
    (tree.root / "bin" / "npm").unlink()
    backend().make_page(tree.root)
    assert tree.texts() == dict.fromkeys(FILES, "old")
    assert "older than its sources: npm was not found" in capfd.readouterr().err


def test_the_linter_is_not_among_what_a_build_fetches() -> None:
    for name in ("web/package-lock.json", "web/lint/package-lock.json"):
        fetched = [path for path in json.loads((ROOT / name).read_text())["packages"] if "biome" in path]
        assert bool(fetched) == ("lint" in name)
