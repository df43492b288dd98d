"""How retime starts and ends: what it imports, its exit codes, and what it prints where."""

from __future__ import annotations

import errno
import importlib.metadata
import json
import os
import pty
import re
import signal
import subprocess
import sys
import warnings
from pathlib import Path

import click
import pytest

from retime.cli.main import COMMANDS, main
from retime.errors import FormatWarning, RetimeWarning
from retime.formats import registry
from tests.cli.conftest import COMMAND

# A warp that is there at once: these tests are not about the search.
QUICK = ("--length", "65%", "--method", "linear", "-o", "out.bvh")
HEAVY = {"numpy", "scipy", "matplotlib"}


def modules_after(*arguments: str) -> set[str]:
    """Run a command, and return the top-level packages and modules of retime that it imported."""
    code = (
        "import sys\nfrom retime.cli.main import main\n"
        f"try:\n    main({list(arguments)!r})\nexcept SystemExit:\n    pass\n"
        "print(*sorted(sys.modules), file=sys.stderr)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return {name if name.startswith("retime") else name.split(".")[0] for name in run.stderr.split()}


@pytest.mark.parametrize(
    "arguments",
    [
        ["--help"],
        ["--version"],
        ["warp", "--help"],
        ["info", "--help"],
        ["apply"],
        ["warp", "x.bvh", "--length", "fast"],
    ],
)
def test_help_and_wrong_usage_do_not_wait_for_numpy(arguments) -> None:
    assert not modules_after(*arguments) & HEAVY


def test_info_needs_neither_the_search_nor_scipy(clips) -> None:
    loaded = modules_after("info", str(clips.bvh))
    assert "numpy" in loaded
    assert not loaded & {"scipy", "matplotlib", "retime.search.guided", "retime.search.path"}


def test_version(run) -> None:
    assert run("--version").stdout == f"retime, version {importlib.metadata.version('retime')}\n"


def test_every_option_has_one_line_of_help() -> None:
    with click.Context(main) as context:
        for name in COMMANDS:
            command = main.get_command(context, name)
            assert command is not None
            for parameter in command.params:
                if isinstance(parameter, click.Option):
                    assert parameter.help, (name, parameter.name)
                    assert "\n" not in parameter.help


def test_every_option_is_tried_somewhere_here() -> None:
    tried = " ".join(path.read_text("utf-8") for path in Path(__file__).parent.glob("test_*.py"))
    with click.Context(main) as context:
        for name in COMMANDS:
            command = main.get_command(context, name)
            assert command is not None
            for parameter in command.params:
                if isinstance(parameter, click.Option):
                    assert any(f'"{flag}"' in tried for flag in parameter.opts), (name, parameter.opts)


def test_the_exit_codes_are_documented(run) -> None:
    text = run("--help").stdout
    codes = re.findall(r"^    (\d+) ", text[text.index("Exit codes") :], flags=re.MULTILINE)
    assert codes == ["0", "1", "2", "3", "4", "5", "130"]


def test_no_command_and_an_unknown_one(run) -> None:
    assert run().stdout == run("--help").stdout
    assert run("wrap", code=2).stderr.startswith("error: No such command 'wrap'")


# What a stranger's file may be: its name, its bytes, and what the error says.
BROKEN = {
    "empty": ("x.bvh", b"", "empty"),
    "a picture": ("x.bvh", b"\x89PNG\r\n\x1a\n" + bytes(64), "PNG"),
    "not text": ("x.bvh", bytes(range(256)) * 4, "x.bvh"),
    "cut in the hierarchy": ("x.bvh", b"HIERARCHY\nROOT Hips\n{\n\tOFFSET 0 0 0\n", "x.bvh:"),
    "a nan": ("x.csv", b"a,b\n1,2\nnan,4\n5,6\n", "x.csv:3"),
    "ragged": ("x.csv", b"a,b\n1,2\n3\n", "x.csv:3"),
    "no array": ("x.npy", b"\x93NUMPY", "x.npy"),
    "an amc alone": ("x.amc", b":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\n", "skeleton"),
    "an unknown ending": ("x.doc", b"hello", "known endings"),
}


@pytest.mark.parametrize("kind", BROKEN)
@pytest.mark.parametrize("arguments", [["info"], ["warp", "--length", "65%"]])
def test_a_broken_file_is_an_error_with_its_place(run, tmp_path, kind, arguments) -> None:
    name, data, says = BROKEN[kind]
    (tmp_path / name).write_bytes(data)
    result = run(*arguments, name, code=1)
    errors = [line for line in result.stderr.splitlines() if line.startswith("error: ")]
    assert len(errors) == 1
    assert errors[0].startswith(f"error: {name}")
    assert says in result.stderr
    assert result.stdout == ""


def test_a_broken_file_in_a_real_process(command, tmp_path) -> None:
    (tmp_path / "x.bvh").write_bytes(b"")
    done = command("warp", "x.bvh", "--length", "65%", "--json")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("error: x.bvh")
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("arguments", [["info"], ["warp", "--length", "65%"], ["convert", "out.bvh"]])
def test_a_missing_file(run, arguments) -> None:
    name, *rest = arguments
    result = run(name, "none.bvh", *rest, code=1)
    assert result.stderr == "error: none.bvh: No such file or directory\n"


def test_a_folder_is_no_clip(run, tmp_path) -> None:
    (tmp_path / "folder.bvh").mkdir()
    assert "folder.bvh: this is a folder" in run("info", "folder.bvh", code=1).stderr


@pytest.mark.parametrize(
    ("problem", "code", "says"),
    [
        (KeyboardInterrupt(), 130, ""),
        (MemoryError("Unable to allocate 9 TiB"), 1, "not enough memory (Unable to allocate 9 TiB)"),
        (OSError(errno.EIO, "Input/output error", "clip.bvh"), 1, "error: clip.bvh: Input/output error"),
    ],
)
def test_what_stops_the_work_is_told_in_a_line(run, clips, monkeypatch, problem, code, says) -> None:
    def stop(*args: object, **options: object) -> None:
        raise problem

    monkeypatch.setattr(registry, "read_with", stop)
    result = run("info", clips.bvh, code=code)
    assert says in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_warning_is_shown_once_and_not_as_python_shows_it(run, clips, monkeypatch) -> None:
    read = registry.read_with

    def twice(path: Path, *options: object, **up: object) -> object:
        for _ in range(2):
            warnings.warn("the T-pose was kept", FormatWarning, stacklevel=1)
        warnings.warn("something \x1b[31melse", RetimeWarning, stacklevel=1)
        return read(path, *options, **up)

    monkeypatch.setattr(registry, "read_with", twice)
    result = run("info", clips.bvh)
    assert result.stderr == "warning: the T-pose was kept\nwarning: something \\x1b[31melse\n"


def test_a_warning_of_another_library_is_left_to_python(run, clips, monkeypatch) -> None:
    def warn(*args: object, **options: object) -> None:
        warnings.warn("division", RuntimeWarning, stacklevel=1)

    monkeypatch.setattr(registry, "read_with", warn)
    with pytest.raises(AssertionError, match="division"):
        run("info", clips.bvh)


def test_names_that_the_terminal_can_not_write(command, clips, tmp_path) -> None:
    (tmp_path / "跳.bvh").write_bytes(clips.bvh.read_bytes())
    done = command("info", "跳.bvh", env={**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"})
    assert (done.returncode, done.stderr) == (0, "")
    assert r"\u8df3.bvh" in done.stdout


def test_it_is_silent_in_a_pipe(command, clips, tmp_path) -> None:
    done = command("warp", clips.bvh, *QUICK, "--json")
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["output"] == "out.bvh"


def test_a_broken_pipe_ends_quietly_with_the_work_done(clips, tmp_path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    arguments = ["warp", str(clips.bvh), *QUICK]
    done = subprocess.run([*COMMAND, *arguments], stdout=writer, stderr=subprocess.PIPE, cwd=tmp_path, check=False)
    os.close(writer)
    assert (done.returncode, done.stderr) == (1, b"")
    assert (tmp_path / "out.bvh").stat().st_size > 1000


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
def test_a_full_disk_behind_standard_output(command, clips) -> None:
    with Path("/dev/full").open("w") as full:
        done = command("info", clips.bvh, stdout=full)
    assert (done.returncode, done.stderr) == (1, "error: No space left on device\n")


class Terminal:
    """Run a command with a terminal as its standard error."""

    def __init__(self, *arguments: str, folder: Path, **environment: str) -> None:
        self._master, slave = pty.openpty()
        self.process = subprocess.Popen(
            [*COMMAND, *arguments],
            stdout=subprocess.PIPE,
            stderr=slave,
            cwd=folder,
            env={**os.environ, "TERM": "xterm", **environment},
        )
        os.close(slave)
        self.shown = ""

    def wait_for(self, text: str) -> None:
        """Read what is shown until `text` is there."""
        while text not in self.shown:
            piece = self._read()
            assert piece, f"{text!r} was not shown; {self.shown!r} was"

    def rest(self) -> str:
        """Read to the end, and wait for the command."""
        while self._read():
            pass
        assert self.process.stdout is not None
        self.stdout = self.process.stdout.read().decode()
        self.process.stdout.close()
        self.process.wait(timeout=60)
        os.close(self._master)
        return self.shown

    def _read(self) -> str:
        try:
            piece = os.read(self._master, 4096).decode()
        except OSError:
            # Linux says EIO where the other end of a terminal is closed.
            piece = ""
        self.shown += piece
        return piece


def test_a_terminal_sees_the_stage_at_work(clips, tmp_path) -> None:
    terminal = Terminal("warp", str(clips.bvh), *QUICK, folder=tmp_path)
    shown = terminal.rest()
    assert terminal.process.returncode == 0
    for stage in ("reading 0 s", "searching 0 s", "resampling 0 s", "writing 0 s"):
        assert stage in shown
    # Nothing is left on the line.
    assert re.search(r"\r +\r$", shown)
    assert terminal.stdout.startswith("input")


@pytest.mark.parametrize(("arguments", "environment"), [(["-q"], {}), ([], {"TERM": "dumb"})])
def test_a_terminal_can_be_kept_quiet(clips, tmp_path, arguments, environment) -> None:
    terminal = Terminal("warp", str(clips.bvh), *QUICK, *arguments, folder=tmp_path, **environment)
    assert terminal.rest() == ""
    assert terminal.process.returncode == 0


def test_ctrl_c_ends_quietly_and_leaves_nothing_behind(clips, tmp_path) -> None:
    # A search that would take minutes.
    long_work = ("--rate", "240", "--upsample", "8", "--max-skip", "60", "--length", "90%", "-o", "out.bvh")
    terminal = Terminal("warp", str(clips.bvh), *long_work, folder=tmp_path, RETIME_BACKEND="numpy")
    terminal.wait_for("searching 1 s")
    terminal.process.send_signal(signal.SIGINT)
    shown = terminal.rest()
    # Where the signal meets Python in the middle of an import, it ends itself by that signal: 130 to a shell, too.
    assert terminal.process.returncode in (130, -signal.SIGINT)
    assert "Traceback" not in shown
    assert "error" not in shown
    assert terminal.stdout == ""
    assert list(tmp_path.iterdir()) == []
