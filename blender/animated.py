"""Animated data-blocks of Blender: their F-curves, actions, slots and strips, read and written.

Objects of Blender are handed in, so this needs no bpy of its own. What differs between Blender 4.2, 4.4 (actions with
slots) and 5.0 (nothing but slots) is here and nowhere else.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from retime.arrays import FloatArray
from retime.errors import OptionError
from retime.warp.cutting import CurveSegments

from .fcurve_keys import Cycles, Keys, continued, end_slopes, segments_of, unrolled
from .timing import Line

# Things of Blender, which has no types that a checker could read.
Thing: TypeAlias = Any

# Kinds of objects whose motion is drawings, not curves.
_DRAWN = {"GPENCIL", "GREASEPENCIL"}
# Modifiers of objects that go by the frames of the scene, whatever the keys say.
_SIMULATED = {
    "CLOTH",
    "SOFT_BODY",
    "FLUID",
    "PARTICLE_SYSTEM",
    "DYNAMIC_PAINT",
    "WAVE",
    "MESH_CACHE",
    "MESH_SEQUENCE_CACHE",
    "BUILD",
}
# Constraints that go by the frames of a film or of a cache.
_FILMED = {"CAMERA_SOLVER", "FOLLOW_TRACK", "OBJECT_SOLVER", "TRANSFORM_CACHE"}
# Nodes that do.
_TIMED_NODES = {"GeometryNodeInputSceneTime", "GeometryNodeSimulationInput", "GeometryNodeSimulationOutput"}
_WORD = re.compile(r"[^\W\d]\w*")
_FREE = 0


@dataclass(frozen=True)
class Unit:
    """One action as something plays it: a data-block itself, or a strip of its NLA.

    Attributes
    ----------
    block : data-block
        Which is animated.
    action : Action
    slot : ActionSlot or None
        Its part of the action; None before Blender 4.4, where all of the action is.
    line : Line
        From the scene's frames to the action's.
    strip : NlaStrip or None
        Of the NLA; None where the action is the block's own.
    """

    block: Thing
    action: Thing
    slot: Thing
    line: Line
    strip: Thing = None


def blocks_of(objects: Sequence[Thing]) -> list[Thing]:
    """List the data-blocks of objects that are animated: objects, their data (cameras, lights) and shape keys."""
    found: dict[str, Thing] = {}
    for one in objects:
        for block in (one, one.data, getattr(one.data, "shape_keys", None)):
            animation = getattr(block, "animation_data", None)
            if (
                block is not None
                and animation is not None
                and (animation.action or any(track.strips for track in animation.nla_tracks))
            ):
                found.setdefault(f"{block.rna_type.identifier}/{block.name_full}", block)
    return list(found.values())


def refuse_untouchable(objects: Sequence[Thing]) -> None:
    """Refuse, by name, objects whose animation can't be retimed.

    Raises
    ------
    OptionError
        Nothing is selected; a grease pencil; what is linked from a file; what is edited just now; the NLA in tweak
        mode, or with meta strips.
    """
    if not objects:
        raise OptionError("select what moves: an armature, or any animated object", option="selection")
    for one in objects:
        if one.type in _DRAWN:
            raise OptionError(
                f"{one.name} is a grease pencil: its drawings are no curves, and retime can't move them. Leave it out "
                "of the selection",
                option="selection",
            )
        if one.library is not None:
            raise OptionError(
                f"{one.name} is linked from {one.library.filepath}: make a library override of it first (Object > "
                "Library Override > Make)",
                option="selection",
            )
        refuse_edited(one, "selection")
        for block in blocks_of([one]):
            if block.library is not None:
                raise OptionError(
                    f"{block.name}, which moves {one.name}, is linked from {block.library.filepath}: make a library "
                    f"override of it too (Object > Library Override > Make), or leave {one.name} out of the selection",
                    option="selection",
                )
    for block in blocks_of(objects):
        if block.animation_data.use_tweak_mode:
            raise OptionError(
                f"{block.name} has a strip in tweak mode: leave it first (Tab in the NLA editor)", option="selection"
            )
        for strip in strips_of(block):
            if strip.type == "META":
                raise OptionError(
                    f"the NLA of {block.name} has a meta strip, {strip.name}: take it apart first (Ctrl Alt G)",
                    option="selection",
                )


def refuse_edited(one: Thing, option: str) -> None:
    """Refuse an object in edit mode, in which Blender shows no poses; the error names a field."""
    if one.mode == "EDIT":
        raise OptionError(
            f"{one.name} is in edit mode, where it has no poses: leave it first (Tab in the 3D view)", option=option
        )


def strips_of(block: Thing) -> Iterator[Thing]:
    """All NLA strips of a data-block, muted ones too: they must stay in step."""
    for track in block.animation_data.nla_tracks:
        yield from track.strips


def units_of(block: Thing) -> list[Unit]:
    """List what plays an action for a data-block: itself and its strips."""
    animation = block.animation_data
    found = []
    if animation.action is not None:
        found.append(Unit(block, animation.action, getattr(animation, "action_slot", None), Line()))
    found += [
        Unit(block, strip.action, getattr(strip, "action_slot", None), line_of(strip), strip)
        for strip in strips_of(block)
        if strip.type == "CLIP" and strip.action is not None
    ]
    return found


def line_of(strip: Thing) -> Line:
    """Return how a strip that plays its action once, forward, turns the scene's frames into the action's."""
    return Line(strip.frame_start, strip.action_frame_start, 1.0 / strip.scale)


def plays_once(strip: Thing) -> bool:
    """Tell whether a strip plays its action once, forward and evenly."""
    return not strip.use_animated_time and not strip.use_reverse and abs(strip.repeat - 1.0) < 1e-6


def strip_curve(strip: Thing) -> tuple[CurveSegments, Any]:
    """Return which frame of its action a strip plays, as a curve over the scene's frames."""
    if strip.use_animated_time and (curve := strip.fcurves.find("strip_time")) is not None:
        return segments_of(keys_of(curve), evaluate=evaluation(curve))
    length = (strip.action_frame_end - strip.action_frame_start) * strip.scale
    ends = np.array([strip.action_frame_start, strip.action_frame_end], dtype=np.float64)
    keys = Keys.straight(
        np.array([strip.frame_start, strip.frame_start + length]), ends[::-1] if strip.use_reverse else ends
    )
    curve, source = segments_of(keys)
    # Blender keeps frames in single precision: the last repetition ends there or thereabouts.
    return unrolled(curve, source, Cycles("NONE", "REPEAT"), strip.frame_start, strip.frame_end - 1e-2)


