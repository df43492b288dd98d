"""Time BVH reading, BVH writing and forward kinematics, each as a ratio to pybvh in the same run.

    python benchmarks/bench_formats.py [--frames 5000] [--repeats 15]

Makes its own file of 96 channels (31 joints, six channels at the root). The two programs take turns, so that a busy
machine slows both; the best of the repeats counts. A ratio below 1 means that retime is the faster one.
"""

from __future__ import annotations

import argparse
import tempfile
import time
import warnings
from collections.abc import Callable
from copy import copy as copy_of
from fractions import Fraction
from pathlib import Path

import numpy as np
import pybvh

from retime.formats import read, write
from retime.motion import rotation
from retime.motion.kinematics import global_poses
from retime.motion.motion import Motion
from retime.motion.skeleton import EndSite, Skeleton

N_JOINTS = 31


def make_motion(n_frames: int) -> Motion:
    """Make a figure of five limbs that swings smoothly: as many joints and channels as a common capture."""
    generator = np.random.default_rng(1)
    parents = [-1]
    for limb in range(5):
        parents += [0, *range(6 * limb + 1, 6 * limb + 6)]
    offsets = generator.normal(scale=3.0, size=(N_JOINTS, 3))
    names = tuple(f"joint{i}" for i in range(N_JOINTS))
    ends = tuple(EndSite(6 * limb + 6, (0.0, 1.0, 0.0)) for limb in range(5))
    skeleton = Skeleton(names, tuple(parents), offsets, ends)
    times = np.arange(n_frames)[:, None, None] / 120.0
    swing = np.sin(times * generator.uniform(1, 6, size=(1, N_JOINTS, 3)) + generator.uniform(0, 6, (1, N_JOINTS, 3)))
    rotations = rotation.from_euler("ZYX", swing * 0.8)
    translations = np.broadcast_to(offsets, (n_frames, N_JOINTS, 3)).copy()
    translations[:, 0] = swing[:, 0] * 20 + np.array([0.0, 17.0, 0.0])
    return Motion(skeleton, rotations, translations, Fraction(120))


def ratio(label: str, ours: Callable[[], object], theirs: Callable[[], object], repeats: int) -> None:
    """Time two calls in turns and print the best of each and their ratio."""
    best = [float("inf"), float("inf")]
    for _ in range(repeats):
        for which, call in enumerate((ours, theirs)):
            start = time.perf_counter()
            call()
            best[which] = min(best[which], time.perf_counter() - start)
    print(f"{label:<20} retime {best[0] * 1e3:7.1f} ms   pybvh {best[1] * 1e3:7.1f} ms   ratio {best[0] / best[1]:.2f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=5000)
    parser.add_argument("--repeats", type=int, default=15)
    arguments = parser.parse_args()
    # pybvh guesses which way is up and says when it is unsure; that is no matter here.
    warnings.simplefilter("ignore", UserWarning)
    with tempfile.TemporaryDirectory() as folder:
        path, copy = Path(folder) / "synthetic.bvh", Path(folder) / "copy.bvh"
        write(make_motion(arguments.frames), path)
        motion = read(path)
        assert isinstance(motion, Motion)
        theirs = pybvh.read_bvh_file(path)
        n_channels = sum(map(len, motion.declaration.channels)) if motion.declaration else 0
        print(f"{motion.n_frames} frames, {n_channels} channels, {path.stat().st_size / 1e6:.1f} MB")

        def their_kinematics() -> object:
            # Setting the angles drops the positions that pybvh keeps from the last call.
            theirs.joint_angles = theirs.joint_angles
            return theirs.node_positions()

        ratio("read", lambda: read(path), lambda: pybvh.read_bvh_file(path), arguments.repeats)
        ratio(
            "write",
            lambda: write(motion, copy, overwrite=True),
            lambda: pybvh.write_bvh_file(theirs, copy),
            arguments.repeats,
        )
        # A motion's poses are kept beside it: a copy has none yet.
        ratio("forward kinematics", lambda: global_poses(copy_of(motion)), their_kinematics, arguments.repeats)


if __name__ == "__main__":
    main()
