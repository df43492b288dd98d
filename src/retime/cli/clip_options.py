"""The options that say how a clip is read, and the reading."""

from __future__ import annotations

import contextlib
import functools
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from retime.cli.help_sections import Option
from retime.errors import OptionError, RetimeWarning
from retime.motion.grammar import parse_frame_range, parse_number
from retime.motion.rate import parse_rate

if TYPE_CHECKING:
    from retime.formats.read_options import ReadOptions
    from retime.motion.any_motion import AnyMotion
    from retime.motion.channels import ChannelKind
    from retime.motion.gaps import GapPolicy
    from retime.motion.motion import Up

PATH = click.Path(path_type=Path)
UP_WHERE_LEFT_OUT = "as the file declares (FBX, USD, AMASS), else y"
"""What help says of --up."""
# Bytes of a file from which a command's arrays are so large that clearing memory for them takes its time.
_LONG_TAKE = 1 << 23


Parsed = TypeVar("Parsed")


def parsed(parse: Callable[[str], Parsed]) -> Callable[[click.Context, click.Parameter, Any], Any]:
    """Make an option's callback of a parser that raises OptionError, so that the error names the option."""

    def one(ctx: click.Context, param: click.Parameter, text: str) -> Parsed:
        try:
            return parse(text)
        except OptionError as error:
            raise click.BadParameter(str(error), ctx=ctx, param=param) from None

    def callback(ctx: click.Context, param: click.Parameter, value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(one(ctx, param, text) for text in value)
        return None if value is None else one(ctx, param, value)

    return callback


@dataclass(frozen=True)
class ClipOptions:
    """How a clip is read, and which part of it is meant.

    Attributes
    ----------
    frames : str, optional
        ``A:B``, as the file numbers its frames, both included.
    drop_first : int
        Frames to leave out at the start, before `frames` is looked at.
    fps : Fraction, optional
        Rate in place of what the file declares.
    skeleton : Path, optional
        The ASF of an AMC.
    repair, decimal_comma, up, root : bool, bool, str, str
        As `retime.read` has them.
    channels : tuple of (str, ChannelKind)
        What channels hold, by names or patterns.
    gaps : GapPolicy, optional
        What to do about values that are missing.
    array : tuple of str
        Arrays of an NPZ.
    animation : str, optional
        Which animation of a scene.
    allow_outside : bool
        Let a scene be composed of files outside its folder.
    confidence : float, optional
        Of keypoints, below which points are missing.
    is_reference : bool
        Whether the clip is to be imitated.
    """

    frames: str | None = None
    drop_first: int = 0
    fps: Fraction | None = None
    skeleton: Path | None = None
    repair: bool = False
    decimal_comma: bool = False
    up: Up | None = None
    channels: tuple[tuple[str, ChannelKind], ...] = ()
    gaps: GapPolicy | None = None
    array: tuple[str, ...] = ()
    root: str | None = None
    animation: str | None = None
    allow_outside: bool = False
    confidence: float | None = None
    is_reference: bool = False

    def read_options(self) -> ReadOptions:
        """Return what a reader is told."""
        from retime.formats.read_options import ReadOptions

        return ReadOptions(
            rate=self.fps,
            skeleton=self.skeleton,
            repair=self.repair,
            decimal_comma=self.decimal_comma,
            channels=dict(self.channels),
            gaps=self.gaps,
            arrays=self.array,
            animation=self.animation,
            outside=self.allow_outside,
            confidence=self.confidence,
        )

    def read(self, path: Path, *, beside: bool = False) -> AnyMotion:
        """Read a clip; raise FormatError, OSError or OptionError.

        One that stands `beside` another needn't have the channels that kinds were given for, nor the joint of `root`.
        """
        from retime.formats.registry import read_with, refuse_unfit
        from retime.kernels import keep_freed_memory
        from retime.media.kinds import is_media
        from retime.motion.first_frames import hint_at_first_frames

        options = self.read_options()
        with contextlib.suppress(OSError):
            if path.stat().st_size > _LONG_TAKE:
                keep_freed_memory()
        if is_media(path):
            from retime.media.features import video_signal

            # What moves in it stands for it.
            clip: AnyMotion = video_signal(path, fps=self.fps)
        else:
            clip = read_with(path, options, up=self.up, root=self.root)
        if not (beside or self.is_reference):
            refuse_unfit(clip, options.channels, self.root)
        if not clip.name:
            clip = replace(clip, name=path.stem)
        if self.drop_first >= clip.n_frames:
            raise OptionError(
                f"--drop-first {self.drop_first} leaves nothing of {path}, which has {clip.n_frames} frames"
            )
        if self.drop_first:
            clip = clip.frames(self.drop_first, clip.n_frames)
        if self.frames is not None:
            clip = clip.frames(*parse_frame_range(self.frames, clip.n_frames, clip.first_frame))
        hint_at_first_frames(clip, reference=self.is_reference)
        return clip


def hint_at_up(clip: AnyMotion, up: str | None) -> None:
    """Warn where a figure seems to stand along Z and nobody said which axis is up."""
    from retime.motion.kinematics import seems_z_up
    from retime.motion.motion import Motion

    if up is None and isinstance(clip, Motion) and seems_z_up(clip):
        warnings.warn(
            f"{clip.name}: the figure lies flat along Y and stands along Z. If Z is up in this file, say so (--up z), "
            "or flights and standing feet are not found, and height does not count; if it lies down, say --up y",
            RetimeWarning,
            stacklevel=2,
        )


def resampled(clip: AnyMotion, rate: Fraction | None, *, held: int) -> AnyMotion:
    """Make another rate of whichever kind of clip this is, and hold each pose for some frames."""
    from retime.motion.signal import Signal
    from retime.warp.resampling import resample

    if isinstance(clip, Signal):
        return resample(clip, rate, on=held)
    return resample(clip, rate, on=held)


def _channel(text: str) -> tuple[str, ChannelKind]:
    # Numbers come in with it, for which nobody should wait who asks for help.
    from retime.motion.channels import parse_channel

    return parse_channel(text)


def _confidence(text: str) -> float:
    share = parse_number(text)
    if share > 1:
        raise OptionError(f"expected a share from 0 to 1, found {text!r}")
    return share


def _gaps(text: str) -> GapPolicy:
    from retime.motion.gaps import GapPolicy

    return GapPolicy.parse(text)


_OPTIONS = (
    click.option(
        "--frames",
        cls=Option,
        section="Input",
        metavar="A:B",
        help="Use only frames A to B, as the file numbers them, both included.",
    ),
    click.option(
        "--drop-first",
        cls=Option,
        section="Input",
        metavar="N",
        type=click.IntRange(min=0),
        default=0,
        default_text="0",
        help="Leave out the first N frames (the T-pose that some files begin with).",
    ),
    click.option(
        "--fps",
        cls=Option,
        section="Input",
        metavar="R",
        callback=parsed(parse_rate),
        help="Frames a second, in place of what the file declares.",
    ),
    click.option(
        "--skeleton",
        cls=Option,
        section="Input",
        metavar="ASF",
        type=PATH,
        help="The skeleton of an AMC, where it can't be found beside it.",
    ),
    click.option(
        "--repair",
        cls=Option,
        section="Input",
        is_flag=True,
        help="Keep the undamaged part of a damaged file, and part numbers that run together (0.0-7.5), with a warning.",
    ),
    click.option(
        "--decimal-comma", cls=Option, section="Input", is_flag=True, help="Numbers are written with a comma (0,5)."
    ),
    click.option(
        "--up",
        cls=Option,
        section="Input",
        metavar="AXIS",
        type=click.Choice(["y", "z"], case_sensitive=False),
        default_text=UP_WHERE_LEFT_OUT,
        help="Which axis of the file is vertical: y, or z. The output keeps the same axis.",
    ),
    click.option(
        "--channel",
        "channels",
        cls=Option,
        section="Input",
        metavar="NAME=KIND",
        callback=parsed(_channel),
        multiple=True,
        default_text="found by name and values",
        help="What a channel of a table holds: linear, angle:deg, angle:rad, quaternion (four columns), label, event "
        "or time. NAME may have * and ?; repeat for more. retime info says what is found.",
    ),
    click.option(
        "--gaps",
        cls=Option,
        section="Input",
        metavar="HOW",
        callback=parsed(_gaps),
        default_text="refused",
        help="Values that a table lacks: bridge fills gaps of up to 1 s from both sides (bridge:0.2 up to 0.2 s), and "
        "keeps longer ones; keep keeps all as gaps.",
    ),
    click.option(
        "--array",
        cls=Option,
        section="Input",
        metavar="NAME",
        multiple=True,
        help="Which array of an NPZ is meant; repeat for more, side by side. Of a C3D: points, or analog.",
    ),
    click.option(
        "--root",
        cls=Option,
        section="Input",
        metavar="NAME",
        default_text="found",
        help="The joint that carries the body, where it is not the one that `retime info` shows.",
    ),
    click.option(
        "--animation",
        cls=Option,
        section="Input",
        metavar="NAME",
        default_text="all; to look at, the first",
        help="Which animation of a scene (.glb, .gltf, .fbx, USD), by its name or its number, counted "
        "from 0; of USD also the path of a prim or an attribute: what is looked at, for all of the scene is retimed.",
    ),
    click.option(
        "--allow-outside",
        cls=Option,
        section="Input",
        is_flag=True,
        help="Let a USD scene be composed of files outside its folder: read what it names, wherever that is.",
    ),
    click.option(
        "--confidence",
        cls=Option,
        section="Input",
        metavar="SHARE",
        callback=parsed(_confidence),
        default_text="0.3",
        help="Of keypoints (OpenPose, MediaPipe): points that the detector is less sure of than this, from 0 to 1, are "
        "missing.",
    ),
)


def clip_options(function: Callable[..., None]) -> Callable[..., None]:
    """Add the options to a command, which gets them as one argument ``clip_options``."""

    @functools.wraps(function)
    def packed(
        *,
        frames: str | None,
        drop_first: int,
        fps: Fraction | None,
        skeleton: Path | None,
        repair: bool,
        decimal_comma: bool,
        up: Up | None,
        channels: tuple[tuple[str, ChannelKind], ...],
        gaps: GapPolicy | None,
        array: tuple[str, ...],
        root: str | None,
        animation: str | None,
        allow_outside: bool,
        confidence: float | None,
        **rest: Any,
    ) -> None:
        options = ClipOptions(
            frames,
            drop_first,
            fps,
            skeleton,
            repair,
            decimal_comma,
            up,
            channels,
            gaps,
            array,
            root,
            animation,
            allow_outside,
            confidence,
        )
        function(clip_options=options, **rest)

    for option in reversed(_OPTIONS):
        packed = option(packed)
    return packed