def selected_frames(one: Thing) -> list[float]:
    """List the frames of the scene at which selected keys of an object lie, whatever plays them."""
    if one.animation_data is None:
        return []
    found: set[float] = set()
    for unit in units_of(one):
        if unit.strip is None and one.animation_data.use_tweak_mode:
            # What is tweaked is the action of a strip, which has its own place in time.
            continue
        for curve in fcurves_of(unit.action, unit.slot):
            at = [point.co.x for point in curve.keyframe_points if point.select_control_point]
            found.update(frame for inner in at if (frame := _scene_frame(unit, inner)) is not None)
    return sorted(found)


def _scene_frame(unit: Unit, inner: float) -> float | None:
    """Return the frame of the scene that first shows a frame of an action; None where none does."""
    if unit.strip is None or plays_once(unit.strip):
        return float(unit.line.outer(inner))
    curve, _ = strip_curve(unit.strip)
    frames = np.append(np.arange(unit.strip.frame_start, unit.strip.frame_end, 0.125), unit.strip.frame_end)
    shown = curve(frames)[:, 0] - inner
    # A thousandth of a frame is nothing, and the ends of strips are no nearer than that.
    if abs(shown[0]) < 1e-3:
        return float(frames[0])
    passed = np.flatnonzero((np.sign(shown[1:]) != np.sign(shown[:-1])) | (np.abs(shown[1:]) < 1e-3))
    if not len(passed):
        return None
    a, b = shown[passed[0]], shown[passed[0] + 1]
    share = 1.0 if a == b else float(np.clip(a / (a - b), 0.0, 1.0))
    return float(frames[passed[0]] + share * (frames[passed[0] + 1] - frames[passed[0]]))


