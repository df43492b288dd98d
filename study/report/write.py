"""Writes what the study found into a folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from retime.files import write_bytes
from study.evaluations.registry import PAPER
from study.report.numbers import json_text, numbers
from study.report.page import report_html
from study.report.pictures import draw_answers, draw_evaluation, draw_signal, draw_speeds
from study.run import Results


@dataclass(frozen=True)
class Written:
    """What was written.

    Attributes
    ----------
    page, numbers : Path
        The report, and its JSON.
    figures : tuple of Path
        Pictures.
    """

    page: Path
    numbers: Path
    figures: tuple[Path, ...]


def write_study(results: Results, folder: Path) -> Written:
    """Write the report, its pictures and its numbers into a folder; what an earlier run left there is replaced."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures: dict[str, Path] = {}
    for evaluation in results.evaluations:
        pictures[evaluation.key] = folder / f"{evaluation.key.lower()}.png"
        draw_evaluation(evaluation, pictures[evaluation.key])
    if results.evaluations:
        pictures["speeds"] = folder / "speeds.svg"
        draw_speeds([one for one in results.evaluations if one.key in PAPER] or results.evaluations, pictures["speeds"])
    if results.answered:
        pictures["answers"] = folder / "answers.svg"
        draw_answers(results.answered, pictures["answers"])
    if results.ball is not None:
        pictures["signals"] = folder / "ball.png"
        draw_signal(results.ball, pictures["signals"])
    page, data = folder / "report.html", folder / "study.json"
    write_bytes(page, report_html(results, pictures).encode("utf-8"), overwrite=True)
    write_bytes(data, json_text(numbers(results)).encode("utf-8"), overwrite=True)
    return Written(page, data, tuple(pictures.values()))
