"""What the study's tests share: its clips, and one evaluation that was run."""

from __future__ import annotations

from pathlib import Path

import pytest

from study.clips.library import Library
from study.evaluations import v5
from study.evaluations.evaluation import Evaluation


@pytest.fixture(scope="session")
def captures(mocap: Path) -> Library:
    return Library(mocap)


@pytest.fixture(scope="session")
def lengthened(captures: Library) -> Evaluation:
    return v5.evaluate(captures, 1)
