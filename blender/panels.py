"""The panel, in the side bars of the 3D view, the dope sheet and the graph editor."""

from __future__ import annotations

import textwrap
from typing import Any

import bpy

from retime.search import options
from retime.search.options import Option

from .settings import GIVEN, has_switch

# Where the panel is, and what these editors are called in names of classes.
PLACES = {"VIEW_3D": "view", "DOPESHEET_EDITOR": "sheet", "GRAPH_EDITOR": "graph"}


def say(layout: Any, text: str, *, icon: str = "NONE", width: int = 44) -> None:
    """Write text in as many lines as the side bar needs."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    for i, line in enumerate(textwrap.wrap(text, width) or [""]):
        column.label(text=line, icon=icon if i == 0 else "BLANK1" if icon != "NONE" else "NONE")


def fault(layout: Any, settings: Any, *names: str, item: int = -1) -> bool:
    """Write the error of a field below it; tell whether there is one."""
    if not settings.fault or settings.fault_field not in names or settings.fault_item != item:
        return False
    row = layout.row()
    row.alert = True
    say(row, settings.fault, icon="ERROR")
    return True


def draw_option(layout: Any, settings: Any, option: Option) -> None:
    """Draw the field of an option, and its error."""
    name = f"search_{option.name}"
    row = layout.row(align=True)
    row.alert = bool(settings.fault) and settings.fault_field == option.name
    if has_switch(option):
        row.prop(settings, f"{GIVEN}{option.name}", text="")
        field = row.row(align=True)
        field.enabled = getattr(settings, f"{GIVEN}{option.name}")
        field.prop(settings, name)
    else:
        row.prop(settings, name, slider=option.slider is not None)
    fault(layout, settings, option.name)


# Fields that have a place of their own; an error about another one stands at the top.
def _own_fields() -> set[str]:
    return {option.name for option in options.OPTIONS} | {
        "keys",
        "locks",
        "range",
        "reference",
        "before",
        "root",
        "curve",
        "editor",
        "project",
    }


def draw_main(layout: Any, context: Any) -> None:
    """Draw what everybody needs."""
    settings = context.scene.retime
    layout.use_property_split = True
    layout.use_property_decorate = False
    if settings.fault and settings.fault_field not in _own_fields():
        fault(layout, settings, settings.fault_field, item=settings.fault_item)
    layout.prop(settings, "range")
    if settings.range == "CUSTOM":
        column = layout.column(align=True)
        column.prop(settings, "start")
        column.prop(settings, "end")
    fault(layout, settings, "range")
    for name in ("length", "influence", "smoothness", "keep_flights", "evenness"):
        draw_option(layout, settings, options.BY_NAME[name])
    if settings.search_length == "free":
        for name in ("min_length", "max_length", "free_weight"):
            draw_option(layout, settings, options.BY_NAME[name])
    layout.prop(settings, "result")
    if settings.result == "KEYS":
        layout.prop(settings, "snap")
    if settings.result == "BAKE":
        layout.prop(settings, "average")
    row = layout.row(align=True)
    row.scale_y = 1.4
    row.operator("retime.retime", icon="TIME")
    row.operator("retime.preview", text="", icon="FCURVE")
    if settings.summary:
        box = layout.box()
        for line in settings.summary.split("\n"):
            say(box, line)


def draw_keytimes(layout: Any, context: Any) -> None:
    """Draw the keytimes and the locks."""
    settings = context.scene.retime
    row = layout.row(align=True)
    row.operator("retime.add_keytime", text="Add", icon="ADD")
    row.operator("retime.keytimes_from_markers", text="Markers", icon="MARKER_HLT")
    row.operator("retime.keytimes_from_keys", text="Keys", icon="KEYTYPE_KEYFRAME_VEC")
    for i, key in enumerate(settings.keys):
        line = layout.row(align=True)
        line.alert = bool(settings.fault) and settings.fault_field == "keys" and settings.fault_item == i
        line.prop(key, "frame", text="")
        line.label(text="", icon="FORWARD")
        line.prop(key, "to", text="")
        line.prop(key, "speed", text="")
        line.operator("retime.remove_keytime", text="", icon="X").index = i
        fault(layout, settings, "keys", item=i)
    fault(layout, settings, "keys")
    if any(key.marker for key in settings.keys):
        layout.operator("retime.keytimes_to_markers", icon="MARKER")
    if len(settings.keys) > 1:
        layout.operator("retime.remove_keytime", text="Remove All", icon="X").index = -1
    layout.separator()
    layout.operator("retime.add_lock", icon="LOCKED")
    for i, lock in enumerate(settings.locks):
        line = layout.row(align=True)
        line.alert = bool(settings.fault) and settings.fault_field == "locks" and settings.fault_item == i
        line.prop(lock, "start", text="")
        line.prop(lock, "end", text="")
        line.prop(lock, "speeds", text="")
        line.operator("retime.remove_lock", text="", icon="X").index = i
        fault(layout, settings, "locks", item=i)
    fault(layout, settings, "locks")


def draw_reference(layout: Any, context: Any) -> None:
    """Draw what the motion shall be like, and keeping in step."""
    settings = context.scene.retime
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(settings, "reference_kind")
    fields = {
        "RANGE": ("reference_start", "reference_end"),
        "ACTION": ("reference_action",),
        "OBJECT": ("reference_object",),
        "FILE": ("reference_file",),
    }.get(settings.reference_kind, ())
    for name in fields:
        layout.prop(settings, name)
    fault(layout, settings, "reference")
    if fields:
        layout.prop(settings, "mirror")
        layout.prop(settings, "repeat")
    layout.operator("retime.synchronise", icon="LINKED")


def draw_hand(layout: Any, context: Any) -> None:
    """Draw propagation, the curve, and the editor."""
    settings = context.scene.retime
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(settings, "before")
    if settings.before is None:
        column = layout.column(align=True)
        column.prop(settings, "example_start")
        column.prop(settings, "example_end")
    fault(layout, settings, "before")
    layout.operator("retime.propagate", icon="PASTEDOWN")
    layout.separator()
    layout.operator("retime.use_curve", icon="FCURVE")
    fault(layout, settings, "curve")
    layout.separator()
    layout.operator("retime.open_editor", icon="URL")
    fault(layout, settings, "editor")
    layout.prop(settings, "project")
    layout.operator("retime.take_from_editor", icon="IMPORT")
    fault(layout, settings, "project")


def draw_more(layout: Any, context: Any) -> None:
    """Draw how results are made, and every other option of the search."""
    settings = context.scene.retime
    layout.use_property_split = True
    layout.use_property_decorate = False
    for name in ("tolerance", "new_action", "move_markers", "move_range", "root"):
        layout.prop(settings, name)
    fault(layout, settings, "root")
    shown = {"length", "influence", "smoothness", "keep_flights", "evenness", "min_length", "max_length", "free_weight"}
    for option in options.OPTIONS:
        if option.name not in shown:
            draw_option(layout, settings, option)


_PANELS = (
    ("main", "Retime", draw_main),
    ("keytimes", "Keytimes and Locks", draw_keytimes),
    ("reference", "Like", draw_reference),
    ("hand", "By Hand", draw_hand),
    ("more", "More", draw_more),
)


def _panel(space: str, name: str, label: str, draw: Any) -> type:
    place = PLACES[space]
    members: dict[str, Any] = {
        "bl_space_type": space,
        "bl_region_type": "UI",
        "bl_category": "Retime",
        "bl_label": label,
        "bl_idname": f"RETIME_PT_{place}_{name}",
        "draw": lambda self, context: draw(self.layout, context),
    }
    if name != "main":
        members |= {"bl_parent_id": f"RETIME_PT_{place}_main", "bl_options": {"DEFAULT_CLOSED"}}
    return type(members["bl_idname"], (bpy.types.Panel,), members)


CLASSES = tuple(_panel(space, *panel) for space in PLACES for panel in _PANELS)


def register() -> None:
    """Add the panels."""
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister() -> None:
    """Take them away again."""
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
