"""``python -m study``: what it needs, what it refuses, and what it leaves behind."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def run(*args: str | Path, code: int = 0) -> subprocess.CompletedProcess[str]:
    """Run it as the makefile does."""
    command = [sys.executable, "-m", "study", *map(str, args)]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert ended.returncode == code, ended.stdout + ended.stderr
    assert "Traceback" not in ended.stderr
    return ended


def test_an_unknown_part_is_refused_with_those_there_are(tmp_path: Path) -> None:
    ended = run("--data", tmp_path, "--only", "V1,V9", code=2)
    assert "V9" in ended.stderr
    assert "sensitivity" in ended.stderr


def test_a_folder_without_captures_is_named_before_the_work(tmp_path: Path) -> None:
    ended = run("--data", tmp_path, "--out", tmp_path / "out", code=1)
    assert "missing" in ended.stderr
    assert str(tmp_path) in ended.stderr
    assert not (tmp_path / "out").exists()


def test_a_quick_part_writes_a_page_pictures_and_numbers(mocap: Path, tmp_path: Path) -> None:
    ended = run("--data", mocap, "--only", "signals", "--quick", "--out", tmp_path / "out")
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"report.html", "study.json", "ball.png"} <= written
    assert all(str(tmp_path / "out" / name) in ended.stdout for name in written)
    assert json.loads((tmp_path / "out" / "study.json").read_text("utf-8"))
