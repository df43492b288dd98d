"""What one clip of many gets: the options of `retime warp`, as they are written there.

A treatment is text and plain numbers, so that it can be written down, hashed, and sent to another machine; it is read
again where the clip is at hand, for a length in frames means nothing before its rate is known.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from retime.brief import brief_repr
from retime.errors import OptionError
from retime.motion.channels import parse_channel
from retime.motion.gaps import GapPolicy
from retime.motion.grammar import parse_frame_range, parse_speeds, read_key, read_lock, read_span
from retime.motion.rate import parse_rate
from retime.search.options import BY_NAME
from retime.search.written import option_reader

Method = Literal["guided", "linear", "spline"]

# What says how long a variant is, or where its moments are: variants draw it.
_DRAWN = ("length", "min_length", "max_length", "free_weight")
# As many frames as a range can speak of.
_MANY_FRAMES = 10**15


def _range(text: str) -> None:
    parse_frame_range(text, 2 * _MANY_FRAMES, -_MANY_FRAMES)


def _path(text: str) -> None:
    if not text or "\0" in text:
        raise OptionError(f"expected the name of a file, found {text!r}")


def _ending(text: str) -> None:
    if not (text.startswith(".") and len(text) > 1) or "/" in text or "\\" in text:
        raise OptionError(f"expected a file's ending such as .bvh, found {text!r}")


def _name_beside(text: str) -> None:
    if "{stem}" not in text or "/" in text or "\\" in text:
        raise OptionError(f"expected a file's name with {{stem}} in it, such as {{stem}}_labels.csv, found {text!r}")


def _written(read: Callable[[str], object], *, many: bool = False) -> Any:
    """Declare a field that holds text, or several texts."""
    return field(default=() if many else None, metadata={"read": read, "many": many})


@dataclass(frozen=True)
class Treatment:
    """What one clip gets; what is left out is as `retime warp` has it.

    Attributes
    ----------
    search : mapping of str to (str, float, bool)
        Options of the search by their names (`retime.guided_warp`), as text or plain values.
    method : {"guided", "linear", "spline"}
        As of ``retime warp --method``.
    key, lock, keep : tuple of str
        Keytimes, locks and stretches not to be cut, as ``2.5=1.8``, ``1..2=1/2``, ``60f..90f``.
    reference : tuple of str
        Files to be imitated; none: the clip itself.
    reference_frames : str, optional
        Frames of the reference (of the clip, where there is none), ``A:B``.
    mirror : bool
        Imitate the reference's mirror image too.
    frames : str, optional
        Frames used of the clip, ``A:B``, as its file numbers them, both included.
    drop_first : int
        Frames left out at the start.
    fps, skeleton, up, root, gaps : str, optional
        As of ``retime warp``, for clip and references.
    channel, array : tuple of str
        As of ``retime warp``.
    animation : str, optional
        Of a scene, the animation that is meant.
    repair, decimal_comma : bool
        As of ``retime warp``.
    average : bool
        Average where the motion is sped up (§3.4).
    on : int
        For how many frames each pose is held.
    format : str, optional
        Ending of the output; left out, the clip's own.
    variants : int
        How many different timings a clip gets; 0: one warp, as the other options say.
    speeds : str, optional
        Of variants: the mean speeds between which their lengths are drawn, ``0.8..1.25``. Written ``speed``, as
        of the command; without variants that is the search's.
    seed : int
        Of variants.
    draw_references : bool
        Of variants: each imitates one of the references, drawn, in place of all of them.
    beside : tuple of str
        Files beside the clip that go through the same warp, such as ``{stem}_labels.csv``.
    """

    search: Mapping[str, Any] = field(default_factory=dict)
    method: Method = "guided"
    key: tuple[str, ...] = _written(read_key, many=True)
    lock: tuple[str, ...] = _written(read_lock, many=True)
    keep: tuple[str, ...] = _written(read_span, many=True)
    reference: tuple[str, ...] = _written(_path, many=True)
    reference_frames: str | None = _written(_range)
    mirror: bool = False
    frames: str | None = _written(_range)
    drop_first: int = 0
    fps: str | None = _written(parse_rate)
    skeleton: str | None = _written(_path)
    up: str | None = None
    root: str | None = None
    gaps: str | None = _written(GapPolicy.parse)
    channel: tuple[str, ...] = _written(parse_channel, many=True)
    array: tuple[str, ...] = _written(_path, many=True)
    animation: str | None = None
    repair: bool = False
    decimal_comma: bool = False
    average: bool = True
    on: int = 1
    format: str | None = _written(_ending)
    variants: int = 0
    speeds: str | None = _written(parse_speeds)
    seed: int = 0
    draw_references: bool = False
    beside: tuple[str, ...] = _written(_name_beside, many=True)

    __repr__ = brief_repr

    def __post_init__(self) -> None:
        if self.method not in ("guided", "linear", "spline"):
            raise OptionError(f"method must be guided, linear or spline; found {self.method!r}")
        if self.up not in (None, "y", "z"):
            raise OptionError(f"up must be y or z; found {self.up!r}")
        if self.speeds is not None and parse_speeds(self.speeds)[1] == float("inf"):
            raise OptionError(f"variants need a fastest speed, as in 0.8..1.25; found {self.speeds!r}")
        if not self.variants:
            if self.speeds is not None:
                raise OptionError("the range of mean speeds is for variants (variants = 8)")
            if self.draw_references:
                raise OptionError("references are drawn for variants (variants = 8)")
            return
        drawn = [name for name in _DRAWN if name in self.search] + ["key"] * bool(self.key)
        if drawn or self.method != "guided":
            raise OptionError(
                f"variants have lengths and keys of their own: {', '.join(drawn) or self.method} can't be combined "
                "with them"
            )

    def with_(self, given: Mapping[str, Any]) -> Treatment:
        """Return this treatment with other settings, as `settings` returns them."""
        fields = {name: value for name, value in given.items() if name in _FIELDS}
        search = {name: value for name, value in given.items() if name not in _FIELDS}
        search = {**self.search, **search}
        if fields.get("variants", self.variants):
            if "speed" in search:
                # Of variants it says between which mean speeds their lengths are drawn, wherever it was written.
                fields.setdefault("speeds", str(search.pop("speed")))
        else:
            # What is for variants alone, and was said further out.
            fields = {"speeds": None, "draw_references": False} | fields
        return dataclasses.replace(self, search=search, **fields)

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON has it, without what is at its default: what `settings` reads."""
        found = {
            one.name: list(value) if isinstance(value, tuple) else value
            for one in dataclasses.fields(self)
            if one.name != "search" and (value := getattr(self, one.name)) != one.default
        }
        return found | dict(self.search)


