"""Contacts: when feet stand on the ground, and how far they slip there.

A foot stands where it is slow and low. Both are measured at joints (ankle and toes, each for itself), so a foot that
rolls over its toes lets go of the ankle first.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from retime.arrays import BoolArray, FloatArray, IntArray
from retime.brief import kind_of
from retime.errors import InvalidMotionError, OptionError
from retime.frames import frame_positions
from retime.motion.body import body_joints
from retime.motion.joint_names import body_parts, near_names
from retime.motion.kinematics import GlobalPlaces, global_places, limb_places, metres_per_unit
from retime.motion.moving import Moving
from retime.motion.picture import contacts_html
from retime.motion.rate import parse_rate

# Seconds to either side. Shorter than a leg's swing, so that on stairs no other step is looked at; longer than it
# takes to get to the top of a hop.
_LOW_WINDOW = 0.4
# Speeds are differences over a thirtieth of a second to either side: over one frame of 120 Hz, capture noise alone
# makes a tenth of a metre a second.
_SPEED_WINDOW = 1 / 30
# Seconds to either side in which a foot's highest speed is looked for: from either end of a stance it reaches into the
# swing beside it.
_SWING_WINDOW = 0.5
# Where names say nothing: a limb whose end is this near to whatever is lowest (metres) for this share of the time.
_LEG_HEIGHT = 0.1
_LEG_SHARE = 0.25


@dataclass(frozen=True)
class Foot:
    """A point of the body that may stand on the ground.

    Attributes
    ----------
    joint : int
        The joint; it and all joints above it decide where the point is.
    end_site : int, optional
        Index of an end site of that joint, where that is the point; left out, it is the joint itself.
    """

    joint: int
    end_site: int | None = None


@dataclass(frozen=True)
class Contact:
    """One stretch in which one foot stands.

    Attributes
    ----------
    foot : int
        Index into `Contacts.feet`.
    first_frame, last_frame : int
        Counted from 0, both included.
    """

    foot: int
    first_frame: int
    last_frame: int


@dataclass(frozen=True, eq=False)
class Contacts:
    """When each foot stands.

    Parameters
    ----------
    feet : tuple of Foot
        The points that were looked at.
    at_rest : bool array, shape (n_frames, n_feet)
        Whether each stands, in each frame.
    rate : Fraction, number or str
        Frames a second; kept as an exact fraction.
    held : bool array, shape (n_frames, n_feet), optional
        Whether each stays put: it stands, and does not roll. Slip is measured there. Left out: wherever it stands.

    Raises
    ------
    InvalidMotionError
        An array has another shape, or a foot is held where it does not stand.
    OptionError
        The rate is none.
    """

    feet: tuple[Foot, ...]
    at_rest: BoolArray
    rate: Fraction
    held: BoolArray | None = None

    def __post_init__(self) -> None:
        at_rest = np.array(self.at_rest, dtype=np.bool_)
        held = at_rest if self.held is None else np.array(self.held, dtype=np.bool_)
        if at_rest.ndim != 2 or len(at_rest) == 0 or at_rest.shape[1] != len(self.feet) or held.shape != at_rest.shape:
            raise InvalidMotionError(
                f"expected contacts of shape (n_frames >= 1, {len(self.feet)} feet), found "
                + (f"{at_rest.shape}" if held.shape == at_rest.shape else f"{at_rest.shape} and {held.shape}")
            )
        if np.any(held & ~at_rest):
            frame, foot = (int(i) for i in np.argwhere(held & ~at_rest)[0])
            raise InvalidMotionError(f"foot {foot} is held at frame {frame}, where it does not stand")
        for name, array in (("at_rest", at_rest), ("held", held)):
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        object.__setattr__(self, "rate", parse_rate(self.rate))

    def __repr__(self) -> str:
        return (
            f"Contacts({len(self.spans())} contacts of {len(self.feet)} feet, {self.n_frames} frames at {self.rate} Hz)"
        )

    def _repr_html_(self) -> str:
        feet = [f"joint {foot.joint}" if foot.end_site is None else f"end {foot.end_site}" for foot in self.feet]
        spans = [(span.foot, span.first_frame, span.last_frame) for span in self.spans()]
        return contacts_html(feet, spans, self.n_frames, float(self.rate))

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.at_rest)

    def refuse_other(self, motion: Moving) -> None:
        """Raise OptionError where these can't be a motion's contacts: they have another number of frames."""
        if self.n_frames != motion.n_frames:
            raise OptionError(
                f"the contacts are those of {self.n_frames} frames, but {motion.name or 'the motion'} has "
                f"{motion.n_frames}"
            )

    def where_held(self) -> Contacts:
        """Return the contacts cut down to the frames in which the foot is held, and does not roll."""
        return Contacts(self.feet, cast(BoolArray, self.held), self.rate)

    def at(self, input_times: ArrayLike) -> Contacts:
        """Sample at any times: between two frames a foot stands if it does in both.

        Parameters
        ----------
        input_times : float array, shape (n,)
            Seconds from the first frame; held at the ends outside.

        Returns
        -------
        Contacts
            `n` frames, at this rate whatever the spacing of the times: as `Motion.at`. Two contacts become one where
            nothing of what lies between them is sampled; `spans_at` keeps them apart.
        """
        held = self.where_held()._numbers_at(input_times) > 0
        return Contacts(self.feet, self._numbers_at(input_times) > 0, self.rate, held)

    def spans(self) -> tuple[Contact, ...]:
        """List the contacts: foot by foot, in the order of time."""
        return self._spans(self._numbers())

    def spans_at(self, input_times: ArrayLike) -> tuple[Contact, ...]:
        """List the contacts that are shown at some times: those of a retimed motion, in its own frames.

        Between two frames a foot stands if it does in both. Two contacts stay two, even where nothing of what lies
        between them is shown.

        Parameters
        ----------
        input_times : float array, shape (n,)
            Seconds from the first frame; held at the ends outside.
        """
        return self._spans(self._numbers_at(input_times))

    def _numbers(self) -> IntArray:
        """For each frame and foot which of the foot's contacts it is in, from 1; 0 where it is in none."""
        begins = self.at_rest & ~np.concatenate([np.zeros_like(self.at_rest[:1]), self.at_rest[:-1]])
        return np.cumsum(begins, axis=0) * self.at_rest

    def _numbers_at(self, input_times: ArrayLike) -> IntArray:
        before, after, fraction = frame_positions(input_times, self.rate, self.n_frames)
        numbers = self._numbers()
        # Neighbouring frames are in one contact, or one of them is in none.
        return np.asarray(np.minimum(numbers[before], numbers[np.where(fraction > 0, after, before)]))

    def _spans(self, numbers: IntArray) -> tuple[Contact, ...]:
        spans = []
        for foot, column in enumerate(numbers.T):
            edges = np.flatnonzero(np.diff(column, prepend=-1, append=-1))
            spans += [
                Contact(foot, int(first), int(stop) - 1)
                for first, stop in itertools.pairwise(edges.tolist())
                if column[first]
            ]
        return tuple(spans)


