"""What an AMC and its ASF declare, kept with the motion so that it can be written back; and what both ways share."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from retime.motion.motion import Declaration

# Where neither the file nor its reader says one.
ASSUMED_RATE = Fraction(120)
RATE_COMMENT = b"# frames per second:"


@dataclass(frozen=True, repr=False)
class AsfDeclaration(Declaration):
    """What an AMC and its ASF declared.

    The ``channels`` of a joint are those of the root's ``order`` or the bone's ``dof``; they turn about fixed axes, the
    first one first, unlike BVH's.

    Attributes
    ----------
    asf : bytes
        The ASF as it was: axes, degrees of freedom, limits, units and notes.
    asf_name : str
        Its file name.
    header : tuple of bytes
        The lines before the first frame.
    degrees : bool
        Whether the AMC's angles are in degrees.
    joint_order : tuple of int
        The joints that have channels, in the order in which the AMC lists them.
    counts_from : int
        The number of the file's first frame.
    line_end : bytes
        What ends a line.
    """

    asf: bytes = b""
    asf_name: str = ""
    header: tuple[bytes, ...] = ()
    degrees: bool = True
    joint_order: tuple[int, ...] = ()
    counts_from: int = 1
    line_end: bytes = b"\n"
