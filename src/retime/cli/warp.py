"""`retime warp`: find a warp for a clip, and use it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from retime.cli.beat_options import keys_from_option, keys_on_option
from retime.cli.clip_options import PATH, ClipOptions, clip_options, hint_at_up, parsed
from retime.cli.found_warp import FoundWarp, deliver
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.in_place import keeps_curves
from retime.cli.output_options import OutputOptions, output_options
from retime.cli.search_options import flags_of, for_footage, search_options
from retime.cli.terminal import Stages, say_table
from retime.cli.variants import LENGTHS, VariantOptions, read_count, read_lengths, read_seed
from retime.cli.wish_options import FLIGHT_OPTIONS, NO_MAP, WISHES_BESIDE, WishOptions, reference_options, wish_options
from retime.errors import OptionError
from retime.motion.grammar import WrittenKey, parse_frame_range, parse_number
from retime.motion.rate import parse_rate

if TYPE_CHECKING:
    from retime.cli.beat_options import BeatKeys
    from retime.motion.any_motion import AnyMotion
    from retime.search.poses.references import Reference
    from retime.search.result import GuidedWarp
    from retime.warp.curve import Warp
    from retime.warp.keytime import Keytime


def _reference_weight(text: str) -> float:
    return parse_number(text, above=True, unit="x")


def _repeat(text: str) -> float:
    return parse_number(text, least=1.0, unit="x")


@dataclass(frozen=True)
class _Request:
    """What was asked for: the input, the keytimes, the method, the places."""

    clip: Path
    clip_options: ClipOptions
    reference: tuple[Path, ...]
    reference_frames: tuple[str, ...]
    reference_weight: tuple[float, ...]
    reference_fps: Fraction | None
    keys: tuple[WrittenKey, ...]
    keys_from: Path | None
    keys_on: str | None
    method: str
    repeat: float | None
    variants: int | None
    seed: int | None
    lengths: tuple[float, float] | None
    draw_references: bool
    group: bool
    search: dict[str, Any]
    wishes: WishOptions
    outputs: OutputOptions

    def check(self) -> None:
        """Refuse, before anything is read, what can't end well."""
        self._check_variants()
        if self.keys_from is None and self.keys_on is not None:
            raise OptionError("--keys-on needs --keys-from FILE")
        if self.keys_from is not None and (self.method == "align" or self.group):
            other = "--group" if self.group else "--method align"
            raise OptionError(f"--keys-from puts one clip's accents on beats: it can't be combined with {other}")
        if self.method == "align":
            self._check_align()
        elif self.repeat is not None:
            raise OptionError("--repeat is for --method align: elsewhere the reference has no clock")
        elif self.method != "guided":
            useless = ["--reference"] * bool(self.reference)
            useless += ["--reference-frames"] * bool(self.reference_frames and not self.reference)
            useless += ["--explain"] * (self.outputs.explain is not None)
            useless += ["--group"] * self.group
            useless += flags_of(name for name in self.search if name != "length")
            useless += self.wishes.names_given()
            if useless:
                raise OptionError(
                    f"{', '.join(useless)} would have no effect: there is no search with --method {self.method}"
                )
            if self.search.get("length") == "free":
                raise OptionError(f"a free length needs a search; --method {self.method} has none")
        for option, given in (
            ("--reference-fps", self.reference_fps is not None),
            ("--reference-weight", bool(self.reference_weight)),
            ("--joint-map", bool(self.wishes.joint_map)),
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
        if len(self.wishes.joint_map) not in (0, 1, len(self.reference)):
            raise OptionError(
                f"--joint-map is given {len(self.wishes.joint_map)} times, for {len(self.reference)} references: once "
                "for all of them, or once for each (- where names say it)"
            )
        if self.group and not self.outputs.also:
            raise OptionError("--group finds one warp on several clips: name the others with --also CLIP=OUT")
        if self.group and self.reference:
            raise OptionError("--group moves like itself: it can't be combined with --reference")
        inputs = [self.clip_options.skeleton, *self._map_files(), *self.reference, self.keys_from]
        for outputs in self.places:
            outputs.check(self.clip, inputs, self.clip_options.array)

    @property
    def many(self) -> VariantOptions | None:
        """The variants that are asked for; None where it is one warp."""
        if self.variants is None:
            return None
        return VariantOptions(self.variants, self.seed or 0, self.lengths or LENGTHS)

    @property
    def places(self) -> list[OutputOptions]:
        """Where each warp goes."""
        return [self.outputs] if self.many is None else self.many.outputs(self.outputs)

    def _check_variants(self) -> None:
        """Refuse what variants draw themselves."""
        if self.variants is None:
            for option, given in (("--seed", self.seed), ("--lengths", self.lengths)):
                if given is not None:
                    raise OptionError(f"{option} is for --variants N")
            if self.draw_references:
                raise OptionError("--draw-references is for --variants N")
            return
        if self.draw_references and not (self.reference or self.reference_frames):
            raise OptionError("--draw-references needs --reference, best several")
        if self.method != "guided":
            raise OptionError(f"--variants are guided warps: not with --method {self.method}")
        refused = (
            ["--key"] * bool(self.keys)
            + ["--keys-from"] * (self.keys_from is not None)
            + ["--group"] * self.group
            + ["--also"] * bool(self.outputs.also)
        )
        refused += flags_of(
            name for name in self.search if name in ("length", "min_length", "max_length", "free_weight")
        )
        if refused:
            raise OptionError(
                f"{', '.join(refused)} can't be combined with --variants, which have lengths and keys of their own"
            )
        if self.wishes.flown or self.wishes.grounded:
            raise OptionError("--flight and --no-flight can't be combined with --variants: name spans with --lock")

    def _check_align(self) -> None:
        """Refuse what keeping step has no use for."""
        from retime.search.align import ANALYSIS, SOLVE

        if not self.reference and not self.reference_frames:
            raise OptionError("--method align needs --reference CLIP: what to keep step with")
        if len(self.reference) > 1:
            raise OptionError(f"--method align keeps step with one reference; found {len(self.reference)}")
        # How long the result is, and which of its frames are compared, is the reference's to say.
        useless = flags_of(name for name in self.search if name not in (*ANALYSIS, *SOLVE))
        useless += ["--reference-weight"] * bool(self.reference_weight)
        useless += ["--flight"] * bool(self.wishes.flown) + ["--no-flight"] * bool(self.wishes.grounded)
        if useless:
            raise OptionError(
                f"{', '.join(useless)} would have no effect: with --method align the output keeps the reference's "
                "clock, frame by frame"
            )

    def _map_files(self) -> list[Path]:
        return [path for path in self.wishes.joint_map if path != NO_MAP]


_EXAMPLES = (
    "\b\nExamples\n"
    "  retime warp walk.bvh --length 65% -o shorter.bvh --plot warp.svg\n"
    "  retime warp walk.bvh --key 2.5=1.8 --reference limp.bvh -o limping.bvh\n"
)


@click.command(
    "warp",
    cls=SectionedCommand,
    short_help="Give a clip new timing: another length, moments at chosen times.",
    epilog=_EXAMPLES,
)
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
    help="Imitate the timing of this clip; repeat for more. Joints are matched by name; --skeleton, --repair, "
    "--decimal-comma, --up, --root, --channel, --gaps, --array and --confidence hold for it too.",
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
    help="Count the reference W times as near as it is, so that it is imitated more; one for each reference.",
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
    "--method",
    cls=Option,
    section="Method",
    metavar="NAME",
    type=click.Choice(["guided", "align", "linear", "spline"]),
    default="guided",
    default_text="guided",
    help="guided: search for a natural warp. align: keep step with the reference, which does the same things in the "
    "same order. linear, spline: only join the keytimes.",
)
@click.option(
    "--repeat",
    cls=Option,
    section="Reference",
    metavar="X",
    callback=parsed(_repeat),
    default_text="1",
    help="With --method align: play the reference X times (a cycle of a walk, for a long walk).",
)
@click.option(
    "--variants",
    cls=Option,
    section="Variants",
    metavar="N",
    callback=parsed(read_count),
    help="Find N different natural timings, no two alike: lengths, keys, locks and weights are drawn. {n} in the name "
    "of an output stands for a variant's number.",
)
@click.option(
    "--seed",
    cls=Option,
    section="Variants",
    metavar="S",
    callback=parsed(read_seed),
    default_text="0",
    help="Another seed, other variants; the same one, the same.",
)
@click.option(
    "--lengths",
    cls=Option,
    section="Variants",
    metavar="LO..HI",
    callback=parsed(read_lengths),
    default_text="80%..120%",
    help="The shortest and the longest of the variants.",
)
@click.option(
    "--draw-references",
    cls=Option,
    section="Variants",
    is_flag=True,
    help="Each variant imitates one of the references, drawn, in place of all of them.",
)
@search_options(
    usual={"length": "as the keytimes say; without any, as the input"},
    beside=WISHES_BESIDE
    | {
        "keep_flights": FLIGHT_OPTIONS,
        "length": (*WISHES_BESIDE["length"], keys_from_option, keys_on_option),
    },
)
@wish_options
@reference_options
@click.option(
    "--group",
    cls=Option,
    section="Output",
    is_flag=True,
    help="Search for the warp on CLIP and the clips of --also together, not on CLIP alone.",
)
@output_options
def command(**given: Any) -> None:
    """Give CLIP new timing: shorter or longer, or with chosen moments at chosen times.

    The search keeps the clip's own timing wherever the length allows it (the flight of a jump stays as fast as it
    was), or imitates that of a reference.
    """
    request = _Request(**given)
    request.check()
    names = _animations(request)
    if len(names) > 1:
        _warp_each(request, names)
        return
    stages = Stages(quiet=request.outputs.quiet)
    with stages.stage("read", "reading"):
        clip = request.clip_options.read(request.clip)
        others = request.outputs.read_others(clip, request.clip_options, searched=request.group)
        references = _read_references(request, clip)
    hint_at_up(clip, request.clip_options.up)
    if request.many is not None:
        with stages.stage("search", "searching"):
            many = request.many
            takes = many.find(
                clip, request.draw_references, {"reference": references or None, **_options(request, clip)}
            )
        # Of frames of the clip itself there is no file to be named.
        drawn = many.drawn_references(request.reference) if request.draw_references and request.reference else ()
        for number, (take, outputs) in enumerate(zip(takes, request.places, strict=True), start=1):
            warp = replace(take.warp, name=clip.name)
            found = FoundWarp(request.clip, request.clip_options, clip, [], "guided", warp, take)
            imitated = [drawn[number - 1]] if drawn else request.reference
            facts = {"references": [str(reference) for reference in imitated], "variant": number}
            deliver(found, outputs, stages, facts)
        return
    together = [clip, *(other for other, _ in others if other is not None)]
    said: dict[str, Any] = {"references": [str(reference) for reference in request.reference]}
    beats: BeatKeys | None = None
    if request.keys_from is None:
        with stages.stage("search", "searching"):
            warp, search = _find(request, together, references)
    else:
        with stages.stage("read", "finding beats"):
            request, beats = _on_beats(request, clip)
        with stages.stage("search", "searching"):
            warp, search = beats.searched(lambda keys: _find(request, together, references, keys))
        said["beats"] = beats.facts()
    warp = replace(warp, name=clip.name)
    found = FoundWarp(request.clip, request.clip_options, clip, others, request.method, warp, search)
    deliver(found, request.outputs, stages, said)
    if beats is not None and not (request.outputs.quiet or request.outputs.as_json):
        say_table(beats.rows())


