"""`retime export`: a saved warp as the retime curve of another program."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import click

from retime.cli.clip_options import PATH, parsed
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.output_checks import check_outputs
from retime.cli.terminal import Stages, say_json, say_table
from retime.hosts.registry import HOST_NAMES, HOSTS
from retime.motion.grammar import parse_number
from retime.motion.rate import parse_rate

_EXAMPLES = (
    "\b\nHosts, and the ending of the file\n"
    + "".join(f"  {host.name.ljust(14)} {' '.join(host.suffixes).ljust(18)} {host.title}\n" for host in HOSTS)
    + "\n\b\nExamples\n"
    "  retime export warp.json -o retime.nk --host nuke --rate 24 --start 1001\n"
    "  retime export warp.json -o hips.py --host maya --rate 30 --item hips_translateX,hips_translateZ\n"
)


def read_tolerance(text: str) -> float:
    """Read a time of 0 or more."""
    return parse_number(text, least=0.0, unit="s")


@click.command(
    "export",
    cls=SectionedCommand,
    short_help="Write a saved warp as the retime curve of Nuke, Maya, After Effects, ...",
    epilog=_EXAMPLES,
)
@click.argument("warp", type=PATH, metavar="WARP.json")
@click.option("-o", "--output", cls=Option, metavar="FILE", type=PATH, required=True, help="Where to write the curve.")
@click.option(
    "--host",
    cls=Option,
    section="The curve",
    metavar="NAME",
    type=click.Choice(HOST_NAMES),
    required=True,
    help="The program, or the format; they are listed below.",
)
@click.option(
    "--rate",
    cls=Option,
    section="The curve",
    metavar="R",
    callback=parsed(parse_rate),
    help="Frames a second of the shot. A warp counts seconds; most programs count frames.",
)
@click.option(
    "--start",
    cls=Option,
    section="The curve",
    metavar="N",
    type=int,
    default_text="the program's custom, 0 or 1",
    help="The number of the shot's first frame, in the input and in the output.",
)
@click.option(
    "--tolerance",
    cls=Option,
    section="The curve",
    metavar="SECONDS",
    callback=parsed(read_tolerance),
    default_text="0.001",
    help="How far the curve may be off to do with fewer keys.",
)
@click.option(
    "--item",
    cls=Option,
    section="The curve",
    metavar="NAME",
    default="",
    help="The node, layer, clip or prim that it is for; of Maya, the animation curves.",
)
@click.option("--force", cls=Option, is_flag=True, help="Replace the file if it is there.")
@click.option("-q", "--quiet", cls=Option, is_flag=True, help="Print no summary.")
@click.option("--json", "as_json", cls=Option, is_flag=True, help="Print the summary as one JSON object.")
def command(
    *,
    warp: Path,
    output: Path,
    host: str,
    rate: Fraction | None,
    start: int | None,
    tolerance: float | None,
    item: str,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Write a warp that retime warp saved as the curve by which another program retimes the shot.

    The file is read back, and the largest difference from the warp is printed. What a program can't play (a hold, a
    span that runs backward) is refused.
    """
    check_outputs({"--output": output}, inputs=[warp], force=force)

    from retime.formats.warp_file import read_warp
    from retime.hosts.exporting import export_curve

    stages = Stages(quiet=quiet or as_json)
    with stages.stage("read", "reading"):
        found = read_warp(warp)
    with stages.stage("write", "writing"):
        done = export_curve(
            found, output, host, rate=rate, start=start, tolerance=tolerance, item=item, overwrite=force
        )
    if as_json:
        say_json(
            {
                "output": str(output),
                "host": done.host,
                "rate": None if rate is None else str(rate),
                "keys": done.keys,
                "error_seconds": done.error,
                "error_frames": done.error_frames,
            }
        )
    elif not quiet:
        say_table([("wrote", str(output)), ("keys", str(done.keys)), ("error", done.error_text)])
