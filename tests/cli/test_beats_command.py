"""`retime warp --keys-from`: accents of a clip on beats."""

from __future__ import annotations

import json

import numpy as np
import pytest

from retime import Signal, read_warp, write


@pytest.fixture
def dance(tmp_path):
    """Swing at two peaks of speed a second."""
    times = np.arange(0, 8, 1 / 30)
    values = np.stack([np.sin(2 * np.pi * times), 0.3 * np.sin(4 * np.pi * times + 1)], axis=1)
    write(Signal(("a", "b"), values, 30), tmp_path / "dance.csv")
    return "dance.csv"


def test_a_dance_is_set_to_another_tempo(run, tmp_path, dance) -> None:
    (tmp_path / "beats.csv").write_text("time,name\n" + "".join(f"{0.6 * k:.3f},b{k}\n" for k in range(1, 30)))
    result = run("warp", dance, "--keys-from", "beats.csv", "-o", "set.csv", "--save", "w.json")
    assert "of 29 met" in result.stdout
    assert "peak at" in result.stdout
    said = json.loads(run("warp", dance, "--keys-from", "beats.csv", "--json").stdout)["beats"]
    met = [one for one in said if one["accent"] is not None]
    assert len(said) == 29
    assert len(met) >= 12
    warp = read_warp(tmp_path / "w.json")
    for one in met:
        # Each to a frame of the analysis.
        assert float(warp(one["beat"])) == pytest.approx(one["accent"], abs=1 / 30)
    steps = np.diff([one["accent"] for one in met]) / np.diff([one["beat"] for one in met])
    assert np.median(steps) == pytest.approx(0.5 / 0.6, rel=0.05)


def test_a_length_and_a_keytime_hold_beside_beats(run, tmp_path, dance) -> None:
    (tmp_path / "beats.csv").write_text("".join(f"{0.55 * k:.3f}\n" for k in range(1, 30)))
    run("warp", dance, "--keys-from", "beats.csv", "--length", "9s", "--key", "4=4.5", "--save", "w.json", "-q")
    warp = read_warp(tmp_path / "w.json")
    assert warp.count_frames(30) == 270
    assert float(warp(4.5)) == pytest.approx(4.0, abs=1e-6)


def test_what_can_not_be_is_said(run, tmp_path, dance) -> None:
    (tmp_path / "late.csv").write_text("500\n")
    assert "no accent" in run("warp", dance, "--keys-from", "late.csv", "--length", "50%", code=3).stderr
    assert "--keys-on needs" in run("warp", dance, "--keys-on", "onsets", code=2).stderr
    assert "--length free" in run("warp", dance, "--keys-from", "late.csv", "--length", "free", code=2).stderr
    refused = run("warp", dance, "--keys-from", "late.csv", "--method", "align", "--reference", dance, code=2)
    assert "can't be combined" in refused.stderr
    assert "--keys-from" in run("warp", dance, "--keys-from", "late.csv", "--variants", "2", code=2).stderr