def _on_beats(request: _Request, clip: AnyMotion) -> tuple[_Request, BeatKeys]:
    """Match a clip's accents with beats; where no length is given, what comes after the last match keeps its speed."""
    from retime.cli.beat_options import beat_keys
    from retime.search.keytimes import as_keytimes
    from retime.search.written import search_arguments

    assert request.keys_from is not None
    if request.search.get("length") == "free":
        raise OptionError("--keys-from fixes the length with its last beat: leave --length free out")
    keys = [key.at(clip.rate) for key in request.keys]
    length = search_arguments(request.search, clip.rate).get("length")
    end = None if length is None else as_keytimes(clip, length, [])[-1].output_time
    given = as_keytimes(clip, length, keys)[1:-1]
    found = beat_keys(request.keys_from, request.keys_on, clip, given, end)
    if length is None:
        last = found.matches[-1]
        seconds = last.beat.time + clip.end_time - last.accent.time + float(1 / clip.rate)
        request = replace(request, search={**request.search, "length": seconds})
    return request, found


def _animations(request: _Request) -> list[str]:
    """Name the animations that are retimed, each by a warp of its own; none, where the output is one clip."""
    output = request.outputs.output
    if output is None or not keeps_curves(request.clip, output):
        return []
    from retime.formats.registry import animation_names

    options = request.clip_options
    return animation_names(request.clip, animation=options.animation, outside=options.allow_outside)


