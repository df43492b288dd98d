"""`retime demo`: what it writes, and what its table says."""

from __future__ import annotations

import re

import numpy as np
import pytest

from retime import read, read_warp, write
from retime.cli import demo
from retime.motion.flights import flights
from tests.cli.figures import figure

NAMES = ["sample.bvh", "shorter.bvh", "warp.json", "warp.png", "warp.svg"]


def table(text: str) -> list[tuple[str, float, float, float]]:
    """Read the rows of the table: a label, seconds in the input, and in the output by linear and guided."""
    rows = re.findall(r"^(\S.*?) +([\d.]+) +([\d.]+) +([\d.]+)$", text, flags=re.MULTILINE)
    return [(label, float(given), float(linear), float(guided)) for label, given, linear, guided in rows]


@pytest.fixture
def quick_sample(tmp_path_factory, monkeypatch):
    """Put the figure of these tests in place of the sample, and leave the pictures out."""
    place = tmp_path_factory.mktemp("sample") / "figure.bvh"
    write(figure(), place)
    phases = b'[{"name": "walk and jump", "first_frame": 0, "last_frame": 240}]'
    shipped = {"sample.bvh": place.read_bytes(), "sample_phases.json": phases}
    monkeypatch.setattr(demo, "_shipped", shipped.__getitem__)
    find_spec = demo.importlib.util.find_spec
    monkeypatch.setattr(
        demo.importlib.util, "find_spec", lambda name: None if name == "matplotlib" else find_spec(name)
    )


def test_without_matplotlib_it_writes_all_but_the_pictures(run, tmp_path, quick_sample) -> None:
    result = run("demo", "--out", "deep/er")
    assert sorted(path.name for path in (tmp_path / "deep/er").iterdir()) == NAMES[:3]
    assert "pip install 'retime[plot]'" in result.stdout
    assert read(tmp_path / "deep/er/shorter.bvh").n_frames == 157


def test_the_default_folder_and_force(run, tmp_path, quick_sample) -> None:
    first = run("demo")
    assert (tmp_path / "retime-demo" / "warp.json").exists()
    assert "exists already" in run("demo", code=1).stderr
    assert run("demo", "--force").stdout == first.stdout


def test_a_file_where_the_folder_should_be(run, tmp_path, quick_sample) -> None:
    (tmp_path / "out").write_text("")
    assert "out" in run("demo", "--out", "out", code=1).stderr


def test_the_sample_keeps_its_jumps_and_gives_up_its_pauses(run, tmp_path) -> None:
    result = run("demo", "--out", "out")
    out = tmp_path / "out"
    assert sorted(path.name for path in out.iterdir()) == NAMES
    sample, shorter = read(out / "sample.bvh"), read(out / "shorter.bvh")
    assert shorter.n_frames == round(0.65 * sample.n_frames)
    assert shorter.skeleton.names == sample.skeleton.names

    rows = table(result.stdout)
    assert [label for label, *_ in rows].count("flight") == 2
    for label, given, linear, guided in rows:
        assert linear == pytest.approx(0.65 * given, abs=0.02)
        if label == "flight":
            assert guided == pytest.approx(given, abs=0.011)
    still, whole = rows[-2:]
    assert still[0] == "standing still, in all"
    assert still[3] < 0.5 * still[2]
    assert whole[3] == whole[2]
    assert "flights, linear: 0 of 2 kept at unit speed; input " in result.stdout
    assert "flights, guided: 2 of 2 kept at unit speed\n" in result.stdout

    jumps = flights(sample)
    assert len(jumps) == 2
    warp = read_warp(out / "warp.json")
    for first, last in jumps:
        middle = np.arange(first + 2, last - 2) / float(sample.rate)
        np.testing.assert_allclose(warp.speed(warp.inverse()(middle)), 1.0, atol=1e-6)
    assert [last - first for first, last in flights(shorter)] == pytest.approx(
        [last - first for first, last in jumps], abs=2
    )
