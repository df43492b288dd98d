"""`retime imitate`: a stretch of a clip was retimed by hand, and the rest follows."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from retime.cli.clip_options import PATH, ClipOptions, clip_options, hint_at_up, parsed
from retime.cli.found_warp import FoundWarp, deliver
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.output_options import OutputOptions, output_options
from retime.cli.search_options import for_footage, search_options
from retime.cli.terminal import Stages
from retime.cli.wish_options import WISHES_BESIDE, WishOptions, wish_options
from retime.errors import OptionError
from retime.motion.grammar import WrittenKey, parse_frame_range
from retime.motion.rate import parse_rate

if TYPE_CHECKING:
    from retime.search.example.reading import ExampleReading

# As many digits as a range can have.
_MANY_FRAMES = 10**15


def _range(text: str) -> str:
    """Refuse what is no range in any clip; which frames it means depends on the clip."""
    parse_frame_range(text, _MANY_FRAMES * 2, -_MANY_FRAMES)
    return text


_OF_PAPER = {
    "free_weight": "sum",
    "score": "joint",
    **dict.fromkeys(("evenness", "keep_flights", "content", "ends", "own_timing"), "0"),
    "match_tempo": "off",
}
# Where nobody says otherwise. What weighs scores is refused without --paper, and has then the paper's values.
_USUAL = {
    "length": "free",
    "smoothing": "3; 5 with --paper",
    "upsample": "16 to 24 by what the hand played, 8 to 12 for takes beyond two minutes",
    "max_skip": "twice unit speed, or more where the hand is faster",
    **{name: f"{usual}; needs --paper" for name, usual in _OF_PAPER.items()},
    "search": "priced; heuristic needs --paper",
}

_EXAMPLES = (
    "\b\nExamples\n"
    "  retime warp walk.bvh --frames 0:90 --length 60% --save hand.json\n"
    "  retime imitate walk.bvh --example 0:90 --warp hand.json -o quick.bvh\n"
    "  retime imitate other.bvh --example 0:90 --example-clip walk.bvh --warp hand.json -o other_quick.bvh\n"
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
@click.option(
    "--example-clip",
    cls=Option,
    section="Example",
    metavar="FILE",
    type=PATH,
    default_text="CLIP",
    help="The clip in which the example lies, where that is another; --example counts its frames. "
    "--drop-first, --skeleton, --repair, --decimal-comma and --up hold for it too.",
)
@click.option(
    "--example-fps",
    cls=Option,
    section="Example",
    metavar="R",
    callback=parsed(parse_rate),
    help="Frames a second of that clip, in place of what its file declares.",
)
@search_options(usual=_USUAL, beside=WISHES_BESIDE)
@wish_options
@output_options
def command(
    *,
    clip: Path,
    clip_options: ClipOptions,
    example: str,
    hand: Path,
    example_clip: Path | None,
    example_fps: Fraction | None,
    keys: tuple[WrittenKey, ...],
    search: dict[str, Any],
    wishes: WishOptions,
    outputs: OutputOptions,
) -> None:
    """Give all of CLIP the timing that a stretch of it was given by hand.

    Each moment of the clip is looked up in the stretch as it was, and plays as fast as the hand played what it found
    there. With --paper the clip imitates the stretch as it is now, its absolute speeds included.
    """
    if example_fps is not None and example_clip is None:
        raise OptionError("--example-fps needs --example-clip")
    outputs.check(clip, [clip_options.skeleton, hand, example_clip])

    from retime.formats.warp_file import read_warp
    from retime.search.imitate import imitate
    from retime.search.written import search_arguments

    stages = Stages(quiet=outputs.quiet)
    with stages.stage("read", "reading"):
        timing = read_warp(hand)
        motion = clip_options.read(clip)
        others = outputs.read_others(motion, clip_options)
        there = motion
        if example_clip is not None:
            shared = replace(clip_options, frames=None, fps=example_fps)
            there = shared.read(example_clip)
        stretch = parse_frame_range(example, there.n_frames, there.first_frame)
    hint_at_up(motion, clip_options.up)
    with stages.stage("search", "searching"):
        options = search_arguments(search, motion.rate) | wishes.arguments(motion.rate, search.get("features"))
        options = for_footage(clip, options)
        times = [key.at(motion.rate) for key in keys]
        other = None if example_clip is None else there
        result = imitate(motion, stretch, timing, example_clip=other, keys=times, **options)
    warp = replace(result.warp, name=motion.name)
    found = FoundWarp(clip, clip_options, motion, others, "guided", warp, result)
    facts = {
        "references": [str(hand)],
        "example": example,
        "example_clip": None if example_clip is None else str(example_clip),
        "coverage": None if result.example is None else _coverage(result.example),
    }
    deliver(found, outputs, stages, facts)


def _coverage(reading: ExampleReading) -> dict[str, Any]:
    """Say in numbers how much of the clip the example speaks for."""
    return {
        "share": reading.share,
        "unspoken": [list(span) for span in reading.unspoken],
        "closed": reading.closed,
        "period": reading.period,
        "tempo": reading.tempo,
        "warnings": list(reading.warnings),
    }
