"""docs/formats.md: its table is the registry's, and its commands run."""

from __future__ import annotations

import importlib.util
import re
import shlex
from pathlib import Path

import numpy as np
from click.testing import CliRunner

from retime.cli.main import main
from retime.data import SAMPLE
from retime.formats.registry import FORMATS, read
from retime.motion.motion import Motion
from tests.formats.body_files import body, npz
from tests.formats.c3d_files import Capture

ROOT = Path(__file__).resolve().parents[2]


def capture() -> Capture:
    """A second of two markers, one of them lost for a while, and a force."""
    points = np.zeros((60, 2, 4))
    points[:, :, 0] = 100 * np.sin(np.arange(60) / 9)[:, None]
    points[20:25, 1] = (0, 0, 0, -1)
    return Capture(rate=60.0, points=points, analog=np.arange(240.0)[:, None])


def test_the_table_is_that_of_the_registry() -> None:
    spec = importlib.util.spec_from_file_location("make_formats", ROOT / "tools" / "make_formats.py")
    assert spec is not None
    assert spec.loader is not None
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    text = tool.PAGE.read_text(encoding="utf-8")
    assert text == tool.page(), "run python tools/make_formats.py"
    for known in FORMATS:
        assert all(f"`{suffix}`" in text for suffix in known.suffixes)


def test_its_commands_run(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("demo").mkdir()
    Path("demo", "sample.bvh").write_bytes(SAMPLE.read_bytes())
    Path("take.c3d").write_bytes(capture().build())
    Path("body.npz").write_bytes(npz(body()))
    commands = re.findall(r"^\$ retime (.*)$", (ROOT / "docs" / "formats.md").read_text(encoding="utf-8"), flags=re.M)
    assert len(commands) >= 15
    for command in commands:
        run = CliRunner().invoke(main, shlex.split(command))
        assert run.exit_code == 0, (command, run.output)
    walk, shorter = read("walk.glb"), read("shorter.glb")
    assert isinstance(walk, Motion)
    assert shorter.end_time < 0.71 * walk.end_time
    assert Path("again.glb").read_bytes() == Path("slow.glb").read_bytes()
    assert Path("again.npz").read_bytes() == Path("shorter.npz").read_bytes()
    assert Path("again.c3d").read_bytes() == Path("shorter.c3d").read_bytes()
