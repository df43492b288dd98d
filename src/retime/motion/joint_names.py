"""What joint names say: the side of the body, the part of it, and which joints of two skeletons are the same.

Names come from many programs: ``LeftUpLeg``, ``mixamorig:LeftUpLeg``, ``lfemur``, ``thigh.L``, ``UpLeg_L`` and
``LeftHip`` are one joint. A name is taken apart into words; one of them may be the side, the others name the part.
"""

from __future__ import annotations

import difflib
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from retime.errors import OptionError

Key = TypeVar("Key")

_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+|[^\W\d_]+")
_SIDES = {"left": "left", "l": "left", "right": "right", "r": "right"}
_OTHER_SIDE = {"left": "right", "right": "left", "": ""}
# What rigs put before every name: mixamorig:Hips, Bip01 L Thigh, DEF-thigh.L, CC_Base_L_Thigh, J_Bip_C_Hips.
_RIG_WORDS = {"mixamorig", "bip", "biped", "valvebiped", "def", "org", "cc", "base", "character", "j", "c"}

# Each part, and what it is called. The joint is meant, not the bone: the forearm begins at the elbow.
_SIDED_PARTS = {
    "thigh": "thigh upleg upperleg femur",
    "shin": "shin lowerleg loleg tibia calf knee",
    "foot": "foot ankle",
    "toes": "toes toe toe0 toebase ball",
    "collar": "collar clavicle",
    "upper arm": "arm upperarm uparm humerus shldr",
    "forearm": "forearm lowerarm loarm radius elbow",
    "hand": "wrist",
    "palm": "fingerbase",
    "fingers": "fingers handindex1",
}
_MIDDLE_PARTS = {
    "hips": "hips pelvis hip",
    "spine": "spine upperback",
    "spine1": "spine1 thorax",
    "neck": "neck lowerneck",
    "neck1": "neck1 upperneck",
    "head": "head",
}
# Words that depend on the other names of the skeleton: (a part, what the word means beside it, and without it).
_AMBIGUOUS = {
    "hip": ("thigh", "hipjoint", "thigh"),
    "shoulder": ("upper arm", "collar", "upper arm"),
    "leg": ("thigh", "shin", "thigh"),
    "hand": ("hand", "palm", "hand"),
}
_SIDED = {word: part for part, words in _SIDED_PARTS.items() for word in words.split()}
_MIDDLE = {word: part for part, words in _MIDDLE_PARTS.items() for word in words.split()}
# Programs place and number these as each likes: Spine1 is at the hips in one and between the shoulders in another.
_TRUNK = {"spine", "chest", "upperchest", "back", "lowerback", "torso", "waist", "ab", "abdomen"}


@dataclass(frozen=True)
class JointName:
    """A joint's name, taken apart.

    Attributes
    ----------
    side : str
        "left", "right" or "".
    base : str
        The rest: lower case, without separators, namespace and what the rig puts before every name.
    """

    side: str
    base: str


@dataclass(frozen=True)
class JointMatch:
    """Which joints of two skeletons are the same.

    Attributes
    ----------
    pairs : tuple of (int, int)
        Input joint and reference joint, in the input's order.
    how : tuple of str
        For each pair: "map" (it was told), "part" (both names are known for it), "exact" or "name" (the same but for
        case, separators and namespace).
    unmatched_input, unmatched_reference : tuple of str
        Names of the joints that are left.
    """

    pairs: tuple[tuple[int, int], ...]
    how: tuple[str, ...]
    unmatched_input: tuple[str, ...]
    unmatched_reference: tuple[str, ...]


def near_names(name: str, names: Iterable[str]) -> str:
    """Say which of `names` a mistyped one may mean: text to follow an error message.

    Examples
    --------
    >>> near_names("leftfoot", ["LeftFoot", "RightFoot", "Head"])
    "; near to it: 'LeftFoot'"
    """
    by_lower: dict[str, str] = {}
    for known in names:
        by_lower.setdefault(known.lower(), known)
    close = difflib.get_close_matches(name.lower(), by_lower, n=3)
    if close:
        return "; near to it: " + ", ".join(repr(by_lower[found]) for found in close)
    return "; there are " + shorten(by_lower.values(), 12)


def shorten(names: Iterable[str], most: int) -> str:
    """List names in a message, and count those past `most`."""
    known = list(names)
    more = f" and {len(known) - most} more" if len(known) > most else ""
    return (", ".join(repr(name) for name in known[:most]) or "none") + more


