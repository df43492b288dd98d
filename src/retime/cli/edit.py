"""`retime edit`: open the editor's page on a clip."""

from __future__ import annotations

import contextlib
import importlib.util
from pathlib import Path

import click

from retime.cli.clip_options import PATH
from retime.cli.sections import Option, SectionedCommand
from retime.cli.terminal import say
from retime.errors import MissingExtraError

_EXAMPLES = "\b\nExamples\n  retime edit walk.bvh\n  retime edit walk.bvh --reference limp.bvh"


@click.command("edit", cls=SectionedCommand, epilog=_EXAMPLES)
@click.argument("clips", type=PATH, metavar="CLIP...", nargs=-1, required=True)
@click.option(
    "--reference",
    "references",
    cls=Option,
    section="Reference",
    metavar="CLIP",
    type=PATH,
    multiple=True,
    default_text="the clip itself",
    help="Imitate the timing of this clip; repeat for more.",
)
@click.option(
    "--port",
    cls=Option,
    section="Page",
    metavar="N",
    type=click.IntRange(0, 65535),
    default=0,
    default_text="any that is free",
    help="Port of the loopback address.",
)
@click.option("--no-browser", cls=Option, section="Page", is_flag=True, help="Print the address, and open nothing.")
def command(*, clips: tuple[Path, ...], references: tuple[Path, ...], port: int, no_browser: bool) -> None:
    """Edit the timing of CLIP in a page in your browser; others get the same warp.

    The page is served at a loopback address, to this machine alone. Ctrl-C ends it.
    """
    for package in ("starlette", "uvicorn", "websockets"):
        if importlib.util.find_spec(package) is None:
            raise MissingExtraError("the editor", package=package, extra="edit")
    from retime.project.places import Places
    from retime.server.app import Editor, serve
    from retime.server.session import new_document

    files = [path.absolute() for path in (*clips, *references)]
    document = new_document([str(file) for file in files[: len(clips)]], [str(file) for file in files[len(clips) :]])

    def started(address: str) -> None:
        say(f"editing at {address}")
        if not no_browser:
            click.launch(address)

    # Ctrl-C is how it ends.
    with contextlib.suppress(KeyboardInterrupt):
        serve(Editor(Places([Path.cwd()], files), document), port=port, started=started)
