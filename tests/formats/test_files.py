"""Whole files in and out: limits before reading, the old file or the new one after writing."""

from __future__ import annotations

import errno
import os
import random
import re
import stat
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from retime import files as files_module
from retime.errors import FormatError, OptionError, OutputExistsError
from retime.files import read_bytes, write_bytes
from retime.formats import Limits, read
from retime.formats.compressed import read_plain
from retime.formats.file_signatures import foreign_kind
from retime.formats.text_lines import Lines, without_byte_order_mark
from retime.kernels import compiled_available, read_file

POSIX = pytest.mark.skipif(os.name == "nt", reason="needs POSIX files")


def test_reading_up_to_the_limit(tmp_path: Path) -> None:
    path = tmp_path / "data"
    path.write_bytes(b"x" * 10)
    assert read_bytes(path, 10) == b"x" * 10
    with pytest.raises(FormatError, match=r"the file has 10 bytes, the limit is 9 \(Limits\.file_bytes\)"):
        read_bytes(path, 9)


@pytest.mark.parametrize("threads", [1, 2, 5])
@pytest.mark.parametrize("n_bytes", [(4 << 20) - 1, 4 << 20, (11 << 20) + 12_345])
def test_a_long_file_is_read_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, n_bytes: int, threads: int) -> None:
    monkeypatch.setenv("RETIME_THREADS", str(threads))
    path = tmp_path / "data"
    data = random.Random(n_bytes).randbytes(n_bytes)
    path.write_bytes(data)
    assert read_plain(path, Limits()) == data
    assert read_plain(path, Limits(file_bytes=n_bytes)) == data
    with pytest.raises(FormatError, match=rf"the file has {n_bytes} bytes, the limit is {n_bytes - 1} "):
        read_plain(path, Limits(file_bytes=n_bytes - 1))


@pytest.mark.skipif(not compiled_available(), reason="the compiled kernels were not built")
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has these pages")
def test_a_long_file_may_end_early_or_fail(tmp_path: Path) -> None:
    """As one does that is cut while it is read, and one on a disk that fails."""
    path = tmp_path / "data"
    for n_bytes in (0, 1, 5 << 20):
        data = random.Random(n_bytes).randbytes(n_bytes)
        path.write_bytes(data)
        with path.open("rb") as file:
            for most in {max(0, n_bytes - 1), n_bytes, n_bytes + 1, n_bytes + (9 << 20)}:
                assert read_file(file.fileno(), most) == data[:most]
    with path.open("ab") as file, pytest.raises(OSError, match=re.escape(os.strerror(errno.EBADF))):
        read_file(file.fileno(), 10)
    folder = os.open(tmp_path, os.O_RDONLY)
    try:
        with pytest.raises(IsADirectoryError):
            read_file(folder, 10)
    finally:
        os.close(folder)


@POSIX
def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(FormatError, match="this is not a regular file"):
        read_bytes(tmp_path / "pipe")


def test_a_missing_file_is_the_system_s_own_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "none.bvh")


def test_an_unknown_ending_lists_the_known(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"no format ends in '\.xyz'; known endings are \.bvh, \.amc, "):
        read(tmp_path / "motion.xyz")
    with pytest.raises(FormatError, match="the name has no ending"):
        read(tmp_path / "motion")


def test_a_rate_that_is_none(tmp_path: Path) -> None:
    with pytest.raises(OptionError):
        read(tmp_path / "motion.bvh", rate="fast")


def test_too_little_memory_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "motion.bvh"
    path.write_bytes(b"HIERARCHY")

    def run_out(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("retime.formats.bvh.parse_hierarchy", run_out)
    with pytest.raises(FormatError, match="too little memory"):
        read(path)


def test_writing_and_replacing(tmp_path: Path) -> None:
    path = tmp_path / "out"
    write_bytes(path, b"one", overwrite=False)
    with pytest.raises(OutputExistsError):
        write_bytes(path, b"two", overwrite=False)
    assert path.read_bytes() == b"one"
    write_bytes(path, iter([b"tw", b"o"]), overwrite=True)
    assert path.read_bytes() == b"two"
    assert list(tmp_path.iterdir()) == [path]


def test_a_failure_halfway_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "out"
    path.write_bytes(b"old")

    def parts() -> Iterator[bytes]:
        yield b"new" * 10_000
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_bytes(path, parts(), overwrite=True)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_parts_are_not_asked_for_where_the_file_may_not_be_written(tmp_path: Path) -> None:
    path = tmp_path / "out"
    path.write_bytes(b"old")
    asked = []

    def parts() -> Iterator[bytes]:
        asked.append(True)
        yield b"new"

    with pytest.raises(OutputExistsError):
        write_bytes(path, parts(), overwrite=False)
    assert not asked


def test_a_file_that_appears_meanwhile_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "out"

    def parts() -> Iterator[bytes]:
        path.write_bytes(b"somebody else's")
        yield b"new"

    with pytest.raises(OutputExistsError):
        write_bytes(path, parts(), overwrite=False)
    assert path.read_bytes() == b"somebody else's"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_system_without_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_links(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(files_module.os, "link", no_links)
    path = tmp_path / "out"
    write_bytes(path, b"one", overwrite=False)
    assert path.read_bytes() == b"one"

    def parts() -> Iterator[bytes]:
        (tmp_path / "other").write_bytes(b"somebody else's")
        yield b"new"

    with pytest.raises(OutputExistsError):
        write_bytes(tmp_path / "other", parts(), overwrite=False)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["other", "out"]


def test_a_missing_folder(tmp_path: Path) -> None:
    # Nobody knows the name that is written under before.
    with pytest.raises(FileNotFoundError) as missing:
        write_bytes(tmp_path / "none/out", b"one", overwrite=False)
    assert missing.value.filename == str(tmp_path / "none/out")


@POSIX
def test_permissions_are_kept_and_new_files_follow_the_mask(tmp_path: Path) -> None:
    path = tmp_path / "out"
    path.write_bytes(b"old")
    path.chmod(0o640)
    write_bytes(path, b"new", overwrite=True)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    mask = os.umask(0o027)
    try:
        write_bytes(tmp_path / "fresh", b"new", overwrite=False)
    finally:
        os.umask(mask)
    assert stat.S_IMODE((tmp_path / "fresh").stat().st_mode) == 0o640


@POSIX
def test_a_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "real").write_bytes(b"old")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    write_bytes(tmp_path / "link", b"new", overwrite=True)
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_bytes() == b"new"


def test_a_name_as_long_as_a_name_may_be(tmp_path: Path) -> None:
    write_bytes(tmp_path / ("語" * 85), b"one", overwrite=False)
    assert (tmp_path / ("語" * 85)).read_bytes() == b"one"


def test_ordinary_bytes_are_nothing_foreign() -> None:
    assert foreign_kind(b"") is None
    assert foreign_kind(b"hello") is None


def test_bytes_without_a_mark_stay_as_they_are() -> None:
    data = "HIERARCHY é".encode("latin-1")
    assert without_byte_order_mark("x", data) is data


def test_lines_and_tokens() -> None:
    lines = Lines(b"one two\r\n\rthree\n", "x", Limits())
    assert lines.token() == b"one"
    assert lines.token_on_line() == b"two"
    assert lines.column_of(b"two") == 5
    assert lines.token_on_line() is None
    assert not lines.at_end()
    assert lines.token() == b"three"
    assert lines.number == 3
    lines.put_back(b"three")
    assert lines.rest() == b"three"
    assert lines.at_end()
    assert lines.token() is None
