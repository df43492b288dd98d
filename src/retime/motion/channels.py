"""What the numbers of a channel are: lengths, angles, rotations, labels, events, times.

A number between two others means something else for each: between 179 and -179 degrees lies 180 and not 0, between the
labels 0 and 7 there is nothing.
"""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np

from retime.arrays import FloatArray
from retime.brief import brief, kind_of
from retime.errors import OptionError

KindName = Literal["linear", "angle", "quaternion", "label", "event", "time"]
KIND_NAMES = get_args(KindName)
FULL_TURN = {"deg": 360.0, "rad": 2 * np.pi}
"""What a full turn is, in each unit of an angle."""
NumberForm = Literal["", "whole", "boolean"]
_TIME_UNITS = ("s", "ms", "us", "frames")
_LIKELIHOOD = "likelihood"


@dataclass(frozen=True)
class ChannelKind:
    """What one channel holds.

    Parameters
    ----------
    kind : str
        ``linear``: in between lies the mean (a length, a weight). ``angle``: a full turn is none. ``quaternion``: one
        of four columns that are a rotation together. ``label``: a number that stands for something, so that nothing
        lies between two of them (a contact, an id, a word). ``event``: what happens at one frame, 0 elsewhere.
        ``time``: a clock of its own.
    unit : str
        Of an angle ``deg`` (if left out) or ``rad``; of a time ``s`` (if left out), ``ms``, ``us`` or ``frames``. Of a
        linear channel any text, for people; ``likelihood`` says how sure other channels are, and so doesn't weigh in
        the search.
    words : tuple of str
        Of a label that is text: the value of a frame is the place of its word here, from 0.
    form : {"", "whole", "boolean"}
        As what its file has the numbers: decimals, whole numbers, or true and false. Two kinds that differ in this, or
        in `numerals`, are equal: it says how to write values, not what they are.
    numerals : tuple of str
        How its file writes the numbers of a label or an event (``007``, ``1.0``), a text for each; none where they are
        plain whole numbers.

    Raises
    ------
    OptionError
        No such kind, or a unit that it can't have.

    Examples
    --------
    >>> ChannelKind.parse("angle:rad").unit, str(ChannelKind("angle")), ChannelKind("label").weighs
    ('rad', 'angle:deg', False)
    """

    kind: KindName = "linear"
    unit: str = ""
    words: tuple[str, ...] = ()
    form: NumberForm = field(default="", compare=False, repr=False)
    numerals: tuple[str, ...] = field(default=(), compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.kind not in KIND_NAMES:
            raise OptionError(f"the kind of a channel is one of {', '.join(KIND_NAMES)}; found {brief(self.kind)}")
        units = {"angle": tuple(FULL_TURN), "time": _TIME_UNITS}.get(self.kind, ())
        if units and not self.unit:
            object.__setattr__(self, "unit", units[0])
        elif self.kind != "linear" and self.unit and self.unit not in units:
            has = f"is in {' or '.join(units)}" if units else "has no unit"
            raise OptionError(f"{'an' if self.kind[0] in 'ae' else 'a'} {self.kind} {has}; found {brief(self.unit)}")
        if isinstance(self.words, str) or not all(isinstance(word, str) for word in self.words):
            raise OptionError(f"the words of a label are texts; found {kind_of(self.words)}")
        object.__setattr__(self, "words", tuple(self.words))
        if self.words and self.kind != "label":
            raise OptionError(f"only a label has words; found them with the kind {self.kind}")
        if self.form not in get_args(NumberForm):
            raise OptionError(f"the form of numbers is one of '', 'whole', 'boolean'; found {brief(self.form)}")
        object.__setattr__(self, "numerals", tuple(self.numerals))

    @classmethod
    def parse(cls, text: str) -> ChannelKind:
        """Read ``KIND`` or ``KIND:UNIT``; raise OptionError where it is neither."""
        kind, _, unit = text.strip().partition(":")
        return cls(kind.strip().lower(), unit.strip())  # type: ignore[arg-type]

    def __str__(self) -> str:
        return f"{self.kind}:{self.unit}" if self.unit else self.kind

    @property
    def weighs(self) -> bool:
        """Whether the search looks at it."""
        return self.kind in ("linear", "angle", "quaternion") and self.unit != _LIKELIHOOD


LINEAR = ChannelKind()
KindLike = ChannelKind | str
KindsLike = Sequence[KindLike] | Mapping[str, KindLike]
"""A kind for each channel, or kinds by names or patterns of names (``*`` and ``?``); other channels' are found."""


def as_kind(kind: KindLike) -> ChannelKind:
    """Take a kind, or the text of one; raise OptionError."""
    if isinstance(kind, ChannelKind):
        return kind
    if isinstance(kind, str):
        return ChannelKind.parse(kind)
    raise OptionError(f"the kind of a channel is text, such as 'angle:deg'; found {kind_of(kind)}")


def as_kinds(kinds: KindsLike | None, names: Sequence[str], values: FloatArray) -> tuple[ChannelKind, ...]:
    """Give each channel its kind: as was said, else as `find_kinds` does.

    Parameters
    ----------
    kinds : sequence, mapping or None
        See `KindsLike`. Of several patterns that a name fits, the last one holds. Nothing: all are found.
    names : sequence of str
        Of the channels.
    values : float array, shape (n_frames, n_channels)
        What they hold.

    Raises
    ------
    OptionError
        A pattern that no name fits, another number of kinds than of channels, or something that is no kind.
    """
    if not kinds:
        return find_kinds(names, values)
    if isinstance(kinds, Mapping):
        return with_chosen(find_kinds(names, values), names, kinds)
    if isinstance(kinds, str) or not isinstance(kinds, Sequence):
        raise OptionError(f"the kinds of channels are one for each, or a mapping of names; found {kind_of(kinds)}")
    if len(kinds) != len(names):
        raise OptionError(f"expected a kind for each of {len(names)} channels; found {len(kinds)}")
    return tuple(as_kind(kind) for kind in kinds)


def with_chosen(
    found: Sequence[ChannelKind], names: Sequence[str], chosen: Mapping[str, KindLike], *, all_fit: bool = True
) -> tuple[ChannelKind, ...]:
    """Put the kinds that were chosen by names or patterns in place of those that were found.

    Raises
    ------
    OptionError
        Something that is no kind, or, with `all_fit`, a pattern that no name fits.
    """
    kinds = list(found)
    for pattern, kind in chosen.items():
        places = matching(pattern, names)
        if not places and all_fit:
            some = ", ".join(names[:12]) + (" ..." if len(names) > 12 else "")
            raise OptionError(f"no channel is called {pattern!r}; there are {some}")
        for place in places:
            one = as_kind(kind)
            # Text stays text, whatever is said about it.
            words = kinds[place].words if one.kind == "label" and not one.words else one.words
            if kinds[place].words and one.kind != "label":
                raise OptionError(f"channel {names[place]!r} holds text, which can only be a label")
            # How its file writes it stays known too.
            kinds[place] = replace(one, words=words, form=kinds[place].form, numerals=kinds[place].numerals)
    return tuple(kinds)


def matching(pattern: str, names: Sequence[str]) -> list[int]:
    """List the channels that a name or a pattern means; a name that is there is never taken for a pattern."""
    if pattern in names:
        return [place for place, name in enumerate(names) if name == pattern]
    return [place for place, name in enumerate(names) if fnmatch.fnmatchcase(name, pattern)]


def parse_channel(text: str) -> tuple[str, ChannelKind]:
    """Read ``NAME=KIND[:UNIT]``, where the name may be a pattern; raise OptionError.

    Examples
    --------
    >>> parse_channel("*_yaw=angle:deg")
    ('*_yaw', ChannelKind(kind='angle', unit='deg', words=()))
    """
    # A name may hold a sign of equality; no kind does.
    name, sign, kind = text.rpartition("=")
    if not (sign and name.strip() and kind.strip()):
        raise OptionError(f"expected a channel and its kind, such as 'pan=angle:deg' or '*_id=label'; found {text!r}")
    return name.strip(), ChannelKind.parse(kind)


def parse_channels(text: str) -> dict[str, ChannelKind]:
    """Read several of `parse_channel`, with commas between them; raise OptionError.

    Examples
    --------
    >>> {name: str(kind) for name, kind in parse_channels("pan=angle:rad, *_id=label").items()}
    {'pan': 'angle:rad', '*_id': 'label'}
    """
    return dict(parse_channel(part) for part in text.split(",") if part.strip())


def text_label(texts: Sequence[str]) -> tuple[FloatArray, ChannelKind]:
    """Give each word of a column of text a number.

    Parameters
    ----------
    texts : sequence of str
        The word of each frame.

    Returns
    -------
    float array, shape (n_frames,)
        Its place among the words: of FALSE and TRUE 0 and 1, others in the order in which they first appear.
    ChannelKind
        A label with those words.

    Examples
    --------
    >>> codes, kind = text_label(["walk", "walk", "run"])
    >>> codes.tolist(), kind.words
    ([0.0, 0.0, 1.0], ('walk', 'run'))
    """
    words = list(dict.fromkeys(texts))
    if {word.lower() for word in words} <= {"false", "true"}:
        words.sort(key=str.lower)
        if len(words) == 1 and words[0].lower() == "true":
            # So that TRUE is 1 also where nothing is FALSE.
            words.insert(0, {"TRUE": "FALSE", "True": "False"}.get(words[0], "false"))
    places = {word: float(place) for place, word in enumerate(words)}
    return np.array([places[text] for text in texts]), ChannelKind("label", words=tuple(words))


def quaternion_groups(names: Sequence[str], kinds: Sequence[ChannelKind]) -> list[tuple[int, ...]]:
    """Put the columns of rotations together by fours.

    Those whose names differ in one letter, w, x, y or z, are one rotation; where names don't say it so of all of them,
    each four in their order are one.

    Raises
    ------
    OptionError
        Their number can't be divided by four.
    """
    columns = [place for place, kind in enumerate(kinds) if kind.kind == "quaternion"]
    if len(columns) % 4:
        raise OptionError(
            f"a quaternion is four columns; found {len(columns)}: {', '.join(names[place] for place in columns[:9])}"
        )
    by_name = _fours([names[place] for place in columns])
    if sum(map(len, by_name)) == len(columns):
        return [tuple(columns[i] for i in four) for four in by_name]
    return [tuple(columns[i : i + 4]) for i in range(0, len(columns), 4)]


def _fours(names: Sequence[str]) -> list[tuple[int, ...]]:
    """Find names that differ in one letter alone, which is w, x, y and z."""
    stems: dict[str, dict[str, int]] = {}
    for place, name in enumerate(names):
        if (
            axis := re.search(r"(?<![A-Za-z])[wxyz](?![A-Za-z])|(?<=[qQ])[wxyzWXYZ](?![a-z])|[WXYZ](?![a-z])", name)
        ) or (axis := re.search(r"[wxyz]$", name)):
            stem = f"{name[: axis.start()]}\0{name[axis.end() :]}"
            stems.setdefault(stem, {})[axis.group().lower()] = place
    return [tuple(axes.values()) for axes in stems.values() if set(axes) == set("wxyz")]


def find_kinds(names: Sequence[str], values: FloatArray) -> tuple[ChannelKind, ...]:
    """Find what channels hold, where both their names and their values say it; the others are linear.

    Parameters
    ----------
    names : sequence of str
        Of the channels.
    values : float array, shape (n_frames, n_channels)
        What they hold; a hole is not a number.

    Examples
    --------
    >>> found = find_kinds(["yaw_deg", "left_contact", "x"], np.array([[179.0, 0, 0], [-179.0, 1, 1]]))
    >>> [str(kind) for kind in found]
    ['angle:deg', 'label', 'linear']
    """
    kinds = [LINEAR] * len(names)
    for four in _fours(names):
        lengths = (
            np.sqrt((values[:, four] ** 2).sum(axis=1)) if np.all(_in(values[:, four], -1.1, 1.1)) else np.zeros(1)
        )
        if np.all(_in(lengths, 0.98, 1.02)) and np.isfinite(lengths).any():
            for place in four:
                kinds[place] = ChannelKind("quaternion")
    for place, name in enumerate(names):
        if kinds[place] is LINEAR:
            column = values[:, place]
            words = _words_of(name)
            kinds[place] = _kind_by(words, name, column[np.isfinite(column)])
    return tuple(kinds)


_ANGLES = {
    "yaw",
    "pitch",
    "roll",
    "heading",
    "azimuth",
    "bearing",
    "angle",
    "pan",
    "tilt",
    "rot",
    "rotation",
    "euler",
} | {
    "rx",
    "ry",
    "rz",
    "theta",
    "phi",
    "psi",
}
_UNITS = {
    **dict.fromkeys(("deg", "degs", "degree", "degrees", "°"), "deg"),
    **dict.fromkeys(("rad", "rads", "radian", "radians"), "rad"),
}
_LABELS = {
    "contact",
    "contacts",
    "label",
    "labels",
    "id",
    "ids",
    "class",
    "state",
    "phase",
    "action",
    "flag",
    "category",
} | {
    "mode",
    "grounded",
    "visible",
    "occluded",
    "valid",
}
_LIKELIHOODS = {"likelihood", "confidence", "conf", "visibility", "probability", "prob", "score"}
_CLOCKS = {"time", "timestamp", "seconds", "milliseconds"}
# More different numbers than this are counts or sizes, not names of things.
_MOST_LABELS = 64


def are_few(n_different: int, n_frames: int) -> bool:
    """Tell numbers that can be names of things, of which there are few, from counts and sizes."""
    return n_different <= _MOST_LABELS and n_different * 2 <= max(n_frames, 4)


def _words_of(name: str) -> list[str]:
    """Take a name apart at signs, and where small letters change to large ones."""
    parted = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", name)
    return [word.lower() for word in re.findall(r"[^\W_\d]+|°", parted)]


def _kind_by(words: Sequence[str], name: str, values: FloatArray) -> ChannelKind:
    """Say what a channel holds whose name has these words; linear where the values don't agree."""
    if not len(values) or not words:
        return LINEAR
    said = set(words)
    if said & _LIKELIHOODS and np.all(_in(values, 0.0, 1.0)):
        return ChannelKind("linear", _LIKELIHOOD)
    if words[0] in _CLOCKS and len(values) > 2 and np.all(np.diff(values) > 0):
        return ChannelKind("time", "ms" if said & {"ms", "milliseconds"} else "s")
    if np.all(values == np.round(values)):
        n_different = len(np.unique(values[:4096])) if len(values) > 4096 else len(np.unique(values))
        if said & {"event", "events"} and np.count_nonzero(values) * 10 <= len(values):
            return ChannelKind("event")
        if said & _LABELS and are_few(n_different, len(values)):
            return ChannelKind("label")
    unit = _UNITS.get(words[-1])
    if unit == "deg" or (unit == "rad" and np.abs(values).max() <= 2 * FULL_TURN["rad"]):
        return ChannelKind("angle", unit)
    if said & _ANGLES:
        for unit, turn in FULL_TURN.items():
            # Only where it goes round does it matter: a jump of nearly a full turn, within one.
            low = -turn / 2 if values.min() < 0 else 0.0
            inside = np.all(_in(values, low * (1 + 1e-3), (low + turn) * (1 + 1e-3)))
            if inside and len(values) > 1 and np.abs(np.diff(values)).max() > 0.8 * turn:
                return ChannelKind("angle", unit)
    return LINEAR


def _in(values: FloatArray, low: float, high: float) -> np.ndarray:
    """Tell which numbers lie in a range; holes do."""
    return np.asarray(np.isnan(values) | ((values >= low) & (values <= high)))