def take_apart(names: Sequence[str]) -> tuple[JointName, ...]:
    """Take the names of a skeleton's joints apart.

    Parameters
    ----------
    names : sequence of str
        All of them: ``lfemur`` is a left one because there is ``rfemur`` too.

    Examples
    --------
    >>> take_apart(["mixamorig:LeftArm", "upper_arm.R", "lfemur", "rfemur"])[0]
    JointName(side='left', base='arm')
    """
    apart = [_take_one_apart(name) for name in names]
    middle = {name.base for name in apart if not name.side}
    for i, name in enumerate(apart):
        if name.side or len(name.base) < 3 or name.base[0] not in "lr":
            continue
        if {"l" + name.base[1:], "r" + name.base[1:]} <= middle:
            apart[i] = JointName(_SIDES[name.base[0]], name.base[1:])
    return tuple(apart)


def _take_one_apart(name: str) -> JointName:
    short = re.split("[:|]", name)[-1]
    words = [word.lower() for word in _WORD.findall(short)]
    if not words:
        return JointName("", name.lower())
    while len(words) > 1 and (words[0] in _RIG_WORDS or words[0].isdigit()):
        words.pop(0)
    # MakeHuman exports helper joints that stand between: __UpLeg_L is no upper leg.
    helper = "__" if short.startswith("__") else ""
    sides = [word for word in words if word in _SIDES]
    if len(sides) == 1 and len(words) > 1:
        words.remove(sides[0])
        return JointName(_SIDES[sides[0]], helper + "".join(words))
    base = "".join(words)
    for side in ("left", "right"):
        if not sides and base.startswith(side) and len(base) > len(side):
            return JointName(side, helper + base.removeprefix(side))
    return JointName("", helper + base)


def mirror_partners(names: Sequence[str], parents: Sequence[int] | None = None) -> tuple[int | None, ...]:
    """Find the joint that each joint becomes in a mirror.

    Parameters
    ----------
    names : sequence of str
        Joint names, root first.
    parents : sequence of int, optional
        Each joint's parent, which stands before it; -1 for the root. Of joints that share a name, they tell which
        belong together: those whose parents do. Left out, the first belongs to the first.

    Returns
    -------
    tuple of int or None
        The joint of the other side; a joint of the middle is its own partner; None where a name says a side and the
        other side has no such joint.

    Examples
    --------
    >>> mirror_partners(["Hips", "LeftFoot", "RightFoot", "LeftSword"])
    (0, 2, 1, None)
    """
    apart = take_apart(names)
    places: defaultdict[JointName, list[int]] = defaultdict(list)
    for joint, name in enumerate(apart):
        places[name].append(joint)
    partners: list[int | None] = [None] * len(apart)
    for joint, name in enumerate(apart):
        others = places.get(JointName(_OTHER_SIDE[name.side], name.base), [])
        place = places[name].index(joint)
        if not name.side:
            partners[joint] = joint
        elif len(others) == 1 == len(places[name]) or parents is None:
            partners[joint] = others[place] if place < len(others) else None
        else:
            above = partners[parents[joint]] if parents[joint] >= 0 else None
            beside = [other for other in others if parents[other] == above]
            place = [other for other in places[name] if parents[other] == parents[joint]].index(joint)
            partners[joint] = beside[place] if place < len(beside) else None
    return tuple(partners)


def body_parts(names: Sequence[str], *, repeated: bool = False) -> tuple[JointName | None, ...]:
    """Say which part of a body each joint is, by the names that well-known programs and databases give them.

    Parameters
    ----------
    names : sequence of str
        Joint names, root first.
    repeated : bool
        Say it of every joint that is called so. Left out, of the first one only, so that each part is there once.

    Returns
    -------
    tuple of JointName or None
        The part as ``base``; None where the name is not known, or an earlier joint is that part already.

    Examples
    --------
    >>> body_parts(["Hips", "LeftShoulder", "LeftElbow"])[1:]
    (JointName(side='left', base='upper arm'), JointName(side='left', base='forearm'))
    """
    apart = take_apart(names)
    parts: list[JointName | None] = []
    for name in apart:
        part = (_SIDED if name.side else _MIDDLE).get(name.base)
        parts.append(JointName(name.side, part) if part else None)
    for word, (other, beside, without) in _AMBIGUOUS.items():
        known_so_far = set(parts)
        for joint, name in enumerate(apart):
            if name.side and name.base == word:
                parts[joint] = JointName(name.side, beside if JointName(name.side, other) in known_so_far else without)
    hips = JointName("", "hips")
    if hips not in parts and apart[0] == JointName("", "root"):
        parts[0] = hips
    seen: set[JointName] = set()
    for joint, known in enumerate(() if repeated else parts):
        if known in seen:
            parts[joint] = None
        elif known is not None:
            seen.add(known)
    return tuple(parts)


