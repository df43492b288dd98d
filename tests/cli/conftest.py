"""Clips to retime, and two ways to call retime: inside this process, and as a command."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from retime import write
from retime.cli.main import main
from tests.cli.figures import curve, figure

COMMAND = (sys.executable, "-m", "retime.cli.main")


@dataclass(frozen=True)
class Clips:
    """Files that tests read and never write."""

    bvh: Path
    csv: Path


@pytest.fixture(scope="session")
def clips(tmp_path_factory: pytest.TempPathFactory) -> Clips:
    folder = tmp_path_factory.mktemp("clips")
    clips = Clips(folder / "jump.bvh", folder / "camera.csv")
    write(figure(), clips.bvh)
    write(curve(), clips.csv)
    return clips


Run = Callable[..., Result]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Call retime in this process, in an empty folder; expect an exit code of 0 unless told otherwise."""
    monkeypatch.chdir(tmp_path)

    def call(*args: str | Path, code: int = 0) -> Result:
        result = CliRunner().invoke(main, [str(arg) for arg in args])
        assert result.exit_code == code, f"{result.exit_code}\n{result.output}\n{result.exception!r}"
        assert isinstance(result.exception, SystemExit | None), repr(result.exception)
        assert "Traceback" not in result.output
        return result

    return call


@pytest.fixture
def command(tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Call retime as a command of its own, in an empty folder."""

    def call(*args: str | Path, **options: Any) -> subprocess.CompletedProcess[str]:
        settings = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "timeout": 60, "cwd": tmp_path}
        return subprocess.run([*COMMAND, *map(str, args)], **{**settings, **options}, check=False)

    return call