def fcurves_of(action: Thing, slot: Thing) -> list[Thing]:
    """List the F-curves of an action that move one data-block."""
    bags = channelbags(action, slot)
    if bags is None:
        return list(action.fcurves)
    return [curve for bag in bags for curve in bag.fcurves]


def keyed(curve: Thing) -> bool:
    """Tell whether an F-curve has keys, or samples in their place."""
    return bool(len(curve.keyframe_points) or len(curve.sampled_points))


def channelbags(action: Thing, slot: Thing) -> list[Thing] | None:
    """List where a slot's curves are; None where actions have no slots (before Blender 4.4)."""
    if not hasattr(action, "layers"):
        return None
    if slot is None:
        return []
    bags = [strip.channelbag(slot) for layer in action.layers for strip in layer.strips]
    return [bag for bag in bags if bag is not None]


def keys_of(curve: Thing) -> Keys:
    """Read the keys of an F-curve; of one that was sampled, its samples, joined by straight lines."""
    points = curve.keyframe_points
    if not len(points):
        samples = np.empty(2 * len(curve.sampled_points), dtype=np.float32)
        curve.sampled_points.foreach_get("co", samples)
        pairs = samples.reshape(-1, 2).astype(np.float64)
        return Keys.straight(pairs[:, 0], pairs[:, 1], straight_on=curve.extrapolation == "LINEAR")
    rows = {}
    for name in ("co", "handle_left", "handle_right"):
        values = np.empty(2 * len(points), dtype=np.float32)
        points.foreach_get(name, values)
        rows[name] = values.reshape(-1, 2).astype(np.float64)
    codes = np.empty(len(points), dtype=np.int32)
    points.foreach_get("interpolation", codes)
    return Keys(
        rows["co"][:, 0],
        rows["co"][:, 1],
        rows["handle_left"],
        rows["handle_right"],
        codes.astype(np.int64),
        curve.extrapolation == "LINEAR",
        np.arange(len(points)),
    )


def evaluation(curve: Thing) -> Any:
    """Return the function that has Blender evaluate a curve at frames; without its modifiers, which see the keys."""

    def evaluate(frames: FloatArray) -> FloatArray:
        states = [(modifier, modifier.mute) for modifier in curve.modifiers]
        try:
            for modifier, _ in states:
                modifier.mute = True
            return np.array([curve.evaluate(frame) for frame in frames.tolist()])
        finally:
            for modifier, mute in states:
                modifier.mute = mute

    return evaluate


def cycles_of(curve: Thing) -> tuple[Cycles, Thing] | None:
    """Return the Cycles modifier of a curve where it is all that bends time; None where there is none to write out.

    Blender lets only the first modifier of a curve be one.
    """
    for modifier in curve.modifiers:
        if modifier.type != "CYCLES" or modifier.mute or modifier.use_restricted_range:
            continue
        if modifier.use_influence and modifier.influence < 1.0:
            continue
        return Cycles(
            modifier.mode_before, modifier.mode_after, modifier.cycles_before, modifier.cycles_after
        ), modifier
    return None


def is_discrete(block: Thing, curve: Thing) -> bool:
    """Tell whether a curve moves a switch or a choice, between whose values there are none."""
    try:
        value = block.path_resolve(curve.data_path)
    except ValueError:
        return False
    if not isinstance(value, str) and hasattr(value, "__len__"):
        # Switches stand in rows too, such as one for each axis.
        value = value[curve.array_index] if curve.array_index < len(value) else None
    return isinstance(value, bool | str)


def drawn(block: Thing, curve: Thing, first: float, last: float) -> tuple[CurveSegments, Any, bool]:
    """Say what an F-curve draws from one of its frames to another, cycles and straight ends written out.

    Returns
    -------
    segments, source
        As `segments_of` has them.
    was_cyclic : bool
        A Cycles modifier was written out.
    """
    keys = keys_of(curve)
    segments, source = segments_of(keys, evaluate=evaluation(curve), discrete=is_discrete(block, curve))
    cycles = cycles_of(curve)
    if cycles is not None:
        segments, source = unrolled(segments, source, cycles[0], first, last)
        return segments, source, True
    slopes = end_slopes(keys)
    if any(slopes):
        segments, source = continued(segments, source, slopes, first, last)
    return segments, source, False


