"""A clip handed to retime's own editor, and its timing taken back. bpy is not needed."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Sequence
from pathlib import Path

from retime.errors import OptionError, words_of
from retime.motion.motion import Motion
from retime.project.document import ClipFile, Document, Key, LockedTime
from retime.project.file import project_bytes, read_project, save_project
from retime.project.from_memory import file_of
from retime.project.solve import DocumentSolver

from .animated import Thing
from .asked import Asked
from .job import wanted_of, what_moves, write_curve
from .retiming import retime
from .sampling import rate_of
from .timing import Timing
from .wording import summary

# Seconds that the editor may take until it says at what address it is; a slower one goes on by itself.
_LONGEST = 10.0


def write_project(asked: Asked, folder: Path, root: str) -> Path:
    """Write the clips, and what is asked of them, as a project of the editor.

    Parameters
    ----------
    asked : Asked
        Its first frame stands in the project's name, for the way back.
    folder : Path
        Where to.
    root : str
        The bone that carries the body; "" where it is found.

    Returns
    -------
    Path
        The project.
    """
    files = [file_of(clip, folder / "clips") for clip in asked.clips]
    clips = tuple(
        ClipFile(str(path), up="z" if isinstance(clip, Motion) else None, root=root or None)
        for path, clip in zip(files, asked.clips, strict=True)
    )
    keys = tuple(Key(f"key{i}", asked.seconds(frame), asked.seconds(to)) for i, (frame, to, _) in enumerate(asked.keys))
    locks = tuple(
        LockedTime(f"lock{i}", asked.seconds(start), asked.seconds(end))
        for i, (start, end, _) in enumerate(asked.locks)
    )
    document = Document(clips, keys=keys, locks=locks, options=dict(asked.given))
    place = folder / f"{files[0].parent.name}_from_{asked.start:.0f}.retime"
    save_project(place, project_bytes(document, {}, folder), overwrite=True)
    return place


def launch(command: str, project: Path) -> None:
    """Start the editor on a project, and wait until it serves its page.

    Parameters
    ----------
    command : str
        The retime command.
    project : Path
        What it says stands beside it, in a file ``.log``.

    Raises
    ------
    OptionError
        There is no such command, or it ended with an error.
    """
    log = project.with_suffix(".log")
    try:
        with log.open("wb") as out:
            process = subprocess.Popen(
                [command, "edit", "--project", str(project)], cwd=project.parent, stdout=out, stderr=subprocess.STDOUT
            )
    except OSError as error:
        raise OptionError(
            f"{words_of(error)}: name the retime command in the preferences of this extension", option="editor"
        ) from None
    until = time.monotonic() + _LONGEST
    while process.poll() is None and time.monotonic() < until and b"http" not in log.read_bytes():
        time.sleep(0.05)
    if process.poll():
        said = log.read_text(encoding="utf-8", errors="replace").strip().rpartition("\n")[2]
        raise OptionError(
            f"the editor did not start: {said or f'{command} ended with {process.returncode} and said nothing'}. It "
            "needs retime of this version: pip install 'retime[edit]'",
            option="editor",
        )


def take_back(data: Thing, scene: Thing, objects: Sequence[Thing], settings: Thing, project: Path) -> list[str]:
    """Give objects the timing of a project as it was saved; return what is to be said.

    Raises
    ------
    RetimeError, OSError
        It is no project, or can't be solved.
    """
    objects = what_moves(objects)
    start = project.stem.rpartition("_from_")[2]
    if not start.lstrip("-").isdigit():
        raise OptionError(
            f"{project.name} was not opened from here: its name does not say the first frame", option="project"
        )
    solution = DocumentSolver().solve(read_project(project).document)
    timing = Timing.of_seconds(solution.warp, float(start), rate_of(scene))
    if settings.tolerance > 0:
        timing = timing.simplified(settings.tolerance)
    report = retime(data, objects, scene, timing, wanted_of(settings))
    write_curve(scene, timing)
    return [*summary(timing, solution.sources.clips[0], solution.search), *report.lines()]