def contacts(
    motion: Moving,
    *,
    feet: Sequence[str] | None = None,
    speed: float = 0.2,
    swing_share: float = 0.12,
    most_speed: float = 0.6,
    rise: float = 0.04,
    height: float = 0.25,
    gap: float = 0.1,
    minimum: float = 0.05,
) -> Contacts:
    """Find where feet stand: where a joint of a foot is slow, and low.

    *Slow*: the joint moves at less than `speed`, and so is held in place; or at less than a share of its own highest
    speed within half a second, its swing's, and so it rolls: the faster a walk, the faster a foot still rolls while it
    bears the body. Speeds are measured over a thirtieth of a second to either side. *Low*: it is at
    most `rise` above the lowest place where it is slow within 0.4 seconds, and at most `height` above whatever is
    lowest at the moment. Captured floors are not level, stairs are not one floor, and how high above its sole a foot's
    joints are is not known: so the first of the two decides, and the second only keeps out a foot (or a hand) that
    rests in the air.

    Where the skeleton's names say which joints are feet and toes (see `retime.motion.joint_names`), those are looked
    at. Else a leg is a limb whose end (its last joint, or an end site of that) is within 10 cm of whatever is lowest
    for a quarter of the time.

    Parameters
    ----------
    motion : Motion
        Y up; `metres_per_unit` gives its size.
    feet : sequence of str, optional
        Names of the joints to look at in place of these: hands, for a handstand. Of a repeated name every joint.
    speed : float
        Metres a second: a slower joint is held in place.
    swing_share : float
        Share of its highest speed within half a second below which a joint rolls; 0 is off.
    most_speed : float
        Metres a second: a faster joint does not roll, whatever its swing.
    rise, height : float
        Metres.
    gap : float
        Seconds; breaks in a contact up to so long are closed.
    minimum : float
        Seconds; shorter contacts are dropped afterwards (and those of a single frame).

    Returns
    -------
    Contacts
        One foot for each joint that was looked at; none where the motion has no feet.

    Raises
    ------
    OptionError
        A joint that the skeleton has not.

    Examples
    --------
    A leg that stands for a second, and then swings:

    >>> from retime.motion import rotation
    >>> from retime.motion.motion import Motion
    >>> from retime.motion.skeleton import Skeleton
    >>> leg = Skeleton(("Hips", "LeftFoot"), (-1, 0), np.array([[0.0, 0.8, 0.0], [0.0, -0.7, 0.0]]))
    >>> swing = np.radians(np.concatenate([np.zeros(30), np.arange(15.0) * 4]))
    >>> q = np.stack([rotation.about_axis(0, swing), rotation.identity(45)], axis=1)
    >>> contacts(Motion(leg, q, metres_per_unit=1.0)).spans()
    (Contact(foot=0, first_frame=0, last_frame=29),)
    """
    if not isinstance(motion, Moving):
        raise OptionError(f"expected contacts(motion) with a Motion, for feet stand; found {kind_of(motion)}")
    poses = global_places(motion)
    scale = metres_per_unit(motion)
    rate = float(motion.rate)
    # What hangs elsewhere than below the joint that carries the body is no part of the figure.
    body = body_joints(motion)
    lowest = np.min(poses.positions[:, body, 1], axis=1)
    ends = [i for i, site in enumerate(motion.skeleton.end_sites) if site.parent in body]
    if ends:
        lowest = np.minimum(lowest, poses.end_positions[:, ends, 1].min(axis=1))
    if feet is None:
        named = tuple(foot for foot in named_feet(motion.skeleton.names) if foot.joint in body)
        found = named or _lowest_limbs(motion, body, poses, lowest, scale)
    else:
        found = tuple(Foot(joint) for name in feet for joint in _joints(motion.skeleton.names, name))

    points = _points(poses, found) * scale
    heights = points[:, :, 1]
    lag = max(1, round(_SPEED_WINDOW * rate))
    frames = np.arange(motion.n_frames)
    before, after = np.maximum(frames - lag, 0), np.minimum(frames + lag, motion.n_frames - 1)
    seconds = np.maximum(after - before, 1)[:, None] / rate
    step = points[after] - points[before]
    speeds = np.sqrt(np.einsum("fpc,fpc->fp", step, step)) / seconds
    swing = -lowest_around(-speeds, max(1, round(_SWING_WINDOW * rate)))
    reach = max(1, round(_LOW_WINDOW * rate))

    def standing(fastest: FloatArray | float) -> BoolArray:
        slow = speeds < fastest
        places = lowest_around(np.where(slow, heights, np.inf), reach)
        at_rest = slow & (heights <= places + rise) & (heights <= lowest[:, None] * scale + height)
        return _without_flicker(at_rest, gap * rate, max(2.0, minimum * rate))

    held = standing(speed)
    rolling = standing(np.maximum(np.minimum(swing_share * swing, most_speed), speed))
    return Contacts(found, held | rolling, motion.rate, held)


