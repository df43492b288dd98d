"""What Windows and macOS do otherwise with files, names, locks and ports, played here.

Their rules stand in for those of this system. The tests of a matrix of systems run the whole suite there
(.github/workflows/tests.yml); these tell before.
"""

from __future__ import annotations

import errno
import os
import socket
import stat
import sys
import types
from pathlib import Path
from typing import Any

import pytest

import retime
from retime import file_names, files
from retime.batch import manifest, run, tree
from retime.cli import output_checks
from retime.errors import OptionError, OutputExistsError, words_of
from retime.project import allowed_places, journal, workspace
from retime.project.history import History
from retime.server import app
from retime.server.files import keep_dropped
from tests.project.documents import numbered


class OsOf:
    """The module os, by another name of the system."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __getattr__(self, attribute: str) -> Any:
        return getattr(os, attribute)


def is_open(path: Path) -> bool:
    """Whether this process has a file open."""
    real = os.path.realpath(path)
    for handle in Path("/proc/self/fd").iterdir():
        try:
            if str(handle.readlink()) == real:
                return True
        except OSError:
            continue
    return False


@pytest.fixture
def windows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rename, replace and remove as Windows does, lock by msvcrt, and have no fcntl."""
    if not Path("/proc/self/fd").is_dir():
        pytest.skip("which files are open is told by /proc")
    import fcntl

    def refusing(name: str) -> Any:
        inner = getattr(Path, name)

        def call(self: Path, *args: Any, **options: Any) -> Any:
            others = [Path(one) for one in args if isinstance(one, str | Path)]
            for place in (self, *others):
                # Which of two is at fault is not told.
                if is_open(place) or (place.exists() and not place.stat().st_mode & stat.S_IWUSR):
                    raise PermissionError(errno.EACCES, "Access is denied", str(self), None, *map(str, others))
            if name == "rename" and Path(args[0]).exists():
                raise FileExistsError(errno.EEXIST, "there is such a file", str(args[0]))
            return inner(self, *args, **options)

        return call

    for name in ("replace", "rename", "unlink"):
        monkeypatch.setattr(Path, name, refusing(name))

    def locking(handle: int, mode: int, count: int) -> None:
        assert (mode, count) == (2, 1)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise PermissionError(errno.EACCES, "Permission denied") from None

    monkeypatch.setitem(sys.modules, "fcntl", None)
    monkeypatch.setitem(sys.modules, "msvcrt", types.SimpleNamespace(locking=locking, LK_NBLCK=2))
    for module in (files, journal, file_names):
        monkeypatch.setattr(module, "os", OsOf("nt"))


def no_links(*_: Any, **__: Any) -> None:
    raise OSError(errno.EPERM, "no links on this file system")


def test_files_are_written_and_replaced_by_the_rules_of_windows(windows, tmp_path, monkeypatch) -> None:
    place = tmp_path / "out.bvh"
    files.write_bytes(place, b"first", overwrite=False)
    files.write_bytes(place, b"second", overwrite=True)
    assert place.read_bytes() == b"second"
    with pytest.raises(OutputExistsError):
        files.write_bytes(place, b"third", overwrite=False)
    with place.open("rb"), pytest.raises(PermissionError) as open_elsewhere:
        # A viewer has it open: it stays, and nothing is left beside it.
        files.write_bytes(place, b"third", overwrite=True)
    place.chmod(stat.S_IRUSR)
    with pytest.raises(PermissionError) as read_only:
        files.write_bytes(place, b"third", overwrite=True)
    for refused in (open_elsewhere, read_only):
        assert words_of(refused.value) == (
            f"{place}: Access is denied (the file is open in another program, or read only)"
        )
    assert place.read_bytes() == b"second"
    assert [path.name for path in tmp_path.iterdir()] == ["out.bvh"]


def test_a_name_that_is_taken_at_the_last_moment_is_not_replaced(windows, tmp_path, monkeypatch) -> None:
    place = tmp_path / "out.bvh"
    monkeypatch.setattr(os, "link", no_links)
    files.write_bytes(place, b"first", overwrite=False)
    assert place.read_bytes() == b"first"
    place.unlink()
    there = Path.exists

    def taken_meanwhile(self: Path, **options: Any) -> bool:
        found = there(self, **options)
        if self == place and not found and any(tmp_path.glob(".retime-*")):
            place.write_bytes(b"another's")
        return found

    monkeypatch.setattr(Path, "exists", taken_meanwhile)
    with pytest.raises(OutputExistsError):
        files.write_bytes(place, b"ours", overwrite=False)
    assert place.read_bytes() == b"another's"


