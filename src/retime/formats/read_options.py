"""What a person may tell a reader of files, and the sizes at which every reader stops."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from retime.checks import real
from retime.errors import OptionError
from retime.files import MOST_BYTES
from retime.limits import MOST_FRAMES, MOST_JOINT_POSES
from retime.motion.channels import ChannelKind
from retime.motion.gaps import GapPolicy


@dataclass(frozen=True)
class Limits:
    """Sizes that a reader refuses to go past; each is named in its message and can be set.

    Attributes
    ----------
    file_bytes : int
        Bytes of a file.
    joints : int
        Joints of a skeleton.
    depth : int
        Joints from the root down to the deepest.
    joint_channels : int
        Channels of one joint.
    channels : int
        Channels of a motion or signal.
    frames : int
        Frames of a motion or signal.
    joint_poses : int
        Frames times joints of a motion. A file may declare many joints and give them hardly a number each, so
        its size alone does not bound the memory.
    line_bytes : int
        Bytes of a line of text.
    name_bytes : int
        Bytes of a joint's or channel's name.
    zip_ratio : int
        How many times larger than its compressed bytes a zip member may claim to be, and what a compressed file holds
        may be; up to 1 MiB is taken in any case.
    inflated_bytes : int
        Bytes of all inflated zip members, and of what a compressed file holds.
    records : int
        Records of an FBX file, each of which takes far more memory than its bytes.
    """

    file_bytes: int = MOST_BYTES
    joints: int = 4096
    depth: int = 256
    joint_channels: int = 9
    channels: int = 16384
    frames: int = MOST_FRAMES
    joint_poses: int = MOST_JOINT_POSES
    line_bytes: int = 16 << 20
    name_bytes: int = 1024
    zip_ratio: int = 200
    inflated_bytes: int = 2 << 30
    records: int = 4_000_000


@dataclass(frozen=True)
class ReadOptions:
    """What a person may tell a reader.

    Attributes
    ----------
    rate : Fraction, optional
        Frames a second, in place of what the file declares (or fails to).
    skeleton : Path, optional
        The ASF of an AMC, where it can't be found beside it.
    repair : bool
        Keep what is whole of a damaged file, with a warning, where that is possible.
    decimal_comma : bool
        Numbers are written with a comma (0,5) instead of a point.
    channels : mapping of str to ChannelKind
        What channels hold, by their names or patterns of them.
    gaps : GapPolicy, optional
        What to do about values that are missing; left out, they are refused.
    arrays : tuple of str
        Arrays of an NPZ that are meant; none given, those that are usual.
    animation : str, optional
        Which animation of a file that has several, by its name or, where no name is this, its number from 0.
    outside : bool
        Files outside a scene's folder may be read, where it is composed of them.
    confidence : float, optional
        Of keypoints, from 0 to 1: points that their detector is less sure of are missing.
    limits : Limits
        Sizes not to go past.
    """

    rate: Fraction | None = None
    skeleton: Path | None = None
    repair: bool = False
    decimal_comma: bool = False
    channels: Mapping[str, ChannelKind] = field(default_factory=dict)
    gaps: GapPolicy | None = None
    arrays: tuple[str, ...] = ()
    animation: str | None = None
    outside: bool = False
    confidence: float | None = None
    limits: Limits = field(default_factory=Limits)

    def __post_init__(self) -> None:
        if self.confidence is not None and not 0 <= real(self.confidence, "the confidence") <= 1:
            raise OptionError(f"the confidence is a share from 0 to 1, found {self.confidence}")
