"""Short runs of the fuzz scripts, which are commands of their own (see docs/reliability.md)."""

from __future__ import annotations

import sys
from importlib.util import find_spec

import pytest

from tests.fuzz import captures, documents, files, keypoints
from tests.fuzz.trials import Tally, run


def ended_well(tally: Tally, *expected: str) -> None:
    assert tally.faults == {}
    # All of one kind would say nothing.
    for end in expected:
        assert tally.ends[end] > 0, f"no trial ended so: {end}; {tally.ends}"


def test_mutants_of_files_are_read_or_refused() -> None:
    read = [f"{suffix} is read" for suffix in (".bvh", ".amc", ".csv", ".npz", ".csv.gz", ".npz.bz2")]
    ended_well(run(files.trial, range(500)), "FormatError", *read, "a warp is applied")


def test_mutants_of_captures_are_retimed_or_refused() -> None:
    ended_well(
        run(captures.trial, range(500)), "FormatError", *(f"{kind} is retimed" for kind in ("c3d", "npz", "npy"))
    )


def test_mutants_of_keypoints_are_read_or_refused() -> None:
    ended_well(run(keypoints.trial, range(200)), "FormatError", "OpenPose is read", "MediaPipe is read")


@pytest.mark.skipif(find_spec("pyarrow") is None, reason="needs pyarrow")
def test_mutants_of_parquet_are_read_or_refused() -> None:
    from tests.fuzz import parquet_files

    tally = run(parquet_files.trial, range(10), most_seconds=parquet_files.MOST_SECONDS)
    ended_well(tally, "FormatError", ".parquet is read")


def test_random_documents_are_solved_or_refused() -> None:
    ended_well(run(documents.trial, range(45)), "FormatError", "guided is solved")


@pytest.mark.skipif(sys.platform == "win32", reason="pipes, devices and links of POSIX")
def test_hostile_folders_keep_what_they_hold() -> None:
    from tests.fuzz import folders

    ended_well(
        run(folders.trial, range(100)),
        ".bvh is written",
        ".retime is written",
        "all edits are safe",
        "FileNotFoundError",
    )


@pytest.mark.skipif(
    any(find_spec(package) is None for package in ("starlette", "uvicorn", "websockets")),
    reason="needs the packages that serve",
)
def test_hostile_messages_end_no_editor() -> None:
    from tests.fuzz import server_messages

    ended_well(run(server_messages.trial, range(5), most_seconds=server_messages.MOST_SECONDS), "goes on")


@pytest.mark.skipif(sys.platform == "win32", reason="a kill of POSIX")
def test_kills_lose_nothing_that_was_acknowledged() -> None:
    from tests.fuzz import kills

    tally = run(kills.trial, range(3), most_seconds=60)
    assert tally.faults == {}


def test_what_must_not_be_is_told_with_its_seed() -> None:
    def trial(draw) -> str:
        if draw.random() < 0.5:
            raise ZeroDivisionError("oh")
        return "well"

    tally = run(trial, range(20))
    assert 0 < len(tally.faults) == tally.ends["fault"] < 20
    seed, words = next(iter(tally.faults.items()))
    assert words.startswith("ZeroDivisionError: oh")
    assert list(run(trial, [seed]).faults) == [seed]
