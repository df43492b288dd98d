"""`retime warp`: find a warp for a clip, and use it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from retime.cli.clip_options import PATH, ClipOptions, clip_options, parsed, retimed
from retime.cli.control_options import ControlOptions, control_options, parse_any_length
from retime.cli.outputs import check_format, check_outputs, check_plot
from retime.cli.search_options import search_options
from retime.cli.sections import Option, SectionedCommand
from retime.cli.terminal import Stages, say, say_json, say_table
from retime.errors import OptionError
from retime.motion.rate import parse_rate
from retime.motion.timecode import parse_frame_range, parse_speed, parse_time

if TYPE_CHECKING:
    from retime.motion.motion import Motion
    from retime.motion.signal import Signal
    from retime.warp.curve import Warp
    from retime.warp.guided import GuidedWarp
    from retime.warp.reference import Reference

Key = tuple[str, str] | tuple[str, str, float]


def _key(text: str) -> Key:
    """Split a keytime at its signs; refuse what is no time."""
    input_time, sign, rest = text.partition("=")
    output_time, at, speed = rest.partition("@")
    if not sign:
        raise OptionError(f"expected input time = output time, such as 2.5=1.8 or 300f=0:01.800, found {text!r}")
    for time in (input_time, output_time):
        if parse_time(time, Fraction(30)) < 0:
            raise OptionError(f"input and output begin at time 0, found {text!r}")
    return (input_time, output_time, parse_speed(speed)) if at else (input_time, output_time)


def _also(text: str) -> tuple[Path, Path]:
    """Split another clip of the group from its output."""
    clip, sign, output = text.partition("=")
    if not (sign and clip and output):
        raise OptionError(
            f"expected another clip and its output, such as camera.csv=camera_retimed.csv, found {text!r}"
        )
    return Path(clip), Path(output)


def _reference_weight(text: str) -> float:
    try:
        weight = float(text)
    except ValueError:
        weight = 0.0
    if not 0 < weight < float("inf"):
        raise OptionError(f"expected a weight above 0, found {text!r}")
    return weight


@dataclass(frozen=True)
class _Request:
    """What was asked for: the input, the keytimes, the method, the places."""

    clip: Path
    clip_options: ClipOptions
    reference: tuple[Path, ...]
    reference_frames: tuple[str, ...]
    reference_weight: tuple[float, ...]
    reference_fps: Fraction | None
    length: str | None
    keys: tuple[Key, ...]
    method: str
    output: Path | None
    save: Path | None
    plot: Path | None
    explain: Path | None
    also: tuple[tuple[Path, Path], ...]
    group: bool
    average: bool
    force: bool
    search: dict[str, Any]
    control: ControlOptions

    def check(self) -> None:
        """Refuse, before anything is read, what can't end well."""
        if self.method != "guided":
            useless = [f"--{'neighbors' if name == 'n_neighbors' else name.replace('_', '-')}" for name in self.search]
            useless += self.control.names_given()
            useless = ["--reference"] * bool(self.reference) + ["--explain"] * (self.explain is not None) + useless
            if useless:
                raise OptionError(
                    f"{', '.join(useless)} would have no effect: there is no search with --method {self.method}"
                )
            if self.length == "free":
                raise OptionError(f"a free length needs a search; --method {self.method} has none")
        for option, given in (
            ("--reference-fps", self.reference_fps is not None),
            ("--reference-weight", bool(self.reference_weight)),
            ("--joint-map", self.control.joint_map is not None),
        ):
            if given and not self.reference:
                raise OptionError(f"{option} needs --reference")
        for option, values in (
            ("--reference-frames", self.reference_frames),
            ("--reference-weight", self.reference_weight),
        ):
            # Frames with no reference are frames of the clip itself.
            expected = len(self.reference) or 1
            if len(values) not in (0, expected):
                raise OptionError(
                    f"{option} is given {len(values)} times, for {expected} references: once for each, or not"
                )
        if self.group and not self.also:
            raise OptionError("--group finds one warp on several clips: name the others with --also CLIP=OUT")
        if self.group and self.reference:
            raise OptionError("--group moves like itself: it can't be combined with --reference")
        skeletons = [] if self.clip_options.skeleton is None else [self.clip_options.skeleton]
        inputs = [self.clip, *skeletons, *self.reference, *(clip for clip, _ in self.also)]
        outputs = {"--output": self.output, "--save": self.save, "--plot": self.plot, "--explain": self.explain}
        outputs |= {f"--also {clip}": place for clip, place in self.also}
        check_outputs(outputs, inputs=inputs, force=self.force)
        for clip, place in self.also:
            check_format(place, like=clip)
        if self.output is not None:
            check_format(self.output, like=self.clip)
        if self.plot is not None:
            check_plot(self.plot)


