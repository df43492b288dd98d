"""Time the retiming of an FBX of 139,000 keys, as a ratio to copying its keys with NumPy in the same run.

    python benchmarks/bench_curves.py [--repeats 15]

The copy takes the file apart too, decodes every array of keys, copies it, and writes the file anew. Of both the
processor's time counts, and the best of the repeats, which take turns. Keys are linear, cubic with automatic slopes, or
cubic with weights, and the warp has 40 knots; a last file has its keys in 5,000 curves.
"""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from retime.formats.curves.fbx import format as fbx
from retime.formats.curves.fbx.file import Value, all_records
from retime.formats.curves.fbx.scene import parse_fbx
from retime.formats.curves.fbx.write import fbx_of
from retime.formats.read_options import Limits, ReadOptions
from retime.motion import rotation
from retime.motion.motion import Motion
from retime.motion.skeleton import Skeleton
from retime.warp.curve import Warp

PATH = Path("synthetic.fbx")
ARRAYS = {"KeyTime": "l", "KeyValueFloat": "f", "KeyAttrFlags": "i", "KeyAttrDataFloat": "f", "KeyAttrRefCount": "i"}


def make_file(n_joints: int, n_frames: int, flags: int, *, a_key: bool) -> bytes:
    """Make a figure that swings, six curves a joint; its keys have `flags`, and a run of their own each where asked."""
    rng = np.random.default_rng(1)
    seconds = np.arange(n_frames)[:, None, None] / 30
    swing = np.sin(seconds * rng.uniform(1, 6, (1, n_joints, 3)) + rng.uniform(0, 6, (1, n_joints, 3)))
    parents = tuple(range(-1, n_joints - 1)) if n_joints < 200 else (-1, *[0] * (n_joints - 1))
    skeleton = Skeleton([f"joint{i}" for i in range(n_joints)], parents, np.ones((n_joints, 3)))
    clip = Motion(skeleton, rotation.from_euler("ZYX", swing * 0.8), 1 + 5 * swing, 30)
    file = parse_fbx(PATH, fbx_of(clip), Limits()).file
    changes = {}
    data = np.array([0, 0, 4000 | 2500 << 16, 0], dtype=np.uint32).view(np.float32)
    for record in all_records(file.records):
        n = n_frames if a_key else 1
        if record.name == "KeyAttrFlags":
            changes[record, 0] = Value("i", np.full(n, flags))
        elif record.name == "KeyAttrDataFloat":
            changes[record, 0] = Value("f", np.tile(data, n))
        elif record.name == "KeyAttrRefCount":
            changes[record, 0] = Value("i", np.full(n, n_frames // n))
    return file.rewritten(changes)


def copied(data: bytes) -> bytes:
    """Copy a file, its keys by NumPy."""
    file = parse_fbx(PATH, data, Limits()).file
    changes = {}
    for record in all_records(file.records):
        if record.name in ARRAYS:
            letter = ARRAYS[record.name]
            changes[record, 0] = Value(letter, file.array(record, letter).copy())
    return file.rewritten(changes)


def best(ours: Callable[[], object], theirs: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Time two calls in turns; return the best of each, seconds."""
    found = [float("inf"), float("inf")]
    for _ in range(repeats):
        for which, call in enumerate((ours, theirs)):
            start = time.process_time()
            call()
            found[which] = min(found[which], time.process_time() - start)
    return found[0], found[1]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=15)
    arguments = parser.parse_args()
    warnings.simplefilter("ignore")
    cases = {
        "linear": (60, 386, 0x404, False),
        "cubic, automatic": (60, 386, 0x6108, False),
        "cubic, weighted": (60, 386, 0x3000C08, True),
        "5,000 curves": (834, 28, 0x6108, True),
    }
    for name, (n_joints, n_frames, flags, a_key) in cases.items():
        data = make_file(n_joints, n_frames, flags, a_key=a_key)
        end = (n_frames - 1) / 30
        rng = np.random.default_rng(0)
        inputs = np.concatenate([[0.0], np.sort(rng.uniform(0, end, 38)), [end]])
        warp = Warp(np.linspace(0, 0.7 * end, 40), inputs)
        ours, theirs = best(
            lambda data=data, warp=warp: fbx.retime(PATH, data, warp, ReadOptions()),
            lambda data=data: copied(data),
            arguments.repeats,
        )
        n_keys = 6 * n_joints * n_frames
        print(
            f"{name:<18} {n_keys:,} keys, {len(data) / 1e6:4.1f} MB   retimed {ours * 1e3:7.1f} ms   "
            f"copied {theirs * 1e3:7.1f} ms   ratio {ours / theirs:.1f}"
        )


if __name__ == "__main__":
    main()
