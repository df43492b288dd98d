"""`retime import`: the retime curve of another program as a warp."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import click

from retime.cli.clip_options import PATH, parsed
from retime.cli.export_curve import read_tolerance
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.output_checks import check_outputs
from retime.cli.terminal import Stages, say_json, say_table
from retime.hosts.registry import HOSTS, IMPORTED
from retime.motion.rate import parse_rate

_EXAMPLES = (
    "\b\nHosts, and the ending of the file\n"
    + "".join(f"  {host.name.ljust(14)} {' '.join(host.suffixes)}\n" for host in HOSTS if host.imports)
    + "\n\b\nExamples\n"
    "  retime import ramp.nk --rate 24 --start 1001 -o warp.json\n"
    "  retime import edit.fcpxml --item 'Shot 12' -o warp.json\n"
)


@click.command(
    "import",
    cls=SectionedCommand,
    short_help="Read a retime curve of Nuke, Maya, Final Cut, ... as a warp.",
    epilog=_EXAMPLES,
)
@click.argument("curve", type=PATH, metavar="CURVE")
@click.option(
    "-o", "--output", cls=Option, metavar="WARP.json", type=PATH, required=True, help="Where to write the warp."
)
@click.option(
    "--host",
    cls=Option,
    section="The curve",
    metavar="NAME",
    type=click.Choice(IMPORTED),
    default_text="by the ending",
    help="The program, or the format, that the curve is of; they are listed below.",
)
@click.option(
    "--rate",
    cls=Option,
    section="The curve",
    metavar="R",
    callback=parsed(parse_rate),
    help="Frames a second that it counts, where the file itself does not say.",
)
@click.option(
    "--start",
    cls=Option,
    section="The curve",
    metavar="N",
    type=int,
    default_text="the program's custom, 0 or 1",
    help="The number of the shot's first frame, in the input and in the output: time 0 of the warp.",
)
@click.option(
    "--tolerance",
    cls=Option,
    section="The curve",
    metavar="SECONDS",
    callback=parsed(read_tolerance),
    default_text="0.001",
    help="How far off the lines may be that a rounded curve (of Maya, of Lottie) is drawn by.",
)
@click.option(
    "--item",
    cls=Option,
    section="The curve",
    metavar="NAME",
    default="",
    help="Which curve, where the file has several: its node, layer, track or clip.",
)
@click.option("--force", cls=Option, is_flag=True, help="Replace the warp if it is there.")
@click.option("-q", "--quiet", cls=Option, is_flag=True, help="Print no summary.")
@click.option("--json", "as_json", cls=Option, is_flag=True, help="Print the summary as one JSON object.")
def command(
    *,
    curve: Path,
    output: Path,
    host: str | None,
    rate: Fraction | None,
    start: int | None,
    tolerance: float | None,
    item: str,
    force: bool,
    quiet: bool,
    as_json: bool,
) -> None:
    """Read a retime curve that was drawn elsewhere as a warp: to apply, to plot, or as an example for retime imitate.

    What is no curve, or jumps, or is a spline that only its program knows, is refused, with its place.
    """
    check_outputs({"--output": output}, inputs=[curve], force=force)

    from retime.formats.warp_file import write_warp
    from retime.hosts.importing import import_curve

    stages = Stages(quiet=quiet or as_json)
    with stages.stage("read", "reading"):
        warp = import_curve(curve, host, rate=rate, start=start, tolerance=tolerance, item=item)
    with stages.stage("write", "writing"):
        write_warp(warp, output, overwrite=force)
    low, high = float(warp.input_times.min()), float(warp.input_times.max())
    if as_json:
        say_json(
            {
                "output": str(output),
                "knots": len(warp.output_times),
                "output_times": list(warp.domain),
                "input_times": [low, high],
                "slowest": float(warp.slopes.min()),
                "fastest": float(warp.slopes.max()),
            }
        )
    elif not quiet:
        say_table(
            [
                ("wrote", str(output)),
                ("knots", str(len(warp.output_times))),
                ("output", f"{warp.output_start:g} to {warp.output_end:g} s"),
                ("input", f"{low:g} to {high:g} s"),
                ("speed", f"{warp.slopes.min():.3g} to {warp.slopes.max():.3g}"),
            ]
        )
