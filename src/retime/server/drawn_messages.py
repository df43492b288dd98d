"""What the page draws, as messages: clips, curves, reasons."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from retime.errors import OptionError
from retime.evaluate.metrics.flights import flight_spans
from retime.motion.any_motion import AnyMotion
from retime.motion.body import body_joints, body_of
from retime.motion.cameras import camera_path
from retime.motion.contacts import contacts
from retime.motion.joint_names import match_joints
from retime.motion.kinematics import global_poses, metres_per_unit
from retime.motion.motion import Motion
from retime.motion.signal import Signal
from retime.motion.skin import Skin
from retime.project.reader import Sources
from retime.project.solve import Solution, ghosts
from retime.search.poses.references import Reference
from retime.server.messages import BINDINGS, Clip, Curve, Kept, Why
from retime.warp.curve import Warp, output_frame_times


def clip_messages(sources: Sources, before: Sources | None = None) -> list[Clip]:
    """Draw the clips and references of a document; where others were drawn before, only what differs."""
    first = sources.clips[0]
    # Each message says how many clips there are, so a change of that number sends all of them again.
    clips = before.clips if before is not None and len(before.clips) == len(sources.clips) else ()
    unit = unit_of_signals(sources.clips)
    skins = sources.skins or (None,) * len(sources.clips)
    found = [
        _clip("clip", i, len(sources.clips), clip, _stretch_of(sources, i), (), unit, skins[i])
        for i, clip in enumerate(sources.clips)
        if not clips or clip is not clips[i]
    ]
    same = before is not None and before.clips[0] is first and len(before.references) == len(sources.references)
    for i, (whole, reference) in enumerate(zip(sources.wholes, sources.references, strict=True)):
        if before is not None and same and reference is before.references[i]:
            continue
        clip = reference.clips[0]
        counterparts = counterparts_of(first, clip, reference)
        stretch = clip.first_frame - whole.first_frame, whole.n_frames
        found.append(_clip("reference", i, len(sources.references), clip, stretch, counterparts, unit))
    return found


def unit_of_signals(clips: Sequence[AnyMotion]) -> float:
    """Return the metres of a unit of a group's signals that say none: they are taken to have the figure's."""
    figures = [clip for clip in clips if isinstance(clip, Motion) and camera_path(clip) is None]
    return metres_per_unit(figures[0]) if figures else 1.0


def _stretch_of(sources: Sources, clip: int) -> tuple[int, int]:
    """Say how many frames of a clip's file come before those used, and how many there are."""
    return sources.stretches[clip] if sources.stretches else (0, sources.clips[clip].n_frames)


def counterparts_of(clip: AnyMotion, other: AnyMotion, reference: Reference) -> tuple[str, ...]:
    """For each joint or channel of a clip say which one of a reference's clip stands for it; "" where none does."""
    if isinstance(clip, Signal) and isinstance(other, Signal):
        wanted = [reference.joint_map.get(name, name) for name in clip.names]
        return tuple(name if name in other.names else "" for name in wanted)
    if isinstance(clip, Signal) or isinstance(other, Signal):
        return ()
    # As the search matches them: nodes above the body are none of its joints.
    own, names = body_of(clip).skeleton.names, body_of(other).skeleton.names
    try:
        # A joint map may name joints of the group's other clips; only this clip's count here.
        match = match_joints(own, names, {name: to for name, to in reference.joint_map.items() if name in own})
    except OptionError:
        # A wrong map is reported by the search, in better words.
        return ("",) * len(own)
    found = {joint: names[to] for joint, to in match.pairs}
    return tuple(found.get(joint, "") for joint in range(len(own)))


def _clip(
    what: str,
    index: int,
    count: int,
    clip: AnyMotion,
    stretch: tuple[int, int],
    counterparts: tuple[str, ...],
    unit: float,
    skin: Skin | None = None,
) -> Clip:
    # Of a figure its body is shown: nodes above it, and what else hangs on those, are no part of it.
    shown = body_of(clip) if isinstance(clip, Motion) else clip
    names, parents = clip_nodes(shown)
    positions, values = np.zeros((0, 0, 3)), np.zeros((0, 0))
    feet: tuple[str, ...] = ()
    stands: list[tuple[float, float, float]] = []
    if isinstance(shown, Motion):
        poses = global_poses(shown)
        positions = np.concatenate([poses.positions, poses.end_positions], axis=1)
        positions *= metres_per_unit(shown)
        feet, stands = _contacts(shown)
    else:
        values = shown.values
    camera = camera_path(clip, unit=unit) if what == "clip" else None
    return Clip(
        what="reference" if what == "reference" else "clip",
        index=index,
        count=count,
        name=clip.name,
        holds="motion" if isinstance(clip, Motion) else "signal",
        rate=float(clip.rate),
        n_frames=clip.n_frames,
        n_nodes=len(parents),
        first_frame=clip.first_frame,
        start_time=stretch[0] / float(clip.rate),
        n_whole=stretch[1],
        names=names,
        parents=parents,
        positions=positions.astype(np.float32),
        values=values,
        kinds=tuple(str(kind) for kind in clip.kinds) if isinstance(clip, Signal) else (),
        flights=np.array(flight_spans(clip), dtype=np.float64).reshape(-1, 2),
        feet=feet,
        contacts=np.array(stands, dtype=np.float64).reshape(-1, 3),
        counterparts=counterparts,
        camera=np.zeros((0, 8), np.float32) if camera is None else camera.astype(np.float32),
        **_skin(clip, skin),
    )


