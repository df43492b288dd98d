"""A warp that was found, and what a command leaves of it: files, and a summary or one JSON object."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from retime.cli.clip_options import ClipOptions
from retime.cli.output_options import OutputOptions
from retime.cli.terminal import Stages, say, say_json, say_table

if TYPE_CHECKING:
    from retime.cli.in_place import Writing
    from retime.motion.any_motion import AnyMotion
    from retime.search.result import GuidedWarp
    from retime.warp.curve import Warp


@dataclass(frozen=True, eq=False)
class FoundWarp:
    """A warp, and where it comes from.

    Attributes
    ----------
    path : Path
        The clip's file.
    clip_options : ClipOptions
        How it was read.
    clip : Motion or Signal
        The input.
    others : list of (Motion, Signal or None, Path)
        Clips that get the same warp, and their places.
    method : str
        "guided", "align", "linear" or "spline".
    warp : Warp
        The result.
    search : GuidedWarp, optional
        Where there was one.
    """

    path: Path
    clip_options: ClipOptions
    clip: AnyMotion
    others: list[tuple[AnyMotion | None, Path]]
    method: str
    warp: Warp
    search: GuidedWarp | None
    n_output_frames: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "n_output_frames", self.warp.count_frames(self.clip.rate))


def deliver(found: FoundWarp, outputs: OutputOptions, stages: Stages, facts: dict[str, Any]) -> None:
    """Write what was asked for, then say what was done; `facts` are the command's own part of the JSON."""
    writing = outputs.writing
    slip = _write(found, outputs, writing, stages)
    if outputs.as_json:
        say_json(_document(found, outputs, stages, facts, slip) | {"beside": [str(one) for one in writing.beside]})
    elif not outputs.quiet:
        _say_summary(found, outputs, writing.beside, slip)


def _write(
    found: FoundWarp, outputs: OutputOptions, writing: Writing, stages: Stages
) -> dict[str, float | bool] | None:
    """Write all files; how far the feet slide in the retimed clip, where that is to be told."""
    # Heavy imports wait until something is to be done.
    from retime.cli.summary import slip_facts
    from retime.files import write_bytes
    from retime.formats.registry import stays_in_place
    from retime.formats.warp_file import write_warp
    from retime.motion.contacts import contacts
    from retime.motion.motion import Motion

    slip = None
    if outputs.output is not None:
        feet = None
        if isinstance(found.clip, Motion) and not stays_in_place(
            found.path, outputs.output, arrays=found.clip_options.array
        ):
            with stages.stage("apply", "finding the feet"):
                feet = contacts(found.clip)
        result = writing.write(
            found.path, found.clip_options, found.clip, found.warp, outputs.output, stages, feet=feet
        )
        # Of curves that were cut nothing is averaged, so standing feet stay as they were.
        if result is not None and (outputs.as_json or not outputs.quiet):
            with stages.stage("slip", "measuring the feet"):
                slip = slip_facts(found.clip, found.warp, result, feet)
        del result
    for one, (clip, _) in zip(outputs.also, found.others, strict=True):
        if clip is None:
            offset = 0.0 if one.offset is None else one.sign * float(one.offset.at(found.clip.rate))
            # The warp's time 0 is the first frame that was looked at.
            offset -= found.clip.first_frame / float(found.clip.rate)
            writing.write_media(one.clip, found.warp, one.output, stages, fps=None, offset=offset)
        else:
            writing.write(one.clip, found.clip_options, clip, found.warp, one.output, stages)
    if outputs.explain is not None and found.search is not None:
        with stages.stage("write", "writing"):
            write_bytes(outputs.explain, found.search.explain().to_csv().encode(), overwrite=outputs.force)
    if outputs.save is not None:
        with stages.stage("write", "writing"):
            write_warp(found.warp, outputs.save, overwrite=outputs.force)
    if outputs.plot is not None:
        with stages.stage("plot", "drawing"):
            _draw(found, outputs.plot, overwrite=outputs.force)
    return slip


