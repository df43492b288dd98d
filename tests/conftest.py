"""What every test shares: how hypothesis runs, and where the motion-capture files are."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from hypothesis import settings

# A run of CI must not depend on luck; at a desk, new examples are worth more. No deadlines: machines are shared.
settings.register_profile("desk", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "desk")

MOCAP = Path(__file__).resolve().parents[1] / "../shared/mocap"


@pytest.fixture(scope="session")
def mocap() -> Path:
    """Give the folder of real motion-capture files beside the checkout."""
    if not MOCAP.is_dir():
        pytest.skip(f"needs the motion-capture files of {MOCAP}")
    return MOCAP.resolve()


@pytest.fixture(autouse=True, scope="session")
def interruptible() -> None:
    """Commands can be interrupted though the tests run in the background of a shell, which makes children ignore it."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
