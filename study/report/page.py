"""The report: one page that stands alone, with pictures, poses and script inside it."""

from __future__ import annotations

import base64
import html
import importlib.resources
from pathlib import Path

from study.evaluations.evaluation import Evaluation
from study.report.player import camera_player_html, player_html, player_script
from study.run import Results
from study.tables.all import tables
from study.tables.table import Table

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
    "set-first": (
        "Old and new defaults",
        "Every clip that defaults are chosen on, shortened and lengthened: by the linear warp, by the paper read "
        "literally, by the guided warp without natural hurry, and by the guided warp as it is by itself.",
    ),
    "set-second": (
        "The same on clips that no default was chosen on",
        "The second set was named before any choice was made, and is measured once.",
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
    "propagation": (
        "Recovery outside the example",
        "A hand retimed one stretch; the rest follows. How far apart left and right steps (flights and the rest, blows "
        "and the rest) come in log-speed where the hand never was, over how far they should: 1 is all of it. Mean, and "
        "the worst in brackets; the length of the output over the right one where it was free; and how much of the "
        "clip the example was said to speak for.",
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
    "signals": (
        "Beyond motion",
        "The warp found on V4's figure, applied to a camera at 24 Hz and to a curve at 50 Hz that were made for it; "
        "and a guided warp of two plain columns of numbers, a bouncing ball that rests and rolls between its flights.",
    ),
}


def report_html(results: Results, pictures: dict[str, Path]) -> str:
    """Write the page: pictures, poses and script all inside it."""
    shown = tables(results)
    style = importlib.resources.files("study.report").joinpath("page.css").read_text(encoding="utf-8")
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
