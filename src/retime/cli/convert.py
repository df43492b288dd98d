"""`retime convert`: read a clip in one format, write it in another."""

from __future__ import annotations

from pathlib import Path

import click

from retime.cli.clip_options import PATH, ClipOptions, clip_options
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.output_checks import check_format, check_outputs
from retime.cli.terminal import Stages, say

_EXAMPLES = "\b\nExamples\n  retime convert 86_01.amc walk.bvh --frames 1:550 --fps 120"


@click.command(
    "convert", cls=SectionedCommand, short_help="Read a clip in one format and write it in another.", epilog=_EXAMPLES
)
@click.argument("clip", type=PATH, metavar="A")
@click.argument("output", type=PATH, metavar="B")
@clip_options
@click.option("--force", cls=Option, is_flag=True, help="Replace B if it is there; never A.")
@click.option("-q", "--quiet", cls=Option, is_flag=True, help="Print no summary.")
def command(*, clip: Path, output: Path, clip_options: ClipOptions, force: bool, quiet: bool) -> None:
    """Read clip A and write it to B, in the format that B's ending names.

    Also cuts (--frames, --drop-first) and corrects the rate (--fps). The timing stays.
    """
    skeletons = [] if clip_options.skeleton is None else [clip_options.skeleton]
    check_outputs({"B": output}, inputs=[clip, *skeletons], force=force)
    check_format(output, like=clip)

    from retime.cli.summary import length_text, rate_text
    from retime.formats.registry import write

    stages = Stages(quiet=quiet)
    with stages.stage("read", "reading"):
        motion = clip_options.read(clip)
    with stages.stage("write", "writing"):
        write(motion, output, overwrite=force)
    if not quiet:
        say(f"{output}: {length_text(motion.n_frames, motion.rate)} at {rate_text(motion.rate)}")
