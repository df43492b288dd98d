"""Short runs of the fuzz scripts, which are commands of their own (see docs/reliability.md)."""

from __future__ import annotations

import json
import os
import random
import signal
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.fuzz import documents, files
from tests.fuzz.trials import Tally, run, run_apart


def ended_well(tally: Tally, *expected: str) -> None:
    assert tally.faults == {}
    # All of one kind would say nothing.
    for end in expected:
        assert tally.ends[end] > 0, f"no trial ended so: {end}; {tally.ends}"


# More of them where less of one comes to something.
COUNTS = {"bvh": 800, "npy": 800, "fbx": 80, "fbx-text": 80, "amass": 120, "humanml3d": 120}
# What a mutant can come to beside being refused.
ENDS = {
    "bvh": (".bvh is read", ".bvh is written and read again"),
    "asf": (".asf is read", ".asf carries a motion"),
    "amc": (".amc is read", ".amc is written and read again"),
    "csv": (".csv is read", ".csv is written and read again"),
    "tables": tuple(f"a table is read: {dialect}" for dialect in ("OpenSim table", "Motive export", "TRC markers")),
    "packed": (".bvh.gz is read", ".csv.bz2 is read"),
    "joint-map": ("a joint map is read",),
    "warp": ("a warp is read",),
    "project": ("a project is read",),
    "journal": ("a journal is read",),
    "labels": tuple(f"labels are retimed ({suffix})" for suffix in (".csv", ".json", ".tsv")),
    "recipe": ("a recipe is read (.toml)", "a recipe is read (.csv)", "OptionError"),
    "typed": ("what was typed is taken", "OptionError"),
    "keypoints": ("OpenPose is read", "MediaPipe is read"),
    "npy": ("npy is read",),
    "npz": ("npz is read",),
    "c3d": ("c3d is read", "c3d is retimed"),
    "amass": ("amass is read", "amass is retimed"),
    "humanml3d": ("humanml3d is read", "humanml3d is retimed"),
    "glb": ("a scene is read", "a scene is retimed"),
    "gltf": ("a scene is read", "a scene is retimed"),
    "fbx": ("a scene is read", "a scene is retimed"),
    "fbx-text": ("a scene is read", "a scene is retimed"),
}


@pytest.mark.parametrize("kind", files.KINDS)
def test_mutants_are_read_or_refused(kind: str) -> None:
    ends = ENDS[kind] if kind in ENDS else (f"a curve of {kind.removeprefix('curve-')} is read",)
    tally = run(files.trial_of(kind), range(COUNTS.get(kind, 300)), processor=True)
    ended_well(tally, *ends, *(["FormatError"] if kind != "typed" else []))


@pytest.mark.skipif(find_spec("pyarrow") is None, reason="needs pyarrow")
def test_mutants_of_parquet_are_read_or_refused() -> None:
    ended_well(run(files.trial_of("parquet"), range(10), processor=True), "FormatError", ".parquet is read")


@pytest.mark.extras
@pytest.mark.skipif(
    any(find_spec(package) is None for package in ("av", "cv2", "python_stretch")), reason="needs the extra 'video'"
)
def test_mutants_of_media_are_retimed_or_refused() -> None:
    from tests.fuzz import media_files

    tally = run(media_files.trial, range(1, 16), most_seconds=media_files.MOST_SECONDS)
    ended_well(tally, "FormatError")
    assert any(end.endswith(("is retimed", "is described", "is looked at")) for end in tally.ends)


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


@pytest.mark.skipif(
    any(find_spec(package) is None for package in ("starlette", "uvicorn", "websockets")),
    reason="needs the packages that serve",
)
def test_hostile_requests_are_refused() -> None:
    from tests.fuzz import server_requests

    tally = run(server_requests.trial, range(3), most_seconds=server_requests.MOST_SECONDS)
    ended_well(tally, f"{server_requests.N_REQUESTS} are refused")


