"""OpenTimelineIO: a track of pieces of the clip, each of one speed.

Its time effects are LinearTimeWarp, with one ``time_scalar``, and FreezeFrame; a curve has no form of its own. So the
warp is cut at whole output frames where its speed changes: each piece is a clip, whose ``source_range`` begins at the
input time that its first frame shows and is as long as the piece is in the timeline, with the piece's speed as an
effect; below 0 it runs backward. The last piece lasts a frame longer than the warp, as the last frame is shown too.
Times are frames at the rate, input ones from `Shot.start`, where the media's ``available_range`` begins.

Source: OpenTimelineIO 0.18, schema LinearTimeWarp.1, FreezeFrame.1, Clip.2
(https://opentimelineio.readthedocs.io/en/latest/api/python/opentimelineio.schema.html).
"""

from __future__ import annotations

import json
import warnings
from typing import Any

import numpy as np

from retime.errors import FormatError, RetimeWarning
from retime.hosts.choosing import chosen
from retime.hosts.shot import MOST_KEYS, Shot, warp_of
from retime.hosts.source_file import name_of
from retime.hosts.text import json_number
from retime.strict_json import parse_json
from retime.warp.curve import Warp

# Frames: pieces that meet so closely are one movement.
_SAME, _NEAR = 1e-3, 0.5


def write(warp: Warp, shot: Shot) -> str:
    """Write a timeline with one track."""
    rate = float(shot.exact_rate)
    at = np.rint(warp.output_times * rate)
    use = warp.input_times * rate
    source = shot.item or "clip.mov"
    name = name_of(source)
    last = float(np.ceil(use.max() - 1e-6))
    media = {
        "OTIO_SCHEMA": "ExternalReference.1",
        "metadata": {},
        "name": name,
        "available_range": _range(shot.start, last + 1, rate),
        "target_url": source,
    }
    clips = []
    for piece in range(len(at) - 1):
        speed = (use[piece + 1] - use[piece]) / (at[piece + 1] - at[piece])
        length = at[piece + 1] - at[piece] + (piece == len(at) - 2)
        clips.append(
            {
                "OTIO_SCHEMA": "Clip.2",
                "metadata": {},
                "name": name,
                "source_range": _range(shot.start + float(use[piece]), float(length), rate),
                "effects": [_effect(float(speed))],
                "markers": [],
                "enabled": True,
                "media_references": {"DEFAULT_MEDIA": media},
                "active_media_reference_key": "DEFAULT_MEDIA",
            }
        )
    if at[0] > 0:
        clips.insert(0, {**_holder("Gap.1", ""), "source_range": _range(0.0, float(at[0]), rate)})
    track = {**_holder("Track.1", name), "children": clips, "kind": "Video"}
    stack = {**_holder("Stack.1", "tracks"), "children": [track]}
    timeline = {
        "OTIO_SCHEMA": "Timeline.1",
        "metadata": {},
        "name": f"retimed {name}",
        "global_start_time": _time(shot.start, rate),
        "tracks": stack,
    }
    return json.dumps(timeline, indent=1, allow_nan=False) + "\n"


def _holder(schema: str, name: str) -> dict[str, Any]:
    fields: dict[str, Any] = {
        "metadata": {},
        "name": name,
        "source_range": None,
        "effects": [],
        "markers": [],
        "enabled": True,
    }
    return {"OTIO_SCHEMA": schema, **fields}


def _time(value: float, rate: float) -> dict[str, Any]:
    return {"OTIO_SCHEMA": "RationalTime.1", "rate": rate, "value": value}


def _range(start: float, duration: float, rate: float) -> dict[str, Any]:
    return {"OTIO_SCHEMA": "TimeRange.1", "start_time": _time(start, rate), "duration": _time(duration, rate)}


def _effect(speed: float) -> dict[str, Any]:
    schema, name = ("FreezeFrame.1", "FreezeFrame") if speed == 0 else ("LinearTimeWarp.1", "LinearTimeWarp")
    return {
        "OTIO_SCHEMA": schema,
        "metadata": {},
        "name": "retime",
        "effect_name": name,
        "enabled": True,
        "time_scalar": speed,
    }


def read(data: bytes, shot: Shot) -> Warp:
    """Read the one video track of a timeline, or that of the name `Shot.item`."""
    document = parse_json(data, what="a timeline")
    # Each with the stacks that it lies in, the outermost first.
    tracks: dict[str, tuple[dict[str, Any], ...]] = {}
    waiting: list[tuple[Any, tuple[dict[str, Any], ...]]] = [(document, ())]
    while waiting:
        node, around = waiting.pop()
        if isinstance(node, dict):
            if _schema(node) == "Track" and node.get("kind", "Video") == "Video" and node.get("children"):
                name = str(node.get("name") or f"track {len(tracks) + 1}")
                tracks[name if name not in tracks else f"{name} ({len(tracks) + 1})"] = (*around, node)
                continue
            inside = (*around, node) if _schema(node) == "Stack" else around
            waiting += [(value, inside) for value in reversed(node.values()) if isinstance(value, dict | list)]
        elif isinstance(node, list):
            waiting += [(value, around) for value in reversed(node)]
    track = chosen(tracks, shot.item, "video track with clips", "an OpenTimelineIO timeline")
    warp, duration = _track(track[-1]["children"], shot)
    for node in track:
        _check_plain(node, duration)
    return warp


