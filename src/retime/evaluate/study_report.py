"""Writes what the study found: one page that stands alone, pictures, and all numbers as JSON."""

from __future__ import annotations

import base64
import html
import importlib.resources
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from retime.evaluate.study import PAPER, Evaluation
from retime.evaluate.study_choices import SETTINGS
from retime.evaluate.study_figures import draw_answers, draw_evaluation, draw_signal, draw_speeds
from retime.evaluate.study_player import camera_player_html, player_html, player_script
from retime.evaluate.study_run import Results
from retime.evaluate.study_tables import (
    Table,
    answer_times_table,
    answers_table,
    figures_table,
    losses_table,
    plain,
    prototype_table,
    sensitivity_table,
    signals_table,
    sizes_table,
    text_values,
)
from retime.files import write_bytes

_CREDIT = (
    "The data used in this project was obtained from mocap.cs.cmu.edu. The database was created with funding from NSF "
    "EIA-0196217. BVH conversions by Bruce Hahne (cgspeed). Boxing_Toes.bvh: Open Asset Import Library, BSD 3-Clause. "
    "test_mocapbank.bvh: bvh-python, MIT, Copyright (c) 2017 20tab srl."
)

_ABOUT = {
    "speeds": (
        "Speeds",
        "Playback speed of every guided warp over output time, on the scale of the paper's Figure 5: a tenth to ten "
        "times, with unit speed as the line in the middle. Thin: the path as it was found; thick: the warp, smoothed. "
        "Flights are shaded.",
    ),
    "sizes": (
        "Table 1",
        "Sizes and times, with the paper's own row below each. Objective: the local scores. Search: the exact one that "
        "retime uses. Recurrence: the paper's own, which finds the same path. Heuristic: the paper's coarse search "
        "with its keytimes, and by how much its result exceeds the optimum.",
    ),
    "answers": (
        "Known answers",
        "Every cycle (jump, blow) of a clip was warped by hand in the same way; the method was given one of them. "
        "Correlation of log-speed with the answer's, where the answer has something to say (shaded in the picture).",
    ),
    "answer-times": (
        "Known answers, in time",
        "By how many frames (at 30 Hz) poses come too early or too late within each of those stretches; in brackets "
        "the length of the whole output, where it was not given, over the right one.",
    ),
    "sensitivity": (
        "What each choice is worth",
        "In-flight frames kept at exactly unit speed when eleven clips with jumps are shortened and lengthened (high "
        "flights: 15 cm off the ground), mean correlation with the known answers, and root mean square error of "
        "log-speed at the given length and at a free one. Below the main choices, one is changed at a time. The bold "
        "row is the default.",
    ),
    "losses": (
        "Where flights are lost",
        "In-flight frames kept, clip by clip: by default, and with the paper's features read literally.",
    ),
    "prototype": (
        "Beside the prototype",
        "Figures of a prototype that went before this package, and the package's own. Its clips and its test for "
        "flights were not quite the same: what is compared here are high flights, 15 cm off the ground.",
    ),
    "signals": (
        "Beyond motion",
        "The warp found on V4's figure, applied to a camera at 24 Hz and to a curve at 50 Hz that were made for it; "
        "and a guided warp of two plain columns of numbers, a bouncing ball that rests and rolls between its flights.",
    ),
}


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


def tables(results: Results) -> dict[str, Table]:
    """Lay out every number that a reader is shown, by name."""
    found = {evaluation.key: figures_table(evaluation) for evaluation in results.evaluations}
    if results.evaluations:
        found["sizes"] = sizes_table(results.evaluations)
    if results.answered:
        found["answers"] = answers_table(results.answered)
        found["answer-times"] = answer_times_table(results.answered)
    if results.sensitivity:
        found["sensitivity"] = sensitivity_table(results.sensitivity)
        found["losses"] = losses_table(results.sensitivity)
    if results.prototype:
        found["prototype"] = prototype_table(results.prototype)
    if results.camera is not None and results.curve is not None and results.ball is not None:
        found["signals"] = signals_table(results.camera, results.curve, results.ball)
    return found


def numbers(results: Results) -> dict[str, Any]:
    """Collect all numbers for JSON; what is not finite is null."""
    return {
        "format": "retime-study",
        "version": 1,
        "machine": results.machine,
        "seconds": round(results.seconds, 1),
        "settings": plain(SETTINGS),
        "evaluations": [_evaluation_numbers(one) for one in results.evaluations],
        "answers": plain(results.answered),
        "sensitivity": plain(results.sensitivity),
        "camera": plain(results.camera),
        "prototype": plain(results.prototype),
        "curve": plain(results.curve),
        "ball": plain(results.ball),
        "values": text_values(results.sensitivity if results.prototype else (), results.evaluations),
        "tables": {name: plain(table) for name, table in tables(results).items()},
    }


