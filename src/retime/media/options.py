"""What can be said of how media are retimed, checked, and as JSON for the process that does the work."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any, Literal, get_args

from retime.brief import kind_of
from retime.checks import real
from retime.errors import OptionError
from retime.media.times import FrameMode

Sound = Literal["keep-pitch", "resample", "drop"]

LEAST_QUALITY, MOST_QUALITY = 0, 63


@dataclass(frozen=True)
class MediaOptions:
    """How media are retimed.

    Parameters
    ----------
    frames : {"blend", "nearest", "flow"}
        How moments between two frames are shown: both mixed, the nearer one, or one made by optical flow.
    shutter : float, optional
        Which share of the frames that an output frame passes is averaged where the warp speeds up: 1 all of them, 0
        none. Left out, 1, and 0 where `frames` is "nearest".
    rate : Fraction or "variable", optional
        Frames a second of the output; "variable" shows each input frame when the warp comes to it. Left out, as
        the input.
    fps : Fraction, optional
        Frames a second of the input, in place of what the file says; numbered pictures say none (24).
    offset : float
        Seconds after the warp's input time 0 at which the media begin; below 0 before it.
    codec : str, optional
        How video is encoded: "h264", "hevc", "vp9", "av1", "prores", "ffv1", or FFmpeg's name of an encoder.
    quality : int, optional
        From 0 (all but lossless) to 63: the encoder's constant quality (CRF), in place of the input's bytes a second.
    pixel_format : str, optional
        FFmpeg's name of it.
    sound : {"keep-pitch", "resample", "drop"}
        Whether sound keeps its pitch, or goes up and down with the speed, or is left out.
    deinterlace : bool
        Make whole frames of those that are two fields, half a frame's time apart.

    Raises
    ------
    OptionError
        No such choice, or a number out of its range.
    """

    frames: FrameMode = "blend"
    shutter: float | None = None
    rate: Fraction | Literal["variable"] | None = None
    fps: Fraction | None = None
    offset: float = 0.0
    codec: str | None = None
    quality: int | None = None
    pixel_format: str | None = None
    sound: Sound = "keep-pitch"
    deinterlace: bool = True

    def __post_init__(self) -> None:
        for name, kind in (("frames", FrameMode), ("sound", Sound)):
            if getattr(self, name) not in get_args(kind):
                raise OptionError(f"{name} is one of {', '.join(get_args(kind))}; found {getattr(self, name)!r}")
        if self.shutter is not None and not 0 <= real(self.shutter, "the shutter") <= 1:
            raise OptionError(f"the shutter is a share from 0 to 1, found {self.shutter}")
        if not math.isfinite(real(self.offset, "the offset")):
            raise OptionError(f"the offset is a number of seconds, found {self.offset}")
        for name in ("rate", "fps"):
            value = getattr(self, name)
            if not (value is None or isinstance(value, Fraction) or (name == "rate" and value == "variable")):
                raise OptionError(f"{name} is a Fraction, found {kind_of(value)}")
        if self.quality is not None and not LEAST_QUALITY <= self.quality <= MOST_QUALITY:
            raise OptionError(f"the quality is from {LEAST_QUALITY} to {MOST_QUALITY}, found {self.quality}")

    @property
    def averaged(self) -> float:
        """The shutter that holds."""
        if self.shutter is not None:
            return self.shutter
        return 0.0 if self.frames == "nearest" else 1.0

    def to_json(self) -> dict[str, Any]:
        """Return this as JSON has it."""
        said = asdict(self)
        return {name: str(value) if isinstance(value, Fraction) else value for name, value in said.items()}

    @classmethod
    def from_json(cls, said: dict[str, Any]) -> MediaOptions:
        """Return what `to_json` said."""
        given = dict(said)
        for name in ("rate", "fps"):
            if given[name] not in (None, "variable"):
                given[name] = Fraction(given[name])
        return cls(**given)
