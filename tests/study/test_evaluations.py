"""The evaluations: found by their files, measured figure by figure, and their promises on real captures."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import study.evaluations
from retime.evaluate.metrics.flights import path_warp
from study.clips.library import Library
from study.evaluations.registry import EVALUATIONS, PAPER, evaluation_files
from study.evaluations.v8 import evaluate as v8
from study.run import PARTS


def test_every_evaluation_of_the_paper_is_run() -> None:
    assert list(PAPER) == [f"V{i}" for i in range(1, 9)]
    assert set(PAPER) <= set(EVALUATIONS) <= set(PARTS)


def test_a_file_is_called_as_its_evaluation() -> None:
    assert {key.lower() for key in EVALUATIONS} == {one.__module__.split(".")[-1] for one in EVALUATIONS.values()}


def test_a_new_file_is_a_new_evaluation_in_its_place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("V9", "V10", "V7c"):
        text = f'KEY = "{name}"\nPAPER = None\n\n\ndef evaluate(clips, repeats):\n    return KEY\n'
        (tmp_path / f"{name.lower()}.py").write_text(text)
    monkeypatch.setattr(study.evaluations, "__path__", [*study.evaluations.__path__, str(tmp_path)])
    found = evaluation_files()
    for name in ("v9", "v10", "v7c"):
        del sys.modules[f"study.evaluations.{name}"]
    assert list(found)[-5:] == ["V7b", "V7c", "V8", "V9", "V10"]
    assert found["V10"].evaluate(None, 1) == "V10"


def test_v5_has_the_papers_sizes_and_keeps_its_jump(lengthened) -> None:
    size = lengthened.row
    assert (size.n_input, size.n_reference, size.max_skip) == (401, 101, 4)
    guided, linear = lengthened.version("guided").figures, lengthened.version("linear").figures
    assert guided["flight_frames_kept"] == guided["flight_frames"] > 10
    assert guided["gravity"] == pytest.approx(1.0, abs=0.02)
    assert linear["gravity"] == pytest.approx(1 / 1.5**2, rel=0.03)
    assert guided["keytimes_missed"] == pytest.approx(0.0, abs=1e-9)
    with pytest.raises(KeyError):
        lengthened.version("no such")


def test_v8_slows_every_flight_to_half(captures: Library) -> None:
    evaluation = v8(captures, 1)
    assert (evaluation.row.n_input, evaluation.row.heuristic) == (1524, None)
    figures = evaluation.version("guided").figures
    assert (figures["flight_slowest"], figures["flight_fastest"]) == pytest.approx((0.5, 0.5), abs=0.05)
    path = path_warp(evaluation.guided)
    assert path.slopes.min() >= 0.25
