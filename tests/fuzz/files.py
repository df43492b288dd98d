"""Mutants of files of every kind: each is read as something valid, or refused as retime refuses.

    python -m tests.fuzz.files --kind bvh --count 2000000 --seed 1
    python -m tests.fuzz.files --kind bvh --only 17

A process of its own tries a block of seeds, in bounds of time and memory; a line is printed for every so many. A run
that was ended goes on with the seed after the last that it told of.
"""

from __future__ import annotations

import importlib
import sys
import tempfile
import time
import warnings

from tests.fuzz import captures, curves, keypoints, scenes, text_files
from tests.fuzz.trials import Tally, Trial, arguments, run_apart, tell

# Those that other packages are needed for, by their modules.
_OTHERS = {"usd": "usd_scenes", "parquet": "parquet_files"}
KINDS: dict[str, Trial] = {**text_files.KINDS, **keypoints.KINDS, **curves.KINDS, **captures.KINDS, **scenes.KINDS}
# How often a long run says how far it is.
_PRINT_SECONDS = 60


def trial_of(kind: str) -> Trial:
    """Return what tries a kind."""
    if kind in _OTHERS:
        return importlib.import_module(f"tests.fuzz.{_OTHERS[kind]}").KINDS[kind]  # type: ignore[no-any-return]
    return KINDS[kind]


def main() -> int:
    """Run from a shell."""
    parser = arguments(__doc__)
    parser.add_argument("--kind", choices=[*KINDS, *_OTHERS], required=True)
    parser.add_argument("--block", type=int, default=10_000, help="seeds of one process")
    given = parser.parse_args()
    seeds = range(given.seed, given.seed + given.count) if given.only is None else range(given.only, given.only + 1)
    trial = trial_of(given.kind)
    told_at = time.monotonic()

    def told(part: range, tally: Tally) -> None:
        nonlocal told_at
        for seed, fault in tally.faults.items():
            print(f"{given.kind}, seed {seed}: {fault}", flush=True)
        if time.monotonic() - told_at > _PRINT_SECONDS:
            told_at = time.monotonic()
            print(f"{given.kind}: done up to seed {part.stop - 1}", flush=True)

    begun = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="retime-fuzz-") as folder:
        # What a process that died has left goes with it.
        tempfile.tempdir = folder
        tally = run_apart(trial, seeds, block=given.block, told=told)
        tempfile.tempdir = None
    print(
        f"{given.kind}, seeds {seeds.start} to {seeds.stop - 1}: {tally.seconds:.0f} s of the processor in "
        f"{time.monotonic() - begun:.0f} s, at most {tally.peak / 2**20:.0f} MB"
    )
    tally.faults = {seed: fault.partition("\n")[0] for seed, fault in tally.faults.items()}
    return tell(tally)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    sys.exit(main())
