"""Keypoint files with known contents, as detectors and those who use them write."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np


def openpose_people(poses: list[np.ndarray], confidence: list[np.ndarray]) -> dict[str, Any]:
    """Return what OpenPose writes of a frame: poses (n_points, 2), and how sure it is of each point."""
    people = []
    for pose, sure in zip(poses, confidence, strict=True):
        flat = np.column_stack([np.where(sure[:, None] > 0, pose, 0.0), sure]).ravel()
        people.append(
            {
                "person_id": [-1],
                "pose_keypoints_2d": flat.tolist(),
                "face_keypoints_2d": [],
                "hand_left_keypoints_2d": [],
                "pose_keypoints_3d": [],
            }
        )
    return {"version": 1.3, "people": people}


def write_openpose(folder: Path, frames: list[dict[str, Any]], *, take: str = "take", first: int = 0) -> Path:
    """Write a file a frame into a folder."""
    folder.mkdir(exist_ok=True)
    for number, frame in enumerate(frames, first):
        (folder / f"{take}_{number:012d}_keypoints.json").write_text(json.dumps(frame))
    return folder


def landmarks(poses: np.ndarray, *, visibility: float = 0.9) -> list[list[dict[str, float]]]:
    """Return what MediaPipe finds, frame by frame, of poses (n_frames, n_points, 3)."""
    return [
        [{"x": x, "y": y, "z": z, "visibility": visibility} for x, y, z in pose] for pose in np.asarray(poses).tolist()
    ]


def moving(n_frames: int, n_points: int, *, seed: int = 0, n_axes: int = 3) -> np.ndarray:
    """Return points that move smoothly, each on a path of its own."""
    chance = np.random.default_rng(seed)
    start, phase = chance.uniform(0.2, 0.8, (n_points, n_axes)), chance.uniform(0, 6, (n_points, n_axes))
    times = np.arange(n_frames)[:, None, None] / 10
    return start + 0.1 * np.sin(times + phase)