@dataclass(frozen=True, eq=False)
class _Outcome:
    """A warp, its search where there was one, and the clip with it."""

    clip: Motion | Signal
    warp: Warp
    search: GuidedWarp | None
    n_output_frames: int
    stages: Stages


_EXAMPLES = (
    "\b\nExamples\n"
    "  retime warp walk.bvh --length 65% -o shorter.bvh --plot warp.svg\n"
    "  retime warp walk.bvh --key 2.5=1.8 --reference limp.bvh -o limping.bvh\n"
)


@click.command("warp", cls=SectionedCommand, epilog=_EXAMPLES)
@click.argument("clip", type=PATH)
@clip_options
@click.option(
    "--reference",
    cls=Option,
    section="Reference",
    metavar="CLIP",
    type=PATH,
    multiple=True,
    default_text="the clip itself",
    help="Imitate the timing of this clip; repeat for more. Joints are matched by name; --skeleton, --repair and "
    "--decimal-comma hold for it too.",
)
@click.option(
    "--reference-frames",
    cls=Option,
    section="Reference",
    metavar="A:B",
    multiple=True,
    help="Frames of the reference (of the clip itself, where there is no other), as its file numbers them.",
)
@click.option(
    "--reference-weight",
    cls=Option,
    section="Reference",
    metavar="W",
    callback=parsed(_reference_weight),
    multiple=True,
    default_text="1",
    help="Let the reference look W times as near; one for each reference.",
)
@click.option(
    "--reference-fps",
    cls=Option,
    section="Reference",
    metavar="R",
    callback=parsed(parse_rate),
    help="Frames a second of the reference, in place of what its file declares.",
)
@click.option(
    "--length",
    cls=Option,
    section="Keytimes",
    metavar="L",
    callback=parsed(parse_any_length),
    default_text="as the input",
    help="Length of the output: 65%, 9.3s or 280f (frames at the clip's rate), or free: the search finds it.",
)
@click.option(
    "--key",
    "keys",
    cls=Option,
    section="Keytimes",
    metavar="IN=OUT[@SPEED]",
    callback=parsed(_key),
    multiple=True,
    help="Show input time IN at output time OUT (2.5, 120f or mm:ss.mmm from the first frame used), at this playback "
    "speed where one is given; repeat for more. Equal input times hold, decreasing ones run backward.",
)
@click.option(
    "--method",
    cls=Option,
    section="Method",
    metavar="NAME",
    type=click.Choice(["guided", "linear", "spline"]),
    default="guided",
    default_text="guided",
    help="guided: search for a natural warp. linear, spline: only join the keytimes.",
)
@search_options
@control_options
@click.option(
    "-o",
    "--output",
    cls=Option,
    section="Output",
    metavar="OUT",
    type=PATH,
    help="Write the retimed clip; the name's ending says in which format.",
)
@click.option(
    "--save",
    cls=Option,
    section="Output",
    metavar="WARP.json",
    type=PATH,
    help="Write the warp, for retime apply and retime plot.",
)
@click.option(
    "--plot",
    cls=Option,
    section="Output",
    metavar="FILE",
    type=PATH,
    help="Draw the warp beside linear, and spline where there are keys (.svg, .png).",
)
@click.option(
    "--explain",
    cls=Option,
    section="Output",
    metavar="FILE.csv",
    type=PATH,
    help="Write for each output frame its score, the reference frames that it was matched with, and what was binding.",
)
@click.option(
    "--also",
    cls=Option,
    section="Output",
    metavar="CLIP=OUT",
    callback=parsed(_also),
    multiple=True,
    help="Give another clip the same warp (a prop, a camera, a second character); repeat for more.",
)
@click.option(
    "--group",
    cls=Option,
    section="Output",
    is_flag=True,
    help="Find the warp on all clips together, not on CLIP alone.",
)
@click.option(
    "--no-average",
    "average",
    cls=Option,
    section="Output",
    is_flag=True,
    flag_value=False,
    default=True,
    help="Don't average the input where it is sped up.",
)
@click.option(
    "--force", cls=Option, section="Output", is_flag=True, help="Replace files that are there; never the input."
)
@click.option(
    "--json",
    "as_json",
    cls=Option,
    section="Output",
    is_flag=True,
    help="Print one JSON object instead of the summary.",
)
@click.option("-q", "--quiet", cls=Option, section="Output", is_flag=True, help="Print no summary.")
def command(*, as_json: bool, quiet: bool, **given: Any) -> None:
    """Give CLIP new timing: shorter or longer, or with chosen moments at chosen times.

    The search keeps the clip's own timing wherever the length allows it (the flight of a jump stays as fast as it
    was), or imitates that of a reference.
    """
    request = _Request(**given)
    request.check()
    outcome = _run(request, Stages(quiet=quiet))
    if as_json:
        say_json(_document(request, outcome))
    elif not quiet:
        _say_summary(request, outcome)


