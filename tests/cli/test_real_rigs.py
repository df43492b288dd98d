"""Every real clip that retime reads goes through the whole command: read, search, averaging, slip, write."""

from __future__ import annotations

import json
import warnings
from pathlib import Path

import numpy as np
import pytest

from retime import FormatWarning, read
from retime.motion.motion import Motion
from tests.conftest import MOCAP

# Without the folder one test remains, which skips.
CLIPS = sorted([*MOCAP.glob("**/*.bvh"), *MOCAP.glob("**/*.amc")]) or [MOCAP / "every clip"]
# A search for 9,000 frames at half the speed takes as long as all other clips together.
MOST_FRAMES = 3000


@pytest.mark.parametrize("clip", CLIPS, ids=lambda clip: clip.name)
@pytest.mark.parametrize("percent", [70, 150])
def test_a_clip_is_retimed_and_read_again(run, mocap, tmp_path, clip: Path, percent: int) -> None:
    output = f"out{clip.suffix}"
    with warnings.catch_warnings():
        # What files get wrong, and what they can't say, is told by other tests.
        warnings.simplefilter("ignore", FormatWarning)
        motion = read(clip)
        assert isinstance(motion, Motion)
        part = ["--frames", f"{motion.first_frame}:{motion.first_frame + MOST_FRAMES - 1}"]
        part = part if motion.n_frames > MOST_FRAMES else []
        line = ("warp", clip, "--length", f"{percent}%", *part, "-o", output, "--json")
        document = json.loads(run(*line).stdout)
        result = read(tmp_path / output)
    assert isinstance(result, Motion)
    n_frames = min(motion.n_frames, MOST_FRAMES)
    assert document["input_frames"] == n_frames
    assert abs(result.n_frames - n_frames * percent / 100) <= 0.5
    assert result.rate == motion.rate
    assert result.skeleton.names == motion.skeleton.names
    assert result.skeleton.parents == motion.skeleton.parents
    assert np.isfinite(result.rotations).all()
    assert np.isfinite(result.local_translations).all()
    # The first and the last pose are kept, as far as the format can hold them.
    for frame in (0, -1):
        within = n_frames - 1 if frame else 0
        turns = np.abs(np.sum(result.rotations[frame] * motion.rotations[within], axis=-1))
        assert np.degrees(2 * np.arccos(np.minimum(turns, 1.0))).max() < 0.5