def write_keys(curve: Thing, keys: Keys) -> None:
    """Put keys in place of a curve's own; keys that were there already keep their marks and their selection."""
    if curve.sampled_points and not len(curve.keyframe_points):
        curve.convert_to_keyframes(0, 1)
    points = curve.keyframe_points
    marks = {}
    for name in ("type", "select_control_point", "select_left_handle", "select_right_handle"):
        values = np.zeros(len(points), dtype=np.int32)
        if len(points):
            points.foreach_get(name, values)
        # What was cut is neither.
        known = (keys.source >= 0) & (keys.source < len(values))
        marks[name] = np.zeros(len(keys), dtype=np.int32)
        marks[name][known] = values[keys.source[known]]
    points.clear()
    points.add(len(keys))
    rows = {
        "co": np.stack([keys.times, keys.values], axis=1),
        "interpolation": keys.interpolation,
        "handle_left_type": np.full(len(keys), _FREE),
        "handle_right_type": np.full(len(keys), _FREE),
        "handle_left": keys.left,
        "handle_right": keys.right,
        **marks,
    }
    if curve.id_data.override_library is not None:
        # Of a library override Blender lets single values be set, and passes over whole rows without a word.
        _write_singly(points, rows)
        return
    for name, values in rows.items():
        kind = np.float32 if values.ndim == 2 else np.int32
        points.foreach_set(name, np.ascontiguousarray(values, dtype=kind).ravel())
    # curve.update() would sort keys and recompute handles, for which there is no need, and drop keys that lie within a
    # hundredth of a frame of another: cuts may.


def _write_singly(points: Thing, rows: dict[str, Any]) -> None:
    names = {
        name: {item.value: item.identifier for item in points[0].rna_type.properties[name].enum_items}
        for name in ("interpolation", "handle_left_type", "handle_right_type", "type")
    }
    for name, values in rows.items():
        for point, value in zip(points, values.tolist(), strict=True):
            setattr(point, name, names[name][value] if name in names else value)


def own_copy(units: Sequence[Unit], name: str) -> dict[int, Thing]:
    """Copy the action that units share, and leave in the copy only what is theirs.

    Returns
    -------
    dict from index of a unit to ActionSlot
        The slots of the copy; its action is ``slot.id_data``. Without slots the values are the copy itself.
    """
    action = units[0].action
    copy = action.copy()
    copy.name = name
    if not hasattr(action, "layers"):
        return dict.fromkeys(range(len(units)), copy)
    wanted = {unit.slot.identifier for unit in units if unit.slot is not None}
    for slot in [slot for slot in copy.slots if slot.identifier not in wanted]:
        copy.slots.remove(slot)
    by_name = {slot.identifier: slot for slot in copy.slots}
    return {i: by_name[unit.slot.identifier] for i, unit in enumerate(units) if unit.slot is not None}


def assign(unit: Unit, action: Thing, slot: Thing) -> None:
    """Have a data-block, or its strip, play another action."""
    holder = unit.block.animation_data if unit.strip is None else unit.strip
    holder.action = action
    if slot is not None:
        holder.action_slot = slot


def is_shared(data: Thing, action: Thing, slot: Thing, blocks: Sequence[Thing]) -> bool:
    """Tell whether anything but these data-blocks plays an action, or this slot of it.

    Parameters
    ----------
    data : bpy.data
    action : Action
    slot : ActionSlot or None
        None before Blender 4.4.
    blocks : sequence of data-block
    """
    others = data.user_map(subset=[action])[action] - set(blocks)
    return any(
        unit.action == action and (slot is None or (unit.slot is not None and unit.slot.identifier == slot.identifier))
        for other in others
        if getattr(other, "animation_data", None) is not None
        for unit in units_of(other)
    )


