"""One press of a button: what is read from the scene, the search, and what is written back.

Reading and writing touch Blender and belong to its own thread; the search between them does not, and may run in
another.
"""

from __future__ import annotations

import contextlib
import threading
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from retime.errors import OptionError, RetimeWarning
from retime.formats.registry import read
from retime.motion.any_motion import AnyMotion
from retime.warp.curve import Warp

from .animated import (
    Thing,
    assign,
    channelbags,
    evaluation,
    fcurves_of,
    keyed,
    keys_of,
    refuse_edited,
    refuse_untouchable,
    units_of,
    write_keys,
)
from .asked import Answer, Asked, Way, answer
from .fcurve_keys import Keys, segments_of
from .hand import hand_timing, keyed_timing
from .retiming import Wanted, extent, retime
from .sampling import clips_of, rate_of
from .timing import Timing
from .wording import summary

# The custom property of the scene whose keys are the curve of the new timing: the input frame over the output frame.
CURVE = "retime_curve"


class Stopped(Exception):
    """The person pressed Esc."""


@dataclass
class Job:
    """A search and what becomes of it.

    Attributes
    ----------
    asked : Asked
        What is asked.
    objects : sequence of Object
        What gets the new timing.
    wanted : Wanted
        How.
    tolerance : float
        Frames by which the timing may be off so that it has fewer knots.
    before : list of (Unit, Action, ActionSlot)
        Actions to go back to before the timing is given: what a hand's example was made from.
    """

    asked: Asked
    objects: Sequence[Thing]
    wanted: Wanted
    tolerance: float
    before: list[tuple[Any, Thing, Thing]] = field(default_factory=list)
    answer: Answer | None = None
    error: BaseException | None = None
    share: float = 0.0
    _stop: threading.Event = field(default_factory=threading.Event)

    def search(self) -> None:
        """Search; in any thread. The answer, or what was raised, is kept."""
        try:
            found = answer(self.asked, self._tell)
            # A short search may end before it says anything; who pressed Esc wants nothing of it.
            self._tell(1.0)
            self.answer = found
        except Exception as error:
            # It is raised again in Blender's own thread, by `answered`.
            self.error = error

    def stop(self) -> None:
        """End the search."""
        self._stop.set()

    def _tell(self, share: float) -> None:
        if self._stop.is_set():
            raise Stopped
        if share == share:
            self.share = share

    def answered(self) -> Answer:
        """Return the answer, its timing simplified; raise what the search raised."""
        if self.error is not None:
            raise self.error
        assert self.answer is not None
        timing = self.answer.timing
        if self.tolerance > 0:
            timing = timing.simplified(self.tolerance)
        return Answer(timing, self.answer.found, self.answer.warnings)

    def finish(self, data: Thing, scene: Thing) -> list[str]:
        """Give the objects the timing that was found; return what is to be said."""
        found = self.answered()
        for unit, action, slot in self.before:
            assign(unit, action, slot)
        report = retime(data, self.objects, scene, found.timing, self.wanted)
        write_curve(scene, found.timing)
        return [*summary(found.timing, self.asked.clips[0], found.found), *report.lines(), *found.warnings]

    def preview(self, scene: Thing) -> list[str]:
        """Show the timing that was found, and change nothing else; return what is to be said."""
        found = self.answered()
        write_curve(scene, found.timing)
        return [*summary(found.timing, self.asked.clips[0], found.found), *found.warnings]


def prepare(data: Thing, scene: Thing, objects: Sequence[Thing], settings: Thing, way: Way) -> Job:
    """Read from the scene what a search needs.

    Parameters
    ----------
    data : bpy.data
    scene : Scene
    objects : sequence of Object
        The selection.
    settings : RetimeSettings
        Of the scene.
    way : {"RETIME", "PROPAGATE", "SYNCHRONISE"}

    Raises
    ------
    OptionError
        What is selected, or asked for, can't be done; names the field.
    """
    objects = what_moves(objects)
    before = _before(objects, settings) if way == "PROPAGATE" and settings.before is not None else []
    hand = None
    if way == "PROPAGATE":
        hand = _hand(before, settings)
    with _playing([(unit, action, slot) for unit, action, slot in before]):
        first, last = frame_range(scene, objects, settings)
        clips = clips_of(data, scene, objects, first, last, root=settings.root)
    asked = Asked(
        way=way,
        start=float(first),
        rate=rate_of(scene),
        clips=clips,
        keys=[(key.frame, key.to, key.speed) for key in settings.keys] if way != "PROPAGATE" else (),
        locks=[(lock.start, lock.end, lock.speeds) for lock in settings.locks],
        given=settings.given(),
        reference=() if way == "PROPAGATE" else _reference(data, scene, objects, settings, (first, last)),
        hand=hand,
        repeat=settings.repeat,
        mirror=settings.mirror,
    )
    return Job(asked, objects, wanted_of(settings), settings.tolerance, before)


