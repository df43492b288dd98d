"""How far standing feet slide, before and after a warp."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

from retime.brief import kind_of
from retime.errors import OptionError
from retime.motion.contacts import Contact, Contacts, Foot, Slip, slip, slip_of
from retime.motion.contacts import contacts as find_contacts
from retime.motion.kinematics import chain_of, metres_per_unit, part_of
from retime.motion.motion import Motion
from retime.warp.apply import check_seam, compare_ranges, resampled
from retime.warp.curve import Warp, WarpLike, as_warp, output_frame_times
from retime.warp.slip_picture import slip_html

# What the measurements of a report are called in its picture.
_LABELS = {
    "input": "input",
    "unaveraged": "no averaging",
    "plain": "all averaged",
    "contact_aware": "feet exempt",
}


@dataclass(frozen=True, eq=False)
class SlipReport:
    """How far feet slide while they stand, before and after a warp.

    Attributes
    ----------
    input : Slip
        Of the input itself.
    unaveraged, plain, contact_aware : Slip
        Of the output, in the same contacts as far as output frames fall into them: without averaging, with everything
        averaged as in the paper, and with standing feet exempted.
    """

    input: Slip
    unaveraged: Slip
    plain: Slip
    contact_aware: Slip

    def __repr__(self) -> str:
        means = ", ".join(f"{name} {each.mean:.1f}" for name, each in self._measured())
        guessed = ", about, for the figure's size is guessed" * self.input.size_guessed
        return f"SlipReport({len(self.input.contacts)} contacts, mean slip in mm{guessed}: {means})"

    def _repr_html_(self) -> str:
        slips = {_LABELS[name]: (each.mean, each.largest) for name, each in self._measured()}
        return slip_html(slips, len(self.input.contacts), guessed=self.input.size_guessed)

    def _measured(self) -> list[tuple[str, Slip]]:
        return [(field.name, getattr(self, field.name)) for field in fields(self)]


def retimed_slip(motion: Motion, warp: WarpLike, *, contacts: Contacts | None = None, loop: bool = False) -> SlipReport:
    """Measure what a warp, and averaging, do to standing feet.

    Parameters
    ----------
    motion : Motion
        The input.
    warp : Warp or GuidedWarp
        From output time to input time.
    contacts : Contacts, optional
        When the input's feet stand; left out, they are found. An output frame is in a contact if the input is, at
        the time that it shows.
    loop : bool
        As in `apply_warp`.

    Returns
    -------
    SlipReport
        Four measurements as `retime.motion.contacts.slip` defines them. Without averaging a foot is only where the
        input had it, so there is no more slip than in the input, but for the frame from which it is counted.
    """
    if not isinstance(motion, Motion):
        raise OptionError(f"expected retimed_slip(motion, warp) with a Motion, for feet slip; found {kind_of(motion)}")
    warp = as_warp(warp, "retimed_slip(motion, warp)")
    compare_ranges(motion, warp)
    if not (contacts is None or isinstance(contacts, Contacts)):
        raise OptionError(f"contacts must be Contacts or None, which finds them; found {kind_of(contacts)}")
    if contacts is not None:
        contacts.refuse_other(motion)
    if loop:
        check_seam(motion)
    standing = find_contacts(motion) if contacts is None else contacts
    shown = _contacts_shown(motion, warp, standing)

    def measured(average: bool, exempt: Contacts | None, keep_root_path: bool) -> Slip:
        return slip_of(resampled(motion, warp, average, exempt, keep_root_path, loop), standing.feet, shown)

    return SlipReport(
        input=slip(motion, standing),
        unaveraged=measured(False, None, True),
        plain=measured(True, None, False),
        contact_aware=measured(True, standing, True),
    )


def _contacts_shown(motion: Motion, warp: Warp, standing: Contacts) -> tuple[Contact, ...]:
    """Find the output frames of each contact, as far as they fall into it."""
    return standing.where_held().spans_at(warp(output_frame_times(warp, float(motion.rate))))


def slip_of_output(motion: Motion, warp: Warp, output: Motion, contacts: Contacts) -> tuple[Slip, Slip, Slip]:
    """Measure the slip of a motion and of what `apply_warp` made of it, which need not be made again.

    Parameters
    ----------
    motion : Motion
        The input.
    warp : Warp
        From output time to input time.
    output : Motion
        The input with this warp's timing.
    contacts : Contacts
        When the input's feet stand.

    Returns
    -------
    input, output, plain : Slip
        Of the input, of the output as it is, and of one with everything averaged as in the paper.
    """
    shown = _contacts_shown(motion, warp, contacts)
    legs, feet = _legs(motion, contacts.feet)
    plain = slip_of(resampled(legs, warp, True, None, False, False), feet, shown)
    return (
        slip(motion, contacts),
        slip_of(output, contacts.feet, shown),
        replace(plain, size_guessed=motion.metres_per_unit is None),
    )


def _legs(motion: Motion, feet: Sequence[Foot]) -> tuple[Motion, tuple[Foot, ...]]:
    """Cut out what the feet hang on, and find the feet there: where all is averaged, no joint needs the others."""
    skeleton = motion.skeleton
    joints = chain_of(skeleton, [foot.joint for foot in feet])
    sites = [i for i, site in enumerate(skeleton.end_sites) if site.parent in joints]
    legs = Motion(
        part_of(skeleton, joints),
        motion.rotations[:, joints],
        motion.local_translations[:, joints],
        motion.rate,
        # A guess takes all of the skeleton.
        metres_per_unit=metres_per_unit(motion),
        up=motion.up,
    )
    return legs, tuple(
        Foot(joints.index(foot.joint), None if foot.end_site is None else sites.index(foot.end_site)) for foot in feet
    )