_FIELDS = {one.name: one for one in dataclasses.fields(Treatment) if one.name != "search"}


def settings(given: Mapping[str, Any], *, place: str = "") -> dict[str, Any]:
    """Check settings as a recipe, or a keyword, has them; return them as `Treatment.with_` takes them.

    Names are those of `Treatment` and of the search's options, with ``_`` or ``-``. Where several texts may stand, one
    may stand alone.

    Parameters
    ----------
    given : mapping of str to object
        Settings by their names.
    place : str
        Where they stand, for messages.

    Raises
    ------
    OptionError
        No such setting, or a value that says nothing.

    Examples
    --------
    >>> settings({"length": "80%", "lock": "1..2", "max-skip": 3})
    {'length': '80%', 'lock': ('1..2',), 'max_skip': 3}
    """
    found: dict[str, Any] = {}
    for written, value in given.items():
        name = written.replace("-", "_")
        try:
            if name in _FIELDS:
                found[name] = _field_value(name, value)
            elif name in BY_NAME:
                found[name] = _search_value(name, value)
            else:
                raise OptionError(f"there is no such setting; {_like(name)}")
        except OptionError as error:
            raise OptionError(f"{place}{': ' if place else ''}{written}: {error}") from None
    return found


def _field_value(name: str, value: Any) -> Any:
    declared = _FIELDS[name]
    read = declared.metadata.get("read", lambda text: None)
    if declared.metadata.get("many"):
        texts = (value,) if isinstance(value, str) else value
        if not isinstance(texts, list | tuple) or not all(isinstance(text, str) for text in texts):
            raise OptionError(f"expected one text or several, found {value!r}")
        for text in texts:
            read(text)
        return tuple(texts)
    if isinstance(declared.default, bool):
        if not isinstance(value, bool):
            raise OptionError(f"expected true or false, found {value!r}")
    elif isinstance(declared.default, int):
        least = 1 if name == "on" else 0
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise OptionError(f"expected a whole number of at least {least}, found {value!r}")
    else:
        if isinstance(value, int | float) and not isinstance(value, bool):
            value = str(value)
        if not isinstance(value, str):
            raise OptionError(f"expected a text, found {value!r}")
        read(value)
    return value


def _search_value(name: str, value: Any) -> Any:
    option = BY_NAME[name]
    if option.kind == "flag":
        return option.checked(value)
    if isinstance(value, int | float) and not isinstance(value, bool):
        if option.kind in ("number", "whole"):
            return option.checked(value)
        value = str(value)
    if not isinstance(value, str):
        raise OptionError(f"expected a text or a number, found {value!r}")
    option_reader(option)(value)
    return value


def _like(name: str) -> str:
    import difflib

    known = sorted({*_FIELDS, *BY_NAME})
    near = difflib.get_close_matches(name, known, n=3)
    return f"did you mean {' or '.join(near)}?" if near else f"there are {', '.join(known)}"
