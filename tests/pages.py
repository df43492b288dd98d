"""The pages of docs/ as a reader follows them: each command typed, each example run, what comes compared with the page.

Of Python itself alone, so that `tests/tutorial_alone.py` can use it where nothing but retime is installed.
"""

from __future__ import annotations

import doctest
import shlex
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


@dataclass(frozen=True)
class Command:
    """A command of a page.

    Attributes
    ----------
    line : int
        Where it stands.
    text : str
        What is typed.
    shown : str
        What the page shows below it; "" for nothing, which is then not compared.
    """

    line: int
    text: str
    shown: str


def commands_of(page: str) -> list[Command]:
    """Collect the commands of a page's console blocks: lines that begin with "$ ", each with what is shown below."""
    found: list[Command] = []
    inside = False
    for number, line in enumerate(page.splitlines(), start=1):
        if line.startswith("```"):
            inside = line.strip() == "```console"
        elif inside and line.startswith("$ "):
            found.append(Command(number, line[2:], ""))
        elif inside and found:
            last = found.pop()
            found.append(Command(last.line, last.text, f"{last.shown}{line}\n"))
    return found


def follow(path: Path, retime: Callable[[list[str]], tuple[int, str]], folder: Path) -> int:
    """Type the commands of a page, in a folder; raise AssertionError where one ends, or says, otherwise than shown.

    Parameters
    ----------
    path : Path
        The page.
    retime : callable
        Calls retime with some arguments; returns its exit code and what it says.
    folder : Path
        Where all of it happens; the working folder.

    Returns
    -------
    int
        How many there were.
    """
    checker = doctest.OutputChecker()
    commands = commands_of(path.read_text(encoding="utf-8"))
    for one in commands:
        words = shlex.split(one.text)
        where = f"{path.name}:{one.line}: {one.text}"
        if words[0] == "printf":
            # Shells differ; a text with line ends, sent to a file.
            assert len(words) == 4, where
            assert words[2] == ">", where
            (folder / words[3]).write_text(words[1].replace("\\n", "\n"), encoding="utf-8")
            continue
        if words[0] == "python":
            done = subprocess.run([sys.executable, *words[1:]], cwd=folder, capture_output=True, text=True, check=False)
            code, said = done.returncode, done.stdout + done.stderr
        else:
            assert words[0] == "retime", where
            code, said = retime(words[1:])
        expected = 2 if one.shown.startswith("error:") else 0
        assert code == expected, f"{where}\nended with {code}\n{said}"
        if one.shown:
            assert checker.check_output(one.shown, said, FLAGS), (
                f"{where}\nthe page shows\n{one.shown}\nit says\n{said}"
            )
    return len(commands)


def run_examples(path: Path) -> int:
    """Run the examples in Python of a page; raise AssertionError where one gives something else. Return how many."""
    result = doctest.testfile(str(path), module_relative=False, optionflags=FLAGS)
    assert result.failed == 0, f"{path.name}: {result.failed} of {result.attempted} examples fail"
    return result.attempted
