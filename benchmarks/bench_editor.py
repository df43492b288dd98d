"""Measure the editor on a long take, in a headless Chromium: opening, keys dragged, playback, the server's memory.

    python benchmarks/bench_editor.py [--quick] [--clip FILE] [--size 1920x1080] [--results FOLDER]

Makes its own take at 120 Hz, joined of all captures in ../shared/mocap or of the sample clip; --clip measures another.
Needs node, the page and its npm packages (make page), and Chromium; the server's processor time and memory are told by
Linux. Wall times say little on a machine that others use: beside them stands what a processor worked for the server and
for the page's own thread.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import clips
from measure import HERE, VERSION, machine, save

import retime

SCRIPT = HERE.parent / "web" / "test" / "measure.mjs"


def main() -> None:
    """Run, print, and save editor.json."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="a short take: only shows that everything runs")
    parser.add_argument("--frames", type=int, default=36_580, help="length of the take [default: five minutes]")
    parser.add_argument("--clip", type=Path, help="measure this clip instead")
    parser.add_argument("--size", default="1920x1080", help="of the page, pixels")
    parser.add_argument("--moves", type=int, default=60, help="positions of each drag")
    parser.add_argument("--results", type=Path, default=HERE / "results" / VERSION, help="folder for the JSON")
    options = parser.parse_args()
    width, height = map(int, options.size.split("x"))
    n_frames, moves = (600, 10) if options.quick else (options.frames, options.moves)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        clip = options.clip
        if clip is None:
            clip = folder / "take.bvh"
            retime.write(clips.joined_motion(n_frames), clip)
        n_frames = retime.read(clip).n_frames
        settings = {
            "python": sys.executable, "clip": str(clip.resolve()), "folder": scratch, "state": scratch,
            "moves": moves, "seconds": 1 if options.quick else 5, "width": width, "height": height,
        }  # fmt: skip
        done = subprocess.run(
            ["node", str(SCRIPT), json.dumps(settings)], capture_output=True, text=True, cwd=SCRIPT.parent, check=False
        )
    if done.returncode:
        sys.exit(done.stdout + done.stderr)
    found = json.loads(done.stdout.splitlines()[-1])
    print(f"{n_frames} frames, a page of {options.size}")
    for name, figures in found.items():
        if name != "errors":
            print(f"{name:38s} " + ", ".join(f"{what} {value:g}" for what, value in figures.items()))
    if found["errors"]:
        sys.exit(f"the page complained: {found['errors']}")
    conditions = {"machine": machine(), "motion": clips.source(), "n_frames": n_frames, "size": options.size}
    print("wrote", save("editor", {**conditions, **found}, options.results))


if __name__ == "__main__":
    main()
