"""The benchmark of the editor runs, at a tiny size, in a real browser. No time is judged."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from tests.server.test_browser import ROOT, pytestmark  # noqa: F401


def test_the_editor_is_measured(tmp_path: Path) -> None:
    script = ROOT / "benchmarks" / "bench_editor.py"
    words = [sys.executable, str(script), "--quick", "--size", "1280x720", "--results", str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=240, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads((tmp_path / "editor.json").read_text())
    assert found["n_frames"] == 600
    assert found["play"]["frames_a_second"] > 0
    assert found["dragged"]["positions"] >= 6
    assert found["memory"]["most"] > 50
    assert "take.bvh: joint" not in done.stderr
