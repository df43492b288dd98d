"""`retime apply`: use a saved warp on clips."""

from __future__ import annotations

from pathlib import Path

import click

from retime.cli.clip_options import PATH, ClipOptions, clip_options
from retime.cli.exit_codes import EXIT_FILE, exit_code
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.in_place import Writing
from retime.cli.media_options import MediaChoices, check_media_place, media_options, say_media
from retime.cli.output_checks import check_format, check_outputs
from retime.cli.output_options import (
    bake_option,
    held_frames,
    layer_option,
    no_average_option,
    on_option,
    on_twos_option,
    tolerance_option,
)
from retime.cli.terminal import Stages, report_error, say
from retime.errors import OptionError, RetimeError, words_of

_EXAMPLES = (
    "\b\nExamples\n"
    "  retime apply warp.json walk.bvh camera.csv --out-dir retimed\n"
    "  retime apply warp.json take.mp4 -o out.mp4 --offset 0.5"
)


@click.command("apply", cls=SectionedCommand, short_help="Use a saved warp on one clip or more.", epilog=_EXAMPLES)
@click.argument("warp", type=PATH, metavar="WARP.json")
@click.argument("clips", type=PATH, metavar="CLIP...", nargs=-1, required=True)
@clip_options
@click.option(
    "-o", "--output", cls=Option, metavar="OUT", type=PATH, help="Where to write the result, if there is only one clip."
)
@click.option(
    "--out-dir",
    cls=Option,
    metavar="DIR",
    type=PATH,
    default_text="beside each clip",
    help="A folder that is there, to write to under each clip's own name and the suffix.",
)
@click.option(
    "--suffix",
    cls=Option,
    metavar="TEXT",
    default="_retimed",
    default_text="_retimed",
    help="Put after each clip's name, before its ending, where -o does not name the output.",
)
@no_average_option
@on_twos_option
@on_option
@bake_option
@tolerance_option
@layer_option
@media_options(offset=True)
@click.option("--force", cls=Option, is_flag=True, help="Replace files that are there; never an input.")
@click.option("-q", "--quiet", cls=Option, is_flag=True, help="Print no summary.")
def command(
    *,
    warp: Path,
    clips: tuple[Path, ...],
    clip_options: ClipOptions,
    output: Path | None,
    out_dir: Path | None,
    suffix: str,
    average: bool,
    on_twos: bool,
    on: int | None,
    bake: bool,
    tolerance: float | None,
    layer: str | None,
    media: MediaChoices,
    force: bool,
    quiet: bool,
) -> None:
    """Use a warp that retime warp saved on one clip or more.

    CLIP may be the clip that the warp was found for, its original at the full rate, another character, a camera, or the
    footage: a video with its sound, sound alone, or numbered pictures (take.%04d.png).
    Where the warp was found with --frames or --drop-first, give the same here. A clip that fails is reported, and the
    others are still written; the exit code says that one failed.
    """
    places = _places(clips, output, out_dir, suffix)
    skeletons = [] if clip_options.skeleton is None else [clip_options.skeleton]
    from retime.media.kinds import is_media

    footage = {clip for clip in clips if is_media(clip)}
    inputs = [warp, *clips, *skeletons]
    check_outputs(
        {f"the output for {clip}": place for clip, place in places.items() if clip not in footage},
        inputs=inputs,
        force=force,
    )
    for clip, place in places.items():
        if clip in footage:
            check_media_place(clip, place, others=inputs, force=force)
        else:
            check_format(place, like=clip, arrays=clip_options.array)
    media.refuse_without_media(clips)

    from retime.cli.summary import length_text
    from retime.formats.registry import stays_in_place
    from retime.formats.warp_file import read_warp

    stages = Stages(quiet=quiet)
    timing = read_warp(warp)
    writing = Writing(average, held_frames(on_twos, on), bake, tolerance, layer, force)
    codes = []
    for clip, place in places.items():
        try:
            if clip in footage:
                media.write(clip, clip_options, timing, place, stages, average=average, force=force)
                if not quiet:
                    say_media(clip, timing, place)
                continue
            motion = None
            # Of a scene that is retimed in place all animations are meant, and nothing is sampled.
            in_place = stays_in_place(clip, place, arrays=clip_options.array)
            if in_place is None or clip_options.frames or clip_options.drop_first:
                with stages.stage("read", f"reading {clip.name}"):
                    motion = clip_options.read(clip, beside=len(places) > 1)
            result = writing.write(clip, clip_options, motion, timing, place, stages)
        except (RetimeError, OSError) as error:
            if len(places) == 1:
                raise
            # One broken file must not keep the others from being done.
            words = words_of(error)
            report_error(words if str(clip) in words or str(place) in words else f"{clip}: {words}")
            codes.append(exit_code(error))
            continue
        if quiet:
            continue
        beside = "".join(f", with {one}" for one in writing.beside)
        writing.beside.clear()
        if result is None or motion is None:
            what = "a layer over it" if layer else f"its curves {'baked' if bake else 'cut'}"
            if in_place is not None and in_place.frames:
                what = "its frames resampled"
            say(f"{place}: {what}, {timing.output_span:.3f} s from {clip}{beside}")
        else:
            say(
                f"{place}: {length_text(result.n_frames, result.rate)}, from {clip}: "
                f"{length_text(motion.n_frames, motion.rate)}{beside}"
            )
    if codes:
        report_error(f"{len(codes)} of {len(places)} clips failed; the others were written")
        raise click.exceptions.Exit(codes[0] if len(set(codes)) == 1 else EXIT_FILE)


def _places(clips: tuple[Path, ...], output: Path | None, out_dir: Path | None, suffix: str) -> dict[Path, Path]:
    """Name each clip's output; raise OptionError where that can't be done."""
    if output is not None:
        if out_dir is not None:
            raise OptionError("-o names one file, and --out-dir a folder: give one of them")
        if len(clips) > 1:
            raise OptionError(f"-o names one file, but there are {len(clips)} clips: give --out-dir instead")
        return {clips[0]: output}
    if "/" in suffix or "\\" in suffix:
        raise OptionError(f"--suffix is part of a file's name and can't hold a slash; found {suffix!r}")
    if len(set(clips)) < len(clips):
        raise OptionError("a clip is given twice")
    from retime.formats.compressed import plain_path

    # What was compressed is written as it is.
    plain = {clip: plain_path(clip) for clip in clips}
    return {clip: (out_dir or clip.parent) / f"{name.stem}{suffix}{name.suffix}" for clip, name in plain.items()}
