"""A folder of clips retimed by Ray: ``python examples/engines/with_ray.py CLIPS OUT``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import ray

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
    ray.init(num_cpus=2, include_dashboard=False, logging_level="warning")
    try:
        return ray.data.from_items(rows).map(retimed).take_all()
    finally:
        ray.shutdown()


if __name__ == "__main__":
    for record in sorted(main(*sys.argv[1:3]), key=lambda record: record["name"]):
        print(*record.values())
