"""A folder of clips retimed by Airflow, a task each: a file for Airflow's folder of DAGs.

With ``CLIPS`` and ``OUT`` set, ``airflow dags reserialize`` and ``airflow dags test retime_library`` run it once, here
and without a scheduler.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from airflow.sdk import dag, task


@task
def rows() -> list[dict[str, str]]:
    """List the clips."""
    clips, out = Path(os.environ["CLIPS"]).resolve(), str(Path(os.environ["OUT"]).resolve())
    return [{"path": str(path), "name": path.name, "out": out} for path in sorted(clips.glob("*.bvh"))]


@task
def retimed(row: dict[str, str]) -> dict[str, Any]:
    """Retime one clip: plain data in, plain data out; a clip that can't be retimed says why."""
    from retime.batch import ClipTask, Treatment, retime_clip

    treatment = Treatment(search={"length": "80%"})
    task = ClipTask(row["path"], row["name"], row["out"], (row["name"],), treatment, overwrite=True)
    record = retime_clip(task)[0]
    return {"name": record.name, "status": record.status, "frames": record.frames_out, "message": record.message}


@task
def told(records: list[dict[str, Any]]) -> None:
    """Say what became of them."""
    for record in records:
        print(*record.values())


@dag(schedule=None)
def retime_library() -> None:
    """Retime a folder."""
    told(retimed.expand(row=rows()))  # type: ignore[arg-type]


retime_library()
