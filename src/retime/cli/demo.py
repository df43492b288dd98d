"""`retime demo`: the sample clip, retimed."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from retime.cli.clip_options import PATH
from retime.cli.help_sections import Option, SectionedCommand
from retime.cli.output_checks import check_outputs
from retime.cli.terminal import Stages, say

if TYPE_CHECKING:
    from retime.motion.motion import Motion
    from retime.warp.curve import Warp

LENGTH = "65%"


@click.command("demo", cls=SectionedCommand, short_help="Retime the sample clip, and show what was kept.")
@click.option(
    "--out",
    cls=Option,
    metavar="DIR",
    type=PATH,
    default="retime-demo",
    default_text="retime-demo",
    help="Folder to write to; made if it is not there.",
)
@click.option("--force", cls=Option, is_flag=True, help="Replace files that are there.")
def command(*, out: Path, force: bool) -> None:
    """Retime the sample clip, and show what was kept and what was squeezed.

    A figure stands, walks, pauses, crouches and jumps; the output has 65 % of its length. Writes the sample, the
    retimed motion, the warp and, where matplotlib is there (extra plot), its picture.
    """
    names = ["sample.bvh", "shorter.bvh", "warp.json"]
    pictures = ["warp.svg", "warp.png"] if importlib.util.find_spec("matplotlib") is not None else []
    places = {name: out / name for name in names + pictures}
    if not out.exists():
        out.mkdir(parents=True)
    check_outputs(places, inputs=[], force=force)

    from retime.files import write_bytes
    from retime.formats.registry import read, write
    from retime.formats.warp_file import write_warp
    from retime.motion.motion import Motion
    from retime.search.guided import guided_warp
    from retime.warp.apply import apply_warp
    from retime.warp.spline import linear_warp

    stages = Stages()
    with stages.stage("read", "reading"):
        write_bytes(places["sample.bvh"], _shipped("sample.bvh"), overwrite=force)
        motion = read(places["sample.bvh"])
    assert isinstance(motion, Motion)
    with stages.stage("search", "searching"):
        found = guided_warp(motion, length=LENGTH)
    linear = linear_warp(found.warp.keytimes)
    with stages.stage("write", "writing"):
        write(apply_warp(motion, found.warp), places["shorter.bvh"], overwrite=force)
        write_warp(found.warp, places["warp.json"], overwrite=force)
    for name in pictures:
        from retime.evaluate.plot.warps import plot_warps

        with stages.stage("plot", "drawing"):
            warps = {"linear": linear, "guided": found.warp}
            plot_warps(warps, motion=motion, path=places[name], title="sample", overwrite=force)

    _say_what_was_kept(motion, json.loads(_shipped("sample_phases.json")), linear, found.warp)
    say("")
    for place in places.values():
        say(f"wrote {place}")
    if not pictures:
        say("No picture: that needs matplotlib, pip install 'retime[plot]'.")


def _shipped(name: str) -> bytes:
    """Read a file of the sample that comes with retime."""
    import importlib.resources

    return importlib.resources.files("retime").joinpath("data", name).read_bytes()


def _say_what_was_kept(motion: Motion, phases: list[dict[str, Any]], linear: Warp, guided: Warp) -> None:
    """Print how long each phase lasts in the input, and in the output by either warp."""
    from retime.cli.summary import flights_text, idle_spans, output_seconds
    from retime.evaluate.metrics.flights import flight_spans

    rate = float(motion.rate)
    rows = []
    for phase in phases:
        # A phase ends where the next one begins; the last one with the clip, whose last frame is shown too.
        rows.append((phase["name"], [(phase["first_frame"] / rate, (phase["last_frame"] + 1) / rate)]))
    rows += [("standing still, in all", idle_spans(motion)), ("the whole clip", [(0.0, motion.duration)])]
    say(f"The sample at {LENGTH} of its length: seconds in the input, and in the output by either warp\n")
    say(f"{'':22}{'input':>8}{'linear':>8}{'guided':>8}")
    for label, spans in rows:
        times = [
            sum(end - start for start, end in spans),
            sum(output_seconds(linear, *span, motion) for span in spans),
            sum(output_seconds(guided, *span, motion) for span in spans),
        ]
        say(f"{label:22}" + "".join(f"{seconds:8.2f}" for seconds in times))
    flights = flight_spans(motion)
    say(f"\nflights, linear: {flights_text(linear, flights)}")
    say(f"flights, guided: {flights_text(guided, flights)}")
