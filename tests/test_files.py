"""What an output may replace: regular files, also through a link, and nothing else."""

from __future__ import annotations

import os
import stat
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
