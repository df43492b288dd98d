"""The editor in a real browser: web/test/browser.mjs drives it, the command line has the last word.

Needs node, the page's npm packages, the built page and Chromium; skips, saying so, where one of them is missing.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import retime
from tests.server.serving import serving  # noqa: F401  (says that this needs the packages that serve)

ROOT = Path(__file__).resolve().parents[2]
WEB = ROOT / "web"
PAGE = ROOT / "src" / "retime" / "server" / "page" / "index.html"
DATA = ROOT.parent / "shared" / "mocap"
CHROMIUM = ("/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome")


def _missing() -> str | None:
    if shutil.which("node") is None:
        return "needs node"
    if not (WEB / "node_modules" / "playwright-core").is_dir():
        return "needs the page's npm packages (make page)"
    if not PAGE.is_file():
        return "needs the page (make page)"
    if not any(Path(path).exists() for path in CHROMIUM):
        return "needs Chromium"
    return None


pytestmark = pytest.mark.skipif(_missing() is not None, reason=str(_missing()))


def drive(script: str, timeout: int, **settings: object) -> dict[str, object]:
    """Run one of the page's browser scripts; it prints what it found."""
    done = subprocess.run(
        ["node", str(WEB / "test" / script), json.dumps({"python": sys.executable, "options": [], **settings})],
        capture_output=True,
        text=True,
        timeout=timeout,
        cwd=WEB,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found: dict[str, object] = json.loads(done.stdout.splitlines()[-1])
    return found


@pytest.fixture
def rooms(tmp_path: Path) -> dict[str, str]:
    """Give folders for files, for the server's state, and for pictures of the page."""
    names = {name: tmp_path / name for name in ("folder", "state", "shots")}
    if "RETIME_SHOTS" in os.environ:
        names["shots"] = Path(os.environ["RETIME_SHOTS"])
    for folder in names.values():
        folder.mkdir(exist_ok=True, parents=True)
    return {name: str(folder) for name, folder in names.items()}


def test_edit_undo_die_recover_save_export(rooms, run):
    folder = Path(rooms["folder"])
    captured = [DATA / "cmu-asfamc" / name for name in ("86.asf", "86_01.amc")]
    if all(file.is_file() for file in captured):
        for file in captured:
            shutil.copy(file, folder)
        clip = folder / "86_01.amc"
    else:
        clip = folder / "sample.bvh"
        retime.write(retime.sample(), clip)

    retime.write(retime.sample(), folder / "other.bvh")
    found = drive("browser.mjs", 240, clip=str(clip), **rooms)

    # What was dragged in the page is in the project file, digit for digit; the command line makes the same of it.
    document = json.loads(Path(str(found["project"])).read_text(encoding="utf-8"))["document"]
    (key,) = document["keys"]
    assert f"input {key['input_time']:.3f} s at output {key['output_time']:.3f} s" in str(found["key"])
    assert document["length"] == "65%"
    other = folder / f"by_hand{clip.suffix}"
    run(
        "warp", str(clip), "--length", "65%", "--key", f"{key['input_time']!r}={key['output_time']!r}", "-o", str(other)
    )
    assert Path(str(found["exported"])).read_bytes() == other.read_bytes()
    assert len(list(Path(rooms["shots"]).glob("*.png"))) >= 10


def test_curve_follows_the_hand(rooms, record_property):
    """Report how long a dragged key's curve takes to be on the screen, at V1's size; the machine decides how long."""
    clip = DATA / "cmu-bvh" / "05_18.bvh"
    if not clip.is_file():
        clip = Path(rooms["folder"]) / "sample.bvh"
        retime.write(retime.sample(), clip)
    found = drive(
        "latency.mjs", 180, clip=str(clip), length="57%", moves=45, folder=rooms["folder"], state=rooms["state"]
    )
    for pace in ("30", "60"):
        measured = found[pace]
        assert isinstance(measured, dict)
        assert measured["moves"] >= 40
        record_property(f"key moved to curve on screen, {pace} moves a second", json.dumps(measured))
    print(json.dumps(found))