def _skin(clip: AnyMotion, skin: Skin | None) -> dict[str, Any]:
    """Return what draws a clip's own mesh, in metres; empty arrays where there is none."""
    shown = body_of(clip) if isinstance(clip, Motion) else None
    held = skin.kept(body_joints(clip)) if skin is not None and isinstance(clip, Motion) else None
    if shown is None or held is None:
        return {
            "skin_points": np.zeros((0, 3), dtype=np.float32),
            "skin_triangles": np.zeros((0, 3), dtype=np.int32),
            "skin_bones": np.zeros((0, 3, 4), dtype=np.float32),
            "skin_joints": np.zeros(0, dtype=np.int32),
            "skin_follows": np.zeros((0, 4), dtype=np.int32),
            "skin_weights": np.zeros((0, 4), dtype=np.float32),
            "turns": np.zeros((0, 0, 4), dtype=np.float32),
        }
    return {
        "skin_points": held.points.astype(np.float32),
        "skin_triangles": held.triangles,
        "skin_bones": (held.bones * metres_per_unit(shown)).astype(np.float32),
        "skin_joints": held.joints,
        "skin_follows": held.follows,
        "skin_weights": held.weights.astype(np.float32),
        "turns": global_poses(shown).rotations.astype(np.float32),
    }


def _contacts(clip: Motion) -> tuple[tuple[str, ...], list[tuple[float, float, float]]]:
    """Name the feet, and say when they stand: which, from when to when (seconds)."""
    found = contacts(clip)
    rate = float(clip.rate)
    names, joints = clip_nodes(clip)[0], len(clip.skeleton.names)
    feet = tuple(names[foot.joint if foot.end_site is None else joints + foot.end_site] for foot in found.feet)
    return feet, [(one.foot, one.first_frame / rate, one.last_frame / rate) for one in found.spans()]


def clip_nodes(clip: AnyMotion) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Return names and parents of a motion's nodes, joints first and then end sites; of a signal its channels."""
    if isinstance(clip, Signal):
        return clip.names, ()
    skeleton = clip.skeleton
    ends = [site.parent for site in skeleton.end_sites]
    names = (*skeleton.names, *(f"end of {skeleton.names[parent]}" for parent in ends))
    return names, (*skeleton.parents, *ends)


def curve_message(revision: int, solution: Solution, solve_ms: float) -> Curve:
    """Draw a solution."""
    warp, search = solution.warp, solution.search
    rate = float(solution.sources.clips[0].rate)
    linear, (begins, ends) = ghosts(solution)
    reading = None if search is None else search.example
    hand = solution.hand
    return Curve(
        revision=revision,
        rate=rate,
        n_output=len(output_frame_times(warp, rate)),
        method=solution.document.method,
        analysis_rate=rate if search is None else search.rate,
        max_skip=0 if search is None else search.max_skip,
        upsample=0 if search is None else search.upsample,
        evenness=0.0 if search is None else search.plan.request.evenness,
        keep_flights=0.0 if search is None else search.plan.request.keep_flights,
        total=None if search is None else search.total,
        lower_bound=None if search is None else search.path.lower_bound,
        optimal=search is not None and search.path.optimal,
        solve_ms=solve_ms,
        key_output_times=np.array([key.output_time for key in warp.keytimes]),
        key_input_times=np.array([key.input_time for key in warp.keytimes]),
        output_times=warp.output_times,
        input_times=warp.input_times,
        linear_output_times=linear.output_times,
        linear_input_times=linear.input_times,
        spline_begins=begins,
        spline_ends=ends,
        given_up=() if search is None else search.given_up,
        spoken_share=None if reading is None else reading.share,
        unspoken=np.array(() if reading is None else reading.unspoken, dtype=np.float64).reshape(-1, 2),
        example_warnings=() if reading is None else reading.warnings,
        hand_output_times=np.zeros(0) if hand is None else hand.output_times,
        hand_input_times=np.zeros(0) if hand is None else hand.input_times,
    )


def kept_message(name: str, warp: Warp) -> Kept:
    """Draw a warp kept for comparison."""
    return Kept(name, warp.output_times, warp.input_times)


def why_message(revision: int, solution: Solution) -> Why | None:
    """Explain a solution; nothing, where there was no search."""
    if solution.search is None:
        return None
    reasons = solution.search.explain()
    document, matched_times = solution.document, reasons.reference_times
    # Each reference is followed by its mirror image, where that was asked for.
    sources, mirrored = [], []
    if solution.hand is not None:
        # The example is a stretch of the clip itself.
        matched_times = matched_times + solution.hand.input_times[0]
    elif document.method == "align":
        # It is followed as it is, or in the mirror, whichever was nearer; and from its beginning again.
        (reference,) = solution.sources.references
        sources, mirrored = [0], [reasons.reference_names[0] != reference.label]
        if document.repeat > 1:
            matched_times = np.fmod(matched_times, reference.clips[0].end_time)
    else:
        for i, file in enumerate(document.references):
            sources += [i] * (1 + file.mirror)
            mirrored += [False] + [True] * file.mirror
    n_output, n_neighbors = reasons.references.shape
    return Why(
        revision=revision,
        n_output=n_output,
        n_neighbors=n_neighbors,
        references=reasons.reference_names,
        mirrored=tuple(mirrored or [False]),
        sources=tuple(sources or [-1]),
        output_times=reasons.output_times,
        input_times=reasons.input_times,
        speeds=reasons.speeds,
        scores=reasons.scores,
        matched=reasons.references.astype(np.int32),
        matched_times=matched_times,
        binding=np.array(
            [sum(1 << BINDINGS.index(word) for word in words.split("+") if word) for words in reasons.binding],
            dtype=np.uint8,
        ),
    )
