"""The whole trip of two formats: the pictures of docs/formats.md, each with a check of what was written.

Usage: python examples/formats.py [FOLDER] (default: docs/images/formats)
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path

from click.testing import CliRunner

import retime
from retime.cli.main import main
from retime.data import SAMPLE

ROOT = Path(__file__).resolve().parents[1]


def draw(folder: Path) -> None:
    """Make a scene and a capture of the sample, retime each in place by the command line, and draw what it did."""
    folder.mkdir(parents=True, exist_ok=True)
    here = Path.cwd()
    with tempfile.TemporaryDirectory() as work:
        os.chdir(work)
        try:
            for ending in ("glb", "c3d"):
                _run("convert", SAMPLE, f"walk.{ending}")
                _run("warp", f"walk.{ending}", "--length", "65%", "-o", f"short.{ending}", "--plot", f"{ending}.svg")
                long, short = retime.read(f"walk.{ending}"), retime.read(f"short.{ending}")
                # A frame more or less: the rate of a scene is told by where its keys lie.
                assert abs(short.duration - 0.65 * long.duration) < 1.5 / float(long.rate)
                (folder / f"{ending}.svg").write_bytes(Path(f"{ending}.svg").read_bytes())
        finally:
            os.chdir(here)


def _run(*words: str | Path) -> None:
    done = CliRunner().invoke(main, [str(word) for word in words])
    assert done.exit_code == 0, done.output


if __name__ == "__main__":
    draw(Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else ROOT / "docs" / "images" / "formats")
