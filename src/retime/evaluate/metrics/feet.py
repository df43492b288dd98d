"""How far feet slide while they stand."""

from __future__ import annotations

from dataclasses import dataclass

from retime.motion.contacts import Contacts, contacts
from retime.motion.contacts import slip as contact_slip
from retime.motion.motion import Motion
from retime.warp.curve import Warp, output_frame_times


@dataclass(frozen=True)
class FootSlip:
    """How far feet slide while they stand, millimetres.

    Attributes
    ----------
    mean, largest : float
        Of all contacts.
    n_contacts : int
        How many contacts there are.
    """

    mean: float
    largest: float
    n_contacts: int


def foot_slip(motion: Motion, output: Motion, warp: Warp, *, standing: Contacts | None = None) -> FootSlip:
    """Measure how far the output's feet slide while the input's stand (see `retime.motion.contacts`).

    The contacts are the input's, carried over by the warp: a foot that stood there should stand in the output.

    Parameters
    ----------
    motion, output : Motion
        Before and after.
    warp : Warp
        What made one the other.
    standing : Contacts, optional
        The input's, where they are known already.
    """
    standing = contacts(motion) if standing is None else standing
    standing = standing.at(warp(output_frame_times(warp, float(output.rate))))
    found = contact_slip(output, standing)
    return FootSlip(found.mean, found.largest, len(found.contacts))