def _evaluation_numbers(evaluation: Evaluation) -> dict[str, Any]:
    left_out = ("versions", "about")
    versions = [
        {"label": one.label, "note": one.note, "warp": plain(one.warp), "figures": plain(one.figures)}
        for one in evaluation.versions
    ]
    return {name: value for name, value in plain(evaluation).items() if name not in left_out} | {"versions": versions}


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
    write_bytes(data, _json(numbers(results)).encode("utf-8"), overwrite=True)
    return Written(page, data, tuple(pictures.values()))


def _json(document: dict[str, Any]) -> str:
    """Write one line for each part, and for each item of a list or table in it: compact, and fit to be compared."""

    def flat(value: Any) -> str:
        return json.dumps(value, separators=(",", ":"), allow_nan=False, ensure_ascii=False)

    def part(value: Any) -> str:
        if isinstance(value, list) and value:
            return "[\n" + ",\n".join(flat(one) for one in value) + "\n]"
        if isinstance(value, dict) and value:
            return "{\n" + ",\n".join(f"{flat(name)}:{flat(one)}" for name, one in value.items()) + "\n}"
        return flat(value)

    return "{\n" + ",\n".join(f"{flat(name)}:{part(value)}" for name, value in document.items()) + "\n}\n"


def report_html(results: Results, pictures: dict[str, Path]) -> str:
    """Write the page: pictures, poses and script all inside it."""
    shown = tables(results)
    style = importlib.resources.files("retime.evaluate").joinpath("study_report.css").read_text(encoding="utf-8")
    sections = [_evaluation_section(one, shown, pictures) for one in results.evaluations]
    players = {} if results.camera is None else {"signals": camera_player_html(results.camera)}
    sections += [
        _part_section(name, shown, pictures, players.get(name, ""))
        for name in _ABOUT
        if name in shown or name in pictures
    ]
    links = [(one.key, one.key) for one in results.evaluations]
    links += [(name, about[0]) for name, about in _ABOUT.items() if name in shown or name in pictures]
    menu = "".join(f'<a href="#{name}">{html.escape(text)}</a>' for name, text in links)
    where = ", ".join(f"{name} {value}" for name, value in results.machine.items())
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>Guided time warping: the eight evaluations</title>
<style>
{style}</style>
</head>
<body>
<main>
<header>
<h1>Guided time warping: the eight evaluations</h1>
<p>V1 to V8 of Hsu, da Silva and Popović (2007), run with retime on public motion capture, at sizes as near to the
paper's Table 1 as the clips allow. Each is shown beside what else a person could do. The figures play side by side on
one clock; drag one sideways to look from elsewhere. Under each figure runs its playback speed, on a log scale from a
tenth to ten times. A figure is orange while it is in flight. What each number means, and where the method fails, is
told in docs/study.</p>
</header>
<nav aria-label="parts">{menu}</nav>
{"".join(sections)}
<footer><p>{html.escape(_CREDIT)}</p><p>Made in {results.seconds:.0f} s ({html.escape(where)}).</p></footer>
</main>
<script>
{player_script()}</script>
</body>
</html>
"""


def _evaluation_section(evaluation: Evaluation, shown: dict[str, Table], pictures: dict[str, Path]) -> str:
    return f"""<section id="{evaluation.key}">
<h2><span class="key">{evaluation.key}</span>{html.escape(evaluation.title)}</h2>
<p>{html.escape(evaluation.about)}</p>
<p class="clip">{html.escape(evaluation.clip)}</p>
{player_html(evaluation)}
{shown[evaluation.key].html()}
{_picture(pictures[evaluation.key], f"{evaluation.key}: playback speed, time map and poses of every version")}
</section>
"""


def _part_section(name: str, shown: dict[str, Table], pictures: dict[str, Path], player: str) -> str:
    title, about = _ABOUT[name]
    table = shown[name].html() if name in shown else ""
    picture = _picture(pictures[name], title) if name in pictures else ""
    head = f"<h2>{html.escape(title)}</h2><p>{html.escape(about)}</p>"
    return f'<section id="{name}">{head}{player}{table}{picture}</section>\n'


def _picture(path: Path, text: str) -> str:
    kind = {".png": "image/png", ".svg": "image/svg+xml"}[path.suffix]
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return f'<img alt="{html.escape(text)}" src="data:{kind};base64,{data}">'
