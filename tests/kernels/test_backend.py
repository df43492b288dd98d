"""Which kernels are used, and what is said where those that were meant can't be had."""

from __future__ import annotations

import importlib
import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import pytest

from retime import kernels
from retime.kernels import compiled_available, sources_digest

# Stands for an installation: what it recorded, and whether the compiled module can be loaded.
CHILD = """
import importlib.abc, sys, types

class Broken(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == "retime.kernels._kernels":
            raise ImportError("DLL load failed while importing _kernels")
        return None

record = types.ModuleType("retime.kernels._built")
record.KERNELS = sys.argv[1]
sys.modules["retime.kernels._built"] = record
sys.meta_path.insert(0, Broken())
"""
# Stands for a checkout that got newer sources: the compiled module is there, and knows nothing of what is called now.
OLDER = """
import sys, types

record = types.ModuleType("retime.kernels._built")
record.KERNELS = sys.argv[1]
older = types.ModuleType("retime.kernels._kernels")
older.sources = "those of last week"
sys.modules |= {"retime.kernels._built": record, "retime.kernels._kernels": older}
"""
SOLVE = """
import numpy as np
from retime.search.path import shortest_path
print(shortest_path(np.ones((6, 2, 2)), n_output=4).frames.tolist())
"""
INFO = """
from retime.cli.main import main
main(["info", "--build", *sys.argv[2:]])
"""


def run(
    record: str, then: str, *arguments: str, backend: str = "", installation: str = CHILD
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", installation + then, record, *arguments],
        env=os.environ | {"RETIME_BACKEND": backend},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize(
    ("record", "reason"),
    [("built", "can't be loaded (DLL load failed while importing _kernels)"), ("failed", "install a C++20 compiler")],
)
def test_kernels_that_were_meant_and_can_not_be_had_are_missed_aloud(record: str, reason: str) -> None:
    done = run(record, SOLVE)
    assert done.stdout == "[0, 2, 4, 5]\n"
    assert done.stderr.count("RetimeWarning") == 1
    assert reason in done.stderr
    assert "many times slower" in done.stderr


def test_kernels_of_other_sources_are_not_called() -> None:
    done = run("built", SOLVE, installation=OLDER)
    assert done.stdout == "[0, 2, 4, 5]\n"
    assert done.stderr.count("RetimeWarning") == 1
    assert "of other sources than those beside it): install retime again" in done.stderr
    forced = run("built", SOLVE, installation=OLDER, backend="compiled")
    assert "OptionError: the compiled kernels can't be had" in forced.stderr


@pytest.mark.skipif(not compiled_available(), reason="the compiled kernels are not here")
def test_the_build_and_the_package_tell_sources_alike() -> None:
    folder = Path(kernels.__file__).parent
    assert importlib.import_module("retime.kernels._kernels").sources == sources_digest(folder)


def test_every_change_of_a_source_counts_and_nothing_else(tmp_path: Path) -> None:
    assert sources_digest(tmp_path) == ""
    assert sources_digest(tmp_path / "nowhere") == ""
    (tmp_path / "a.cpp").write_text("int a;\n")
    one = sources_digest(tmp_path)
    (tmp_path / "notes.txt").write_text("b")
    assert sources_digest(tmp_path) == one
    (tmp_path / "a.hpp").write_text("int b;\n")
    assert sources_digest(tmp_path) != one


@pytest.mark.parametrize("record", ["left out", "no CMake"])
def test_kernels_that_nobody_asked_for_are_not_missed(record: str) -> None:
    done = run(record, SOLVE)
    assert (done.stdout, done.stderr) == ("[0, 2, 4, 5]\n", "")


def test_whoever_chose_numpy_is_not_warned() -> None:
    assert run("built", SOLVE, backend="numpy").stderr == ""


def test_asking_for_the_compiled_kernels_by_name_says_why_there_are_none() -> None:
    done = run("built", SOLVE, backend="compiled")
    assert done.returncode
    assert "OptionError: the compiled kernels can't be had: they were built, but can't be loaded" in done.stderr


@pytest.mark.parametrize(
    ("record", "reason"),
    [
        ("built", "can't be loaded (DLL load failed while importing _kernels)"),
        ("failed", "could not be built when retime was installed"),
        ("left out", "RETIME_WITHOUT_KERNELS"),
        ("no CMake", "there was no CMake"),
    ],
)
def test_info_says_why_nothing_is_compiled(record: str, reason: str) -> None:
    done = run(record, INFO)
    assert done.stderr == ""
    row = next(line for line in done.stdout.splitlines() if line.startswith("kernels"))
    assert "none compiled" in row
    assert reason in row
    document = json.loads(run(record, INFO, "--json").stdout)
    assert (document["backend"], document["compiled_available"]) == ("numpy", False)
    assert document["compiled_build"] == record
    assert reason in document["why_not_compiled"]


@pytest.mark.parametrize("backend", ["compiled", "numpy"])
def test_memory_that_was_freed_can_be_kept(backend: str) -> None:
    """Arrays come and go as before; with glibc a second array of a size takes no new pages."""
    if backend == "compiled" and not compiled_available():
        pytest.skip("the compiled kernels are not here")
    child = """
import resource, sys
import numpy as np
import retime.kernels
if sys.argv[1] == "numpy":
    retime.kernels.compiled_available = lambda: False
retime.kernels.keep_freed_memory()
np.ones(5_000_000)
before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
for _ in range(5):
    assert np.ones(5_000_000).sum() == 5e6
print(resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before)
"""
    if sys.platform == "win32":
        pytest.skip("Windows does not count pages")
    done = subprocess.run([sys.executable, "-c", child, backend], capture_output=True, text=True, check=True)
    # Another allocator may stand before glibc's: that of `make sanitize` does.
    if backend == "compiled" and platform.libc_ver()[0] == "glibc" and not os.environ.get("LD_PRELOAD"):
        # One array alone has ten thousand pages, or twenty large ones.
        assert int(done.stdout) < 20
