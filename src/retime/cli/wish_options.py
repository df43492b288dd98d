"""What is asked for beside the options of the search: keytimes, locks, joints that count, and a reference's joints."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from retime.cli.clip_options import PATH, parsed
from retime.cli.help_sections import Option
from retime.errors import OptionError
from retime.motion.grammar import (
    WrittenLock,
    WrittenSpan,
    parse_number,
    read_key,
    read_lock,
    read_span,
)

if TYPE_CHECKING:
    from retime.motion.any_motion import AnyMotion
    from retime.search.poses.spaces import PoseSpace


def _kept(text: str) -> WrittenLock:
    return WrittenLock(read_span(text), 0.0, 1.0)


def _weight(text: str) -> tuple[str, float]:
    name, _, value = text.rpartition("=")
    if not name:
        raise OptionError(f"expected a joint's weight such as LeftHand=2, found {text!r}")
    return name, parse_number(value, unit="x")


key_option = click.option(
    "--key",
    "keys",
    cls=Option,
    section="Keytimes",
    metavar="IN=OUT[@SPEED]",
    callback=parsed(read_key),
    multiple=True,
    help="Show input time IN at output time OUT (2.5, 120f, mm:ss.mmm or hh:mm:ss:ff, from the first frame used), at "
    "this playback speed where one is given; repeat for more. Equal input times hold the pose, decreasing ones run "
    "backward.",
)

_WISHES = (
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
)

FLIGHT_OPTIONS = (
    click.option(
        "--flight",
        "flown",
        cls=Option,
        section="Control",
        metavar="A..B",
        callback=parsed(read_span),
        multiple=True,
        help="From input time A to B the figure flies, whatever was found there: also to move a flight's ends.",
    ),
    click.option(
        "--no-flight",
        "grounded",
        cls=Option,
        section="Control",
        metavar="A..B",
        callback=parsed(read_span),
        multiple=True,
        help="From input time A to B nothing flies, whatever was found there.",
    ),
)

_POSES = (
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


# Where they stand in help: each after the option of the search that is named.
WISHES_BESIDE = {"length": (key_option,), "free_weight": _WISHES, "features": _POSES}


@dataclass(frozen=True)
class WishOptions:
    """The options that were given; what was not is None or empty."""

    locks: tuple[WrittenLock, ...] = ()
    keep: tuple[WrittenLock, ...] = ()
    joints: str | None = None
    weights: tuple[tuple[str, float], ...] = ()
    joint_map: tuple[Path, ...] = ()
    mirror: bool = False
    flown: tuple[WrittenSpan, ...] = ()
    grounded: tuple[WrittenSpan, ...] = ()

    def names_given(self) -> list[str]:
        """Return the options that were given, for messages."""
        flags = {"locks": "--lock", "weights": "--joint-weight", "flown": "--flight", "grounded": "--no-flight"}
        return [
            flags.get(name, f"--{name.replace('_', '-')}")
            for name in self.__dataclass_fields__
            if getattr(self, name) not in (None, (), False)
        ]

    def arguments(self, rate: Fraction, features: PoseSpace | None) -> dict[str, Any]:
        """Return what `guided_warp` calls them; what was not given is left to it."""
        found: dict[str, Any] = {}
        if self.locks or self.keep:
            from retime.search.wishes.locks import Lock

            found["locks"] = [Lock(*lock.at(rate)) for lock in (*self.locks, *self.keep)]
        if self.joints is not None or self.weights:
            from retime.search.poses.spaces import PoseOptions

            joints = None if self.joints is None else tuple(name.strip() for name in self.joints.split(","))
            found["features"] = PoseOptions(space=features, joints=joints, weights=dict(self.weights))
        return found

    def flights(self, clips: Sequence[AnyMotion]) -> list[tuple[float, float]] | None:
        """Return the flights of clips, put right; None where nothing was said of them."""
        if not self.flown and not self.grounded:
            return None
        from retime.motion.flights import corrected_flights
        from retime.search.wishes.tempo import flights_of

        rate = clips[0].rate
        return corrected_flights(
            flights_of(clips),
            flown=[span.at(rate) for span in self.flown],
            grounded=[span.at(rate) for span in self.grounded],
        )


def wish_options(function: Callable[..., None]) -> Callable[..., None]:
    """Hand a command the wishes that were given as one argument ``wishes``; `search_options` adds them."""

    @functools.wraps(function)
    def packed(**given: Any) -> None:
        names = [name for name in WishOptions.__dataclass_fields__ if name in given]
        function(wishes=WishOptions(**{name: given.pop(name) for name in names}), **given)

    return packed


def reference_options(function: Callable[..., None]) -> Callable[..., None]:
    """Add the options of a command whose reference may be another clip."""
    for option in reversed(_REFERENCE_OPTIONS):
        function = option(function)
    return function
