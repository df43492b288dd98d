"""The benchmarks run, at tiny sizes and without the peers; their page says what the results say. No time is judged."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PEERS = ("faiss", "gdtw", "numba", "pybvh", "sklearn")
RESULTS = ("sizes", "growth", "targets", "long_takes")


def _tool():
    spec = importlib.util.spec_from_file_location("make_performance", ROOT / "tools" / "make_performance.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Results of a quick run, with nothing to compare with."""
    folder = tmp_path_factory.mktemp("benchmarks")
    for peer in PEERS:
        (folder / f"{peer}.py").write_text(f"raise ModuleNotFoundError('hidden', name={peer!r})\n")
    python_path = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    for name in RESULTS:
        subprocess.run(
            [sys.executable, ROOT / "benchmarks" / f"bench_{name}.py", "--quick", "--results", folder],
            env={**os.environ, "PYTHONPATH": python_path},
            check=True,
            capture_output=True,
            text=True,
            timeout=240,
        )
    return {name: json.loads((folder / f"{name}.json").read_text()) for name in RESULTS}


def test_missing_peers_are_named(results) -> None:
    assert results["sizes"]["left_out"]["faiss flat"] == "faiss is not installed"
    assert results["sizes"]["left_out"]["gdtw"] == "gdtw is not installed"
    assert results["targets"]["rows"][0]["text"] == "sklearn is not installed"


def test_long_takes_are_compared_with_what_is_there(results) -> None:
    rows = {row["what"]: row for row in results["long_takes"]["rows"]}
    assert rows["reading and writing, against pybvh"]["text"] == "pybvh is not installed"
    still = rows["the same on a clip in which nothing moves, against one that moves"]
    assert set(still["ratios"]) == {"total", "processor"}
    assert rows["the most memory of the whole command, 600 frames"]["bytes"][0] > 1e7


def test_every_way_to_the_path_finds_the_same_total(results) -> None:
    path = results["growth"]["path_in_n"]
    n = len(path["layered"]["facts"])
    assert [f["total"] for f in path["priced"]["facts"][:n]] == [f["total"] for f in path["layered"]["facts"]]
    assert all(facts["optimal"] for facts in path["priced"]["facts"])


def test_the_page_can_be_made_of_the_results(results) -> None:
    page = _tool().page({"version": "0", **results})
    assert "| V1 | 50 |" in page
    assert "not measured" in page
    assert "## Long takes" in page


def test_the_page_is_up_to_date() -> None:
    tool = _tool()
    assert tool.PAGE.read_text(encoding="utf-8") == tool.page(tool.newest()), "run python tools/make_performance.py"
