"""`retime report`: a file to attach to an issue, for a clip that is refused or read wrongly."""

from __future__ import annotations

from pathlib import Path

import click

from retime.cli.clip_options import PATH, ClipOptions, clip_options
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.output_checks import check_outputs
from retime.cli.terminal import say
from retime.errors import OptionError, OutputExistsError, RetimeError

_EXAMPLES = (
    "\b\nExamples\n  retime report broken.bvh\n  retime report walk.c3d -o walk-report.zip\n"
    "  retime report table.csv --keep LeftFoot --keep RightFoot"
)
_PLACE = Path("retime-report.zip")


@click.command(
    "report",
    cls=SectionedCommand,
    short_help="Make a file for an issue, of a clip that is refused or read wrongly.",
    epilog=_EXAMPLES,
)
@click.argument("clip", type=PATH)
@clip_options
@click.option(
    "-o",
    "--output",
    cls=Option,
    metavar="ZIP",
    type=PATH,
    default_text=str(_PLACE),
    help="Where to write the report. No file is ever replaced.",
)
@click.option(
    "--keep",
    cls=Option,
    metavar="WORD",
    multiple=True,
    help="A word of the file that is no secret and stays; repeat for more. For a fault that hangs on a name.",
)
def command(*, clip: Path, clip_options: ClipOptions, output: Path | None, keep: tuple[str, ...]) -> None:
    """Make a small file to attach to an issue, of a CLIP that is refused or read wrongly.

    It holds what happened, the versions, and the clip without names (joints, channels, markers, nodes, files, comments)
    and with few of its frames, tried to behave in the same way when it is read. What it holds is printed; nothing is
    sent.
    """
    from retime.cli.info import build_facts
    from retime.issue_report.report import Reading, make_report
    from retime.media.kinds import is_media

    if is_media(clip):
        raise OptionError(f"{clip} is video, pictures or sound, which can't be stripped of what they show: describe it")
    if clip.is_dir():
        raise OptionError(f"{clip} is a folder of files: make a report of one of them")
    if clip_options.frames is not None or clip_options.drop_first:
        raise OptionError("--frames and --drop-first have no place in a report, which chooses frames itself")
    place = output or _PLACE
    try:
        check_outputs({"--output": place}, inputs=[clip], force=False)
    except OutputExistsError as error:
        # Its own words name an option that this command does not have.
        raise RetimeError(
            f"{place}: exists already, and a report replaces nothing: name another place with -o"
        ) from error
    from retime.files import write_bytes

    reading = Reading(clip_options.read_options(), clip_options.up, clip_options.root)
    report = make_report(clip, reading, build=build_facts(), keep=keep)
    write_bytes(place, report.archive(), overwrite=False)
    say(report.text)
    if report.stayed:
        say("Words of the file that stay: " + ", ".join(report.stayed) + "\n")
    say(f"{place}: this, and nothing else, is in it; look at the files before you attach it to an issue.")
