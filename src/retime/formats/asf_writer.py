"""Makes an ASF for a skeleton that has none."""

from __future__ import annotations

import math
import re

import numpy as np

from retime.arrays import FloatArray
from retime.formats.asf import ROOT
from retime.motion.skeleton import Skeleton


def make_asf(skeleton: Skeleton, offsets: FloatArray, metres_per_unit: float | None) -> tuple[bytes, tuple[str, ...]]:
    """Write an ASF for a skeleton that has none: axes along the global ones, all rotations free.

    A bone has one end, so a joint whose children stand in different places gets length 0 and a bone without
    freedom to each of those places. The root is a place without length as well.

    Parameters
    ----------
    skeleton : Skeleton
        The joints.
    offsets : float array, shape (n_joints, 3)
        Where each joint stands in its parent's space; the root's is not used.
    metres_per_unit : float, optional
        Becomes the ``length`` of ``:units``.

    Returns
    -------
    text : bytes
        The file.
    names : tuple of str
        What each joint is called in it: its own name where that is one word that stands for nothing else; the
        root is called root.
    """
    taken = {ROOT, "begin", "end"}
    names = [ROOT]
    for name in skeleton.names[1:]:
        names.append(_free_name(name, taken))
        taken.add(names[-1].lower())
    bones: list[tuple[str, FloatArray, bool]] = []
    lines: list[str] = []
    for joint, name in enumerate(names):
        children = skeleton.children(joint)
        ends = [tuple(offsets[child].tolist()) for child in children]
        ends += [site.offset for site in skeleton.end_sites if site.parent == joint]
        places = list(dict.fromkeys(ends))
        own = places[0] if joint > 0 and len(places) == 1 else (0.0, 0.0, 0.0)
        if joint > 0:
            bones.append((name, np.array(own), True))
        attached = [name]
        helpers: dict[tuple[float, ...], list[str]] = {}
        for child, end in zip(children, ends, strict=False):
            if end == own:
                attached.append(names[child])
            else:
                helpers.setdefault(end, []).append(names[child])
        for end in places:
            if end != own:
                below = helpers.get(end, [])
                helper = _free_name(f"{name}_to_{below[0] if below else 'end'}", taken)
                taken.add(helper.lower())
                bones.append((helper, np.array(end), False))
                attached.append(helper)
                if below:
                    lines.append(" ".join([helper, *below]))
        if len(attached) > 1:
            lines.append(" ".join(attached))
    return _asf_text(bones, lines, metres_per_unit), tuple(names)


def _free_name(name: str, taken: set[str]) -> str:
    """Make one word of a name, that is no keyword, no number and not taken yet."""
    word = re.sub(r"[\s\x00-\x1f(),#]+", "_", name.encode("utf-8", "replace").decode())
    if not word or word[0] in ":+-." or word[0].isdigit():
        word = f"_{word}"
    number, free = 1, word
    while free.lower() in taken:
        number += 1
        free = f"{word}_{number}"
    return free


def _asf_text(bones: list[tuple[str, FloatArray, bool]], hierarchy: list[str], metres_per_unit: float | None) -> bytes:
    length_unit = 1.0 if metres_per_unit is None else 2.54 / 100.0 / metres_per_unit
    out = [
        "# made by retime",
        ":version 1.10",
        ":name retime",
        ":units",
        "  mass 1.0",
        f"  length {length_unit:.15g}",
        "  angle deg",
        ":documentation",
        "  One bone a joint, axes along the global ones.",
        ":root",
        "  order TX TY TZ RX RY RZ",
        "  axis XYZ",
        "  position 0 0 0",
        "  orientation 0 0 0",
        ":bonedata",
    ]
    for number, (name, end, free) in enumerate(bones, 1):
        length = math.hypot(*end.tolist())
        x, y, z = end / length if length > 0 else (0.0, 1.0, 0.0)
        out += [
            "  begin",
            f"    id {number}",
            f"    name {name}",
            f"    direction {x:.15g} {y:.15g} {z:.15g}",
            f"    length {length:.15g}",
            "    axis 0 0 0 XYZ",
        ]
        if free:
            out += ["    dof rx ry rz", *(f"    {word} (-180.0 180.0)" for word in ("limits", "      ", "      "))]
        out.append("  end")
    out += [":hierarchy", "  begin", *(f"    {line}" for line in hierarchy), "  end", ""]
    return "\n".join(out).encode()