def what_moves(objects: Sequence[Thing]) -> list[Thing]:
    """Return the objects of a selection that play keys.

    Raises
    ------
    OptionError
        None does, or one of the selection can't be retimed.
    """
    refuse_untouchable(objects)
    found = [one for one in objects if moves(one)]
    if not found:
        raise OptionError("nothing that is selected has keys: select what moves", option="selection")
    return found


def moves(one: Thing) -> bool:
    """Tell whether an object, its data or its shape keys play keys."""
    blocks = (one, one.data, getattr(one.data, "shape_keys", None))
    return any(
        unit.strip is not None or any(keyed(curve) for curve in fcurves_of(unit.action, unit.slot))
        for block in blocks
        if block is not None and getattr(block, "animation_data", None) is not None
        for unit in units_of(block)
    )


def wanted_of(settings: Thing) -> Wanted:
    """Read how a result is to be made."""
    return Wanted(
        settings.result,
        settings.snap,
        settings.average,
        settings.new_action,
        settings.move_markers,
        settings.move_range,
    )


def frame_range(scene: Thing, objects: Sequence[Thing], settings: Thing) -> tuple[int, int]:
    """Return the first and the last frame that get new timing.

    Raises
    ------
    OptionError
        They are no range.
    """
    if settings.range == "CUSTOM":
        first, last = settings.start, settings.end
    elif settings.range == "SCENE" and scene.use_preview_range:
        first, last = scene.frame_preview_start, scene.frame_preview_end
    elif settings.range == "SCENE":
        first, last = scene.frame_start, scene.frame_end
    else:
        low, high = extent(objects)
        first, last = int(np.floor(low)), int(np.ceil(high))
    if last - first < 1:
        raise OptionError(
            f"frames {first} to {last} are no range: there is nothing to retime from one frame on", option="range"
        )
    return first, last


def _reference(
    data: Thing, scene: Thing, objects: Sequence[Thing], settings: Thing, span: tuple[int, int]
) -> list[AnyMotion]:
    kind = settings.reference_kind
    if kind == "SELF":
        return []
    if kind == "RANGE":
        first, last = settings.reference_start, settings.reference_end
        if last - first < 1:
            raise OptionError(f"frames {first} to {last} are no range to be like", option="reference")
        return clips_of(data, scene, objects, first, last, root=settings.root)
    if kind == "OBJECT":
        other = settings.reference_object
        if other is None:
            raise OptionError("choose the object whose timing is wanted", option="reference")
        refuse_edited(other, "reference")
        if not moves(other):
            raise OptionError(f"{other.name} does not move", option="reference")
        low, high = extent([other])
        return clips_of(data, scene, [other], int(np.floor(low)), int(np.ceil(high)))
    if kind == "ACTION":
        return [_of_action(data, scene, objects, settings.reference_action, settings.root)]
    if not settings.reference_file:
        raise OptionError("choose the motion file whose timing is wanted", option="reference")
    try:
        return [read(_absolute(data, settings.reference_file))]
    except (OSError, ValueError) as error:
        raise OptionError(str(error), option="reference") from None


def _absolute(data: Thing, path: str) -> str:
    """Turn Blender's own way of writing paths beside the file (//) into a plain one."""
    from pathlib import Path

    return str(Path(data.filepath).parent / path[2:]) if path.startswith("//") else path


def _of_action(data: Thing, scene: Thing, objects: Sequence[Thing], action: Thing, root: str) -> AnyMotion:
    if action is None:
        raise OptionError("choose the action whose timing is wanted", option="reference")
    one = next((one for one in objects if one.type == "ARMATURE"), objects[0])
    first, last = action.frame_range
    with _only(one, action):
        playing = [unit for unit in units_of(one) if unit.strip is None]
        if not any(_is_there(one, curve) for unit in playing for curve in fcurves_of(unit.action, unit.slot)):
            raise OptionError(
                f"the action {action.name} moves nothing of {one.name}: choose one that was made for it, or choose the "
                "object that it moves",
                option="reference",
            )
        return clips_of(data, scene, [one], int(np.floor(first)), int(np.ceil(last)), root=root)[0]


def _is_there(block: Thing, curve: Thing) -> bool:
    """Tell whether a curve has keys, and something to move."""
    try:
        block.path_resolve(curve.data_path)
    except ValueError:
        return False
    return keyed(curve)


@contextlib.contextmanager
def _only(one: Thing, action: Thing) -> Iterator[None]:
    """Have an object play one action and nothing else, for a while."""
    animation = one.animation_data or one.animation_data_create()
    old, slot = animation.action, getattr(animation, "action_slot", None)
    use_nla = animation.use_nla
    try:
        animation.use_nla = False
        animation.action = action
        _choose_slot(animation)
        yield
    finally:
        animation.action = old
        if slot is not None:
            animation.action_slot = slot
        animation.use_nla = use_nla