def _run(request: _Request, stages: Stages) -> _Outcome:
    # Heavy imports wait until something is to be done.
    from retime.formats.files import write_bytes
    from retime.formats.registry import write
    from retime.formats.warp_file import write_warp
    from retime.warp.apply import output_frame_times

    with stages.stage("read", "reading"):
        clip = request.clip_options.read(request.clip)
        others = [(request.clip_options.read(other), place) for other, place in request.also]
        references = _read_references(request, clip)
    with stages.stage("search", "searching"):
        warp, search = _find(request, [clip, *(other for other, _ in others)], references)
        warp = replace(warp, name=clip.name)
    if request.output is not None:
        with stages.stage("apply", "resampling"):
            result = retimed(clip, warp, average=request.average)
        with stages.stage("write", "writing"):
            write(result, request.output, overwrite=request.force)
    for other, place in others:
        with stages.stage("apply", "resampling"):
            result = retimed(other, warp, average=request.average)
        with stages.stage("write", "writing"):
            write(result, place, overwrite=request.force)
    if request.explain is not None and search is not None:
        with stages.stage("write", "writing"):
            write_bytes(request.explain, search.explain().to_csv().encode(), overwrite=request.force)
    if request.save is not None:
        with stages.stage("write", "writing"):
            write_warp(warp, request.save, overwrite=request.force)
    if request.plot is not None:
        with stages.stage("plot", "drawing"):
            _draw(request, clip, warp)
    n_output_frames = len(output_frame_times(warp, float(clip.rate)))
    return _Outcome(clip, warp, search, n_output_frames, stages)


def _read_references(request: _Request, clip: Motion | Signal) -> list[Reference]:
    """Read what is to be imitated; nothing, where that is the clip as a whole."""
    from retime.warp.reference import Reference

    options, control = request.clip_options, request.control
    if not request.reference and not request.reference_frames and not control.mirror:
        return []
    joint_map = {}
    if control.joint_map is not None:
        from retime.formats.joint_map import read_joint_map

        joint_map = read_joint_map(control.joint_map)
    found = []
    frames = request.reference_frames or (None,) * max(1, len(request.reference))
    weights = request.reference_weight or (1.0,) * len(frames)
    for i, (span, weight) in enumerate(zip(frames, weights, strict=True)):
        if request.reference:
            motion = ClipOptions(
                frames=span,
                fps=request.reference_fps,
                skeleton=options.skeleton,
                repair=options.repair,
                decimal_comma=options.decimal_comma,
            ).read(request.reference[i])
        else:
            start, stop = parse_frame_range(span or ":", clip.n_frames, clip.first_frame)
            motion = clip.frames(start, stop)
        found.append(Reference(motion, weight=weight, mirror=control.mirror, joint_map=joint_map))
    return found


def _find(
    request: _Request, clips: list[Motion | Signal], references: list[Reference]
) -> tuple[Warp, GuidedWarp | None]:
    """Find the warp by the method asked for."""
    from retime.warp.guided import as_keytimes, guided_warp
    from retime.warp.keytimes import check_keytimes
    from retime.warp.spline import linear_warp, spline_warp

    clip = clips[0]
    if request.method == "guided":
        options = request.search | request.control.arguments(clip.rate, request.search.get("features"))
        search = guided_warp(
            clips if request.group else clip,
            reference=references or None,
            length=request.length,
            keys=request.keys,
            **options,
        )
        return search.warp, search
    keytimes = check_keytimes(as_keytimes(clip, request.length, request.keys), clip.duration)
    if request.method == "linear":
        return linear_warp(keytimes), None
    return spline_warp(keytimes, rate=float(clip.rate)), None


