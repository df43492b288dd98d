"""What values print of themselves stays short, whatever they hold; their pictures are whole pages' parts."""

from __future__ import annotations

import dataclasses
import importlib
import pkgutil
import xml.etree.ElementTree as ElementTree
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import retime
from retime.motion.contacts import slip
from retime.motion.kinematics import global_poses
from retime.motion.motion import Declaration
from retime.search.poses.spaces import PoseOptions

# An extra may be missing; what it needs holds no values of its own.
_LEFT_OUT = ("retime.notebook", "retime.server.app", "retime.server.guard", "retime.__main__")
_ARRAYS = ("Array", "ndarray", "Float64s", "Bytes")


def modules() -> list[Any]:
    names = [found.name for found in pkgutil.walk_packages(retime.__path__, "retime.")]
    # The compiled kernels are there only where a compiler was.
    names = [name for name in names if name not in _LEFT_OUT and "kernels." not in name]
    return [module for module in map(_imported, names) if module is not None]


def _imported(name: str) -> Any:
    """Import a module; None where it is one of those that run in a process with usd-core, which is not installed."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name == "pxr" and name.startswith("retime.formats.curves.usd."):
            return None
        raise


def public_dataclasses() -> list[type]:
    return [
        value
        for module in modules()
        for value in vars(module).values()
        if isinstance(value, type)
        and dataclasses.is_dataclass(value)
        and value.__module__ == module.__name__
        and not value.__name__.startswith("_")
    ]


def holds_arrays(kind: type) -> bool:
    return any(word in str(field.type) for field in dataclasses.fields(kind) for word in _ARRAYS)


def prints_its_fields(kind: type) -> bool:
    """Whether its repr is the one that dataclass made, which writes out every number."""
    return getattr(kind.__repr__, "__wrapped__", None) is not None


def test_every_value_with_arrays_prints_them_short() -> None:
    kinds = [kind for kind in public_dataclasses() if holds_arrays(kind)]
    assert {"Motion", "Warp", "FramePath", "Slip", "Curve"} <= {kind.__name__ for kind in kinds}
    assert [kind.__qualname__ for kind in kinds if prints_its_fields(kind)] == []


@dataclasses.dataclass
class Printing:
    """Has what the test above looks for."""

    values: int


def test_the_repr_that_dataclass_makes_is_told_from_ours() -> None:
    assert prints_its_fields(Printing)
    assert not prints_its_fields(retime.Warp)


CLIP = retime.sample()[:400]
RESULT = retime.guided_warp(CLIP, length="65%", keys=[(3.0, 2.0)])
STANDING = retime.contacts(CLIP)
SIGNAL = retime.Signal(("x", "y"), np.random.default_rng(0).normal(size=(50, 2)), Fraction(30), name="<noise> & more")
VALUES = {
    "motion": CLIP,
    "signal": SIGNAL,
    "many channels": retime.Signal(tuple(f"c{i}" for i in range(300)), np.zeros((9, 300)), 30),
    "skeleton": CLIP.skeleton,
    "declaration": CLIP.declaration,
    "poses": global_poses(CLIP),
    "warp": RESULT.warp,
    "result": RESULT,
    "path": RESULT.path,
    "reduction": RESULT.reduction,
    "model": RESULT.model,
    "explanation": RESULT.explain(),
    "contacts": STANDING,
    "slip": slip(CLIP, STANDING),
    "slip report": retime.retimed_slip(CLIP, RESULT.warp),
    "reference": retime.Reference([CLIP, SIGNAL], joint_map={name: name for name in CLIP.skeleton.names}),
    "pose options": PoseOptions(weights=dict.fromkeys(CLIP.skeleton.names, 1.0)),
    "session": retime.Session(CLIP),
}


@pytest.mark.parametrize("kind", VALUES)
def test_every_repr_is_short(kind) -> None:
    text = repr(VALUES[kind])
    assert len(text) <= 300, text
    assert "\n" not in text
    assert "array(" not in text
    assert " at 0x" not in text


def test_a_declaration_counts_what_is_long() -> None:
    assert repr(Declaration("bvh", (("Xrotation",),) * 31, "0.01")) == (
        "Declaration(format='bvh', channels=tuple of 31, frame_time='0.01')"
    )


@pytest.mark.parametrize("kind", [kind for kind, value in VALUES.items() if hasattr(value, "_repr_html_")])
def test_pictures_are_well_formed_and_small(kind) -> None:
    page = VALUES[kind]._repr_html_()
    pictures = list(ElementTree.fromstring(page).iter("{http://www.w3.org/2000/svg}svg"))
    assert pictures
    for picture in pictures:
        assert float(picture.attrib["height"]) <= 240
    assert len(page) < 60_000
    assert "nan" not in page


def test_what_has_a_picture() -> None:
    shown = {kind for kind, value in VALUES.items() if hasattr(value, "_repr_html_")}
    assert {"motion", "signal", "warp", "result", "explanation", "contacts", "slip report"} <= shown


@pytest.mark.parametrize(
    "clip",
    [
        CLIP[:1],
        retime.Signal(("x",), [[1.0]], 30),
        retime.Motion(retime.Skeleton(("root",), (-1,), np.zeros((1, 3))), np.tile([1.0, 0, 0, 0], (5, 1, 1))),
    ],
    ids=["one frame", "one value", "one joint that stays"],
)
def test_the_smallest_clips_have_pictures(clip) -> None:
    page = clip._repr_html_()
    assert "nan" not in page
    ElementTree.fromstring(page)
