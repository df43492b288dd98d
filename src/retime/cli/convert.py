"""`retime convert`: read a clip in one format, write it in another."""

from __future__ import annotations

import warnings
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import click

from retime.cli.clip_options import PATH, ClipOptions, clip_options, parsed, resampled
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.output_checks import check_holds_like, check_outputs
from retime.cli.output_options import held_frames, on_option, on_twos_option
from retime.cli.terminal import Stages, say
from retime.errors import FormatWarning, OptionError
from retime.motion.rate import parse_rate

if TYPE_CHECKING:
    from retime.motion.joint_signal import JointSpace

_EXAMPLES = (
    "\b\nExamples\n  retime convert 86_01.amc walk.bvh --frames 1:550 --fps 120\n"
    "  retime convert walk.bvh film.bvh --rate 24 --on-twos\n"
    "  retime convert walk.bvh walk.csv --space heading"
)
# As retime.motion.joint_signal has them, which the help need not wait for.
_SPACES = ("global", "torso", "heading", "local")


@click.command(
    "convert", cls=SectionedCommand, short_help="Read a clip in one format and write it in another.", epilog=_EXAMPLES
)
@click.argument("clip", type=PATH, metavar="A")
@click.argument("output", type=PATH, metavar="B")
@clip_options
@click.option(
    "--rate",
    cls=Option,
    metavar="R",
    callback=parsed(parse_rate),
    default_text="that of A",
    help="Frames a second of B: frames are made where they stand in time, so that B plays as A does. (--fps corrects "
    "what A says of itself.)",
)
@on_twos_option
@on_option
@click.option(
    "--rotations",
    cls=Option,
    section="A motion as a table",
    is_flag=True,
    help="Write the joints' rotations as quaternions (Hips.qw ...), not their positions (Hips.x ...).",
)
@click.option(
    "--space",
    cls=Option,
    section="A motion as a table",
    metavar="SPACE",
    type=click.Choice(_SPACES, case_sensitive=False),
    default_text="global; local for rotations",
    help="What positions and rotations are seen from: global (Y is up), torso (the hips), heading (the ground below "
    "the hips, turned as they are), local (each joint's parent).",
)
@click.option("--force", cls=Option, is_flag=True, help="Replace B if it is there; never A.")
@click.option("-q", "--quiet", cls=Option, is_flag=True, help="Print no summary.")
def command(
    *,
    clip: Path,
    output: Path,
    clip_options: ClipOptions,
    rate: Fraction | None,
    on_twos: bool,
    on: int | None,
    rotations: bool,
    space: JointSpace | None,
    force: bool,
    quiet: bool,
) -> None:
    """Read clip A and write it to B, in the format that B's ending names.

    Also cuts (--frames, --drop-first), corrects the rate (--fps) and makes another one (--rate). The timing stays.
    A table is given the positions, or the rotations, of a motion's joints.
    """
    skeletons = [] if clip_options.skeleton is None else [clip_options.skeleton]
    check_outputs({"B": output}, inputs=[clip, *skeletons], force=force)
    as_table = _as_table(clip, output, clip_options.array)
    if not as_table and (rotations or space):
        raise OptionError(
            f"{'--rotations' if rotations else '--space'} is for a motion that is written as a table, such as "
            f"{output.with_suffix('.csv').name}: {clip} is written to {output}"
        )

    from retime.cli.in_place import Writing
    from retime.cli.summary import length_text, rate_text
    from retime.files import noting_writes
    from retime.formats.registry import stays_in_place, write
    from retime.motion.joint_signal import joint_signal
    from retime.motion.motion import Motion
    from retime.warp.curve import Warp

    stages = Stages(quiet=quiet)
    with stages.stage("read", "reading"):
        motion = clip_options.read(clip)
    with stages.stage("resample", "resampling"):
        motion = resampled(motion, rate, held=held_frames(on_twos, on))
    if as_table and isinstance(motion, Motion):
        motion = joint_signal(motion, rotations=rotations, space=space)
    known = None if as_table or clip_options.array else stays_in_place(clip, output, arrays=clip_options.array)
    with stages.stage("write", "writing"), noting_writes() as written:
        if known is not None and known.frames and rate is None and motion.n_frames > 1:
            # The same file with fewer frames, or another rate: all that it holds beside them is kept.
            whole = Warp([0.0, motion.end_time], [0.0, motion.end_time])
            held = held_frames(on_twos, on)
            writing = Writing(False, held, bake=False, tolerance=None, layer=None, force=force)
            writing.write(clip, clip_options, motion, whole, output, stages)
        else:
            if known is not None:
                warnings.warn(
                    f"{output} is written anew: it holds the {known.holds} of {clip}, and nothing else of that file",
                    FormatWarning,
                    stacklevel=2,
                )
            write(motion, output, overwrite=force)
    if not quiet:
        beside = "".join(f", with {one}" for one in written if one != output)
        say(f"{output}: {length_text(motion.n_frames, motion.rate)} at {rate_text(motion.rate)}{beside}")


def _as_table(clip: Path, output: Path, arrays: tuple[str, ...]) -> bool:
    """Tell whether a motion is to become a table; raise FormatError where B can't hold what A does."""
    from retime.formats.registry import check_holds, format_in, format_of

    if format_in(clip, arrays=arrays).holds == "motion" and format_of(output).holds == "signal":
        check_holds(output, "signal")
        return True
    check_holds_like(output, clip, arrays)
    return False
