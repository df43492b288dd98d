"""A short run of the random requests; the whole of it is a command (`random_requests.py`)."""

from __future__ import annotations

import sys
import threading
from collections import Counter

import pytest

from tests.fuzz.random_requests import KINDS, limit, run


@pytest.mark.skipif(sys.platform == "win32", reason="its alarm is a signal that is not there")
@pytest.mark.skipif(threading.current_thread() is not threading.main_thread(), reason="alarms are for the main thread")
def test_each_request_is_kept_or_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in limit().items():
        monkeypatch.setenv(name, value)
    outcomes = [run(seed)[0] for seed in range(150)]
    assert [(one.seed, one.faults) for one in outcomes if one.faults] == []
    # All of them refused would say nothing.
    for asked in KINDS:
        ends = Counter(one.kind for one in outcomes if one.asked == asked)
        assert ends["kept"] >= 5
        assert ends["OptionError"] >= 3
        assert ends["InfeasibleWarpError"] >= 2
