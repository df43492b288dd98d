"""The same request gives the same bits on one thread and two, with wide vectors and narrow, compiled and in NumPy."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

import retime
from retime.kernels import compiled_available
from retime.search.poses.references import model_poses

# Pose vectors at 30 Hz in, digests of scores and frames of paths out. Six seconds of each clip keep NumPy quick.
CHILD = """
import hashlib, sys
import numpy as np
from retime.kernels import StepPairs
from retime.search.path import shortest_path
from retime.search.score import build_model, triple_scores

some = StepPairs.of([1, 2, 3, 4, 6, 9], 2.05)
clips = np.load(sys.argv[1])
for name in sorted(clips.files):
    poses = clips[name][:180]
    model = build_model([poses], rate=30, time_scale=0.1)
    for score in ("joint", "conditional"):
        scores = triple_scores(poses, model, max_skip=6, score=score)
        path = shortest_path(scores, n_output=max(3, round(0.65 * len(poses))))
        print(name, score, hashlib.sha256(scores.tobytes()).hexdigest(), *path.frames)
        scores = triple_scores(poses, model, steps=some, score=score)
        path = shortest_path(scores, steps=some, n_output=max(3, round(0.65 * len(poses))))
        print(name, score, "steps", hashlib.sha256(scores.tobytes()).hexdigest(), *path.frames)
"""

SETTINGS = {
    "one thread": {"RETIME_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    "two threads": {"RETIME_THREADS": "2"},
    "AVX2": {"RETIME_SIMD": "avx2"},
    "no wide vectors": {"RETIME_SIMD": "plain"},
    "NumPy": {"RETIME_BACKEND": "numpy"},
    # What NumPy multiplies matrices with has other kernels for other processors.
    "an old processor": {"OPENBLAS_CORETYPE": "Prescott"},
}
HERE = Path(__file__).parent


@pytest.mark.parametrize("setting", SETTINGS)
def test_the_sample_gives_the_paths_and_warps_that_are_committed(setting: str) -> None:
    if not compiled_available() and setting != "NumPy":
        pytest.skip("the compiled kernels were not built")
    done = subprocess.run(
        [sys.executable, str(HERE / "sample_warps.py")],
        env=os.environ | SETTINGS[setting],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == json.loads((HERE / "sample_digests.json").read_text(encoding="utf-8"))


def test_every_clip_gives_the_same_bits_and_the_same_path_everywhere(mocap: Path, tmp_path: Path) -> None:
    if not compiled_available():
        pytest.skip("the compiled kernels were not built")
    poses = {}
    for path in sorted([*mocap.glob("*/*.bvh"), *mocap.glob("*/*.amc")]):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", retime.FormatWarning)
            clip = retime.read(path)
        clip = clip.frames(0, min(clip.n_frames, round(6.5 * clip.rate)))
        poses[path.name] = model_poses(clip).input.at_rate(30.0, 4.0)
    assert len(poses) > 30
    np.savez(tmp_path / "poses.npz", **poses)
    answers = {}
    for setting, variables in SETTINGS.items():
        done = subprocess.run(
            [sys.executable, "-c", CHILD, str(tmp_path / "poses.npz")],
            env=os.environ | variables,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        answers[setting] = done.stdout.splitlines()
    expected = answers["one thread"]
    assert len(expected) == 4 * len(poses)
    for setting, lines in answers.items():
        different = [line.split()[:3] for line, other in zip(lines, expected, strict=True) if line != other]
        assert not different, f"{setting} differs on {different}"
