"""Mutants of files of every kind: each is read as something valid, or refused as retime refuses.

    python -m tests.fuzz.files --kind bvh --count 2000000 --seed 1
    python -m tests.fuzz.files --kind bvh --only 17

A process of its own tries a block of seeds, in bounds of time and memory; a line is printed for every so many. A run
that was ended goes on with the seed after the last that it told of.
"""

from __future__ import annotations

import importlib
import sys
import warnings

from tests.fuzz import captures, curves, keypoints, scenes, text_files
from tests.fuzz.trials import Trial, arguments, run_told

# Files of a few hundred bytes hold no more than this, whatever they say of themselves.
MOST_BYTES = 256 << 20
# Those that other packages are needed for, by their modules.
_OTHERS = {"usd": "usd_scenes", "parquet": "parquet_files"}
KINDS: dict[str, Trial] = {**text_files.KINDS, **keypoints.KINDS, **curves.KINDS, **captures.KINDS, **scenes.KINDS}


def trial_of(kind: str) -> Trial:
    """Return what tries a kind."""
    if kind in _OTHERS:
        return importlib.import_module(f"tests.fuzz.{_OTHERS[kind]}").KINDS[kind]  # type: ignore[no-any-return]
    return KINDS[kind]


def main() -> int:
    """Run from a shell."""
    parser = arguments(__doc__)
    parser.add_argument("--kind", choices=[*KINDS, *_OTHERS], required=True)
    given = parser.parse_args()
    # What other packages do is done by processes with bounds of their own.
    most_bytes = None if given.kind in _OTHERS else MOST_BYTES
    return run_told(trial_of(given.kind), given, name=given.kind, most_bytes=most_bytes)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(main())