def _warp_each(request: _Request, names: list[str]) -> None:
    """Find a warp for each animation of a scene, by itself, and write the scene with all of them retimed."""
    outputs, given = request.outputs, request.clip_options
    single = {
        "--save": outputs.save,
        "--plot": outputs.plot,
        "--explain": outputs.explain,
        "--json": outputs.as_json,
        "--also": outputs.also,
        "--variants": request.many,
        "--frames": given.frames,
        "--drop-first": given.drop_first,
    }
    refused = [option for option, value in single.items() if value]
    if refused:
        raise OptionError(
            f"{', '.join(refused)}: {request.clip} has {len(names)} animations ({', '.join(names)}), and each gets a "
            "warp of its own; choose one of them (--animation)"
        )
    assert outputs.output is not None
    from retime.cli.summary import length_text

    stages = Stages(quiet=outputs.quiet)
    warps, rows = {}, []
    for name in names:
        one = replace(request, clip_options=replace(given, animation=name))
        with stages.stage("read", f"reading {name}"):
            clip = one.clip_options.read(one.clip)
            references = _read_references(one, clip)
        with stages.stage("search", f"searching {name}"):
            warps[name], _ = _find(one, [clip], references)
        before, after = (length_text(n, clip.rate) for n in (clip.n_frames, warps[name].count_frames(clip.rate)))
        rows.append((name, f"{before} -> {after}"))
    with stages.stage("write", f"writing {outputs.output.name}"):
        writing = outputs.writing
        writing.write_curves(request.clip, given, warps, outputs.output)
    if not outputs.quiet:
        say_table([*rows, *(("wrote", str(place)) for place in (outputs.output, *writing.beside))])


