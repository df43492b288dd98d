"""`retime info`: what a clip holds, and how retime is built."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from retime.cli.clip_options import PATH, ClipOptions, clip_options
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.terminal import say_json, say_table

if TYPE_CHECKING:
    from retime.motion.any_motion import AnyMotion

# The extras of pyproject.toml, and a package that each brings.
EXTRAS = {
    "plot": "matplotlib",
    "edit": "starlette",
    "notebook": "anywidget",
    "pandas": "pandas",
    "parquet": "pyarrow",
    "usd": "usd-core",
    "video": "av",
    "beats": "librosa",
    "batch": "distributed",
}
_PACKAGES = ("numpy", "click")
_NAMES_SHOWN = 4


_EXAMPLES = "\b\nExamples\n  retime info walk.bvh\n  retime info take.mp4 --json\n  retime info --build\n"


@click.command(
    "info",
    cls=SectionedCommand,
    short_help="Say what a clip holds, or how retime is built (--build).",
    epilog=_EXAMPLES,
)
@click.argument("clip", type=PATH, required=False)
@clip_options
@click.option("--json", "as_json", cls=Option, is_flag=True, help="Print one JSON object.")
@click.option("--build", cls=Option, is_flag=True, help="Say how retime itself is built: backend, versions, extras.")
def command(*, clip: Path | None, clip_options: ClipOptions, as_json: bool, build: bool) -> None:
    """Say what CLIP holds: joints, frames, rate, channels, units, flights, and what its names tell.

    Of video, pictures and sound: streams, sizes, rates, lengths, colours and chapters.
    """
    if build == (clip is not None):
        raise click.UsageError("give a CLIP, or --build" if clip is None else "give a CLIP or --build, not both")
    if clip is None:
        document = _describe_build()
        rows = _build_rows(document)
    else:
        from retime.media.kinds import is_media

        if is_media(clip):
            document = _describe_media(clip, clip_options)
            rows = _media_rows(document)
        else:
            motion = clip_options.read(clip)
            _warn_of_a_slow_clock(motion)
            document = _describe_clip(clip, motion, clip_options.array) | {"facts": _facts(clip, clip_options)}
            rows = _clip_rows(document)
    if as_json:
        say_json(document)
    else:
        say_table(rows)


def _warn_of_a_slow_clock(motion: AnyMotion) -> None:
    """Warn as a search does of a clip that has hardly a frame a second."""
    from retime.errors import RetimeWarning
    from retime.search.inputs import slow_clock

    if problem := slow_clock(motion):
        warnings.warn(problem, RetimeWarning, stacklevel=2)


def _facts(clip: Path, clip_options: ClipOptions) -> dict[str, str]:
    """Ask the format what the file holds beside what was read; it has warned already."""
    from retime.errors import RetimeWarning
    from retime.formats.registry import facts_of

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RetimeWarning)
        return facts_of(clip, clip_options.read_options())


def _describe_build() -> dict[str, Any]:
    import importlib.metadata
    import platform

    from retime.errors import RetimeWarning
    from retime.kernels import backend, build_record, compiled_available, why_not_compiled
    from retime.server import PAGE, no_page

    has_page = (PAGE / "index.html").is_file()
    with warnings.catch_warnings():
        # What reading would warn of is printed as part of the answer.
        warnings.simplefilter("ignore", RetimeWarning)
        used = getattr(backend(), "__name__", "").rpartition(".")[2].removesuffix("_backend")
    return {
        "retime": importlib.metadata.version("retime"),
        "backend": used,
        "compiled_available": compiled_available(),
        "compiled_build": build_record(),
        "why_not_compiled": why_not_compiled(),
        "python": platform.python_version(),
        "platform": platform.platform(terse=True),
        "packages": {package: importlib.metadata.version(package) for package in _PACKAGES},
        "extras": {extra: _version(package) for extra, package in EXTRAS.items()},
        "page": has_page,
        "page_missing": None if has_page else no_page(),
    }


def build_facts() -> list[tuple[str, str]]:
    """Say in rows of a label and its text how retime is built, and which of its extras are here."""
    build = _describe_build()
    build["extras"] = {extra: version for extra, version in build["extras"].items() if version}
    return _build_rows(build)


def _version(package: str) -> str | None:
    import importlib.metadata

    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def _build_rows(build: dict[str, Any]) -> list[tuple[str, str]]:
    kernels = build["why_not_compiled"]
    if kernels is None:
        chosen = "loaded" if build["backend"] == "compiled" else "there, but switched off by RETIME_BACKEND"
        kernels = f"compiled, {chosen}"
    else:
        kernels = f"none compiled: {kernels}"
    return [
        ("retime", build["retime"]),
        ("backend", build["backend"]),
        ("kernels", kernels),
        ("python", f"{build['python']} on {build['platform']}"),
        *build["packages"].items(),
        *(
            (f"[{extra}]", f"{EXTRAS[extra]} {version}" if version else f"not installed: pip install 'retime[{extra}]'")
            for extra, version in build["extras"].items()
        ),
        ("page", build["page_missing"] or "built in"),
    ]


def _describe_clip(path: Path, clip: AnyMotion, arrays: tuple[str, ...]) -> dict[str, Any]:
    from retime.formats.registry import format_in
    from retime.motion.body import body_joint
    from retime.motion.contacts import contacts, named_feet
    from retime.motion.first_frames import frames_before_capture
    from retime.motion.flights import flights
    from retime.motion.gaps import gaps_text
    from retime.motion.joint_names import body_parts, mirror_partners
    from retime.motion.kinematics import seems_z_up
    from retime.motion.motion import Motion

    document: dict[str, Any] = {
        "path": str(path),
        "format": format_in(path, arrays=arrays).name,
        "holds": "motion" if isinstance(clip, Motion) else "signal",
        "name": clip.name,
        "frames": clip.n_frames,
        "first_frame": clip.first_frame,
        "rate": float(clip.rate),
        "exact_rate": str(clip.rate),
        "seconds": clip.duration,
    }
    if not isinstance(clip, Motion):
        return {
            **document,
            "table": clip.dialect,
            "clock": {
                "column": clip.time_column,
                "form": clip.clock.form,
                "start": clip.start_time,
                "said": str(clip.clock),
            }
            if clip.time_column
            else None,
            "channels": len(clip.names),
            "channel_names": list(clip.names),
            "kinds": [str(kind) for kind in clip.kinds],
            "words": {name: list(kind.words) for name, kind in zip(clip.names, clip.kinds, strict=True) if kind.words},
            "weigh": [kind.weighs for kind in clip.kinds],
            "gaps": gaps_text(clip.holes, clip.names, clip.first_frame),
        }
    skeleton = clip.skeleton
    names, declared = skeleton.names, clip.declaration
    feet = contacts(clip).feet
    partners = mirror_partners(names, skeleton.parents)
    return {
        **document,
        "channels": None if declared is None else sum(len(channels) for channels in declared.channels),
        "joints": list(skeleton.names),
        "parents": list(skeleton.parents),
        "end_sites": len(skeleton.end_sites),
        "metres_per_unit": clip.metres_per_unit,
        "up": clip.up,
        "seems_z_up": seems_z_up(clip),
        "root": names[body_joint(clip)],
        "frames_before_capture": frames_before_capture(clip),
        "flights": [[first + clip.first_frame, last + clip.first_frame] for first, last in flights(clip)],
        # What the joints' names tell: feet, sides.
        "feet": [("end of " if foot.end_site is not None else "") + names[foot.joint] for foot in feet],
        "feet_found_by": ("name" if named_feet(names) else "motion") if feet else None,
        "mirror_pairs": [[names[i], names[j]] for i, j in enumerate(partners) if j is not None and i < j],
        "parts": [part and f"{part.side} {part.base}".strip() for part in body_parts(names)],
    }


def _describe_media(path: Path, clip_options: ClipOptions) -> dict[str, Any]:
    """Describe video, pictures or sound; its first video, or else its first sound, stands for the whole."""
    from retime.media.description import describe_media

    media = describe_media(path, fps=clip_options.fps)
    video = next((one for one in media["streams"] if one["type"] == "video"), None)
    sound = next((one for one in media["streams"] if one["type"] == "audio"), None)
    document = {"path": str(path), "format": media["container"], "name": path.stem}
    if video is not None:
        pictures = media["container"] == "numbered pictures"
        document |= {"holds": "pictures" if pictures else "video", "first_frame": 0}
        document |= {key: video[key] for key in ("frames", "rate", "exact_rate", "seconds")}
    elif sound is not None:
        document |= {"holds": "sound", "seconds": sound["seconds"]}
    else:
        document |= {"holds": "a picture", "seconds": 0.0}
    return document | {key: media[key] for key in ("n_streams", "streams", "chapters")}


def _media_rows(media: dict[str, Any]) -> list[tuple[str, str]]:
    rows = [("clip", f"{media['path']}, {media['holds']} ({media['format']})"), ("length", f"{media['seconds']:.3f} s")]
    for stream in media["streams"]:
        rows += _video_rows(stream) if stream["type"] == "video" else [(stream["type"], _stream_text(stream))]
    unlisted = media["n_streams"] - len(media["streams"])
    if unlisted:
        rows.append(("streams", f"{unlisted} more"))
    if media["chapters"]:
        named = [f"{one['start']:.2f}-{one['end']:.2f} s {one['title']}".rstrip() for one in media["chapters"]]
        rows.append(("chapters", f"{len(named)}: {_few(named)}"))
    return rows


def _video_rows(video: dict[str, Any]) -> list[tuple[str, str]]:
    """Say what a stream of frames is: a row for each side of it that a person may have to know."""
    look = f"{video['pixel_format']}, {video['bits']} bits" + (", with alpha" if video["alpha"] else "")
    shape = "" if video["pixel_aspect"] in ("1", "1/1") else f", pixels of {video['pixel_aspect'].replace('/', ':')}"
    rate = f"{video['rate']:.6g} Hz" + (f" ({video['exact_rate']})" if "/" in video["exact_rate"] else "")
    rows = [
        ("video", f"{video['codec']}, {video['width']}x{video['height']}, {look}{shape}{_named(video)}"),
        ("frames", f"{video['frames']}, numbered 0:{video['frames'] - 1}"),
        ("rate", f"variable, {rate} in the mean" if video["variable_rate"] else rate),
    ]
    if video["rotation"]:
        rows.append(("rotation", f"shown turned by {video['rotation']} degrees clockwise"))
    if video["interlaced"]:
        rows.append(("interlaced", "two fields a frame"))
    colours = [f"{name} {video[name]}" for name in ("range", "matrix", "primaries", "transfer") if video[name]]
    if colours:
        rows.append(("colour", ", ".join(colours) + (f" (HDR, {video['hdr']})" if video["hdr"] else "")))
    if video["light"]:
        rows.append(("light", ", ".join(video["light"])))
    return rows


def _stream_text(stream: dict[str, Any]) -> str:
    """Say what a stream of sound, a cover or a subtitle is."""
    said = [stream["codec"]]
    if "channels" in stream:
        channels = "1 channel" if stream["channels"] == 1 else f"{stream['channels']} channels"
        placed = "" if "channel" in stream["layout"] else f" ({stream['layout']})"
        said += [f"{stream['rate']} Hz", channels + placed, f"{stream['seconds']:.3f} s"]
    if "width" in stream:
        said.append(f"{stream['width']}x{stream['height']}")
    return ", ".join(said) + _named(stream)


def _named(stream: dict[str, Any]) -> str:
    # "und" is how MP4 says that nobody said a language.
    return "".join(f", {stream[key]}" for key in ("language", "title") if stream.get(key, "und") != "und")


def _clip_rows(clip: dict[str, Any]) -> list[tuple[str, str]]:
    last_frame = clip["first_frame"] + clip["frames"] - 1
    rows = [
        ("clip", f"{clip['path']}, a {clip['holds']} ({clip['format']})"),
        ("frames", f"{clip['frames']}, numbered {clip['first_frame']}:{last_frame}"),
        ("rate", f"{clip['rate']:.6g} Hz" + (f" ({clip['exact_rate']})" if "/" in clip["exact_rate"] else "")),
        ("length", f"{clip['seconds']:.3f} s"),
    ]
    if clip["holds"] == "signal":
        if clip["table"]:
            rows.insert(1, ("table", clip["table"]))
        if clip["clock"]:
            rows.append(("clock", f"{clip['clock']['column']}: {clip['clock']['said']}"))
        rows += clip["facts"].items()
        return [*rows, ("channels", f"{clip['channels']}: {', '.join(clip['channel_names'])}"), *_kind_rows(clip)]
    rows += clip["facts"].items()
    if clip["channels"] is not None:
        rows.append(("channels", str(clip["channels"])))
    metres = clip["metres_per_unit"]
    seconds = [(frame - clip["first_frame"]) / clip["rate"] for flight in clip["flights"] for frame in flight]
    flights = [
        f"{first}:{last} ({start:.2f}-{end:.2f} s)"
        for (first, last), start, end in zip(clip["flights"], seconds[::2], seconds[1::2], strict=True)
    ]
    return [
        *rows,
        ("unit", "not known (flights take a size from the skeleton)" if metres is None else f"{metres:.6g} m"),
        ("up", clip["up"] + (", but the figure stands along z: try --up z" if clip["seems_z_up"] else "")),
        ("joints", f"{len(clip['joints'])}, and {clip['end_sites']} end sites: {', '.join(clip['joints'])}"),
        ("root", clip["root"] + _why_root(clip)),
        ("flights", f"{len(flights)}: frames {', '.join(flights)}" if flights else "none"),
        *_names_rows(clip),
    ]


def _kind_rows(clip: dict[str, Any]) -> list[tuple[str, str]]:
    """Say what channels hold, those of a kind together, and what of them the search looks at."""
    by_kind: dict[str, list[str]] = {}
    idle = []
    for name, kind, weighs in zip(clip["channel_names"], clip["kinds"], clip["weigh"], strict=True):
        by_kind.setdefault(kind, []).append(name)
        if not weighs:
            idle.append(name)
    rows = [("kinds", "; ".join(f"{kind}: {_few(names)}" for kind, names in by_kind.items()))]
    rows += [("words", f"{name}: {_few(words)}") for name, words in clip["words"].items()]
    if idle:
        rows.append(("weigh", f"all but {_few(idle)}" if len(idle) < clip["channels"] else "none"))
    if clip["gaps"]:
        rows.append(("gaps", clip["gaps"]))
    return rows


def _why_root(clip: dict[str, Any]) -> str:
    above = clip["joints"].index(clip["root"])
    return f" (it carries the body; {above} above or beside it)" if above else ""


def _names_rows(clip: dict[str, Any]) -> list[tuple[str, str]]:
    """Say what was told by the joints' names: another name, and it is otherwise."""
    feet, pairs, n_joints = clip["feet"], clip["mirror_pairs"], len(clip["joints"])
    found = {"name": "by name", "motion": "by how they move, for no joint is called a foot"}
    unknown = [name for name, part in zip(clip["joints"], clip["parts"], strict=True) if part is None]
    known = f"{n_joints - len(unknown)} of {n_joints} joints known by name"
    return [
        (
            "feet",
            f"{len(feet)}, {found[clip['feet_found_by']]}: {', '.join(feet)}"
            if feet
            else "none: no joint is called a foot, and no limb is often lowest",
        ),
        (
            "mirror",
            f"{len(pairs)} pairs by name: {_few(['/'.join(pair) for pair in pairs])}"
            if pairs
            else "none: no two joints are called left and right",
        ),
        ("parts", known + (f"; other names match only their like: {_few(unknown)}" if unknown else "")),
    ]


def _few(names: list[str]) -> str:
    """List some names, and count the others."""
    return ", ".join(names[:_NAMES_SHOWN]) + (f" and {more} more" if (more := len(names) - _NAMES_SHOWN) > 0 else "")