@pytest.mark.skipif(sys.platform != "linux", reason="looks at a process as only Linux shows it")
@pytest.mark.skipif(
    any(find_spec(package) is None for package in ("starlette", "uvicorn", "websockets")),
    reason="needs the packages that serve",
)
def test_an_editor_is_edited_in_every_way_and_does_not_grow_by_much() -> None:
    from tests.fuzz import soak

    found = soak.soak(40)
    assert found.edits > 80
    # What it holds for ever, and what the first searches keep for the next.
    assert 0 < found.settled <= found.most < found.settled + (64 << 20)
    assert found.ended <= found.most


@pytest.mark.skipif(sys.platform == "win32", reason="a kill of POSIX")
def test_kills_lose_nothing_that_was_acknowledged() -> None:
    from tests.fuzz import kills

    edited = "an editor is killed after a save was told"
    ended_well(run_apart(kills.trial, range(40)), edited, "a write of .bvh is killed", "a write of .csv is killed")


@pytest.mark.skipif(sys.platform == "win32", reason="a kill of POSIX")
def test_a_batch_that_is_killed_goes_on_where_it_ended(tmp_path: Path) -> None:
    from tests.fuzz import kills

    kills.batches(random.Random(3), tmp_path)


def test_small_searches_cost_as_little_as_any_path() -> None:
    from tests.fuzz import small_optima

    ends = ("a loop is free", "a loop is given", "a length is free", "a length is given", "natural hurry", "aligned")
    ended_well(run(small_optima.trial, range(400), processor=True), *ends, "wishes that no path obeys")


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


def test_a_wait_in_vain_is_told_and_not_counted_as_an_error_that_is_raised_on_purpose() -> None:
    def trial(draw: random.Random) -> str:
        raise TimeoutError("nothing came") if draw.random() < 0.5 else FileNotFoundError("no such file")

    tally = run(trial, range(20))
    assert 0 < len(tally.faults) == tally.ends["fault"] < 20
    assert tally.ends["FileNotFoundError"] == 20 - len(tally.faults)
    assert all(fault.startswith("waited in vain: nothing came") for fault in tally.faults.values())


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs processes that are forks of one another")
def test_a_trial_that_ends_its_process_is_told_with_its_seed_and_the_others_are_made() -> None:
    def trial(draw: random.Random) -> str:
        number = draw.random()
        if number < 0.1:
            os.kill(os.getpid(), signal.SIGKILL)
        return "high" if number > 0.5 else "low"

    told: list[range] = []
    tally = run_apart(trial, range(40), block=10, told=lambda part, _: told.append(part))
    draws = [random.Random(seed).random() for seed in range(40)]
    assert sorted(tally.faults) == [seed for seed in range(40) if draws[seed] < 0.1]
    assert all(fault == "it ended the process, with -9" for fault in tally.faults.values())
    assert tally.ends["high"] == sum(number > 0.5 for number in draws)
    assert tally.ends["low"] == sum(0.1 <= number <= 0.5 for number in draws)
    # Each seed once, whatever was done again.
    assert sorted(seed for part in told for seed in part) == list(range(40))


@pytest.mark.skipif(sys.platform != "linux", reason="a bound of memory that only Linux keeps")
def test_a_trial_that_takes_too_much_is_told() -> None:
    def trial(draw: random.Random) -> str:
        what = draw.randrange(3)
        if what == 0:
            while True:
                # A loop of Python's own, which a handler can leave.
                json.dumps([0] * 100)
        if what == 1:
            bytearray(300 << 20)
        return "well"

    tally = run_apart(trial, range(8), most_seconds=1, most_bytes=100 << 20)
    whats = [random.Random(seed).randrange(3) for seed in range(8)]
    assert set(whats) == {0, 1, 2}
    for seed, what in enumerate(whats):
        assert tally.faults.get(seed, "well").startswith(("TooLongError: more than 1 s", "MemoryError", "well")[what])
