"""`retime imitate`: a stretch of a clip was retimed by hand, and the rest follows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from retime.cli.clip_options import PATH, ClipOptions, clip_options, hint_at_up, parsed
from retime.cli.found_warp import FoundWarp, deliver
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.output_options import OutputOptions, output_options
from retime.cli.search_options import search_arguments, search_options
from retime.cli.terminal import Stages
from retime.cli.wish_options import WISHES_BESIDE, WishOptions, wish_options
from retime.motion.grammar import WrittenKey, parse_frame_range

# As many digits as a range can have.
_MANY_FRAMES = 10**15


def _range(text: str) -> str:
    """Refuse what is no range in any clip; which frames it means depends on the clip."""
    parse_frame_range(text, _MANY_FRAMES * 2, -_MANY_FRAMES)
    return text


_EXAMPLES = (
    "\b\nExamples\n"
    "  retime warp walk.bvh --frames 0:90 --length 60% --save hand.json\n"
    "  retime imitate walk.bvh --example 0:90 --warp hand.json -o quick.bvh\n"
)


@click.command(
    "imitate",
    cls=SectionedCommand,
    short_help="Give a whole clip the timing that one stretch got by hand.",
    epilog=_EXAMPLES,
)
@click.argument("clip", type=PATH)
@clip_options
@click.option(
    "--example",
    cls=Option,
    section="Example",
    metavar="A:B",
    required=True,
    callback=parsed(_range),
    help="The frames that were retimed by hand, as the file numbers them, both included.",
)
@click.option(
    "--warp",
    "hand",
    cls=Option,
    section="Example",
    metavar="WARP.json",
    type=PATH,
    required=True,
    help="The warp that those frames got, however it was made; its input time 0 is the example's first frame.",
)
@search_options(length="free", beside=WISHES_BESIDE)
@wish_options
@output_options
def command(
    *,
    clip: Path,
    clip_options: ClipOptions,
    example: str,
    hand: Path,
    keys: tuple[WrittenKey, ...],
    search: dict[str, Any],
    wishes: WishOptions,
    outputs: OutputOptions,
) -> None:
    """Give all of CLIP the timing that a stretch of it was given by hand.

    The stretch, retimed by its warp, is the reference that the whole clip imitates.
    """
    outputs.check(clip, [clip_options.skeleton, hand])

    from retime.formats.warp_file import read_warp
    from retime.search.imitate import imitate

    stages = Stages(quiet=outputs.quiet)
    with stages.stage("read", "reading"):
        timing = read_warp(hand)
        motion = clip_options.read(clip)
        others = [(clip_options.read(other), place) for other, place in outputs.also]
        stretch = parse_frame_range(example, motion.n_frames, motion.first_frame)
    hint_at_up(motion, clip_options.up)
    with stages.stage("search", "searching"):
        options = search_arguments(search, motion.rate) | wishes.arguments(motion.rate, search.get("features"))
        times = [key.at(motion.rate) for key in keys]
        result = imitate(motion, stretch, timing, keys=times, **options)
    warp = replace(result.warp, name=motion.name)
    found = FoundWarp(clip, motion, others, "guided", warp, result)
    deliver(found, outputs, stages, {"references": [str(hand)], "example": example})
