"""Ask other programs where the joints are.

    python -m tests.golden.make_golden_poses

writes `poses.json` beside this file: for odd but legal files of tests/data/bvh, the global positions of all joints in
all frames as pybvh finds them, else as bvhio does. Run it where both are installed (they are development
requirements), when such a file is added. test_golden_poses.py compares retime with the file, and with the programs
themselves on real captures.
"""

from __future__ import annotations

import json
import warnings
from importlib.metadata import version
from pathlib import Path

import numpy as np

DATA = Path(__file__).resolve().parents[1] / "data/bvh"
POSES = Path(__file__).with_name("poses.json")

# Files whose numbers are the point. Where pybvh refuses one (it wants three rotations a joint and positions at the
# root alone) bvhio reads it.
FILES = (
    "plain",
    "angles_beyond_half_turns",
    "blender_two_roots",
    "fewer_than_3_rotations",
    "mixed_3_and_6_channels",
    "position_on_one_axis",
    "positions_on_inner_joints",
    "rotation_before_position",
    "rotation_order_differs_by_joint",
    "several_end_sites",
    "zero_length_offsets",
)


def poses_by_pybvh(path: Path) -> np.ndarray | None:
    """Find the joints of all frames, shape (n_frames, n_joints, 3); None where pybvh does not read the file."""
    import pybvh

    with warnings.catch_warnings():
        # It guesses which way is up, and says when it is unsure.
        warnings.simplefilter("ignore", UserWarning)
        try:
            motion = pybvh.read_bvh_file(path)
        except ValueError:
            return None
        return np.array(motion.joint_positions())


def poses_by_bvhio(path: Path, n_frames: int) -> np.ndarray:
    """Find the joints of the first frames, shape (n_frames, n_joints, 3), in single precision.

    Only for files with as many rows as they claim: bvhio waits for ever for a row that is missing.
    """
    import bvhio

    root = bvhio.readAsHierarchy(str(path))
    poses = []
    for frame in range(n_frames):
        root.loadPose(frame)
        poses.append([[*joint.PositionWorld] for joint, _, _ in root.layout()])
    return np.array(poses)


def count_frames(path: Path) -> int:
    return int(path.read_bytes().split(b"Frames:")[1].split()[0])


def make_poses() -> dict[str, dict[str, object]]:
    """Make the content of poses.json."""
    made = {}
    for name in FILES:
        path = DATA / f"{name}.bvh"
        program, poses = "pybvh", poses_by_pybvh(path)
        if poses is None:
            program, poses = "bvhio", poses_by_bvhio(path, count_frames(path))
        # bvhio's floats have seven digits.
        made[name] = {
            "program": f"{program} {version(program)}",
            "positions": np.round(poses, 12 if program == "pybvh" else 6).tolist(),
        }
    return made


if __name__ == "__main__":
    entries = [f"{json.dumps(name)}: {json.dumps(entry)}" for name, entry in make_poses().items()]
    POSES.write_text("{\n" + ",\n".join(entries) + "\n}\n")
