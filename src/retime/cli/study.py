"""`retime study`: the paper's eight evaluations, run on a folder of captures."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import click

from retime.cli.clip_options import PATH
from retime.cli.sections import Option, SectionedCommand
from retime.cli.terminal import Stages, say
from retime.errors import MissingExtraError


@click.command("study", cls=SectionedCommand, short_help="Run the paper's eight evaluations on captures.")
@click.option(
    "--data",
    cls=Option,
    section="What",
    metavar="DIR",
    type=PATH,
    required=True,
    help="Folder of captures, laid out as docs/study says.",
)
@click.option(
    "--only",
    cls=Option,
    section="What",
    metavar="PARTS",
    help="Some parts, with commas between them: V1 to V8, V6b, V7b, answers, sensitivity, signals.",
)
@click.option(
    "--quick",
    cls=Option,
    section="What",
    is_flag=True,
    help="Time everything once, and compare the main settings alone.",
)
@click.option(
    "--out",
    cls=Option,
    metavar="DIR",
    type=PATH,
    default="retime-study",
    default_text="retime-study",
    help="Folder to write to; made if it is not there. What an earlier run left there is replaced.",
)
def command(*, data: Path, only: str | None, quick: bool, out: Path) -> None:
    """Run the paper's eight evaluations on real motion, and write what came out.

    Writes a page that plays every result beside what else one could do (it stands alone: open it in a browser),
    pictures, and all numbers as JSON.
    """
    from retime.evaluate.study_motions import Library, missing_files
    from retime.evaluate.study_run import chosen_parts, run

    parts = chosen_parts(only)
    if importlib.util.find_spec("matplotlib") is None:
        raise MissingExtraError("the study's pictures", package="matplotlib", extra="plot")
    missing = missing_files(data)
    if missing:
        raise FileNotFoundError(2, f"--data: the study needs this file ({len(missing)} missing)", str(missing[0]))

    from retime.evaluate.study_report import write_study

    results = run(Library(data), parts, quick=quick, say=lambda part: say(f"running: {part}"))
    stages = Stages()
    with stages.stage("write", "writing"):
        written = write_study(results, out)
    for place in (written.page, written.numbers, *written.figures):
        say(f"wrote {place}")
    say(f"It took {results.seconds + sum(stages.seconds.values()):.0f} s.")
