"""Mutants of keypoint files: each is read as a valid signal, or refused as retime refuses."""

from __future__ import annotations

import functools
import json
import random
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from retime.formats import read
from tests.formats.keypoint_files import landmarks, moving, openpose_people
from tests.fuzz.text_files import check
from tests.fuzz.trials import Trial, mutated_json, mutated_text


@functools.cache
def whole_files() -> tuple[tuple[str, Any], ...]:
    """Return documents that mutants are made of, each with the program that writes so."""
    poses = moving(3, 15, n_axes=2)
    people = [openpose_people([pose, pose + 3], [np.ones(15)] * 2) for pose in poses]
    lists = landmarks(moving(3, 17))
    return (
        ("OpenPose", people),
        ("OpenPose in one file", {"fps": 30, "frames": people}),
        ("MediaPipe", [{"frame": n, "timestamp_ms": 33 * n, "landmarks": one} for n, one in enumerate(lists)]),
        ("MediaPipe's tasks", [{"landmarks": [one, one], "time": n / 30} for n, one in enumerate(lists)]),
        ("lists of numbers", {"metadata": {"fps": 25}, "data": moving(3, 17).tolist()}),
        ("points by name", [dict(zip("abcde", one, strict=False)) for one in lists]),
    )


def keypoint_file(draw: random.Random) -> str:
    """Make a mutant, and read it."""
    program, document = draw.choice(whole_files())
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as name:
        path = Path(name)
        if program == "OpenPose":
            for number, frame in enumerate(document):
                changed = mutated_json(draw, frame) if draw.random() < 0.3 else frame
                (path / f"a_{number:012d}_keypoints.json").write_text(json.dumps(changed))
        else:
            path /= "clip.json"
            data = json.dumps(mutated_json(draw, document)).encode()
            path.write_bytes(data if draw.random() < 0.7 else mutated_text(draw, data))
        clip = read(path, rate=None if draw.random() < 0.5 and program != "OpenPose" else 30, gaps="keep")
        check(clip)
    return f"{program} is read"


KINDS: dict[str, Trial] = {"keypoints": keypoint_file}
