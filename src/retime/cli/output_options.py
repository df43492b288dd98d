"""The options that say what a command that finds a warp writes and prints."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from retime.cli.clip_options import PATH, ClipOptions, parsed
from retime.cli.help_sections import Option
from retime.cli.in_place import Writing
from retime.cli.media_options import MediaChoices, media_options
from retime.cli.output_checks import check_format, check_outputs, check_plot
from retime.errors import OptionError
from retime.motion.grammar import WrittenTime, parse_number, read_time

if TYPE_CHECKING:
    from retime.motion.any_motion import AnyMotion


class Also(NamedTuple):
    """Another clip that gets the same warp.

    Attributes
    ----------
    clip, output : Path
        Where it is, and where it goes.
    offset : WrittenTime, optional
        How long after the first clip it begins, or, of the other sign, before it.
    sign : int
        1 or -1.
    """

    clip: Path
    output: Path
    offset: WrittenTime | None = None
    sign: int = 1


# What follows the name of a clip: a sign, and a time that says its unit.
_OFFSET = re.compile(r"(.+\.\w+)([+-])([\d.:;]+[sf]?)", re.IGNORECASE)


def _also(text: str) -> Also:
    """Split another clip, and its offset, from its output."""
    clip, sign, output = text.partition("=")
    if not (sign and clip and output):
        raise OptionError(
            "expected another clip and its output, such as camera.csv=camera_retimed.csv (camera.csv+0.5s=... where it "
            f"begins later), found {text!r}"
        )
    if (match := _OFFSET.fullmatch(clip)) and not Path(clip).exists():
        return Also(Path(match[1]), Path(output), read_time(match[3]), -1 if match[2] == "-" else 1)
    return Also(Path(clip), Path(output))


no_average_option = click.option(
    "--no-average",
    "average",
    cls=Option,
    is_flag=True,
    flag_value=False,
    default=True,
    help="Where the motion is sped up, show single moments of the input instead of averages over a few frames.",
)

on_twos_option = click.option(
    "--on-twos",
    cls=Option,
    is_flag=True,
    help="Hold each pose for two frames, as drawn animation does: stepped, not smooth.",
)

on_option = click.option(
    "--on",
    cls=Option,
    metavar="N",
    type=click.IntRange(1, 1000),
    help="Hold each pose for N frames (--on 3: on threes).",
)


def held_frames(on_twos: bool, on: int | None) -> int:
    """Return for how many frames a pose is held; raise OptionError where both options say it."""
    if on_twos and on is not None:
        raise OptionError("--on-twos is --on 2: give one of them")
    return 2 if on_twos else on or 1


bake_option = click.option(
    "--bake",
    cls=Option,
    is_flag=True,
    help="Of a scene (.glb, .gltf, .fbx, USD): put a key on every frame, in place of cutting curves at a warp's knots.",
)


def _tolerance(text: str) -> float:
    return parse_number(text, least=0.0, unit="s")


tolerance_option = click.option(
    "--tolerance",
    cls=Option,
    metavar="SECONDS",
    callback=parsed(_tolerance),
    default_text="0.001",
    help="Of a scene: how far the warp's knots may be thinned out before its curves are cut at them.",
)

layer_option = click.option(
    "--layer",
    cls=Option,
    metavar="KIND",
    type=click.Choice(["clips", "over"]),
    help="Of a USD scene: leave the file as it is, and write a small layer that shows it with new timing. clips: by "
    "value clips, whose times are the warp. over: with new time samples over the file's own.",
)

_OPTIONS = (
    click.option(
        "-o",
        "--output",
        cls=Option,
        metavar="OUT",
        type=PATH,
        help="Write the retimed clip; the name's ending says in which format.",
    ),
    click.option(
        "--save", cls=Option, metavar="WARP.json", type=PATH, help="Write the warp, for retime apply and retime plot."
    ),
    click.option(
        "--plot",
        cls=Option,
        metavar="FILE",
        type=PATH,
        help="Draw the warp beside the linear one, and beside the spline where there are keytimes; below, what held it "
        "back (.svg, .pdf, .png).",
    ),
    click.option(
        "--explain",
        cls=Option,
        metavar="FILE.csv",
        type=PATH,
        help="Write for each output frame its score, the reference frames that it was matched with, and what held "
        "it back.",
    ),
    click.option(
        "--also",
        cls=Option,
        metavar="CLIP=OUT",
        callback=parsed(_also),
        multiple=True,
        help="Give another clip the same warp (a prop, a camera, a second character); repeat for more. "
        "CLIP+0.5s=OUT where it begins half a second after the first clip, CLIP-12f=OUT twelve frames before. "
        "Left out, times in both files say it.",
    ),
    no_average_option,
    on_twos_option,
    on_option,
    bake_option,
    tolerance_option,
    layer_option,
    click.option("--force", cls=Option, is_flag=True, help="Replace files that are there; never the input."),
    click.option("--json", "as_json", cls=Option, is_flag=True, help="Print one JSON object instead of the summary."),
    click.option("-q", "--quiet", cls=Option, is_flag=True, help="Print no summary."),
)


@dataclass(frozen=True)
class OutputOptions:
    """What is to be written, and what is to be said."""

    output: Path | None
    save: Path | None
    plot: Path | None
    explain: Path | None
    also: tuple[Also, ...]
    average: bool
    on_twos: bool
    on: int | None
    bake: bool
    tolerance: float | None
    layer: str | None
    media: MediaChoices
    force: bool
    as_json: bool
    quiet: bool

    @property
    def held(self) -> int:
        """For how many frames each pose of the output is held."""
        return held_frames(self.on_twos, self.on)

    def read_others(
        self, clip: AnyMotion, clip_options: ClipOptions, *, searched: bool = False
    ) -> list[tuple[AnyMotion | None, Path]]:
        """Read the clips that get the same warp, on the clock of the first one; beside each stands its output.

        Video and sound are None: they are not read.

        Of clips that are searched together the search itself says whose clock begins elsewhere.
        """
        from retime.formats.registry import stays_in_place
        from retime.media.kinds import is_media
        from retime.motion.group_clock import hint_at_clocks, on_clock_by_times, on_clock_of

        found: list[tuple[AnyMotion | None, Path]] = []
        for one in self.also:
            if is_media(one.clip):
                if searched:
                    raise OptionError(f"--group searches clips of motion together, and {one.clip} is video or sound")
                # Footage of the same moments needs not be looked at.
                found.append((None, one.output))
                continue
            in_place = stays_in_place(one.clip, one.output, arrays=clip_options.array)
            if one.offset is not None and in_place:
                raise OptionError(
                    f"{one.clip} has an offset, and {one.output} would be that file retimed in place, which begins "
                    "where it does; write another format"
                )
            other = clip_options.read(one.clip, beside=True)
            if one.offset is not None:
                other = on_clock_of(other, clip, one.sign * float(one.offset.at(clip.rate)))
            elif not in_place:
                other = on_clock_by_times(other, clip)
            found.append((other, one.output))
        if not searched:
            hint_at_clocks([clip, *(other for other, _ in found if other is not None)])
        return found

    @property
    def writing(self) -> Writing:
        """How clips are written."""
        return Writing(self.average, self.held, self.bake, self.tolerance, self.layer, self.force, self.media)

    @property
    def places(self) -> list[Path]:
        """The files to be written."""
        places = [self.output, *(one.output for one in self.also), self.save, self.plot, self.explain]
        return [place for place in places if place is not None]

    def check(self, clip: Path, inputs: Iterable[Path | None], arrays: tuple[str, ...] = ()) -> None:
        """Refuse, before anything is read, what could not be written.

        `inputs` are read beside the clip, `arrays` are those of an archive that are meant.
        """
        if self.held > 1 and self.output is None and not self.also:
            raise OptionError("poses are held in the retimed clip: give -o OUT, or --also")
        self.media.refuse_without_media([*([] if self.output is None else [clip]), *(one.clip for one in self.also)])
        read = [clip, *(path for path in inputs if path is not None), *(one.clip for one in self.also)]
        outputs = {"--output": self.output, "--save": self.save, "--plot": self.plot, "--explain": self.explain}
        outputs |= {f"--also {one.clip}": one.output for one in self.also}
        check_outputs(outputs, inputs=read, force=self.force)
        for one in self.also:
            check_format(one.output, like=one.clip, arrays=arrays)
        if self.output is not None:
            check_format(self.output, like=clip, arrays=arrays)
        if self.plot is not None:
            check_plot(self.plot)


def output_options(function: Callable[..., None]) -> Callable[..., None]:
    """Add the options to a command, which gets them as one argument ``outputs``."""

    @functools.wraps(function)
    def packed(**given: Any) -> None:
        outputs = OutputOptions(**{name: given.pop(name) for name in OutputOptions.__dataclass_fields__})
        function(outputs=outputs, **given)

    added = media_options(offset=False)(packed)
    for option in reversed(_OPTIONS):
        added = option(added)
    return added
