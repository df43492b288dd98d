"""New timing for all that a selection of objects plays: keys kept, by NLA strips, or baked.

Objects of Blender are handed in; what is computed about curves is in `fcurve_keys` and `bake`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from retime.arrays import FloatArray
from retime.warp.cutting import CurveSegments

from .animated import (
    Thing,
    Unit,
    assign,
    blocks_of,
    drawn,
    evaluation,
    fcurves_of,
    frame_notes,
    is_discrete,
    is_shared,
    keyed,
    keys_of,
    line_of,
    own_copy,
    plays_once,
    shared_notes,
    strip_curve,
    strips_of,
    units_of,
    write_keys,
)
from .bake import Channels, CurveName, baked
from .fcurve_keys import (
    CONSTANT,
    LINEAR,
    Keys,
    difference,
    negated_from,
    on_whole_frames,
    retimed,
    segments_of,
    stretched,
    stretched_curve,
    with_samples,
)
from .timing import Timing

Kind = Literal["KEYS", "NLA", "BAKE"]


@dataclass(frozen=True)
class Wanted:
    """How a result is to be made.

    Attributes
    ----------
    kind : {"KEYS", "NLA", "BAKE"}
        Keys kept, curves cut exactly; strips with a curve of strip time; a key on every frame.
    snap : bool
        With "KEYS": keys on whole frames.
    average : bool
        With "BAKE": averaged where sped up.
    new_action : bool
        Leave the old action as it is, with a fake user.
    move_markers, move_range : bool
        Markers, and the frame range of scene and action, follow.
    """

    kind: Kind = "KEYS"
    snap: bool = False
    average: bool = True
    new_action: bool = True
    move_markers: bool = True
    move_range: bool = True


@dataclass
class Report:
    """What is to be said of a result.

    Attributes
    ----------
    notes : list of str
        What did not follow, or was done another way.
    snapped : dict of str to float
        For kinds of curves, by how much snapping to whole frames changed one at most.
    """

    notes: list[str] = field(default_factory=list)
    snapped: dict[str, float] = field(default_factory=dict)

    def lines(self) -> list[str]:
        """Return it as lines of text."""
        said = [f"on whole frames {kind} is off by {most:.3g} at most" for kind, most in sorted(self.snapped.items())]
        return said + list(dict.fromkeys(self.notes))


def extent(objects: Sequence[Thing]) -> tuple[float, float]:
    """Return the first and the last frame of the scene at which anything of the objects has a key or a strip."""
    low, high = np.inf, -np.inf
    for block in blocks_of(objects):
        for unit in units_of(block):
            if unit.strip is not None:
                low, high = min(low, unit.strip.frame_start), max(high, unit.strip.frame_end)
                continue
            for curve in filter(keyed, fcurves_of(unit.action, unit.slot)):
                first, last = curve.range()
                low, high = min(low, first), max(high, last)
    return float(low), float(high)


def retime(data: Thing, objects: Sequence[Thing], scene: Thing, timing: Timing, wanted: Wanted) -> Report:
    """Give all that objects play a new timing.

    Parameters
    ----------
    data : bpy.data
    objects : sequence of Object
        Those that `animated.refuse_untouchable` takes.
    scene : Scene
        Their scene.
    timing : Timing
        In its frames.
    wanted : Wanted
        How.
    """
    report = Report([*frame_notes(objects), *shared_notes(data, objects)])
    # Ends of what is played are asked for before anything moves.
    reach = _reach(objects, scene, timing)
    if wanted.kind == "NLA":
        for block in blocks_of(objects):
            _by_strips(block, timing, reach, report)
    else:
        _by_keys(data, objects, scene, timing, reach, wanted, report)
    if wanted.move_markers:
        for marker in scene.timeline_markers:
            marker.frame = round(timing.moved(marker.frame))
    if wanted.move_range:
        _move_range(scene, timing)
    # All that depends on time is stale now.
    scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
    return report


def _reach(objects: Sequence[Thing], scene: Thing, timing: Timing) -> tuple[float, float]:
    low, high = extent(objects)
    return min(low, scene.frame_start, timing.start), max(high, scene.frame_end, timing.input_end)


def _move_range(scene: Thing, timing: Timing) -> None:
    for start, end in (("frame_start", "frame_end"), ("frame_preview_start", "frame_preview_end")):
        first, last = (round(timing.moved(getattr(scene, name))) for name in (start, end))
        # The one that gives way first must not push the other.
        for name, frame in ((end, max(last, getattr(scene, start))), (start, first), (end, last)):
            setattr(scene, name, frame)


def _by_keys(
    data: Thing,
    objects: Sequence[Thing],
    scene: Thing,
    timing: Timing,
    reach: tuple[float, float],
    wanted: Wanted,
    report: Report,
) -> None:
    groups: dict[tuple[Any, ...], list[Unit]] = {}
    for block in blocks_of(objects):
        for unit in units_of(block):
            if unit.strip is not None and not plays_once(unit.strip):
                report.notes.append(
                    f"{unit.block.name}: the strip {unit.strip.name} repeats, runs backward or has strip time of its "
                    "own; its strip time was retimed, its keys were not"
                )
                continue
            if hasattr(unit.action, "layers") and unit.slot is None:
                # It plays nothing of its action.
                continue
            line = unit.line
            key = (unit.action.name_full, round(line.at - line.start / line.speed, 4), round(line.speed, 6))
            groups.setdefault(key, []).append(unit)
    played: dict[str, int] = {}
    for name, *_ in groups:
        played[name] = played.get(name, 0) + 1
    blocks = blocks_of(objects)
    for (name, *_), units in groups.items():
        old = units[0].action
        # One action that is played in two places with different timing becomes two; a linked one is nobody's to change,
        # and one that others play too is not the selection's alone.
        new = wanted.new_action or played[name] > 1 or old.library is not None
        new = new or any(is_shared(data, old, unit.slot, blocks) for unit in units)
        slots = own_copy(units, f"{old.name} retimed") if new else {i: unit.slot for i, unit in enumerate(units)}
        done: set[str] = set()
        for i, unit in enumerate(units):
            slot: Thing = slots.get(i)
            has_slots = hasattr(old, "layers")
            action = (slot.id_data if has_slots else slot) if new else old
            own = slot.identifier if has_slots else action.name
            if own not in done:
                done.add(own)
                _retime_action(
                    unit,
                    action,
                    slot if has_slots else None,
                    scene,
                    timing,
                    reach,
                    wanted,
                    report,
                    first=len(done) == 1,
                )
            if new:
                assign(unit, action, slot if has_slots else None)
        if new and old.library is None:
            old.use_fake_user = True
    for block in blocks_of(objects):
        _move_strips(block, timing)


def _retime_action(
    unit: Unit,
    action: Thing,
    slot: Thing,
    scene: Thing,
    timing: Timing,
    reach: tuple[float, float],
    wanted: Wanted,
    report: Report,
    *,
    first: bool,
) -> None:
    line = unit.line
    curves = [curve for curve in fcurves_of(action, slot) if keyed(curve)]
    low, high = (float(frame) for frame in line.inner(np.array(reach)))
    draws: list[tuple[CurveSegments, Any]] = []
    exact: list[Keys] = []
    for curve in curves:
        keys = keys_of(curve)
        segments, source, was_cyclic = drawn(unit.block, curve, low, high)
        segments = stretched_curve(segments, line.start, line.at, 1 / line.speed)
        begin = float(segments.times[0, 0]) if len(segments) else segments.end_time
        warp = timing.reaching(min(begin, reach[0]), max(segments.end_time, reach[1]))
        # What went straight on ends in a straight line, along which it goes on.
        straight = keys.straight_on and not was_cyclic
        extended = len(segments) and straight and segments.end_time > float(line.outer(keys.times[-1])) + 0.5
        code = LINEAR if extended else int(keys.interpolation[-1])
        exact.append(retimed(segments, source, warp, last_code=code, straight_on=straight))
        draws.append((segments, source))
        if was_cyclic:
            report.notes.append(
                f"{unit.block.name}: the cycles of {curve.data_path} were written out as keys, to frame "
                f"{exact[-1].times[-1]:.0f}"
            )
    results = exact
    if wanted.kind == "BAKE":
        results = _baked(unit, curves, draws, exact, scene, timing, wanted)
    elif wanted.snap:
        results = [on_whole_frames(keys) for keys in exact]
        for curve, keys, true in zip(curves, results, exact, strict=True):
            kind = curve.data_path.rsplit(".", 1)[-1]
            report.snapped[kind] = max(report.snapped.get(kind, 0.0), difference(keys, true))
    for curve, keys in zip(curves, results, strict=True):
        write_keys(curve, stretched(keys, line.at, line.start, line.speed))
        for modifier in [one for one in curve.modifiers if one.type == "CYCLES"]:
            if _was_written_out(curve, modifier):
                curve.modifiers.remove(modifier)
    if not first:
        return

    def moved(frame: float) -> float:
        return float(line.inner(timing.moved(float(line.outer(frame)))))

    if wanted.move_markers:
        for marker in action.pose_markers:
            marker.frame = round(moved(marker.frame))
    if wanted.move_range and action.use_frame_range:
        action.frame_start, action.frame_end = moved(action.frame_start), moved(action.frame_end)


def _was_written_out(curve: Thing, modifier: Thing) -> bool:
    from .animated import cycles_of

    found = cycles_of(curve)
    return found is not None and found[1] == modifier


def _baked(
    unit: Unit,
    curves: Sequence[Thing],
    draws: Sequence[tuple[CurveSegments, Any]],
    exact: Sequence[Keys],
    scene: Thing,
    timing: Timing,
    wanted: Wanted,
) -> list[Keys]:
    names: list[CurveName] = [(curve.data_path, curve.array_index) for curve in curves]
    by_name = {name: drawing[0] for name, drawing in zip(names, draws, strict=True)}
    discrete = frozenset(name for name, curve in zip(names, curves, strict=True) if is_discrete(unit.block, curve))
    chains = chains_of(unit.block)
    values = baked(
        by_name,
        chains,
        timing,
        average=wanted.average,
        discrete=discrete,
        metres_per_unit=float(scene.unit_settings.scale_length),
    )
    frames = timing.frames()
    exact = _agreeing_after(chains, names, exact, by_name, values, timing)
    # A strip may begin and end between two frames, and holds what its action has there.
    ends = np.zeros(0)
    if unit.strip is not None and not wanted.average:
        ends = np.array([timing.moved(unit.strip.frame_start), timing.moved(unit.strip.frame_end)])
    results = []
    for name, keys in zip(names, exact, strict=True):
        # Nor is a curve to become longer than it was: there may be nothing beyond its ends.
        low, high = max(frames[0], keys.times[0]), min(frames[-1], keys.times[-1])
        if high <= low:
            results.append(keys)
            continue
        inside = frames[(frames > low) & (frames < high)]
        between = ends[(ends > low) & (ends < high)]
        at = np.unique(np.concatenate([[low], inside, between, [high]]))
        whole = np.isin(at, frames)
        rows = by_name[name](timing.warp(at))[:, 0]
        rows[whole] = values[name][np.isin(frames, at)]
        made = with_samples(keys, at, rows)
        if name in discrete:
            made.interpolation[:] = CONSTANT
        results.append(made)
    return results


def _agreeing_after(
    chains: Sequence[Channels],
    names: Sequence[CurveName],
    exact: Sequence[Keys],
    by_name: dict[CurveName, CurveSegments],
    values: dict[CurveName, FloatArray],
    timing: Timing,
) -> list[Keys]:
    """Flip the signs of quaternions after the range where they flipped within it: baked ones agree, and so must these.

    Both signs mean one turn, so no pose changes.
    """
    last = timing.frames()[-1:]
    result = list(exact)
    for chain in chains:
        turn = [(chain.turn_path, i) for i in range(4)]
        if chain.mode != "QUATERNION" or not all(name in by_name for name in turn):
            continue
        was = [float(by_name[name](timing.warp(last))[0, 0]) for name in turn]
        if sum(old * values[name][-1] for old, name in zip(was, turn, strict=True)) < 0:
            for name in turn:
                at = names.index(name)
                result[at] = negated_from(result[at], float(last[0]))
    return result


def chains_of(block: Thing) -> list[Channels]:
    """Read where an object, and the bones of an armature, keep their places and turns; none for other data-blocks."""
    if not hasattr(block, "rotation_mode"):
        return []
    chains = [_channels("", block.name, -1, np.eye(4), block)]
    if block.type != "ARMATURE":
        return chains
    bones = block.data.bones
    place = {bone.name: i + 1 for i, bone in enumerate(bones)}
    for bone in bones:
        rest = np.array(bone.matrix_local)
        if bone.parent is not None:
            rest = np.linalg.inv(np.array(bone.parent.matrix_local)) @ rest
        parent = 0 if bone.parent is None else place[bone.parent.name]
        prefix = f"{block.pose.bones[bone.name].path_from_id()}."
        chains.append(_channels(prefix, bone.name, parent, rest, block.pose.bones[bone.name]))
    return chains


def _channels(prefix: str, name: str, parent: int, rest: FloatArray, holder: Thing) -> Channels:
    mode = holder.rotation_mode
    turn = {"QUATERNION": "rotation_quaternion", "AXIS_ANGLE": "rotation_axis_angle"}.get(mode, "rotation_euler")
    return Channels(prefix, name, parent, rest, mode, np.array(holder.location), np.array(getattr(holder, turn)))


def _move_strips(block: Thing, timing: Timing) -> None:
    """Have strips begin and end where the new timing has them; those that keep their keys follow by strip time."""
    _place([_Place.of(strip, timing, by_time=not plays_once(strip)) for strip in strips_of(block)])


@dataclass(frozen=True)
class _Place:
    """Where a strip comes to be, and what it plays there.

    Attributes
    ----------
    strip : NlaStrip
    start, end : float
        In the scene's frames.
    blends : (float, float)
        Frames over which it comes in and goes out.
    controls : dict of str to Keys
        Its own curves, by their data paths: influence and strip time, which run in the scene's frames.
    action : (float, float) or None
        The first and the last frame of its action that it plays; None where these stay, or it has none.
    scale : float
        Frames of the scene for one of the action.
    """

    strip: Thing
    start: float
    end: float
    blends: tuple[float, float]
    controls: dict[str, Keys]
    action: tuple[float, float] | None
    scale: float

    @classmethod
    def of(cls, strip: Thing, timing: Timing, *, by_time: bool) -> _Place:
        """Say where a strip comes to be; `by_time`: its keys stay, and its curve of strip time is retimed."""
        start, end = strip.frame_start, strip.frame_end
        new = timing.moved(start), timing.moved(end)
        blends = (
            timing.moved(start + strip.blend_in) - new[0],
            new[1] - timing.moved(end - strip.blend_out),
        )
        controls = {}
        for curve in strip.fcurves:
            if curve.data_path == "strip_time" or not len(curve.keyframe_points):
                continue
            keys = keys_of(curve)
            segments, source = segments_of(keys, evaluate=evaluation(curve))
            warp = timing.reaching(float(keys.times[0]), float(keys.times[-1]))
            controls[curve.data_path] = retimed(
                segments, source, warp, last_code=int(keys.interpolation[-1]), straight_on=keys.straight_on
            )
        action = None
        if strip.type == "CLIP" and by_time:
            segments, source = strip_curve(strip)
            warp = timing.reaching(start, end)
            controls["strip_time"] = retimed(segments, source, warp, last_code=LINEAR, straight_on=False)
        elif strip.type == "CLIP":
            # The same line from the scene's frames to the action's, over another stretch.
            line = line_of(strip)
            action = float(line.inner(new[0])), float(line.inner(new[1]))
        return cls(strip, *new, blends, controls, action, strip.scale)


def _place(places: Sequence[_Place]) -> None:
    """Move strips to their places.

    While one is moved Blender pushes its neighbours along, and blends them anew where they do so by themselves: each
    kind of change is made to all before the next one.
    """
    for place in places:
        strip = place.strip
        if "strip_time" in place.controls:
            strip.use_animated_time = True
        if place.action is not None:
            first, last = place.action
            strip.use_sync_length = False
            strip.action_frame_start, strip.action_frame_end = min(first, strip.action_frame_end - 1e-3), last
            strip.action_frame_start = first
            strip.scale = place.scale
        for path, keys in place.controls.items():
            write_keys(strip.fcurves.find(path), keys)
    for place in places:
        strip = place.strip
        # Whichever end must go first.
        if place.end > strip.frame_start_raw:
            strip.frame_end_raw, strip.frame_start_raw = place.end, place.start
        else:
            strip.frame_start_raw, strip.frame_end_raw = place.start, place.end
    for place in places:
        place.strip.blend_in, place.strip.blend_out = 0.0, 0.0
        place.strip.blend_in, place.strip.blend_out = place.blends


def _by_strips(block: Thing, timing: Timing, reach: tuple[float, float], report: Report) -> None:
    """Leave the keys of a data-block, and have strips play them with the new timing."""
    animation = block.animation_data
    if animation.action is not None:
        alone = not animation.use_nla or not len(animation.nla_tracks)
        if not animation.use_nla:
            # Where strips were not played, the one that is to be must be the only one.
            for track in animation.nla_tracks:
                track.mute = True
            if any(strips_of(block)):
                report.notes.append(f"{block.name}: its NLA was switched off; it is on now, and its other tracks muted")
            animation.use_nla = True
        _push_down(animation, reach, alone=alone)
    _place([_Place.of(strip, timing, by_time=True) for strip in strips_of(block)])


def _push_down(animation: Thing, reach: tuple[float, float], *, alone: bool) -> None:
    """Make the active action a strip on a track of its own, on top, that plays what it played.

    Where it was played `alone`, without an NLA, Blender did not look at how it was to be mixed.
    """
    action, slot = animation.action, getattr(animation, "action_slot", None)
    low, high = reach[0], max(reach[1], reach[0] + 1.0)
    if not alone:
        first, last = _own_range(action, slot, (low, high))
        # Beyond its own frames, it is held there or not at all.
        low = low if animation.action_extrapolation == "HOLD" else first
        high = high if animation.action_extrapolation != "NOTHING" else max(last, low + 1.0)
    track = animation.nla_tracks.new()
    track.name = "Retime"
    strip = track.strips.new(action.name, int(np.floor(low)), action)
    if slot is not None:
        strip.action_slot = slot
    strip.use_sync_length = False
    strip.action_frame_start, strip.action_frame_end = low, high
    strip.scale = strip.repeat = 1.0
    strip.frame_end_raw, strip.frame_start_raw = high, low
    if not alone:
        strip.extrapolation = animation.action_extrapolation
        strip.blend_type = animation.action_blend_type
        if animation.action_influence < 1.0:
            strip.use_animated_influence = True
            # Without a key it would be a curve that says nothing, which is taken for none.
            strip.fcurves.find("influence").keyframe_points.insert(low, animation.action_influence)
    animation.action = None


def _own_range(action: Thing, slot: Thing, reach: tuple[float, float]) -> tuple[float, float]:
    """Return the first and the last frame of an action as Blender has them; curves with modifiers know no end."""
    curves = [curve for curve in fcurves_of(action, slot) if keyed(curve)]
    if not curves or any(len(curve.modifiers) for curve in curves):
        return reach
    return min(curve.range()[0] for curve in curves), max(curve.range()[1] for curve in curves)
