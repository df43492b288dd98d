"""The options that say how video, pictures and sound are retimed."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import click

from retime.cli.clip_options import ClipOptions, parsed
from retime.cli.help_sections import Option
from retime.cli.output_checks import check_format, check_outputs
from retime.cli.terminal import Stages, say
from retime.errors import OptionError
from retime.motion.grammar import parse_number, read_time
from retime.motion.rate import parse_rate

if TYPE_CHECKING:
    from retime.media.options import MediaOptions
    from retime.warp.curve import Warp

_SECTION = "Video and sound"


def _rate(text: str) -> Fraction | Literal["variable"]:
    return "variable" if text == "variable" else parse_rate(text)


def _shutter(text: str) -> float:
    share = parse_number(text)
    if share > 1:
        raise OptionError(f"expected a share from 0 to 1, found {text!r}")
    return share


def _offset(text: str) -> float:
    written = read_time(text)
    if written.seconds is None:
        raise OptionError(f"expected seconds: the motion's frames and the video's may differ; found {text!r}")
    return float(written.seconds)


_OPTIONS = {
    "between": click.option(
        "--between",
        cls=Option,
        section=_SECTION,
        metavar="HOW",
        type=click.Choice(["blend", "nearest", "flow"]),
        default_text="blend",
        help="Between two frames show both mixed (blend), the nearer one (nearest), or one made by optical flow.",
    ),
    "shutter": click.option(
        "--shutter",
        cls=Option,
        section=_SECTION,
        metavar="SHARE",
        callback=parsed(_shutter),
        default_text="1; 0 with nearest",
        help="Where sped up, average this share of the frames that an output frame passes: 1 all of them, 0 none.",
    ),
    "output_rate": click.option(
        "--output-rate",
        cls=Option,
        section=_SECTION,
        metavar="R",
        callback=parsed(_rate),
        default_text="as the input",
        help="Frames a second of the output; variable shows each frame of the input when the warp comes to it.",
    ),
    "offset": click.option(
        "--offset",
        cls=Option,
        section=_SECTION,
        metavar="TIME",
        callback=parsed(_offset),
        default_text="0",
        help="How long after the warp's input time 0 the video or sound begins (below 0: before it).",
    ),
    "codec": click.option(
        "--codec",
        cls=Option,
        section=_SECTION,
        metavar="NAME",
        default_text="as the input",
        help="h264, hevc, vp9, av1, prores, ffv1, or FFmpeg's name of an encoder.",
    ),
    "quality": click.option(
        "--quality",
        cls=Option,
        section=_SECTION,
        metavar="N",
        type=click.IntRange(0, 63),
        default_text="the input's bytes a second",
        help="Constant quality (CRF): 0 loses all but nothing, 18 hardly anything that is seen, 28 is small.",
    ),
    "pixel_format": click.option(
        "--pixel-format",
        cls=Option,
        section=_SECTION,
        metavar="NAME",
        default_text="as the input",
        help="FFmpeg's name of it, such as yuv420p or yuv422p10le.",
    ),
    "sound": click.option(
        "--sound",
        cls=Option,
        section=_SECTION,
        metavar="HOW",
        type=click.Choice(["keep-pitch", "resample", "drop"]),
        default_text="keep-pitch",
        help="keep-pitch: stretched, at its own pitch. resample: higher where faster. drop: left out.",
    ),
    "no_deinterlace": click.option(
        "--no-deinterlace",
        cls=Option,
        section=_SECTION,
        is_flag=True,
        default=None,
        default_text="whole frames are made",
        help="Take frames that are two fields (interlaced) as they are.",
    ),
}


@dataclass(frozen=True)
class MediaChoices:
    """What was given of these options; None where it was not."""

    between: str | None = None
    shutter: float | None = None
    output_rate: Fraction | Literal["variable"] | None = None
    offset: float | None = None
    codec: str | None = None
    quality: int | None = None
    pixel_format: str | None = None
    sound: str | None = None
    no_deinterlace: bool | None = None

    def refuse_without_media(self, written: Iterable[Path]) -> None:
        """Raise OptionError where one was given, and of what is written nothing is video, pictures or sound."""
        given = [f"--{name.replace('_', '-')}" for name, value in vars(self).items() if value is not None]
        if not given:
            return
        from retime.media.kinds import is_media

        if not any(map(is_media, written)):
            raise OptionError(
                f"{', '.join(given)} would have no effect: no clip that is written is video, pictures or sound"
            )

    def options(self, *, average: bool, fps: Fraction | None, offset: float | None) -> MediaOptions:
        """Return them as the library takes them; what is None is as it is there."""
        from retime.media.options import MediaOptions

        chosen = {
            "frames": self.between,
            "shutter": self.shutter if average or self.shutter is not None else 0.0,
            "rate": self.output_rate,
            "offset": offset,
            "codec": self.codec,
            "quality": self.quality,
            "pixel_format": self.pixel_format,
            "sound": self.sound,
            "deinterlace": False if self.no_deinterlace else None,
            "fps": fps,
        }
        return MediaOptions(**{name: value for name, value in chosen.items() if value is not None})  # type: ignore[arg-type]

    def write(
        self, clip: Path, options: ClipOptions, warp: Warp, place: Path, stages: Stages, *, average: bool, force: bool
    ) -> None:
        """Retime a video, pictures, or sound."""
        from retime.media.apply import retime_media
        from retime.progress import watching

        read = {
            "--frames": options.frames,
            "--drop-first": options.drop_first,
            "--skeleton": options.skeleton,
            "--channel": options.channels,
            "--animation": options.animation,
            "--up": options.up,
            "--confidence": options.confidence,
        }
        useless = [name for name, value in read.items() if value]
        if useless:
            raise OptionError(f"{', '.join(useless)} would have no effect on {clip}, which is video, pictures or sound")
        made = self.options(average=average, fps=options.fps, offset=self.offset)
        with stages.stage("apply", f"retiming {clip.name}"), watching(stages.tell):
            retime_media(clip, place, warp, made, overwrite=force)


def check_media_place(clip: Path, place: Path, *, others: list[Path], force: bool) -> None:
    """Refuse, before anything is read, a place that video or sound can't be written to."""
    from retime.media.kinds import is_sequence

    check_format(place, like=clip)
    # Numbered pictures are looked at when their numbers are known.
    checked = place.with_name("pictures") if is_sequence(place) else place
    check_outputs({f"the output for {clip}": checked}, inputs=others, force=force or is_sequence(place))


def say_media(clip: Path, warp: Warp, place: Path) -> None:
    """Say what was written."""
    say(f"{place}: {warp.output_span:.2f} s, from {clip}")


def media_options(*, offset: bool) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Add the options to a command, which gets them as one argument ``media``.

    Of footage that a warp is found on where it begins is known, and so it is of clips beside it: without `offset` there
    is none.
    """
    declared = [option for name, option in _OPTIONS.items() if offset or name != "offset"]
    names = [name for name in _OPTIONS if offset or name != "offset"]

    def add(function: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(function)
        def packed(**given: Any) -> None:
            media = MediaChoices(**{name: given.pop(name) for name in names})
            function(media=media, **given)

        for option in reversed(declared):
            packed = option(packed)
        return packed

    return add
