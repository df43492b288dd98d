"""New keys for the animations of an FBX scene; every other byte stays as it was."""

from __future__ import annotations

import warnings
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from retime.errors import FormatWarning
from retime.formats.curves.fbx.curve import CurveRecords, Keys, refuse_keys
from retime.formats.curves.fbx.file import Record, Value
from retime.formats.curves.fbx.keys import new_keys
from retime.formats.curves.fbx.scene import FbxScene, Stack
from retime.formats.curves.fbx.span import Beyond, StackCurves, extended
from retime.formats.curves.fbx.values import quaternion_doubt
from retime.warp.curve import Warp
from retime.warp.cutting import cut_curves

_Changes = dict[tuple[Record, int], Value]
# What has a timing of its own, beside the curves.
_OTHER_CLOCKS = {"Audio": "sound", "AudioLayer": "sound", "Cache": "caches of moving points"}


def cut_keys(scene: FbxScene, curves: StackCurves, warp: Warp) -> tuple[Keys, list[Beyond]]:
    """Cut all curves of a stack by a warp whose time 0 is the stack's start.

    Returns the new keys, and which curves did something beyond their keys, and where, that is keys now.
    """
    moved = Warp(warp.output_times + curves.start, warp.input_times + curves.start)
    old, written = extended(scene, curves, float(moved.input_times.min()), float(moved.input_times.max()))
    cut, source = cut_curves(old.batch, moved)
    # The one key of a curve goes where its time is shown.
    alone = np.flatnonzero((cut.counts == 0) & (curves.keys.counts == 1))
    times, which = np.unique(old.batch.end_times[alone], return_inverse=True)
    shown = [moved_time(time, curves, warp, last=False) for time in times.tolist()]
    cut.end_times[alone] = np.array(shown)[which] if len(shown) else 0.0
    return new_keys(old, cut, source, scene.ticks), written


def retimed(scene: FbxScene, done: list[tuple[StackCurves, Warp, Keys, list[Beyond]]]) -> bytes:
    """Write a scene with new keys for some of its stacks.

    Parameters
    ----------
    scene : FbxScene
        The scene.
    done : list of (StackCurves, Warp, Keys, list of Beyond)
        Each stack, its warp (time 0 is the stack's start), its new keys, and which curves hold beyond them now, where.
    """
    _refuse_shared(scene, [curves.stack for curves, *_ in done])
    changes: _Changes = {}
    for curves, warp, keys, written in done:
        _curve_changes(scene, curves, keys, changes)
        for index, side in written:
            _hold(scene, curves.records[index], side, changes)
        _stack_changes(scene, curves, warp, changes)
    repeated = sum(len({index for index, _ in written}) for *_, written in done)
    if repeated:
        warnings.warn(
            f"{scene.file.path}: {repeated} curves go on beyond their keys (repeated, mirrored or straight on); what "
            "the animation shows of that is written as keys, and beyond its end they hold",
            FormatWarning,
            stacklevel=2,
        )
    others = sorted({_OTHER_CLOCKS[item.kind] for item in scene.items.values() if item.kind in _OTHER_CLOCKS})
    if others:
        warnings.warn(
            f"{scene.file.path}: the scene's {' and '.join(others)} keep their timing", FormatWarning, stacklevel=2
        )
    doubt = quaternion_doubt(scene, [curves for curves, *_ in done])
    if doubt:
        warnings.warn(f"{scene.file.path}: {doubt}; they are cut as angles", FormatWarning, stacklevel=2)
    _settings_changes(scene, done, changes)
    return scene.file.rewritten(changes)


def _refuse_shared(scene: FbxScene, stacks: list[Stack]) -> None:
    """Raise FormatError where a curve of these stacks is also of another one."""
    owner: dict[int, Stack] = {}
    chosen = {id(stack) for stack in stacks}
    for stack in scene.stacks:
        for curve in stack.curves:
            other = owner.setdefault(curve.id, stack)
            if other is not stack and (id(stack) in chosen or id(other) in chosen):
                raise scene.file.error(
                    f"the animations {other.name!r} and {stack.name!r} share a curve, and each would give it a timing",
                    curve.record,
                )


def _curve_changes(scene: FbxScene, curves: StackCurves, keys: Keys, changes: _Changes) -> None:
    """Note the new arrays of all curves that change."""
    # Cut where a steep curve overshoots, a key may be further off than any that is read.
    refuse_keys(scene.file, curves.records, keys, scene.ticks)
    old = curves.keys
    runs, run_owner = _runs(keys)
    run_starts = np.searchsorted(run_owner, np.arange(len(keys.counts) + 1))
    lengths = np.diff(np.append(runs, len(keys.ticks)))
    starts, old_starts = keys.starts.tolist(), old.starts.tolist()
    values = keys.values.astype(np.float32)
    bits = keys.flags.astype(np.uint32).view(np.int32)
    for index, record in enumerate(curves.records):
        new = slice(starts[index], starts[index + 1])
        was = slice(old_starts[index], old_starts[index + 1])
        as_values = values if record.letters[1] == "f" else keys.values
        if (
            np.array_equal(keys.ticks[new], old.ticks[was])
            and np.array_equal(as_values[new], old.values[was])
            and np.array_equal(keys.flags[new], old.flags[was])
            and np.array_equal(keys.data[new], old.data[was])
        ):
            continue
        run = slice(run_starts[index], run_starts[index + 1])
        data = keys.data[runs[run]].ravel()
        arrays: tuple[NDArray[np.generic], ...] = (
            keys.ticks[new],
            as_values[new],
            bits[runs[run]],
            data.view(np.float32) if record.letters[3] == "f" else data.view(np.int32),
            lengths[run],
        )
        for part, letter, numbers in zip(record.parts, record.letters, arrays, strict=True):
            changes[part, 0] = Value(letter, numbers)


