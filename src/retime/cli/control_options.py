"""The options that shape the timing beyond keytimes, as one argument."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from retime.cli.clip_options import PATH, parsed
from retime.cli.sections import Option
from retime.errors import OptionError
from retime.motion.grammar import (
    WrittenLock,
    WrittenTime,
    check_length,
    parse_number,
    parse_share,
    parse_speeds,
    read_key,
    read_lock,
    read_span,
    read_time,
)

if TYPE_CHECKING:
    from retime.search.poses.spaces import PoseSpace

Influence = float | list[tuple[WrittenTime, float]]


def _influence(text: str) -> Influence:
    """Read a share, or a curve ``T=V,T=V,...`` over output time."""
    if "=" not in text:
        return parse_share(text)
    curve = []
    for pair in text.split(","):
        time, _, value = pair.partition("=")
        curve.append((read_time(time), parse_share(value)))
    return curve


def _kept(text: str) -> WrittenLock:
    return WrittenLock(read_span(text), 0.0, 1.0)


def _weight(text: str) -> tuple[str, float]:
    name, _, value = text.rpartition("=")
    if not name:
        raise OptionError(f"expected a joint's weight such as LeftHand=2, found {text!r}")
    return name, parse_number(value, unit="x")


def length_option(default_text: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Make --length; the default is the command's."""
    return click.option(
        "--length",
        cls=Option,
        section="Keytimes",
        metavar="L",
        callback=parsed(check_length),
        default_text=default_text,
        help="Length of the output: 65%, 9.3 (seconds) or 280f (frames at the clip's rate), or free: the search finds "
        "it.",
    )


key_option = click.option(
    "--key",
    "keys",
    cls=Option,
    section="Keytimes",
    metavar="IN=OUT[@SPEED]",
    callback=parsed(read_key),
    multiple=True,
    help="Show input time IN at output time OUT (2.5, 120f, mm:ss.mmm or hh:mm:ss:ff, from the first frame used), at "
    "this playback speed where one is given; repeat for more. Equal input times hold, decreasing ones run backward.",
)

_OPTIONS = (
    click.option(
        "--min-length",
        cls=Option,
        section="Keytimes",
        metavar="L",
        callback=parsed(check_length),
        help="With --length free: no shorter than this.",
    ),
    click.option(
        "--max-length",
        cls=Option,
        section="Keytimes",
        metavar="L",
        callback=parsed(check_length),
        help="With --length free: no longer than this.",
    ),
    click.option(
        "--free-weight",
        cls=Option,
        section="Keytimes",
        metavar="NAME",
        type=click.Choice(["neutral", "sum"]),
        default_text="neutral",
        help="With --length free: weigh both clocks alike, or the paper's plain sum, which favours short results.",
    ),
    click.option(
        "--lock",
        "locks",
        cls=Option,
        section="Control",
        metavar="A..B[=SPEED]",
        callback=parsed(read_lock),
        multiple=True,
        help="Play input time A to B at this speed (2, 1/2, 50%), or within a range of speeds (1/2..1, uncut); 1 where "
        "left out.",
    ),
    click.option(
        "--keep",
        cls=Option,
        section="Control",
        metavar="A..B",
        callback=parsed(_kept),
        multiple=True,
        help="Don't cut input time A to B: it may be slowed down, not sped up.",
    ),
    click.option(
        "--speed",
        cls=Option,
        section="Control",
        metavar="LO..HI",
        callback=parsed(parse_speeds),
        help="Slowest and fastest playback speed, such as 1/4..8; sets upsample and max_skip.",
    ),
    click.option(
        "--smoothness",
        cls=Option,
        section="Control",
        metavar="W",
        callback=parsed(parse_number),
        default_text="0",
        help="Weight on changes of log-speed, in median scores.",
    ),
    click.option(
        "--influence",
        cls=Option,
        section="Control",
        metavar="V",
        callback=parsed(_influence),
        default_text="1",
        help="From 0 (spline through the keytimes) to 1 (guided), or a curve over output time: 0s=0,2s=1.",
    ),
    click.option(
        "--loop",
        cls=Option,
        section="Control",
        is_flag=True,
        help="The clip is a cycle and stays one: first and last speed agree.",
    ),
    click.option(
        "--score",
        cls=Option,
        section="Method",
        metavar="NAME",
        type=click.Choice(["joint", "conditional"]),
        default_text="joint",
        help="joint: the paper's. conditional: how the reference moves where its pose is like this.",
    ),
    click.option(
        "--search",
        "kind",
        cls=Option,
        section="Method",
        metavar="NAME",
        type=click.Choice(["priced", "layered", "heuristic"]),
        default_text="priced",
        help="priced, layered: exact. heuristic: the paper's, from coarse to fine; its excess is reported.",
    ),
    click.option(
        "--joints",
        cls=Option,
        section="Method",
        metavar="A,B,...",
        help="Look at these joints (or channels) only.",
    ),
    click.option(
        "--joint-weight",
        "weights",
        cls=Option,
        section="Method",
        metavar="JOINT=W",
        callback=parsed(_weight),
        multiple=True,
        help="Let a joint (or channel) count W times; repeat for more.",
    ),
)