def _read_references(request: _Request, clip: AnyMotion) -> list[Reference]:
    """Read what is to be imitated; nothing, where that is the clip as a whole."""
    from retime.search.poses.references import Reference

    options, wishes = request.clip_options, request.wishes
    if not request.reference and not request.reference_frames and not wishes.mirror:
        return []
    from retime.formats.joint_map import read_joint_map

    maps = [{} if path == NO_MAP else read_joint_map(path) for path in wishes.joint_map]
    found = []
    frames = request.reference_frames or (None,) * max(1, len(request.reference))
    weights = request.reference_weight or (1.0,) * len(frames)
    # A single map holds for all references.
    joint_maps = maps if len(maps) > 1 else (maps or [{}]) * len(frames)
    for i, (span, weight, joint_map) in enumerate(zip(frames, weights, joint_maps, strict=True)):
        if request.reference:
            motion = ClipOptions(
                frames=span,
                fps=request.reference_fps,
                skeleton=options.skeleton,
                repair=options.repair,
                decimal_comma=options.decimal_comma,
                up=options.up,
                channels=options.channels,
                gaps=options.gaps,
                array=options.array,
                root=options.root,
                is_reference=True,
            ).read(request.reference[i], beside=True)
        else:
            start, stop = parse_frame_range(span or ":", clip.n_frames, clip.first_frame)
            motion = clip.frames(start, stop)
        found.append(Reference(motion, weight=weight, mirror=wishes.mirror, joint_map=joint_map))
    return found


def _find(
    request: _Request, clips: list[AnyMotion], references: list[Reference], beats: Sequence[Keytime] = ()
) -> tuple[Warp, GuidedWarp | None]:
    """Find the warp by the method asked for; `beats` are more keytimes."""
    from retime.search.align import align
    from retime.search.guided import guided_warp
    from retime.search.joined import joined_warp

    clip = clips[0]
    keys = [key.at(clip.rate) for key in request.keys] + [(key.input_time, key.output_time) for key in beats]
    if request.method in ("guided", "align"):
        options = _options(request, clip)
        if request.method == "align":
            search = align(clip, references[0], repeat=request.repeat or 1.0, keys=keys, **options)
        else:
            together = clips if request.group else [clip]
            search = guided_warp(
                clips if request.group else clip,
                reference=references or None,
                keys=keys,
                flights=request.wishes.flights(together),
                **options,
            )
        return search.warp, search
    return joined_warp(clip, request.search.get("length"), keys, request.method), None


def _options(request: _Request, clip: AnyMotion) -> dict[str, Any]:
    """Return the options of the search as its functions take them."""
    from retime.search.written import search_arguments

    search = search_arguments(request.search, clip.rate)
    return for_footage(request.clip, search | request.wishes.arguments(clip.rate, request.search.get("features")))
