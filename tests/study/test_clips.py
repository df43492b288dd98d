"""Clips: the files that are named, steps of a walk, blows."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from retime.errors import OptionError
from study.clips.blows import fast_spans, wrists
from study.clips.library import Library, read_sample
from study.clips.sources import FIRST, SECOND, SOURCES, missing_files
from study.clips.walks import steps, walking_spans
from tests.evaluate.figures import jumper
from tests.motion.walkers import renamed

SAMPLE = read_sample()


def test_steps_of_a_walk_alternate() -> None:
    for start, end in walking_spans(SAMPLE):
        sides = [step.side for step in steps(SAMPLE) if start - 1e-9 <= step.time <= end + 1e-9]
        assert all(a != b for a, b in itertools.pairwise(sides))
        assert len(sides) >= 3


def test_blows_are_where_a_joint_is_fastest() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    feet = [name for name in motion.skeleton.names if "Foot" in name]
    # A thrown body is fastest when it leaves the ground and when it meets it again, after half a second.
    (up, slower), (faster, down) = fast_spans(motion, feet)
    assert (up, down) == pytest.approx((1.0, 1.5), abs=0.04)
    assert slower - up == pytest.approx(down - faster, abs=0.02)
    assert slower - up + down - faster == pytest.approx(0.15 * motion.end_time, abs=0.04)


def test_wrists_have_the_names_of_either_kind_of_file() -> None:
    motion = jumper(lead=1.0, rest=1.0)
    with pytest.raises(OptionError, match="jumper has no joints that are known to be wrists"):
        wrists(motion)
    feet = {"LeftFoot": "lwrist", "RightFoot": "rwrist"}
    assert wrists(renamed(motion, feet)) == ("lwrist", "rwrist")
    assert wrists(renamed(motion, {"LeftFoot": "LeftWrist", "RightFoot": "RightWrist"})) == ("LeftWrist", "RightWrist")


def test_every_file_that_is_named_is_there(mocap: Path) -> None:
    assert all((mocap / source.path).is_file() for source in SOURCES.values())
    assert missing_files(mocap) == []
    assert len(missing_files(mocap / "nowhere")) == len(SOURCES)


def test_the_second_set_shares_no_frame_with_the_first(mocap: Path) -> None:
    assert len(SECOND) >= 12
    assert not FIRST.keys() & SECOND.keys()
    shared = {one.path for one in FIRST.values()} & {one.path for one in SECOND.values()}
    assert shared == {"cmu-asfamc/86_01.amc"}
    assert SECOND["86_01, later"].drop_first == FIRST["86_01"].frames
    clips = Library(mocap)
    for name in SECOND:
        assert 1 <= clips[name].duration < 60
        assert clips[name].skeleton.n_joints > 15
