"""The settings of the panel, kept with the scene. Options of the search are made of `retime.search.options`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from retime.search import options
from retime.search.options import Option

# Beside a number whose default depends on the clip stands a switch that says whether it is given at all.
GIVEN = "use_"


def _property_of(option: Option) -> Any:
    """Make the property that holds an option."""
    common = {"name": option.label, "description": f"{option.hint}. Default: {option.default_words}"}
    if option.kind == "flag":
        return BoolProperty(default=bool(option.default), **common)
    if option.kind == "choice":
        items = [(choice.value, choice.label, option.hint) for choice in option.choices]
        if option.default is None:
            items.insert(0, ("USUAL", f"Usual: {option.default_words}", option.hint))
        return EnumProperty(items=items, default=option.default or "USUAL", **common)
    if option.kind in ("number", "influence"):
        bounds = {"min": max(option.least, -1e6), "max": min(option.most, 1e6)}
        if option.slider is not None:
            bounds |= {"soft_min": 0.0, "soft_max": option.slider[0]}
        start = option.default if option.default is not None else _usual_number(option)
        return FloatProperty(default=float(start), **bounds, **common)
    if option.kind == "whole":
        start = option.default if option.default is not None else 4
        return IntProperty(default=int(start), min=int(max(option.least, 0)), max=int(min(option.most, 1e6)), **common)
    # What people type: lengths, rates, speeds.
    return StringProperty(default="", **common)


def _usual_number(option: Option) -> float:
    """Where a number has no one default, begin with the one that stands first in its words."""
    first = option.default_words.split(maxsplit=1)[0]
    return float(first) if first.replace(".", "", 1).isdigit() else max(option.least, 0.0)


def has_switch(option: Option) -> bool:
    """Tell whether an option is a number that is given or left out."""
    return option.kind in ("number", "whole") and option.default is None


class RetimeKeytime(bpy.types.PropertyGroup):
    """A moment of the motion, and when it shall be."""

    __annotations__ = {
        "frame": FloatProperty(name="Frame", description="The frame of a pose as it is now", default=1.0, precision=1),
        "to": FloatProperty(name="To", description="The frame at which this pose shall be", default=1.0, precision=1),
        "speed": StringProperty(
            name="Speed", description="How fast the motion passes there: 1/2, 2, 150%. Empty: as it comes"
        ),
        "marker": StringProperty(name="Marker", description="The timeline marker that it was made of"),
    }


class RetimeLock(bpy.types.PropertyGroup):
    """A stretch that plays at speeds of its own."""

    __annotations__ = {
        "start": FloatProperty(name="From", description="First frame of the stretch, as it is now", precision=1),
        "end": FloatProperty(name="To", description="Last frame of the stretch, as it is now", precision=1),
        "speeds": StringProperty(
            name="Speed", description="1/2..2, ..1, 150%, or uncut: slowed down at most. Empty: its own speed"
        ),
    }


_OWN: dict[str, Any] = {
    "range": EnumProperty(
        name="Range",
        description="Which frames get new timing; what comes after them moves along",
        items=[
            ("ACTION", "All Keys", "From the first key of the selection to the last"),
            ("SCENE", "Scene Range", "From the scene's start to its end; the preview range, where that is on"),
            ("CUSTOM", "From ... To", "These frames"),
        ],
        default="ACTION",
    ),
    "start": IntProperty(name="From", description="First frame that gets new timing", default=1),
    "end": IntProperty(name="To", description="Last frame that gets new timing", default=100),
    "keys": CollectionProperty(type=RetimeKeytime),
    "locks": CollectionProperty(type=RetimeLock),
    "reference_kind": EnumProperty(
        name="Like",
        description="Whose timing is wanted",
        items=[
            ("SELF", "Itself", "The motion goes on moving like itself, hurried or slowed down"),
            ("RANGE", "A Range of It", "It shall move as it does in a range of its own frames"),
            ("ACTION", "Another Action", "It shall move as this action does"),
            ("OBJECT", "Another Object", "It shall move as another object does in these frames"),
            ("FILE", "A File", "It shall move as a motion file does: BVH, AMC, glTF, ..."),
        ],
        default="SELF",
    ),
    "reference_start": IntProperty(name="From", description="First frame of the reference", default=1),
    "reference_end": IntProperty(name="To", description="Last frame of the reference", default=50),
    "reference_action": PointerProperty(
        type=bpy.types.Action, name="Action", description="The action whose timing is wanted"
    ),
    "reference_object": PointerProperty(
        type=bpy.types.Object, name="Object", description="The object whose timing is wanted"
    ),
    "reference_file": StringProperty(
        name="File", description="The motion file whose timing is wanted", subtype="FILE_PATH"
    ),
    "mirror": BoolProperty(
        name="Mirror Too",
        description="Look at the mirror image of the reference as well: left for right",
        default=False,
    ),
    "repeat": FloatProperty(
        name="Repeat",
        description="How often the reference is played, to keep in step with",
        default=1.0,
        min=1.0,
        max=1000.0,
    ),
    "root": StringProperty(
        name="Root Bone", description="The bone that carries the body, such as the hips. Empty: it is found"
    ),
    "result": EnumProperty(
        name="Result",
        description="What the new timing becomes",
        items=[
            ("KEYS", "Keys Kept", "Keys move, and curves are cut where their speed changes: exactly the same poses"),
            ("NLA", "NLA Strip", "Keys stay; a strip plays them by a curve of strip time that you can edit"),
            ("BAKE", "Baked", "A key on every frame, averaged where sped up so that sway does not become jitter"),
        ],
        default="KEYS",
    ),
    "snap": BoolProperty(
        name="Keys on Whole Frames",
        description="Move every key to the nearest whole frame. Poses change a little; the panel says by how much",
        default=False,
    ),
    "average": BoolProperty(
        name="Average", description="Average what is sped up; feet that stand are exempt", default=True
    ),
    "new_action": BoolProperty(
        name="New Action", description="Leave the old action as it is, with a fake user", default=True
    ),
    "move_markers": BoolProperty(
        name="Markers Follow", description="Move timeline markers and the markers of the action along", default=True
    ),
    "move_range": BoolProperty(
        name="Frame Range Follows",
        description="The frame range of scene and action follows the new length",
        default=True,
    ),
    "tolerance": FloatProperty(
        name="Tolerance",
        description="By how many frames the timing may be off, for fewer keys; 0: every bend of it is a key",
        default=0.05,
        min=0.0,
        max=2.0,
        precision=3,
    ),
    "before": PointerProperty(
        type=bpy.types.Action,
        name="Before",
        description="The action as it was before a part of it was retimed by hand. Empty: the keytimes say how",
    ),
    "example_start": IntProperty(
        name="From", description="First frame of the example that the keytimes retime", default=1
    ),
    "example_end": IntProperty(name="To", description="Last frame of the example that the keytimes retime", default=50),
    "summary": StringProperty(options={"HIDDEN"}),
    "fault": StringProperty(options={"HIDDEN"}),
    "fault_field": StringProperty(options={"HIDDEN"}),
    "fault_item": IntProperty(default=-1, options={"HIDDEN"}),
    "project": StringProperty(
        name="Project",
        description="The project of the editor; save it there (Ctrl S) before you take the timing back",
        subtype="FILE_PATH",
    ),
}


def _annotations() -> dict[str, Any]:
    found = dict(_OWN)
    for option in options.OPTIONS:
        found[f"search_{option.name}"] = _property_of(option)
        if has_switch(option):
            found[f"{GIVEN}{option.name}"] = BoolProperty(
                name=option.label, description=f"{option.hint}. Left out: {option.default_words}", default=False
            )
    return found


class RetimeSettings(bpy.types.PropertyGroup):
    """What the panel holds."""

    __annotations__ = _annotations()

    def given(self) -> Mapping[str, Any]:
        """Return the options of the search that differ from their defaults."""
        found: dict[str, Any] = {}
        for option in options.OPTIONS:
            value = getattr(self, f"search_{option.name}")
            if isinstance(value, float):
                # Blender holds it in single precision: what was typed is meant.
                value = float(f"{value:.6g}")
            if has_switch(option):
                if getattr(self, f"{GIVEN}{option.name}"):
                    found[option.name] = value
            elif value not in ("", "USUAL") and value != option.default:
                found[option.name] = value
        return found


CLASSES = (RetimeKeytime, RetimeLock, RetimeSettings)


def register() -> None:
    """Add the settings to scenes."""
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Scene.retime = PointerProperty(type=RetimeSettings)


def unregister() -> None:
    """Take them away again."""
    del bpy.types.Scene.retime
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