def _choose_slot(holder: Thing) -> None:
    """Take the one slot that fits, where Blender does not by itself."""
    if hasattr(holder, "action_slot") and holder.action_slot is None and len(holder.action_suitable_slots):
        holder.action_slot = holder.action_suitable_slots[0]


def _before(objects: Sequence[Thing], settings: Thing) -> list[tuple[Any, Thing, Thing]]:
    """Say which of the selection plays what was retimed by hand, and the action and slot of before."""
    units = [unit for one in objects if one.animation_data is not None for unit in units_of(one) if unit.strip is None]
    if not units:
        raise OptionError("nothing that is selected plays an action of its own", option="before")
    action = settings.before
    unit = next((unit for unit in units if unit.block.type == "ARMATURE"), units[0])
    slot = None
    if channelbags(action, unit.slot) is not None:
        slots = [slot for slot in action.slots if unit.slot is not None and slot.identifier == unit.slot.identifier]
        slots += [slot for slot in action.slots if slot.target_id_type in ("OBJECT", "UNSPECIFIED")]
        if not slots:
            raise OptionError(f"the action {action.name} has no slot for {unit.block.name}", option="before")
        slot = slots[0]
    return [(unit, action, slot)]


def _hand(before: Sequence[tuple[Any, Thing, Thing]], settings: Thing) -> Any:
    if not before:
        pairs = [(key.frame, key.to) for key in settings.keys]
        return keyed_timing(pairs, settings.example_start, settings.example_end)
    unit, action, slot = before[0]

    def keyed(curves: Sequence[Thing]) -> dict[tuple[str, int], tuple[Any, Any]]:
        read = {(curve.data_path, curve.array_index): keys_of(curve) for curve in curves}
        return {name: (keys.times, keys.values) for name, keys in read.items()}

    return hand_timing(keyed(fcurves_of(action, slot)), keyed(fcurves_of(unit.action, unit.slot)))


@contextlib.contextmanager
def _playing(instead: Sequence[tuple[Any, Thing, Thing]]) -> Iterator[None]:
    """Have data-blocks play other actions for a while."""
    try:
        for unit, action, slot in instead:
            assign(unit, action, slot)
        yield
    finally:
        for unit, _, _ in instead:
            assign(unit, unit.action, unit.slot)


def write_curve(scene: Thing, timing: Timing) -> None:
    """Write the timing as keys of a custom property of the scene, which the graph editor shows."""
    warp = timing.warp
    scene[CURVE] = float(warp.input_times[0])
    curve = curve_of(scene)
    if curve is None:
        scene.keyframe_insert(f'["{CURVE}"]', frame=warp.output_start)
        curve = curve_of(scene)
    write_keys(curve, Keys.straight(warp.output_times, warp.input_times))


def curve_of(scene: Thing) -> Thing:
    """Return the F-curve that holds the timing; None where there is none."""
    animation = scene.animation_data
    if animation is None or animation.action is None:
        return None
    curves = fcurves_of(animation.action, getattr(animation, "action_slot", None))
    return next((one for one in curves if one.data_path == f'["{CURVE}"]'), None)


def drawn_timing(scene: Thing) -> Timing:
    """Read the timing from its curve, as a person may have drawn it.

    Raises
    ------
    OptionError
        There is no curve, or one key.
    """
    curve = curve_of(scene)
    keys = None if curve is None else keys_of(curve)
    if keys is None or len(keys) < 2:
        raise OptionError("there is no curve to take: press Preview first, or Retime", option="curve")
    segments, _ = segments_of(keys, evaluate=evaluation(curve))
    # Straight lines between its keys are taken as they are; bends are followed eight times a frame.
    times = keys.times
    if not (segments.kinds == 1).all():
        fine = np.arange(times[0], times[-1], 0.125)
        times = np.unique(np.concatenate([times, fine]))
    return Timing(Warp(times, np.append(segments(times[:-1])[:, 0], segments.end_value[0])), rate_of(scene))


def use_drawn(data: Thing, scene: Thing, objects: Sequence[Thing], settings: Thing) -> list[str]:
    """Give objects the timing of the curve; return what is to be said."""
    objects = what_moves(objects)
    timing = drawn_timing(scene)
    if settings.tolerance > 0:
        timing = timing.simplified(settings.tolerance)
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always", RetimeWarning)
        report = retime(data, objects, scene, timing, wanted_of(settings))
    before, after = timing.input_end - float(timing.warp.input_times[0]) + 1, timing.end - timing.start + 1
    return [f"{before:g} → {after:g} frames, by the curve", *report.lines(), *(str(one.message) for one in heard)]