def _runs(keys: Keys) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Find where runs of keys with the same flags and attributes begin, and the curve of each run."""
    new = np.ones(len(keys.ticks), dtype=bool)
    new[1:] = (keys.flags[1:] != keys.flags[:-1]) | (keys.data[1:] != keys.data[:-1]).any(axis=1)
    new[keys.starts[:-1]] = True
    runs = np.flatnonzero(new)
    return runs, np.searchsorted(keys.starts, runs, side="right") - 1


def _hold(scene: FbxScene, record: CurveRecords, side: str, changes: _Changes) -> None:
    """Let a curve hold beyond its keys, on one side."""
    holder = record.item.record.child(side)
    kind = holder.child("Type") if holder is not None else None
    values = scene.file.values(kind) if kind is not None else []
    if kind is not None and values:
        letter, content = values[0]
        changes[kind, 0] = Value(letter, ord("C") if isinstance(content, int) else "C")


def moved_time(time: float, curves: StackCurves, warp: Warp, *, last: bool) -> float:
    """Find where a time of a stack is shown: the first output time that shows it, or the last, seconds.

    The stack's start and end are the output's, whichever way it runs; what lies before or behind them keeps its
    distance. What the warp leaves out moves to its start or its end.
    """
    at = time - curves.start
    low, high = warp.output_times[0], warp.output_times[-1]
    if at <= 1e-9:
        return float(curves.start + low + at)
    if time >= curves.end - 1e-9:
        return float(curves.start + high + time - curves.end)
    begin, end = warp.input_times[:-1], warp.input_times[1:]
    slack = 1e-9 * max(1.0, abs(at))
    shows = np.flatnonzero((np.minimum(begin, end) - slack <= at) & (at <= np.maximum(begin, end) + slack))
    if not len(shows):
        return float(curves.start + (high if last else low))
    piece = shows[-1 if last else 0]
    width = end[piece] - begin[piece]
    share = (at - begin[piece]) / width if width else float(last)
    span = warp.output_times[piece + 1] - warp.output_times[piece]
    return float(curves.start + warp.output_times[piece] + span * min(max(share, 0.0), 1.0))


def _moved_ticks(scene: FbxScene, ticks: int, curves: StackCurves, warp: Warp, *, last: bool) -> int:
    time = scene.seconds(ticks)
    if time is None:
        # Endless before is endless after.
        return ticks
    return round(moved_time(time, curves, warp, last=last) * scene.ticks)


def _stack_changes(scene: FbxScene, curves: StackCurves, warp: Warp, changes: _Changes) -> None:
    """Let a stack's own times, and those of its take, follow."""
    for name, (record, values) in scene.properties(curves.stack.item).items():
        if name in ("LocalStart", "LocalStop", "ReferenceStart", "ReferenceStop") and len(values) > 4:
            ticks = scene.file.whole(record, values[4])
            moved = _moved_ticks(scene, ticks, curves, warp, last=name.endswith("Stop"))
            changes[record, 4] = Value(values[4].letter, moved)
    takes = scene.file.section("Takes")
    for take in takes.children if takes else []:
        said = scene.file.values(take)
        if take.name != "Take" or not said or said[0].content != curves.stack.name:
            continue
        for name in ("LocalTime", "ReferenceTime"):
            span = take.child(name)
            if span is None:
                continue
            for place, value in enumerate(scene.file.values(span)[:2]):
                moved = _moved_ticks(scene, scene.file.whole(span, value), curves, warp, last=place == 1)
                changes[span, place] = Value(value.letter, moved)


def _settings_changes(
    scene: FbxScene, done: list[tuple[StackCurves, Warp, Keys, list[Beyond]]], changes: _Changes
) -> None:
    """Let the scene's span of time follow: that of the stack which is shown, or else of the first."""
    takes = scene.file.section("Takes")
    shown = takes.child("Current") if takes else None
    values = scene.file.values(shown) if shown is not None else []
    current = str(values[0].content) if values else ""
    names = [stack.name for stack in scene.stacks]
    if current not in names:
        current = names[0]
    for curves, warp, *_ in done:
        if curves.stack.name == current:
            for name in ("TimeSpanStart", "TimeSpanStop"):
                found: tuple[Record, list[Value]] | None = scene.settings.get(name)
                if found is not None and len(found[1]) > 4:
                    record, parts = found
                    ticks = scene.file.whole(record, parts[4])
                    moved = _moved_ticks(scene, ticks, curves, warp, last=name.endswith("Stop"))
                    changes[record, 4] = Value(parts[4].letter, moved)
            return


def warps_of(stacks: list[Stack], warps: Warp | Mapping[str, Warp]) -> list[tuple[Stack, Warp]]:
    """Pair stacks with their warps; those that have none are left out."""
    if isinstance(warps, Warp):
        return [(stack, warps) for stack in stacks]
    return [(stack, warps[stack.name]) for stack in stacks if stack.name in warps]
