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
    own_copy,
    plays_once,
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
from .timing import Line, Timing

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


def retime(objects: Sequence[Thing], scene: Thing, timing: Timing, wanted: Wanted) -> Report:
    """Give all that objects play a new timing.

    Parameters
    ----------
    objects : sequence of Object
        Those that `animated.refuse_untouchable` takes.
    scene : Scene
        Their scene.
    timing : Timing
        In its frames.
    wanted : Wanted
        How.
    """
    report = Report(frame_notes(objects))
    # Ends of what is played are asked for before anything moves.
    reach = _reach(objects, scene, timing)
    if wanted.kind == "NLA":
        for block in blocks_of(objects):
            _by_strips(block, timing, reach, report)
    else:
        _by_keys(objects, scene, timing, reach, wanted, report)
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
    objects: Sequence[Thing],
    scene: Thing,
    timing: Timing,
    reach: tuple[float, float],
    wanted: Wanted,
    report: Report,
) -> None:
    # All else is handed in; who plays an action only Blender as a whole can say.
    import bpy

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
        new = new or any(is_shared(bpy.data, old, unit.slot, blocks) for unit in units)
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
        ends = ends[(ends > frames[0]) & (ends < frames[-1]) & (ends != np.rint(ends))]
    results = []
    for name, keys in zip(names, exact, strict=True):
        at = np.concatenate([frames, ends])
        rows = np.concatenate([values[name], by_name[name](timing.warp(ends))[:, 0]])
        made = with_samples(keys, np.sort(at), rows[np.argsort(at)])
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
    for strip in strips_of(block):
        start, end = strip.frame_start, strip.frame_end
        new_start, new_end = timing.moved(start), timing.moved(end)
        if strip.type == "CLIP" and not plays_once(strip):
            _by_strip_time(strip, timing)
            continue
        _retime_controls(strip, timing)
        blends = _moved_blends(strip, timing)
        if strip.type == "CLIP":
            # The same line from the scene's frames to the action's, over another stretch.
            line = Line(start, strip.action_frame_start, 1.0 / strip.scale)
            first, last = float(line.inner(new_start)), float(line.inner(new_end))
            scale = strip.scale
            strip.use_sync_length = False
            strip.action_frame_start, strip.action_frame_end = min(first, strip.action_frame_end - 1e-3), last
            strip.action_frame_start = first
            strip.scale = scale
        _place(strip, new_start, new_end)
        strip.blend_in, strip.blend_out = blends


def _place(strip: Thing, start: float, end: float) -> None:
    """Set both ends of a strip, whichever must go first."""
    if end > strip.frame_start_raw:
        strip.frame_end_raw, strip.frame_start_raw = end, start
    else:
        strip.frame_start_raw, strip.frame_end_raw = start, end


def _moved_blends(strip: Thing, timing: Timing) -> tuple[float, float]:
    start, end = strip.frame_start, strip.frame_end
    return (
        timing.moved(start + strip.blend_in) - timing.moved(start),
        timing.moved(end) - timing.moved(end - strip.blend_out),
    )


def _retime_controls(strip: Thing, timing: Timing) -> None:
    """Retime the curves of a strip itself (influence), which run in the scene's frames."""
    for curve in strip.fcurves:
        if curve.data_path == "strip_time" or not len(curve.keyframe_points):
            continue
        keys = keys_of(curve)
        segments, source = segments_of(keys, evaluate=evaluation(curve))
        warp = timing.reaching(float(keys.times[0]), float(keys.times[-1]))
        write_keys(
            curve,
            retimed(segments, source, warp, last_code=int(keys.interpolation[-1]), straight_on=keys.straight_on),
        )


def _by_strips(block: Thing, timing: Timing, reach: tuple[float, float], report: Report) -> None:
    """Leave the keys of a data-block, and have strips play them with the new timing."""
    animation = block.animation_data
    strips = list(strips_of(block))
    action, slot = animation.action, getattr(animation, "action_slot", None)
    if action is not None:
        if not animation.use_nla:
            # Where strips were not played, the one that is to be must be the only one.
            for track in animation.nla_tracks:
                track.mute = True
            if strips:
                report.notes.append(f"{block.name}: its NLA was switched off; it is on now, and its other tracks muted")
            animation.use_nla = True
        strips.append(_pushed_down(animation, action, slot, reach))
    for strip in strips:
        if strip.type == "CLIP":
            _by_strip_time(strip, timing)
        else:
            _place(strip, timing.moved(strip.frame_start), timing.moved(strip.frame_end))


def _pushed_down(animation: Thing, action: Thing, slot: Thing, reach: tuple[float, float]) -> Thing:
    """Make the active action a strip on a track of its own, on top, that plays what it played."""
    track = animation.nla_tracks.new()
    track.name = "Retime"
    first = int(np.floor(reach[0]))
    strip = track.strips.new(action.name, first, action)
    if slot is not None:
        strip.action_slot = slot
    strip.use_sync_length = False
    low, high = reach[0], max(reach[1], reach[0] + 1.0)
    strip.action_frame_start, strip.action_frame_end = low, high
    strip.scale = strip.repeat = 1.0
    _place(strip, low, high)
    strip.extrapolation = animation.action_extrapolation
    strip.blend_type = animation.action_blend_type
    if animation.action_influence < 1.0:
        strip.use_animated_influence = True
        strip.influence = animation.action_influence
    animation.action = None
    return strip


def _by_strip_time(strip: Thing, timing: Timing) -> None:
    """Retime a strip by its curve of strip time; its keys stay."""
    curve, source = strip_curve(strip)
    start, end = strip.frame_start, strip.frame_end
    blends = _moved_blends(strip, timing)
    warp = timing.reaching(start, end)
    keys = retimed(curve, source, warp, last_code=LINEAR, straight_on=False)
    _retime_controls(strip, timing)
    strip.use_animated_time = True
    write_keys(strip.fcurves.find("strip_time"), keys)
    _place(strip, timing.moved(start), timing.moved(end))
    strip.blend_in, strip.blend_out = blends
