"""The options of the search, as one argument."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import click

from retime.cli.clip_options import parsed
from retime.cli.sections import Option
from retime.motion.grammar import parse_number
from retime.motion.rate import parse_rate

# What `guided_warp` calls them.
NAMES = ("rate", "max_skip", "upsample", "n_neighbors", "time_scale", "low_pass", "features", "smoothing")

# Defaults stand in help only: an option that is not given is not passed on, and guided_warp() has its own. A test
# compares the two.
_OPTIONS = (
    click.option(
        "--rate",
        cls=Option,
        section="Method",
        metavar="R",
        callback=parsed(parse_rate),
        default_text="30",
        help="Analysis rate, Hz; the output keeps the clip's own rate.",
    ),
    click.option(
        "--max-skip",
        cls=Option,
        section="Method",
        metavar="N",
        type=click.IntRange(1, 255),
        default_text="8, 16 for another reference, or more where the length needs it",
        help="Largest step between neighbouring frames of the path: no speed beyond max_skip / upsample.",
    ),
    click.option(
        "--upsample",
        cls=Option,
        section="Method",
        metavar="U",
        type=click.IntRange(min=1),
        default_text="1 where nothing gets slower, else 4 or more; 8 for another reference",
        help="Input frames offered per analysis period: no speed below 1/U.",
    ),
    click.option(
        "--neighbors",
        "n_neighbors",
        cls=Option,
        section="Method",
        metavar="K",
        type=click.IntRange(min=1),
        default_text="3",
        help="Reference frames averaged in a score.",
    ),
    click.option(
        "--time-scale",
        cls=Option,
        section="Method",
        metavar="S",
        callback=parsed(functools.partial(parse_number, unit="s")),
        default_text="0.2",
        help="How much velocity and acceleration weigh against pose, seconds.",
    ),
    click.option(
        "--low-pass",
        cls=Option,
        section="Method",
        metavar="HZ",
        callback=parsed(functools.partial(parse_number, unit="Hz")),
        default_text="4",
        help="Cutoff of the filter that the analysis looks through, Hz; 0 is off.",
    ),
    click.option(
        "--features",
        cls=Option,
        section="Method",
        metavar="NAME",
        type=click.Choice(["torso", "heading", "signal"]),
        default_text="heading (torso where Y is not up), or signal",
        help="What a pose is. torso, heading: joints in that space. signal: the channels.",
    ),
    click.option(
        "--smoothing",
        cls=Option,
        section="Method",
        metavar="N",
        type=click.IntRange(min=0),
        default_text="5",
        help="Output frames, at the analysis rate, averaged to smooth the path's steps; 0 is off.",
    ),
)


def search_options(function: Callable[..., None]) -> Callable[..., None]:
    """Add the options to a command, which gets those that were given as one dictionary ``search``."""

    @functools.wraps(function)
    def packed(**given: Any) -> None:
        search = {name: value for name in NAMES if (value := given.pop(name)) is not None}
        function(search=search, **given)

    for option in reversed(_OPTIONS):
        packed = option(packed)
    return packed
