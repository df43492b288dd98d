"""Random project files: each is solved, explained and told to a page, or refused as retime refuses.

python -m tests.fuzz.documents --count 12000 --seed 1
"""

from __future__ import annotations

import functools
import json
import random
import sys
import tempfile
import warnings
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from retime.formats import write
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.project.dataclass_json import to_value
from retime.project.document import ClipFile, Document, Example, FlightMark, Key, LockedTime, ReferenceFile
from retime.project.file import VERSION, project_bytes, read_project
from retime.project.solve import DocumentSolver
from retime.server.drawn_messages import clip_messages, curve_message, why_message
from retime.server.message_coding import write_message
from tests.fuzz.trials import command, mutated_json
from tests.warp.motions import wandering_motion


@functools.cache
def clips() -> dict[str, Motion | Signal]:
    """Return the clips that documents name."""
    values = np.random.default_rng(1).standard_normal((40, 2)).cumsum(axis=0)
    return {
        "walk.bvh": wandering_motion(40),
        "other.bvh": wandering_motion(30, seed=3),
        "camera.csv": Signal(("pan", "tilt"), values, Fraction(30)),
    }


def whole_document(draw: random.Random) -> Document:
    """Make a document that mostly can be solved."""

    def chance(share: float) -> bool:
        return draw.random() < share

    times = sorted(draw.uniform(0.1, 1.2) for _ in range(draw.randint(0, 3)))
    keys = tuple(
        Key(f"k{i}", time, time * draw.uniform(0.8, 1.2), draw.choice([None, None, 0.5, 2.0]))
        for i, time in enumerate(times)
    )
    options: dict[str, str | float | bool] = {}
    for name, values in {
        "length": ["65%", "1.5", "50f", "free", "140%"],
        "rate": ["12", "30", "30000/1001"],
        "speed": ["1/4..4", "0.5..2"],
        "max_skip": [4, 9],
        "influence": [0.0, 0.5, 1.0],
        "smoothness": [0.0, 2.0],
        "upsample": [1, 2],
        "score": ["conditional", "density"],
        "loop": [True],
        "search": ["exact", "heuristic"],
    }.items():
        if chance(0.25):
            options[name] = draw.choice(values)
    return Document(
        clips=(ClipFile("walk.bvh"), *((ClipFile("camera.csv", role="follow"),) if chance(0.3) else ())),
        references=tuple(
            draw.choice([ReferenceFile(), ReferenceFile("other.bvh", weight=2.0), ReferenceFile(first_frame=3)])
            for _ in range(draw.choice([0, 0, 1, 2]))
        ),
        keys=keys if chance(0.7) else (),
        locks=(LockedTime("l", 0.4, 0.7, draw.choice([0.5, 1.0]), 1.0),) if chance(0.3) else (),
        method=draw.choice(["guided", "guided", "guided", "align", "linear", "spline"]),
        flights=(FlightMark("f", 0.2, 0.4, chance(0.5)),) if chance(0.2) else (),
        example=Example(0.2, 0.6) if chance(0.15) else None,
        average=chance(0.5),
        options=options,
    )


def whole_value(draw: random.Random) -> Any:
    """Make a project file's value."""
    return {"format": "retime-project", "version": VERSION, "document": to_value(whole_document(draw))}


def trial(draw: random.Random) -> str:
    """Make a project, change it in a few places, and do with it what the editor does."""
    value = whole_value(draw)
    for _ in range(draw.choice([0, 1, 1, 2, 3])):
        value["document"] = mutated_json(draw, value["document"])
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        folder = Path(name)
        for file, clip in clips().items():
            write(clip, folder / file)
        path = folder / "p.retime"
        path.write_text(json.dumps(value))
        project = read_project(path)
        # What can be read can be written, and read as the same.
        path.write_bytes(project_bytes(project.document, project.warps, folder))
        assert read_project(path).document == project.document
        solver = DocumentSolver()
        for told in clip_messages(solver.read(project.document), None):
            write_message(told)
        solution = solver.solve(project.document)
        write_message(curve_message(1, solution, 1.0))
        if (why := why_message(1, solution)) is not None:
            write_message(why)
    return f"{project.document.method}{' by example' if project.document.example else ''} is solved"


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(command(trial, __doc__))
