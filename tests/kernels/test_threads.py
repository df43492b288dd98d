"""Kernels that are called by several threads at once, each of which takes threads of its own: as if they were alone."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from retime.kernels import compiled_available
from retime.search.guided import guided_warp
from retime.search.result import GuidedWarp
from tests.warp.motions import wandering_motion


@pytest.mark.skipif(not compiled_available(), reason="there are no compiled kernels to share memory")
def test_searches_at_once_find_what_each_finds_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RETIME_THREADS", "3")
    wishes = [{"length": "70%"}, {"length": "120%", "loop": True}, {"length": "free"}, {"length": "60%", "upsample": 2}]

    def search(seed: int) -> GuidedWarp:
        return guided_warp(wandering_motion(24 + 5 * seed, seed=seed), **wishes[seed % len(wishes)])

    alone = [search(seed) for seed in range(6)]
    with ThreadPoolExecutor(6) as pool:
        together = list(pool.map(search, range(6)))
    for one, other in zip(alone, together, strict=True):
        assert one.warp == other.warp
        np.testing.assert_array_equal(one.path.scores, other.path.scores)
        assert one.path.total == other.path.total