def _without_flicker(at_rest: BoolArray, gap: float, least: float) -> BoolArray:
    """Close breaks of `gap` frames or less, then drop what is shorter than `least` frames."""
    for column in at_rest.T:
        for first, stop in runs(~column):
            if first > 0 and stop < len(column) and stop - first <= gap:
                column[first:stop] = True
        for first, stop in runs(column):
            if stop - first < least:
                column[first:stop] = False
    return at_rest


def named_feet(names: Sequence[str]) -> tuple[Foot, ...]:
    """Find the joints that names call feet or toes (see `retime.motion.joint_names`); none where they don't."""
    # Where a name repeats, every joint of that name: which comes first in a file says nothing.
    parts = enumerate(body_parts(names, repeated=True))
    return tuple(Foot(joint) for joint, part in parts if part is not None and part.base in ("foot", "toes"))


def _joints(names: Sequence[str], name: str) -> list[int]:
    """Find all joints of a name: files may repeat one."""
    if name not in names:
        raise OptionError(f"no joint is called {name!r}{near_names(name, names)}")
    return [joint for joint, other in enumerate(names) if other == name]


def _lowest_limbs(
    motion: Moving, body: Sequence[int], poses: GlobalPlaces, lowest: FloatArray, scale: float
) -> tuple[Foot, ...]:
    """Find the ends of limbs that are among the lowest things for a good part of the time."""
    skeleton = motion.skeleton
    found = []
    # The body's first joint is no limb: what hangs on it alone is a prop, not a leg.
    for joint in sorted(set(body[1:]) - set(skeleton.parents)):
        sites = [i for i, site in enumerate(skeleton.end_sites) if site.parent == joint]
        ends = [Foot(joint), *(Foot(joint, site) for site in sites)]
        heights = (_points(poses, ends)[:, :, 1] - lowest[:, None]) * scale
        end = int(np.argmin(heights.mean(axis=0)))
        if np.mean(heights[:, end] <= _LEG_HEIGHT) >= _LEG_SHARE:
            found.append(ends[end])
    return tuple(found)


