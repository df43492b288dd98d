"""Documents to try the project with, and edits of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from retime.project.document import (
    BeatsFile,
    ClipFile,
    CounterpartFile,
    Document,
    Example,
    FlightMark,
    InfluencePoint,
    JointPair,
    KeptWarp,
    Key,
    LockedTime,
    Marker,
    MediaFile,
    ReferenceFile,
    WorkArea,
)
from retime.project.file import warp_id
from retime.project.journal import Edit
from retime.warp.curve import Warp

WARP = Warp(np.array([0.0, 0.1, 1 / 3]), np.array([0.0, 0.3, 2 / 3]), name="été")


def document_of(folder: Path) -> Document:
    """Make a document that uses every field."""
    return Document(
        clips=(
            ClipFile(str(folder / "a.bvh"), first_frame=2, last_frame=90, fps="30000/1001", up="z"),
            ClipFile(str(folder / "camera.csv"), channels="pan=angle:deg, *_id=label", gaps="bridge:0.2"),
        ),
        references=(
            ReferenceFile(
                str(folder / "refs" / "b.bvh"),
                weight=2.0,
                mirror=True,
                joint_map=str(folder / "names.json"),
                joints=(JointPair("Hips", "pelvis"),),
                counterparts=(CounterpartFile(1, str(folder / "refs" / "c.csv"), fps="25", gaps="keep"),),
            ),
            ReferenceFile(first_frame=4),
        ),
        keys=(Key("k1", 1 / 3, 0.1), Key("k2", 2.0, 1.5, 0.5)),
        locks=(LockedTime("l1", 0.5, 0.75, 0.0, 1.0),),
        method="spline",
        repeat=2.5,
        flights=(FlightMark("f1", 0.25, 0.5, False), FlightMark("found 1.000", 1.0, 1.25)),
        example=Example(0.5, 2.0),
        average=False,
        options={"length": "65%", "influence": 0.5, "score": "conditional", "speed": "1/4..4", "max_skip": 9},
        kept=(KeptWarp(warp_id(WARP), "first try"),),
        influence=(InfluencePoint(-0.5, 0.0), InfluencePoint(1 / 3, 0.75)),
        media=MediaFile(str(folder / "footage" / "take.mp4"), "-12f", "output"),
        beats=BeatsFile(str(folder / "beats.csv"), "onsets"),
        markers=(Marker("m1", 1 / 3, "beat, première"), Marker("m2", 2.0, on="input")),
        work_area=WorkArea(0.1, 1 / 3),
    )


def numbered(number: int) -> Document:
    return Document((ClipFile("/a.bvh"),), keys=(Key("k", 0.01 * number, 1.0),))


def edited(workspace, number: int) -> None:
    document = replace(workspace.history.present, keys=(Key("k", 0.01 * number, 1.0),))
    workspace.history = workspace.history.edit(document, label=f"to {number}")
    workspace.journal.edit(Edit(document, f"to {number}", "", True), workspace.history, workspace.warps)


def dead(workspace) -> None:
    """Let go of a workspace as a program does that dies: nothing is removed."""
    workspace.journal._file.close()
    workspace.journal._lock.close()