# In the place of a joint map: names say it.
NO_MAP = Path("-")

# Where the reference may be another clip.
_REFERENCE_OPTIONS = (
    click.option(
        "--joint-map",
        cls=Option,
        section="Reference",
        metavar="FILE",
        type=PATH,
        multiple=True,
        help="Which joint of the reference is which of the clip's, where names don't say it (.json, .csv): once for "
        "all references, or once for each (- for none).",
    ),
    click.option(
        "--mirror",
        cls=Option,
        section="Reference",
        is_flag=True,
        help="Imitate the reference's mirror image too.",
    ),
)


@dataclass(frozen=True)
class ControlOptions:
    """The options that were given; what was not is None or empty."""

    min_length: str | None = None
    max_length: str | None = None
    free_weight: str | None = None
    locks: tuple[WrittenLock, ...] = ()
    keep: tuple[WrittenLock, ...] = ()
    speed: tuple[float, float] | None = None
    smoothness: float | None = None
    influence: Influence | None = None
    loop: bool = False
    score: str | None = None
    kind: str | None = None
    joints: str | None = None
    weights: tuple[tuple[str, float], ...] = ()
    joint_map: tuple[Path, ...] = ()
    mirror: bool = False

    def names_given(self) -> list[str]:
        """Return the options that were given, for messages."""
        flags = {"kind": "--search", "locks": "--lock", "weights": "--joint-weight"}
        return [
            flags.get(name, f"--{name.replace('_', '-')}")
            for name in self.__dataclass_fields__
            if getattr(self, name) not in (None, (), False)
        ]

    def arguments(self, rate: Fraction, features: PoseSpace | None) -> dict[str, Any]:
        """Return what `guided_warp` calls them; what was not given is left to it."""
        given: dict[str, Any] = {
            "min_length": self.min_length,
            "max_length": self.max_length,
            "free_weight": self.free_weight,
            "speed": self.speed,
            "smoothness": self.smoothness,
            "score": self.score,
            "search": self.kind,
        }
        found = {name: value for name, value in given.items() if value is not None}
        if self.locks or self.keep:
            from retime.search.wishes.locks import Lock

            found["locks"] = [Lock(*lock.at(rate)) for lock in (*self.locks, *self.keep)]
        if self.loop:
            found["loop"] = True
        if self.influence is not None:
            found["influence"] = (
                [(float(time.at(rate)), value) for time, value in self.influence]
                if isinstance(self.influence, list)
                else self.influence
            )
        if self.joints is not None or self.weights:
            from retime.search.poses.spaces import PoseOptions

            joints = None if self.joints is None else tuple(name.strip() for name in self.joints.split(","))
            found["features"] = PoseOptions(space=features, joints=joints, weights=dict(self.weights))
        return found


def _packed(*options: Callable[..., Any]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Make a decorator that adds options to a command, which gets them as one argument ``control``."""

    def add(function: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(function)
        def packed(**given: Any) -> None:
            names = [name for name in ControlOptions.__dataclass_fields__ if name in given]
            function(control=ControlOptions(**{name: given.pop(name) for name in names}), **given)

        for option in reversed(options):
            packed = option(packed)
        return packed

    return add


# A command whose reference may be another clip gets all of them.
control_options = _packed(*_OPTIONS, *_REFERENCE_OPTIONS)
control_options_of_one_clip = _packed(*_OPTIONS)
