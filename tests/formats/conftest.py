"""What several tests of formats read."""

from __future__ import annotations

import pytest

from retime.motion.motion import Motion
from tests.formats.amc_files import AMC, read_amc


@pytest.fixture
def plain() -> Motion:
    """Three frames of an arm, in an AMC without quirks."""
    return read_amc(AMC / "plain.amc")