def shared_notes(data: Thing, objects: Sequence[Thing]) -> list[str]:
    """Name what is not selected and yet changes: objects that have their data from one that is."""
    # Keys of shapes belong to a mesh, which objects have.
    lent = {block: one.data for one in objects for block in blocks_of([one]) if block != one}
    # All of Blender's data is looked through, once.
    users = data.user_map(subset=set(lent.values())) if lent else {}
    return [
        f"{block.name} is the data of {user.name} too, which gets the same timing"
        for block, owned in lent.items()
        for user in sorted(users[owned], key=lambda user: str(user.name))
        if getattr(user, "data", None) == owned and user not in objects
    ]


def frame_notes(objects: Sequence[Thing]) -> list[str]:
    """Name what does not follow: drivers, modifiers and constraints by the scene's frames, keys of materials."""
    notes = []
    for one in objects:
        notes += [
            f"{one.name}: {modifier.name} runs in the scene's own frames"
            for modifier in one.modifiers
            if modifier.type in _SIMULATED or (modifier.type == "NODES" and _is_timed(modifier.node_group))
        ]
        if one.rigid_body is not None and one.rigid_body.type == "ACTIVE" and not one.rigid_body.kinematic:
            notes.append(f"{one.name}: its rigid body runs in the scene's own frames")
        for holder in (one, *(one.pose.bones if one.pose is not None else ())):
            notes += [
                f"{holder.name}: {constraint.name} runs in the scene's own frames"
                for constraint in holder.constraints
                if constraint.type in _FILMED
            ]
        for block in (one, one.data, getattr(one.data, "shape_keys", None)):
            animation = getattr(block, "animation_data", None)
            if block is None or animation is None:
                continue
            notes += [
                f"{block.name}: the driver of {driver.data_path} goes by the scene's frames"
                for driver in animation.drivers
                if _goes_by_frames(driver)
            ]
            for unit in units_of(block):
                notes += _modifier_notes(unit)
        notes += [
            f"{one.name}: keys of {words} keep their timing, as other objects may use these too"
            for words, block in _lent(one)
            if getattr(block, "animation_data", None) is not None and units_of(block)
        ]
    return notes


def _lent(one: Thing) -> Iterator[tuple[str, Thing]]:
    """List what an object uses and does not own, where keys may be: materials, nodes, particles."""
    for slot in one.material_slots:
        if slot.material is not None:
            yield f"the material {slot.material.name}", slot.material
            yield f"the nodes of the material {slot.material.name}", slot.material.node_tree
    if one.type == "LIGHT":
        yield f"the nodes of the light {one.data.name}", one.data.node_tree
    for modifier in one.modifiers:
        if modifier.type == "NODES":
            yield f"the nodes of {modifier.name}", modifier.node_group
    for system in one.particle_systems:
        yield f"the particles {system.name}", system.settings


def _is_timed(tree: Thing, seen: frozenset[str] = frozenset()) -> bool:
    """Tell whether nodes, or groups of nodes among them, go by the scene's frames."""
    if tree is None or tree.name_full in seen:
        return False
    seen |= {tree.name_full}
    return any(
        node.bl_idname in _TIMED_NODES or _is_timed(getattr(node, "node_tree", None), seen) for node in tree.nodes
    )


def _goes_by_frames(driver: Thing) -> bool:
    inner = driver.driver
    paths = [target.data_path for variable in inner.variables for target in variable.targets]
    if any(path.startswith("frame_") for path in paths):
        return True
    # A variable hides what Blender calls by its name.
    words = set(_WORD.findall(inner.expression)) - {variable.name for variable in inner.variables}
    return inner.type == "SCRIPTED" and any(word == "frame" or word.startswith("frame_") for word in words)


def _modifier_notes(unit: Unit) -> Iterable[str]:
    for curve in fcurves_of(unit.action, unit.slot):
        written_out = cycles_of(curve)
        for modifier in curve.modifiers:
            if modifier.mute or (written_out is not None and modifier == written_out[1]):
                continue
            if modifier.type == "LIMITS" and not (
                modifier.use_min_x or modifier.use_max_x or modifier.use_restricted_range
            ):
                # It bounds values, whatever the time.
                continue
            yield (
                f"{unit.block.name}: the {modifier.type.capitalize().replace('_', ' ')} modifier of {curve.data_path} "
                "goes by the scene's frames"
            )