def _draw(request: _Request, clip: Motion | Signal, warp: Warp) -> None:
    """Draw the warp beside what an animator has today."""
    from retime.evaluate.plot import plot_warps
    from retime.warp.spline import linear_warp, spline_warp

    warps = {"linear": linear_warp(warp.keytimes)}
    if len(warp.keytimes) > 2:
        warps["spline"] = spline_warp(warp.keytimes, rate=float(clip.rate))
    warps[request.method] = warp
    plot_warps(warps, motion=clip, path=request.plot, title=clip.name, overwrite=request.force)


def _document(request: _Request, outcome: _Outcome) -> dict[str, Any]:
    """Collect what --json prints; the search's numbers are null where there was none."""
    search = outcome.search
    seconds = dict(outcome.stages.seconds)
    if search is not None:
        # The search says itself how long each of its stages took.
        del seconds["search"]
        seconds = {"read": seconds.pop("read"), **search.seconds, **seconds}
    return {
        "method": request.method,
        "input": str(request.clip),
        "references": [str(reference) for reference in request.reference],
        "input_frames": outcome.clip.n_frames,
        "input_rate": float(outcome.clip.rate),
        "output_frames": outcome.n_output_frames,
        "output_rate": float(outcome.clip.rate),
        "n_input": None if search is None else search.n_input,
        "n_output": None if search is None else search.n_output,
        "n_reference": None if search is None else search.n_reference,
        "max_skip": None if search is None else search.max_skip,
        "n_neighbors": None if search is None else search.n_neighbors,
        "rate": None if search is None else search.rate,
        "upsample": None if search is None else search.upsample,
        "total": None if search is None else search.total,
        "lower_bound": None if search is None else search.path.lower_bound,
        "optimal": None if search is None else search.path.optimal,
        "excess": None if search is None else search.excess,
        "path": None if search is None else search.path.frames.tolist(),
        "seconds": seconds,
        "output": None if request.output is None else str(request.output),
        "warp": None if request.save is None else str(request.save),
        "plot": None if request.plot is None else str(request.plot),
        "explain": None if request.explain is None else str(request.explain),
        "also": [str(place) for _, place in request.also],
    }


def _say_summary(request: _Request, outcome: _Outcome) -> None:
    from retime.cli import summary

    clip, search = outcome.clip, outcome.search
    last_frame = clip.first_frame + clip.n_frames - 1
    share = outcome.n_output_frames / clip.n_frames
    rows = [
        (
            "input",
            f"{request.clip}, frames {clip.first_frame}:{last_frame}: "
            f"{summary.length_text(clip.n_frames, clip.rate)} at {summary.rate_text(clip.rate)}",
        ),
        ("output", f"{summary.length_text(outcome.n_output_frames, clip.rate)} ({share:.1%} of the input)"),
    ]
    if search is not None:
        upsampled = f", upsample {search.upsample}" if search.upsample > 1 else ""
        rows.append(
            (
                "search",
                f"n_input {search.n_input}, n_output {search.n_output}, n_reference {search.n_reference}, max_skip "
                f"{search.max_skip}{upsampled} at {search.rate:g} Hz",
            )
        )
    rows.append(("speed", summary.speed_text(outcome.warp)))
    spans = summary.flight_spans(clip)
    if spans:
        rows.append(("flights", summary.flights_text(outcome.warp if search is None else search.steps, spans)))
    if search is not None and search.excess is not None:
        rows.append(("excess", f"{search.excess:.2%} over the optimum (heuristic search)"))
    places = [request.output, *(place for _, place in request.also), request.save, request.plot, request.explain]
    rows += [("wrote", str(place)) for place in places if place is not None]
    say_table(rows)
    if not any(places):
        say(
            "Nothing was written. To keep the result: -o OUT (the retimed clip), --save WARP.json (the warp), "
            "--plot WARP.svg (a picture)."
        )