def test_left_overs_go_on_windows_unless_they_are_open(windows, tmp_path) -> None:
    dead, living = (tmp_path / f".retime-{letter * 16}.tmp" for letter in "ab")
    dead.write_bytes(b"")
    with living.open("wb"):
        files.remove_left_overs(tmp_path)
        assert [path.name for path in tmp_path.iterdir()] == [living.name]
    files.remove_left_overs(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_without_any_locks_nothing_is_removed_and_nobody_kept_out(tmp_path, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "fcntl", None)
    monkeypatch.setitem(sys.modules, "msvcrt", None)
    monkeypatch.setattr(files, "os", OsOf("posix"))
    left = tmp_path / f".retime-{'a' * 16}.tmp"
    left.write_bytes(b"")
    files.remove_left_overs(tmp_path)
    assert left.exists()
    with left.open("ab") as one, left.open("ab") as other:
        assert files.hold(one)
        assert files.hold(other)


def test_one_editor_at_a_time_and_its_edits_are_kept_on_windows(windows, tmp_path) -> None:
    place = tmp_path / "walk.journal"
    mine = journal.Journal(place)
    with pytest.raises(OptionError, match="another editor has this open"):
        journal.Journal(place)
    history = History(numbered(0))
    mine.begin(history, {}, "")
    for number in range(3):
        # Written anew each time: the file that is open is let go of, and opened again.
        mine.begin(history, {}, f"{number}")
    edit = journal.Edit(numbered(1), "to 1", "", True)
    history = history.edit(edit.document, label=edit.label, gesture=edit.gesture, done=edit.done)
    mine.edit(edit, history, {})
    recovered = journal.read_journal(place)
    assert recovered.history == history
    assert recovered.base == "2"
    mine.close()
    again = journal.Journal(place)
    assert again.recover() is not None
    again.close(remove=True)
    assert not place.exists()


def test_a_batch_is_begun_stopped_and_done_again_by_the_rules_of_windows(windows, tmp_path) -> None:
    root, out = tmp_path / "in", tmp_path / "out"
    for name, start in (("walk.bvh", 0), ("deep/run.bvh", 60)):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        retime.write(retime.sample().frames(start, start + 40), root / name)
    first = run(root, out, {"length": "80%"}, workers=0)
    assert [one.status for one in first.records] == ["done", "done"]
    # An earlier run was ended in the middle of a line: its manifest is written anew while it is open to be added to.
    with (out / manifest.MANIFEST).open("ab") as file:
        file.write(b'{"torn')
    with (out / ".retime" / "lock").open("a") as lock:
        assert files.hold(lock)
        with pytest.raises(OptionError, match="another run is at work"):
            run(root, out, {"length": "80%"}, workers=0)
    again = run(root, out, {"length": "80%"}, workers=0)
    assert [one.status for one in again.records] == ["kept", "kept"]
    other = run(root, out, {"length": "70%"}, workers=0)
    assert [one.status for one in other.records] == ["done", "done"]
    assert not list(out.rglob(".retime-*.tmp"))


def test_a_project_is_saved_and_moved_by_the_rules_of_windows(windows, tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("RETIME_STATE", str(tmp_path / "state"))
    clip = tmp_path / "walk.bvh"
    retime.write(retime.sample().frames(0, 40), clip)
    work = workspace.open_document(workspace.new_document([str(clip)]))
    for name in ("one.retime", "two.retime", "two.retime"):
        work.save(tmp_path / name, work.history, work.warps, overwrite=name == "two.retime")
    work.close()
    again = workspace.open_project(tmp_path / "two.retime")
    assert again.history.present == work.history.present
    again.close()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.retime", "state", "two.retime", "walk.bvh"]


def test_a_scratch_file_is_opened_by_another_and_goes(windows, tmp_path) -> None:
    with files.scratch(tmp_path) as file:
        Path(file.name).write_bytes(b"by a child")
        assert file.read() == b"by a child"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "usable"),
    [
        ("con.bvh", "_con.bvh"),
        ("NUL", "_NUL"),
        ("Com1.take.csv", "_Com1.take.csv"),
        ("lpt9 .bvh", "_lpt9 .bvh"),
        ("walk. ", "walk"),
        ("...", "_"),
        ("console.bvh", "console.bvh"),
        ("com10.bvh", "com10.bvh"),
    ],
)
def test_devices_of_windows_are_no_names_of_files(monkeypatch, name, usable) -> None:
    assert file_names.usable_name(name) == name
    monkeypatch.setattr(file_names, "os", OsOf("nt"))
    assert file_names.usable_name(name) == usable


