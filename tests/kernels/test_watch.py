"""Long kernels tell how far they are, and end where nobody wants their answer any more."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import threading
import time
from typing import Any

import numpy as np
import pytest

from retime.kernels import compiled_available
from retime.progress import look, watching
from retime.search.session import Session

pytestmark = pytest.mark.skipif(not compiled_available(), reason="NumPy's kernels are interrupted by Python itself")


class EnoughError(Exception):
    pass


# Each takes seconds where nothing ends it: with random poses no frame can be ruled out early.
LONG = {
    "scores": ({}, {"upsample": 8, "max_skip": 40}),
    "conditional scores": ({"score": "conditional", "n_neighbors": 64}, {"upsample": 8, "max_skip": 40}),
    "layered path": ({}, {"upsample": 4, "max_skip": 24, "search": "layered"}),
}


def session(seconds: float, **options: Any) -> Session:
    poses = np.random.default_rng(0).standard_normal((round(30 * seconds), 12)).cumsum(axis=0)
    return Session(poses, rate=30, **options)


@pytest.mark.parametrize("name", LONG)
def test_what_a_watcher_raises_ends_the_kernel_at_once(name: str) -> None:
    analysis, solve = LONG[name]
    searching = session(120, **analysis)
    raised: list[float] = []

    def tell(share: float) -> None:
        if math.isnan(share) or share > 0:
            raised.append(time.process_time())
            raise EnoughError

    with pytest.raises(EnoughError), watching(tell):
        searching.solve(length="150%", **solve)
    assert time.process_time() - raised[0] < 0.5
    # Nothing of it stays behind: the next search is whole.
    assert searching.solve(length="50%").path.optimal


def test_a_watcher_hears_of_progress_many_times_a_second() -> None:
    heard: list[tuple[float, float]] = []
    searching = session(60)
    with watching(lambda share: heard.append((time.monotonic(), share))):
        searching.solve(length="150%", upsample=8, max_skip=40)
    shares = [share for _, share in heard if not math.isnan(share)]
    assert len(heard) > 5
    assert all(0 <= share <= 1 for share in shares)
    assert max(shares) > 0.5


def test_threads_watch_for_themselves() -> None:
    others: list[float] = []
    with watching(others.append):
        thread = threading.Thread(target=look)
        thread.start()
        thread.join()
        look(0.25)
    look(0.5)
    assert others == [0.25]


def _processor_of_children() -> float:
    """Seconds that processes which have ended worked."""
    times = os.times()
    return times.children_user + times.children_system


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent another way there")
def test_ctrl_c_ends_a_kernel() -> None:
    child = subprocess.Popen(
        [
            sys.executable,
            "-c",
            "import numpy as np\n"
            "from retime.search.session import Session\n"
            "poses = np.random.default_rng(0).standard_normal((6000, 40)).cumsum(axis=0)\n"
            "session = Session(poses, rate=30)\n"
            "print('begun', flush=True)\n"
            "session.solve(length='150%', upsample=8, max_skip=40)\n",
        ],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "begun\n"
    # Inside of the kernel: alone it takes many seconds.
    with pytest.raises(subprocess.TimeoutExpired):
        child.wait(timeout=1)
    os.kill(child.pid, signal.SIGINT)
    before = _processor_of_children()
    _, errors = child.communicate(timeout=120)
    # All that it worked, from its start: of the processor, as a busy machine's clock says nothing.
    assert _processor_of_children() - before < 8
    assert child.returncode != 0
    assert "KeyboardInterrupt" in errors
