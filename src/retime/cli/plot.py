"""`retime plot`: draw saved warps."""

from __future__ import annotations

from pathlib import Path

import click

from retime.cli.clip_options import PATH, ClipOptions, clip_options
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.output_checks import check_outputs, check_plot
from retime.cli.terminal import Stages, say

_EXAMPLES = "\b\nExamples\n  retime plot linear.json guided.json --motion walk.bvh -o compared.svg"


@click.command(
    "plot", cls=SectionedCommand, short_help="Draw saved warps: speed, time map, keytimes, poses.", epilog=_EXAMPLES
)
@click.argument("warps", type=PATH, metavar="WARP.json...", nargs=-1, required=True)
@click.option(
    "--motion",
    cls=Option,
    section="Input",
    metavar="CLIP",
    type=PATH,
    help="The clip that the warps are for: adds a strip of its poses. The next options say how to read it.",
)
@clip_options
@click.option(
    "-o",
    "--output",
    cls=Option,
    metavar="FILE",
    type=PATH,
    required=True,
    help="Where to write the picture (.svg, .pdf, .png).",
)
@click.option(
    "--title", cls=Option, metavar="TEXT", default="", default_text="the clip's name", help="Title of the picture."
)
@click.option("--force", cls=Option, is_flag=True, help="Replace the picture if it is there.")
@click.option("-q", "--quiet", cls=Option, is_flag=True, help="Print no summary.")
def command(
    *,
    warps: tuple[Path, ...],
    clip_options: ClipOptions,
    motion: Path | None,
    output: Path,
    title: str,
    force: bool,
    quiet: bool,
) -> None:
    """Draw warps that retime warp saved: speed, time map, keytimes, several compared."""
    given = [path for path in (motion, clip_options.skeleton) if path is not None]
    check_plot(output)
    check_outputs({"--output": output}, inputs=[*warps, *given], force=force)

    from retime.evaluate.plot.warps import plot_warps
    from retime.formats.warp_file import read_warp

    stages = Stages(quiet=quiet)
    with stages.stage("read", "reading"):
        named = {label: read_warp(path) for label, path in _labels(warps).items()}
        clip = None if motion is None else clip_options.read(motion)
    with stages.stage("plot", "drawing"):
        plot_warps(named, motion=clip, path=output, title=title, overwrite=force)
    if not quiet:
        say(f"{output}: {', '.join(named)}")


def _labels(paths: tuple[Path, ...]) -> dict[str, Path]:
    """Call each warp by its file's name, or by its whole path where names repeat."""
    unique = tuple(dict.fromkeys(paths))
    stems = [path.stem for path in unique]
    return {path.stem if stems.count(path.stem) == 1 else str(path): path for path in unique}
