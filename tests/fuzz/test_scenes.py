"""A short run of the mutants of scenes."""

from __future__ import annotations

import pytest

from tests.fuzz.scenes import run


@pytest.mark.parametrize(("kind", "count"), [("gltf", 600), ("fbx", 150), ("fbx-text", 150)])
def test_mutants_are_read_or_refused(kind: str, count: int) -> None:
    outcomes = run(count, seed=1, kind=kind)
    assert outcomes["refused"] > count / 6
    assert outcomes["retimed"] > count / 12
