"""Archives of SMPL bodies made for tests."""

from __future__ import annotations

import io
from typing import Any

import numpy as np


def npz(members: dict[str, Any], *, compressed: bool = False) -> bytes:
    file = io.BytesIO()
    (np.savez_compressed if compressed else np.savez)(file, **members)
    return file.getvalue()


def body(seed: int = 0, *, n_frames: int = 40, joints: int = 52, dtype: str = "f8", **more: Any) -> dict[str, Any]:
    """A body that turns smoothly, some of its joints past half a turn, and walks on."""
    rng = np.random.default_rng(seed)
    times = np.arange(n_frames)[:, None] / 60
    waves = rng.normal(size=(1, 3 * joints)) * np.sin(
        times * rng.uniform(2, 7, 3 * joints) + rng.uniform(0, 6, 3 * joints)
    )
    poses = 0.8 * waves
    # The pelvis turns on and on.
    poses[:, :3] = np.array([0.2, 0.1, 1.0]) * (2.5 + 4 * times)
    trans = np.column_stack([times[:, 0], 0.1 * np.sin(9 * times[:, 0]), 0.9 + 0.05 * np.cos(9 * times[:, 0])])
    return {
        "poses": poses.astype(dtype),
        "trans": trans.astype(dtype),
        "betas": rng.normal(size=16),
        "dmpls": rng.normal(size=(n_frames, 8)).astype(dtype),
        "gender": np.array("neutral"),
        "mocap_framerate": np.array(60.0),
        **more,
    }


def smplx(seed: int = 0, **more: Any) -> dict[str, Any]:
    """As the second release of AMASS has it: parts of the poses beside them."""
    members = body(seed, joints=55, **more)
    poses, n_frames = members["poses"], len(members["poses"])
    del members["dmpls"], members["mocap_framerate"]
    parts = {
        "root_orient": (0, 3),
        "pose_body": (3, 66),
        "pose_jaw": (66, 69),
        "pose_eye": (69, 75),
        "pose_hand": (75, 165),
    }
    return {
        **members,
        **{name: poses[:, start:stop] for name, (start, stop) in parts.items()},
        "num_betas": np.array(16),
        "surface_model_type": np.array("smplx"),
        "mocap_frame_rate": np.array(60.0),
        "mocap_time_length": np.array(n_frames / 60),
    }
