"""`retime study`: what it needs, what it refuses, and what it leaves behind."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

MOCAP = Path(__file__).resolve().parents[2] / "../shared/mocap"


def test_an_unknown_part_is_refused_with_those_there_are(run, tmp_path: Path) -> None:
    result = run("study", "--data", tmp_path, "--only", "V1,V9", code=2)
    assert "V9" in result.stderr
    assert "sensitivity" in result.stderr


def test_a_folder_without_captures_is_named_before_the_work(run, tmp_path: Path) -> None:
    result = run("study", "--data", tmp_path, "--out", tmp_path / "out", code=1)
    assert "missing" in result.stderr
    assert str(tmp_path) in result.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.skipif(not MOCAP.is_dir(), reason="needs the captures in ../shared/mocap")
def test_a_quick_part_writes_a_page_pictures_and_numbers(run, tmp_path: Path) -> None:
    result = run("study", "--data", MOCAP, "--only", "signals", "--quick", "--out", tmp_path / "out")
    written = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"report.html", "study.json", "ball.png"} <= written
    assert all(str(tmp_path / "out" / name) in result.output for name in written)
    assert json.loads((tmp_path / "out" / "study.json").read_text("utf-8"))