def _points(poses: GlobalPlaces, feet: Sequence[Foot]) -> FloatArray:
    """Global places of feet, shape (n_frames, n_feet, 3)."""
    points = np.empty((len(poses.positions), len(feet), 3))
    for i, foot in enumerate(feet):
        ends = foot.end_site is not None
        points[:, i] = poses.end_positions[:, foot.end_site] if ends else poses.positions[:, foot.joint]
    return points


def lowest_around(values: FloatArray, reach: int) -> FloatArray:
    """Least of the values (n_frames, ...) within `reach` frames of each, by windows that double in length."""
    width, least = 1, np.pad(values, [(reach, reach), *[(0, 0)] * (values.ndim - 1)], mode="edge")
    while width < 2 * reach + 1:
        more = min(width, 2 * reach + 1 - width)
        least = np.minimum(least[:-more], least[more:])
        width += more
    return least


def runs(column: BoolArray) -> list[tuple[int, int]]:
    """List the runs of True: the first frame of each, and the frame after its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], column.astype(np.int8), [0]])))
    return [(int(first), int(stop)) for first, stop in edges.reshape(-1, 2)]


@dataclass(frozen=True, eq=False)
class Slip:
    """How far feet slide while they stand.

    Attributes
    ----------
    contacts : tuple of Contact
        The contacts that were measured.
    millimetres : float array, shape (n_contacts,)
        For each, how far its foot gets, along the ground, from where it was in the contact's first frame.
    size_guessed : bool
        Whether the figure was taken for a person of 1.7 m, since its file doesn't say how long a unit is.
    """

    contacts: tuple[Contact, ...]
    millimetres: FloatArray
    size_guessed: bool = False

    def __repr__(self) -> str:
        about = "about " * self.size_guessed
        return f"Slip({about}mm in {len(self.contacts)} contacts: mean {self.mean:.1f}, largest {self.largest:.1f})"

    @property
    def mean(self) -> float:
        """Millimetres a contact; 0 where there is none."""
        return float(self.millimetres.mean()) if len(self.millimetres) else 0.0

    @property
    def largest(self) -> float:
        """Millimetres of the worst contact; 0 where there is none."""
        return float(self.millimetres.max()) if len(self.millimetres) else 0.0

    @property
    def total(self) -> float:
        """Millimetres of all contacts together."""
        return float(self.millimetres.sum())


def slip(motion: Moving, contacts: Contacts) -> Slip:
    """Measure how far feet slide while they stand, and are held: rolling from heel to toe is no slip.

    A contact's slip is the greatest distance, along the ground (X and Z), between the place of its foot in the
    contact's first frame and its place in any later frame of the contact. So a foot that trembles on the spot counts
    by the size of the trembling, whatever the rate; a foot that slides away and back by how far it went.

    Parameters
    ----------
    motion : Motion
        Y up. In millimetres by `metres_per_unit`, which is a guess where the file doesn't say.
    contacts : Contacts
        When its feet stand: of this motion, frame by frame.

    Raises
    ------
    OptionError
        The contacts are of another number of frames.
    """
    contacts.refuse_other(motion)
    return slip_of(motion, contacts.feet, contacts.where_held().spans())


def slip_of(motion: Moving, feet: Sequence[Foot], spans: Sequence[Contact]) -> Slip:
    """Measure as `slip` does, in given contacts."""
    points = [(foot.joint, foot.end_site) for foot in feet]
    ground = limb_places(motion, points)[:, :, [0, 2]] * metres_per_unit(motion)
    slips = np.zeros(len(spans))
    for i, span in enumerate(spans):
        places = ground[span.first_frame : span.last_frame + 1, span.foot]
        slips[i] = np.sqrt(np.max(np.sum((places - places[0]) ** 2, axis=-1))) * 1000
    return Slip(tuple(spans), slips, motion.metres_per_unit is None)
