"""docs/formats.md: its table is the registry's, and its commands run."""

from __future__ import annotations

import importlib.util
import re
import shlex
from pathlib import Path

from click.testing import CliRunner

from retime.cli.main import main
from retime.data import SAMPLE
from retime.formats.registry import FORMATS, read
from retime.motion.motion import Motion

ROOT = Path(__file__).resolve().parents[2]


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
    commands = re.findall(r"^\$ retime (.*)$", (ROOT / "docs" / "formats.md").read_text(encoding="utf-8"), flags=re.M)
    assert len(commands) == 4
    for command in commands:
        run = CliRunner().invoke(main, shlex.split(command))
        assert run.exit_code == 0, (command, run.output)
    walk, shorter = read("walk.glb"), read("shorter.glb")
    assert isinstance(walk, Motion)
    assert shorter.end_time < 0.71 * walk.end_time
    assert Path("again.glb").read_bytes() == Path("slow.glb").read_bytes()