def _draw(found: FoundWarp, place: Path, *, overwrite: bool) -> None:
    """Draw the warp beside what an animator has today."""
    from retime.evaluate.plot.warps import plot_with_baselines

    explanation = None if found.search is None else found.search.explain()
    plot_with_baselines(
        found.warp, found.clip, method=found.method, explanation=explanation, path=place, overwrite=overwrite
    )


def _document(
    found: FoundWarp,
    outputs: OutputOptions,
    stages: Stages,
    facts: dict[str, Any],
    slip: dict[str, float | bool] | None,
) -> dict[str, Any]:
    """Collect what --json prints; the search's numbers are null where there was none."""
    search = found.search
    seconds = dict(stages.seconds)
    if search is not None:
        # The search says itself how long each of its stages took.
        del seconds["search"]
        seconds = {"read": seconds.pop("read"), **search.seconds, **seconds}
    # Nothing is left out: what no stage names, such as the programs that a first use loads, is the rest. (Variants
    # share one search, which was as long as all of theirs.)
    named = stages.seconds if "variant" in facts else seconds
    seconds["other"] = max(0.0, stages.elapsed() - sum(named.values()))

    def text(path: Path | None) -> str | None:
        return None if path is None else str(path)

    return {
        "method": found.method,
        "input": str(found.path),
        **facts,
        "input_frames": found.clip.n_frames,
        "input_rate": float(found.clip.rate),
        "input_seconds": found.clip.duration,
        "output_frames": found.n_output_frames,
        "output_rate": float(found.clip.rate),
        "output_seconds": float(found.n_output_frames / found.clip.rate),
        "n_input": None if search is None else search.n_input,
        "n_output": None if search is None else search.n_output,
        "n_reference": None if search is None else search.n_reference,
        "max_skip": None if search is None else search.max_skip,
        "n_neighbors": None if search is None else search.n_neighbors,
        "rate": None if search is None else search.rate,
        "upsample": None if search is None else search.upsample,
        "upsamples": None if search is None else list(search.reduction.upsamples),
        "total": None if search is None else search.total,
        "lower_bound": None if search is None else search.path.lower_bound,
        "optimal": None if search is None else search.path.optimal,
        "excess": None if search is None else search.excess,
        "path": None if search is None else search.path.frames.tolist(),
        "slip": slip,
        "seconds": seconds,
        "output": text(outputs.output),
        "warp": text(outputs.save),
        "plot": text(outputs.plot),
        "explain": text(outputs.explain),
        "also": [str(one.output) for one in outputs.also],
    }


def _say_summary(
    found: FoundWarp, outputs: OutputOptions, beside: list[Path], slip: dict[str, float | bool] | None
) -> None:
    from retime.cli import summary
    from retime.evaluate.metrics.flights import flight_spans

    clip, search = found.clip, found.search
    last_frame = clip.first_frame + clip.n_frames - 1
    share = found.n_output_frames / clip.n_frames
    rows = [
        (
            "input",
            f"{found.path}, frames {clip.first_frame}:{last_frame}: "
            f"{summary.length_text(clip.n_frames, clip.rate)} at {summary.rate_text(clip.rate)}",
        ),
        ("output", f"{summary.length_text(found.n_output_frames, clip.rate)} ({share:.1%} of the input)"),
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
    if search is not None and search.example is not None:
        rows.append(("example", summary.example_text(search.example)))
    rows.append(("speed", summary.speed_text(found.warp)))
    spans = flight_spans(clip)
    if spans:
        rows.append(("flights", summary.flights_text(found.warp if search is None else search.staircase, spans)))
    if search is not None and search.excess is not None:
        rows.append(("excess", f"{search.excess:.2%} over the optimum (heuristic search)"))
    if slip is not None:
        rows.append(("slip", summary.slip_text(slip)))
    rows += [("wrote", str(place)) for place in (*outputs.places, *beside)]
    say_table(rows)
    if not outputs.places:
        say(
            "Nothing was written. To keep the result: -o OUT (the retimed clip), --save WARP.json (the warp), "
            "--plot WARP.svg (a picture)."
        )