def _check_plain(node: dict[str, Any], duration: float) -> None:
    """Refuse what a track, or a stack around it, does to the time of all its clips, which lasts `duration` seconds."""
    what = f"the {_schema(node).lower()} {str(node.get('name') or '')[:40]!r}"
    if node.get("enabled", True) is False:
        raise FormatError(f"{what} is switched off, so it shows no input; switch it on")
    if _speed(node.get("effects") or [], what) != 1.0:
        raise FormatError(f"{what} has a time effect, and a warp is read from those of clips: put it on the clips")
    if node.get("source_range") is not None:
        start, length, frame = _span(node["source_range"], what)
        if abs(start) > _SAME * frame or length < duration - _SAME * frame:
            raise FormatError(f"{what} shows a part of its clips alone (source_range): trim the clips themselves")


def _schema(node: Any) -> str:
    return str(node.get("OTIO_SCHEMA", "")).split(".")[0] if isinstance(node, dict) else ""


def _track(children: Any, shot: Shot) -> tuple[Warp, float]:
    """Make a warp of a track's pieces; return it, and how long they last, seconds."""
    if not isinstance(children, list) or len(children) > MOST_KEYS:
        raise FormatError(f"a track has a list of at most {MOST_KEYS} pieces")
    at: list[float] = []
    use: list[float] = []
    media: str | None = None
    end, gap = 0.0, 0.0
    last: tuple[float, float, float] | None = None
    for number, clip in enumerate(children, start=1):
        what = f"piece {number} of the track"
        kind = _schema(clip)
        if kind == "Gap" and not at:
            end += _span(clip.get("source_range"), what)[1]
            continue
        if kind != "Clip":
            raise FormatError(
                f"{what} is a {kind[:40] or 'thing without a schema'}, which shows no input; a warp needs clips alone"
            )
        if clip.get("enabled", True) is False:
            raise FormatError(f"{what} is switched off, so it shows no input; switch it on, or take it out")
        start, length, frame = _span(clip.get("source_range"), what)
        url, zero = _media(clip, what)
        if media is not None and url != media:
            raise FormatError(f"{what} shows other media, {url!r:.60}, than those before it; a warp is of one clip")
        media = url
        start -= shot.start * frame if zero is None else zero
        speed = _speed(clip.get("effects") or [], what)
        if last is not None:
            off = abs(start - (use[-1] + last[0] * last[1])) / frame
            if off > _NEAR:
                raise FormatError(
                    f"{what} begins {off:.3g} frames from where the one before it ends: a warp can't jump"
                )
            gap = max(gap, off)
        at.append(end)
        use.append(start)
        end, last = end + length, (length, speed, frame)
    if gap > _SAME:
        warnings.warn(
            f"pieces of the track meet up to {gap:.2g} frames apart: the warp has its knots where each begins",
            RetimeWarning,
            stacklevel=2,
        )
    if last is None:
        raise FormatError("the track has no clip")
    length, speed, frame = last
    # The last frame is shown from here to the end of the track.
    if length > frame * (1 + 1e-9):
        at.append(end - frame)
        use.append(use[-1] + speed * (length - frame))
    return warp_of(at, use), end


def _span(found: Any, what: str) -> tuple[float, float, float]:
    """Return start, duration and the length of a frame, seconds."""
    if not isinstance(found, dict):
        raise FormatError(f"{what} has no source_range, so it is not known what of its media it shows")
    start, _ = _seconds(found.get("start_time"), what)
    duration, rate = _seconds(found.get("duration"), what)
    if not duration > 0:
        raise FormatError(f"{what} lasts {duration:g} s")
    return start, duration, 1 / rate


def _seconds(found: Any, what: str) -> tuple[float, float]:
    """Return a time in seconds, and its rate."""
    if not isinstance(found, dict):
        raise FormatError(f"{what}: expected a RationalTime, found {type(found).__name__}")
    value, rate = (json_number(found.get(key), f"{what}, {key}") for key in ("value", "rate"))
    if not 1e-6 <= rate <= 1e6:
        raise FormatError(f"{what}: no time counts {rate:g} a second")
    return value / rate, rate


def _media(clip: dict[str, Any], what: str) -> tuple[str, float | None]:
    """Return which media a clip shows, and the time of their first frame where it is said."""
    found = clip.get("media_reference")
    references = clip.get("media_references")
    if isinstance(references, dict):
        found = references.get(str(clip.get("active_media_reference_key", "DEFAULT_MEDIA")))
    if not isinstance(found, dict):
        return "", None
    available = found.get("available_range")
    zero = None
    if isinstance(available, dict):
        zero = None if _schema(found) == "MissingReference" else _seconds(available.get("start_time"), what)[0]
    return str(found.get("target_url", "")), zero


def _speed(effects: Any, what: str) -> float:
    """Return the one speed of a clip."""
    speed = 1.0
    for effect in effects if isinstance(effects, list) else []:
        kind = _schema(effect)
        if kind and effect.get("enabled", True) is False:
            continue
        if kind == "FreezeFrame":
            speed = 0.0
        elif kind == "LinearTimeWarp":
            speed *= json_number(effect.get("time_scalar"), f"{what}, time_scalar")
        elif kind == "TimeEffect":
            raise FormatError(
                f"{what} has a time effect that is no LinearTimeWarp or FreezeFrame: its curve is not in the file"
            )
    return speed