def match_joints(
    input_names: Sequence[str], reference_names: Sequence[str], joint_map: Mapping[str, str] | None = None
) -> JointMatch:
    """Match the joints of two skeletons by name.

    What `joint_map` says comes first. Then the parts of the body go by what they are called in well-known skeletons
    (CMU's ASF and BVH, Mixamo, Rigify, MakeHuman, Biped and others), then equal names, then names that differ in case,
    separators or namespace only. The parts go before equal names because ``LeftShoulder`` is the collar bone in some
    skeletons and the upper arm in others. Joints of spine and neck are matched only where both skeletons have the same
    ones.

    Parameters
    ----------
    input_names, reference_names : sequence of str
        Joint names, root first. Of joints that share a name, the first is matched.
    joint_map : mapping of str to str, optional
        Input joint to reference joint.

    Raises
    ------
    OptionError
        The map names a joint that is not there, or one reference joint twice.

    Examples
    --------
    >>> match_joints(["root", "lfemur", "rfemur"], ["Hips", "RightUpLeg", "LeftUpLeg"]).pairs
    ((0, 0), (1, 2), (2, 1))
    """
    input_joints, reference_joints = _first_places(input_names), _first_places(reference_names)
    pairs: dict[int, tuple[int, str]] = {}
    taken: set[int] = set()
    for name, other in (joint_map or {}).items():
        for asked, known, whose in ((name, input_joints, "input"), (other, reference_joints, "reference")):
            if asked not in known:
                raise OptionError(f"the joint map names {asked!r}, which the {whose} has not{near_names(asked, known)}")
        if reference_joints[other] in taken:
            raise OptionError(f"the joint map gives the reference joint {other!r} to two joints of the input")
        pairs[input_joints[name]] = reference_joints[other], "map"
        taken.add(reference_joints[other])

    apart = take_apart(input_names), take_apart(reference_names)
    parts = body_parts(input_names), body_parts(reference_names)
    unlike = _unlike_chains(*apart)
    keys = (
        ("part", parts),
        ("exact", (tuple(input_names), tuple(reference_names))),
        ("name", apart),
    )
    for how, (input_keys, reference_keys) in keys:
        places = _first_places(reference_keys)
        # A key that repeats says nothing, unless it is a whole name: then the first is meant.
        repeated = set() if how == "exact" else _repeated(input_keys) | _repeated(reference_keys)
        for joint, key in enumerate(input_keys):
            found = places.get(key)
            if key is None or key in repeated or found is None or joint in pairs or found in taken:
                continue
            if apart[0][joint] in unlike or apart[1][found] in unlike:
                continue
            # Two joints that are known to be different parts are not one, whatever they are called.
            if how != "part" and parts[0][joint] != parts[1][found] and None not in (parts[0][joint], parts[1][found]):
                continue
            pairs[joint] = found, how
            taken.add(found)
    order = sorted(pairs)
    return JointMatch(
        tuple((joint, pairs[joint][0]) for joint in order),
        tuple(pairs[joint][1] for joint in order),
        tuple(name for joint, name in enumerate(input_names) if joint not in pairs),
        tuple(name for joint, name in enumerate(reference_names) if joint not in taken),
    )


def _first_places(keys: Sequence[Key]) -> dict[Key, int]:
    places: dict[Key, int] = {}
    for place, key in enumerate(keys):
        places.setdefault(key, place)
    return places


def _repeated(keys: Sequence[object]) -> set[object]:
    return {key for key, count in Counter(keys).items() if count > 1}


def _unlike_chains(input_names: Sequence[JointName], reference_names: Sequence[JointName]) -> set[JointName]:
    """Find the names of spine and neck joints where the two skeletons have different ones."""
    unlike: set[JointName] = set()
    for kinds in (_TRUNK, {"neck"}):
        chains = [
            {
                name: part
                for name in names
                if not name.side and (part := _middle_part(name)).rstrip("0123456789") in kinds
            }
            for names in (input_names, reference_names)
        ]
        if list(chains[0].values()) != list(chains[1].values()):
            unlike.update(*chains)
    return unlike


def _middle_part(name: JointName) -> str:
    return _MIDDLE.get(name.base, name.base)
