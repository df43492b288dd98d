"""``python -m study --data FOLDER``: runs the study on a folder of captures, and writes what came out."""

from __future__ import annotations

import argparse
import importlib.util
import sys
import time
from pathlib import Path

from retime.errors import MissingExtraError, OptionError, RetimeError
from study.clips.library import Library
from study.clips.sources import missing_files
from study.report.write import write_study
from study.run import PARTS, chosen_parts, run

_ABOUT = """Run the paper's eight evaluations on real motion, and write what came out: a page that plays every
result beside what else one could do (it stands alone: open it in a browser), pictures, and all numbers as JSON."""


def main() -> None:
    """Run what was asked for; end with a message where it can't be done."""
    parser = argparse.ArgumentParser(prog="python -m study", description=_ABOUT)
    parser.add_argument(
        "--data", metavar="DIR", type=Path, required=True, help="folder of captures: docs/study says which"
    )
    parser.add_argument("--only", metavar="PARTS", help=f"some parts, with commas between them: {', '.join(PARTS)}")
    parser.add_argument(
        "--quick", action="store_true", help="time everything once, and compare the main settings alone"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("out/study"),
        help="folder to write to, out/study by default; what an earlier run left there is replaced",
    )
    options = parser.parse_args()
    try:
        study(options.data, options.out, only=options.only, quick=options.quick)
    except OptionError as error:
        parser.error(str(error))
    except RetimeError as error:
        sys.exit(f"error: {error}")
    except OSError as error:
        sys.exit(f"error: {error.filename}: {error.strerror}" if error.filename else f"error: {error}")


def study(data: Path, out: Path, *, only: str | None, quick: bool) -> None:
    """Run some parts, or all, and write them; say what is at work, and where things went.

    Raises
    ------
    OptionError
        There is no such part.
    FileNotFoundError
        The data folder lacks a file.
    MissingExtraError
        Nothing can draw the pictures.
    """
    start = time.perf_counter()
    parts = chosen_parts(only)
    # Better said now than after a minute's work.
    if importlib.util.find_spec("matplotlib") is None:
        raise MissingExtraError("the study's pictures", package="matplotlib", extra="plot")
    missing = missing_files(data)
    if missing:
        raise FileNotFoundError(2, f"the study needs this file ({len(missing)} missing)", str(missing[0]))
    results = run(Library(data), parts, quick=quick, say=lambda part: print(f"running: {part}", flush=True))
    written = write_study(results, out)
    for place in (written.page, written.numbers, *written.figures):
        print(f"wrote {place}")
    print(f"It took {time.perf_counter() - start:.0f} s.")


if __name__ == "__main__":
    main()
