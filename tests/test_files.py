"""What an output may replace: regular files, also through a link, and nothing else."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from retime.errors import FormatError, OptionError
from retime.files import resolved, write_bytes

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pipes and links of POSIX")


@pytest.mark.parametrize("overwrite", [True, False])
@pytest.mark.parametrize("linked", [True, False])
def test_a_pipe_is_never_renamed_over(tmp_path: Path, overwrite: bool, linked: bool) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    place = tmp_path / "out.bvh" if linked else pipe
    if linked:
        place.symlink_to(pipe)
    with pytest.raises((FormatError, FileExistsError)):
        write_bytes(place, b"new", overwrite=overwrite)
    assert stat.S_ISFIFO(pipe.lstat().st_mode)
    assert place.is_symlink() == linked
    assert not list(tmp_path.glob(".retime-*"))


def test_a_link_is_written_through(tmp_path: Path) -> None:
    target, link = tmp_path / "target", tmp_path / "link"
    target.write_bytes(b"old")
    link.symlink_to(target)
    write_bytes(link, b"new", overwrite=True)
    assert link.is_symlink()
    assert target.read_bytes() == b"new"


@pytest.mark.parametrize("overwrite", [True, False])
def test_a_circle_of_links_is_refused_and_stays(tmp_path: Path, overwrite: bool) -> None:
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(OSError, match="symbolic links"):
        write_bytes(tmp_path / "a", b"new", overwrite=overwrite)
    assert (tmp_path / "a").readlink() == Path("b")
    assert resolved(tmp_path / "a").parent == tmp_path.resolve()


def test_a_name_with_a_nul_is_no_path() -> None:
    with pytest.raises(OptionError, match="no file can have such a name"):
        resolved("a\0b")


WRITER = """
import os, sys
from retime.files import write_bytes
def parts():
    yield b"begun"
    print("writing", flush=True)
    sys.stdin.readline()
    yield b" and done"
write_bytes(sys.argv[1], parts(), overwrite=True)
"""


def begun(place: Path) -> subprocess.Popen[str]:
    """Start a process that is in the middle of writing a file."""
    process = subprocess.Popen(
        [sys.executable, "-c", WRITER, str(place)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "writing\n"
    return process


def age(path: Path, seconds: float) -> None:
    then = path.stat().st_mtime - seconds
    os.utime(path, (then, then))


def test_what_dead_writers_left_is_removed_and_what_living_ones_write_is_not(tmp_path: Path) -> None:
    dead, living = begun(tmp_path / "dead.bvh"), None
    try:
        (left,) = tmp_path.glob(".retime-*.tmp")
        dead.kill()
        dead.wait(30)
        fresh = tmp_path / f".retime-{'0' * 16}.tmp"
        fresh.write_bytes(b"a moment ago")
        living = begun(tmp_path / "living.bvh")
        (written,) = set(tmp_path.glob(".retime-*.tmp")) - {left, fresh}
        # None of these is a file that write_bytes makes.
        strangers = [tmp_path / name for name in (".retime-notes.tmp", f"x.retime-{'1' * 16}.tmp")]
        for path in strangers:
            path.write_bytes(b"a person's")
        link = tmp_path / f".retime-{'2' * 16}.tmp"
        link.symlink_to(strangers[0])
        for path in (left, written, *strangers):
            age(path, 3600)
        write_bytes(tmp_path / "out.bvh", b"new", overwrite=False)
        assert not left.exists()
        assert all(path.exists() for path in (fresh, written, *strangers))
        assert link.is_symlink()
        living.communicate("\n", timeout=30)
        assert living.returncode == 0
        assert (tmp_path / "living.bvh").read_bytes() == b"begun and done"
    finally:
        for process in (dead, living):
            if process is not None:
                process.kill()
                process.communicate()


def test_a_folder_that_can_not_be_tidied_is_written_to(tmp_path: Path, monkeypatch) -> None:
    left = tmp_path / f".retime-{'0' * 16}.tmp"
    left.write_bytes(b"")
    age(left, 3600)

    def refused(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "unlink", refused)
    write_bytes(tmp_path / "out.bvh", b"new", overwrite=True)
    assert (tmp_path / "out.bvh").read_bytes() == b"new"