def test_a_dropped_file_with_the_name_of_a_device_gets_another(windows, tmp_path) -> None:
    assert keep_dropped("aux.bvh", b"HIERARCHY", tmp_path).name == "_aux.bvh"


def test_names_that_are_one_file_are_told(monkeypatch, tmp_path) -> None:
    composed, apart = "caf\u00e9.bvh", "cafe\u0301.bvh"
    assert file_names.name_key("Walk.bvh") != file_names.name_key("walk.bvh") or sys.platform in ("darwin", "win32")
    monkeypatch.setattr(file_names, "sys", types.SimpleNamespace(platform="darwin"))
    assert file_names.name_key("Walk.bvh") == file_names.name_key("walk.BVH")
    assert file_names.name_key(composed) == file_names.name_key(apart)
    assert file_names.name_key("walk.bvh") != file_names.name_key("walks.bvh")
    with pytest.raises(OptionError, match="name the same file"):
        output_checks.check_outputs({"-o": tmp_path / "Out.bvh", "--also": tmp_path / "out.bvh"}, inputs=[], force=True)


def test_two_clips_that_would_be_one_file_are_refused(monkeypatch, tmp_path) -> None:
    (tmp_path / "Walk.bvh").write_text("")
    (tmp_path / "walk.csv").write_text("")
    found = tree.find_clips(tmp_path)
    assert len(tree.output_names(found, ".csv")) == 2 or sys.platform in ("darwin", "win32")
    monkeypatch.setattr(file_names, "sys", types.SimpleNamespace(platform="darwin"))
    with pytest.raises(OptionError, match="would both be written as"):
        tree.output_names(found, ".csv")


def test_macos_waits_for_the_disk_and_not_for_the_drive(monkeypatch, tmp_path) -> None:
    fcntl = pytest.importorskip("fcntl", reason="Windows has none")
    called = []
    monkeypatch.setattr(fcntl, "F_FULLFSYNC", 51, raising=False)
    monkeypatch.setattr(fcntl, "fcntl", lambda handle, what: called.append(what))
    files.write_bytes(tmp_path / "a", b"x", overwrite=False)
    assert called == [51]

    def refused(handle: int, what: int) -> None:
        raise OSError(errno.ENOTSUP, "not on this file system")

    synced = []
    monkeypatch.setattr(fcntl, "fcntl", refused)
    monkeypatch.setattr(os, "fsync", synced.append)
    files.write_bytes(tmp_path / "b", b"x", overwrite=False)
    assert synced


def test_no_other_program_takes_the_port_on_windows(monkeypatch) -> None:
    # That option is not here; another that is off stands in for it.
    monkeypatch.setattr(socket, "SO_EXCLUSIVEADDRUSE", socket.SO_KEEPALIVE, raising=False)
    monkeypatch.setattr(app, "sys", types.SimpleNamespace(platform="win32"))
    with app.listen(0) as listener:
        assert listener.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        assert not listener.getsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR)


def test_a_command_to_type_is_quoted_for_the_shell_at_hand(monkeypatch, tmp_path) -> None:
    words = ("retime", "edit", "my walk.bvh", "--folder", "C:\\Clips of Ann")
    assert allowed_places._typed(words) == "retime edit 'my walk.bvh' --folder 'C:\\Clips of Ann'" or os.name == "nt"
    monkeypatch.setattr(allowed_places, "os", OsOf("nt"))
    assert allowed_places._typed(words) == 'retime edit "my walk.bvh" --folder "C:\\Clips of Ann"'


@pytest.mark.parametrize("ending", ["\r\n", "\r", "\n"])
def test_line_ends_of_every_system_are_read(tmp_path, ending) -> None:
    text = "time,x\n0,1\n0.5,2\n1,3\n"
    (tmp_path / "a.csv").write_bytes(text.replace("\n", ending).encode())
    assert retime.read(tmp_path / "a.csv").values[:, 0].tolist() == [1, 2, 3]
