"""Take the picture of the editor in docs/images: ``python tools/take_editor_picture.py``, with the page built.

Needs node, Chromium and the page's npm packages, as tests/server/test_browser.py does.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import retime

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "images" / "editor.png"


def main() -> None:
    """Drive the page on the sample clip."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        retime.write(retime.sample(), folder / "sample.bvh")
        settings = {
            "python": sys.executable,
            "clip": str(folder / "sample.bvh"),
            "folder": name,
            "state": str(folder / "state"),
            "picture": str(PICTURE),
        }
        subprocess.run(["node", "test/picture.mjs", json.dumps(settings)], check=True, cwd=ROOT / "web")


if __name__ == "__main__":
    main()
