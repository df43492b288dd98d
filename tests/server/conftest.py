"""A served clip for each test; without the packages that serve, only what needs none of them is tested."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from click.testing import CliRunner, Result

from retime.cli.main import main

if TYPE_CHECKING:
    from tests.server.serving import Served

MISSING = [package for package in ("starlette", "uvicorn", "websockets") if find_spec(package) is None]
# test_installed.py says so.
collect_ignore = [
    path.name
    for path in Path(__file__).parent.glob("*.py")
    if MISSING and (path.name == "serving.py" or "from tests.server.serving" in path.read_text(encoding="utf-8"))
    if path.name != "conftest.py"
]


Run = Callable[..., Result]


@pytest.fixture
def run() -> Run:
    """Call retime in this process, in the current folder."""

    def call(*args: str) -> Result:
        result = CliRunner().invoke(main, args)
        assert result.exit_code == 0, result.output
        return result

    return call


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Give a folder with clips."""
    from tests.server.serving import make_clips

    return make_clips(tmp_path / "clips")


@pytest.fixture
def served(folder: Path) -> Iterator[Served]:
    """Serve one clip."""
    from tests.server.serving import serving

    with serving(folder, "jump.bvh") as found:
        yield found
