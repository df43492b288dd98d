"""A folder of clips retimed by Hugging Face datasets: ``python examples/engines/with_datasets.py CLIPS OUT``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import datasets

from retime.batch import ClipTask, Treatment, retime_clip


def retimed(row: dict[str, str]) -> dict[str, Any]:
    """Retime one clip: plain data in, plain data out; a clip that can't be retimed says why."""
    treatment = Treatment(search={"length": "80%"})
    task = ClipTask(row["path"], row["name"], row["out"], (row["name"],), treatment, overwrite=True)
    record = retime_clip(task)[0]
    return {"name": record.name, "status": record.status, "frames": record.frames_out, "message": record.message}


def main(clips: str, out: str) -> list[dict[str, Any]]:
    """Retime every BVH of a folder."""
    rows = [{"path": str(path), "name": path.name, "out": out} for path in sorted(Path(clips).resolve().glob("*.bvh"))]
    found = datasets.Dataset.from_list(rows).map(retimed, num_proc=2)
    return found.select_columns(["name", "status", "frames", "message"]).to_list()


if __name__ == "__main__":
    for record in sorted(main(*sys.argv[1:3]), key=lambda record: record["name"]):
        print(*record.values())
