"""The AMC files of the tests, skeletons and frames written by hand, and how they are read."""

from __future__ import annotations

from pathlib import Path

import pytest

from retime.formats import read
from retime.motion.motion import Motion

DATA = Path(__file__).resolve().parents[1] / "data"
AMC = DATA / "amc"
ASF = DATA / "asf"
MOCAP = Path(__file__).resolve().parents[2] / "../shared/mocap"
ARM = AMC / "arm.asf"

needs_mocap = pytest.mark.skipif(not MOCAP.is_dir(), reason="the folder ../shared/mocap is not beside the checkout")


def read_amc(path: Path, **options: object) -> Motion:
    motion = read(path, **{"rate": 120, **options})
    assert isinstance(motion, Motion)
    return motion


def bone(name: str, direction: str, axis: str = "0 0 0 XYZ", dof: str = "", length: float = 1) -> str:
    free = f"dof {dof}\n" if dof else ""
    return f"begin\nname {name}\ndirection {direction}\nlength {length}\naxis {axis}\n{free}end\n"


def asf_text(
    bones: str,
    hierarchy: str,
    *,
    root: str = "order TX TY TZ RX RY RZ\naxis XYZ\nposition 0 0 0\norientation 0 0 0",
    units: str = "angle deg",
) -> str:
    return f":units\n{units}\n:root\n{root}\n:bonedata\n{bones}:hierarchy\nbegin\n{hierarchy}\nend\n"


def pose(folder: Path, asf: str, frame: str, **options: object) -> Motion:
    (folder / "one.asf").write_text(asf)
    (folder / "one.amc").write_text(f":FULLY-SPECIFIED\n:DEGREES\n1\n{frame}\n")
    return read_amc(folder / "one.amc", **options)
